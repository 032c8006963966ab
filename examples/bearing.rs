//! Bearing of Hesch and Betsch (2007) with the kernels alone, without a script: two rings in frictionless mortar contact, spun up by a
//! torque, then free. Prints the ledger of every 20th step and the drift of the energy.
//!
//! `cargo example bearing -- [refine] [dt] [until]`

use std::error::Error;

use conserva::dynamics::{Hat, LoadKind, Model, Options, Simulation};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<f64> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let argument = |index: usize, default: f64| arguments.get(index).copied().unwrap_or(default);
    let (refine, dt, until) = (argument(0, 1.0) as usize, argument(1, 0.005), argument(2, 2.0));

    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material()?;
    let mut model = Model::new("bearing");
    let mesh = |inner, outer, around: usize| ring(inner, outer, [10 * refine, around * refine], [0.0; 2], 0.0);
    let outer = model.add_body("outer ring", mesh(1.0, 1.5, 48)?, &steel);
    let inner = model.add_body("inner ring", mesh(0.5, 1.002, 40)?, &steel);
    model.fix(model.boundary(outer, "outer")?, [true; 3]);
    model.add_contact("race", model.boundary(inner, "outer")?, model.boundary(outer, "inner")?);
    model.load(model.boundary(inner, "inner")?, LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 0.5, peak: 0.1 });

    let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, dt))?;
    let settled = sim.settle()?;
    println!("settled in {} steps, {} iterations: strain energy {:.12e}", settled.steps, settled.newton_iterations, settled.strain);
    let (mut free, mut worst, mut iterations, mut steps) = (f64::NAN, 0.0f64, 0, 0);
    while sim.time() < until - 1e-9 {
        sim.step(Some(until), &mut |row| {
            if free.is_nan() && row.time > 0.5 - 1e-9 {
                free = row.total();
            }
            steps += 1;
            iterations += row.newton_iterations;
            worst = worst.max(row.energy_defect.abs() / row.total());
            if row.step % 20 == 0 {
                println!(
                    "t {:.4}  total {:.12e}  defect {:9.1e}  angular momentum {:.10e}  active {} iterations {}  halvings {}",
                    row.time,
                    row.total(),
                    row.energy_defect,
                    row.angular_momentum[2],
                    row.active,
                    row.newton_iterations,
                    row.halvings
                );
            }
        })?;
    }
    println!("drift since the torque ended {:.1e}, worst defect {worst:.1e} of the total", sim.row().total() / free - 1.0);
    println!("{steps} steps, {:.2} iterations a step, {:?}", iterations as f64 / steps as f64, sim.statistics());
    Ok(())
}
