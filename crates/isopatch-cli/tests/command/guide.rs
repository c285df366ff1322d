//! The guide shows every option that the help has.

use super::Folder;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The names of the options in a help text: lines that begin with `-o, --output <OUT>` or `--box <…>`.
fn options_of(help: &str) -> Vec<String> {
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let names = lines.filter_map(|line| {
        let long = line.split_whitespace().find(|word| word.starts_with("--"))?;
        Some(long.split(['=', '[']).next().unwrap_or(long).to_owned())
    });
    names.filter(|name| name != "--help" && name != "--version").collect()
}

/// The lines of code in the pages of the guide that call the program, by subcommand.
fn examples() -> BTreeMap<String, Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide");
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let text = fs::read_to_string(entry.unwrap().path()).unwrap();
        for code in text.split("```").skip(1).step_by(2) {
            for line in code.lines().filter_map(|line| line.strip_prefix("isopatch ")) {
                let line = line.split(" # ").next().unwrap().to_owned();
                let command = line.split_whitespace().next().unwrap().to_owned();
                found.entry(command).or_default().push(line);
            }
        }
    }
    found
}

fn shows(line: &str, option: &str) -> bool {
    let is_it = |word: &str| word == option || word.starts_with(&format!("{option}="));
    line.split_whitespace().any(|word| is_it(word) || (option == "--output" && word == "-o"))
}

#[test]
fn every_option_has_an_example_in_the_guide() {
    let (folder, examples) = (Folder::new(), examples());
    let help = folder.run(&["--help"]).stdout;
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        // A longer indent goes on with the description above.
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .filter(|name| !name.is_empty() && *name != "help")
        .collect();
    assert!(commands.contains(&"fit") && commands.contains(&"gallery"), "{help}");
    let mut missing = Vec::new();
    for command in commands {
        let lines = examples.get(command).map_or(&[][..], Vec::as_slice);
        assert!(!lines.is_empty(), "no example of isopatch {command}");
        let options = options_of(&folder.run(&[command, "--help"]).stdout);
        assert!(!options.is_empty(), "{command}");
        let shown = |option: &&String| lines.iter().any(|line| shows(line, option));
        missing.extend(options.iter().filter(|option| !shown(option)).map(|o| format!("{command} {o}")));
    }
    assert!(missing.is_empty(), "no example in docs/guide of: {}", missing.join(", "));
}

/// Every word of the examples that begins with dashes is an option that the program has.
#[test]
fn the_guide_shows_no_options_that_are_not_there() {
    let folder = Folder::new();
    for (command, lines) in examples() {
        if command == "help" {
            continue;
        }
        let options = options_of(&folder.run(&[&command, "--help"]).stdout);
        for line in lines {
            let words = line.split_whitespace().filter(|word| word.starts_with("--"));
            for word in words.map(|word| word.split('=').next().unwrap()) {
                assert!(options.iter().any(|option| option == word), "isopatch {line}: {word}");
            }
        }
    }
}
