//! Conserva: a scripting engine for contact dynamics that conserves energy, linear and angular momentum.
//!
//! Two blocks collide. Energy is conserved to round-off in every step, including those in which contact becomes active or inactive:
//!
//! ```
//! use conserva::dynamics::{Model, Options, PERSISTENCY, Simulation};
//! use conserva::integrators::ENERGY_MOMENTUM;
//! use conserva::materials::NeoHookean;
//! use conserva::mesh::rectangle;
//!
//! let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material()?;
//! let mut model = Model::new("collision");
//! let left = model.add_body("left", rectangle([1.0, 0.5], [6, 3], [0.0, 0.0])?, &rubber);
//! let right = model.add_body("right", rectangle([1.0, 0.8], [8, 5], [1.02, -0.1])?, &rubber);
//! model.set_initial_velocity(left, [1.0, 0.0, 0.0], [0.0; 3]);
//! let contact = model.add_contact("faces", model.boundary(left, "right")?, model.boundary(right, "left")?);
//! contact.update = Some(&PERSISTENCY);
//!
//! let mut simulation = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.005))?;
//! let energy = simulation.row().total();
//! let mut closed = 0;
//! for _ in 0..20 {
//!     simulation.step(None, &mut |row| closed = closed.max(row.active))?;
//!     assert!((simulation.row().total() - energy).abs() < 1e-10 * energy);
//! }
//! assert!(closed > 0 && simulation.row().strain > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A force element is a [`Part`](dynamics::Part), and a program can define its own. This one resists the relative motion of two nodes with
//! a force `c (v_b - v_a)`. It receives the velocity at which forces act in a step, and the derivative of that velocity, so that it works
//! with every time integrator (`examples/dashpot.rs` compares it with a closed form, `examples/newmark.rs` defines a time integrator):
//!
//! ```
//! use std::sync::Arc;
//!
//! use conserva::dynamics::{
//!     Change, Iterate, Model, Numbering, Options, Part, PartDefinition, Pose, Refusal, PartStepResult, Simulation, StepError, Sums,
//! };
//! use conserva::integrators::ENERGY_MOMENTUM;
//! use conserva::linear::{Block, Pattern};
//! use conserva::materials::NeoHookean;
//! use conserva::mesh::rectangle;
//!
//! /// Dashpot between two nodes of the first body of a plane model.
//! #[derive(Clone)]
//! struct Dashpot {
//!     viscosity: f64,
//!     nodes: [u32; 2],
//!     places: [Block; 4],
//! }
//!
//! impl PartDefinition for Dashpot {
//!     fn name(&self) -> &str {
//!         "dashpot"
//!     }
//!     fn bodies(&self) -> Vec<usize> {
//!         vec![0]
//!     }
//!     fn part(&self, _: &Numbering) -> Box<dyn Part> {
//!         Box::new(self.clone())
//!     }
//!     fn changed(&self, _: &Change) -> Arc<dyn PartDefinition> {
//!         Arc::new(self.clone())
//!     }
//!     fn describe(&self) -> String {
//!         format!("dashpot of {}", self.viscosity)
//!     }
//! }
//!
//! impl Dashpot {
//!     fn rate(&self, at: &Iterate, i: usize) -> f64 {
//!         let [a, b] = self.nodes.map(|node| at.velocity[2 * node as usize + i]);
//!         b - a
//!     }
//! }
//!
//! impl Part for Dashpot {
//!     fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
//!         visit(&self.nodes);
//!     }
//!     fn place(&mut self, pattern: &Pattern) {
//!         self.places = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[k, l]| pattern.block(self.nodes[k], self.nodes[l]));
//!     }
//!     fn linearize(&self, at: &Iterate, _: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
//!         for i in 0..2 {
//!             let force = at.weight * self.viscosity * self.rate(at, i);
//!             sums.internal[2 * self.nodes[0] as usize + i] -= force;
//!             sums.internal[2 * self.nodes[1] as usize + i] += force;
//!         }
//!         if let Some(values) = sums.tangent.as_deref_mut() {
//!             for (block, sign) in self.places.iter().zip([1.0, -1.0, -1.0, 1.0]) {
//!                 (0..2).for_each(|i| values[block.at(i, i)] += sign * at.weight * self.viscosity * at.velocity_slope);
//!             }
//!         }
//!         Ok(())
//!     }
//!     fn energy(&self, _: Pose, _: &[f64]) -> f64 {
//!         0.0
//!     }
//!     fn after_step(&self, at: &Iterate, _: &[f64]) -> Result<PartStepResult, StepError> {
//!         let power: f64 = (0..2).map(|i| self.viscosity * self.rate(at, i).powi(2)).sum();
//!         Ok(PartStepResult { dissipated: at.dt * power, ..PartStepResult::default() })
//!     }
//! }
//!
//! let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material()?;
//! let mut model = Model::new("spinning block");
//! let block = model.add_body("block", rectangle([1.0, 0.5], [4, 2], [0.0, 0.0])?, &rubber);
//! model.set_initial_velocity(block, [0.0; 3], [0.0, 0.0, 2.0]);
//! model.parts.push(Arc::new(Dashpot { viscosity: 0.1, nodes: [0, 4], places: Default::default() }));
//! let mut simulation = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.01))?;
//! let energy = simulation.row().total();
//! let mut heat = 0.0;
//! for _ in 0..20 {
//!     simulation.step(None, &mut |row| heat += row.dissipation)?;
//! }
//! assert!(heat > 0.01 * energy && (simulation.row().total() + heat - energy).abs() < 1e-10 * energy);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Models, simulations and their states can be sent to other threads. `examples/` has more programs, `docs/reference.md` the script
//! language.
//!
//! The modules are in floor order, after those of the kernels: each depends only on modules above it in this list (reasons in
//! `src/README.md`). The method is that of C. Hesch and P. Betsch, "Energy-momentum schemes for large deformation contact problems", PAMM
//! 2007.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

// The kernels are packages of their own (`packages/`), which changes above them do not recompile.
#[doc(inline)]
pub use conserva_base::{elements, integrators, linear, machine, math};
#[doc(inline)]
pub use conserva_bodies::bodies;
#[doc(inline)]
pub use conserva_contact::contact;
#[doc(inline)]
pub use conserva_dynamics::dynamics;
#[doc(inline)]
pub use conserva_materials::materials;
#[doc(inline)]
pub use conserva_mesh::mesh;
#[doc(inline)]
pub use conserva_output::output;

#[cfg(feature = "command-line")]
#[doc(inline)]
pub use conserva_language::cli;
#[cfg(feature = "scripts")]
#[doc(inline)]
pub use conserva_language::{script, studies};
