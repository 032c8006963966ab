//! Contract of bodies with viscosity and plasticity: exact tangents; the work of a discrete gradient is stored or becomes heat.

use conserva::bodies::{BodyCells, BodyState, Dilatation, ElementLoop, Elements, Formulation, Plane, Space, Step};
use conserva::elements::CellKind;
use conserva::integrators::Derivative;
use conserva::linear::{Pattern, Vertex};
use conserva::materials::{Branch, ElasticPlastic, Hardening, LINEAR, Material, NeoHookean, RateDependence, Viscosity};
use conserva::math::workers::Workers;
use conserva::mesh::{Mesh, block, rectangle};

use crate::common::Random;

/// Viscous body of a few cells, with displacements at start and end of a step.
struct Body<const D: usize> {
    elements: Box<dyn ElementLoop<D>>,
    pattern: Pattern,
    ends: [Vec<f64>; 2],
}

impl<const D: usize> Body<D>
where
    Space<D>: Elements<D>,
{
    fn new(mesh: &Mesh, plane: Plane, law: &Material) -> Self {
        let branches = [(30.0, 0.05), (7.0, 0.4)].map(|(shear_modulus, relaxation_time)| Branch { shear_modulus, relaxation_time });
        let material = law.clone().with_viscosity(Viscosity { shear: 0.4, bulk: 0.1, branches: branches.to_vec() });
        let formulation = Formulation { plane, dilatation: Dilatation::Pointwise };
        let mut elements = Space::<D>::elements(&BodyCells::new(mesh, &material, formulation)).unwrap();
        let vertices = vec![Vertex::coordinates(D as u8); mesh.points.len()];
        let pattern = Pattern::new(&vertices, elements.cliques().iter().map(|clique| &clique[..]));
        elements.place(&pattern);
        let mut random = Random(3);
        let ends = [0.02, 0.05].map(|size| (0..D * mesh.points.len()).map(|_| size * random.next()).collect());
        Body { elements, pattern, ends }
    }

    fn step<'a>(derivative: Derivative, [u_0, u_1]: [&'a [f64]; 2], history: &'a [f64]) -> Step<'a> {
        Step { derivative, weight: 0.7, inertia: 0.0, u_0, u_1, history, dt: 0.05 }
    }

    fn forces(&self, step: &Step, values: Option<&mut [f64]>) -> Vec<f64> {
        let mut forces = vec![0.0; step.u_1.len()];
        self.elements.assemble(step, &mut forces, values, &Workers::new(1)).unwrap();
        forces
    }

    fn tangent_is_the_derivative_of_the_force(&self, name: &str) {
        let [u_0, u_1] = &self.ends;
        let at_rest = self.elements.relaxed(BodyState { u: u_1, history: &vec![0.0; self.elements.history()] });
        // A step back from the end to the start makes the history variables nonzero.
        let history = self.elements.advance(&Self::step(Derivative::DiscreteGradient, [u_1, u_0], &at_rest)).history;
        for derivative in Derivative::ALL {
            let mut values = vec![0.0; self.pattern.values()];
            self.forces(&Self::step(derivative, [u_0, u_1], &history), Some(&mut values));
            let h = 1e-6;
            for unknown in 0..u_1.len() {
                let [up, down] = [h, -h].map(|h| {
                    let mut u = u_1.clone();
                    u[unknown] += h;
                    self.forces(&Self::step(derivative, [u_0, &u], &history), None)
                });
                for &node in self.pattern.neighbors(unknown / D) {
                    let place = self.pattern.block(node, (unknown / D) as u32);
                    for i in 0..D {
                        let difference = (up[node as usize * D + i] - down[node as usize * D + i]) / (2.0 * h);
                        let value = values[place.at(i, unknown % D)];
                        // Values are of the order 100, in bodies of revolution 1000: truncation error h^2, round-off 1e-16/h.
                        assert!((difference - value).abs() < 1e-5, "{name} {derivative:?}: {difference} {value}");
                    }
                }
            }
        }
    }

    fn work_is_stored_or_heat(&self, name: &str) {
        let [mut from, mut to] = self.ends.each_ref().map(Vec::as_slice);
        let mut history = self.elements.relaxed(BodyState { u: from, history: &vec![0.0; self.elements.history()] });
        let energy =
            |u: &[f64], history: &[f64]| self.elements.strain_energy(BodyState { u, history }) + self.elements.relaxing_energy(history);
        let mut stored = energy(from, &history);
        for _ in 0..3 {
            let step = Self::step(Derivative::DiscreteGradient, [from, to], &history);
            let work: f64 = self.forces(&step, None).iter().zip(to.iter().zip(from)).map(|(f, (a, b))| f * (a - b)).sum();
            let after = self.elements.advance(&step);
            let energy = energy(to, &after.history);
            let heat = after.viscous + after.plastic;
            assert!(after.viscous > 0.0 && after.plastic >= 0.0 && energy > 0.0, "{name}");
            let defect = work / step.weight - (energy - stored) - heat;
            // The tolerance is the round-off of energies of the order 100 times a volume.
            assert!(defect.abs() < 1e-13 * (work.abs() + energy + heat).max(10.0), "{name}: {defect:e}");
            (stored, history) = (energy, after.history);
            std::mem::swap(&mut from, &mut to);
        }
    }

    fn check(&self, name: &str) {
        self.tangent_is_the_derivative_of_the_force(name);
        self.work_is_stored_or_heat(name);
    }
}

fn laws() -> Vec<Material> {
    let large = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().unwrap();
    let metal = ElasticPlastic {
        youngs_modulus: 100.0,
        poisson_ratio: 0.3,
        density: 1.0,
        yield_stress: 1.0,
        hardening: Hardening::NONE,
        back_stresses: Vec::new(),
        rate: RateDependence::None,
    };
    vec![large, Material::new(&LINEAR[0], &[100.0, 0.3, 1.0]).unwrap(), Material::elastic_plastic(&metal).unwrap()]
}

#[test]
fn forces_of_viscous_cells_have_exact_tangents_and_exact_work() {
    for law in laws() {
        for plane in [Plane::Strain, Plane::Stress, Plane::Axisymmetric] {
            for kind in [CellKind::Quad4, CellKind::Tri6] {
                let mesh = rectangle([2.0, 1.0], [2, 1], [0.5, 0.0]).and_then(|mesh| mesh.with_cells(kind)).unwrap();
                Body::<2>::new(&mesh, plane, &law).check(&format!("{law:?} {plane:?} {kind:?}"));
            }
        }
        let mesh = block([1.0; 3], [1; 3], [0.0; 3]).unwrap();
        Body::<3>::new(&mesh, Plane::Strain, &law).check(&format!("{law:?} hex8"));
    }
}
