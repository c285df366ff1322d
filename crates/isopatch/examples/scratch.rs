#![allow(missing_docs, clippy::unwrap_used)]
use isopatch::apatch::{self, APatchOptions};
use isopatch::hull::{self, HermiteMesh, HullOptions, Reason};
use isopatch::io::read::read_mesh;
use isopatch::mesh::normals::{NormalRule, at_corners};
use isopatch::mesh::{HalfEdgeMesh, PrepareOptions, creases, prepare};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let angle: f64 = args.get(2).map_or(180.0, |a| a.parse().unwrap());
    let path = format!("/work/shared/meshes/{}.off", args[1]);
    let read = read_mesh(path.as_ref()).unwrap();
    let prepared = prepare(&read.positions, &read.faces, &PrepareOptions::default()).unwrap();
    let faces: Vec<[u32; 3]> = prepared.faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
    let mesh = HalfEdgeMesh::from_faces(prepared.positions.len(), &faces).unwrap();
    let positions = prepared.positions;
    let sharp = creases::by_angle(&mesh, &positions, angle.to_radians());
    let gradients = at_corners(&mesh, &positions, &sharp, NormalRule::LoopLimit);
    let data = HermiteMesh::with_creases(mesh, positions, gradients, sharp).unwrap();
    let start = std::time::Instant::now();
    let hull = hull::build(data, &HullOptions::default());
    println!("hull {:?}: corners {} creases {} problems {} faces {}", start.elapsed(), hull.corners().len(), hull.added_creases().len(), hull.problems().len(), hull.faces().len());
    let function = apatch::build(hull, &APatchOptions::default());
    let hull = function.hull();
    println!("all {:?}: corners {} creases {} problems {:?} faces {}", start.elapsed(), hull.corners().len(), hull.added_creases().len(), hull.problems(), hull.faces().len());
    for c in hull.corners() { if c.reason != Reason::NoVisibleNormal { 
        let mesh = hull.data().mesh();
        let ns: Vec<_> = mesh.ring(c.vertex).map(|h| isopatch::mesh::normals::of_face(mesh, hull.data().positions(), mesh.face(h))).collect();
        println!("  {:?} {:?} best {:?}", c.vertex, c.reason, isopatch::hull::most_visible_direction(&ns).map(|x| x.1)); } }
}
