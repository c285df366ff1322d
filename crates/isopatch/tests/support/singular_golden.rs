//! Surfaces whose singular sets a computer algebra system has found.
#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, clippy::panic)] // Test data that is wrong has to stop the test.

use isopatch::field::{Constants, Field, Formula};
use isopatch::geom::{Aabb, Point3};
use isopatch::singular::{Analysis, SingularOptions, analyse};
use serde_json::{Map, Value};
use std::path::Path;

/// The golden ratio.
pub const T: &str = "((1+sqrt(5))/2)";

pub fn formula(text: &str) -> Formula {
    Formula::parse(text, &Constants::new()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

pub fn analysed(text: &str, bounds: &Aabb) -> Analysis {
    analyse(&formula(text), bounds, &SingularOptions::default()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// A surface of the golden file.
pub struct Golden {
    /// The formula.
    pub text: String,
    /// The box.
    pub bounds: Aabb,
    /// The whole entry.
    pub entry: Value,
}

impl Golden {
    /// All, by name.
    pub fn all() -> Vec<(String, Self)> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/singular.json");
        let json: Map<String, Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        json.into_iter().map(|(name, entry)| (name, Self::new(entry))).collect()
    }

    fn new(entry: Value) -> Self {
        let number = |v: &Value| match v.as_str() {
            Some(text) => formula(text).constant().unwrap(),
            None => v.as_f64().unwrap(),
        };
        let side = |a: usize, k: usize| number(&entry["box"][a][k]);
        let corner = |k: usize| Point3::from_fn(|a, _| side(a, k));
        let mut text = entry["f"].as_str().unwrap().replace("**", "^");
        // Rational(a,b) is a/b.
        while let Some(start) = text.find("Rational(") {
            let end = start + text[start..].find(')').unwrap();
            let quotient = text[start + "Rational".len()..end].replace(',', "/");
            text.replace_range(start..end, &quotient);
        }
        if entry["golden_ratio_t"] == true {
            text = text.replace('t', T);
        }
        Self { text, bounds: Aabb::new(corner(0), corner(1)), entry }
    }

    /// Points that are listed under a key.
    pub fn points(&self, key: &str) -> Vec<Point3> {
        let list = self.entry[key].as_array().cloned().unwrap_or_default();
        list.iter().map(|p| Point3::from_fn(|a, _| p[a].as_f64().unwrap())).collect()
    }

    /// Points of the curves that the file gives parameters for, in the box.
    pub fn curve_points(&self) -> Vec<Point3> {
        let mut points = Vec::new();
        for curve in self.entry["singular_curves"].as_array().into_iter().flatten() {
            let Some(parameters) = curve["param"].as_array() else { continue };
            for i in -80..=80 {
                // From −4 to 4, not through values of note.
                let mut constants = Constants::new();
                constants.set("s", 0.05 * f64::from(i) + 0.0037).unwrap();
                let value = |v: &Value| {
                    let text = v.as_str().unwrap().replace("**", "^");
                    Formula::parse(&text, &constants).unwrap().value(Point3::zeros())
                };
                let p = Point3::new(value(&parameters[0]), value(&parameters[1]), value(&parameters[2]));
                if self.bounds.contains(&p) {
                    points.push(p);
                }
            }
        }
        points
    }
}

/// The size of the box counts as 1.
pub fn relative(bounds: &Aabb) -> f64 {
    bounds.size().max()
}
