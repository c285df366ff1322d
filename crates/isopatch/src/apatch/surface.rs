use super::build::APatchFunction;
use super::crease::CreaseCounts;
use super::locate::CellTree;
use super::shoot::Shot;
use crate::geom::{Aabb, Point3, Vec3};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};
use crate::surface::{Continuity, Domain, PatchForm, PatchId, Sample, Seam, SeamSide, Surface, Volume};
use std::sync::OnceLock;

/// The zero set of an [`APatchFunction`]: one triangular patch over each face, then one square patch over each edge that
/// has a cell; C1 across all seams but creases and boundaries, which are G0.
///
/// The patch over an edge has u along the edge, from the start of its half edge to its end, and v from the right face (0) to
/// the left face (1). Its sides u = 0 and u = 1 are the vertices, so it is a lens; over a nonconvex edge it also narrows
/// to a point where the surface goes through the edge.
#[derive(Debug)]
pub struct APatchSurface {
    function: APatchFunction,
    /// The edge of each square patch.
    squares: Vec<EdgeId>,
    seams: Vec<Seam>,
    tree: OnceLock<CellTree>,
}

/// A patch by what it is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// A face.
    Face(FaceId),
    /// An edge.
    Edge(EdgeId),
}

/// Where the square patch meets the right and the left face.
const RIGHT: u8 = 0;
const LEFT: u8 = 2;

impl APatchSurface {
    /// The zero set of a function.
    pub fn new(function: APatchFunction) -> Self {
        let hull = function.hull();
        let mesh = hull.data().mesh();
        let has_cell = |e: &EdgeId| hull.edges()[e.index()].cells.iter().any(Option::is_some);
        let squares: Vec<EdgeId> = mesh.edges().filter(has_cell).collect();
        let mut square_of = vec![None; mesh.edge_count()];
        for (n, e) in squares.iter().enumerate() {
            square_of[e.index()] = Some(PatchId((mesh.face_count() + n) as u32));
        }
        let mut seams = Vec::with_capacity(mesh.edge_count() + squares.len());
        for e in mesh.edges() {
            let of_face =
                |h, reversed| SeamSide { patch: PatchId(mesh.face(h).0), edge: mesh.side(h) as u8, reversed };
            let h = mesh.edge_half_edge(e);
            let Some([_, g]) = hull.data().joint(e) else {
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
    pub fn function(&self) -> &APatchFunction {
        &self.function
    }

    /// The function, to be given other free parameters.
    pub fn into_function(self) -> APatchFunction {
        self.function
    }

    /// What a patch is over.
    pub fn over(&self, patch: PatchId) -> Over {
        match patch.index().checked_sub(self.function.faces().len()) {
            None => Over::Face(FaceId(patch.0)),
            Some(square) => Over::Edge(self.squares[square]),
        }
    }

    /// The edges with a square patch; the n-th has the patch number faces + n.
    pub fn square_edges(&self) -> &[EdgeId] {
        &self.squares
    }

    /// Counts the creases: those that are straight, so that the function ends in them by itself, and those to which the faces
    /// are pulled.
    pub fn crease_counts(&self) -> CreaseCounts {
        self.function.crease_counts()
    }

    fn shoot(&self, patch: PatchId, [u, v]: [f64; 2]) -> Option<Shot> {
        match self.over(patch) {
            Over::Face(f) => self.function.shoot_face(f, [u, v, 1.0 - u - v]),
            Over::Edge(e) => self.function.shoot_edge(e, [1.0 - u, u], v),
        }
    }

    pub(super) fn tree(&self) -> &CellTree {
        self.tree.get_or_init(|| CellTree::new(&self.function))
    }
}

impl Surface for APatchSurface {
    fn patch_count(&self) -> usize {
        self.function.faces().len() + self.squares.len()
    }

    fn domain(&self, patch: PatchId) -> Domain {
        match self.over(patch) {
            Over::Face(_) => Domain::Triangle,
            Over::Edge(_) => Domain::Square,
        }
    }

    /// NaN where the ray has no root.
    fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample {
        let nan = Vec3::repeat(f64::NAN);
        if let Over::Face(f) = self.over(patch)
            && let Some(face) = self.function.creased_face(f)
        {
            let x = [uv[0], uv[1], 1.0 - uv[0] - uv[1]];
            let none = Sample { point: nan, normal: nan, du: nan, dv: nan };
            return face.sample(x).unwrap_or(none);
        }
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
        let mesh = self.function.hull().data().mesh();
        match self.over(patch) {
            Over::Face(f) => mesh.triangle(f).map(|v| v.0),
            Over::Edge(e) => {
                let h = mesh.edge_half_edge(e);
                [mesh.origin(h).0, mesh.dest(h).0, mesh.dest(h).0]
            }
        }
    }

    /// A box around the cells of the patch.
    fn bounds(&self, patch: PatchId) -> Aabb {
        let hull = self.function.hull();
        match self.over(patch) {
            Over::Face(f) => {
                let face = &hull.faces()[f.index()];
                let corners = Aabb::around(&hull.data().corners(f));
                let cells = face.apexes.iter().flatten().fold(corners, |b, apex| b.including(apex));
                let cells = match (self.dips(f), face.apexes.iter().flatten().next()) {
                    // Behind the base it goes as far as the apex at most.
                    (true, Some(apex)) => {
                        let center: Point3 = hull.data().corners(f).iter().sum::<Point3>() / 3.0;
                        let size = corners.diagonal() + (apex - center).norm();
                        cells.grown(size)
                    }
                    _ => cells,
                };
                self.function.creased_face(f).map_or(cells, |creased| cells.plus(&creased.corrections()))
            }
            Over::Edge(e) => {
                let cells = Side::BOTH.into_iter().filter_map(|side| self.function.edge_cell(e, side));
                cells.fold(Aabb::EMPTY, |b, cell| b.union(&Aabb::around(&cell)))
            }
        }
    }

    fn part_bounds(&self, patch: PatchId, triangle: [[f64; 2]; 3]) -> Aabb {
        match self.over(patch) {
            Over::Face(f) if self.dips(f) => self.bounds(patch),
            Over::Face(f) => self.function.face_part_bounds(f, triangle),
            Over::Edge(e) => self.function.edge_part_bounds(e, triangle),
        }
    }

    fn volume(&self) -> Option<&dyn Volume> {
        Some(self)
    }
}

impl APatchSurface {
    /// May the patch over a convex face go behind the face?
    fn dips(&self, f: FaceId) -> bool {
        let base = &self.function.faces()[f.index()].base;
        let sign = match self.function.hull().faces()[f.index()].class {
            Class::Positive => 1.0,
            Class::Negative => -1.0,
            Class::Zero | Class::Nonconvex => return false,
        };
        base.middle.iter().any(|f| sign * f > 0.0)
    }
}
