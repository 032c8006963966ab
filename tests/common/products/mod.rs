//! Random products of the catalogues: small models that combine one row of every catalogue, and conditions that hold for all of them.
//!
//! A [`Product`] is a row of each factor and a seed for its numbers. It is written as a script ([`script`]), so that it can be stored, read
//! and reduced ([`shrink`]). [`run`] executes it, [`oracle`] judges the outcome from printed lines and files, and [`cover`] chooses
//! products so that they contain every allowed pair of rows. Factors come from the registry of the language and from the catalogues of the
//! kernels ([`catalogue`]).

// Each program uses a part of this file.
#![allow(dead_code)]

pub mod agreement;
pub mod catalogue;
pub mod cover;
pub mod geometry;
pub mod numbers;
pub mod oracle;
pub mod run;
pub mod script;
pub mod shrink;
pub mod study;
pub mod told;

use std::fmt;

pub use catalogue::Catalogue;

/// A row of each factor, in the order of the catalogue, and a seed for the numbers.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Product {
    /// Index of the row of every factor.
    pub rows: Vec<usize>,
    /// Seed of the numbers; 0 gives simple ones.
    pub seed: u64,
}

/// A product with the words of its catalogue.
#[derive(Clone, Copy)]
pub struct Named<'a> {
    /// The catalogue.
    pub catalogue: &'a Catalogue,
    /// The product.
    pub product: &'a Product,
}

impl<'a> Named<'a> {
    /// The row of a factor.
    pub fn row(&self, factor: &str) -> &'a str {
        let index = self.catalogue.index(factor);
        &self.catalogue.factors[index].rows[self.product.rows[index]]
    }

    /// True if the row of a factor is one of `rows`.
    pub fn is(&self, factor: &str, rows: &[&str]) -> bool {
        rows.contains(&self.row(factor))
    }
}

impl fmt::Display for Named<'_> {
    /// All rows that are not the first of their factor.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.catalogue.factors.iter().zip(&self.product.rows).filter(|(_, row)| **row > 0);
        let all: Vec<String> = all.map(|(factor, row)| format!("{}={}", factor.name, factor.rows[*row].replace(' ', "_"))).collect();
        write!(out, "{} seed={}", if all.is_empty() { "plain".into() } else { all.join(" ") }, self.product.seed)
    }
}
