use super::Provenance;
use super::layout::*;
use super::write::{faces, meta, points, write_sections};
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
    let sections = [
        (META, meta(provenance)?),
        (FACES, faces(mesh)),
        (POSITIONS, points(data.positions().iter())),
        (GRADIENTS, numbers(mesh.half_edges().flat_map(|h| <[f64; 3]>::from(data.gradient(h))))),
        (CREASES, mesh.edges().map(|e| data.is_crease(e).into()).collect()),
        (FACE_CLASSES, hull.faces().iter().map(|face| class_code(face.class)).collect()),
        (EDGE_CLASSES, hull.edges().iter().map(|edge| class_code(edge.class)).collect()),
        (RAYS, rays(hull)),
        (BASES, finite(BASES, numbers(function.faces().iter().flat_map(|face| face.base.data())))?),
        (FACE_CELLS, finite(FACE_CELLS, face_cells(function))?),
        (EDGE_CELLS, finite(EDGE_CELLS, edge_cells(function))?),
        (FREE, free(function)),
        (NOTES, notes(hull)),
    ];
    write_sections(&sections, out)
}

fn numbers(numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// The bytes, if they are those of finite numbers.
fn finite(tag: Tag, bytes: Vec<u8>) -> Result<Vec<u8>, WriteError> {
    let is_bad = |number: &[u8; 8]| !f64::from_le_bytes(*number).is_finite();
    match bytes.as_chunks().0.iter().position(is_bad) {
        Some(index) => Err(WriteError::Coefficient { section: tag.to_string(), index }),
        None => Ok(bytes),
    }
}

fn class_code(class: Class) -> u8 {
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
    numbers(hull.faces().iter().flat_map(of))
}

fn face_cells(function: &APatchFunction) -> Vec<u8> {
    let of = |(apex, side): (&Point3, &FaceSide)| -> [f64; FACE_CELL_NUMBERS] {
        let parts = [<[f64; 3]>::from(*apex), side.layer1.corner, side.layer1.edge, side.q];
        std::array::from_fn(|n| parts[n / 3][n % 3])
    };
    let cells = function.hull().faces().iter().zip(function.faces()).flat_map(|(face, coefficients)| {
        face.apexes.iter().flatten().zip(coefficients.sides.iter().flatten())
    });
    numbers(cells.flat_map(of))
}

fn edge_cells(function: &APatchFunction) -> Vec<u8> {
    let of = |(cell, side): (&EdgeCell, &EdgeSide)| {
        let wedge = cell.mu.into_iter().chain(cell.nu).chain([cell.angle]);
        wedge.chain(side.b).chain(side.a).chain(side.far).collect::<Vec<f64>>()
    };
    let cells = function
        .hull()
        .edges()
        .iter()
        .zip(function.edges())
        .flat_map(|(edge, sides)| edge.cells.iter().flatten().zip(sides.iter().flatten()));
    numbers(cells.flat_map(of))
}

fn free(function: &APatchFunction) -> Vec<u8> {
    let faces = function.default_free().iter().zip(function.sufficient_free()).zip(function.free());
    numbers(faces.flat_map(|((default, bound), free)| [*default, *bound, *free].into_iter().flatten()))
}

/// What is wrong, and what was changed for less to be wrong.
fn notes(hull: &Hull) -> Vec<u8> {
    let reason =
        |reason: Reason| Reason::ALL.iter().position(|r| *r == reason).map_or(NO_REASON, |r| r as u8);
    let of_problem = |problem: &Problem| match problem {
        Problem::Vertex { vertex, reason: why } => (0, reason(*why), vertex.0),
        Problem::Face { face, reason: why } => (1, reason(*why), face.0),
        Problem::Edge { edge, reason: why, .. } => (2, reason(*why), edge.0),
    };
    let moved = hull.moved_normals().iter().map(|vertex| (3, NO_REASON, vertex.0));
    let corners = hull.corners().iter().map(|corner| (4, reason(corner.reason), corner.vertex.0));
    let creases = hull.added_creases().iter().map(|crease| (5, reason(crease.reason), crease.edge.0));
    let notes = hull.problems().iter().map(of_problem).chain(moved).chain(corners).chain(creases);
    let bytes = |(what, why, element): (u8, u8, u32)| {
        let [a, b, c, d] = element.to_le_bytes();
        [what, why, 0, 0, a, b, c, d]
    };
    notes.flat_map(bytes).collect()
}
