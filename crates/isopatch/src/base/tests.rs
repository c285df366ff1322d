use std::time::Instant;

use super::test_fields::*;
use super::*;

fn with_faces(faces: usize) -> BaseOptions {
    BaseOptions { faces: Some(faces), ..BaseOptions::default() }
}

#[test]
fn paper_surfaces_are_meshed_within_all_limits() {
    for (name, field, bounds, faces, euler) in paper_surfaces() {
        let start = Instant::now();
        let outcome = build(field.as_ref(), &bounds, &with_faces(faces)).unwrap();
        println!("{name}: {:.3} s, {:?}", start.elapsed().as_secs_f64(), quality(&outcome.base));
        let mesh = &outcome.base.mesh;
        assert_eq!((mesh.face_count(), mesh.euler_number(), mesh.component_count()), (faces, euler, 1), "{name}");
        assert!(mesh.is_closed());
        if !outcome.violations.is_empty() { println!("  {} violations", outcome.violations.len()); }
        assert_eq!(outcome.repairs, [], "{name}");
        let diagonal = outcome.base.diagonal();
        for (p, n) in outcome.base.positions.iter().zip(&outcome.base.normals) {
            let (f, g) = field.gradient(*p);
            assert!(f.abs() <= 1e-12 * diagonal * g.norm() || f.abs() <= field.rounding_bound(*p), "{name}");
            assert!((n.norm() - 1.0).abs() < 1e-14);
        }
        if let Ok(folder) = std::env::var("ISOPATCH_DUMP") {
            dump(&folder, name, &outcome.base);
        }
    }
}

fn dump(folder: &str, name: &str, base: &BaseMesh) {
    let mut text = format!("OFF\n{} {} 0\n", base.positions.len(), base.mesh.face_count());
    for p in &base.positions {
        text += &format!("{:e} {:e} {:e}\n", p.x, p.y, p.z);
    }
    for f in base.mesh.faces() {
        let [a, b, c] = base.mesh.triangle(f);
        text += &format!("3 {} {} {}\n", a.0, b.0, c.0);
    }
    std::fs::write(format!("{folder}/{}.off", name.replace(' ', "")), text).unwrap();
}
