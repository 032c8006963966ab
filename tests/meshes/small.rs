//! Small handmade mesh files, one for each construct. Comments in the files state the expected content in lines `expect: …`.
//!
//! `cells N KIND`, `nodes N`, `measure X`, `box X Y Z to X Y Z`; `part NAME CELLS` and `boundary NAME FACETS NODES MEASURE` for all parts
//! and boundaries; `note TEXT` for all changes made by the reader; `error LINE TEXT` with `in FILE` for an error in an included file;
//! `deck NAME CELLS MEASURE`, `held PART BOUNDARY`, `contact PART.BOUNDARY PART.BOUNDARY` and `decknote TEXT` for the file read as a deck;
//! `option plane` (shells are read as plane cells) and `option skip` (elements that are no cells are refused).

use std::path::{Path, PathBuf};

use conserva::mesh::{
    Deck, DeckBoundary, FileNote, MESH_ENDINGS, Mesh, MeshError, ReadOptions, Shells, Structural, read_deck, read_mesh_with,
};

const CLOSE: f64 = 1e-12;

struct Case {
    path: PathBuf,
    /// First word and rest of each line.
    expected: Vec<(String, String)>,
}

impl Case {
    fn new(path: PathBuf) -> Case {
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"));
        let lines =
            text.lines().map(|line| line.trim_start_matches(['*', ' ', '#', '%', '$', '<', '!', '-']).trim_end_matches("-->").trim_end());
        let lines = lines.filter_map(|line| line.strip_prefix("expect: "));
        let expected = lines.map(|line| line.split_once(' ').map_or((line, ""), |(word, rest)| (word, rest)));
        Case { path, expected: expected.map(|(word, rest)| (word.into(), rest.into())).collect() }
    }

    fn all(&self, word: &str) -> Vec<&str> {
        self.expected.iter().filter(|(known, _)| known == word).map(|(_, rest)| rest.as_str()).collect()
    }

    fn options(&self) -> ReadOptions {
        let has = |word: &str| self.all("option").contains(&word);
        ReadOptions {
            structural: if has("skip") { Structural::Refused } else { Structural::Skipped },
            shells: if has("plane") { Shells::Plane } else { Shells::Refused },
            part: self.all("option").iter().find_map(|option| option.strip_prefix("part ")).map(String::from),
        }
    }

    /// Finds included files as `read_mesh` does: in the folder and below.
    fn find(&self, name: &str) -> Result<PathBuf, String> {
        let folder = self.path.parent().unwrap().canonicalize().unwrap();
        let file = folder.join(name).canonicalize().map_err(|error| error.to_string())?;
        if file.starts_with(&folder) { Ok(file) } else { Err("it is not below the folder of the file that includes it".into()) }
    }

    fn check(&self) {
        let name = self.path.file_name().unwrap().to_string_lossy();
        match (read_mesh_with(&self.path, self.options(), Some(&|name: &str| self.find(name))), &self.all("error")[..]) {
            (Ok((mesh, notes)), []) => self.check_mesh(&mesh, &notes, &name),
            (Err(error), [expected]) => self.check_error(&error, expected, &name),
            (Ok(_), _) => panic!("{name}: read, though it should be refused"),
            (Err(error), _) => panic!("{name}: {error} ({:?})", error.place()),
        }
        if !self.all("deck").is_empty() {
            let deck = read_deck(&self.path, self.options(), Some(&|name: &str| self.find(name)));
            self.check_deck(&deck.unwrap_or_else(|error| panic!("{name}: {error}")), &name);
        }
    }

    fn check_mesh(&self, mesh: &Mesh, notes: &[FileNote], name: &str) {
        assert_eq!(mesh.defects(), [], "{name}");
        let mut found = vec![format!("cells {}", mesh.counted_cells().trim_end_matches(" cells")), format!("nodes {}", mesh.points.len())];
        found.extend(mesh.parts.iter().map(|(part, cells)| format!("part {part} {}", cells.len())));
        let listed =
            ["cells", "nodes", "part"].iter().flat_map(|word| self.all(word).into_iter().map(move |rest| format!("{word} {rest}")));
        assert_eq!(found, listed.collect::<Vec<String>>(), "{name}");
        let [measure] = self.all("measure")[..] else { panic!("{name}: no measure") };
        assert!((mesh.measure() - measure.parse::<f64>().unwrap()).abs() < CLOSE, "{name}: {}", mesh.measure());
        // boundaries in any order
        let mut boundaries = self.all("boundary");
        for boundary in &mesh.boundaries {
            let nodes = mesh.boundary_nodes(boundary).len();
            let begin = format!("{} {} {nodes} ", boundary.name, boundary.facets.len());
            let place = boundaries.iter().position(|expected| expected.starts_with(&begin));
            let expected = boundaries.remove(place.unwrap_or_else(|| panic!("{name}: {begin} is not among {boundaries:?}")));
            let measure: f64 = expected[begin.len()..].parse().unwrap_or_else(|_| panic!("{name}: {expected}"));
            assert!(
                (mesh.boundary_measure(boundary) - measure).abs() < CLOSE,
                "{name} {}: {}",
                boundary.name,
                mesh.boundary_measure(boundary)
            );
        }
        assert!(boundaries.is_empty(), "{name}: {boundaries:?} are missing");
        let expected = self.all("note");
        assert!(notes.len() == expected.len(), "{name}: {notes:?}");
        assert!(notes.iter().zip(&expected).all(|(note, text)| note.to_string().contains(text)), "{name}: {notes:?}");
        for corners in self.all("box") {
            let numbers: Vec<f64> = corners.split(' ').filter_map(|word| word.parse().ok()).collect();
            for i in 0..3 {
                let of_axis = || mesh.points.iter().map(|point| point[i]);
                let (low, high) = (of_axis().reduce(f64::min).unwrap(), of_axis().reduce(f64::max).unwrap());
                assert!((low - numbers[i]).abs() < CLOSE && (high - numbers[i + 3]).abs() < CLOSE, "{name}: {low} to {high}");
            }
        }
    }

    fn check_error(&self, error: &MeshError, expected: &str, name: &str) {
        let (line, text) = expected.split_once(' ').unwrap();
        assert_eq!(error.line(), line.parse().ok(), "{name}: {error}");
        assert!(error.to_string().contains(text), "{name}: {error}");
        assert!(!error.hint().is_empty(), "{name}");
        let file = error.included_file().and_then(Path::file_name).map(|file| file.to_string_lossy().into_owned());
        assert_eq!(file.as_deref(), self.all("in").first().copied(), "{name}: {error}");
    }

    fn check_deck(&self, deck: &Deck, name: &str) {
        let parts = self.all("deck");
        assert_eq!(parts.len(), deck.parts.len(), "{name}");
        for (part, expected) in deck.parts.iter().zip(parts) {
            let measure = expected.strip_prefix(&format!("{} {} ", part.name, part.mesh.cell_count()));
            let measure: f64 = measure.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{name}: {} for {expected}", part.name));
            assert!((part.mesh.measure() - measure).abs() < CLOSE, "{name} {}: {}", part.name, part.mesh.measure());
        }
        let held = deck.held.iter().map(|DeckBoundary { part, boundary }| format!("{part} {boundary}"));
        assert_eq!(held.collect::<Vec<String>>(), self.all("held"), "{name}");
        let place = |of: &DeckBoundary| format!("{}.{}", of.part, of.boundary);
        let pairs = deck.pairs.iter().map(|pair| format!("{} {}", place(&pair.secondary), place(&pair.primary)));
        assert_eq!(pairs.collect::<Vec<String>>(), self.all("contact"), "{name}");
        let notes: Vec<String> = deck.notes.iter().map(ToString::to_string).collect();
        assert!(self.all("decknote").iter().all(|text| notes.iter().any(|note| note.contains(text))), "{name}: {notes:?}");
    }
}

#[test]
fn each_construct_of_a_mesh_file_is_read_or_refused_as_its_file_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/small");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_mesh = |path: &PathBuf| path.extension().is_some_and(|ending| MESH_ENDINGS.iter().any(|known| ending == *known));
    let mut files: Vec<PathBuf> = entries.filter(is_mesh).collect();
    files.sort();
    assert!(files.len() >= 110);
    files.into_iter().for_each(|path| Case::new(path).check());
}
