//! The whole function: cells over faces, and cells over edges between them.

use super::cells::{HybridHull, Jet};
use super::face::{FaceCells, Foot};
use super::flank::Flank;
use super::tetra::gradient;
use crate::apatch::EdgeFunction;
use crate::geom::{Point3, Vec3};
use crate::hull::{CreaseCurve, Side};
use crate::mesh::{EdgeId, FaceId};
use crate::parallel::Evenly;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A C1 function on the hull of a polygon mesh, zero at its vertices with the given gradients there.
///
/// C1 across every face of a cell, but for fans of five and more corners whose data do not fit
/// ([`FanNet::defects`](super::FanNet::defects)).
#[derive(Clone, Debug)]
pub struct HybridFunction {
    hull: HybridHull,
    corners: Vec<Vec<Point3>>,
    faces: Vec<FaceCells>,
    edges: Vec<[Option<EdgeFunction>; 2]>,
    /// The curves of creases in which the zero set of a face does not end by itself.
    pub(super) curves: BTreeMap<EdgeId, CreaseCurve>,
}

impl HybridFunction {
    /// The function on a hull (steps 1 to 4 of the paper), in linear time.
    pub fn new(hull: HybridHull) -> Self {
        let (corners, faces) = (0..hull.faces.len())
            .into_par_iter()
            .evenly()
            .map(|f| {
                let frame = hull.data.frame(f.into());
                let cells = FaceCells::new(&frame, &hull.faces[f]);
                (frame.p, cells)
            })
            .unzip();
        let curves = curves(&hull);
        let mut function = Self { hull, corners, faces, edges: Vec::new(), curves };
        function.edges = (0..function.hull.edges.len())
            .into_par_iter()
            .evenly()
            .map(|e| Side::BOTH.map(|side| function.built_edge(e.into(), side)))
            .collect();
        function
    }

    /// The hull with its data.
    pub fn hull(&self) -> &HybridHull {
        &self.hull
    }

    /// The hull again, to be changed.
    pub fn into_hull(self) -> HybridHull {
        self.hull
    }

    /// The function in the cells of each face.
    pub fn faces(&self) -> &[FaceCells] {
        &self.faces
    }

    /// Corners of a face, counter-clockwise.
    pub fn corners(&self, f: FaceId) -> &[Point3] {
        &self.corners[f.index()]
    }

    /// The function in the cell of an edge on a side.
    pub fn edge_function(&self, e: EdgeId, side: Side) -> Option<&EdgeFunction> {
        self.edges[e.index()][side.index()].as_ref()
    }

    /// Number of cells of faces and of edges: the paper's elements.
    pub fn cell_counts(&self) -> [usize; 2] {
        let of_faces = self.faces.iter().map(FaceCells::count).sum();
        [of_faces, self.edges.iter().flatten().flatten().count()]
    }

    /// The same function with other values and gradients at some apexes. Only the cells of those faces and of their edges change:
    /// layers 2 and 3 over them, and for cells around an axis what is not given by the polygon alone.
    pub fn with_jets(mut self, jets: &[(FaceId, Side, Jet)]) -> Self {
        for (f, side, jet) in jets {
            self.hull.faces[f.index()].at_apex[side.index()] = Some(*jet);
        }
        for (f, ..) in jets {
            self.faces[f.index()] = FaceCells::new(&self.hull.data.frame(*f), &self.hull.faces[f.index()]);
        }
        let mut changed: Vec<EdgeId> = jets
            .iter()
            .flat_map(|(f, ..)| self.hull.data.mesh().face_half_edges(*f))
            .map(|h| self.hull.data.mesh().edge(h))
            .collect();
        changed.sort_unstable();
        changed.dedup();
        for e in changed {
            self.edges[e.index()] = Side::BOTH.map(|side| self.built_edge(e, side));
        }
        self
    }

    /// What the cells on the left and the right of an edge give on a side, both along the edge.
    pub fn flanks(&self, e: EdgeId, side: Side) -> Option<[Flank; 2]> {
        let mesh = self.hull.data.mesh();
        let [h, g] = self.hull.data.joint(e)?;
        let of = |h| {
            let f = mesh.face(h);
            let apex = self.hull.faces[f.index()].apexes[side.index()].as_ref()?;
            self.faces[f.index()].flank(self.corners(f), apex, side, mesh.side(h))
        };
        Some([of(h)?, of(g)?.reversed()])
    }

    fn built_edge(&self, e: EdgeId, side: Side) -> Option<EdgeFunction> {
        if !self.hull.edges[e.index()].cells[side.index()] {
            return None;
        }
        let [left, right] = self.flanks(e, side)?;
        Some(left.edge_function(&right, self.on_edge(e).map(|f| side.sign() * f)))
    }

    /// The coefficients on an edge, near its start and near its end.
    pub fn on_edge(&self, e: EdgeId) -> [f64; 2] {
        let data = &self.hull.data;
        let start = data.mesh().edge_half_edge(e);
        let end = data.mesh().next(start);
        let edge = data.position(end) - data.position(start);
        [data.gradient(start).dot(&edge) / 3.0, data.gradient(end).dot(&-edge) / 3.0]
    }

    /// Start and end of an edge.
    pub fn ends(&self, e: EdgeId) -> [Point3; 2] {
        let (data, h) = (&self.hull.data, self.hull.data.mesh().edge_half_edge(e));
        [data.position(h), data.position(data.mesh().next(h))]
    }

    /// Corners of the cell of an edge on a side: the apex of the right face, start and end, the apex of the left face.
    pub fn edge_cell(&self, e: EdgeId, side: Side) -> Option<[Point3; 4]> {
        self.edge_function(e, side)?;
        let [h, g] = self.hull.data.joint(e)?;
        let apex = |h| self.hull.faces[self.hull.data.mesh().face(h).index()].apexes[side.index()];
        let [p_i, p_j] = self.ends(e);
        Some([apex(g)?, p_i, p_j, apex(h)?])
    }

    /// Value and gradient at the parameter t of the ray from a foot to the apex on a side; none without a cell there.
    pub fn in_face_cell(&self, f: FaceId, side: Side, foot: Foot, t: f64) -> Option<(f64, Vec3)> {
        let apex = self.hull.faces[f.index()].apexes[side.index()].as_ref()?;
        self.faces[f.index()].value(self.corners(f), apex, side, foot, t)
    }

    /// Value and gradient at barycentric coordinates of the cell of an edge; none if it has none on that side.
    pub fn in_edge_cell(&self, e: EdgeId, side: Side, x: [f64; 4]) -> Option<(f64, Vec3)> {
        let corners = self.edge_cell(e, side)?;
        let (value, d) = self.edge_function(e, side)?.value(x);
        Some((side.sign() * value, side.sign() * gradient(&corners, d)))
    }
}

fn curves(hull: &HybridHull) -> BTreeMap<EdgeId, CreaseCurve> {
    let mesh = hull.data.mesh();
    let is_pulled = |e: &EdgeId| {
        let h = mesh.edge_half_edge(*e);
        ![Some(h), mesh.twin(h)].into_iter().flatten().all(|h| hull.data.ends_in_crease(h))
    };
    let creases = mesh.edges().filter(|e| hull.data.is_crease(*e)).filter(is_pulled);
    creases.filter_map(|e| Some((e, hull.data.crease_curve(e)?))).collect()
}
