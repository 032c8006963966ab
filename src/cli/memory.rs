//! `--memory`: limit of the memory of a command.

use clap::Args;

use crate::machine::memory;

/// The option, of every command that runs scripts.
#[derive(Args)]
pub struct MemoryArguments {
    /// Memory limit of the program (8GB, 500MB); computations that need more are refused [default: the free memory of the machine]
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub memory: Option<u64>,
}

impl MemoryArguments {
    /// Sets the limit of this process.
    pub fn apply(&self) {
        self.memory.into_iter().for_each(memory::set_limit);
    }
}

/// Parses a size in bytes, a number with its unit.
///
/// # Errors
/// The text is not of the expected form; the message describes the form.
fn size(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic()).trim_end();
    let unit = match text[digits.len()..].trim() {
        "MB" | "M" => 1e6,
        "GB" | "G" => 1e9,
        "TB" | "T" => 1e12,
        "MiB" => f64::from(1 << 20),
        "GiB" => f64::from(1 << 30),
        _ => f64::NAN,
    };
    let bytes = digits.parse::<f64>().ok().map(|count| count * unit).filter(|bytes| (LEAST..1e18).contains(bytes));
    bytes.map(|bytes| bytes as u64).ok_or_else(|| "write a size with its unit, 50MB at least: 500MB, 8GB, 1.5GiB".into())
}

/// Lower bound of the limit `[bytes]`: memory of the idle program, with a margin.
const LEAST: f64 = 5e7;

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_have_units() {
        let sizes = ["8GB", "500 MB", "1.5GiB", "2T"].map(|text| size(text).unwrap());
        assert_eq!(sizes, [8_000_000_000, 500_000_000, 1_610_612_736, 2_000_000_000_000]);
        assert!(["8", "GB", "-1GB", "1kB", "49MB", "1e30GB", "NaNGB"].iter().all(|text| size(text).is_err()));
    }
}
