//! Files that appear complete or not at all.

use super::WriteError;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why an output could not be put in place.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct OutputError {
    /// The file that was asked for.
    pub path: PathBuf,
    /// What the writer or the system says.
    pub source: WriteError,
}

/// Several output files that are all written under temporary names first, and then all renamed.
///
/// Dropped without [`Outputs::commit`], it removes the temporary files and leaves older files as they were. When the bytes reach
/// the disk is left to the system: that no program which fails or is interrupted destroys an older file is promised, that no crash
/// of the machine does is not.
#[derive(Debug, Default)]
pub struct Outputs {
    pending: Vec<Pending>,
}

#[derive(Debug)]
struct Pending {
    temporary: PathBuf,
    target: PathBuf,
}

/// What a temporary name ends in.
const TEMPORARY: &str = "isopatch.tmp";
/// Bytes that are written at a time.
const BUFFER: usize = 1 << 16;
/// Temporary names that are tried: leftovers of interrupted runs take some.
const ATTEMPTS: u32 = 1000;

impl Outputs {
    /// No files yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Writes one file under a temporary name in the folder of `path`.
    ///
    /// `write` gets a buffered file.
    pub fn write(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), WriteError>,
    ) -> Result<(), OutputError> {
        let fault = |source| OutputError { path: path.to_owned(), source };
        self.write_temporary(path, write).map_err(fault)
    }

    fn write_temporary(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), WriteError>,
    ) -> Result<(), WriteError> {
        let target = replaceable(path)?;
        let (file, temporary) = create_beside(&target)?;
        // From here on, dropping `self` removes the temporary file.
        self.pending.push(Pending { temporary, target });
        let mut file = BufWriter::with_capacity(BUFFER, file);
        write(&mut file)?;
        Ok(file.flush()?)
    }

    /// Renames all files to their final names, replacing older ones.
    ///
    /// If a rename fails, the files renamed before it stay in place: each of them is complete.
    pub fn commit(mut self) -> Result<(), OutputError> {
        // Taken from the front, so that what is left behind on failure is removed by the drop.
        while !self.pending.is_empty() {
            let Pending { temporary, target } = &self.pending[0];
            fs::rename(temporary, target)
                .map_err(|e| OutputError { path: target.clone(), source: e.into() })?;
            self.pending.remove(0);
        }
        Ok(())
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for pending in &self.pending {
            // Nothing more can be done about a temporary file that cannot be removed.
            let _ = fs::remove_file(&pending.temporary);
        }
    }
}

/// The file that a rename has to replace: where a link leads, because the link is to stay. Only an ordinary file can
/// be replaced: not a folder, nor a device such as /dev/null.
fn replaceable(path: &Path) -> io::Result<PathBuf> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => fs::canonicalize(path),
        Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(_) => Err(io::Error::new(io::ErrorKind::InvalidInput, "not an ordinary file")),
        Err(_) => Ok(path.to_owned()),
    }
}

/// A new file `.NAME.N.isopatch.tmp` in the folder of `path`; a rename within a folder is atomic.
fn create_beside(path: &Path) -> io::Result<(File, PathBuf)> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?.to_string_lossy();
    for attempt in 0..ATTEMPTS {
        let temporary = path.with_file_name(format!(".{name}.{attempt}.{TEMPORARY}"));
        match File::create_new(&temporary) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
            Ok(file) => return Ok((file, temporary)),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_appear_together() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "old").unwrap();
        let mut outputs = Outputs::new();
        for name in ["a", "b"] {
            outputs.write(&path(name), |f| Ok(f.write_all(b"new")?)).unwrap();
        }
        assert_eq!(fs::read(path("a")).unwrap(), b"old");
        outputs.commit().unwrap();
        assert_eq!(names(folder.path()), ["a", "b"]);
        assert_eq!(fs::read(path("a")).unwrap(), b"new");
    }

    #[test]
    fn a_failure_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "old").unwrap();
        let mut outputs = Outputs::new();
        outputs.write(&path("a"), |f| Ok(f.write_all(b"new")?)).unwrap();
        let error = outputs.write(&path("b"), |f| {
            f.write_all(b"half")?;
            Err(WriteError::InsideOut { patch: 3 })
        });
        assert!(matches!(error.unwrap_err().source, WriteError::InsideOut { patch: 3 }));
        drop(outputs);
        assert_eq!(names(folder.path()), ["a"]);
        assert_eq!(fs::read(path("a")).unwrap(), b"old");
    }

    #[test]
    fn unwritable_outputs_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no such folder").join("a.step");
        for path in [missing.as_path(), folder.path()] {
            let error = Outputs::new().write(path, |_| Ok(())).unwrap_err().to_string();
            assert!(error.starts_with(&format!("cannot write {}: ", path.display())), "{error}");
        }
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let mut outputs = Outputs::new();
        outputs.write(&link, |f| Ok(f.write_all(b"new")?)).unwrap();
        outputs.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        let error = Outputs::new().write(Path::new("/dev/null"), |_| Ok(())).unwrap_err();
        assert_eq!(error.to_string(), "cannot write /dev/null: not an ordinary file");
    }

    #[test]
    fn leftovers_of_an_interrupted_run_are_not_touched() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(".a.0.isopatch.tmp"), "other").unwrap();
        let mut outputs = Outputs::new();
        outputs.write(&folder.path().join("a"), |f| Ok(f.write_all(b"new")?)).unwrap();
        outputs.commit().unwrap();
        assert_eq!(names(folder.path()), [".a.0.isopatch.tmp", "a"]);
    }
}
