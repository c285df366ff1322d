//! Surfaces with a name: the examples of the papers and a few more, each in one file of the folder `models`.

use crate::field::{Constants, Formula, FormulaError};
use crate::geom::{Aabb, Point3};
use serde::Deserialize;
use std::sync::LazyLock;

/// The files of the folder `models`, in the order in which they are listed, with the surface's name.
const FILES: [(&str, &str); 65] = [
    ("sphere", include_str!("../../../models/sphere.toml")),
    ("torus", include_str!("../../../models/torus.toml")),
    ("dodeca", include_str!("../../../models/dodeca.toml")),
    ("dtorus", include_str!("../../../models/dtorus.toml")),
    ("mcmullen", include_str!("../../../models/mcmullen.toml")),
    ("chair", include_str!("../../../models/chair.toml")),
    ("decocube", include_str!("../../../models/decocube.toml")),
    ("tangle", include_str!("../../../models/tangle.toml")),
    ("orthocircles", include_str!("../../../models/orthocircles.toml")),
    ("ellipsoid", include_str!("../../../models/ellipsoid.toml")),
    ("superellipsoid", include_str!("../../../models/superellipsoid.toml")),
    ("superquadric", include_str!("../../../models/superquadric.toml")),
    ("star", include_str!("../../../models/star.toml")),
    ("peanut", include_str!("../../../models/peanut.toml")),
    ("seashell", include_str!("../../../models/seashell.toml")),
    ("twistedcolumn", include_str!("../../../models/twistedcolumn.toml")),
    ("threebars", include_str!("../../../models/threebars.toml")),
    ("blobs", include_str!("../../../models/blobs.toml")),
    ("goursat", include_str!("../../../models/goursat.toml")),
    ("chmutov6", include_str!("../../../models/chmutov6.toml")),
    ("pretzel", include_str!("../../../models/pretzel.toml")),
    ("bretzel5", include_str!("../../../models/bretzel5.toml")),
    ("trefoil", include_str!("../../../models/trefoil.toml")),
    ("hopf", include_str!("../../../models/hopf.toml")),
    ("borromean", include_str!("../../../models/borromean.toml")),
    ("gyroid", include_str!("../../../models/gyroid.toml")),
    ("schwarzp", include_str!("../../../models/schwarzp.toml")),
    ("schwarzd", include_str!("../../../models/schwarzd.toml")),
    ("neovius", include_str!("../../../models/neovius.toml")),
    ("iwp", include_str!("../../../models/iwp.toml")),
    ("scherk", include_str!("../../../models/scherk.toml")),
    ("cone", include_str!("../../../models/cone.toml")),
    ("whitney", include_str!("../../../models/whitney.toml")),
    ("steiner", include_str!("../../../models/steiner.toml")),
    ("toroidal", include_str!("../../../models/toroidal.toml")),
    ("cayley", include_str!("../../../models/cayley.toml")),
    ("clebsch", include_str!("../../../models/clebsch.toml")),
    ("kummer", include_str!("../../../models/kummer.toml")),
    ("togliatti", include_str!("../../../models/togliatti.toml")),
    ("barthsextic", include_str!("../../../models/barthsextic.toml")),
    ("barthdecic", include_str!("../../../models/barthdecic.toml")),
    ("endrass", include_str!("../../../models/endrass.toml")),
    ("ringcyclide", include_str!("../../../models/ringcyclide.toml")),
    ("horncyclide", include_str!("../../../models/horncyclide.toml")),
    ("spindlecyclide", include_str!("../../../models/spindlecyclide.toml")),
    ("hunt", include_str!("../../../models/hunt.toml")),
    ("crosscap", include_str!("../../../models/crosscap.toml")),
    ("swallowtail", include_str!("../../../models/swallowtail.toml")),
    ("dingdong", include_str!("../../../models/dingdong.toml")),
    ("octdong", include_str!("../../../models/octdong.toml")),
    ("chubs", include_str!("../../../models/chubs.toml")),
    ("zitrus", include_str!("../../../models/zitrus.toml")),
    ("daisy", include_str!("../../../models/daisy.toml")),
    ("heart", include_str!("../../../models/heart.toml")),
    ("visavis", include_str!("../../../models/visavis.toml")),
    ("calypso", include_str!("../../../models/calypso.toml")),
    ("crixxi", include_str!("../../../models/crixxi.toml")),
    ("nepali", include_str!("../../../models/nepali.toml")),
    ("kolibri", include_str!("../../../models/kolibri.toml")),
    ("tanz", include_str!("../../../models/tanz.toml")),
    ("sofa", include_str!("../../../models/sofa.toml")),
    ("d4", include_str!("../../../models/d4.toml")),
    ("cuspidaledge", include_str!("../../../models/cuspidaledge.toml")),
    ("twospheres", include_str!("../../../models/twospheres.toml")),
    ("stick", include_str!("../../../models/stick.toml")),
];

/// A surface with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What the command line calls it: lower-case letters and digits.
    pub name: &'static str,
    /// What people call it.
    pub title: String,
    /// f(x, y, z); the surface is f = 0.
    pub formula: String,
    /// Values of the names in the formula, in alphabetical order.
    pub constants: Vec<(String, f64)>,
    /// A box that holds the surface; none if it is to be searched for.
    pub bounds: Option<Aabb>,
    /// How many faces its base mesh has unless another number is asked for.
    pub faces: usize,
    /// Is it shown for its singularities (or, beside others, for having none)? Such surfaces are for `isopatch singular`.
    pub singular: bool,
    /// Who or which paper it comes from, in a line.
    pub origin: String,
}

/// All surfaces, in the order of the papers; those with singularities after the others.
pub fn surfaces() -> &'static [Entry] {
    static SURFACES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
        // A file that can't be read is left out; it is part of the program, and a test shows that none is.
        FILES.iter().filter_map(|(name, text)| Entry::parse(name, text).ok()).collect()
    });
    &SURFACES
}

/// The surface of that name.
pub fn surface(name: &str) -> Option<&'static Entry> {
    // No file is read for a name that there is not.
    let is_known = FILES.iter().any(|(known, _)| *known == name);
    if is_known { surfaces().iter().find(|entry| entry.name == name) } else { None }
}

/// A file of the folder `models`, as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    title: String,
    formula: String,
    /// xmin, xmax, ymin, ymax, zmin, zmax.
    r#box: Option<[f64; 6]>,
    faces: usize,
    #[serde(default)]
    singular: bool,
    origin: String,
    #[serde(default)]
    constants: std::collections::BTreeMap<String, f64>,
}

impl Entry {
    /// The function, with its constants.
    pub fn field(&self) -> Result<Formula, FormulaError> {
        let mut constants = Constants::new();
        for (name, value) in &self.constants {
            // A name that is refused is one that the formula does not know, and it says so.
            constants.set(name, *value).ok();
        }
        Formula::parse(&self.formula, &constants)
    }

    fn parse(name: &'static str, text: &str) -> Result<Self, toml::de::Error> {
        let model: Model = toml::from_str(text)?;
        let bounds = model
            .r#box
            .map(|[x0, x1, y0, y1, z0, z1]| Aabb::new(Point3::new(x0, y0, z0), Point3::new(x1, y1, z1)));
        Ok(Self {
            name,
            title: model.title,
            formula: model.formula.replace('\n', ""),
            constants: model.constants.into_iter().collect(),
            bounds,
            faces: model.faces,
            singular: model.singular,
            origin: model.origin,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_read() {
        for (name, text) in FILES {
            let entry = Entry::parse(name, text).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(surface(name), Some(&entry));
            entry.field().unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }

    #[test]
    fn names_are_unique_and_boxes_in_order() {
        for (i, entry) in surfaces().iter().enumerate() {
            assert!(surfaces()[..i].iter().all(|other| other.name != entry.name), "{} twice", entry.name);
            assert!(entry.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()));
            let bounds = entry.bounds.expect("all have one so far");
            assert!((0..3).all(|i| bounds.min[i] < bounds.max[i]), "{}", entry.name);
            assert!(
                entry.faces % 2 == 0,
                "{}: a closed triangle mesh has an even number of faces",
                entry.name
            );
        }
    }

    #[test]
    fn the_papers_surfaces_have_the_papers_face_counts() {
        let faces = |name| surface(name).map(|entry| entry.faces);
        let paper = [("torus", 600), ("dodeca", 1200), ("dtorus", 1800), ("mcmullen", 2000), ("chair", 4000)];
        assert!(paper.iter().all(|(name, count)| faces(name) == Some(*count)));
        assert_eq!(faces("decocube"), Some(5000));
    }
}
