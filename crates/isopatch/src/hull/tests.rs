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
        let mut reasons = std::collections::BTreeMap::new();
        robust.problems().iter().for_each(|p| *reasons.entry(p.reason().name()).or_insert(0) += 1);
        eprintln!(
            "{name}: faces {} paper {} robust {} {reasons:?} moved {} {t1:?} {t2:?}",
            robust.faces().len(),
            first.bad_faces().len(), robust.bad_faces().len(), robust.moved_normals().len()
        );
    }
}
