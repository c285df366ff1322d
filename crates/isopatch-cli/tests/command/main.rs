//! The program as its users see it: exit status, messages, files.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod bad_input;
mod files;
mod guide;
mod interrupt;
mod listing;
mod meshes;
mod options;
mod render;
mod sheets;
mod singular;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What an older file contains; no failed run may change it.
const OLDER: &str = "older";

/// A folder of its own, with an older output file in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::write(folder.path("older.step"), OLDER).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program, to be run in the folder.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_isopatch"));
        command.args(arguments).current_dir(self.0.path());
        command
    }

    fn run(&self, arguments: &[&str]) -> Run {
        Run::new(self.command(arguments).output().unwrap())
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Nothing but the older file is there, and it is as it was.
    #[track_caller]
    fn assert_untouched(&self) {
        assert_eq!(self.names(), ["older.step"]);
        assert_eq!(fs::read_to_string(self.path("older.step")).unwrap(), OLDER);
    }
}

/// How a run ended.
struct Run {
    status: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Run {
    fn new(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    #[track_caller]
    fn assert_done(&self) {
        assert_eq!((self.status, self.stderr.as_str()), (Some(0), ""));
    }

    /// Ended with this status and a message that has all the words; nothing on stdout.
    #[track_caller]
    fn assert_fails(&self, status: i32, words: &[&str]) {
        assert_eq!(self.status, Some(status), "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "\"{word}\" is not in: {}", self.stderr);
        }
        assert!(self.stderr.starts_with("error: "), "{}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert_eq!(self.stdout, "");
    }
}

/// Runs `fit INPUT … -o older.step` where the older file must survive, and a message with all the words comes.
#[track_caller]
fn assert_fit_fails(arguments: &[&str], status: i32, words: &[&str]) {
    let folder = Folder::new();
    let line = [&["fit"], arguments, &["-o", "older.step"]].concat();
    folder.run(&line).assert_fails(status, words);
    folder.assert_untouched();
}

/// A JSON report in the folder.
fn report(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(folder.path(name)).unwrap()).unwrap()
}

/// The folder of test data that is not in the repository.
fn data_folder() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    std::env::var_os("ISOPATCH_TEST_DATA").map_or(beside, PathBuf::from)
}

/// A file of the folder `models`.
fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(name)
}
