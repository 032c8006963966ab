//! Covering array: products that contain every pair of rows of two factors.
//!
//! The construction is greedy and deterministic. A product that the program refuses covers nothing: it is reduced to the rows that cause
//! the refusal, and later products do not combine these.

use std::collections::{BTreeMap, BTreeSet};

use super::{Catalogue, Product};

/// Row as a pair of factor and index.
pub type Row = (usize, usize);

/// Rows that the program refuses in combination, with code and title.
#[derive(Clone, Debug)]
pub struct Refusal {
    /// The rows; rows of other factors are arbitrary.
    pub rows: Vec<Row>,
    /// Code of the message.
    pub code: String,
    /// Title of the message.
    pub title: String,
}

/// Pairs that are not yet covered, and known refusals.
pub struct Cover<'a> {
    catalogue: &'a Catalogue,
    /// Pairs that no product contains yet.
    open: Open,
    /// Number of pairs without a meaning in combination.
    pub meaningless: usize,
    /// Number of all other pairs.
    pub meant: usize,
    /// Refused products.
    pub refusals: Vec<Refusal>,
    /// Pairs for which all products tried were refused, with the refusals.
    pub excluded: BTreeMap<(Row, Row), String>,
    /// Number of refused products by pair of rows.
    attempts: BTreeMap<(Row, Row), usize>,
}

/// Largest number of products tried for a pair before it counts as refused.
const ATTEMPTS: usize = 4;
/// Largest number of products tried around known refusals for a pair.
const MOST_WAYS: usize = 200;

/// Pairs not yet covered, as a table over all rows.
#[derive(Clone)]
struct Open {
    /// Index of the first row of every factor among all rows.
    starts: Vec<usize>,
    rows: Vec<Row>,
    table: Vec<bool>,
    count: usize,
}

impl Open {
    fn new(catalogue: &Catalogue) -> Self {
        let counts = catalogue.factors.iter().map(|factor| factor.rows.len());
        let starts = counts.scan(0, |sum, count| Some(std::mem::replace(sum, *sum + count))).collect();
        let rows: Vec<Row> =
            catalogue.factors.iter().enumerate().flat_map(|(factor, known)| (0..known.rows.len()).map(move |row| (factor, row))).collect();
        Open { starts, table: vec![false; rows.len() * rows.len()], rows, count: 0 }
    }

    fn place(&self, (first, second): (Row, Row)) -> usize {
        (self.starts[first.0] + first.1) * self.rows.len() + self.starts[second.0] + second.1
    }

    fn has(&self, pair: (Row, Row)) -> bool {
        self.table[self.place(pair)]
    }

    fn set(&mut self, pair: (Row, Row), is_open: bool) {
        let place = self.place(pair);
        if self.table[place] != is_open {
            self.table[place] = is_open;
            self.count = if is_open { self.count + 1 } else { self.count - 1 };
        }
    }

    /// An open pair of the two factors with the most open pairs; its products also cover pairs of small factors.
    fn first(&self) -> Option<(Row, Row)> {
        let mut of_factors: BTreeMap<(usize, usize), (usize, usize)> = BTreeMap::new();
        for place in (0..self.table.len()).filter(|&place| self.table[place]) {
            let [first, second] = [place / self.rows.len(), place % self.rows.len()].map(|row| self.rows[row].0);
            of_factors.entry((first, second)).or_insert((0, place)).0 += 1;
        }
        // Of equal numbers, the first pair of factors.
        let (_, place) = of_factors.into_values().rev().max_by_key(|(count, _)| *count)?;
        Some((self.rows[place / self.rows.len()], self.rows[place % self.rows.len()]))
    }
}

/// True if a product has both rows of a pair.
fn has(product: &Product, pair: (Row, Row)) -> bool {
    [pair.0, pair.1].iter().all(|&(factor, row)| product.rows[factor] == row)
}

impl<'a> Cover<'a> {
    /// All pairs of the catalogue.
    pub fn new(catalogue: &'a Catalogue) -> Self {
        let mut cover = Cover {
            catalogue,
            open: Open::new(catalogue),
            meaningless: 0,
            meant: 0,
            refusals: Vec::new(),
            excluded: BTreeMap::new(),
            attempts: BTreeMap::new(),
        };
        for first in 0..catalogue.factors.len() {
            for second in first + 1..catalogue.factors.len() {
                for a in 0..catalogue.factors[first].rows.len() {
                    for b in 0..catalogue.factors[second].rows.len() {
                        let pair = ((first, a), (second, b));
                        if cover.company(&[pair.0, pair.1]).is_some() {
                            cover.open.set(pair, true);
                            cover.meant += 1;
                        } else {
                            cover.meaningless += 1;
                        }
                    }
                }
            }
        }
        cover
    }

    /// Number of pairs not yet covered.
    pub fn open(&self) -> usize {
        self.open.count
    }

    /// The simplest product that contains some rows and gives each an effect.
    fn company(&self, rows: &[Row]) -> Option<Product> {
        let has = |product: &Product| rows.iter().all(|&(factor, row)| product.rows[factor] == row);
        let mut product = self.catalogue.plain();
        rows.iter().for_each(|&(factor, row)| product.rows[factor] = row);
        let fits = |product: &Product| Some(self.catalogue.normalized(product)).filter(|normal| has(normal));
        fits(&product).or_else(|| {
            // A row depends on one or two rows of other factors.
            let needs = [
                "cell=hex8",
                "partner=held_body",
                "partner=rigid_plane",
                "shape=round",
                "joint=point",
                "joint=point drive=drive",
                "load=force",
            ];
            let needs =
                needs.iter().chain(&["cell=hex8 partner=held_body", "cell=hex8 partner=rigid_plane", "shape=round partner=held_body"]);
            let needs = needs.chain(&["cell=hex8 load=force", "partner=held_body load=force", "partner=rigid_plane moving=moving"]);
            let candidates = needs.map(|words| {
                let mut product = self.catalogue.product(words);
                rows.iter().for_each(|&(factor, row)| product.rows[factor] = row);
                product
            });
            candidates.into_iter().find_map(|product| fits(&product))
        })
    }

    /// Known refusal of a product.
    pub fn refusal(&self, product: &Product) -> Option<&Refusal> {
        self.refusals.iter().find(|refusal| refusal.rows.iter().all(|&(factor, row)| product.rows[factor] == row))
    }

    /// The pairs of a product.
    fn pairs(product: &Product) -> impl Iterator<Item = (Row, Row)> + '_ {
        let count = product.rows.len();
        let pairs = (0..count).flat_map(move |first| (first + 1..count).map(move |second| (first, second)));
        pairs.map(|(first, second)| ((first, product.rows[first]), (second, product.rows[second])))
    }

    fn gain(&self, product: &Product) -> usize {
        Self::pairs(product).filter(|pair| self.open.has(*pair)).count()
    }

    /// A product with many uncovered pairs; `None` if all are covered or refused.
    pub fn next(&mut self) -> Option<Product> {
        while let Some(pair) = self.open.first() {
            let tried = self.attempts.get(&pair).copied().unwrap_or(0);
            let plainest = self.company(&[pair.0, pair.1]).expect("pairs without a meaning are not open");
            let allowed = if tried < ATTEMPTS { self.allowed(plainest.clone(), pair) } else { None };
            let Some(mut best) = allowed else {
                self.exclude(pair, &plainest);
                continue;
            };
            *self.attempts.entry(pair).or_default() += 1;
            let count = self.catalogue.factors.len();
            // After refusals of a pair its product takes fewer uncovered rows of other factors, and none in the last attempt.
            let others = if tried + 1 >= ATTEMPTS { 0 } else { 2 * count };
            for turn in 0..others {
                let index = (turn * 7 + pair.0.0) % count;
                if index == pair.0.0 || index == pair.1.0 || (tried > 0 && !(index + tried).is_multiple_of(3)) {
                    continue;
                }
                let mut most = self.gain(&best);
                for row in 0..self.catalogue.factors[index].rows.len() {
                    let mut candidate = best.clone();
                    candidate.rows[index] = row;
                    let candidate = self.catalogue.normalized(&candidate);
                    if !has(&candidate, pair) || self.refusal(&candidate).is_some() {
                        continue;
                    }
                    let gain = self.gain(&candidate);
                    if gain > most {
                        (most, best) = (gain, candidate);
                    }
                }
            }
            return Some(best);
        }
        None
    }

    /// The product, or for a refused one a modification that contains the pair and is allowed.
    pub fn allowed(&self, product: Product, pair: (Row, Row)) -> Option<Product> {
        let mut seen = BTreeSet::from([product.clone()]);
        let mut ways = vec![product];
        let mut place = 0;
        while place < ways.len() && place < MOST_WAYS {
            let Some(refusal) = self.refusal(&ways[place]) else { return Some(ways.swap_remove(place)) };
            for &(factor, _) in refusal.rows.iter().filter(|row| row.0 != pair.0.0 && row.0 != pair.1.0) {
                for row in 0..self.catalogue.factors[factor].rows.len() {
                    let mut candidate = ways[place].clone();
                    candidate.rows[factor] = row;
                    let candidate = self.catalogue.normalized(&candidate);
                    if has(&candidate, pair) && seen.insert(candidate.clone()) {
                        ways.push(candidate);
                    }
                }
            }
            place += 1;
        }
        None
    }

    fn exclude(&mut self, pair: (Row, Row), product: &Product) {
        let why = self
            .refusal(product)
            .map_or_else(|| "in all company that was tried".to_string(), |refusal| format!("{} {}", refusal.code, refusal.title));
        self.open.set(pair, false);
        self.excluded.insert(pair, why);
    }

    /// Products with all pairs that the known refusals allow, without running them.
    pub fn all(&mut self) -> Vec<Product> {
        let mut products = Vec::new();
        while let Some(product) = self.next() {
            self.drawn(&product);
            products.push(product);
        }
        products
    }

    /// Products to be run at the same time, each chosen as if the earlier ones had been covered.
    pub fn batch(&mut self, count: usize) -> Vec<Product> {
        let open = self.open.clone();
        let mut products = Vec::new();
        while products.len() < count
            && let Some(product) = self.next()
        {
            for pair in Self::pairs(&product) {
                self.open.set(pair, false);
            }
            products.push(product);
        }
        self.open = open;
        for pair in self.excluded.keys() {
            self.open.set(*pair, false);
        }
        products
    }

    /// Marks the pairs of a product as covered.
    pub fn drawn(&mut self, product: &Product) {
        for pair in Self::pairs(product) {
            self.open.set(pair, false);
            self.excluded.remove(&pair);
        }
    }

    /// Records rows that the program refuses in combination.
    pub fn refused(&mut self, rows: Vec<Row>, code: &str, title: &str) {
        if !rows.is_empty() && !self.refusals.iter().any(|refusal| refusal.rows == rows) {
            self.refusals.push(Refusal { rows, code: code.into(), title: title.into() });
        }
    }

    /// A product without known refusals: rows that cause a refusal are replaced one after another.
    pub fn mended(&self, product: &Product, mut choose: impl FnMut(usize) -> usize) -> Option<Product> {
        let mut product = product.clone();
        for _ in 0..60 {
            let Some(refusal) = self.refusal(&product) else { return Some(product) };
            let (factor, _) = refusal.rows[choose(refusal.rows.len())];
            product.rows[factor] = choose(self.catalogue.factors[factor].rows.len());
            product = self.catalogue.normalized(&product);
        }
        None
    }

    /// Table of refusals in file format: code, rows, title.
    pub fn table(&self) -> String {
        let mut lines: Vec<String> =
            self.refusals.iter().map(|refusal| format!("{} | {} | {}", refusal.code, self.words(&refusal.rows), refusal.title)).collect();
        lines.sort();
        lines.iter().map(|line| format!("{line}\n")).collect()
    }

    /// Reads refusals of a table; rows that no longer exist in the catalogue are left out.
    pub fn learn(&mut self, table: &str) {
        for line in table.lines() {
            let parts: Vec<&str> = line.split(" | ").collect();
            let [code, words, title] = parts[..] else { continue };
            let rows: Option<Vec<Row>> = words.split(' ').map(|word| self.row(word)).collect();
            if let Some(rows) = rows {
                self.refused(rows, code, title);
            }
        }
    }

    fn row(&self, word: &str) -> Option<Row> {
        let (name, row) = word.split_once('=')?;
        let factor = self.catalogue.factors.iter().position(|factor| factor.name == name)?;
        let place = self.catalogue.factors[factor].rows.iter().position(|known| known.replace(' ', "_") == row)?;
        Some((factor, place))
    }

    /// The simplest product with the rows of a refusal.
    pub fn example(&self, refusal: &Refusal) -> Option<Product> {
        self.company(&refusal.rows)
    }

    /// Removes refusals that the program no longer makes.
    pub fn forget(&mut self, is_stale: &[bool]) {
        let mut stale = is_stale.iter();
        self.refusals.retain(|_| !stale.next().copied().unwrap_or(false));
    }

    /// Description of rows.
    pub fn words(&self, rows: &[Row]) -> String {
        let words = |&(factor, row): &Row| {
            format!("{}={}", self.catalogue.factors[factor].name, self.catalogue.factors[factor].rows[row].replace(' ', "_"))
        };
        rows.iter().map(words).collect::<Vec<_>>().join(" ")
    }
}
