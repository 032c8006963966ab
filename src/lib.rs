//! Conserva: a scripting engine for contact dynamics that conserves energy and both momenta.
//!
//! Two blocks collide. The step from contact to no contact and back keeps the energy to round-off:
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
//! model.throw(left, [1.0, 0.0, 0.0], [0.0; 3]);
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
//! Models, simulations and their states can be sent to other threads. `examples/` has more programs, `docs/reference.md` the language of
//! the scripts.
//!
//! The modules stand in floor order: each names only modules above it in this list (`src/README.md` tells why).
//! The method is that of C. Hesch and P. Betsch, "Energy-momentum schemes for large deformation contact problems", PAMM 2007.

#![deny(missing_docs)]
#![forbid(unsafe_code)]

pub mod machine;
pub mod math;

pub mod elements;
pub mod linear;
pub mod materials;

pub mod mesh;

pub mod integrators;

pub mod bodies;
pub mod contact;

pub mod dynamics;

pub mod output;

pub mod script;

pub mod studies;

pub mod cli;
