use super::layout::*;
use super::read::{NativeError, Sections, check_length};
use crate::apatch::{APatchFunction, APatchParts, APatchSurface, Base, EdgeSide, FaceFunction, FaceSide};
use crate::geom::Vec3;
use crate::hull::{
    AddedCrease, Class, Corner, EdgeCell, HermiteMesh, Hull, HullEdge, HullFace, HullParts, Layer1, Problem,
    Reason, Side,
};
use crate::mesh::{EdgeId, FaceId, HalfEdgeMesh, VertexId};

/// The surface of a file with sections of A-patches.
pub(super) fn a_patches(sections: &Sections<'_>, mesh: HalfEdgeMesh) -> Result<APatchSurface, NativeError> {
    let (vertices, faces, edges) = (mesh.vertex_count(), mesh.face_count(), mesh.edge_count());
    let positions = vectors(&sections.numbers(POSITIONS, vertices, POINT)?);
    let gradients = vectors(&sections.numbers(GRADIENTS, 3 * faces, POINT)?);
    let sharp = flags(sections.sized(CREASES, edges, 1)?)?;
    let data = HermiteMesh::with_creases(mesh, positions, gradients, sharp)?;

    let (hull_faces, functions) = read_faces(sections, faces)?;
    let (hull_edges, sides) = read_edges(sections, &data, &hull_faces)?;
    let free = free(sections, faces)?;
    let mut parts = HullParts {
        data,
        faces: hull_faces,
        edges: hull_edges,
        problems: Vec::new(),
        moved_normals: Vec::new(),
        corners: Vec::new(),
        added_creases: Vec::new(),
    };
    notes(sections.get(NOTES)?, &mut parts)?;
    let of = |from: usize| free.iter().map(|n| [n[from], n[from + 1]]).collect();
    Ok(APatchSurface::new(APatchFunction::from(APatchParts {
        hull: Hull::from(parts),
        faces: functions,
        edges: sides,
        default_free: of(0),
        sufficient_free: of(2),
        free: of(4),
    })))
}

pub(super) fn vectors(numbers: &[f64]) -> Vec<Vec3> {
    numbers.as_chunks::<3>().0.iter().map(|n| Vec3::from(*n)).collect()
}

fn vector(numbers: &[f64]) -> Vec3 {
    Vec3::new(numbers[0], numbers[1], numbers[2])
}

fn triple(numbers: &[f64]) -> [f64; 3] {
    [numbers[0], numbers[1], numbers[2]]
}

pub(super) fn flags(codes: &[u8]) -> Result<Vec<bool>, NativeError> {
    let flag = |(index, code): (usize, &u8)| match code {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(wrong_code(CREASES, index, u32::from(*code))),
    };
    codes.iter().enumerate().map(flag).collect()
}

pub(super) fn wrong_code(tag: Tag, index: usize, code: u32) -> NativeError {
    NativeError::Code { section: tag.to_string(), index, code }
}

fn classes(sections: &Sections<'_>, tag: Tag, count: usize) -> Result<Vec<Class>, NativeError> {
    let found =
        |(index, code): (usize, &u8)| class(*code).ok_or_else(|| wrong_code(tag, index, u32::from(*code)));
    sections.sized(tag, count, 1)?.iter().enumerate().map(found).collect()
}

/// The class with a code.
pub(super) fn class(code: u8) -> Option<Class> {
    match code {
        0 => Some(Class::Positive),
        1 => Some(Class::Negative),
        2 => Some(Class::Zero),
        3 => Some(Class::Nonconvex),
        _ => None,
    }
}

/// Which cells there are follows from the classes: one on each side that the surface reaches into.
fn read_faces(
    sections: &Sections<'_>,
    count: usize,
) -> Result<(Vec<HullFace>, Vec<FaceFunction>), NativeError> {
    let classes = classes(sections, FACE_CLASSES, count)?;
    let cell_count =
        classes.iter().map(|class| Side::BOTH.iter().filter(|side| class.reaches(**side)).count()).sum();
    let rays = sections.numbers(RAYS, count, 8 * RAY_NUMBERS)?;
    let bases = sections.numbers(BASES, count, 8 * BASE_NUMBERS)?;
    let cells = sections.numbers(FACE_CELLS, cell_count, 8 * FACE_CELL_NUMBERS)?;
    let mut cells = cells.chunks_exact(FACE_CELL_NUMBERS);
    let faces = classes.iter().zip(rays.chunks_exact(RAY_NUMBERS)).zip(bases.chunks_exact(BASE_NUMBERS));
    Ok(faces
        .map(|((class, ray), base)| {
            let found = Side::BOTH.map(|side| if class.reaches(side) { cells.next() } else { None });
            let face = HullFace {
                class: *class,
                direction: vector(ray),
                heights: [ray[3], ray[4]],
                apexes: found.map(|cell| cell.map(vector)),
            };
            let side = |cell: &[f64]| FaceSide {
                layer1: Layer1 { corner: triple(&cell[3..]), edge: triple(&cell[6..]) },
                q: triple(&cell[9..]),
            };
            let sides = found.map(|cell| cell.map(side));
            (face, FaceFunction { base: layer_0(base, *class == Class::Nonconvex), sides })
        })
        .unzip())
}

/// From the nine data in the order of [`Base::data`].
fn layer_0(n: &[f64], split: bool) -> Base {
    let e = [[0.0, n[0], n[5]], [n[1], 0.0, n[2]], [n[4], n[3], 0.0]];
    Base { e, middle: triple(&n[6..]), split }
}

type Edges = (Vec<HullEdge>, Vec<[Option<EdgeSide>; 2]>);

/// An edge across which the surface is smooth has a cell on each side that the surface over it reaches into, if both faces
/// have cells there.
fn read_edges(sections: &Sections<'_>, data: &HermiteMesh, faces: &[HullFace]) -> Result<Edges, NativeError> {
    let mesh = data.mesh();
    let classes = classes(sections, EDGE_CLASSES, mesh.edge_count())?;
    let has_cell = |e: EdgeId, side: Side| {
        let beside =
            |joint: [_; 2]| joint.map(|h| faces[mesh.face(h).index()].apexes[side.index()].is_some());
        classes[e.index()].reaches(side) && data.joint(e).is_some_and(|joint| beside(joint) == [true; 2])
    };
    let cell_count = mesh.edges().map(|e| Side::BOTH.iter().filter(|side| has_cell(e, **side)).count()).sum();
    let cells = sections.numbers(EDGE_CELLS, cell_count, 8 * EDGE_CELL_NUMBERS)?;
    let mut cells = cells.chunks_exact(EDGE_CELL_NUMBERS);
    Ok(mesh
        .edges()
        .map(|e| {
            let found = Side::BOTH.map(|side| if has_cell(e, side) { cells.next() } else { None });
            let made = found.map(|numbers| numbers.map(edge_cell));
            let edge =
                HullEdge { class: classes[e.index()], cells: made.map(|made| made.map(|(cell, _)| cell)) };
            (edge, made.map(|made| made.map(|(_, side)| side)))
        })
        .unzip())
}

fn edge_cell(n: &[f64]) -> (EdgeCell, EdgeSide) {
    let cell = EdgeCell { mu: [n[0], n[1], n[2], n[3]], nu: [n[4], n[5], n[6], n[7]], angle: n[8] };
    let side = EdgeSide { reach: cell.reach(), b: [n[9], n[10]], a: [n[11], n[12]], far: [n[13], n[14]] };
    (cell, side)
}

/// Defaults, bounds and values; bounds may be infinite.
fn free(sections: &Sections<'_>, count: usize) -> Result<Vec<[f64; FREE_NUMBERS]>, NativeError> {
    let bytes = sections.sized(FREE, count, 8 * FREE_NUMBERS)?;
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|c| f64::from_le_bytes(*c)).collect();
    let is_bad = |(index, x): (usize, &f64)| match index % FREE_NUMBERS {
        2 | 3 => x.is_nan(),
        _ => !x.is_finite(),
    };
    match numbers.iter().enumerate().position(is_bad) {
        Some(index) => Err(NativeError::NotFinite { section: FREE.to_string(), index }),
        None => Ok(numbers.as_chunks().0.to_vec()),
    }
}

fn notes(section: &[u8], hull: &mut HullParts) -> Result<(), NativeError> {
    let count = section.len() / NOTE;
    check_length(NOTES, section, (count * NOTE) as u64)?;
    let mesh = hull.data.mesh();
    for (index, note) in section.as_chunks::<NOTE>().0.iter().enumerate() {
        let [what, why, _, _, a, b, c, d] = *note;
        let element = u32::from_le_bytes([a, b, c, d]);
        let below = |limit: usize| match (element as usize) < limit {
            true => Ok(element),
            false => Err(wrong_code(NOTES, index, element)),
        };
        let reason = || {
            Reason::ALL.get(usize::from(why)).copied().ok_or_else(|| wrong_code(NOTES, index, u32::from(why)))
        };
        match what {
            0 => {
                let vertex = VertexId(below(mesh.vertex_count())?);
                hull.problems.push(Problem::Vertex { vertex, reason: reason()? });
            }
            1 => {
                let face = FaceId(below(mesh.face_count())?);
                hull.problems.push(Problem::Face { face, reason: reason()? });
            }
            2 => {
                let edge = EdgeId(below(mesh.edge_count())?);
                let pair = hull.data.pair(edge).ok_or_else(|| wrong_code(NOTES, index, element))?;
                let faces = pair.map(|h| mesh.face(h));
                hull.problems.push(Problem::Edge { edge, faces, reason: reason()? });
            }
            3 => hull.moved_normals.push(VertexId(below(mesh.vertex_count())?)),
            4 => {
                let vertex = VertexId(below(mesh.vertex_count())?);
                hull.corners.push(Corner { vertex, reason: reason()? });
            }
            5 => {
                let edge = EdgeId(below(mesh.edge_count())?);
                hull.added_creases.push(AddedCrease { edge, reason: reason()? });
            }
            _ => return Err(wrong_code(NOTES, index, u32::from(what))),
        }
    }
    Ok(())
}
