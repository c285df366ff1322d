use super::Provenance;
use super::layout::*;
use super::write::{Section, meta, points, write_sections};
use super::write_a_patches::class_code;
use crate::geom::{Point3, Vec3};
use crate::hull::Side;
use crate::hybrid::{Element, HybridFace, HybridSurface};
use crate::io::WriteError;
use crate::mesh::HalfEdgeMesh;
use std::io::Write;

/// Writes a surface of hybrid A-patches: its mesh of polygons, gradients, and what stands over each face, from which
/// [`super::read_native`] makes the same coefficients again, bit for bit.
///
/// # Errors
/// [`WriteError::Coefficient`] for a number that is not finite.
pub fn write_native_hybrid(
    surface: &HybridSurface,
    provenance: &Provenance,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let hull = surface.function().hull();
    let (data, mesh) = (&hull.data, hull.data.mesh());
    let vectors = |of: fn(&crate::hybrid::HermitePolygons, crate::mesh::HalfEdgeId) -> Vec3| {
        let all: Vec<Vec3> = mesh.half_edges().map(|h| of(data, h)).collect();
        points(all.iter())
    };
    let sections = [
        Section::new(META, || meta(provenance)),
        Section::new(POLYGONS, || Ok(polygons(mesh))),
        Section::new(POSITIONS, || Ok(points(data.positions().iter()))),
        Section::new(GRADIENTS, || Ok(vectors(|data, h| data.gradient(h)))),
        Section::new(MIDDLES, || Ok(vectors(|data, h| data.middle(h)))),
        Section::new(CREASES, || Ok(mesh.edges().map(|e| data.is_crease(e).into()).collect())),
        Section::new(ELEMENTS, || Ok(hull.faces.iter().flat_map(codes).collect())),
        Section::new(LINES, || lines(&hull.faces)),
    ];
    write_sections(&sections, out)
}

/// Numbers of vertices and faces; the number of corners of each face; all corners.
fn polygons(mesh: &HalfEdgeMesh) -> Vec<u8> {
    let counts = [mesh.vertex_count() as u32, mesh.face_count() as u32];
    let sizes = mesh.faces().map(|f| mesh.face_half_edges(f).len() as u32);
    let corners = mesh.half_edges().map(|h| mesh.origin(h).0);
    counts.into_iter().chain(sizes).chain(corners).flat_map(u32::to_le_bytes).collect()
}

/// Class, element, which apexes there are, and which of them have values of their own.
fn codes(face: &HybridFace) -> [u8; ELEMENT_BYTES] {
    let element = match face.element {
        None => 0,
        Some(Element::Triangle) => 1,
        Some(Element::Pyramid) => 2,
        Some(Element::Fan) => 3,
        Some(Element::Sectors) => 4,
    };
    let bits = |has: [bool; 2]| u8::from(has[0]) + 2 * u8::from(has[1]);
    let apexes = bits(face.apexes.map(|a| a.is_some()));
    [class_code(face.class), element, apexes, bits(face.at_apex.map(|jet| jet.is_some()))]
}

fn lines(faces: &[HybridFace]) -> Result<Vec<u8>, WriteError> {
    let mut numbers: Vec<f64> = Vec::with_capacity(LINE_NUMBERS * faces.len());
    let vector = |v: Option<Point3>| <[f64; 3]>::from(v.unwrap_or_else(Vec3::zeros));
    for face in faces {
        numbers.extend(vector(Some(face.center)));
        numbers.extend(vector(Some(face.normal)));
        for side in Side::BOTH {
            numbers.extend(vector(face.apexes[side.index()]));
            let jet = face.at_apex[side.index()];
            numbers.push(jet.map_or(0.0, |jet| jet.value));
            numbers.extend(vector(jet.map(|jet| jet.gradient)));
        }
        numbers.extend(face.quadric.coefficients);
        numbers.extend(vector(Some(face.quadric.center)));
        numbers.push(face.quadric.scale);
    }
    if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
        return Err(WriteError::Coefficient { section: LINES.to_string(), index });
    }
    Ok(numbers.into_iter().flat_map(f64::to_le_bytes).collect())
}
