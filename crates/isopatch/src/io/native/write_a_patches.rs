use super::Provenance;
use super::layout::*;
use super::write::{Section, faces, meta, points, write_sections};
use crate::apatch::{APatchFunction, APatchSurface, EdgeSide, FaceSide};
use crate::geom::Point3;
use crate::hull::{Class, EdgeCell, Hull, Problem, Reason};
use crate::io::WriteError;
use std::io::Write;

/// Writes a surface of A-patches with its hull and all coefficients, so that [`super::read_native`] gives it back bit for bit.
///
/// # Errors
/// [`WriteError::Coefficient`] for a coefficient that is not finite.
pub fn write_native_a_patches(
    surface: &APatchSurface,
    provenance: &Provenance,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let function = surface.function();
    let hull = function.hull();
    let data = hull.data();
    let mesh = data.mesh();
    let functions = function.faces();
    let gradients = || mesh.half_edges().flat_map(|h| <[f64; 3]>::from(data.gradient(h)));
    let bases = || functions.iter().flat_map(|face| face.base.data());
    let sections = [
        Section::new(META, || meta(provenance)),
        Section::new(FACES, || Ok(faces(mesh))),
        Section::new(POSITIONS, || Ok(points(data.positions().iter()))),
        Section::new(GRADIENTS, || Ok(numbers(3 * mesh.half_edge_count(), gradients()))),
        Section::new(CREASES, || Ok(mesh.edges().map(|e| data.is_crease(e).into()).collect())),
        Section::new(FACE_CLASSES, || Ok(hull.faces().iter().map(|face| class_code(face.class)).collect())),
        Section::new(EDGE_CLASSES, || Ok(hull.edges().iter().map(|edge| class_code(edge.class)).collect())),
        Section::new(RAYS, || Ok(rays(hull))),
        Section::new(BASES, || finite(BASES, numbers(BASE_NUMBERS * functions.len(), bases()))),
        Section::new(FACE_CELLS, || finite(FACE_CELLS, face_cells(function))),
        Section::new(EDGE_CELLS, || finite(EDGE_CELLS, edge_cells(function))),
        Section::new(FREE, || Ok(free(function))),
        Section::new(NOTES, || Ok(notes(hull))),
    ];
    write_sections(&sections, out)
}

/// The bytes of `count` numbers.
fn numbers(count: usize, numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(count * size_of::<f64>());
    numbers.for_each(|number| bytes.extend_from_slice(&number.to_le_bytes()));
    bytes
}

/// The bytes, if they are those of finite numbers.
fn finite(tag: Tag, bytes: Vec<u8>) -> Result<Vec<u8>, WriteError> {
    let is_bad = |number: &[u8; 8]| !f64::from_le_bytes(*number).is_finite();
    match bytes.as_chunks().0.iter().position(is_bad) {
        Some(index) => Err(WriteError::Coefficient { section: tag.to_string(), index }),
        None => Ok(bytes),
    }
}

pub(super) fn class_code(class: Class) -> u8 {
    match class {
        Class::Positive => 0,
        Class::Negative => 1,
        Class::Zero => 2,
        Class::Nonconvex => 3,
    }
}

fn rays(hull: &Hull) -> Vec<u8> {
    let of = |face: &crate::hull::HullFace| {
        let [x, y, z] = face.direction.into();
        [x, y, z, face.heights[0], face.heights[1]]
    };
    numbers(RAY_NUMBERS * hull.faces().len(), hull.faces().iter().flat_map(of))
}

fn face_cells(function: &APatchFunction) -> Vec<u8> {
    let of = |(apex, side): (&Point3, &FaceSide)| -> [f64; FACE_CELL_NUMBERS] {
        let parts = [<[f64; 3]>::from(*apex), side.layer1.corner, side.layer1.edge, side.q];
        std::array::from_fn(|n| parts[n / 3][n % 3])
    };
    let cells = || {
        let faces = function.hull().faces().iter().zip(function.faces());
        faces.flat_map(|(face, made)| face.apexes.iter().flatten().zip(made.sides.iter().flatten()))
    };
    numbers(FACE_CELL_NUMBERS * cells().count(), cells().flat_map(of))
}

fn edge_cells(function: &APatchFunction) -> Vec<u8> {
    let of = |(cell, side): (&EdgeCell, &EdgeSide)| -> [f64; EDGE_CELL_NUMBERS] {
        let ([m_0, m_1, m_2, m_3], [n_0, n_1, n_2, n_3]) = (cell.mu, cell.nu);
        let ([b_0, b_1], [a_0, a_1], [f_0, f_1]) = (side.b, side.a, side.far);
        [m_0, m_1, m_2, m_3, n_0, n_1, n_2, n_3, cell.angle, b_0, b_1, a_0, a_1, f_0, f_1]
    };
    let cells = || {
        let edges = function.hull().edges().iter().zip(function.edges());
        edges.flat_map(|(edge, sides)| edge.cells.iter().flatten().zip(sides.iter().flatten()))
    };
    numbers(EDGE_CELL_NUMBERS * cells().count(), cells().flat_map(of))
}

fn free(function: &APatchFunction) -> Vec<u8> {
    let faces = function.default_free().iter().zip(function.sufficient_free()).zip(function.free());
    let of = |((default, bound), free): ((&[f64; 2], &[f64; 2]), &[f64; 2])| {
        [*default, *bound, *free].into_iter().flatten()
    };
    numbers(FREE_NUMBERS * function.free().len(), faces.flat_map(of))
}

/// The place in [`Reason::ALL`].
pub(super) fn reason_code(reason: Reason) -> u8 {
    match reason {
        Reason::NoVisibleNormal => 0,
        Reason::ApexOverlap => 1,
        Reason::FlatEdgeCell => 2,
        Reason::SteepApex => 3,
        Reason::NoApex => 4,
        Reason::CreaseTurns => 5,
        Reason::Folds => 6,
    }
}

/// What is wrong, and what was changed for less to be wrong.
fn notes(hull: &Hull) -> Vec<u8> {
    let of_problem = |problem: &Problem| match problem {
        Problem::Vertex { vertex, reason: why } => (0, reason_code(*why), vertex.0),
        Problem::Face { face, reason: why } => (1, reason_code(*why), face.0),
        Problem::Edge { edge, reason: why, .. } => (2, reason_code(*why), edge.0),
    };
    let moved = hull.moved_normals().iter().map(|vertex| (3, NO_REASON, vertex.0));
    let corners = hull.corners().iter().map(|corner| (4, reason_code(corner.reason), corner.vertex.0));
    let creases = hull.added_creases().iter().map(|crease| (5, reason_code(crease.reason), crease.edge.0));
    let notes = hull.problems().iter().map(of_problem).chain(moved).chain(corners).chain(creases);
    let bytes = |(what, why, element): (u8, u8, u32)| {
        let [a, b, c, d] = element.to_le_bytes();
        [what, why, 0, 0, a, b, c, d]
    };
    notes.flat_map(bytes).collect()
}
