//! Imports between the modules of the library go one way only (ARCHITECTURE.md): this reads the sources and says so.
//!
//! A module may use what stands below it in [`BELOW`], directly or through others. Paths are found where they are
//! written out, in `use` trees and in expressions; code under `#[cfg(test)]` is free to use anything.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

/// Every module of the crate with the modules right below it. Those that are planned have their place as well.
const BELOW: &[(&str, &[&str])] = &[
    ("parallel", &[]),
    ("geom", &[]),
    ("numeric", &["geom", "parallel"]),
    ("bernstein", &["numeric"]),
    ("field", &["bernstein"]),
    ("expand", &["field"]),
    ("mesh", &["bernstein"]),
    ("surface", &["field", "mesh"]),
    ("base", &["surface"]),
    ("singular", &["base", "expand"]),
    ("hull", &["base"]),
    ("apatch", &["hull"]),
    ("hybrid", &["apatch"]),
    ("network", &["base"]),
    ("spline", &["network"]),
    ("rational", &["network"]),
    ("tessellate", &["hybrid", "spline", "rational"]),
    ("query", &["hybrid", "spline", "rational"]),
    ("inspect", &["tessellate"]),
    ("render", &["tessellate", "query"]),
    ("report", &["inspect"]),
    ("io", &["tessellate", "query", "inspect", "render"]),
    ("gallery", &["field"]),
    ("recipes", &["gallery", "io", "report", "singular"]),
];

/// A path that goes the wrong way.
#[derive(Debug, PartialEq, Eq)]
struct Offence {
    file: String,
    line: usize,
    module: String,
    imports: String,
}

impl fmt::Display for Offence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, module, imports } = self;
        write!(f, "{file}:{line}: `{module}` may not use `{imports}`")
    }
}

/// The modules that `module` may name: itself, and all below it. None for a module without a place.
fn allowed(module: &str) -> Option<BTreeSet<&str>> {
    let below: BTreeMap<&str, &[&str]> = BELOW.iter().copied().collect();
    let mut found = BTreeSet::new();
    let mut open = vec![*below.get_key_value(module)?.0];
    while let Some(next) = open.pop() {
        if found.insert(next) {
            open.extend(below[next]);
        }
    }
    Some(found)
}

/// A word or a sign of Rust source, with its line.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Token {
    text: String,
    line: usize,
}

/// Splits Rust source; comments, literals and lifetimes are left out.
fn tokens(source: &str) -> Vec<Token> {
    let c: Vec<char> = source.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let is_word = |ch: char| ch.is_alphanumeric() || ch == '_';
    let (mut found, mut i, mut line) = (Vec::new(), 0, 1);
    while i < c.len() {
        let start = i;
        match at(i) {
            '/' if at(i + 1) == '/' => i = (i..c.len()).find(|j| c[*j] == '\n').unwrap_or(c.len()),
            '/' if at(i + 1) == '*' => i = end_of_block_comment(&c, i),
            'r' if at(i + 1) == '"' || (at(i + 1) == '#' && matches!(at(i + 2), '"' | '#')) => {
                i = end_of_raw_string(&c, i + 1);
            }
            '"' => i = end_of_quoted(&c, i),
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => i = end_of_quoted(&c, i),
            '\'' => i += 1 + c[i + 1..].iter().take_while(|ch| is_word(**ch)).count(),
            ch if is_word(ch) => {
                i += c[i..].iter().take_while(|ch| is_word(**ch)).count();
                found.push(Token { text: c[start..i].iter().collect(), line });
            }
            ':' if at(i + 1) == ':' => {
                i += 2;
                found.push(Token { text: "::".into(), line });
            }
            ch => {
                i += 1;
                if !ch.is_whitespace() {
                    found.push(Token { text: ch.into(), line });
                }
            }
        }
        line += c[start..i].iter().filter(|ch| **ch == '\n').count();
    }
    found
}

fn end_of_block_comment(c: &[char], start: usize) -> usize {
    let (mut depth, mut i) = (1, start + 2);
    while i < c.len() && depth > 0 {
        match (c[i], c.get(i + 1)) {
            ('/', Some('*')) => (depth, i) = (depth + 1, i + 2),
            ('*', Some('/')) => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
    }
    i
}

/// `start` is at the first `#` or quote after the r.
fn end_of_raw_string(c: &[char], start: usize) -> usize {
    let hashes = c[start..].iter().take_while(|ch| **ch == '#').count();
    let closing: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
    let body = start + hashes + 1;
    (body..c.len()).find(|j| c[*j..].starts_with(&closing)).map_or(c.len(), |j| j + closing.len())
}

/// End of a string or character literal, by its opening quote.
fn end_of_quoted(c: &[char], start: usize) -> usize {
    let mut i = start + 1;
    while i < c.len() && c[i] != c[start] {
        i += if c[i] == '\\' { 2 } else { 1 };
    }
    (i + 1).min(c.len())
}

fn starts_with(tokens: &[Token], words: &[&str]) -> bool {
    tokens.len() >= words.len() && tokens.iter().zip(words).all(|(t, w)| t.text == *w)
}

const CFG_TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];

/// Splits off the items under `#[cfg(test)]`: the tokens that remain, and the names of the test modules in other files.
fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    let (mut kept, mut files, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        if !starts_with(&tokens[i..], &CFG_TEST) {
            kept.push(tokens[i].clone());
            i += 1;
            continue;
        }
        let item = &tokens[i + CFG_TEST.len()..];
        let length = item_length(item);
        if let Some(m) = item[..length].iter().position(|t| t.text == "mod")
            && item.get(m + 2).is_some_and(|t| t.text == ";")
        {
            files.push(item[m + 1].text.clone());
        }
        i += CFG_TEST.len() + length;
    }
    (kept, files)
}

/// Tokens of the item that comes first, up to its semicolon or its closing brace.
fn item_length(tokens: &[Token]) -> usize {
    let mut depth = 0usize;
    for (i, token) in tokens.iter().enumerate() {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" => depth = depth.saturating_sub(1),
            "}" if depth <= 1 => return i + 1,
            "}" => depth -= 1,
            ";" if depth == 0 => return i + 1,
            _ => {}
        }
    }
    tokens.len()
}

/// The modules right under the crate's root that paths name. `nesting` is the depth of the file's module: so many
/// `super` lead to the root.
fn imports(tokens: &[Token], nesting: usize) -> Vec<Token> {
    let mut found = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let supers =
            (i..).step_by(2).take_while(|j| starts_with(&tokens[(*j).min(tokens.len())..], &["super", "::"]));
        let path = match (tokens[i].text.as_str(), supers.count()) {
            ("crate", _) if starts_with(&tokens[i + 1..], &["::"]) => i + 2,
            (_, supers) if supers > 0 => {
                i += 2 * supers;
                if supers != nesting {
                    continue;
                }
                i
            }
            _ => {
                i += 1;
                continue;
            }
        };
        found.extend(first_names(&tokens[path..]));
        i = path;
    }
    found
}

/// The first name of a path, or of every branch of a use tree.
fn first_names(path: &[Token]) -> Vec<Token> {
    let is_name = |t: &Token| t.text.starts_with(|c: char| c.is_alphabetic() || c == '_');
    if !starts_with(path, &["{"]) {
        return path.first().filter(|t| is_name(t)).cloned().into_iter().collect();
    }
    let (mut names, mut depth) = (Vec::new(), 0);
    for pair in path.windows(2) {
        match pair[0].text.as_str() {
            "{" => depth += 1,
            "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            break;
        }
        if depth == 1 && matches!(pair[0].text.as_str(), "{" | ",") && is_name(&pair[1]) {
            names.push(pair[1].clone());
        }
    }
    names
}

/// Where a source file stands: its module under the root, and the depth of the module that it is.
fn place(file: &str) -> (&str, usize) {
    let path = file.trim_end_matches(".rs");
    let path = path.strip_suffix("/mod").unwrap_or(path);
    let depth = if path == "lib" { 0 } else { path.split('/').count() };
    (path.split('/').next().unwrap_or(path), depth)
}

/// Checks sources given by their path under `src`.
fn check(sources: &BTreeMap<String, String>) -> Vec<Offence> {
    let split: Vec<_> = sources.iter().map(|(file, text)| (file, without_tests(&tokens(text)))).collect();
    let is_test = |file: &str| {
        split.iter().any(|(owner, (_, tests))| {
            let (folder, stem) = owner.rsplit_once('/').unwrap_or(("", owner));
            let folder = match stem {
                "mod.rs" | "lib.rs" => folder.to_owned(),
                _ => owner.trim_end_matches(".rs").to_owned(),
            };
            let rest = if folder.is_empty() { Some(file) } else { file.strip_prefix(&format!("{folder}/")) };
            tests
                .iter()
                .any(|t| rest.is_some_and(|r| r == format!("{t}.rs") || r.starts_with(&format!("{t}/"))))
        })
    };
    let mut offences = Vec::new();
    for (file, (tokens, _)) in split.iter().filter(|(file, _)| !is_test(file)) {
        let (module, nesting) = place(file);
        if module == "lib" {
            continue;
        }
        let allowed = allowed(module).unwrap_or_default();
        for name in imports(tokens, nesting) {
            if !allowed.contains(name.text.as_str()) {
                let (file, module) = (file.to_string(), module.to_owned());
                offences.push(Offence { file, line: name.line, module, imports: name.text });
            }
        }
    }
    offences
}

fn read(folder: &Path, prefix: &str, sources: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{prefix}{}", path.file_name().unwrap().to_string_lossy());
        if path.is_dir() {
            read(&path, &format!("{name}/"), sources);
        } else if name.ends_with(".rs") {
            sources.insert(name, std::fs::read_to_string(&path).unwrap());
        }
    }
}

fn library() -> BTreeMap<String, String> {
    let mut sources = BTreeMap::new();
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "", &mut sources);
    sources
}

#[test]
fn imports_of_the_library_go_one_way() {
    let offences: Vec<String> = check(&library()).iter().map(Offence::to_string).collect();
    assert!(offences.is_empty(), "imports against the order of ARCHITECTURE.md:\n{}", offences.join("\n"));
}

#[test]
fn every_module_of_the_library_has_a_place() {
    let sources = library();
    assert!(sources.len() > 10 && sources.contains_key("lib.rs"));
    let without: BTreeSet<&str> =
        sources.keys().map(|file| place(file).0).filter(|m| *m != "lib" && allowed(m).is_none()).collect();
    assert!(without.is_empty(), "not in the table of this test: {without:?}");
}

/// Checks one planted file; the offending lines and what they import.
fn planted(file: &str, text: &str) -> Vec<(usize, String)> {
    let sources = BTreeMap::from([(file.to_owned(), text.to_owned())]);
    check(&sources).into_iter().map(|o| (o.line, o.imports)).collect()
}

fn offences(found: &[(usize, &str)]) -> Vec<(usize, String)> {
    found.iter().map(|(line, module)| (*line, (*module).to_owned())).collect()
}

#[test]
fn plain_and_nested_use_trees_are_read() {
    let text = "use crate::geom::Jet;\nuse crate::{\n    geom::{Aabb, Interval},\n    spline::{self, build},\n    io,\n};\n";
    assert_eq!(planted("field/tape.rs", text), offences(&[(4, "spline"), (5, "io")]));
    assert_eq!(planted("recipes/fit.rs", text), []);
}

#[test]
fn paths_in_expressions_and_types_count() {
    let text = "fn f(s: &dyn crate::surface::Surface) {\n    let x = 'a';\n    crate::io::write(s, x);\n}\n";
    assert_eq!(planted("mesh/half_edge.rs", text), offences(&[(1, "surface"), (3, "io")]));
}

#[test]
fn comments_literals_and_lifetimes_do_not_count() {
    let text = r####"//! See [`crate::io`].
/* crate::io::a /* crate::io::b */ crate::io::c */
fn f<'a>(_: &'a str) { let _ = ("crate::io::\" x", r#"crate::io::" x"#, '"', b"\\"); }
use crate::render::x;
"####;
    assert_eq!(planted("geom/points.rs", text), offences(&[(4, "render")]));
}

#[test]
fn apatch_and_spline_do_not_know_each_other() {
    assert_eq!(planted("apatch/mod.rs", "use crate::spline::fit;"), offences(&[(1, "spline")]));
    assert_eq!(planted("spline/mod.rs", "\nuse crate::apatch::Bound;"), offences(&[(2, "apatch")]));
    assert_eq!(planted("spline/mod.rs", "use crate::{base::BaseMesh, network, surface::Surface};"), []);
}

#[test]
fn super_may_lead_to_the_root() {
    let text = "use super::super::io::Writer;\nuse super::edge;\nuse super::super::{geom, recipes};";
    assert_eq!(planted("spline/edge.rs", text), offences(&[(1, "io"), (3, "recipes")]));
    assert_eq!(planted("surface.rs", "use super::base;\nuse super::geom;"), offences(&[(1, "base")]));
}

#[test]
fn test_code_is_exempt_and_what_follows_it_is_not() {
    let text =
        "#[cfg(test)]\nmod tests {\n    use crate::recipes;\n    fn g() { h([0; 3]); }\n}\nuse crate::io;\n";
    assert_eq!(planted("bernstein/curve.rs", text), offences(&[(6, "io")]));
    let text =
        "#[cfg(test)]\n#[allow(unused)]\nfn f(_: [u8; 3]) -> crate::io::A { loop {} }\nuse crate::query;";
    assert_eq!(planted("bernstein/curve.rs", text), offences(&[(4, "query")]));
}

#[test]
fn test_modules_in_their_own_files_are_exempt() {
    let sources: BTreeMap<String, String> = [
        ("base/mod.rs", "#[cfg(test)]\npub(crate) mod planted;\nmod build;"),
        ("base/planted.rs", "use crate::spline;"),
        ("base/planted/deep.rs", "use crate::spline;"),
        ("base/build.rs", "#[cfg(test)]\nmod tests;\nuse crate::render;"),
        ("base/build/tests.rs", "use crate::recipes;"),
        ("base/tests.rs", "use crate::recipes;"),
    ]
    .map(|(file, text)| (file.to_owned(), text.to_owned()))
    .into();
    let found: Vec<String> = check(&sources).iter().map(Offence::to_string).collect();
    assert_eq!(
        found,
        ["base/build.rs:3: `base` may not use `render`", "base/tests.rs:1: `base` may not use `recipes`"]
    );
}

#[test]
fn a_name_that_is_no_module_is_an_offence() {
    assert_eq!(planted("io/step.rs", "use crate::utils::round;"), offences(&[(1, "utils")]));
    assert_eq!(planted("utils/mod.rs", "use crate::geom::Vec3;"), offences(&[(1, "geom")]));
}
