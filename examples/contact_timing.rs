//! Time of one contact evaluation of two rings in mortar contact, per active facet pair; no script, no solver.
//!
//! Run with `cargo example contact_timing`. The rings are those of the bearing scenario, refined by 1, 2, 4.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

use conserva::contact::{CandidateSearch, Evaluation, Mortar, PatchFunctions, PredictedMotion};
use conserva::integrators::Derivative;

/// Coordinates of the nodes of a circle of facets, in order.
fn circle(count: u32, radius: f64, turn: f64) -> impl Iterator<Item = f64> {
    (0..count).flat_map(move |i| {
        let angle = turn + TAU * f64::from(i) / f64::from(count);
        [radius * angle.cos(), radius * angle.sin()]
    })
}

fn main() {
    for refine in [1, 2, 4] {
        let (inner, outer) = (40 * refine, 48 * refine);
        let secondary: Vec<[u32; 2]> = (0..inner).map(|i| [i, (i + 1) % inner]).collect();
        let primary: Vec<[u32; 2]> = (0..outer).map(|i| [inner + (i + 1) % outer, inner + i]).collect();
        let positions = |turn| circle(inner, 1.002, turn).chain(circle(outer, 1.0, 0.0)).collect::<Vec<f64>>();
        let half_facet = 0.5 * TAU / f64::from(inner);
        let (q_0, q_1) = (positions(0.1), positions(0.1 + half_facet));
        let mut mortar = Mortar::new(&secondary, &primary, &q_0);
        let travel = 0.5 * mortar.facet_size();
        let repetitions = 20_000 / refine;

        let clock = Instant::now();
        for step in 0..repetitions {
            black_box(mortar.update_candidates(&PredictedMotion::within(if step % 2 == 0 { &q_0 } else { &q_1 }, travel)));
        }
        let kept = clock.elapsed().as_secs_f64() / f64::from(repetitions);
        let clock = Instant::now();
        for _ in 0..repetitions / 10 {
            black_box(Mortar::new(&secondary, &primary, &q_0).update_candidates(&PredictedMotion::within(&q_0, travel)));
        }
        let searched = clock.elapsed().as_secs_f64() / f64::from(repetitions / 10);
        mortar.begin_step(&q_0);
        let (lambda, mut out) = (vec![1.0; inner as usize], Evaluation::default());
        mortar.evaluate(Derivative::DiscreteGradient, &q_1, &lambda, &mut out);
        let live = out.live.iter().filter(|live| **live).count();
        println!(
            "refine {refine}: {} pairs, {live} live; list kept in {:.2} us, made in {:.1} us",
            mortar.pairs().len(),
            1e6 * kept,
            1e6 * searched
        );
        for derivative in Derivative::ALL {
            let clock = Instant::now();
            for _ in 0..repetitions {
                mortar.evaluate(derivative, black_box(&q_1), black_box(&lambda), &mut out);
            }
            let seconds = clock.elapsed().as_secs_f64() / f64::from(repetitions);
            let name = format!("{derivative:?}");
            println!("    {name:<18} {:7.2} us, {:4.0} ns per live pair", 1e6 * seconds, 1e9 * seconds / live as f64);
        }
        let clock = Instant::now();
        for _ in 0..repetitions {
            black_box(mortar.gap(black_box(&q_1)));
        }
        println!("    {:<16} {:7.2} us", "gap alone", 1e6 * clock.elapsed().as_secs_f64() / f64::from(repetitions));
    }
}
