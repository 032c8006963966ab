//! Amplification matrices of time integrators, column by column from steps of an oscillator, against closed forms.
//!
//! The oscillator is one cell of a linear law, fixed at its left side: stiffness E, mass 1/3, so that `omega` = 1 and `dt` is
//! `Omega = omega dt`. States are constructed: positions, velocities, and history vectors.
//!
//! Closed forms: Hughes (The Finite Element Method, 1987, section 9), Hilber, Hughes and Taylor (1977), Wood, Bossak and Zienkiewicz
//! (1980), Chung and Hulbert (1993), the scalar equations of the energy-decaying scheme, and for the differentiation formulas the
//! characteristic polynomial and the stability function at `i Omega` (Hairer and Wanner, Solving Ordinary Differential Equations II, 1996;
//! Bank et al. 1985).

use conserva::dynamics::{Model, Options, Simulation, State};
use conserva::integrators::{
    BACKWARD_EULER, BDF2, ENERGY_MOMENTUM, MEAN_VALUE, MIDPOINT, Scheme, TR_BDF2, TRAPEZOIDAL, TRIPLE_JUMP, energy_decaying,
    generalized_alpha, hht, newmark, wbz,
};
use conserva::materials::{LINEAR, Material};
use conserva::mesh::rectangle;
use nalgebra::{Complex, DMatrix, Matrix3, SMatrix};
use serde_json::Value;

/// Size of the states, well within the cell.
const SIZE: f64 = 0.01;
/// Steps per radian: `Omega` from 1e-2 to 1e4.
const STEPS: [f64; 13] = [0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 10000.0];

fn oscillator(scheme: &Scheme, dt: f64) -> Simulation {
    let law = Material::new(&LINEAR[0], &[1.0 / 3.0, 0.0, 1.0]).expect("in range");
    let mut model = Model::new("oscillator");
    let body = model.add_body("cell", rectangle([1.0, 1.0], [1, 1], [0.0; 2]).expect("the mesh is sound"), &law);
    model.fix(model.boundary(body, "left").expect("it is there"), [true, true, false]);
    model.fix(model.boundary(body, "right").expect("it is there"), [false, true, false]);
    Simulation::new(&model, Options::new(scheme, dt)).expect("the model is sound")
}

/// Simulation whose state is set component by component; `memory` overwrites the history vectors.
struct Hand {
    sim: Simulation,
    /// Unknowns of the moving side.
    moving: Vec<usize>,
    unknowns: usize,
    start: Value,
}

impl Hand {
    fn new(scheme: &Scheme, dt: f64) -> Hand {
        let mut sim = oscillator(scheme, dt);
        let state = sim.state();
        let moving = (0..state.positions.len()).step_by(2).filter(|&k| state.positions[k] > 0.5).collect();
        let data = |sim: &Simulation| serde_json::to_value(sim.state()).expect("a state is data");
        let mut start = data(&sim);
        // History vectors exist after a step.
        sim.step(None, &mut |_| ()).expect("the step converges");
        (start["remembered"], start["row"]["step"]) = (data(&sim)["remembered"].take(), 1.into());
        Hand { sim, moving, unknowns: state.positions.len(), start }
    }

    fn vector(&self, value: f64) -> Value {
        let numbers = (0..self.unknowns).map(|k| if self.moving.contains(&k) { value } else { 0.0 });
        numbers.collect::<Vec<f64>>().into()
    }

    /// State after a step from given values; `memory` has acceleration, force remainder and the delayed force, as far as the scheme has
    /// them.
    fn after(&mut self, [x, v]: [f64; 2], memory: Option<[f64; 3]>) -> Value {
        let mut state = self.start.clone();
        let (u, v) = (self.vector(x), self.vector(v));
        for (k, position) in state["positions"].as_array_mut().expect("numbers").iter_mut().enumerate() {
            let rest = if self.moving.contains(&k) { 1.0 } else { position.as_f64().expect("a number") };
            *position = (rest + u[k].as_f64().expect("a number")).into();
        }
        (state["displacements"], state["velocities"]) = (u, v);
        // Newton's method scales energies by that of the state.
        state["row"]["kinetic"] = (SIZE * SIZE).into();
        match memory {
            None => state["row"]["step"] = 0.into(),
            Some([acceleration, left, answered]) => {
                for (path, value) in [("/acceleration", acceleration), ("/force/left", left), ("/force/answered", answered)] {
                    let value = self.vector(value);
                    let slot = state["remembered"].pointer_mut(path).expect("it remembers that");
                    if slot.as_array().is_some_and(|numbers| !numbers.is_empty()) {
                        *slot = value;
                    }
                }
            }
        }
        let state: State = serde_json::from_value(state).expect("it is a state");
        self.sim.restore(&state);
        self.sim.step(None, &mut |_| ()).expect("the step converges");
        serde_json::to_value(self.sim.state()).expect("a state is data")
    }

    fn number(&self, state: &Value, path: &str) -> f64 {
        state.pointer(path).and_then(|vector| vector[self.moving[0]].as_f64()).unwrap_or(0.0)
    }
}

/// Forces at the two nodes are half of the stiffness each, and masses half of the mass; in units of `omega` = 1 both are 1/6.
const HALF: f64 = 1.0 / 6.0;

/// Amplification matrix of `[x, v]` for schemes whose history vectors follow from these.
fn two(scheme: &Scheme, dt: f64) -> DMatrix<f64> {
    let mut hand = Hand::new(scheme, dt);
    DMatrix::from_columns(&[[SIZE, 0.0], [0.0, SIZE]].map(|state| {
        let end = hand.after(state, None);
        nalgebra::DVector::from_vec(["/displacements", "/velocities"].map(|path| hand.number(&end, path) / SIZE).to_vec())
    }))
}

/// Amplification matrix of `[x, v, a]` for a scheme with an acceleration and its delayed force as history.
fn three(scheme: &Scheme, dt: f64) -> DMatrix<f64> {
    let mut hand = Hand::new(scheme, dt);
    let lag = scheme.lag;
    // Of a displacement, and of an acceleration.
    let memories = [[0.0, lag.force * HALF * SIZE, 0.0], [0.0; 3], [SIZE, -lag.inertia * HALF * SIZE, -HALF * SIZE]];
    let states = [[SIZE, 0.0], [0.0, SIZE], [0.0; 2]];
    DMatrix::from_columns(&[0, 1, 2].map(|k: usize| {
        let end = hand.after(states[k], Some(memories[k]));
        let paths = ["/displacements", "/velocities", "/remembered/acceleration"];
        nalgebra::DVector::from_vec(paths.map(|path| hand.number(&end, path) / SIZE).to_vec())
    }))
}

/// Amplification matrix of `[x, v, a, m]` for a scheme with an independent force remainder `m`.
fn four(scheme: &Scheme, dt: f64) -> DMatrix<f64> {
    let mut hand = Hand::new(scheme, dt);
    DMatrix::from_columns(&[0, 1, 2, 3].map(|k: usize| {
        let of = |one: usize, size: f64| if k == one { size } else { 0.0 };
        let end = hand.after([of(0, SIZE), of(1, SIZE)], Some([of(2, SIZE), of(3, HALF * SIZE), 0.0]));
        let at = ["/displacements", "/velocities", "/remembered/acceleration"].map(|path| hand.number(&end, path) / SIZE);
        nalgebra::DVector::from_vec(vec![at[0], at[1], at[2], hand.number(&end, "/remembered/force/left") / (HALF * SIZE)])
    }))
}

/// Published amplification matrix of the alpha methods, from the three equations of Newmark's method with inertia and forces between the
/// ends of a step.
fn published(alpha: [f64; 2], beta: f64, gamma: f64, dt: f64) -> DMatrix<f64> {
    let [alpha_m, alpha_f] = alpha;
    #[rustfmt::skip]
    let left = Matrix3::new(
        1.0, 0.0, -beta * dt * dt,
        0.0, 1.0, -gamma * dt,
        1.0 - alpha_f, 0.0, 1.0 - alpha_m,
    );
    #[rustfmt::skip]
    let right = Matrix3::new(
        1.0, dt, (0.5 - beta) * dt * dt,
        0.0, 1.0, (1.0 - gamma) * dt,
        -alpha_f, 0.0, -alpha_m,
    );
    let matrix: SMatrix<f64, 3, 3> = left.lu().solve(&right).expect("it is regular");
    DMatrix::from_iterator(3, 3, matrix.iter().copied())
}

/// Matrix in units in which all entries have the same size: `x`, `v dt`, `a dt^2`, and forces as accelerations.
fn scaled(matrix: &DMatrix<f64>, dt: f64) -> DMatrix<f64> {
    let unit = |k: usize| dt.powi(k.min(2) as i32);
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * unit(i) / unit(j))
}

fn eigenvalues(matrix: &DMatrix<f64>) -> Vec<Complex<f64>> {
    matrix.clone().complex_eigenvalues().iter().copied().collect()
}

fn radius(values: &[Complex<f64>]) -> f64 {
    values.iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// Angle of the least damped complex pair of eigenvalues, over that of the exact solution.
fn turned(values: &[Complex<f64>], dt: f64) -> f64 {
    let turning = values.iter().filter(|value| value.im > 1e-12).max_by(|a, b| a.norm().total_cmp(&b.norm()));
    turning.map_or(f64::NAN, |value| value.arg() / dt)
}

fn compare(name: &str, dt: f64, computed: &DMatrix<f64>, exact: &[Complex<f64>], radius_within: f64) {
    let values = eigenvalues(&scaled(computed, dt));
    let (error, period) = (radius(&values) - radius(exact), turned(&values, dt) - turned(exact, dt));
    println!("{name} {dt}: radius {:.12} error {error:.1e}, period error {period:.1e}", radius(exact));
    assert!(error.abs() < radius_within, "{name}, Omega = {dt}: {} and {}", radius(&values), radius(exact));
    if dt <= 10.0 {
        assert!(period.abs() < 1e-8 || turned(exact, dt).is_nan(), "{name}, Omega = {dt}: period off by {period:e}");
    }
}

#[test]
fn rules_without_memory_have_the_closed_forms() {
    for dt in STEPS {
        let z = Complex::new(0.0, dt);
        let trapezoidal = (1.0 + 0.5 * z) / (1.0 - 0.5 * z);
        for scheme in [&ENERGY_MOMENTUM, &MEAN_VALUE, &MIDPOINT, &TRAPEZOIDAL] {
            compare(scheme.name, dt, &two(scheme, dt), &[trapezoidal, trapezoidal.conj()], 1e-10);
        }
        let of_share = |share: f64| (1.0 + 0.5 * share * z) / (1.0 - 0.5 * share * z);
        let outer = 1.0 / (2.0 - 2.0f64.cbrt());
        let jumped = of_share(outer).powi(2) * of_share(1.0 - 2.0 * outer);
        compare(TRIPLE_JUMP.name, dt, &two(&TRIPLE_JUMP, dt), &[jumped, jumped.conj()], 1e-10);
        let euler = 1.0 / (1.0 - z);
        compare(BACKWARD_EULER.name, dt, &two(&BACKWARD_EULER, dt), &[euler, euler.conj()], 1e-10);
        // Trapezoidal rule to `share`, differentiation formula from there.
        let share = 2.0 - 2.0f64.sqrt();
        let middle = (1.0 + 0.5 * share * z) / (1.0 - 0.5 * share * z);
        let end = (middle - (1.0 - share).powi(2)) / (share * (2.0 - share)) / (1.0 - (1.0 - share) / (2.0 - share) * z);
        compare(TR_BDF2.name, dt, &two(&TR_BDF2, dt), &[end, end.conj()], 1e-10);
        // 3/2 y_1 - 2 y_0 + 1/2 y_b = z y_1.
        let lead = Complex::new(1.5, 0.0) - z;
        let root = (4.0 - 2.0 * lead).sqrt();
        let roots = [(2.0 + root) / (2.0 * lead), (2.0 - root) / (2.0 * lead)];
        compare(BDF2.name, dt, &four(&BDF2, dt), &[roots[0], roots[1], roots[0].conj(), roots[1].conj()], 1e-10);
    }
}

#[test]
fn the_alpha_methods_have_the_matrices_of_their_authors() {
    let all = |rho: f64| ([(2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)], generalized_alpha(rho));
    let hilber = [-0.05, -0.2, -1.0 / 3.0].map(|alpha: f64| ([0.0, -alpha], hht(alpha)));
    let wood = [-0.1, -0.5].map(|alpha: f64| ([alpha, 0.0], wbz(alpha)));
    for ([alpha_m, alpha_f], scheme) in hilber.into_iter().chain(wood).chain([0.0, 0.5, 0.8, 1.0].map(all)) {
        let (gamma, beta) = (0.5 - alpha_m + alpha_f, 0.25 * (1.0 - alpha_m + alpha_f).powi(2));
        for dt in STEPS {
            let (computed, exact) = (three(&scheme, dt), published([alpha_m, alpha_f], beta, gamma, dt));
            let (computed, exact) = (scaled(&computed, dt), scaled(&exact, dt));
            let off = (&computed - &exact).amax() / exact.amax();
            println!("{} {dt}: matrix off by {off:.1e}", scheme.describe());
            assert!(off < 1e-11, "{}, Omega = {dt}: {computed} {exact}", scheme.describe());
            // For long steps the three eigenvalues coincide, and round-off of 1e-16 in a matrix is 1e-6 in them.
            let within = if dt <= 100.0 { 1e-10 } else { 1e-5 };
            let (values, expected) = (eigenvalues(&computed), eigenvalues(&exact));
            assert!((radius(&values) - radius(&expected)).abs() < within, "{}, Omega = {dt}", scheme.describe());
            assert!(dt > 10.0 || (turned(&values, dt) - turned(&expected, dt)).abs() < 1e-8, "{}, Omega = {dt}", scheme.describe());
        }
        // In the limit of infinite steps.
        let rho = radius(&eigenvalues(&scaled(&published([alpha_m, alpha_f], beta, gamma, 1e8), 1e8)));
        let told = match scheme.name {
            "generalized_alpha" => scheme.parameters.values[0],
            "hht" => ((1.0 - alpha_f) / (1.0 + alpha_f)).max(alpha_f / (1.0 - alpha_f)),
            _ => (1.0 + alpha_m) / (1.0 - alpha_m),
        };
        assert!((rho - told).abs() < 1e-4, "{}: {rho} and {told}", scheme.describe());
    }
}

/// Amplification matrix of the energy-decaying scheme: `v - v_0 + dt ((q_0 + q)/2 + chi/2 (q - q_0)) = 0`, `q - q_0 = dt (v_0 + v)/2`, and
/// the filter of `v`.
fn decaying(rho: f64, dt: f64) -> DMatrix<f64> {
    let chi = (1.0 - rho) / (1.0 + rho);
    let left = nalgebra::Matrix2::new(0.5 * dt * (1.0 + chi), 1.0, 1.0, -0.5 * dt);
    let right = nalgebra::Matrix2::new(-0.5 * dt * (1.0 - chi), 1.0, 1.0, 0.5 * dt);
    let lost = 0.25 * dt * dt / (1.0 + 0.25 * dt * dt);
    let filter = nalgebra::Matrix2::new(1.0, 0.0, 0.0, 1.0 - (1.0 - rho) * lost * lost);
    let matrix = filter * left.lu().solve(&right).expect("it is regular");
    DMatrix::from_iterator(2, 2, matrix.iter().copied())
}

#[test]
fn the_energy_decaying_scheme_has_the_spectral_radius_that_was_given() {
    for rho in [0.0, 0.3, 0.8, 1.0] {
        let scheme = energy_decaying(rho);
        let mut before = 1.0 + 1e-12;
        for dt in STEPS {
            let (computed, exact) = (scaled(&two(&scheme, dt), dt), scaled(&decaying(rho, dt), dt));
            // Relative to the amplitude before the step, because that after it may vanish.
            let off = (&computed - &exact).amax() / exact.amax().max(1.0);
            // Two eigenvalues coincide for long steps.
            let radius = radius(&eigenvalues(&computed));
            println!("{} {dt}: matrix off by {off:.1e}, radius {radius:.9}", scheme.describe());
            assert!(off < 1e-11, "{}, Omega = {dt}: {computed} {exact}", scheme.describe());
            assert!(radius < before + 1e-6, "{}, Omega = {dt}: {radius} after {before}", scheme.describe());
            before = radius;
        }
        assert!((before - rho).abs() < 1e-3, "{}: {before}", scheme.describe());
    }
}

#[test]
fn newmark_has_the_closed_forms() {
    for [beta, gamma] in [[0.25, 0.5], [0.3025, 0.6], [0.5, 1.0], [1.0 / 6.0, 0.5]] {
        for dt in STEPS.into_iter().filter(|dt| beta > 0.2 || *dt < 3.0) {
            // Hughes (1987), 9.1: trace and determinant.
            let d = 1.0 + beta * dt * dt;
            let (trace, determinant) = (2.0 - dt * dt * (gamma + 0.5) / d, 1.0 - dt * dt * (gamma - 0.5) / d);
            let root = Complex::new(0.25 * trace * trace - determinant, 0.0).sqrt();
            let scheme = newmark(beta, gamma);
            compare(&scheme.describe(), dt, &two(&scheme, dt), &[0.5 * trace + root, 0.5 * trace - root], 1e-10);
        }
    }
}

/// Leading error that adaptive steps use: amplitude and phase of a slow vibration in a step.
#[test]
fn slow_vibrations_are_off_by_the_leading_error() {
    let dt = 0.02f64;
    let check = |scheme: &Scheme, matrix: &DMatrix<f64>| {
        let exact = Complex::new(0.0, dt).exp();
        let values = eigenvalues(&scaled(matrix, dt));
        let nearest = values.iter().min_by(|a, b| (*a - exact).norm().total_cmp(&(*b - exact).norm())).expect("there are some");
        let off = nearest.ln() - Complex::new(0.0, dt);
        let (first, second) = (off.re.abs() / dt.powi(2), off.im.abs() / dt.powi(3));
        println!("{}: {first:.4} {second:.4}, row {:?}", scheme.describe(), scheme.error);
        assert!((first - scheme.error.first).abs() < 0.01, "{}: {first}", scheme.describe());
        assert!((second - scheme.error.second).abs() < 0.01, "{}: {second}", scheme.describe());
    };
    for scheme in [&ENERGY_MOMENTUM, &MIDPOINT, &TRAPEZOIDAL, &BACKWARD_EULER, &TR_BDF2] {
        check(scheme, &two(scheme, dt));
    }
    for scheme in [energy_decaying(0.0), energy_decaying(0.3), energy_decaying(0.8), energy_decaying(1.0)] {
        check(&scheme, &two(&scheme, dt));
    }
    check(&BDF2, &four(&BDF2, dt));
    for scheme in [newmark(0.25, 0.5), newmark(0.3025, 0.6), newmark(0.5, 1.0), newmark(1.0 / 6.0, 0.5)] {
        check(&scheme, &two(&scheme, dt));
    }
    for scheme in [hht(-0.1), hht(-1.0 / 3.0), wbz(-0.5), generalized_alpha(0.0), generalized_alpha(0.8), generalized_alpha(1.0)] {
        check(&scheme, &three(&scheme, dt));
    }
}
