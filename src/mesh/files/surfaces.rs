//! Surfaces of triangles from files: STL, as text or binary, and Wavefront OBJ.
//!
//! STL: each triangle has three points, whose order determines its orientation, and a normal that is ignored. OBJ: lines `v x y z` and
//! `f a b c …`, whose polygons are divided into fans; textures, normals, groups and other data are left out.

use std::path::Path;

use super::text::{shortened, utf8};
use crate::machine::files;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Size of the header of a binary STL file with the number of triangles `[bytes]`.
const STL_HEAD: usize = 84;
/// Size of a triangle in a binary STL file `[bytes]`.
const STL_TRIANGLE: usize = 50;

/// Points `[length]` and triangles of a surface.
pub type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Reads an STL or OBJ file; see [`read_surface_bytes`].
///
/// # Errors
/// A file that cannot be read, and all that [`read_surface_bytes`] refuses.
pub fn read_surface(path: impl AsRef<Path>) -> Result<Triangles, MeshError> {
    let path = path.as_ref();
    match files::read(path) {
        Ok(content) => read_surface_bytes(&content),
        Err(error) => fail(FilePosition::Line(1), FileProblem::Unreadable { path: path.into(), reason: error.to_string() }),
    }
}

/// Triangles of the content of a file, whose format is recognized from the content.
///
/// # Errors
/// Another format, malformed content, a file that ends early, references to missing points.
pub fn read_surface_bytes(content: &[u8]) -> Result<Triangles, MeshError> {
    // A binary file may begin like a text file: its length follows from the number of triangles.
    if let Some(count) = binary_count(content) {
        return Ok(binary_stl(content, count));
    }
    let text = utf8(content)?;
    if text.trim_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case("solid")) {
        text_stl(text)
    } else if text.lines().any(|line| line.starts_with("v ")) {
        obj(text)
    } else {
        let problem = FileProblem::Malformed { expected: "an STL or OBJ file", found: shortened(text.lines().next().unwrap_or("")) };
        fail(FilePosition::Line(1), problem)
    }
}

fn fail<T>(at: FilePosition, problem: FileProblem) -> Result<T, MeshError> {
    Err(FileError { at, problem }.into())
}

/// Number of triangles of a binary STL file, if the length of the file agrees with it.
fn binary_count(content: &[u8]) -> Option<usize> {
    let count = u32::from_le_bytes(content.get(STL_HEAD - 4..STL_HEAD)?.try_into().ok()?) as usize;
    (content.len() == STL_HEAD + STL_TRIANGLE * count).then_some(count)
}

fn binary_stl(content: &[u8], count: usize) -> Triangles {
    let of_triangle = |bytes: &[u8]| -> Vec<[f64; 3]> {
        let number = |k: usize| f64::from(f32::from_le_bytes([bytes[k], bytes[k + 1], bytes[k + 2], bytes[k + 3]]));
        (1..4).map(|corner| std::array::from_fn(|i| number(12 * corner + 4 * i))).collect()
    };
    let points = content[STL_HEAD..].chunks_exact(STL_TRIANGLE).flat_map(of_triangle).collect();
    (points, (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())
}

/// Three numbers at the beginning of the words.
fn point<'a>(words: impl Iterator<Item = &'a str>, line: usize) -> Result<[f64; 3], MeshError> {
    let (mut point, mut count) = ([0.0; 3], 0);
    for (x, word) in point.iter_mut().zip(words) {
        let Ok(value) = word.parse() else {
            return fail(FilePosition::Line(line), FileProblem::Malformed { expected: "a number", found: shortened(word) });
        };
        (*x, count) = (value, count + 1);
    }
    if count == 3 {
        Ok(point)
    } else {
        fail(FilePosition::Line(line), FileProblem::Malformed { expected: "3 coordinates", found: format!("{count} of them") })
    }
}

fn text_stl(text: &str) -> Result<Triangles, MeshError> {
    let mut points = Vec::new();
    let mut last = 1;
    for (line, words) in text.lines().map(str::split_ascii_whitespace).enumerate().map(|(index, words)| (index + 1, words)) {
        let mut words = words;
        let Some(first) = words.next() else { continue };
        last = line;
        if first.eq_ignore_ascii_case("vertex") {
            points.push(point(words, line)?);
        } else if first.eq_ignore_ascii_case("endfacet") && points.len() % 3 != 0 {
            let found = format!("a facet of {} points", points.len() % 3);
            return fail(FilePosition::Line(line), FileProblem::Malformed { expected: "facets of 3 points", found });
        }
    }
    if points.len() % 3 != 0 {
        return fail(
            FilePosition::Line(last),
            FileProblem::Malformed { expected: "facets of 3 points", found: "the end of the file".into() },
        );
    }
    let count = points.len() as u32 / 3;
    Ok((points, (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect()))
}

fn obj(text: &str) -> Result<Triangles, MeshError> {
    let (mut points, mut triangles): Triangles = Default::default();
    for (index, content) in text.lines().enumerate() {
        let (line, mut words) = (index + 1, content.split_ascii_whitespace());
        match words.next() {
            Some("v") => points.push(point(words, line)?),
            Some("f") => {
                let mut corners = Vec::new();
                for word in words {
                    let number: Option<i64> = word.split('/').next().and_then(|number| number.parse().ok());
                    // Points are counted from 1, or backwards from the last point by negative numbers.
                    let place = number.map(|number| if number < 0 { points.len() as i64 + number } else { number - 1 });
                    match place {
                        Some(place) if (0..points.len() as i64).contains(&place) => corners.push(place as u32),
                        _ => {
                            let found = shortened(word);
                            return fail(FilePosition::Line(line), FileProblem::Malformed { expected: "the number of a point", found });
                        }
                    }
                }
                if corners.len() < 3 {
                    let found = format!("{} of them", corners.len());
                    return fail(FilePosition::Line(line), FileProblem::Malformed { expected: "3 points of a face or more", found });
                }
                triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            }
            _ => {}
        }
    }
    Ok((points, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid one\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1e0 0.5\n  endloop\n \
                        endfacet\nendsolid one\n";

    #[test]
    fn the_same_triangle_in_three_formats() {
        let expected = (vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]], vec![[0, 1, 2]]);
        assert_eq!(read_surface_bytes(TEXT.as_bytes()).unwrap(), expected);
        // Binary file whose header begins like a text file.
        let mut binary = b"solid".to_vec();
        binary.resize(80, b' ');
        binary.extend(1_u32.to_le_bytes());
        let numbers = [0.0_f32, 0.0, 1.0].into_iter().chain(expected.0.iter().flatten().map(|&x| x as f32));
        binary.extend(numbers.flat_map(f32::to_le_bytes));
        binary.extend([0, 0]);
        assert_eq!(read_surface_bytes(&binary).unwrap(), expected);
        let obj = "# one\nv 0 0 0\nv 1 0 0\nv 0 1 0.5\nvn 0 0 1\nf 1/1/1 2//1 -1\n";
        assert_eq!(read_surface_bytes(obj.as_bytes()).unwrap(), expected);
        let quad = read_surface_bytes(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
        assert_eq!(quad.1, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let told = |content: &str| read_surface_bytes(content.as_bytes()).unwrap_err();
        assert_eq!(told(&TEXT.replace("1e0", "one")).place(), Some(FilePosition::Line(6)));
        assert_eq!(told(&TEXT.replace("   vertex 1 0 0\n", "")).place(), Some(FilePosition::Line(7)));
        assert!(told("v 0 0 0\nf 1 2 3\n").to_string().contains("number of a point"));
        assert_eq!(told("v 0 0\n").place(), Some(FilePosition::Line(1)));
        assert!(told("ply\n").to_string().contains("STL or OBJ"));
        assert!(told("").to_string().contains("STL or OBJ"));
    }
}
