//! Ctrl-C.
#![cfg(unix)]

use super::{Folder, Run};
use std::process::{Command, Stdio};
use std::time::Duration;

#[test]
fn ctrl_c_ends_the_work_and_leaves_older_files_alone() {
    let folder = Folder::new();
    let mut command = folder.command(&["fit", "decocube", "--faces", "200000", "-o", "older.step"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Long enough to be at work, far too short for so many patches.
    std::thread::sleep(Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let run = Run::new(child.wait_with_output().unwrap());
    assert_eq!(run.status, Some(130), "{}", run.stderr);
    assert_eq!((run.stderr.as_str(), run.stdout.as_str()), ("", ""));
    folder.assert_untouched();
}
