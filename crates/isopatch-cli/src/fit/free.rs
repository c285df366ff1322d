//! Free parameters from a file.

use std::path::{Path, PathBuf};

/// Why a file of free parameters can't be used.
#[derive(Debug, thiserror::Error)]
#[error("--free {}: {problem}", path.display())]
pub struct FreeError {
    path: PathBuf,
    problem: Problem,
}

#[derive(Debug, thiserror::Error)]
enum Problem {
    #[error(transparent)]
    Read(#[from] std::io::Error),
    #[error("line {line} has {found} words instead of two, for the outer and the inner side")]
    Words { line: usize, found: usize },
    #[error("line {line}: \"{word}\" is neither a finite number nor -")]
    Word { line: usize, word: String },
}

/// Reads a line for each face: the values of its outer and its inner side, `-` for the default, which is NaN here. Empty lines
/// and lines that start with # are skipped.
pub fn read(path: &Path) -> Result<Vec<[f64; 2]>, FreeError> {
    let read = || parse(&std::fs::read_to_string(path)?);
    read().map_err(|problem| FreeError { path: path.to_owned(), problem })
}

fn parse(text: &str) -> Result<Vec<[f64; 2]>, Problem> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    lines
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .map(|(n, line)| pair(n, line))
        .collect()
}

fn pair(line: usize, text: &str) -> Result<[f64; 2], Problem> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let &[outer, inner] = words.as_slice() else { return Err(Problem::Words { line, found: words.len() }) };
    let value = |word: &str| match word.parse::<f64>() {
        _ if word == "-" => Ok(f64::NAN),
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(Problem::Word { line, word: word.to_owned() }),
    };
    Ok([value(outer)?, value(inner)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_faces() {
        let found = parse("# outer inner\n1 -2.5\n\n- 3e-1\n").unwrap();
        assert_eq!((found[0], found[1][1], found.len()), ([1.0, -2.5], 0.3, 2));
        assert!(found[1][0].is_nan());
    }

    #[test]
    fn what_is_wrong_is_named() {
        let message = |text: &str| parse(text).unwrap_err().to_string();
        assert_eq!(
            message("1 2\n3\n"),
            "line 2 has 1 words instead of two, for the outer and the inner side"
        );
        assert_eq!(message("1 inf"), "line 1: \"inf\" is neither a finite number nor -");
        assert_eq!(message("#\n\n1 x"), "line 3: \"x\" is neither a finite number nor -");
    }
}
