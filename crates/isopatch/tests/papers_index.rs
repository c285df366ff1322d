//! PAPERS.md names files and tests of this crate: they must exist.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

use std::path::Path;

/// The references `src/…`, `tests/…` and `examples/…` of a text that do not hold: a path that is missing, or a `path: test` whose
/// file has no such function.
fn broken(text: &str, root: &Path) -> Vec<String> {
    let quoted = text.split('`').skip(1).step_by(2);
    quoted
        .filter(|q| ["src/", "tests/", "examples/"].iter().any(|folder| q.starts_with(folder)))
        .filter(|q| {
            let (path, test) = q.split_once(": ").map_or((*q, None), |(path, test)| (path, Some(test)));
            let path = root.join(path);
            let holds = match test {
                Some(test) => {
                    std::fs::read_to_string(&path).is_ok_and(|s| s.contains(&format!("fn {test}(")))
                }
                None => path.exists(),
            };
            !holds
        })
        .map(str::to_owned)
        .collect()
}

#[test]
fn files_and_tests_of_the_index_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../../PAPERS.md")).unwrap();
    assert!(text.contains("`tests/golden_spline.rs: "), "the index has lost its form");
    let broken = broken(&text, root);
    assert!(broken.is_empty(), "PAPERS.md names what is not there:\n{}", broken.join("\n"));
}

#[test]
fn broken_references_are_seen() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = "`src/lib.rs` `src/nothing.rs` `examples/none.rs` `tests/papers_index.rs: broken` `tests/papers_index.rs: absent` `models/`";
    assert_eq!(broken(text, root), ["src/nothing.rs", "examples/none.rs", "tests/papers_index.rs: absent"]);
}
