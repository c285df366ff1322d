use super::base::Base;
use super::check::{self, Patches};
use super::edge::{EdgeFunction, EdgeSide, Flank};
use super::face::{FaceFunction, FaceSide};
use super::free::{self, Free, FreeRule};
use super::quadric::{CellQuadric, Layer2Rule};
use crate::hull::{Class, Hull, Reason, Side};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Options of [`build`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct APatchOptions {
    /// How layer 2 is found; default by interpolation.
    pub layer2: Layer2Rule,
    /// Where default free parameters come from; default the neighbours.
    pub rule: FreeRule,
    /// Free parameters; default those of the rule.
    pub free: Free,
}

/// A C1 function on a hull, zero at the vertices of its mesh with the given gradients there.
#[derive(Clone, Debug)]
pub struct APatchFunction {
    hull: Hull,
    faces: Vec<FaceFunction>,
    edges: Vec<[Option<EdgeSide>; 2]>,
    /// Per face, outer and inner: what the rule gives, the sufficient bound, what is used.
    defaults: Vec<[f64; 2]>,
    sufficient: Vec<[f64; 2]>,
    free: Vec<[f64; 2]>,
}

/// Defaults are raised to this times the sufficient bound.
const ABOVE_BOUND: f64 = 1.0 + 1e-6;

/// Computes the function (all ten steps of the paper's §4), in linear time.
///
/// With robust apexes, the hull is changed where a patch turns over with the default free parameters, see [`Hull::relieved`]; where
/// that does not help although the mesh was refined, or vertices became corners all the same, it is also made without refinement,
/// and kept so if that has no more corners, see [`Hull::unrefined`]. Where corners are left at vertices that a direction sees, it is
/// made for a mesh that is rounded there, and kept so if that has fewer, see [`Hull::rounded`].
pub fn build(hull: Hull, options: &APatchOptions) -> APatchFunction {
    let (mut function, left) = unfolded(hull, options);
    let cuts = |hull: &Hull| (hull.corners().len(), hull.added_creases().len());
    let avoidable = |hull: &Hull| hull.corners().iter().any(|c| c.reason != Reason::NoVisibleNormal);
    if (!left.is_empty() || avoidable(&function.hull))
        && let Some(hull) = function.hull.unrefined()
    {
        let (plain, _) = unfolded(hull, options);
        if !left.is_empty() || cuts(&plain.hull) <= cuts(&function.hull) {
            function = plain;
        }
    }
    if avoidable(&function.hull) {
        let corners = function.hull.corners().len();
        let mut rounded = function.hull.rounded().map(|hull| unfolded(hull, options));
        let better = rounded.find(|(round, left)| left.is_empty() && round.hull.corners().len() < corners);
        drop(rounded);
        function = better.map_or(function, |(round, _)| round);
    }
    function.with_free(&options.free)
}

/// The function on a hull that is changed until no patch turns over, and those that do when that has been tried often enough.
fn unfolded(hull: Hull, options: &APatchOptions) -> (APatchFunction, Patches) {
    let mut function = assemble(hull, options);
    let mut among = Patches::all(&function);
    let mut folded = check::folded(&function, &among, false);
    for _ in 0..ROUNDS {
        if folded.is_empty() {
            break;
        }
        let faces = function.faces.len();
        let (hull, changed) = function.hull.relieved(&folded.faces, &folded.edges);
        function = assemble(hull, options);
        if changed.is_empty() {
            break;
        }
        among = match function.faces.len() == faces {
            true => Patches::around(&function, &changed).with(folded),
            false => Patches::all(&function),
        };
        folded = check::folded(&function, &among, true);
    }
    (function, folded)
}

/// Rounds of looking for patches that turn over. Hulls ran out of things to change after at most 12.
const ROUNDS: usize = 40;

/// The function on a hull as it is, with default free parameters.
fn assemble(hull: Hull, options: &APatchOptions) -> APatchFunction {
    let hull = hull.sharpened();
    let mesh = hull.data().mesh();
    let (mut faces, mut quadrics): (Vec<FaceFunction>, Vec<[Option<CellQuadric>; 2]>) = Default::default();
    (0..mesh.face_count())
        .into_par_iter()
        .evenly()
        .map(|f| face_function(&hull, f.into(), options.layer2))
        .unzip_into_vecs(&mut faces, &mut quadrics);
    let edges: Vec<[Option<EdgeSide>; 2]> = (0..mesh.edge_count())
        .into_par_iter()
        .evenly()
        .map(|e| Side::BOTH.map(|side| edge_side(&hull, &faces, e.into(), side)))
        .collect();
    let [outer, inner] = Side::BOTH.map(|side| {
        let quadrics: Vec<_> = quadrics.iter().map(|q| q[side.index()]).collect();
        free::defaults(&hull, side, &quadrics, options.rule)
    });
    let defaults: Vec<[f64; 2]> = outer.into_iter().zip(inner).map(|(u, v)| [u, v]).collect();
    let free = Vec::new();
    let mut function = APatchFunction { hull, faces, edges, defaults, sufficient: Vec::new(), free };
    function.sufficient = function.sufficient_bounds();
    function.with_free(&Free::Default)
}

fn face_function(hull: &Hull, f: FaceId, rule: Layer2Rule) -> (FaceFunction, [Option<CellQuadric>; 2]) {
    let (mesh, frame, face) = (hull.data().mesh(), hull.face_frame(f).sharpened(), &hull.faces()[f.index()]);
    let mut half_edges = mesh.face_half_edges(f);
    // The faces beside a crease have gradients of their own there.
    let class = |h: HalfEdgeId| match mesh.edge(h) {
        e if hull.data().is_crease(e) => frame.edge_class(mesh.side(h)),
        e => hull.edges()[e.index()].class,
    };
    let straight = [(); 3].map(|()| half_edges.next().is_some_and(|h| class(h) == Class::Zero));
    let base = Base::new(&frame, straight, face.class == Class::Nonconvex);
    let made = Side::BOTH.map(|side| {
        let layer1 = frame.sharp_layer1(side, &face.apexes[side.index()]?);
        let quadric = CellQuadric::new(&frame, side, &layer1, rule);
        Some((FaceSide { layer1, q: quadric.towards_apex() }, quadric))
    });
    let sides = made.map(|side| side.map(|(side, _)| side));
    (FaceFunction { base, sides }, made.map(|side| side.map(|(_, quadric)| quadric)))
}

/// What the cells on the left and the right of an edge give on a side, with their free parameters.
fn flanks(
    hull: &Hull,
    faces: &[FaceFunction],
    e: EdgeId,
    side: Side,
    free: impl Fn(FaceId) -> f64,
) -> Option<[Flank; 2]> {
    let mesh = hull.data().mesh();
    let [h, g] = hull.data().joint(e)?;
    let of = |h, reversed| {
        let f = mesh.face(h);
        Some(faces[f.index()].sides[side.index()]?.flank(mesh.side(h), reversed, free(f)))
    };
    Some([of(h, false)?, of(g, true)?])
}

fn edge_side(hull: &Hull, faces: &[FaceFunction], e: EdgeId, side: Side) -> Option<EdgeSide> {
    let cell = hull.edges()[e.index()].cells[side.index()].as_ref()?;
    let [left, right] = flanks(hull, faces, e, side, |_| 0.0)?;
    Some(EdgeSide::new(cell, &left, &right))
}

/// A function taken apart, as files have it; see the methods of [`APatchFunction`] with the same names.
#[derive(Clone, Debug)]
pub struct APatchParts {
    /// The hull.
    pub hull: Hull,
    /// The function in the cells of each face.
    pub faces: Vec<FaceFunction>,
    /// The function in the cells of each edge.
    pub edges: Vec<[Option<EdgeSide>; 2]>,
    /// Default free parameters.
    pub default_free: Vec<[f64; 2]>,
    /// Their sufficient bounds.
    pub sufficient_free: Vec<[f64; 2]>,
    /// Those in use.
    pub free: Vec<[f64; 2]>,
}

impl From<APatchParts> for APatchFunction {
    /// The function of parts that belong together: with an entry for each face and each edge of the hull, and a function for
    /// each of its cells.
    fn from(parts: APatchParts) -> Self {
        let APatchParts { hull, faces, edges, default_free, sufficient_free, free } = parts;
        Self { hull, faces, edges, defaults: default_free, sufficient: sufficient_free, free }
    }
}

impl APatchFunction {
    /// The hull with its data.
    pub fn hull(&self) -> &Hull {
        &self.hull
    }

    /// The function in the cells of each face.
    pub fn faces(&self) -> &[FaceFunction] {
        &self.faces
    }

    /// The function in the outer and the inner cell of each edge, without free parameters.
    pub fn edges(&self) -> &[[Option<EdgeSide>; 2]] {
        &self.edges
    }

    /// What the rule gives for the free parameters of each face, outer and inner.
    pub fn default_free(&self) -> &[[f64; 2]] {
        &self.defaults
    }

    /// Values of the free parameters from which on every ray of the cells at a face has one simple root, whatever those of
    /// the other faces; infinite where none is known, because an edge cell has [`Reason::SteepApex`](crate::hull::Reason).
    ///
    /// Sufficient by algebra: then the layers have the signs (−, +, +, +), given layer 1 > 0, which valid hulls have.
    pub fn sufficient_free(&self) -> &[[f64; 2]] {
        &self.sufficient
    }

    /// The free parameters in use.
    pub fn free(&self) -> &[[f64; 2]] {
        &self.free
    }

    /// The same function with other values at its apexes: layers 0 and 1, and all but the free parameter's part of layer 2,
    /// are kept as they are (§5.3), so that this costs one addition a face.
    pub fn with_free(mut self, free: &Free) -> Self {
        let standard = |f: usize, s: usize| {
            let bound = self.sufficient[f][s];
            if bound.is_finite() { self.defaults[f][s].max(bound * ABOVE_BOUND) } else { self.defaults[f][s] }
        };
        self.free = (0..self.faces.len())
            .map(|f| match free {
                Free::Default => [standard(f, 0), standard(f, 1)],
                Free::Global(b) => [*b; 2],
                Free::PerFace(values) => {
                    [0, 1].map(|s| match values.get(self.hull.source_face(f.into()).index()) {
                        Some(given) if given[s].is_finite() => given[s],
                        _ => standard(f, s),
                    })
                }
            })
            .collect();
        self
    }

    /// The function in the cell of an edge on a side.
    pub fn edge_function(&self, e: EdgeId, side: Side) -> Option<EdgeFunction> {
        let (s, mesh) = (side.index(), self.hull.data().mesh());
        let [left, right] = flanks(&self.hull, &self.faces, e, side, |f| self.free[f.index()][s])?;
        let h = mesh.edge_half_edge(e);
        let (a, c) = (mesh.side(h), (mesh.side(h) + 1) % 3);
        let base = &self.faces[mesh.face(h).index()].base;
        let e_ij = [base.e[a][c], base.e[c][a]].map(|f| side.sign() * f);
        Some(self.edges[e.index()][s].as_ref()?.function(e_ij, left.rim, right.rim))
    }

    fn sufficient_bounds(&self) -> Vec<[f64; 2]> {
        let mesh = self.hull.data().mesh();
        let mut bounds: Vec<[f64; 2]> = self
            .faces
            .iter()
            .map(|face| {
                face.sides.map(|side| {
                    side.map_or(0.0, |side| side.q.iter().fold(0.0, |bound: f64, q| bound.max(-2.0 * q)))
                })
            })
            .collect();
        for e in mesh.edges() {
            for side in Side::BOTH {
                let (Some(cell), Some([left, right]), Some(joint)) = (
                    &self.edges[e.index()][side.index()],
                    flanks(&self.hull, &self.faces, e, side, |_| 0.0),
                    self.hull.data().joint(e),
                ) else {
                    continue;
                };
                for (h, bound) in joint.into_iter().zip(cell.sufficient(&left.rim, &right.rim)) {
                    let of_face = &mut bounds[mesh.face(h).index()][side.index()];
                    *of_face = of_face.max(bound);
                }
            }
        }
        bounds
    }
}
