//! Contact patch test: two blocks with meshes that do not match, pressed together, carry one constant pressure.
//!
//! Taylor and Papadopoulos (1991); mortar methods pass it whatever the meshes (Puso and Laursen, CMAME 193, 2004). Closed forms: the
//! multiplier is the pressure per current length, so it is the dead traction times undeformed over deformed width; the stretch solves
//! `a E' (a^2 - 1)/2 = -t` with `E' = E/(1 - nu^2)` (Saint Venant-Kirchhoff, plane strain, free to widen).

use conserva::dynamics::{Constant, LoadKind, Simulation};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::rectangle;

use crate::common::Builder;

const TRACTION: f64 = 50.0;
const MODULUS: f64 = 1000.0;
/// Required accuracy. The solution has a relative error of 1e-14 in the displacements, and of about 1e-12 in the multiplier, by the
/// stiffness.
const TOLERANCE: f64 = 1e-10;

#[derive(Clone, Copy, Debug)]
struct Case {
    /// Numbers of cells of the lower and the upper block along the width.
    cells: [usize; 2],
    lower_is_secondary: bool,
    angle: f64,
    poisson: f64,
}

/// Two blocks of width 3 and heights 1 and 2, rotated together by an angle.
fn pressed(case: Case) -> Simulation {
    let stuff = SaintVenantKirchhoff { youngs_modulus: MODULUS, poisson_ratio: case.poisson, density: 1.0 }.material().expect("in range");
    let mut builder = Builder::default();
    let turned = |size: [f64; 2], cells: [usize; 2], bottom: f64| {
        rectangle(size, cells, [0.0, bottom]).and_then(|mesh| mesh.rotate(case.angle, [0.0; 3])).expect("the mesh is sound")
    };
    let lower = builder.body("lower", turned([3.0, 1.0], [case.cells[0], 2], 0.0), &stuff);
    let upper = builder.body("upper", turned([3.0, 2.0], [case.cells[1], 3], 1.0), &stuff);
    if case.angle == 0.0 {
        builder.fix(lower, "bottom", [false, true, false]);
        builder.fix(lower, "left", [true, false, false]);
        builder.fix(upper, "left", [true, false, false]);
    } else {
        // Supports act along the axes only; without Poisson's effect a fully fixed block has the same solution.
        assert_eq!(case.poisson, 0.0);
        builder.fix(lower, "bottom", [true; 3]);
    }
    let (s, c) = case.angle.sin_cos();
    builder.load(upper, "top", LoadKind::Traction([TRACTION * s, -TRACTION * c, 0.0]), Constant(1.0));
    let (secondary, primary) =
        if case.lower_is_secondary { ((lower, "top"), (upper, "bottom")) } else { ((upper, "bottom"), (lower, "top")) };
    builder.contact(secondary, primary);
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.01);
    sim.settle().unwrap_or_else(|error| panic!("{case:?}: {error}"));
    sim
}

/// Stretch of a bar under dead traction `-TRACTION` by Newton's method on the scalar cubic.
fn stretch(poisson: f64) -> f64 {
    let modulus = MODULUS / (1.0 - poisson * poisson);
    let mut a = 1.0f64;
    for _ in 0..30 {
        a -= (0.5 * modulus * a * (a * a - 1.0) + TRACTION) / (0.5 * modulus * (3.0 * a * a - 1.0));
    }
    a
}

#[test]
fn pressure_is_constant_across_meshes_that_do_not_match() {
    for cells in [[5, 7], [7, 5], [3, 16], [4, 4]] {
        for lower_is_secondary in [true, false] {
            for (angle, poisson) in [(0.0, 0.0), (0.0, 0.3), (0.6, 0.0), (2.5, 0.0)] {
                let case = Case { cells, lower_is_secondary, angle, poisson };
                let sim = pressed(case);
                let stretch = stretch(poisson);
                // E_22 = -nu/(1 - nu) E_11 across the load.
                let width = (1.0 - poisson / (1.0 - poisson) * (stretch * stretch - 1.0)).sqrt();
                let expected = TRACTION / width;
                let contact = sim.contact("contact").expect("there is one");
                for (node, pressure) in contact.pressure.iter().enumerate() {
                    assert!((pressure / expected - 1.0).abs() < TOLERANCE, "{case:?}: pressure {pressure} at {node}, expected {expected}");
                }
                assert!(contact.active.iter().all(|active| *active), "{case:?}");
                // No penetration: the gap is a linear function whose weighted mean vanishes at every node.
                assert!(contact.gap.iter().all(|gap| gap.abs() < TOLERANCE), "{case:?}: {:?}", contact.gap);
                let fields = sim.fields();
                let upper = &fields[1];
                let (s, c) = angle.sin_cos();
                for node in upper.mesh.boundary_nodes(upper.mesh.boundary("top").expect("a rectangle has it")) {
                    let u = upper.displacement[node as usize];
                    let along = c * u[1] - s * u[0];
                    assert!((along - 3.0 * (stretch - 1.0)).abs() < TOLERANCE, "{case:?}: top sinks by {along}");
                }
            }
        }
    }
}
