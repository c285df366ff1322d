//! Every crate that isopatch is built or tested with has a licence of [`ALLOWED`] (no GPL, LGPL or AGPL).
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

use serde_json::Value;
use std::process::Command;

/// Identifiers of the SPDX list. A crate under a choice of licences needs one of them, under a conjunction all.
const ALLOWED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MPL-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// expression = term {"OR" term}, term = factor {"AND" factor}, factor = "(" expression ")" | licence ["WITH" exception].
struct Expression<'a> {
    words: Vec<&'a str>,
    next: usize,
}

impl<'a> Expression<'a> {
    fn take(&mut self, word: &str) -> bool {
        let found = self.words.get(self.next).is_some_and(|w| *w == word);
        self.next += usize::from(found);
        found
    }

    fn any(&mut self) -> Option<bool> {
        let mut allowed = self.all()?;
        while self.take("OR") {
            allowed |= self.all()?;
        }
        Some(allowed)
    }

    fn all(&mut self) -> Option<bool> {
        let mut allowed = self.factor()?;
        while self.take("AND") {
            allowed &= self.factor()?;
        }
        Some(allowed)
    }

    fn factor(&mut self) -> Option<bool> {
        if self.take("(") {
            let allowed = self.any()?;
            return self.take(")").then_some(allowed);
        }
        let licence = *self.words.get(self.next)?;
        self.next += 1;
        // An exception only adds permissions.
        if self.take("WITH") {
            self.next += 1;
        }
        Some(ALLOWED.contains(&licence))
    }
}

/// Is the SPDX expression satisfied by allowed licences? False as well if it is malformed. A slash is the old "OR".
fn is_allowed(expression: &str) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let mut parser = Expression { words: spaced.split_whitespace().collect(), next: 0 };
    parser.any() == Some(true) && parser.next == parser.words.len()
}

/// What cargo knows of the dependency graph: of every platform in CI, elsewhere of this one, whose crates are there.
fn metadata() -> Value {
    let mut command = Command::new(env!("CARGO"));
    command.args(["metadata", "--format-version", "1"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("CI").is_none() {
        let version = Command::new("rustc").arg("-vV").output().unwrap();
        let version = String::from_utf8(version.stdout).unwrap();
        let host = version.lines().find_map(|l| l.strip_prefix("host: ")).unwrap();
        command.args(["--filter-platform", host]);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn every_dependency_has_an_allowed_licence() {
    let metadata = metadata();
    let used: Vec<&Value> =
        metadata["resolve"]["nodes"].as_array().unwrap().iter().map(|n| &n["id"]).collect();
    let packages: Vec<&Value> =
        metadata["packages"].as_array().unwrap().iter().filter(|p| used.contains(&&p["id"])).collect();
    assert!(packages.iter().any(|p| p["name"] == "nalgebra"), "the graph lacks a direct dependency");
    let refused: Vec<String> = packages
        .iter()
        .filter(|p| !p["license"].as_str().is_some_and(is_allowed))
        .map(|p| format!("{} {}: {}", p["name"], p["version"], p["license"]))
        .collect();
    assert!(refused.is_empty(), "licences that are not on the list:\n{}", refused.join("\n"));
}

#[test]
fn expressions_are_evaluated() {
    for good in [
        "MIT",
        "MIT OR GPL-3.0-only",
        "Unlicense/MIT",
        "(MIT OR Apache-2.0) AND Unicode-3.0",
        "Apache-2.0 WITH LLVM-exception OR LGPL-2.1-or-later",
    ] {
        assert!(is_allowed(good), "{good}");
    }
    for bad in [
        "GPL-3.0-only",
        "MIT AND AGPL-3.0-only",
        "(MIT OR Apache-2.0) AND LGPL-3.0-only",
        "",
        "MIT OR",
        "(MIT",
    ] {
        assert!(!is_allowed(bad), "{bad}");
    }
}
