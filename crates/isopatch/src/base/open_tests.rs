use super::open_fixtures::*;
use super::*;
use crate::field::Field;

fn base_of(cut: &Cut, faces: usize) -> BaseOutcome {
    let options = BaseOptions { faces: Some(faces), trial: true, ..BaseOptions::default() };
    base_from_seed(&cut.field, &seed_of(cut), &options)
        .unwrap_or_else(|e| panic!("{}, {faces}: {e}", cut.name))
}

/// Boundary vertices are exactly those with sides, edges inside join no two vertices of one side, and every boundary edge
/// lies in a side.
fn assert_cut_by_its_box(name: &str, base: &BaseMesh) {
    let clip = base.clip.as_ref().unwrap();
    for v in base.mesh.vertices() {
        let sides = clip.sides[v.index()];
        assert_eq!(base.mesh.is_boundary_vertex(v), !sides.is_empty(), "{name}: {v:?}");
        assert_eq!(BoxSides::of(&base.positions[v.index()], &clip.bounds), sides, "{name}: {v:?}");
    }
    for e in base.mesh.edges() {
        let h = base.mesh.edge_half_edge(e);
        let [a, b] = [base.mesh.origin(h), base.mesh.dest(h)].map(|v| clip.sides[v.index()]);
        assert_eq!(base.mesh.twin(h).is_none(), !a.common(b).is_empty(), "{name}: {e:?}");
    }
}

fn assert_on_surface(cut: &Cut, base: &BaseMesh) {
    for p in &base.positions {
        let (f, g) = cut.field.gradient(*p);
        let reach = 1e-12 * base.diagonal() * g.norm();
        assert!(f.abs() <= reach.max(cut.field.rounding_bound(*p)), "{}: {f:e} at {p:?}", cut.name);
    }
}

#[test]
fn surfaces_cut_by_a_box_end_in_its_sides() {
    for cut in cuts() {
        let seed = seed_of(&cut);
        for faces in [cut.least, 2 * cut.least + 1] {
            let outcome = base_of(&cut, faces);
            let base = &outcome.base;
            assert_eq!(base.mesh.euler_number(), seed.mesh.euler_number(), "{}", cut.name);
            assert_cut_by_its_box(cut.name, base);
            assert_on_surface(&cut, base);
        }
    }
}
