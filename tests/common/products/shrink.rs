//! Reduction of a product that keeps the kind of its failure.

use super::cover::Row;
use super::run::{Bench, Verdict};
use super::{Catalogue, Named, Product};

/// True if two verdicts have a fault of one kind, or one code of refusal.
fn is_alike(verdict: &Verdict, other: &Verdict) -> bool {
    match (verdict, other) {
        (Verdict::Refused(code, _), Verdict::Refused(again, _)) => code == again,
        (Verdict::Wrong(faults), Verdict::Wrong(again)) => faults.first().map(|fault| fault.kind) == again.first().map(|fault| fault.kind),
        _ => false,
    }
}

/// Product with the fewest rows that are not the first of their factor and with the same kind of verdict, and with simple numbers if the
/// verdict permits.
pub fn shrink(catalogue: &Catalogue, bench: &Bench, product: &Product, verdict: &Verdict) -> (Product, Verdict) {
    let judge = |product: &Product| bench.judge(Named { catalogue, product });
    shrink_by(catalogue, &judge, product, verdict)
}

fn shrink_by(catalogue: &Catalogue, judge: &dyn Fn(&Product) -> Verdict, product: &Product, verdict: &Verdict) -> (Product, Verdict) {
    let mut best = (product.clone(), verdict.clone());
    let attempt = |candidate: Product, best: &mut (Product, Verdict)| {
        let candidate = catalogue.normalized(&candidate);
        if candidate == best.0 {
            return false;
        }
        let found = judge(&candidate);
        let keeps = is_alike(&found, verdict);
        if keeps {
            *best = (candidate, found);
        }
        keeps
    };
    let mut is_smaller = true;
    while is_smaller {
        is_smaller = false;
        if best.0.seed != 0 {
            let plain = Product { seed: 0, ..best.0.clone() };
            is_smaller |= attempt(plain, &mut best);
        }
        // The last factors first: operations on a model before the model.
        for index in (0..catalogue.factors.len()).rev() {
            if best.0.rows[index] > 0 {
                let mut candidate = best.0.clone();
                candidate.rows[index] = if catalogue.factors[index].name == "cell" { simpler_cell(catalogue, index, &best.0) } else { 0 };
                is_smaller |= candidate != best.0 && attempt(candidate, &mut best);
            }
        }
    }
    best
}

/// The first cell kind, or the simplest one of the same dimension if the verdict needs the dimension.
fn simpler_cell(catalogue: &Catalogue, index: usize, product: &Product) -> usize {
    let solid = |row: usize| !super::catalogue::is_plane(&catalogue.factors[index].rows[row]);
    let plainest = catalogue.factors[index].rows.iter().position(|row| row == "hex8").unwrap_or(0);
    let is_obstacle_of_space =
        catalogue.factors[catalogue.index("partner")].rows[product.rows[catalogue.index("partner")]].starts_with("rigid_");
    if solid(product.rows[index]) && product.rows[index] != plainest && is_obstacle_of_space { plainest } else { 0 }
}

/// Rows that cause a refusal: those that are not the first of their factor, and first ones for which other rows are allowed.
pub fn blame(catalogue: &Catalogue, bench: &Bench, product: &Product, verdict: &Verdict) -> Vec<Row> {
    let is_early = bench.refusal(Named { catalogue, product }).is_some();
    let judge = |product: &Product| match bench.refusal(Named { catalogue, product }) {
        Some((code, title)) => Verdict::Refused(code, title),
        None if is_early => Verdict::Sound,
        None => bench.judge(Named { catalogue, product }),
    };
    let whole = product;
    let (product, _) = shrink_by(catalogue, &judge, product, verdict);
    let mut rows: Vec<Row> = Vec::new();
    for (factor, &row) in product.rows.iter().enumerate() {
        let count = catalogue.factors[factor].rows.len();
        let is_cured = |other: usize| {
            let mut candidate = product.clone();
            candidate.rows[factor] = other;
            let candidate = catalogue.normalized(&candidate);
            let is_alike =
                (0..candidate.rows.len()).all(|place| candidate.rows[place] == if place == factor { other } else { product.rows[place] });
            is_alike && !matches!(judge(&candidate), Verdict::Refused(..))
        };
        if row > 0 || [1, count / 2, count - 1].into_iter().filter(|&other| other < count && other > 0).any(is_cured) {
            // The row of the original product.
            rows.push((factor, whole.rows[factor]));
        }
    }
    general(catalogue, &judge, &product, rows)
}

/// Removes rows from a refusal that are necessary only to give the others an effect, if every other such row of their factor is refused as
/// well: friction that an integrator does not support is refused with any partner.
fn general(catalogue: &Catalogue, judge: &dyn Fn(&Product) -> Verdict, product: &Product, rows: Vec<Row>) -> Vec<Row> {
    let verdict = judge(product);
    let keeps = |candidate: &Product, factor: usize| rows.iter().all(|&(other, row)| other == factor || candidate.rows[other] == row);
    let is_carrier = |&(factor, row): &Row| {
        let with = |other: usize| {
            let mut candidate = product.clone();
            candidate.rows[factor] = other;
            catalogue.normalized(&candidate)
        };
        let others = (1..catalogue.factors[factor].rows.len()).filter(|&other| other != row).map(with);
        let mut meant = others.filter(|candidate| keeps(candidate, factor) && candidate.rows[factor] > 0).peekable();
        row > 0 && !keeps(&with(0), factor) && meant.peek().is_some() && meant.all(|candidate| is_alike(&judge(&candidate), &verdict))
    };
    rows.iter().filter(|row| !is_carrier(row)).copied().collect()
}
