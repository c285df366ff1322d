use super::Provenance;
use super::layout::*;
use super::write::{Section, meta, points, write_sections};
use crate::geom::{Point3, Vec3};
use crate::io::WriteError;
use crate::rational::{FrameSeam, RationalParts, RationalSurface};
use std::io::Write;

/// Writes a surface of rational patches so that [`super::read_native`] gives it back bit for bit.
///
/// # Errors
/// [`WriteError::NotFinite`].
pub fn write_native_rational(
    surface: &RationalSurface,
    provenance: &Provenance,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let parts = surface.parts();
    check(&parts)?;
    let frame = &parts.frame;
    let sections = [
        Section::new(META, || meta(provenance)),
        Section::new(TRIANGLES, || Ok(triangles(&parts))),
        Section::new(POINTS, || Ok(points(frame.positions.iter()))),
        Section::new(NORMALS, || {
            let normals: Vec<Vec3> = frame.normals.iter().flatten().map(|n| n.unwrap_or_default()).collect();
            Ok(points(normals.iter()))
        }),
        Section::new(WIRE_STARTS, || Ok(parts.wire_starts.iter().flat_map(|v| v.to_le_bytes()).collect())),
        Section::new(WIRES, || Ok(points(parts.wires.iter().flatten()))),
        Section::new(SEAMS, || Ok(frame.seams.iter().flat_map(seam).collect())),
        Section::new(CORRECTIONS, || Ok(parts.patches.iter().flat_map(patch).collect())),
    ];
    write_sections(&sections, out)
}

fn check(parts: &RationalParts) -> Result<(), WriteError> {
    let finite = |p: &Point3| p.iter().all(|c| c.is_finite());
    let bad = parts.patches.iter().position(|(center, across, middle)| {
        !finite(center) || !finite(middle) || !across.iter().flatten().all(finite)
    });
    if let Some(index) = bad {
        return Err(WriteError::NotFinite { what: "patch", index });
    }
    let bad = parts.wires.iter().position(|wire| !wire.iter().all(finite));
    bad.map_or(Ok(()), |index| Err(WriteError::NotFinite { what: "wire", index }))
}

fn triangles(parts: &RationalParts) -> Vec<u8> {
    let frame = &parts.frame;
    let counts = [frame.positions.len() as u32, frame.faces.len() as u32];
    counts.into_iter().chain(frame.faces.iter().flatten().copied()).flat_map(u32::to_le_bytes).collect()
}

fn seam(seam: &FrameSeam) -> Vec<u8> {
    let (second, edge) = seam.second.unwrap_or((NO_FACE, 0));
    let mut bytes: Vec<u8> =
        [seam.first.0, second, seam.wire].into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend([seam.first.1, edge, u8::from(seam.smooth), 0]);
    bytes
}

fn patch((center, across, middle): &(Point3, [[Vec3; 4]; 3], Vec3)) -> Vec<u8> {
    let mut bytes = points(std::iter::once(center));
    bytes.extend(points(across.iter().flatten()));
    bytes.extend(points(std::iter::once(middle)));
    bytes
}
