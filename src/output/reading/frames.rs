//! The list of a series' frames, read back.

use std::path::{Component, Path, PathBuf};

use super::error::{ReadError, bytes_of};
use super::tags::tags;

/// A frame of a series.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedFrame {
    /// Time of the frame.
    pub time: f64,
    /// Path of the frame, relative to the list.
    pub name: String,
    /// Path of the frame.
    pub path: PathBuf,
}

/// Reads the frames of a `.pvd` file.
///
/// # Errors
/// A file that cannot be read or is no list of frames.
pub fn read_frames(path: &Path) -> Result<Vec<ListedFrame>, ReadError> {
    let bytes = bytes_of(path)?;
    let text = String::from_utf8(bytes).map_err(|_| ReadError::damaged(path, "it is not text"))?;
    let tags = tags(&text);
    if !tags.iter().any(|tag| tag.name == "VTKFile" && tag.attribute("type").as_deref() == Some("Collection")) {
        return Err(ReadError::damaged(path, "it is no list of frames (`VTKFile` of the type `Collection`)"));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut frames = Vec::new();
    for tag in tags.iter().filter(|tag| tag.name == "DataSet") {
        let time = tag.attribute("timestep").and_then(|time| time.parse::<f64>().ok());
        let (Some(time), Some(name)) = (time, tag.attribute("file")) else {
            return Err(ReadError::damaged(path, format!("frame {} has no time or no file", frames.len())));
        };
        if !Path::new(&name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
            let what = format!("names a file outside of its folder: {name:?}");
            return Err(ReadError::new(path, what, "move the frames beside the list, and name them there"));
        }
        frames.push(ListedFrame { time, path: folder.join(&name), name });
    }
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::super::super::pvd::pvd;
    use super::super::super::samples::scratch;
    use super::*;

    #[test]
    fn a_list_reads_back() {
        let (directory, files) = scratch("frames");
        files.write("fields.pvd", pvd([(0.0, "fields/a.vtu"), (0.1 + 0.2, "a&\"b\"/x.vtu")])).unwrap();
        let frames = read_frames(&directory.join("fields.pvd")).unwrap();
        assert_eq!(
            frames.iter().map(|frame| (frame.time, frame.name.as_str())).collect::<Vec<_>>(),
            [(0.0, "fields/a.vtu"), (0.1 + 0.2, "a&\"b\"/x.vtu")]
        );
        assert_eq!(frames[0].path, directory.join("fields/a.vtu"));
        files.write("fields.pvd", "<VTKFile type=\"Collection\"><DataSet timestep=\"x\"/>").unwrap();
        assert!(read_frames(&directory.join("fields.pvd")).unwrap_err().to_string().contains("frame 0 has no time"));
        files.write("fields.pvd", "step,time\n").unwrap();
        assert!(read_frames(&directory.join("fields.pvd")).unwrap_err().to_string().contains("no list of frames"));
    }
}
