//! Verdicts on many products, several at a time: the covering array, and random ones.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::super::splitmix::SplitMix;
use super::cover::{Cover, Row};
use super::run::{Bench, Verdict};
use super::shrink::blame;
use super::{Catalogue, Named, Product};

/// Number of products that are chosen before the first verdict. With larger batches more products would be refused for the same reason.
const BATCH: usize = 2;

/// A known violation.
#[derive(Debug)]
pub struct Known {
    /// Kinds of faults, separated by blanks.
    pub kinds: String,
    /// Rows that a product must have.
    pub rows: String,
    /// Name of the fault.
    pub fault: String,
}

impl Known {
    /// Known violations of a table, one per line: kinds, rows and name, separated by bars.
    pub fn read(table: &str) -> Vec<Known> {
        let line = |line: &str| {
            let parts: Vec<String> = line.split('|').map(|part| part.trim().to_string()).collect();
            let [kinds, rows, fault] = parts.try_into().ok()?;
            Some(Known { kinds, rows, fault })
        };
        table.lines().filter_map(line).collect()
    }
}

/// Verdicts on many products.
#[derive(Default)]
pub struct Study {
    /// Number of products that ran without a violation.
    pub sound: usize,
    /// Number of refused products.
    pub refused: usize,
    /// Number of products with a known fault.
    pub known: usize,
    /// Number of occurrences of each known violation.
    pub met: BTreeMap<usize, usize>,
    /// Products with other faults.
    pub wrong: Vec<(Product, Verdict)>,
    /// Refusals of the table that the program no longer makes, and the reverse.
    pub changed: Vec<String>,
    /// Times of all products.
    pub times: Vec<(Duration, Product)>,
}

/// Result of a product in a worker.
struct Judged {
    verdict: Verdict,
    blamed: Vec<Row>,
    time: Duration,
}

/// Judges products on threads with a folder each; results are in the order of the products.
fn judge_all(catalogue: &Catalogue, home: &Path, program: &Path, threads: usize, products: &[Product], is_blamed: bool) -> Vec<Judged> {
    let next = AtomicUsize::new(0);
    let found: Mutex<BTreeMap<usize, Judged>> = Mutex::default();
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let (next, found) = (&next, &found);
            let work = move || {
                let bench = Bench { home: home.join(format!("{thread}")), program: program.to_path_buf() };
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(product) = products.get(place) else { return };
                    let begun = Instant::now();
                    let verdict = bench.judge(Named { catalogue, product });
                    let time = begun.elapsed();
                    let blamed = match &verdict {
                        Verdict::Refused(..) if is_blamed => blame(catalogue, &bench, product, &verdict),
                        _ => Vec::new(),
                    };
                    found.lock().expect("no thread panics").insert(place, Judged { verdict, blamed, time });
                }
            };
            std::thread::Builder::new().stack_size(conserva::script::STACK).spawn_scoped(scope, work).expect("a thread can be made");
        }
    });
    found.into_inner().expect("no thread panics").into_values().collect()
}

impl Study {
    /// Records a verdict.
    fn book(&mut self, catalogue: &Catalogue, product: &Product, judged: &Judged, known: &[Known]) {
        self.times.push((judged.time, product.clone()));
        match &judged.verdict {
            Verdict::Sound => self.sound += 1,
            Verdict::Refused(..) => self.refused += 1,
            Verdict::Wrong(faults) => {
                let is_met = |Known { kinds, rows, .. }: &Known| {
                    let pattern = catalogue.product(rows);
                    let has = pattern.rows.iter().zip(&product.rows).all(|(wanted, row)| *wanted == 0 || wanted == row);
                    has && faults.iter().all(|fault| kinds.split(' ').any(|kind| kind == fault.kind))
                };
                let met: Vec<usize> = (0..known.len()).filter(|&place| is_met(&known[place])).collect();
                if met.is_empty() {
                    self.wrong.push((product.clone(), judged.verdict.clone()));
                } else {
                    self.known += 1;
                    met.into_iter().for_each(|place| *self.met.entry(place).or_default() += 1);
                }
            }
        }
    }

    /// Records a judged product, and prints one with an unknown fault.
    fn book_and_print(&mut self, catalogue: &Catalogue, product: &Product, judged: &Judged, known: &[Known]) {
        let before = self.wrong.len();
        self.book(catalogue, product, judged, known);
        if let Some((product, verdict)) = self.wrong.get(before) {
            println!("{}: {verdict:?}", Named { catalogue, product });
        }
    }

    /// Judges products that cover every allowed pair of rows; `refusals` is the stored table of refusals.
    pub fn cover<'a>(
        catalogue: &'a Catalogue,
        home: &Path,
        program: &Path,
        threads: usize,
        refusals: &str,
        known: &[Known],
    ) -> (Study, Cover<'a>) {
        let (mut study, mut cover) = (Study::default(), Cover::new(catalogue));
        cover.learn(refusals);
        study.changed = stale(catalogue, &mut cover, &home.join("0"));
        let learnt = cover.refusals.len();
        loop {
            if study.times.len() % (50 * BATCH) == 0 {
                let _ = std::fs::write(home.join("refused.txt"), cover.table());
                eprintln!("{} products, {} pairs to draw, {} refusals", study.times.len(), cover.open(), cover.refusals.len());
            }
            let products = cover.batch(BATCH);
            if products.is_empty() {
                let new = cover.refusals[learnt.min(cover.refusals.len())..].iter();
                study.changed.extend(new.map(|refusal| format!("new: {} {}", refusal.code, cover.words(&refusal.rows))));
                return (study, cover);
            }
            let judged = judge_all(catalogue, home, program, threads, &products, true);
            for (product, judged) in products.iter().zip(&judged) {
                study.book(catalogue, product, judged, known);
                match &judged.verdict {
                    Verdict::Refused(code, title) => cover.refused(judged.blamed.clone(), code, title),
                    _ => cover.drawn(product),
                }
            }
        }
    }

    /// Judges the array of all pairs that the known refusals allow, chosen before any product has run; pairs of products that are refused
    /// nevertheless stay open.
    pub fn array<'a>(
        catalogue: &'a Catalogue,
        home: &Path,
        program: &Path,
        threads: usize,
        refusals: &str,
        known: &[Known],
    ) -> (Study, Cover<'a>) {
        let (mut study, mut chosen) = (Study::default(), Cover::new(catalogue));
        chosen.learn(refusals);
        let products = chosen.all();
        let mut cover = Cover::new(catalogue);
        cover.excluded = chosen.excluded;
        for some in products.chunks(64) {
            let judged = judge_all(catalogue, home, program, threads, some, false);
            for (product, judged) in some.iter().zip(&judged) {
                study.book_and_print(catalogue, product, judged, known);
                match &judged.verdict {
                    Verdict::Refused(code, title) => println!("refused: {}: {code} {title}", Named { catalogue, product }),
                    _ => cover.drawn(product),
                }
            }
        }
        (study, cover)
    }

    /// Judges random products with consecutive seeds.
    pub fn random(
        catalogue: &Catalogue,
        home: &Path,
        program: &Path,
        threads: usize,
        refusals: &str,
        known: &[Known],
        seeds: std::ops::Range<u64>,
    ) -> Study {
        let mut study = Study::default();
        let mut cover = Cover::new(catalogue);
        cover.learn(refusals);
        let products: Vec<Product> = seeds.map(|seed| random(&cover, catalogue, seed)).collect();
        for some in products.chunks(64) {
            let judged = judge_all(catalogue, home, program, threads, some, false);
            for (product, judged) in some.iter().zip(&judged) {
                study.book_and_print(catalogue, product, judged, known);
            }
        }
        study
    }
}

/// Random product of a seed without known refusals; about half of its rows are the first of their factor.
pub fn random(cover: &Cover, catalogue: &Catalogue, seed: u64) -> Product {
    let mut random = SplitMix(seed ^ 0x0070_726f_6475_6374);
    let rows = catalogue.factors.iter().map(|factor| if random.below(2) == 0 { 0 } else { random.below(factor.rows.len()) }).collect();
    let product = catalogue.normalized(&Product { rows, seed: seed + 1 });
    cover.mended(&product, |count| random.below(count)).unwrap_or(product)
}

/// Removes refusals from the table that the program no longer makes; returns their descriptions.
fn stale(catalogue: &Catalogue, cover: &mut Cover, home: &Path) -> Vec<String> {
    let bench = Bench { home: home.to_path_buf(), program: home.to_path_buf() };
    let is_stale = |refusal: &super::cover::Refusal| {
        let Some(product) = cover.example(refusal) else { return true };
        match bench.judge_once(Named { catalogue, product: &product }) {
            Verdict::Refused(code, _) => code != refusal.code,
            _ => true,
        }
    };
    let found: Vec<bool> = cover.refusals.iter().map(is_stale).collect();
    let words = cover.refusals.iter().zip(&found).filter(|(_, is_stale)| **is_stale);
    let words = words.map(|(refusal, _)| format!("gone: {} {}", refusal.code, cover.words(&refusal.rows))).collect();
    cover.forget(&found);
    words
}
