//! Samples of the unit cube: a scrambled Sobol sequence, which fills the cube evenly, or independent random numbers. Equal seeds give equal
//! samples.

use std::str::FromStr;

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Method of sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplingMethod {
    /// The Sobol sequence with the scrambling of Owen as of B. Burley, "Practical hash-based Owen scrambling" (2020).
    Sobol,
    /// Independent, uniformly distributed.
    Random,
}

/// Method, number and seed of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Method of sampling.
    pub method: SamplingMethod,
    /// Number of samples of the varied parameters.
    pub count: usize,
    /// Seed of the pseudo-random numbers.
    pub seed: u32,
}

/// Largest numbers of samples and of parameters of the Sobol sequence.
const SOBOL: [usize; 2] = [1 << 16, 256];
/// Largest number of random samples.
const MOST: usize = 1_000_000;

impl FromStr for Sampling {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (method, most) = match text.split(':').next().unwrap_or_default().trim() {
            "sobol" => (SamplingMethod::Sobol, SOBOL[0]),
            "random" => (SamplingMethod::Random, MOST),
            _ => return Err("write sobol:256 or random:256, with the number of samples".into()),
        };
        let count = text.split_once(':').and_then(|(_, count)| count.trim().parse::<usize>().ok());
        match count.filter(|count| (1..=most).contains(count)) {
            Some(count) => Ok(Sampling { method, count, seed: 0 }),
            None => Err(format!("give the number of samples, from 1 to {most}, behind a colon: sobol:256")),
        }
    }
}

impl Sampling {
    /// Returns the samples, each with a number from 0 to 1 for every parameter.
    ///
    /// # Errors
    /// More samples or parameters than the method allows.
    pub fn draw(&self, parameters: usize) -> Result<Vec<Vec<f64>>, String> {
        if self.method == SamplingMethod::Sobol && parameters > SOBOL[1] {
            return Err(format!("the Sobol sequence samples {} parameters at most", SOBOL[1]));
        }
        let mut random = Pcg64Mcg::seed_from_u64(u64::from(self.seed));
        let sample = |index: usize| {
            let one = |parameter: usize| match self.method {
                SamplingMethod::Sobol => f64::from(sobol_burley::sample(index as u32, parameter as u32, self.seed)),
                // 53 bits, as many as the mantissa has.
                SamplingMethod::Random => (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64,
            };
            (0..parameters).map(one).collect()
        };
        Ok((0..self.count).map(sample).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sobol_has_one_sample_in_every_cell_and_random_has_not() {
        // Every elementary interval of base 2 contains its fraction of the samples: the definition of a (0, 2)-sequence.
        let cells = |method| {
            let samples = Sampling { method, count: 256, seed: 7 }.draw(2).unwrap();
            let mut cells: Vec<[usize; 2]> = samples.iter().map(|sample| [0, 1].map(|axis| (sample[axis] * 16.0) as usize)).collect();
            cells.sort_unstable();
            cells.dedup();
            cells.len()
        };
        assert_eq!(cells(SamplingMethod::Sobol), 256);
        assert!((140..190).contains(&cells(SamplingMethod::Random)), "256 (1 - 1/e) = 162 are to be expected");
    }

    #[test]
    fn the_seed_decides() {
        for method in [SamplingMethod::Sobol, SamplingMethod::Random] {
            let draw = |seed| Sampling { method, count: 10, seed }.draw(3).unwrap();
            assert_eq!(draw(1), draw(1));
            assert_ne!(draw(1), draw(2));
        }
        assert!("sobol:65537".parse::<Sampling>().unwrap_err().contains("65536"));
        assert!("halton:3".parse::<Sampling>().unwrap_err().contains("sobol:256"));
        assert!("random".parse::<Sampling>().unwrap_err().contains("number of samples"));
        assert!(Sampling { method: SamplingMethod::Sobol, count: 1, seed: 0 }.draw(257).is_err());
    }
}
