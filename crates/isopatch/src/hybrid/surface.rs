use super::face::FaceCells;
use super::function::HybridFunction;
use super::locate::CellTree;
use crate::apatch::{CreaseCounts, Over, Shot};
use crate::geom::{Aabb, Vec3};
use crate::mesh::{EdgeId, FaceId};
use crate::surface::{Continuity, Domain, PatchForm, PatchId, Sample, Seam, SeamSide, Surface, Volume};
use std::sync::OnceLock;

/// The zero set of a [`HybridFunction`]: one patch over each polygon, then one square patch over each edge that has a cell; C1
/// across all seams but creases and boundaries, which are G0.
///
/// The patch over a triangle has a triangle for its domain, that over a pyramid a square, others a polygon in sectors. The patch
/// over an edge has u along the edge, from the start of its half edge to its end, and v from the right face (0) to the left
/// face (1); it shrinks to points at both ends.
#[derive(Debug)]
pub struct HybridSurface {
    function: HybridFunction,
    /// The edge of each patch over an edge.
    squares: Vec<EdgeId>,
    seams: Vec<Seam>,
    tree: OnceLock<CellTree>,
}

/// Where the patch over an edge meets the right and the left face.
const RIGHT: u8 = 0;
const LEFT: u8 = 2;

impl HybridSurface {
    /// The zero set of a function.
    pub fn new(function: HybridFunction) -> Self {
        let data = &function.hull().data;
        let mesh = data.mesh();
        let squares: Vec<EdgeId> = mesh.edges().filter(|e| function.has_edge_patch(*e)).collect();
        let mut square_of = vec![None; mesh.edge_count()];
        for (n, e) in squares.iter().enumerate() {
            square_of[e.index()] = Some(PatchId((mesh.face_count() + n) as u32));
        }
        let mut seams = Vec::with_capacity(mesh.edge_count() + squares.len());
        for e in mesh.edges() {
            let of_face =
                |h, reversed| SeamSide { patch: PatchId(mesh.face(h).0), edge: mesh.side(h) as u8, reversed };
            let h = mesh.edge_half_edge(e);
            let Some([_, g]) = data.joint(e) else {
                let second = mesh.twin(h).map(|g| of_face(g, true));
                seams.push(Seam { first: of_face(h, false), second, continuity: Continuity::G0 });
                continue;
            };
            let mut add = |first, second| {
                seams.push(Seam { first, second: Some(second), continuity: Continuity::G1 });
            };
            match square_of[e.index()] {
                Some(patch) => {
                    add(of_face(h, false), SeamSide { patch, edge: LEFT, reversed: true });
                    add(of_face(g, false), SeamSide { patch, edge: RIGHT, reversed: true });
                }
                None => add(of_face(h, false), of_face(g, true)),
            }
        }
        Self { function, squares, seams, tree: OnceLock::new() }
    }

    /// The function.
    pub fn function(&self) -> &HybridFunction {
        &self.function
    }

    /// The function, to be given other parameters.
    pub fn into_function(self) -> HybridFunction {
        self.function
    }

    /// What a patch is over.
    pub fn over(&self, patch: PatchId) -> Over {
        match patch.index().checked_sub(self.function.faces().len()) {
            None => Over::Face(FaceId(patch.0)),
            Some(square) => Over::Edge(self.squares[square]),
        }
    }

    /// The edges with a patch; the n-th has the patch number faces + n.
    pub fn square_edges(&self) -> &[EdgeId] {
        &self.squares
    }

    fn shoot(&self, patch: PatchId, [u, v]: [f64; 2]) -> Option<Shot> {
        match self.over(patch) {
            Over::Face(f) => self.function.shoot_face(f, [u, v]),
            Over::Edge(e) => self.function.shoot_edge(e, [1.0 - u, u], v),
        }
    }

    pub(super) fn tree(&self) -> &CellTree {
        self.tree.get_or_init(|| CellTree::new(&self.function))
    }
}

impl Surface for HybridSurface {
    fn patch_count(&self) -> usize {
        self.function.faces().len() + self.squares.len()
    }

    fn domain(&self, patch: PatchId) -> Domain {
        match self.over(patch) {
            Over::Face(f) => self.function.face_domain(f),
            Over::Edge(_) => Domain::Square,
        }
    }

    /// NaN where the ray has no root.
    fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample {
        let nan = Vec3::repeat(f64::NAN);
        self.shoot(patch, uv).map_or(Sample { point: nan, normal: nan, du: nan, dv: nan }, |shot| Sample {
            point: shot.point,
            normal: shot.gradient.normalize(),
            du: shot.du,
            dv: shot.dv,
        })
    }

    fn form(&self, _: PatchId) -> PatchForm<'_> {
        PatchForm::APatch
    }

    fn seams(&self) -> &[Seam] {
        &self.seams
    }

    fn corners(&self, patch: PatchId) -> [u32; 3] {
        let mesh = self.function.hull().data.mesh();
        match self.over(patch) {
            Over::Face(f) => mesh.triangle(f).map(|v| v.0),
            Over::Edge(e) => {
                let h = mesh.edge_half_edge(e);
                [mesh.origin(h).0, mesh.dest(h).0, mesh.dest(h).0]
            }
        }
    }

    fn bounds(&self, patch: PatchId) -> Aabb {
        // Boxes of squares and polygons are taken of the rectangle around a triangle.
        let triangle = match self.domain(patch) {
            Domain::Triangle => [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            Domain::Square => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
            Domain::Polygon(n) => [[0.0, 0.0], [f64::from(n), 0.0], [f64::from(n), 1.0]],
        };
        self.part_bounds(patch, triangle)
    }

    fn part_bounds(&self, patch: PatchId, triangle: [[f64; 2]; 3]) -> Aabb {
        match self.over(patch) {
            Over::Face(f) => self.function.face_part_bounds(f, triangle),
            Over::Edge(e) => self.function.edge_part_bounds(e, triangle),
        }
    }

    fn volume(&self) -> Option<&dyn Volume> {
        Some(self)
    }
}

impl HybridSurface {
    /// Counts the creases: those that are straight, so that the function ends in them by itself, and those to which the faces are
    /// pulled.
    pub fn crease_counts(&self) -> CreaseCounts {
        self.function.crease_counts()
    }

    /// Number of patches that are flat faces, and so have no cells.
    pub fn flat_count(&self) -> usize {
        self.function.faces().iter().filter(|cells| matches!(cells, FaceCells::Flat(_))).count()
    }
}
