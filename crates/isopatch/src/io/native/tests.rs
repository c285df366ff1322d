use super::layout::{ENTRY, FIXED_HEADER, MAJOR, MINOR};
use super::*;
use crate::base::EdgeFeature;
use crate::geom::Vec3;
use crate::golden::{flat_triangle, inverted, joined, scaled, sphere};
use crate::io::WriteError;
use proptest::prelude::*;

fn provenance() -> Provenance {
    Provenance {
        options: "{\"faces\":20}".into(),
        source: "x²+y²+z²−1".into(),
        unit: Unit::In,
        diagonal: 2.9467,
        ..Provenance::default()
    }
}

fn written(spline: &TriangularSpline) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_native(spline, &provenance(), &mut bytes).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> Result<NativeModel, NativeError> {
    read_native(&mut &*bytes)
}

/// Rewrites the checksums, so that a planted fault is found by what it says.
pub(super) fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let word = |bytes: &[u8], at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    let count = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    for entry in 0..count {
        let at = FIXED_HEADER + entry * ENTRY;
        let (offset, length) = (word(&bytes, at + 8), word(&bytes, at + 16));
        if let Some(section) = bytes.get(offset..offset.saturating_add(length)) {
            let checksum = crc32fast::hash(section).to_le_bytes();
            bytes[at + 4..at + 8].copy_from_slice(&checksum);
        }
    }
    let end = FIXED_HEADER + count * ENTRY;
    let checksum = crc32fast::hash(&bytes[..end]).to_le_bytes();
    bytes[end..end + 4].copy_from_slice(&checksum);
    bytes
}

/// Position of the bytes of a section.
fn section(bytes: &[u8], tag: &[u8; 4]) -> usize {
    let entry = (0..6).map(|k| FIXED_HEADER + k * ENTRY).find(|at| bytes[*at..].starts_with(tag)).unwrap();
    u64::from_le_bytes(bytes[entry + 8..entry + 16].try_into().unwrap()) as usize
}

fn bits(points: &[Vec3]) -> Vec<u64> {
    points.iter().flat_map(|p| p.iter().map(|c| c.to_bits()).collect::<Vec<_>>()).collect()
}

#[test]
fn the_round_trip_is_exact() {
    let cavity = inverted(&scaled(&sphere(), 1.0 / 3.0, Vec3::new(0.1, 0.2, 0.3)));
    let mut sharp = sphere();
    sharp.base.features[4] = EdgeFeature::Sharp;
    let mut skew = sphere();
    skew.base.curvatures[5][(0, 2)] += 1e-3;
    for spline in [sphere(), flat_triangle(), joined(&[sphere(), cavity]), sharp, skew] {
        let bytes = written(&spline);
        let model = read(&bytes).unwrap();
        let (a, b) = (model.spline().unwrap(), &spline);
        assert_eq!(model.provenance, provenance());
        assert_eq!(a.base.mesh, b.base.mesh);
        assert_eq!(a.base.features, b.base.features);
        assert_eq!(a.base.curvatures, b.base.curvatures);
        assert_eq!(bits(&a.base.positions), bits(&b.base.positions));
        assert_eq!(bits(&a.base.normals), bits(&b.base.normals));
        assert_eq!(bits(a.curves.as_flattened()), bits(b.curves.as_flattened()));
        assert_eq!(bits(a.nets.as_flattened()), bits(b.nets.as_flattened()));
        let mut again = Vec::new();
        write_native(a, &model.provenance, &mut again).unwrap();
        assert_eq!(again, bytes);
    }
}

/// Readers of version 1.2 know no sharp edges, so the version says that there may be some.
#[test]
fn the_version_is_that_of_the_description() {
    let bytes = written(&sphere());
    assert_eq!((&bytes[8..10], &bytes[10..12]), (&MAJOR.to_le_bytes()[..], &MINOR.to_le_bytes()[..]));
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/format.md")).unwrap();
    assert!(text.lines().next().unwrap().ends_with(&format!("version {MAJOR}.{MINOR}")));
}

#[test]
fn a_border_is_not_sharp() {
    let mut bytes = written(&flat_triangle());
    let start = section(&bytes, b"EDGE");
    bytes[start] = 2;
    assert!(matches!(read(&resealed(bytes)), Err(NativeError::Feature { edge: 0, code: 2 })));
}

#[test]
fn a_changed_border_is_refused() {
    let mut spline = sphere();
    spline.nets[3][0].x = spline.nets[3][0].x.next_up();
    let error = write_native(&spline, &provenance(), &mut Vec::new()).unwrap_err();
    assert!(matches!(error, WriteError::Border { patch: 3, .. }), "{error}");
}

/// The unit sphere of 20 patches as version 1.4 has written it.
#[test]
fn files_of_version_1_4_are_read() {
    let old = include_bytes!("../../../tests/golden/native/sphere-1.4.isopatch");
    let model = read(old).unwrap();
    let spline = model.spline().unwrap();
    assert_eq!((&old[10..12], spline.nets.len()), (&[4, 0][..], 20));
    assert!(spline.nets.iter().flatten().all(|p| (p.norm() - 1.0).abs() < 0.1));
    let mut new = Vec::new();
    write_native(spline, &model.provenance, &mut new).unwrap();
    assert!(new.len() < old.len());
    let again = read(&new).unwrap();
    assert_eq!(again.spline().unwrap().base.curvatures, spline.base.curvatures);
    assert_eq!(again.spline().unwrap().nets, spline.nets);
    assert_eq!(again.spline().unwrap().curves, spline.curves);
}

/// Control points stored once and corners, with a tenth for everything else: normals, tensors, features and the frame.
#[test]
fn little_is_stored_besides_control_points() {
    let spline = sphere();
    let mesh = &spline.base.mesh;
    let points = mesh.vertex_count() + 3 * mesh.edge_count() + 15 * mesh.face_count();
    let frame = FIXED_HEADER + 6 * ENTRY + 4 + meta_length(&provenance());
    let least = 24 * points + 12 * mesh.face_count();
    let length = written(&spline).len() - frame;
    assert!(10 * length <= 11 * least, "{length} {least}");
}

fn meta_length(provenance: &Provenance) -> usize {
    super::write::meta(provenance).unwrap().len()
}

#[test]
fn unknown_sections_are_skipped() {
    let mut bytes = written(&sphere());
    // An entry in front of the checksum of the header moves everything behind it.
    let end = FIXED_HEADER + 6 * ENTRY;
    let entry = [&b"NEWS"[..], &[0; 4], &u64::MAX.to_le_bytes(), &u64::MAX.to_le_bytes()].concat();
    bytes.splice(end..end, entry);
    bytes[12] = 7;
    for k in 0..6 {
        let at = FIXED_HEADER + k * ENTRY + 8;
        let moved = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) + ENTRY as u64;
        bytes[at..at + 8].copy_from_slice(&moved.to_le_bytes());
    }
    assert_eq!(read(&resealed(bytes)).unwrap().spline().unwrap().nets, sphere().nets);
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = written(&flat_triangle());
    assert!((0..bytes.len()).all(|length| read(&bytes[..length]).is_err()));
    assert!(matches!(read(&bytes[..5]), Err(NativeError::Truncated(_))));
    assert!(matches!(read(b"solid cube"), Err(NativeError::Magic)));
    assert!(matches!(read(&bytes[..bytes.len() - 1]), Err(NativeError::Bounds(s)) if s == "INNR"));
}

#[test]
fn every_flipped_bit_is_an_error() {
    let bytes = written(&flat_triangle());
    for bit in 0..8 * bytes.len() {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(read(&flipped).is_err(), "bit {bit}");
    }
}

#[test]
fn faults_behind_right_checksums_are_named() {
    let change = |tag: &[u8; 4], at: usize, new: &[u8]| {
        let mut bytes = written(&sphere());
        let start = section(&bytes, tag) + at;
        bytes[start..start + new.len()].copy_from_slice(new);
        read(&resealed(bytes)).unwrap_err()
    };
    let huge = u32::MAX.to_le_bytes();
    assert!(matches!(change(b"FACE", 0, &huge), NativeError::Mesh(_)));
    assert!(matches!(change(b"FACE", 4, &huge), NativeError::Length { expected: 51539607548, .. }));
    assert!(matches!(change(b"FACE", 8, &huge), NativeError::Mesh(MeshError::NoSuchVertex { face: 0, .. })));
    assert!(matches!(change(b"EDGE", 2, &[1]), NativeError::Feature { edge: 2, code: 1 }));
    assert!(matches!(change(b"EDGE", 3, &[9]), NativeError::Feature { edge: 3, code: 9 }));
    assert!(matches!(change(b"META", 0, &huge), NativeError::Truncated("name of the generator")));
    assert!(matches!(change(b"META", 4, &[0xff]), NativeError::Text("name of the generator")));
    let nan = f64::NAN.to_le_bytes();
    assert!(matches!(change(b"QRTC", 16, &nan), NativeError::NotFinite { index: 2, .. }));
    let mut newer = written(&sphere());
    newer[8] = 2;
    assert!(matches!(read(&resealed(newer)), Err(NativeError::Version { major: 2, minor: MINOR })));
}

proptest! {
    /// Whatever the bytes, reading returns.
    #[test]
    fn planted_bytes_never_panic(at in 0usize..4000, new in proptest::collection::vec(any::<u8>(), 1..16)) {
        let mut bytes = written(&flat_triangle());
        let at = at % (bytes.len() - new.len());
        bytes[at..at + new.len()].copy_from_slice(&new);
        let count = u32::from_le_bytes(bytes[12..16].try_into().unwrap());
        if count <= 6 {
            bytes = resealed(bytes);
        }
        let _ = read(&bytes);
    }
}

use crate::mesh::MeshError;
