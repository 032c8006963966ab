//! Contract of the element loop for every cell kind, material and integrator, on random states of a distorted mesh: exact tangent;
//! directionality and orthogonality of the discrete gradient to round-off; objectivity.

use conserva::bodies::{BodyCells, BodyState, Dilatation, ElementLoop, Elements, Formulation, Plane, Space, Step};
use conserva::elements::CellKind;
use conserva::integrators::{BACKWARD_EULER, Derivative, ENERGY_MOMENTUM, MEAN_VALUE, MIDPOINT, Scheme, TRAPEZOIDAL};
use conserva::linear::{NodeMatrix, Pattern, Vertex};
use conserva::materials::{CATALOGUE, Kinematics, Material, MaterialRow, NeoHookean, StoredEnergy};
use conserva::math::workers::Workers;
use conserva::mesh::{Change, Mesh, block, rectangle};

use crate::common::{Random, difference};

/// Every law of the catalogue, and an energy as text.
fn materials() -> Vec<Material> {
    let example = |row| Material::new(row, &MaterialRow::example(row, MODULUS, 1.0)).expect("the values are in their ranges");
    let mut all: Vec<Material> = CATALOGUE.iter().map(example).collect();
    let constants = [("mu", 0.4 * MODULUS), ("k", 0.8 * MODULUS)];
    let energy = StoredEnergy::new("mu/2*(exp((I1bar - 3)/4) - 1)*4", Some("k/4*(J^2 - 1 - 2*ln(J))"), &constants).expect("an energy");
    all.push(Material::hyperelastic(energy, 1.0).expect("a material"));
    all
}

const MODULUS: f64 = 1000.0;

/// Law whose stiffness jumps when its fibers begin to pull.
const FIBERS: &str = "holzapfel_gasser_ogden";

/// Mesh of about ten cells (more than one batch, the last one not full) with nodes at unit distance, all moved at random.
fn distorted(kind: CellKind) -> Mesh {
    let mesh = match kind.dimension() {
        2 if kind.is_quadratic() => rectangle([10.0, 4.0], [5, 2], [0.3, -0.2]),
        2 => rectangle([5.0, 2.0], [5, 2], [0.3, -0.2]),
        _ => {
            // A block becomes one hexahedron, two wedges, or six tetrahedra or pyramids.
            let is_split_in_six = matches!(kind, CellKind::Tet4 | CellKind::Tet10 | CellKind::Pyr5 | CellKind::Pyr13);
            let counts = if is_split_in_six { [2, 1, 1] } else { [3, 3, 1] };
            let size = if kind.is_quadratic() { 4.0 } else { 1.0 };
            block(counts.map(|count| size * count as f64), counts, [0.3, -0.2, 0.1])
        }
    };
    moved_at_random(mesh.and_then(|mesh| mesh.with_cells(kind)).expect("the mesh is sound"))
}

fn moved_at_random(mut mesh: Mesh) -> Mesh {
    let (mut random, dimension) = (Random(3), mesh.dimension());
    for point in &mut mesh.points {
        for x in &mut point[..dimension] {
            *x += 0.15 * random.next();
        }
    }
    mesh
}

/// Distorted meshes of several cell kinds: quadrilaterals with triangles, and their extrusions; hexahedra, pyramids and tetrahedra.
fn mixed() -> Vec<Mesh> {
    let plate = |x: f64, kind| rectangle([3.0, 2.0], [3, 2], [x, -0.2]).and_then(|mesh| mesh.with_cells(kind)).expect("a mesh");
    let plane = plate(0.3, CellKind::Quad4).joined(&plate(3.3, CellKind::Tri3)).expect("they match");
    let solid = plane.extruded(1.0, 1, 1.0, Change::NONE).expect("a solid");
    let cube = block([1.0; 3], [1; 3], [0.0; 3]).expect("a mesh");
    let top = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.5, 0.5, 2.0]];
    let pyramid = Mesh::new(CellKind::Pyr5, top.to_vec(), vec![0, 1, 2, 3, 4]);
    let tetrahedron = Mesh::new(CellKind::Tet4, vec![top[0], top[1], top[4], [0.5, -1.0, 1.5]], vec![0, 1, 2, 3]);
    let chain = cube.joined(&pyramid).and_then(|mesh| mesh.joined(&tetrahedron)).expect("they match");
    let finer = |mesh: &Mesh, kind| {
        let mut mesh = mesh.with_cells(kind).expect("cells of second order");
        mesh.points.iter_mut().flatten().for_each(|x| *x *= 4.0);
        mesh
    };
    let second_order = [finer(&plane, CellKind::Quad8), finer(&solid, CellKind::Hex20), finer(&chain, CellKind::Hex20)];
    [plane, solid, chain].into_iter().chain(second_order).map(moved_at_random).collect()
}

/// Distorted meshes of every cell kind and of several.
fn meshes() -> Vec<Mesh> {
    CellKind::ALL.iter().map(|&kind| distorted(kind)).chain(mixed()).collect()
}

struct Loop<const D: usize> {
    elements: Box<dyn ElementLoop<D>>,
    pattern: Pattern,
    nodes: usize,
    reference: Vec<f64>,
    /// Center of the random states: the undeformed state, or a state in which one family of fibers clearly pulls and the other is clearly
    /// compressed, so that no difference quotient crosses the strain at which a fiber begins to pull.
    middle: Vec<f64>,
    /// Amplitude of the random displacements, relative to laws without fibers.
    spread: f64,
    /// True if rotations and translations along the first axis are rigid motions of the body.
    is_free: bool,
    /// Scale of forces: the modulus, in axisymmetric bodies times the largest circumference.
    scale: f64,
}

impl<const D: usize> Loop<D>
where
    Space<D>: Elements<D>,
{
    fn new(mesh: &Mesh, material: &Material, formulation: Formulation, integrator: &Scheme) -> Self {
        let cells = BodyCells { averages_stress: integrator.averages_stress, ..BodyCells::new(mesh, material, formulation) };
        let mut elements = Space::<D>::elements(&cells).expect("no cell is inside out");
        let nodes = mesh.points.len();
        let pattern = Pattern::new(&vec![Vertex::coordinates(D as u8); nodes], elements.cliques().iter().map(|clique| &clique[..]));
        elements.place(&pattern);
        let is_free = formulation.plane != Plane::Axisymmetric && material.kinematics() != Kinematics::Linear;
        let scale = if formulation.plane == Plane::Axisymmetric { 2.0 * std::f64::consts::PI * 10.0 * MODULUS } else { MODULUS };
        let reference: Vec<f64> = mesh.points.iter().flat_map(|point| point[..D].to_vec()).collect();
        let (mut middle, mut spread) = (reference.clone(), 1.0);
        if material.name() == FIBERS {
            // The families lie at angles of 0.6 to both sides of the first axis: a shear of 1/2 stretches one to 1.28 and the other to
            // 0.84.
            middle.chunks_exact_mut(D).for_each(|x| x[1] += 0.5 * x[0]);
            spread = 0.4;
        }
        Loop { elements, pattern, nodes, is_free, scale, reference, middle, spread }
    }

    /// The loop about the undeformed state, where fibers of both families pull at some points and are compressed at others.
    fn at_rest(self) -> Self {
        Loop { middle: self.reference.clone(), spread: 1.0, ..self }
    }

    fn random_state(&self, size: f64, random: &mut Random) -> Vec<f64> {
        self.middle.iter().map(|x| x + self.spread * size * random.next()).collect()
    }

    /// Displacements `q - X` of the nodes at positions `q`.
    fn displacements(&self, q: &[f64]) -> Vec<f64> {
        q.iter().zip(&self.reference).map(|(q, x)| q - x).collect()
    }

    fn strain_energy(&self, q: &[f64]) -> f64 {
        self.elements.strain_energy(BodyState { u: &self.displacements(q), history: &[] })
    }

    /// Force and values of the tangent of a step.
    fn assemble(&self, integrator: &'static Scheme, q_0: &[f64], q_1: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut values = vec![f64::NAN; self.pattern.values()];
        let force = self.force(integrator, q_0, q_1, Some(&mut values));
        (force, values)
    }

    /// Force of a step; the values of its tangent are written to `values`.
    fn force(&self, integrator: &'static Scheme, q_0: &[f64], q_1: &[f64], values: Option<&mut [f64]>) -> Vec<f64> {
        // Previous values must be overwritten.
        let mut force = vec![f64::NAN; q_1.len()];
        let (u_0, u_1) = (&self.displacements(q_0)[..], &self.displacements(q_1)[..]);
        let step = Step { derivative: integrator.derivative, weight: integrator.weight, inertia: 0.0, u_0, u_1, history: &[], dt: 0.0 };
        self.elements.assemble(&step, &mut force, values, &Workers::new(1)).expect("no cell turns inside out");
        force
    }

    /// Random direction of all unknowns, with components up to one.
    fn direction(&self, random: &mut Random) -> Vec<f64> {
        (0..D * self.nodes).map(|_| random.next()).collect()
    }
}

/// Number of random directions in which derivatives are compared with differences: each holds all unknowns, so that no wrong entry hides.
const DIRECTIONS: usize = 3;

/// Returns `q + h d`.
fn along(q: &[f64], direction: &[f64], h: f64) -> Vec<f64> {
    q.iter().zip(direction).map(|(q, d)| q + h * d).collect()
}

/// Formulations that a mesh and a material permit, with their names.
fn formulations(mesh: &Mesh, material: &Material) -> Vec<(Formulation, String)> {
    let planes = [Plane::Strain, Plane::Stress, Plane::Axisymmetric];
    let dilatations = [Dilatation::Pointwise, Dilatation::Mean, Dilatation::Linear];
    let all = planes.into_iter().flat_map(|plane| dilatations.map(|dilatation| Formulation { plane, dilatation }));
    all.filter(|formulation| formulation.check(mesh, material).is_ok())
        .map(|one| (one, format!("{:?} {:?}", one.plane, one.dilatation)))
        .collect()
}

/// Integrators with different force evaluations in the element loop.
const SEEN: [&Scheme; 5] = [&ENERGY_MOMENTUM, &MEAN_VALUE, &MIDPOINT, &TRAPEZOIDAL, &BACKWARD_EULER];

/// Calls a contract for every cell kind, material, formulation and integrator.
macro_rules! for_all {
    ($contract:ident) => {
        for material in materials() {
            for mesh in meshes() {
                for (formulation, how) in formulations(&mesh, &material) {
                    for integrator in SEEN {
                        let form = material.volumetric_form().map_or("", |form| form.name);
                        let name = format!("{} {} {form} {how} {}", mesh.kind_names(), material.name(), integrator.name);
                        match mesh.dimension() {
                            2 => $contract::<2>(Loop::new(&mesh, &material, formulation, integrator), integrator, &name),
                            _ => $contract::<3>(Loop::new(&mesh, &material, formulation, integrator), integrator, &name),
                        }
                    }
                }
            }
        }
    };
}

fn tangent<const D: usize>(cells: Loop<D>, integrator: &'static Scheme, name: &str)
where
    Space<D>: Elements<D>,
{
    let mut random = Random(5);
    for step in [0.02, 0.2] {
        let q_0 = cells.random_state(0.05, &mut random);
        let q_1: Vec<f64> = q_0.iter().map(|q| q + cells.spread * step * random.next() * 0.5).collect();
        let (_, values) = cells.assemble(integrator, &q_0, &q_1);
        let h = 2e-6;
        for _ in 0..DIRECTIONS {
            let direction = cells.direction(&mut random);
            let (above, below) = (along(&q_1, &direction, h), along(&q_1, &direction, -h));
            let (above, below) = (cells.force(integrator, &q_0, &above, None), cells.force(integrator, &q_0, &below, None));
            let differences: Vec<f64> = above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * h)).collect();
            let mut product = vec![0.0; q_1.len()];
            cells.pattern.multiply_into(&values, &direction, &mut product);
            let error = difference(&differences, &product) / cells.scale;
            // Truncation h^2 times third derivatives (some hundred moduli where the step is small, by the quotient of the discrete
            // gradient), round-off eps/h.
            assert!(error < 1e-6, "{name}: the tangent is off by {error:.1e} at step {step}");
        }
    }
}

#[test]
fn tangent_is_the_derivative_of_the_force() {
    for_all!(tangent);
}

/// The weight of the mass in a step adds that multiple of the mass matrix to the tangent.
fn inertia<const D: usize>(cells: Loop<D>, integrator: &'static Scheme, name: &str)
where
    Space<D>: Elements<D>,
{
    let q = cells.random_state(0.05, &mut Random(13));
    let (force, stiffness) = cells.assemble(integrator, &cells.reference, &q);
    let (mut same, mut values) = (vec![0.0; q.len()], vec![0.0; stiffness.len()]);
    let (u_0, u_1) = (&cells.displacements(&cells.reference)[..], &cells.displacements(&q)[..]);
    let step = Step { derivative: integrator.derivative, weight: integrator.weight, inertia: 400.0, u_0, u_1, history: &[], dt: 0.0 };
    cells.elements.assemble(&step, &mut same, Some(&mut values), &Workers::new(1)).expect("no cell turns inside out");
    assert_eq!(force, same, "{name}: the force is that of the strains alone");
    cells.elements.assemble(&step, &mut same, None, &Workers::new(1)).expect("no cell turns inside out");
    assert_eq!(force, same, "{name}: the force is the same without a tangent");
    let mut mass = NodeMatrix::new(&cells.pattern, cells.nodes);
    cells.elements.add_mass(&mut mass);
    for (row, column, mass) in mass.entries() {
        let block = cells.pattern.block(row, column);
        for i in 0..D {
            for k in 0..D {
                let (place, expected) = (block.at(i, k), if i == k { 400.0 * mass } else { 0.0 });
                // Round-off of sums of some thousands: stiffness and mass.
                assert!((values[place] - stiffness[place] - expected).abs() < 1e-14 * cells.scale * 10.0, "{name}: ({row}, {column})");
            }
        }
    }
}

#[test]
fn tangent_holds_the_weighted_mass() {
    for_all!(inertia);
}

/// Threads share the batches of a body, but the order of sums does not change.
#[test]
fn sums_do_not_depend_on_the_number_of_threads() {
    let plate = rectangle([6.0, 4.0], [60, 40], [0.0; 2]).expect("the mesh is sound");
    let beside = rectangle([6.0, 4.0], [60, 40], [6.0, 0.0]).and_then(|mesh| mesh.with_cells(CellKind::Tri3)).expect("a mesh");
    sums_are_the_same(&plate);
    sums_are_the_same(&plate.joined(&beside).expect("they match"));
}

fn sums_are_the_same(mesh: &Mesh) {
    let material = NeoHookean { youngs_modulus: MODULUS, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let cells = Loop::<2>::new(mesh, &material, Formulation::default(), &ENERGY_MOMENTUM);
    let mut random = Random(17);
    let (q_0, q_1) = (cells.random_state(0.01, &mut random), cells.random_state(0.01, &mut random));
    let (u_0, u_1) = (&cells.displacements(&q_0)[..], &cells.displacements(&q_1)[..]);
    let step = Step { derivative: Derivative::DiscreteGradient, weight: 1.0, inertia: 10.0, u_0, u_1, history: &[], dt: 0.0 };
    let assembled = [1, 2, 3].map(|threads| {
        let (mut force, mut values) = (vec![f64::NAN; q_1.len()], vec![f64::NAN; cells.pattern.values()]);
        cells.elements.assemble(&step, &mut force, Some(&mut values), &Workers::new(threads)).expect("no cell turns inside out");
        let mut alone = vec![f64::NAN; q_1.len()];
        cells.elements.assemble(&step, &mut alone, None, &Workers::new(threads)).expect("no cell turns inside out");
        assert_eq!(alone, force, "the force alone, {threads} threads");
        (force, values)
    });
    assert!(assembled[0] == assembled[1] && assembled[0] == assembled[2]);
    assert!(assembled[0].1.iter().all(|value| value.is_finite()));
    // For a translation every row of the tangent of the internal forces sums to zero, and with the mass to ten times the mass of its node.
    let (mut mass, along) = (NodeMatrix::new(&cells.pattern, cells.nodes), [1.0, 0.0].repeat(cells.nodes));
    cells.elements.add_mass(&mut mass);
    let mut sums = vec![0.0; q_1.len()];
    cells.pattern.multiply_into(&assembled[0].1, &along, &mut sums);
    for (node, (sums, mass)) in sums.chunks_exact(2).zip(mass.row_sums()).enumerate() {
        // Round-off of sums of stiffnesses, some thousands.
        assert!((sums[0] - 10.0 * mass).abs() < 1e-11 * MODULUS && sums[1].abs() < 1e-11 * MODULUS, "node {node}: {sums:?} {mass}");
    }
}

/// Sums of the nodal forces and of their moments about the origin.
fn resultants<const D: usize>(q: &[f64], force: &[f64]) -> ([f64; 3], [f64; 3]) {
    let vector = |x: &[f64]| nalgebra::Vector3::from_fn(|i, _| if i < D { x[i] } else { 0.0 });
    let (mut sum, mut moment) = (nalgebra::Vector3::zeros(), nalgebra::Vector3::zeros());
    for (q, f) in q.chunks_exact(D).zip(force.chunks_exact(D)) {
        sum += vector(f);
        moment += vector(q).cross(&vector(f));
    }
    (sum.into(), moment.into())
}

fn conservation<const D: usize>(cells: Loop<D>, integrator: &'static Scheme, name: &str)
where
    Space<D>: Elements<D>,
{
    // Fibers may begin to pull within a step: conservation does not depend on it.
    let (cells, mut random) = (cells.at_rest(), Random(7));
    for step in [1e-9, 1e-6, 1e-3, 0.2] {
        let q_0 = cells.random_state(0.1, &mut random);
        let q_1: Vec<f64> = q_0.iter().map(|q| q + step * random.next() * 0.5).collect();
        let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
        let force = cells.force(integrator, &q_0, &q_1, None);
        let size: f64 = force.iter().map(|f| f.abs()).sum();
        // Rigid motions of the configuration of the force do no work; 5 is the extent of the mesh.
        let arms = if integrator.derivative == Derivative::AT_END { &q_1 } else { &middle };
        let (sum, moment) = resultants::<D>(arms, &force);
        // The sum of forces along the axis of a body of revolution vanishes; a linear strain is not invariant under rotations.
        let first = if cells.is_free { 0 } else { 1 };
        assert!(difference(&sum[first..], &[0.0; 3][first..]) < 1e-15 * size, "{name}: the force has the resultant {sum:?} of {size}");
        assert!(!cells.is_free || difference(&moment, &[0.0; 3]) < 5e-15 * size, "{name}: the force has the moment {moment:?} of {size}");

        let work: f64 = force.iter().zip(q_0.iter().zip(&q_1)).map(|(f, (a, b))| f * (b - a)).sum();
        let [start, end] = [&q_0, &q_1].map(|q| cells.strain_energy(q));
        let defect = (work - (end - start)).abs();
        // Round-off of the energies that are subtracted, and of the increments `q_1 - q_0` that the force multiplies.
        let round_off = 1e-15 * (start * 10.0 + 10.0 * size);
        if integrator.promises.energy {
            assert!(defect < round_off, "{name}: {defect:.1e} of {round_off:.1e} at step {step}");
        } else {
            // Other integrators are not directional: the defect of a large step is far above round-off.
            assert!(step < 0.2 || defect > 1e6 * round_off, "{name}: only {defect:.1e} at step {step}");
        }
    }
}

#[test]
fn discrete_gradient_is_directional_and_orthogonal_to_rigid_motions() {
    for_all!(conservation);
}

/// At equal states every integrator's force is the gradient of the strain energy (half of it for the trapezoidal rule).
fn consistency<const D: usize>(cells: Loop<D>, integrator: &'static Scheme, name: &str)
where
    Space<D>: Elements<D>,
{
    let mut random = Random(9);
    let q = cells.random_state(0.1, &mut random);
    let force = cells.force(integrator, &q, &q, None);
    let h = 2e-5;
    for _ in 0..DIRECTIONS {
        let direction = cells.direction(&mut random);
        let (above, below) = (cells.strain_energy(&along(&q, &direction, h)), cells.strain_energy(&along(&q, &direction, -h)));
        let work: f64 = force.iter().zip(&direction).map(|(force, d)| force * d).sum();
        let error = (work - integrator.weight * (above - below) / (2.0 * h)).abs() / cells.scale;
        // Truncation h^2 times third derivatives of order ten, round-off 1e-16 of an energy of order 0.1 moduli over h.
        assert!(error < 1e-6, "{name}: the force is off by {error:.1e}");
    }
}

#[test]
fn force_at_equal_states_is_the_gradient_of_the_energy() {
    for_all!(consistency);
}

/// A rotation and translation of both states leaves the energy and turns the force.
fn objectivity<const D: usize>(cells: Loop<D>, integrator: &'static Scheme, name: &str)
where
    Space<D>: Elements<D>,
{
    if !cells.is_free {
        return;
    }
    let axis = if D == 2 { [0.0, 0.0, 2.3] } else { [1.1, -0.7, 1.9] };
    let rotation = nalgebra::Rotation3::new(nalgebra::Vector3::from(axis));
    let turn = |x: &[f64], shift: f64| -> Vec<f64> {
        x.chunks_exact(D)
            .flat_map(|x| {
                let turned = rotation * nalgebra::Vector3::from_fn(|i, _| if i < D { x[i] } else { 0.0 });
                turned.iter().take(D).map(|x| x + shift).collect::<Vec<f64>>()
            })
            .collect()
    };
    let mut random = Random(11);
    let (q_0, q_1) = (cells.random_state(0.1, &mut random), cells.random_state(0.1, &mut random));
    let force = cells.force(integrator, &q_0, &q_1, None);
    let turned = cells.force(integrator, &turn(&q_0, 7.0), &turn(&q_1, 7.0), None);
    let size = force.iter().fold(0.0f64, |size, f| size.max(f.abs()));
    // Round-off: displacements of order ten, strains of order 0.1.
    assert!(difference(&turn(&force, 0.0), &turned) < 1e-12 * size, "{name}: the force turns with the body");
    let (energy, same) = (cells.strain_energy(&q_1), cells.strain_energy(&turn(&q_1, 7.0)));
    assert!((energy - same).abs() < 1e-12 * energy, "{name}: the energy stays: {energy} {same}");
    // A rotated body stores no energy: strains of round-off, 1e-15, squared.
    assert!(cells.strain_energy(&turn(&cells.reference, 7.0)) < 1e-26 * MODULUS, "{name}");
}

#[test]
fn rigid_motions_leave_energy_and_turn_forces() {
    for_all!(objectivity);
}
