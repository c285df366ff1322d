//! Binary glTF 2.0.

use super::text::Buffers;
use super::{ThinParts, Unit, WriteError, error};
use crate::geom::{Aabb, Point3, Points, Vec3};
use crate::tessellate::{APatchTriangles, Tessellation};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How to write a .glb file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GlbOptions {
    /// Length of a model unit: glTF is in metres. Default: millimetre.
    pub unit: Unit,
}

// Numbers of the specification, glTF 2.0 section 3.6.2 and 4.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERSION: u32 = 2;
/// Drawing modes.
const POINTS: u32 = 0;
const LINES: u32 = 1;
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";
/// Bytes of the file header, and of the header of a chunk.
const FILE_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Writes one mesh. Positions are single precision, relative to the centre of the bounding box, which is the
/// translation of the mesh's node; its parent turns z up to y up and model units to metres. A vertex on a crease is there once for
/// each of its normals.
pub fn write_glb(mesh: &Tessellation, options: &GlbOptions, out: &mut impl Write) -> Result<(), WriteError> {
    write_glb_with(mesh, &ThinParts::default(), options, out)
}

/// The same, and thin parts as primitives of their own: points, and pairs of points for lines.
pub fn write_glb_with(
    mesh: &Tessellation,
    thin: &ThinParts,
    options: &GlbOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    let mesh = &*mesh.with_split_creases();
    let bounds = Aabb::around(&mesh.positions);
    let center = if bounds.is_empty() { Vec3::zeros() } else { bounds.center() };
    let ends = |curve: &Vec<Point3>| curve.windows(2).flat_map(|w| [w[0], w[1]]).collect::<Vec<_>>();
    let lines: Vec<Point3> = thin.curves.iter().flat_map(ends).collect();
    let more = [(POINTS, &thin.points), (LINES, &lines)];
    let binary =
        mesh.positions.len() * 24 + mesh.triangles.len() * 12 + (thin.points.len() + lines.len()) * 12;
    let counts = [mesh.positions.len(), mesh.triangles.len()];
    let mut scene = scene(counts, &bounds, &center, options.unit);
    more.iter().for_each(|(mode, points)| add_primitive(&mut scene, *mode, points, &center));
    write_head(&scene, binary, out)?;
    let mut buffers = Buffers::default();
    buffers.write_items(out, mesh.positions.len(), |v, bytes| {
        push_vector(bytes, relative(&mesh.positions[v], &center))
    })?;
    buffers.write_items(out, mesh.normals.len(), |v, bytes| {
        push_vector(bytes, relative(&mesh.normals[v], &Vec3::zeros()));
    })?;
    buffers.write_items(out, mesh.triangles.len(), |t, bytes| push_triangle(bytes, mesh.triangles[t]))?;
    for (_, points) in more {
        buffers
            .write_items(out, points.len(), |v, bytes| push_vector(bytes, relative(&points[v], &center)))?;
    }
    Ok(())
}

/// Writes A-patches without creases, as [`write_glb`] writes their tessellation, whose `bounds` are given. Parts are made when their
/// bytes are due: there is never the whole mesh, and what that would take in memory takes longer than to compute points again.
pub fn write_glb_of_a_patches(
    triangles: &APatchTriangles<'_>,
    bounds: &Aabb,
    options: &GlbOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let center = bounds.center();
    let counts = [triangles.point_count(), triangles.triangle_count()];
    write_head(&scene(counts, bounds, &center, options.unit), counts[0] * 24 + counts[1] * 12, out)?;
    let room = || [Points::default(), Points::default()];
    let mut buffers = Buffers::default();
    buffers.write_items_with(out, triangles.point_parts(), room, |[points, normals], part, bytes| {
        triangles.points(part, false, points, normals);
        push_vectors(bytes, points, &center);
    })?;
    // The first normal that is none.
    let bad = AtomicUsize::new(usize::MAX);
    buffers.write_items_with(out, triangles.point_parts(), room, |[points, normals], part, bytes| {
        triangles.points(part, true, points, normals);
        push_vectors(bytes, normals, &Vec3::zeros());
        let is_finite = |v: Vec3| v.x.is_finite() & v.y.is_finite() & v.z.is_finite();
        if let Some(i) = (0..normals.len()).find(|i| !is_finite(normals.get(*i))) {
            bad.fetch_min(triangles.first_point(part) + i, Ordering::Relaxed);
        }
    })?;
    match bad.into_inner() {
        usize::MAX => {}
        index => return Err(WriteError::NotFinite { what: "vertex", index }),
    }
    Ok(buffers.write_items_with(out, triangles.triangle_parts(), Vec::new, |numbers, part, bytes| {
        triangles.part_triangles(part, numbers, |t| push_triangle(bytes, t));
    })?)
}

/// Writes all that comes before the binary data, of which there are so many bytes.
fn write_head(scene: &Value, binary: usize, out: &mut impl Write) -> Result<(), WriteError> {
    let mut scene = scene.to_string().into_bytes();
    // Chunks are padded to four bytes, JSON with spaces.
    scene.resize(scene.len().next_multiple_of(4), b' ');
    let total = FILE_HEADER + 2 * CHUNK_HEADER + scene.len() + binary;
    let total = u32::try_from(total).map_err(|_| WriteError::TooMany {
        format: "GLB",
        what: "bytes",
        count: total,
    })?;
    out.write_all(b"glTF")?;
    out.write_all(&VERSION.to_le_bytes())?;
    out.write_all(&total.to_le_bytes())?;
    out.write_all(&(scene.len() as u32).to_le_bytes())?;
    out.write_all(JSON_CHUNK)?;
    out.write_all(&scene)?;
    out.write_all(&(binary as u32).to_le_bytes())?;
    out.write_all(BINARY_CHUNK)?;
    Ok(())
}

fn push_vector(bytes: &mut Vec<u8>, v: [f32; 3]) {
    push_words(bytes, v.map(f32::to_bits));
}

/// Many of them: room is asked for once.
fn push_vectors(bytes: &mut Vec<u8>, vectors: &Points, center: &Vec3) {
    let start = bytes.len();
    bytes.resize(start + vectors.len() * VECTOR, 0);
    for (i, bytes) in bytes[start..].chunks_exact_mut(VECTOR).enumerate() {
        bytes.copy_from_slice(&little_endian(relative(&vectors.get(i), center).map(f32::to_bits)));
    }
}

#[inline]
fn push_triangle(bytes: &mut Vec<u8>, triangle: [u32; 3]) {
    push_words(bytes, triangle);
}

/// Little-endian, at once: each addition to a vector asks whether there is room.
#[inline]
fn push_words(bytes: &mut Vec<u8>, words: [u32; 3]) {
    bytes.extend_from_slice(&little_endian(words));
}

/// Bytes of a vector or a triangle.
const VECTOR: usize = 12;

#[inline]
fn little_endian(words: [u32; 3]) -> [u8; VECTOR] {
    let [a, b, c] = words.map(u32::to_le_bytes);
    [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], c[0], c[1], c[2], c[3]]
}

/// Adds points of a drawing mode after what the scene has; nothing where there are none, or no triangles.
fn add_primitive(scene: &mut Value, mode: u32, points: &[Point3], center: &Vec3) {
    let (Some(length), false) = (scene["buffers"][0]["byteLength"].as_u64(), points.is_empty()) else {
        return;
    };
    let bounds = Aabb::around(points);
    let accessor = json!({ "bufferView": 0, "componentType": FLOAT, "count": points.len(), "type": "VEC3",
        "min": relative(&bounds.min, center), "max": relative(&bounds.max, center) });
    let bytes = 12 * points.len() as u64;
    let view = json!({ "buffer": 0, "byteOffset": length, "byteLength": bytes, "target": ARRAY_BUFFER });
    let mut push = |list: &str, value: Value| -> Option<usize> {
        let list = scene[list].as_array_mut()?;
        list.push(value);
        Some(list.len() - 1)
    };
    let view = push("bufferViews", view);
    let accessor = push("accessors", accessor);
    if let (Some(view), Some(accessor)) = (view, accessor) {
        scene["accessors"][accessor]["bufferView"] = json!(view);
        let primitive = json!({ "attributes": { "POSITION": accessor }, "mode": mode, "material": 0 });
        if let Some(list) = scene["meshes"][0]["primitives"].as_array_mut() {
            list.push(primitive);
        }
        scene["buffers"][0]["byteLength"] = json!(length + bytes);
    }
}

fn relative(p: &Vec3, center: &Vec3) -> [f32; 3] {
    let r = p - center;
    [r.x as f32, r.y as f32, r.z as f32]
}

fn scene([vertices, triangles]: [usize; 2], bounds: &Aabb, center: &Vec3, unit: Unit) -> Value {
    let indices = 3 * triangles;
    let generator = concat!("isopatch ", env!("CARGO_PKG_VERSION"));
    let mut document = json!({
        "asset": { "version": "2.0", "generator": generator },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
    });
    // glTF has no empty meshes.
    let children: &[u32] = if indices == 0 { &[] } else { &[1] };
    let metres = unit.metres();
    let mut root = json!({ "name": "isopatch", "rotation": [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2], "scale": [metres, metres, metres] });
    if children.is_empty() {
        document["nodes"] = json!([root]);
        return document;
    }
    root["children"] = json!(children);
    document["nodes"] = json!([root, { "name": "surface", "mesh": 0, "translation": center.as_slice() }]);
    document["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }]);
    document["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5 } }]);
    document["accessors"] = json!([
        { "bufferView": 0, "componentType": FLOAT, "count": vertices, "type": "VEC3",
          "min": relative(&bounds.min, center), "max": relative(&bounds.max, center) },
        { "bufferView": 1, "componentType": FLOAT, "count": vertices, "type": "VEC3" },
        { "bufferView": 2, "componentType": UNSIGNED_INT, "count": indices, "type": "SCALAR" },
    ]);
    let vectors = 12 * vertices;
    document["bufferViews"] = json!([
        { "buffer": 0, "byteOffset": 0, "byteLength": vectors, "target": ARRAY_BUFFER },
        { "buffer": 0, "byteOffset": vectors, "byteLength": vectors, "target": ARRAY_BUFFER },
        { "buffer": 0, "byteOffset": 2 * vectors, "byteLength": 4 * indices, "target": ELEMENT_ARRAY_BUFFER },
    ]);
    document["buffers"] = json!([{ "byteLength": 2 * vectors + 4 * indices }]);
    document
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apatch::{self, APatchOptions, APatchSurface};
    use crate::golden::{scaled, sphere};
    use crate::hull::test_meshes::{quadrics, torus};
    use crate::hull::{self, HullOptions};
    use crate::tessellate::{APatchResolution, TessellateOptions, tessellate, tessellate_a_patches};

    #[test]
    fn parts_give_the_bytes_of_the_whole() {
        let open = quadrics().into_iter().map(|(_, _, data)| data);
        for data in std::iter::once(torus([16, 10])).chain(open) {
            let hull = hull::build(data, &HullOptions::default());
            let surface = APatchSurface::new(apatch::build(hull, &APatchOptions::default()));
            for (along, across) in [(1, 1), (2, 1), (3, 2), (8, 2)] {
                let (resolution, options) = (APatchResolution { along, across }, GlbOptions::default());
                let triangles = APatchTriangles::new(&surface, resolution).unwrap();
                let (mut whole, mut parts) = (Vec::new(), Vec::new());
                write_glb(&tessellate_a_patches(&surface, resolution).unwrap(), &options, &mut whole)
                    .unwrap();
                let bounds = triangles.bounds().unwrap();
                write_glb_of_a_patches(&triangles, &bounds, &options, &mut parts).unwrap();
                assert!(triangles.is_smooth() && whole == parts, "{along} {across}");
            }
        }
    }

    #[test]
    fn chunks_fill_the_file_and_positions_are_relative() {
        let far = scaled(&sphere(), 1e-3, Vec3::new(1e6, -2e6, 3e6));
        let mesh = tessellate(&far, &TessellateOptions { resolution: 2 }).unwrap();
        let mut bytes = Vec::new();
        write_glb(&mesh, &GlbOptions { unit: Unit::M }, &mut bytes).unwrap();
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let scene: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        let binary = 20 + word(12);
        assert_eq!((word(binary), &bytes[binary + 4..binary + 8]), (bytes.len() - binary - 8, &b"BIN\0"[..]));
        let center: Vec<f64> = serde_json::from_value(scene["nodes"][1]["translation"].clone()).unwrap();
        for (v, p) in mesh.positions.iter().enumerate() {
            for c in 0..3 {
                let stored = f32::from_bits(word(binary + 8 + 12 * v + 4 * c) as u32);
                assert!((center[c] + f64::from(stored) - p[c]).abs() < 1e-9);
                let accessor = &scene["accessors"][0];
                let bound = |which: &str| accessor[which][c].as_f64().unwrap() as f32;
                assert!(bound("min") <= stored && stored <= bound("max"));
            }
        }
    }
}
