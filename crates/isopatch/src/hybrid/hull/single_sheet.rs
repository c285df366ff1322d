//! Moves free parameters so that every ray meets the surface once (docs/theory/hybrid.md; Lawson & Hanson's least-distance programming).
//!
//! Along a ray from the base to the apex the function is a cubic with coefficients L_0 to L_3, the layers, of which L_0 is not
//! positive (all times the sign of the side). If L_2 and L_3 are positive there is one root. Both depend linearly on the free
//! parameters, over polygons as well as in the cells over edges, where those of the two faces do not mix. So for each face alone the
//! smallest change is looked for that makes them all positive.

use super::affine::Affine;
use super::layers::Layers;
use crate::geom::Vec3;
use crate::hull::{Class, Side};
use crate::hybrid::{HybridFace, HybridHull};
use crate::mesh::FaceId;
use crate::numeric::least_distance::least_distance;
use crate::parallel::Evenly;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Layers stay above zero by this part of their unit: distance to the apex times the length of the gradients.
const MARGIN: f64 = 0.01;

/// What is known of the rays over a face and over its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// Every ray has one simple root.
    Certain,
    /// So have those over the face and its edges, but layer 1 may vanish where the surface goes through the face.
    Crossings,
    /// So have those over the face; nothing is certain over its edges.
    FaceOnly,
    /// Nothing is certain.
    None,
}

/// Moves the free parameters of some faces, as little as possible, so that the sufficient conditions hold there. Returns how much
/// of that was possible, face by face.
pub fn enforce(hull: &mut HybridHull, faces: &[FaceId]) -> Vec<Certainty> {
    let found: Vec<(HybridFace, Certainty)> = faces.par_iter().evenly().map(|f| enforced(hull, *f)).collect();
    let put = |(f, (face, certainty)): (&FaceId, (HybridFace, Certainty))| {
        hull.faces[f.index()] = face;
        certainty
    };
    faces.iter().zip(found).map(put).collect()
}

/// What holds with the parameters as they are, face by face.
pub fn certainties(hull: &HybridHull) -> Vec<Certainty> {
    let judge = |f: usize| {
        let Some(conditions) = Conditions::of(hull, f.into()) else { return Certainty::Certain };
        let held = conditions.stages().into_iter().find(|(rows, _)| rows.iter().all(|row| row.value > 0.0));
        held.map_or(Certainty::None, |(_, certainty)| certainty)
    };
    (0..hull.faces.len()).into_par_iter().evenly().map(judge).collect()
}

fn enforced(hull: &HybridHull, f: FaceId) -> (HybridFace, Certainty) {
    let face = &hull.faces[f.index()];
    let frame = hull.data.frame(f);
    let unit = unit(hull, f);
    let Some(layers) = Layers::new(&frame, face, unit) else { return (face.clone(), Certainty::Certain) };
    let conditions = Conditions::new(hull, f, &layers, unit);
    for (rows, certainty) in conditions.stages() {
        let margins: Vec<f64> = rows.iter().map(|row| MARGIN * unit - row.value).collect();
        if margins.iter().all(|margin| *margin <= 0.0) {
            return (face.clone(), certainty);
        }
        let a = DMatrix::from_fn(rows.len(), layers.unknowns(), |i, j| rows[i].slope[j] / unit);
        let b = DVector::from_iterator(rows.len(), margins.iter().map(|margin| margin / unit));
        if let Some(x) = least_distance(&a, &b).filter(|x| x.norm() < FARTHEST) {
            return (layers.moved(face, &x), certainty);
        }
    }
    (face.clone(), Certainty::None)
}

/// Parameters that would have to move farther than this many units are left alone.
const FARTHEST: f64 = 20.0;

/// The largest of the products of a gradient at the face with the distance from an apex.
fn unit(hull: &HybridHull, f: FaceId) -> f64 {
    let frame = hull.data.frame(f);
    let apexes = hull.faces[f.index()].apexes;
    let distance = |p: &Vec3| apexes.iter().flatten().map(|a| (a - p).norm()).fold(0.0, f64::max);
    let longest = frame.n.iter().map(|n| n.norm()).fold(0.0, f64::max);
    frame.p.iter().map(distance).fold(f64::MIN_POSITIVE, f64::max) * longest
}

/// Forms that have to be positive, in the order in which they are given up from the last to the first.
struct Conditions {
    face: Vec<Affine>,
    edges: Vec<Affine>,
    crossings: Vec<Affine>,
}

impl Conditions {
    fn of(hull: &HybridHull, f: FaceId) -> Option<Self> {
        let frame = hull.data.frame(f);
        let unit = unit(hull, f);
        let layers = Layers::new(&frame, &hull.faces[f.index()], unit)?;
        Some(Self::new(hull, f, &layers, unit))
    }

    fn new(hull: &HybridHull, f: FaceId, layers: &Layers<'_>, unit: f64) -> Self {
        let face = &hull.faces[f.index()];
        let (mut own, mut edges, mut crossings) = (Vec::new(), Vec::new(), Vec::new());
        for side in Side::BOTH.into_iter().filter(|side| face.apexes[side.index()].is_some()) {
            let signed = |forms: Vec<Affine>| forms.into_iter().map(move |form| side.sign() * &form);
            own.extend(signed(layers.upper(side)));
            // On the base the sign is the other one, and zero is allowed: the margin is given back.
            let room = Affine::constant(MARGIN * unit, layers.unknowns());
            own.extend(layers.base().iter().map(|form| &(-side.sign() * form) + &room));
            edges.extend(signed(over_edges(hull, f, layers, side)));
            if face.class == Class::Nonconvex {
                crossings.extend(signed(layers.middle(side)));
            }
        }
        Self { face: own, edges, crossings }
    }

    fn stages(&self) -> [(Vec<&Affine>, Certainty); 3] {
        let (face, edges, crossings) = (&self.face, &self.edges, &self.crossings);
        [
            (face.iter().chain(edges).chain(crossings).collect(), Certainty::Certain),
            (face.iter().chain(edges).collect(), Certainty::Crossings),
            (face.iter().collect(), Certainty::FaceOnly),
        ]
    }
}

/// What the cells over the edges of a face take from it on a side, where the surface is on that side.
fn over_edges(hull: &HybridHull, f: FaceId, layers: &Layers<'_>, side: Side) -> Vec<Affine> {
    let mesh = hull.data.mesh();
    let mut forms = Vec::new();
    for (k, h) in mesh.face_half_edges(f).enumerate() {
        let edge = hull.edges[mesh.edge(h).index()];
        if !edge.cells[side.index()] || !edge.class.reaches(side) {
            continue;
        }
        let beyond = mesh.twin(h).and_then(|g| hull.faces[mesh.face(g).index()].apexes[side.index()]);
        if let Some(found) = beyond.and_then(|w| layers.beyond(side, k, &w)) {
            forms.extend(found);
        }
    }
    forms
}
