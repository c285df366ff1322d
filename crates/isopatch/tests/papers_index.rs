//! PAPERS.md names files and tests of this crate, which must exist, and has a line for every numbered item of the four papers.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

use std::collections::BTreeSet;
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

/// The numbered items of a paper.
struct Paper {
    /// The heading of its part of PAPERS.md.
    heading: &'static str,
    /// Kind, and numbers: single ones, or the first and the last of some.
    items: &'static [(&'static str, &'static [&'static str])],
}

/// The kind of equations; the others are words of the text.
const EQUATION: &str = "equation";

const PAPERS: [Paper; 4] = [
    Paper {
        heading: "## Tong & Kim 2009",
        items: &[
            (EQUATION, &["1-8", "9a", "9b", "10-26", "B.1"]),
            ("Table", &["1-3"]),
            ("Fig", &["1-15"]),
            ("Algorithm", &["5.1"]),
            ("Appendix", &["A", "B", "C", "D"]),
        ],
    },
    Paper {
        heading: "## Xu, Huang & Bajaj 2001",
        items: &[
            (EQUATION, &["2.1-2.3", "3.1", "4.1-4.21"]),
            ("Lemma", &["2.1-2.3"]),
            ("Theorem", &["4.1-4.2"]),
            ("Corollary", &["4.3"]),
            ("Step", &["1-10"]),
            ("Fig", &["1-17"]),
            ("Appendix", &["A"]),
        ],
    },
    Paper {
        heading: "## Xu, Bajaj & Evans",
        items: &[
            (EQUATION, &["2.1-2.15", "4.1-4.14", "5.1-5.4", "7.1-7.8"]),
            ("Lemma", &["2.1"]),
            ("Theorem", &["2.1-2.3", "4.1-4.2"]),
            ("Corollary", &["2.1-2.2"]),
            ("Sub-algorithm", &["1-4"]),
            ("Fig", &["1.1", "2.1-2.2", "3.1", "4.1-4.2", "6.1-6.3"]),
        ],
    },
    Paper {
        heading: "## Bajaj & Xu 1997",
        items: &[
            (EQUATION, &["3.1-3.2", "5.1-5.14", "6.1-6.13"]),
            ("Lemma", &["5.1-5.2", "6.1"]),
            ("Theorem", &["5.3"]),
            ("Problem", &["1-3"]),
            ("Algorithm", &["1-2"]),
            ("Fig", &["1-7"]),
        ],
    },
];

/// Numbers from `first` to `last`, which differ in what follows the last dot; `first` alone if they are not like this.
fn between(first: &str, last: &str) -> Vec<String> {
    let split = |number: &str| {
        let at = number.rfind('.').map_or(0, |dot| dot + 1);
        Some((number[..at].to_owned(), number[at..].parse::<u32>().ok()?))
    };
    match (split(first), split(last)) {
        (Some((head, a)), Some((same, b))) if head == same => (a..=b).map(|n| format!("{head}{n}")).collect(),
        _ => vec![first.to_owned()],
    }
}

/// The number at the start of a text, such as 4, 5.14, 9a or B.1, and what follows it.
fn number(text: &str) -> Option<(&str, &str)> {
    let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '.')).unwrap_or(text.len());
    let found = text[..end].trim_end_matches('.');
    let is_number =
        found.starts_with(|c: char| c.is_ascii_digit()) || found.len() == 1 || found.starts_with("B.");
    (is_number && found.starts_with(|c: char| c.is_ascii_digit() || c.is_ascii_uppercase()))
        .then(|| (found, &text[found.len()..]))
}

/// The numbers of a list such as "4", "1.1, 6.1 to 6.3", "9–15 and 17" at the start of a text.
fn numbers(text: &str) -> Vec<String> {
    let (mut found, mut rest) = (Vec::new(), text.trim_start());
    while let Some((first, after)) = number(rest) {
        let range = ["–", " to "].iter().find_map(|word| number(after.strip_prefix(word)?));
        let after = match range {
            Some((last, after)) => {
                found.extend(between(first, last));
                after
            }
            None => {
                found.push(first.to_owned());
                after
            }
        };
        match [", ", " and "].iter().find_map(|word| after.strip_prefix(word)) {
            Some(next) => rest = next,
            None => break,
        }
    }
    found
}

/// The items of a kind that a text names.
fn named(text: &str, kind: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    if kind == EQUATION {
        // "(4.1)" and "(4.1) to (4.17)".
        for (at, _) in text.match_indices('(') {
            let Some((first, after)) = number(&text[at + 1..]) else { continue };
            let Some(after) = after.strip_prefix(')') else { continue };
            found.insert(first.to_owned());
            let range = ["–(", " to ("].iter().find_map(|word| number(after.strip_prefix(word)?));
            found.extend(range.into_iter().flat_map(|(last, _)| between(first, last)));
        }
        return found;
    }
    // "Lemma 2.1", "Lemmas 2.1, 2.2", "Corollaries 2.1", "Figs. 2 to 4", "appendices".
    let stem = kind.trim_end_matches('y').trim_end_matches("ix").to_lowercase();
    let lower = text.to_lowercase();
    assert_eq!(lower.len(), text.len(), "letters whose case has another length");
    for (at, _) in lower.match_indices(&stem) {
        let after = &text[at..];
        if let Some(space) = after.find(' ').filter(|space| after[..*space].is_ascii()) {
            found.extend(numbers(&after[space..]));
        }
    }
    found
}

/// The text under a heading, to the next of its level.
fn part<'a>(text: &'a str, heading: &str) -> &'a str {
    let start = text.find(heading).unwrap_or_else(|| panic!("no {heading}")) + heading.len();
    let end = text[start..].find("\n## ").map_or(text.len(), |end| start + end);
    &text[start..end]
}

#[test]
fn every_numbered_item_of_the_papers_has_a_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../../PAPERS.md")).unwrap();
    let mut missing = Vec::new();
    for Paper { heading, items } in PAPERS {
        // Prose may name an item without saying where it is; a row of a table says so, or why it is not done.
        let rows = part(&text, heading).lines().filter_map(|line| line.strip_prefix('|')?.split_once(" | "));
        let tells = |cells: &str| cells.contains('`') || cells.contains("because");
        let first_cells: Vec<&str> = rows.filter(|(_, cells)| tells(cells)).map(|(first, _)| first).collect();
        for (kind, ranges) in items {
            let named: BTreeSet<String> = first_cells.iter().flat_map(|cell| named(cell, kind)).collect();
            for range in *ranges {
                let (first, last) = range.split_once('-').unwrap_or((range, range));
                let wanted = between(first, last);
                missing.extend(
                    wanted.iter().filter(|n| !named.contains(*n)).map(|n| format!("{heading}: {kind} {n}")),
                );
            }
        }
    }
    assert!(missing.is_empty(), "PAPERS.md has no line for\n{}", missing.join("\n"));
}

#[test]
fn ranges_and_lists_are_read() {
    let all = |text: &str, kind: &str| named(text, kind).into_iter().collect::<Vec<_>>().join(" ");
    assert_eq!(all("Figs. 9–11 and 13 of it, Fig. 2", "Fig"), "10 11 13 2 9");
    assert_eq!(all("(4.9) to (4.11), (9a), (B.1), (a), (see 5.1)", EQUATION), "4.10 4.11 4.9 9a B.1");
    assert_eq!(all("Corollary 2.1, Corollaries 2.2 and 2.4", "Corollary"), "2.1 2.2 2.4");
    assert_eq!(all("Appendix A; Appendices C, D", "Appendix"), "A C D");
    assert_eq!(all("Steps 1 to 3; Sub-algorithms 2 to 4", "Step"), "1 2 3");
    assert_eq!(all("Lemma 5.1", "Theorem"), "");
}
