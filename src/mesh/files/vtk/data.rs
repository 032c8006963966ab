//! Numbers of a data array of VTK's XML files: as text, as base64, or as appended bytes; plain or in zlib blocks.

use std::io::Read as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

/// Number types of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    Signed(usize),
    Unsigned(usize),
    Real(usize),
}

impl Scalar {
    /// Type of a name in XML files, such as `Int32`.
    pub fn of_name(name: &str) -> Option<Scalar> {
        let (family, bits) = name.split_at(name.find(|c: char| c.is_ascii_digit())?);
        let bytes = match bits {
            "8" => 1,
            "16" => 2,
            "32" => 4,
            "64" => 8,
            _ => return None,
        };
        match family {
            "Int" => Some(Scalar::Signed(bytes)),
            "UInt" => Some(Scalar::Unsigned(bytes)),
            "Float" if bytes >= 4 => Some(Scalar::Real(bytes)),
            _ => None,
        }
    }

    /// Number of bytes.
    pub fn bytes(self) -> usize {
        match self {
            Scalar::Signed(bytes) | Scalar::Unsigned(bytes) | Scalar::Real(bytes) => bytes,
        }
    }

    /// True for whole numbers.
    pub fn is_whole(self) -> bool {
        !matches!(self, Scalar::Real(_))
    }
}

/// Numbers of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    Reals(Vec<f64>),
    Whole(Vec<i64>),
}

impl Numbers {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Numbers::Reals(values) => values.len(),
            Numbers::Whole(values) => values.len(),
        }
    }

    /// Values as real numbers.
    pub fn reals(self) -> Vec<f64> {
        match self {
            Numbers::Reals(values) => values,
            Numbers::Whole(values) => values.into_iter().map(|value| value as f64).collect(),
        }
    }

    /// Values as whole numbers; `None` if one is not.
    pub fn whole(self) -> Option<Vec<i64>> {
        match self {
            Numbers::Whole(values) => Some(values),
            Numbers::Reals(values) => values.into_iter().map(|value| (value as i64 as f64 == value).then_some(value as i64)).collect(),
        }
    }
}

/// Layout of the bytes of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// True if the least byte of a number comes first.
    pub is_little: bool,
    /// Size of the numbers that give the length of data `[bytes]`.
    pub header: usize,
    /// True for data in zlib blocks.
    pub is_compressed: bool,
}

/// Numbers from words of text.
pub(super) fn of_text(text: &str, scalar: Scalar) -> Result<Numbers, String> {
    let wrong = |word: &str| format!("\"{}\" is no number of its type", super::super::text::shortened(word));
    if scalar.is_whole() {
        text.split_ascii_whitespace().map(|word| word.parse().map_err(|_| wrong(word))).collect::<Result<_, _>>().map(Numbers::Whole)
    } else {
        text.split_ascii_whitespace().map(|word| word.parse().map_err(|_| wrong(word))).collect::<Result<_, _>>().map(Numbers::Reals)
    }
}

/// Numbers from bytes.
pub(super) fn of_bytes(bytes: &[u8], scalar: Scalar, is_little: bool) -> Result<Numbers, String> {
    let size = scalar.bytes();
    if !bytes.len().is_multiple_of(size) {
        return Err(format!("{} bytes are no whole count of numbers with {size} bytes", bytes.len()));
    }
    let word = |chunk: &[u8]| {
        let mut wide = [0; 8];
        wide[..size].copy_from_slice(chunk);
        if !is_little {
            wide[..size].reverse();
        }
        u64::from_le_bytes(wide)
    };
    let words = bytes.chunks_exact(size).map(word);
    Ok(match scalar {
        Scalar::Real(4) => Numbers::Reals(words.map(|word| f64::from(f32::from_bits(word as u32))).collect()),
        Scalar::Real(_) => Numbers::Reals(words.map(f64::from_bits).collect()),
        Scalar::Unsigned(_) => Numbers::Whole(words.map(|word| word as i64).collect()),
        Scalar::Signed(_) => {
            let shift = 64 - 8 * size as u32;
            Numbers::Whole(words.map(|word| ((word << shift) as i64) >> shift).collect())
        }
    })
}

/// Bytes of base64 text, which may consist of several consecutive pieces, each with its padding.
pub(super) fn of_base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let clean: Vec<u8> = text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let mut bytes = Vec::with_capacity(clean.len() / 4 * 3);
    let mut rest = &clean[..];
    while !rest.is_empty() {
        let filling = rest.iter().position(|&byte| byte == b'=').unwrap_or(rest.len());
        // A piece has at least four characters; otherwise padding without text would cause an endless loop.
        let end = filling.div_ceil(4).max(1).saturating_mul(4).min(rest.len());
        STANDARD.decode_vec(&rest[..end], &mut bytes).map_err(|error| format!("it is no base64 text: {error}"))?;
        rest = &rest[end..];
    }
    Ok(bytes)
}

/// Data without their header, unpacked.
pub(super) fn unpacked(data: &[u8], layout: Layout) -> Result<Vec<u8>, String> {
    let cut = || "the data end too early".to_string();
    let word = |index: usize| {
        let bytes = data.get(index * layout.header..(index + 1) * layout.header).ok_or_else(cut)?;
        let number = of_bytes(bytes, Scalar::Unsigned(layout.header), layout.is_little)?.whole().unwrap_or_default();
        number.first().and_then(|&number| usize::try_from(number).ok()).ok_or_else(cut)
    };
    if !layout.is_compressed {
        let end = word(0)?.checked_add(layout.header).ok_or_else(cut)?;
        return data.get(layout.header..end).map(<[u8]>::to_vec).ok_or_else(cut);
    }
    let (count, size, last) = (word(0)?, word(1)?, word(2)?);
    let mut at = count.checked_add(3).and_then(|words| words.checked_mul(layout.header)).ok_or_else(cut)?;
    let mut bytes = Vec::new();
    for block in 0..count {
        let end = at.checked_add(word(3 + block)?).ok_or_else(cut)?;
        let packed = data.get(at..end).ok_or_else(cut)?;
        let length = if block + 1 == count && last > 0 { last } else { size };
        let before = bytes.len();
        // Reading one byte beyond the announced length detects a block that is too long.
        let unpacking = ZlibDecoder::new(packed).take(length as u64 + 1).read_to_end(&mut bytes);
        unpacking.map_err(|error| format!("a compressed block is damaged: {error}"))?;
        if bytes.len() - before != length {
            return Err("a compressed block has another length than announced".into());
        }
        at = end;
    }
    Ok(bytes)
}
