use super::layout::*;
use super::read::{NativeError, Sections, check_length};
use super::read_a_patches::{class, flags, vectors, wrong_code};
use crate::geom::Vec3;
use crate::hull::{Class, Side};
use crate::hybrid::{
    Element, HermitePolygons, HybridEdge, HybridFace, HybridFunction, HybridHull, HybridSurface, Jet, Quadric,
};
use crate::mesh::{EdgeId, HalfEdgeMesh, MeshError};

/// The surface of a file with sections of hybrid A-patches.
pub(super) fn hybrid(sections: &Sections<'_>) -> Result<HybridSurface, NativeError> {
    let mesh = polygons(sections.get(POLYGONS)?)?;
    let (vertices, corners, edges) = (mesh.vertex_count(), mesh.half_edge_count(), mesh.edge_count());
    let positions = vectors(&sections.numbers(POSITIONS, vertices, POINT)?);
    let gradients = vectors(&sections.numbers(GRADIENTS, corners, POINT)?);
    let middles = vectors(&sections.numbers(MIDDLES, corners, POINT)?);
    let sharp = flags(sections.sized(CREASES, edges, 1)?)?;
    let faces = faces(sections, mesh.face_count())?;
    let mut data = HermitePolygons::with_creases(mesh, positions, gradients, sharp)?;
    data.set_middles(middles);
    let edges = data.mesh().edges().map(|e| edge(&data, &faces, e)).collect();
    Ok(HybridSurface::new(HybridFunction::new(HybridHull { data, faces, edges })))
}

fn polygons(section: &[u8]) -> Result<HalfEdgeMesh, NativeError> {
    let (numbers, rest) = section.as_chunks::<4>();
    let numbers: Vec<u32> = numbers.iter().map(|n| u32::from_le_bytes(*n)).collect();
    let [vertices, faces, ref rest_numbers @ ..] = numbers[..] else {
        return Err(NativeError::Truncated("section HFAC"));
    };
    let sizes = rest_numbers.get(..faces as usize).ok_or(NativeError::Truncated("section HFAC"))?;
    let mut corners = &rest_numbers[sizes.len()..];
    let total: u64 = sizes.iter().map(|size| u64::from(*size)).sum();
    check_length(POLYGONS, section, 4 * (2 + u64::from(faces) + total) + rest.len() as u64)?;
    // Every vertex belongs to a face, so a larger count is wrong; it must not set memory aside.
    if vertices as usize > corners.len() {
        return Err(MeshError::IsolatedVertex { vertex: vertices - 1 }.into());
    }
    let mut polygons: Vec<&[u32]> = Vec::with_capacity(sizes.len());
    for size in sizes {
        let (polygon, others) =
            corners.split_at_checked(*size as usize).ok_or(NativeError::Truncated("section HFAC"))?;
        polygons.push(polygon);
        corners = others;
    }
    Ok(HalfEdgeMesh::from_faces(vertices as usize, &polygons)?)
}

fn faces(sections: &Sections<'_>, count: usize) -> Result<Vec<HybridFace>, NativeError> {
    let codes = sections.sized(ELEMENTS, count, ELEMENT_BYTES)?;
    let numbers = sections.numbers(LINES, count, 8 * LINE_NUMBERS)?;
    let (codes, _) = codes.as_chunks::<ELEMENT_BYTES>();
    codes
        .iter()
        .enumerate()
        .zip(numbers.chunks_exact(LINE_NUMBERS))
        .map(|((f, c), n)| face(f, *c, n))
        .collect()
}

fn face(index: usize, codes: [u8; ELEMENT_BYTES], n: &[f64]) -> Result<HybridFace, NativeError> {
    let wrong = |code: u8| wrong_code(ELEMENTS, index, u32::from(code));
    let [of_class, element, apexes, jets] = codes;
    let class: Class = class(of_class).ok_or_else(|| wrong(of_class))?;
    let element = match element {
        0 => None,
        1 => Some(Element::Triangle),
        2 => Some(Element::Pyramid),
        3 => Some(Element::Fan),
        4 => Some(Element::Sectors),
        _ => return Err(wrong(element)),
    };
    if let Some(code) = [apexes, jets].into_iter().find(|bits| *bits > 3) {
        return Err(wrong(code));
    }
    let at = |from: usize| Vec3::new(n[from], n[from + 1], n[from + 2]);
    let has = |bits: u8, side: Side| bits >> side.index() & 1 == 1;
    // Centre and normal, then apex, value and gradient on each side.
    let of = |side: Side| 6 + 7 * side.index();
    let jet = |side: Side| Jet { value: n[of(side) + 3], gradient: at(of(side) + 4) };
    let quadric = &n[20..];
    Ok(HybridFace {
        class,
        element,
        center: at(0),
        normal: at(3),
        apexes: Side::BOTH.map(|side| has(apexes, side).then(|| at(of(side)))),
        at_apex: Side::BOTH.map(|side| has(jets, side).then(|| jet(side))),
        quadric: Quadric {
            coefficients: std::array::from_fn(|k| quadric[k]),
            center: at(30),
            scale: quadric[13],
        },
    })
}

/// A cell stands over an edge where both faces have an apex.
fn edge(data: &HermitePolygons, faces: &[HybridFace], e: EdgeId) -> HybridEdge {
    let both = data.joint(e).map(|pair| pair.map(|h| &faces[data.mesh().face(h).index()]));
    let has_cell =
        |side: Side| both.is_some_and(|both| both.iter().all(|face| face.apexes[side.index()].is_some()));
    HybridEdge { class: data.edge_class(data.mesh().edge_half_edge(e)), cells: Side::BOTH.map(has_cell) }
}
