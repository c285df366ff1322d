//! Help, version, gallery.

use super::Folder;
use serde_json::Value;

#[test]
fn help_names_the_options_and_the_exit_status() {
    let help = Folder::new().run(&["fit", "--help"]);
    help.assert_done();
    for word in ["--box", "--tol", "--config", "Exit status", "130 interrupted"] {
        assert!(help.stdout.contains(word), "{word}");
    }
    let version = Folder::new().run(&["--version"]);
    version.assert_done();
    assert!(version.stdout.contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn the_gallery_is_listed() {
    let text = Folder::new().run(&["gallery"]);
    text.assert_done();
    let json = Folder::new().run(&["gallery", "--json"]);
    json.assert_done();
    let entries: Vec<Value> = serde_json::from_str(&json.stdout).unwrap();
    assert!(entries.len() >= 7);
    for entry in &entries {
        assert!(text.stdout.contains(entry["name"].as_str().unwrap()));
        assert!(text.stdout.contains(entry["formula"].as_str().unwrap()));
    }
    assert_eq!((&entries[6]["name"], &entries[6]["faces"]), (&"decocube".into(), &5000.into()));
}
