use super::layout::*;
use super::read::{NativeError, Sections, check_length};
use crate::geom::{Point3, Vec3};
use crate::rational::{Frame, FrameSeam, RationalParts, RationalSurface};

/// The surface of a file with sections of rational patches.
pub(super) fn rational(sections: &Sections<'_>) -> Result<RationalSurface, NativeError> {
    let (vertices, faces) = triangles(sections.get(TRIANGLES)?)?;
    let positions = vectors(&sections.numbers(POINTS, vertices, POINT)?);
    let normals = vectors(&sections.numbers(NORMALS, 3 * faces.len(), POINT)?);
    let normal = |n: &Vec3| Some(*n).filter(|n| *n != Vec3::zeros());
    let frame = Frame {
        positions,
        normals: normals.as_chunks::<3>().0.iter().map(|n| n.each_ref().map(normal)).collect(),
        seams: seams(sections.get(SEAMS)?)?,
        faces,
    };
    let wires = frame.wire_count();
    let starts = sections.sized(WIRE_STARTS, wires, 4)?;
    let inner = vectors(&sections.numbers(WIRES, wires, 2 * POINT)?);
    let numbers = sections.numbers(CORRECTIONS, frame.faces.len(), 8 * CORRECTION_NUMBERS)?;
    let patch = |n: &[f64]| {
        let v = vectors(n);
        let across = |k: usize| [v[1 + 4 * k], v[2 + 4 * k], v[3 + 4 * k], v[4 + 4 * k]];
        (v[0], [0, 1, 2].map(across), v[13])
    };
    Ok(RationalSurface::from_parts(RationalParts {
        frame,
        wire_starts: starts.as_chunks().0.iter().map(|n| u32::from_le_bytes(*n)).collect(),
        wires: inner.as_chunks::<2>().0.to_vec(),
        patches: numbers.chunks_exact(CORRECTION_NUMBERS).map(patch).collect(),
    })?)
}

/// The number of vertices, and those of each triangle.
fn triangles(section: &[u8]) -> Result<(usize, Vec<[u32; 3]>), NativeError> {
    let numbers: Vec<u32> = section.as_chunks().0.iter().map(|n| u32::from_le_bytes(*n)).collect();
    let [vertices, faces, corners @ ..] = &numbers[..] else {
        return Err(NativeError::Truncated("section RTRI"));
    };
    // The two counts, and three numbers a triangle, of four bytes each.
    check_length(TRIANGLES, section, 8 + 12 * u64::from(*faces))?;
    Ok((*vertices as usize, corners.as_chunks().0.to_vec()))
}

fn seams(section: &[u8]) -> Result<Vec<FrameSeam>, NativeError> {
    let count = section.len() / SEAM;
    check_length(SEAMS, section, (count * SEAM) as u64)?;
    let seam = |(index, bytes): (usize, &[u8; SEAM])| {
        let number = |i: usize| u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
        let [edge, other, smooth, _] = [bytes[12], bytes[13], bytes[14], bytes[15]];
        // Wires are numbered without gaps, so none has a larger number than there are seams.
        if smooth > 1 || number(8) as usize >= count {
            let code = if smooth > 1 { u32::from(smooth) } else { number(8) };
            return Err(NativeError::Code { section: SEAMS.to_string(), index, code });
        }
        let second = Some((number(4), other)).filter(|(face, _)| *face != NO_FACE);
        Ok(FrameSeam { first: (number(0), edge), second, smooth: smooth == 1, wire: number(8) })
    };
    section.as_chunks().0.iter().enumerate().map(seam).collect()
}

fn vectors(numbers: &[f64]) -> Vec<Point3> {
    numbers.as_chunks::<3>().0.iter().map(|n| Vec3::from(*n)).collect()
}
