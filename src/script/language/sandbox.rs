//! Read access of a script: files below its own folder and below the folders the user named.
//!
//! Paths are made canonical before they are compared, so that `..` and symbolic links do not lead outside. Write access is limited by
//! [`RunFiles`](crate::output::RunFiles).

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::causes;
use super::failure::Failure;
use super::wording::did_you_mean;
use crate::output::Inputs;

/// Folders of a run.
#[derive(Clone, Debug)]
pub struct Sandbox {
    home: PathBuf,
    readable: Vec<PathBuf>,
    /// Files that were read.
    read: RefCell<BTreeSet<PathBuf>>,
    /// Files that were read, and all scripts.
    inputs: Inputs,
}

impl Sandbox {
    /// A sandbox around the folder of a script.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn new(home: &Path, allowed: &[PathBuf]) -> Result<Self, Failure> {
        let home = if home.as_os_str().is_empty() { Path::new(".") } else { home };
        let canonical = |folder: &Path| {
            folder.canonicalize().map_err(|error| {
                Failure::script(format!("the folder {} cannot be opened", folder.display()))
                    .code(causes::FILE)
                    .cause(reason(&error))
                    .hint("name an existing folder")
            })
        };
        let readable = allowed.iter().map(|folder| canonical(folder)).collect::<Result<_, _>>()?;
        Ok(Sandbox { home: canonical(home)?, readable, read: RefCell::default(), inputs: Inputs::default() })
    }

    /// The folder of the script.
    pub fn home(&self) -> &Path {
        &self.home
    }

    /// Files that the script has requested and may read.
    pub(crate) fn files_read(&self) -> Vec<PathBuf> {
        self.read.borrow().iter().cloned().collect()
    }

    /// Notes a file that was read for the script elsewhere.
    pub fn note(&self, file: PathBuf) {
        self.inputs.add(&file);
        self.read.borrow_mut().insert(file);
    }

    /// All files that are read, so that no result takes their place.
    pub fn inputs(&self) -> Inputs {
        self.inputs.clone()
    }

    /// Returns the file at a path of a script: below its own folder first, then below the working folder and the allowed folders.
    ///
    /// # Errors
    /// The file does not exist, or the script may not read it.
    pub(crate) fn readable(&self, path: &str) -> Result<PathBuf, Failure> {
        let given = Path::new(path);
        let bases = [self.home.clone(), PathBuf::from(".")].into_iter().chain(self.readable.iter().cloned());
        let found: Vec<PathBuf> = bases.filter_map(|base| base.join(given).canonicalize().ok()).filter(|file| file.is_file()).collect();
        let allowed = |file: &PathBuf| std::iter::once(&self.home).chain(&self.readable).any(|folder| file.starts_with(folder));
        if let Some(file) = found.iter().find(|file| allowed(file)) {
            self.note(file.clone());
            return Ok(file.clone());
        }
        Err(match found.first() {
            Some(file) => {
                let folder = file.parent().unwrap_or(file);
                Failure::script(format!("the script may not read \"{path}\""))
                    .code("C0941")
                    .cause("a script reads files below its own folder and below the folders that `--allow-read` names")
                    .hint(format!("allow it with `--allow-read {}`", folder.display()))
            }
            None => {
                let looked = given.parent().filter(|parent| !parent.as_os_str().is_empty());
                let folder = looked.map_or(self.home.clone(), |parent| self.home.join(parent));
                let siblings = siblings(&folder, given);
                let failure = Failure::script(format!("there is no file \"{path}\""))
                    .code("C0942")
                    .cause("paths are relative to the script's folder, or absolute below a folder that `--allow-read` names");
                match siblings {
                    Some(suggestion) => failure.hint(suggestion),
                    None => failure.hint("check the path"),
                }
            }
        })
    }

    /// Returns the file of an imported module.
    ///
    /// # Errors
    /// The file does not exist, or lies outside of the script's folder.
    pub fn module(&self, path: &str) -> Result<PathBuf, Failure> {
        let file = self.home.join(format!("{path}.rhai"));
        match file.canonicalize() {
            Ok(file) if file.starts_with(&self.home) => {
                self.inputs.add(&file);
                Ok(file)
            }
            Ok(_) => Err(Failure::script(format!("the script may not import \"{path}\""))
                .code("C0943")
                .cause("modules lie below the folder of the script that was started")
                .hint("move the module into a subfolder, such as `lib`, next to the script")),
            Err(_) => {
                let folder = file.parent().unwrap_or(&self.home).to_path_buf();
                let failure = Failure::script(format!("there is no module \"{path}\""))
                    .code("C0944")
                    .cause(format!("the import means the file \"{path}.rhai\" below the script's folder"));
                Err(match siblings(&folder, Path::new(&format!("{path}.rhai"))).filter(|suggestion| suggestion.contains(".rhai")) {
                    Some(suggestion) => failure.hint(suggestion.replace(".rhai", "")),
                    None => failure.hint("write the path without the ending `.rhai`"),
                })
            }
        }
    }
}

/// Returns an error of the operating system in lower case, without its number.
pub fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}

fn siblings(folder: &Path, given: &Path) -> Option<String> {
    let name = given.file_name()?.to_string_lossy().into_owned();
    let names: Vec<String> =
        std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    did_you_mean(&name, names.iter().map(String::as_str)).map(|suggestion| suggestion.replace('`', "\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("conserva-sandbox-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("home/lib")).unwrap();
        fs::create_dir_all(folder.join("other")).unwrap();
        fs::write(folder.join("home/mesh.msh"), "").unwrap();
        fs::write(folder.join("home/lib/rings.rhai"), "").unwrap();
        fs::write(folder.join("other/secret.msh"), "").unwrap();
        fs::write(folder.join("other/secret.rhai"), "").unwrap();
        folder
    }

    #[test]
    fn reading_stays_inside() {
        let root = folder("reading");
        let home = root.join("home");
        let closed = Sandbox::new(&home, &[]).unwrap();
        assert!(closed.readable("mesh.msh").is_ok());
        assert!(closed.readable("lib/../mesh.msh").is_ok());
        assert!(closed.readable("../other/secret.msh").unwrap_err().title.contains("may not read"));
        assert!(closed.readable(root.join("other/secret.msh").to_str().unwrap()).is_err());
        std::os::unix::fs::symlink(root.join("other"), home.join("link")).unwrap();
        assert!(closed.readable("link/secret.msh").unwrap_err().title.contains("may not read"));
        assert!(closed.module("link/secret").unwrap_err().title.contains("may not import"));
        assert!(closed.module("../other/secret").is_err());
        assert!(closed.module("lib/rings").is_ok());
        assert!(closed.module("lib/ring").unwrap_err().hints[0].contains("rings"));
        assert!(closed.readable("mesh.mhs").unwrap_err().hints[0].contains("mesh.msh"));
        let open = Sandbox::new(&home, &[root.join("other")]).unwrap();
        assert!(open.readable("secret.msh").is_ok());
        assert!(open.readable(root.join("other/secret.msh").to_str().unwrap()).is_ok());
        fs::remove_dir_all(root).unwrap();
    }
}
