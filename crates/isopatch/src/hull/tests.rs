use super::test_meshes::{from_file, quadrics};
use super::*;
use crate::hull::ApexRule::Paper;

fn paper() -> HullOptions {
    HullOptions { rule: Paper, ..HullOptions::default() }
}

#[test]
fn hulls_of_quadrics_have_no_problems() {
    for (name, _, data) in quadrics() {
        for options in [paper(), HullOptions::default()] {
            let hull = build(data.clone(), &options);
            assert!(hull.problems().is_empty(), "{name}: {:?}", hull.problems().first());
            assert!(hull.moved_normals().is_empty(), "{name}");
        }
    }
}

#[test]
#[ignore = "prints a table"]
fn real_meshes() {
    for name in std::env::var("MESHES").unwrap().split_whitespace() {
        let Some(data) = from_file(name) else { continue };
        let start = std::time::Instant::now();
        let first = build(data.clone(), &paper());
        let t1 = start.elapsed();
        let robust = build(data, &HullOptions::default());
        let t2 = start.elapsed() - t1;
        for p in robust.problems().iter().take(std::env::var("SHOW").map_or(0, |s| s.parse().unwrap())) {
            eprintln!("{p}");
            if let Problem::Face { face, .. } = p {
                let (fr, hf) = (robust.face_frame(*face), robust.faces()[face.index()]);
                let dn = fr.n.map(|n| n.normalize().dot(&hf.direction));
                let fnn = fr.n.map(|n| n.normalize().dot(&fr.normal));
                eprintln!(
                    "   {:?} d.n {dn:.3?} f.n {fnn:.3?} h/r {:.3?}",
                    hf.class,
                    hf.heights.map(|h| h / fr.inner_radius)
                );
                for s in Side::BOTH {
                    if let Some(a) = hf.apexes[s.index()] {
                        eprintln!("   {:?} len {:?}", fr.layer1(s, &a), (fr.p[1] - fr.p[0]).norm());
                    }
                }
            }
            if let Problem::Edge { edge, faces, .. } = p {
                eprintln!("   {:?}", robust.edges()[edge.index()]);
                let n = faces.map(|f| robust.face_frame(f).normal);
                eprintln!(
                    "   dihedral {:.1} deg {:?}",
                    crate::geom::angle_between(&n[0], &n[1]).to_degrees(),
                    faces.map(|f| {
                        let h = robust.faces()[f.index()];
                        (
                            h.class,
                            h.heights.map(|x| x / robust.face_frame(f).inner_radius),
                            h.direction.dot(&robust.face_frame(f).normal),
                        )
                    })
                );
            }
        }
        let mut reasons = std::collections::BTreeMap::new();
        robust.problems().iter().for_each(|p| *reasons.entry(p.reason().name()).or_insert(0) += 1);
        eprintln!(
            "{name}: faces {} paper {} robust {} {reasons:?} moved {} {t1:?} {t2:?}",
            robust.faces().len(),
            first.bad_faces().len(),
            robust.bad_faces().len(),
            robust.moved_normals().len()
        );
    }
}
