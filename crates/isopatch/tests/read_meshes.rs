//! Mesh readers: round trips through small writers, variants of the formats, refused files, damaged files,
//! and the mesh collection of the test data.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use isopatch::geom::{Point3, Vec3};
use isopatch::io::read::{Element, Place, PolygonMesh, ReadError};
use isopatch::io::read::{read_mesh, read_obj, read_off, read_ply, read_stl};
use proptest::prelude::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};

type Reader = fn(&[u8]) -> Result<PolygonMesh, ReadError>;

/// A prism over a triangle: two triangles, three quadrilaterals, coordinates that need all their digits.
fn prism() -> PolygonMesh {
    let third = 1.0 / 3.0;
    let corner = |i: u32, z: f64| {
        let angle = f64::from(i) * 2.0;
        Vec3::new(third + angle.cos(), angle.sin(), z)
    };
    let positions: Vec<Point3> =
        (0..3).map(|i| corner(i, -1e-7)).chain((0..3).map(|i| corner(i, 1e6 + 0.1))).collect();
    let faces = vec![vec![2, 1, 0], vec![3, 4, 5], vec![0, 1, 4, 3], vec![1, 2, 5, 4], vec![2, 0, 3, 5]];
    let normals = positions.iter().map(|p| p.normalize()).collect();
    PolygonMesh { positions, faces, normals: Some(normals) }
}

fn numbers(v: &Vec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

fn off(mesh: &PolygonMesh) -> Vec<u8> {
    let keyword = if mesh.normals.is_some() { "NOFF" } else { "OFF" };
    let mut s = format!("{keyword}\n{} {} 0\n", mesh.positions.len(), mesh.faces.len());
    for (i, p) in mesh.positions.iter().enumerate() {
        let normal = mesh.normals.as_ref().map_or(String::new(), |n| numbers(&n[i]));
        writeln!(s, "{} {normal}", numbers(p)).unwrap();
    }
    for face in &mesh.faces {
        let corners: Vec<String> = face.iter().map(u32::to_string).collect();
        writeln!(s, "{} {}", face.len(), corners.join(" ")).unwrap();
    }
    s.into_bytes()
}

fn obj(mesh: &PolygonMesh) -> Vec<u8> {
    let mut s = String::from("# a mesh\n");
    for p in &mesh.positions {
        writeln!(s, "v {}", numbers(p)).unwrap();
    }
    for n in mesh.normals.iter().flatten() {
        writeln!(s, "vn {}", numbers(n)).unwrap();
    }
    for face in &mesh.faces {
        let item = |v: &u32| match mesh.normals {
            Some(_) => format!("{0}//{0}", v + 1),
            None => format!("{}", v + 1),
        };
        writeln!(s, "f {}", face.iter().map(item).collect::<Vec<_>>().join(" ")).unwrap();
    }
    s.into_bytes()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Ply {
    Ascii,
    Little,
    Big,
}

/// With `single` precision the positions are rounded to `f32`. A property and an element that readers must pass
/// over stand in between.
fn ply(mesh: &PolygonMesh, format: Ply, single: bool) -> Vec<u8> {
    let name = match format {
        Ply::Ascii => "ascii",
        Ply::Little => "binary_little_endian",
        Ply::Big => "binary_big_endian",
    };
    let float = if single { "float" } else { "float64" };
    let mut out = format!("ply\r\nformat {name} 1.0\r\ncomment made by a test\r\n").into_bytes();
    let mut line = |s: String| out.extend_from_slice(format!("{s}\r\n").as_bytes());
    line(format!("element vertex {}", mesh.positions.len()));
    for axis in ["x", "y", "z"] {
        line(format!("property {float} {axis}"));
    }
    line("property uchar red".into());
    if mesh.normals.is_some() {
        for axis in ["nx", "ny", "nz"] {
            line(format!("property {float} {axis}"));
        }
    }
    line("element camera 1\r\nproperty list ushort short path".into());
    line(format!("element face {}", mesh.faces.len()));
    line("property list uint8 int vertex_indices\r\nproperty char flag\r\nend_header".into());

    let real = |out: &mut Vec<u8>, x: f64| match (format, single) {
        (Ply::Ascii, false) => out.extend_from_slice(format!("{x} ").as_bytes()),
        (Ply::Ascii, true) => out.extend_from_slice(format!("{} ", x as f32).as_bytes()),
        (Ply::Little, false) => out.extend_from_slice(&x.to_le_bytes()),
        (Ply::Little, true) => out.extend_from_slice(&(x as f32).to_le_bytes()),
        (Ply::Big, false) => out.extend_from_slice(&x.to_be_bytes()),
        (Ply::Big, true) => out.extend_from_slice(&(x as f32).to_be_bytes()),
    };
    let integer = |out: &mut Vec<u8>, i: u32, bytes: usize| match format {
        Ply::Ascii => out.extend_from_slice(format!("{i} ").as_bytes()),
        Ply::Little => out.extend_from_slice(&i.to_le_bytes()[..bytes]),
        Ply::Big => out.extend_from_slice(&i.to_be_bytes()[4 - bytes..]),
    };
    for (i, p) in mesh.positions.iter().enumerate() {
        p.iter().for_each(|&x| real(&mut out, x));
        integer(&mut out, 255, 1);
        mesh.normals.iter().for_each(|n| n[i].iter().for_each(|&x| real(&mut out, x)));
    }
    for (value, bytes) in [(2, 2), (7, 2), (8, 2)] {
        integer(&mut out, value, bytes);
    }
    for face in &mesh.faces {
        integer(&mut out, face.len() as u32, 1);
        face.iter().for_each(|&v| integer(&mut out, v, 4));
        integer(&mut out, 1, 1);
    }
    out
}

fn triangles(mesh: &PolygonMesh) -> Vec<[Point3; 3]> {
    let fan = |f: &Vec<u32>| (1..f.len() - 1).map(|i| [f[0], f[i], f[i + 1]]).collect::<Vec<_>>();
    mesh.faces.iter().flat_map(fan).map(|t| t.map(|v| mesh.positions[v as usize])).collect()
}

fn stl_ascii(mesh: &PolygonMesh) -> Vec<u8> {
    let mut s = String::from("solid a name with facet in it\n");
    for t in triangles(mesh) {
        let [a, b, c] = t.map(|p| numbers(&p));
        writeln!(s, "facet normal nan 0 0\n outer loop").unwrap();
        writeln!(s, "  vertex {a}\n  vertex {b}\n  vertex {c}\n endloop\nendfacet").unwrap();
    }
    s.push_str("endsolid a name\n");
    s.into_bytes()
}

/// A binary file that starts, as some do, like an ASCII one.
fn stl_binary(mesh: &PolygonMesh) -> Vec<u8> {
    let mut out = b"solid but binary".to_vec();
    out.resize(80, b' ');
    out.extend_from_slice(&(triangles(mesh).len() as u32).to_le_bytes());
    for t in triangles(mesh) {
        out.extend_from_slice(&[0; 12]);
        t.iter().flat_map(|p| p.iter()).for_each(|&x| out.extend_from_slice(&(x as f32).to_le_bytes()));
        out.extend_from_slice(&[0; 2]);
    }
    out
}

fn rounded(v: &Vec3) -> Vec3 {
    v.map(|x| f64::from(x as f32))
}

fn refusal(read: Reader, bytes: impl AsRef<[u8]>) -> String {
    read(bytes.as_ref()).unwrap_err().to_string()
}

/// What every reader promises of a mesh that it gives out.
fn assert_well_formed(mesh: &PolygonMesh) {
    let finite = |v: &Vec3| v.iter().all(|x| x.is_finite());
    assert!(!mesh.faces.is_empty());
    assert!(mesh.positions.iter().all(finite));
    assert!(mesh.faces.iter().all(|f| f.len() >= 3));
    assert!(mesh.faces.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()));
    if let Some(normals) = &mesh.normals {
        assert!(normals.iter().all(finite));
        assert_eq!(normals.len(), mesh.positions.len());
    }
}

fn assert_round_trips(mesh: &PolygonMesh) {
    assert_eq!(&read_off(&off(mesh)).unwrap(), mesh);
    assert_eq!(&read_obj(&obj(mesh)).unwrap(), mesh);
    for format in [Ply::Ascii, Ply::Little, Ply::Big] {
        assert_eq!(&read_ply(&ply(mesh, format, false)).unwrap(), mesh, "{format:?}");
    }
    let single = PolygonMesh {
        positions: mesh.positions.iter().map(rounded).collect(),
        faces: mesh.faces.clone(),
        normals: mesh.normals.as_ref().map(|n| n.iter().map(rounded).collect()),
    };
    for format in [Ply::Little, Ply::Big] {
        assert_eq!(read_ply(&ply(mesh, format, true)).unwrap(), single, "{format:?}");
    }
    // STL keeps the corners' positions; welding leaves no two vertices at one point.
    for (bytes, expected) in [(stl_ascii(mesh), mesh), (stl_binary(mesh), &single)] {
        let read = read_stl(&bytes).unwrap();
        assert_eq!(triangles(&read), triangles(expected));
        for (i, p) in read.positions.iter().enumerate() {
            assert!(!read.positions[..i].contains(p), "vertex {i} is not welded");
        }
    }
}

#[test]
fn every_format_round_trips() {
    assert_round_trips(&prism());
    assert_round_trips(&PolygonMesh { normals: None, ..prism() });
}

#[test]
fn stl_welds_in_order_of_appearance() {
    let mesh = PolygonMesh { normals: None, ..prism() };
    let read = read_stl(&stl_ascii(&mesh)).unwrap();
    assert_eq!(read.positions.len(), 6);
    assert_eq!(read.faces[..3], [[0, 1, 2], [3, 4, 5], [2, 1, 4]]);
}

#[test]
fn stl_welds_zero_and_minus_zero() {
    let positions = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-0.0, -0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = positions.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
    let mesh = PolygonMesh { positions, faces: vec![vec![0, 1, 2], vec![3, 4, 5]], normals: None };
    for bytes in [stl_ascii(&mesh), stl_binary(&mesh)] {
        let read = read_stl(&bytes).unwrap();
        assert_eq!(read.faces, [[0, 1, 2], [0, 2, 3]]);
        assert!(read.positions[0].iter().all(|x| x.is_sign_positive()));
    }
}

#[test]
fn stl_reads_several_solids_on_one_line_or_in_capitals() {
    let facet = |z| {
        format!("FACET NORMAL 0 0 1 OUTER LOOP VERTEX 0 0 {z} VERTEX 1 0 {z} VERTEX 0 1 {z} ENDLOOP ENDFACET")
    };
    let text = format!("SOLID one\n{}\nENDSOLID one\n\nsolid\n{}\nendsolid\n", facet(0), facet(1));
    let mesh = read_stl(text.as_bytes()).unwrap();
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (6, 2));
}

const SQUARE_FACES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn assert_square(mesh: &PolygonMesh) {
    let expected = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.5));
    assert_eq!(mesh.positions, expected);
    assert_eq!(mesh.faces, SQUARE_FACES);
}

#[test]
fn off_variants() {
    let up = "0 0 1";
    let plain = "0 0 .5\n1 0 .5\n1 1 .5\n0 1 .5\n3 0 1 2\n3 0 2 3\n";
    let coloured = "0 0 .5 255 0 0\n1 0 .5 1 1 1 1\n1 1 .5\n0 1 .5\n3 0 1 2 0.1 0.2 0.3\n3 0 2 3 7\n";
    let normals = format!("0 0 .5 {up} 9 9\n1 0 .5 {up}\n1 1 .5 {up}\n0 1 .5 {up}\n3 0 1 2\n3 0 2 3");
    let cases = [
        (format!("OFF\n4 2 5\n{plain}"), false),
        (format!("OFF 4 2 5\n{plain}"), false),
        (format!("OFF4 2 0\n{plain}"), false),
        (format!("OFF\n4 2\n{plain}"), false),
        (format!("\u{feff}# made\n\nOFF # keyword\n\n#counts\n4 2 5\n\n{plain}\n# end \n\n"), false),
        (format!("OFF\n4 2 5\n{plain}").replace('\n', "\r\n"), false),
        (
            format!("OFF\n4 2 5\n{}", plain.replace("3 0 1 2", "3 0\n 1 2").replace("1 0 .5", "1\n0 5e-1")),
            false,
        ),
        (format!("COFF\n4 2 5\n{coloured}"), false),
        (format!("STCOFF\n4 2 5\n{coloured}"), false),
        (format!("STOFF\n4 2 5\n{coloured}"), false),
        (format!("NOFF\n4 2 5\n{normals}"), true),
        (format!("STCNOFF\n4 2 5\n{normals}"), true),
    ];
    for (text, has_normals) in cases {
        let mesh = read_off(text.as_bytes()).unwrap_or_else(|e| panic!("{e} in\n{text}"));
        assert_square(&mesh);
        assert_eq!(mesh.normals, has_normals.then(|| vec![Vec3::z(); 4]));
    }
}

#[test]
fn obj_variants() {
    let vertices = "v 0 0 .5\nv 1 0 .5 1.0\nv 1 1 .5 0.2 0.3 0.4\nv 0 1 .5\n";
    for faces in [
        "f 1 2 3\nf 1 3 4\n",
        "f -4 -3 -2\nf -4 -2 -1",
        "f 1/ 2// 3\nf 1//1 3/1/ 4\nvn 0 0 1",
        "vt 0 0\nvn 0 0 1\nf 1/1 2/1 3/1\nf 1/1/1 3/1/1 4//-1",
        "g \\name # comment\nusemtl caf\u{e9}\ns off\nl 1 2\nf 1 2\\\n 3\nf 1 \\\r\n 3 4 # f 9 9 9",
        "\tf  1  2  3  \n\n  f 1 3 4",
        "curv 0 1 \\\nf 7 8 9\nf 1 2 3\nf 1 3 4",
    ] {
        let text = format!("mtllib a.mtl\n{vertices}{faces}");
        assert_square(&read_obj(text.as_bytes()).unwrap_or_else(|e| panic!("{e} in\n{text}")));
        assert_square(&read_obj(text.replace('\n', "\r\n").replace("\r\r", "\r").as_bytes()).unwrap());
    }
    // Positive indices may name vertices to come, negative ones count from where they stand.
    assert_square(&read_obj(format!("f 1 2 3\nf 1 3 4\n{vertices}").as_bytes()).unwrap());
    let mesh = read_obj(format!("{vertices}f -4 -3 -2\nv 9 9 9\nf -5 -3 -2").as_bytes()).unwrap();
    assert_eq!(mesh.faces, SQUARE_FACES);
}

#[test]
fn obj_normals_must_agree_at_a_vertex() {
    let start = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 5\nvn 0 0 1\nvn 0 1 0\nvn 0 0 1\n";
    let normals = |faces: &str| read_obj(format!("{start}{faces}").as_bytes()).unwrap().normals;
    let up = Vec3::z();
    assert_eq!(normals("f 1//1 2//1 3//1\nf 1//3 3//3 4//3"), Some(vec![up, up, up, up, Vec3::zeros()]));
    assert_eq!(normals("f 1//1 2//1 3//1\nf 1//2 3//1 4//1"), None, "vertex 1 has two");
    assert_eq!(normals("f 1//1 2//1 3//1\nf 1 3 4"), None, "corners without");
}

#[test]
fn ply_normals_need_three_properties() {
    let header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let text = format!(
        "{header}property float nx\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n\
         0 0 0 1 1 0 0 1 0.1 1 0 1 3 0 1 2"
    );
    let mesh = read_ply(text.as_bytes()).unwrap();
    assert_eq!(mesh.normals, None);
    assert_eq!(mesh.positions[2].x, 0.1, "decimal digits are not rounded to f32");
}

#[test]
fn ply_faces_may_come_first() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\n\
        property double x\nproperty double y\nproperty double z\nend_header\n3 2 1 0\n0 0 0\n1 0 0\n0 1 0\n";
    assert_eq!(read_ply(text.as_bytes()).unwrap().faces, [[2, 1, 0]]);
}

#[test]
fn refused_off_files_name_the_culprit() {
    let body = "0 0 0\n1 0 0\n0 1 0\n";
    let face = |f: &str| refusal(read_off, format!("OFF\n3 2 0\n{body}3 0 1 2\n{f}\n"));
    assert_eq!(face("3 0 1 3"), "face 1 names vertex 3, but there are 3 vertices, counted from 0");
    assert_eq!(face("3 0 -1 2"), "face 1 names vertex -1, but there are 3 vertices, counted from 0");
    assert_eq!(face("2 0 1"), "face 1 has 2 corners; it needs 3 or more");
    assert_eq!(face("3 0 1"), "line 8: the file ends where a vertex index was expected");
    assert_eq!(face("3 0 1 x"), "line 7: expected a vertex index, found `x`");
    assert_eq!(face("3 0 1 1.5"), "line 7: expected a vertex index, found `1.5`");
    assert_eq!(face("999 0"), "the file claims 999 corners of a face, but has room for at most 2");
    assert_eq!(
        face("3 0 1 2\n\n3 0 1 2"),
        "line 9: unexpected data after the last element that the header announces"
    );
    for bad in ["nan", "inf", "-Infinity", "1e999"] {
        let text = format!("OFF\n3 1 0\n0 0 0\n1 {bad} 0\n0 1 0\n3 0 1 2\n");
        assert_eq!(refusal(read_off, text), "vertex 1 has a coordinate that is not a finite number");
    }
    assert_eq!(refusal(read_off, ""), "line 1: the file ends where the keyword OFF was expected");
    assert_eq!(refusal(read_off, "\u{1}\u{ff}"), r"line 1: expected the keyword OFF, found `\x01\xc3\xbf`");
    assert_eq!(refusal(read_off, "XOFF 1 1 1"), "line 1: expected the keyword OFF, found `XOFF`");
    assert_eq!(refusal(read_off, "OFF BINARY\n\0\0\0"), "line 1: binary OFF is not supported");
    assert_eq!(
        refusal(read_off, "4nOFF 4 1 1 1"),
        "line 1: OFF with points of other than 3 dimensions is not supported"
    );
    assert_eq!(refusal(read_off, format!("OFF 3 0 0\n{body}")), "the file holds no face");
}

#[test]
fn refused_obj_files_name_the_culprit() {
    let with =
        |line: &str| refusal(read_obj, format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2 3\n{line}\n"));
    let no_vertex = |v| format!("face 1 names vertex {v}, but there are 3 vertices, counted from 1");
    for index in ["4", "0", "-4", "4294967297", "-9223372036854775808"] {
        assert_eq!(with(&format!("f 1 2 {index}")), no_vertex(index));
    }
    assert_eq!(with("f 1//1 2//1 3//2"), "face 1 names normal 2, but there are 1 normals, counted from 1");
    assert_eq!(with("f 1//1 2//1 3//-2"), "face 1 names normal -2, but there are 1 normals, counted from 1");
    assert_eq!(with("f 1 2"), "face 1 has 2 corners; it needs 3 or more");
    let corner = "a corner of a face such as 1, 1/2, 1//3 or 1/2/3";
    for bad in ["1/1/1/1", "1/1/1/", "/1", "a"] {
        assert_eq!(with(&format!("f 2 3 {bad}")), format!("line 6: expected {corner}, found `{bad}`"));
    }
    assert_eq!(with("v 1 2"), "line 6: expected a coordinate, found the end of the line");
    assert_eq!(with("v 1 nan 2"), "vertex 3 has a coordinate that is not a finite number");
    assert_eq!(with("vn 1 inf 2"), "normal 1 has a coordinate that is not a finite number");
    assert_eq!(refusal(read_obj, "v 0 0 0\n"), "the file holds no face");
    let long = "x".repeat(1000);
    assert_eq!(
        with(&format!("v {long}")),
        format!("line 6: expected a coordinate, found `{}…`", "x".repeat(40))
    );
}

/// An ASCII PLY file with a vertex and a face element, as (header, body).
fn small_ply(vertices: u64, faces: u64) -> (String, &'static str) {
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list char int vertex_indices\nend_header\n"
    );
    (header, "0 0 0\n1 0 0\n0 1 0\n")
}

#[test]
fn refused_ply_files_name_the_culprit() {
    let (header, body) = small_ply(3, 1);
    let with_face = |face: &str| refusal(read_ply, format!("{header}{body}{face}"));
    let no_vertex = |v| format!("face 0 names vertex {v}, but there are 3 vertices, counted from 0");
    assert_eq!(with_face("3 0 1 3"), no_vertex(3));
    assert_eq!(with_face("3 0 1 -1"), no_vertex(-1));
    assert_eq!(with_face("-3 0 1 2"), "line 13: expected the length of a list, found -3");
    assert_eq!(with_face("3 0 1 2.5"), "line 13: expected an integer, found `2.5`");
    assert_eq!(with_face("2 0 1"), "face 0 has 2 corners; it needs 3 or more");
    assert_eq!(
        with_face("3 0 1 2\n0"),
        "line 14: unexpected data after the last element that the header announces"
    );
    assert_eq!(
        refusal(read_ply, format!("{header}0 0 0\n1 nan 0\n0 1 0\n3 0 1 2")),
        "vertex 1 has a coordinate that is not a finite number"
    );
    let with_header = |from: &str, to: &str| {
        assert!(header.contains(from));
        refusal(read_ply, format!("{}{body}3 0 1 2\n", header.replacen(from, to, 1)))
    };
    assert_eq!(with_header("ply", "plx"), "line 1: expected the keyword ply, found `plx`");
    assert_eq!(
        with_header("ascii", "utf8"),
        "line 2: expected ascii, binary_little_endian or binary_big_endian, found `utf8`"
    );
    assert_eq!(
        with_header("format ascii 1.0\n", ""),
        "line 8: expected a line with the format before it, found `end_header`"
    );
    assert_eq!(
        with_header("float x", "real x"),
        "line 4: expected a type such as uchar, int, float or double, found `real`"
    );
    assert_eq!(with_header("float y", "float u"), "the header has no property y in an element vertex");
    assert_eq!(
        with_header("vertex_indices", "v"),
        "the header has no property list … vertex_indices in an element face"
    );
    assert_eq!(
        with_header("element face", "element vertex"),
        "line 7: expected another name than that of an earlier element, found `vertex`"
    );
    assert_eq!(
        with_header("list char", "list float"),
        "line 8: expected a list with an integer length, found `list`"
    );
    assert_eq!(
        with_header("element vertex 3\n", ""),
        "line 3: expected an element before its properties, found `property`"
    );
    assert_eq!(
        with_header("element face", "element tristrips"),
        "line 7: an element tristrips is not supported"
    );
    assert_eq!(with_header("face 1", "face -1"), "line 7: expected the number of elements, found `-1`");

    let binary = ply(&prism(), Ply::Little, false);
    let end = binary.len();
    assert_eq!(
        refusal(read_ply, &binary[..end - 1]),
        format!("byte {}: the file ends where a value was expected", end - 1)
    );
    assert_eq!(
        refusal(read_ply, [&binary[..], b"\n"].concat()),
        format!("byte {end}: unexpected data after the last element that the header announces")
    );
}

#[test]
fn refused_stl_files_name_the_culprit() {
    let mesh = prism();
    let text = String::from_utf8(stl_ascii(&mesh)).unwrap();
    assert_eq!(
        refusal(read_stl, text.replacen("endloop", "vertex", 1)),
        "line 7: expected endloop, found `vertex`"
    );
    assert_eq!(
        refusal(read_stl, text.replacen("facet normal", "face normal", 1)),
        "line 2: expected facet or endsolid, found `face`"
    );
    assert_eq!(
        refusal(read_stl, text.replace("endsolid a name\n", "")),
        "line 58: the file ends where facet or endsolid was expected"
    );
    assert_eq!(refusal(read_stl, format!("{text}x")), "line 59: expected solid, found `x`");
    assert_eq!(refusal(read_stl, "solid\nendsolid\n"), "the file holds no face");
    let broken =
        PolygonMesh { positions: mesh.positions.iter().map(|p| p * f64::NAN).collect(), ..mesh.clone() };
    for bytes in [stl_ascii(&broken), stl_binary(&broken)] {
        assert_eq!(refusal(read_stl, bytes), "face 0 has a coordinate that is not a finite number");
    }
    let mut binary = stl_binary(&mesh);
    binary[0] = b'S' - 1; // no longer "solid"
    let count = triangles(&mesh).len();
    assert_eq!(
        refusal(read_stl, &binary[..binary.len() - 1]),
        format!("the file claims {count} triangles, but has room for at most {}", count - 1)
    );
    assert_eq!(
        refusal(read_stl, [&binary[..], &[0]].concat()),
        format!("byte {}: unexpected data after the last element that the header announces", binary.len())
    );
}

/// Counts that would take terabytes are refused before anything is allocated for them.
#[test]
fn huge_counts_are_refused_at_once() {
    let huge = 1u64 << 40;
    let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let refused = |read: Reader, bytes: &[u8]| {
        let error = read(bytes).unwrap_err();
        assert!(matches!(error, ReadError::TooMany { .. }), "{error}");
    };
    refused(read_off, format!("OFF {huge} 1 0\n{body}").as_bytes());
    refused(read_off, format!("OFF 3 {huge} 0\n{body}").as_bytes());
    refused(read_ply, format!("{}{body}", small_ply(huge, 1).0).as_bytes());
    refused(read_ply, format!("{}{body}", small_ply(3, u64::MAX).0).as_bytes());
    let (header, vertices) = small_ply(3, 1);
    refused(read_ply, format!("{header}{vertices}{huge} 0 1 2").as_bytes());
    refused(
        read_ply,
        format!("{}element empty {huge}\nend_header\n", header.replace("end_header\n", "")).as_bytes(),
    );
    let mut stl = stl_binary(&prism());
    stl[..5].fill(0);
    stl[80..84].fill(0xff);
    refused(read_stl, &stl);
}

/// One file of each format and flavour, with its reader.
fn samples() -> Vec<(Reader, Vec<u8>)> {
    let mesh = prism();
    vec![
        (read_off, off(&mesh)),
        (read_obj, obj(&mesh)),
        (read_ply, ply(&mesh, Ply::Ascii, false)),
        (read_ply, ply(&mesh, Ply::Little, false)),
        (read_ply, ply(&mesh, Ply::Big, true)),
        (read_stl, stl_ascii(&mesh)),
        (read_stl, stl_binary(&mesh)),
    ]
}

/// A file cut off anywhere is refused or, where what is left is a whole file, read as such; never a panic.
#[test]
fn truncated_files() {
    for (read, bytes) in samples() {
        let whole = read(&bytes).unwrap();
        for length in 0..bytes.len() {
            if let Ok(mesh) = read(&bytes[..length]) {
                assert_well_formed(&mesh);
                // Only a final separator or digit may be missing; OBJ has no counts to miss a line by.
                assert!(bytes.len() - length <= 12 || bytes[0] == b'#', "{length} of {} bytes", bytes.len());
                assert!(mesh.faces.len() <= whole.faces.len());
            }
        }
    }
}

#[test]
fn single_bytes_changed() {
    for (read, bytes) in samples() {
        for at in 0..bytes.len() {
            for value in [0, b' ', b'\n', b'-', b'9', b'#', b'\\', 0x7f, 0xff, bytes[at] ^ 1] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                read(&damaged).iter().for_each(assert_well_formed);
            }
        }
    }
}

prop_compose! {
    fn any_mesh()(count in 3u32..20)(
        positions in prop::collection::vec(prop::array::uniform3(-1e30..1e30f64), count as usize),
        faces in prop::collection::vec(prop::collection::vec(0..count, 3..7), 1..20),
        has_normals in any::<bool>(),
    ) -> PolygonMesh {
        let positions: Vec<Point3> = positions.into_iter().map(Point3::from).collect();
        // OBJ keeps the normals of vertices that a face uses.
        let used = |v: usize| faces.iter().flatten().any(|&c| c as usize == v);
        let normal = |v: usize| if used(v) { positions[v].zxy().normalize() } else { Vec3::zeros() };
        let normals = has_normals.then(|| (0..positions.len()).map(normal).collect());
        PolygonMesh { positions, faces, normals }
    }
}

proptest! {
    // A failing case is printed in full; it becomes a named test, not a file of seeds.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_mesh_round_trips(mesh in any_mesh()) {
        assert_round_trips(&mesh);
    }

    #[test]
    fn damaged_files(
        sample in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        cut in any::<prop::sample::Index>(),
        move_from in any::<prop::sample::Index>(),
    ) {
        let samples = samples();
        let (read, mut bytes) = samples[sample.index(samples.len())].clone();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let from = move_from.index(bytes.len());
        bytes.rotate_left(from % 2 * from);
        bytes.truncate(cut.index(2 * bytes.len()));
        read(&bytes).iter().for_each(assert_well_formed);
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for read in [read_off as Reader, read_obj, read_ply, read_stl] {
            read(&bytes).iter().for_each(assert_well_formed);
        }
    }
}

#[test]
fn the_ending_tells_the_format() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mesh = prism();
    for (name, bytes) in [
        ("prism.off", off(&mesh)),
        ("prism.OBJ", obj(&mesh)),
        ("prism.ply", ply(&mesh, Ply::Big, false)),
        ("prism.v2.Stl", stl_binary(&mesh)),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        let read = read_mesh(&path).unwrap();
        assert_eq!(read.positions.len(), 6, "{name}");
    }
    for name in ["prism", "prism.step", ".obj"] {
        let error = read_mesh(Path::new(name)).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("can't tell the mesh format of {name}: its name must end in .obj, .off, .ply or .stl")
        );
    }
    let error = read_mesh(&folder.join("no such file.ply")).unwrap_err();
    assert!(matches!(error, ReadError::File { .. }), "{error}");
    assert!(error.to_string().contains("no such file.ply"), "{error}");
}

/// The folder of the mesh collection, or none after a line that says so.
fn collection(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("ISOPATCH_TEST_DATA").map(|data| PathBuf::from(data).join("meshes"));
    let folder = folder.filter(|folder| folder.is_dir());
    if folder.is_none() {
        println!("skipped: {test} (needs ISOPATCH_TEST_DATA)");
    }
    folder
}

/// Every mesh of the collection has the numbers of its manifest, also after a round trip through each format.
#[test]
fn mesh_collection() {
    let Some(folder) = collection("mesh_collection") else { return };
    let manifest = std::fs::read_to_string(folder.join("MANIFEST.tsv")).unwrap();
    let mut lines = manifest.lines().map(|line| line.split('\t').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let columns = ["verts", "faces", "tri", "quad", "pent", "other"].map(column);
    let mut read = 0;
    for row in lines {
        let name = row[column("name")];
        let expected = columns.map(|c| row[c].parse::<usize>().unwrap());
        if name == "nasty_nan_vertex.off" {
            continue;
        }
        let mesh = read_mesh(&folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let of_size = |size: usize| mesh.faces.iter().filter(|f| f.len() == size).count();
        let (tri, quad, pent) = (of_size(3), of_size(4), of_size(5));
        let other = mesh.faces.len() - tri - quad - pent;
        assert_eq!([mesh.positions.len(), mesh.faces.len(), tri, quad, pent, other], expected, "{name}");
        assert_eq!(mesh.normals, None, "{name}");
        assert_eq!(read_obj(&obj(&mesh)).unwrap(), mesh, "{name}");
        assert_eq!(read_ply(&ply(&mesh, Ply::Ascii, false)).unwrap(), mesh, "{name}");
        assert_eq!(read_ply(&ply(&mesh, Ply::Big, false)).unwrap(), mesh, "{name}");
        assert_eq!(triangles(&read_stl(&stl_ascii(&mesh)).unwrap()), triangles(&mesh), "{name}");
        read += 1;
    }
    assert!(read >= 30, "only {read} meshes in the manifest");
}

#[test]
fn mesh_collection_nan_vertex() {
    let Some(folder) = collection("mesh_collection_nan_vertex") else { return };
    let error = read_mesh(&folder.join("nasty_nan_vertex.off")).unwrap_err();
    let text = std::fs::read_to_string(folder.join("nasty_nan_vertex.off")).unwrap();
    let line = text.lines().position(|line| line.to_lowercase().contains("nan")).unwrap();
    assert!(
        matches!(error, ReadError::NotFinite { element: Element::Vertex, index } if index == line - 2),
        "{error}"
    );
}

#[test]
fn places_are_typed() {
    let error = read_off(b"OFF\n1 1 1\n0 0 zero 1 2 3").unwrap_err();
    assert!(matches!(error, ReadError::Syntax { place: Place::Line(3), .. }), "{error}");
}
