use super::*;
use crate::apatch::{self, APatchFunction, APatchOptions, Free};
use crate::hull::test_meshes::{perturbed, quadrics, torus};
use crate::hull::{self, HermiteMesh, HullOptions};
use crate::mesh::creases;
use crate::surface::{PatchId, Surface};
use proptest::prelude::*;

fn surface(data: HermiteMesh, free: Free) -> APatchSurface {
    let options = APatchOptions { free, ..APatchOptions::default() };
    APatchSurface::new(apatch::build(hull::build(data, &HullOptions::default()), &options))
}

fn written(surface: &APatchSurface) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_native_a_patches(surface, &Provenance::default(), &mut bytes).unwrap();
    bytes
}

fn assert_same(a: &APatchFunction, b: &APatchFunction) {
    assert_eq!((a.faces(), a.edges()), (b.faces(), b.edges()));
    assert_eq!(
        (a.default_free(), a.sufficient_free(), a.free()),
        (b.default_free(), b.sufficient_free(), b.free())
    );
    let (a, b) = (a.hull(), b.hull());
    assert_eq!((a.faces(), a.edges()), (b.faces(), b.edges()));
    assert_eq!((a.problems(), a.moved_normals()), (b.problems(), b.moved_normals()));
    assert_eq!((a.corners(), a.added_creases()), (b.corners(), b.added_creases()));
    let (a, b) = (a.data(), b.data());
    assert_eq!((a.mesh(), a.positions()), (b.mesh(), b.positions()));
    assert!(a.mesh().half_edges().all(|h| a.gradient(h) == b.gradient(h)));
    assert!(a.mesh().edges().all(|e| a.is_crease(e) == b.is_crease(e)));
}

/// Every class, both sides, open borders, creases, an infinite bound, free parameters that were given.
#[test]
fn the_round_trip_is_exact() {
    let mut all: Vec<APatchSurface> =
        quadrics().into_iter().map(|(_, _, data)| surface(data, Free::Default)).collect();
    all.push(surface(perturbed(0.1, 0.6), Free::Global(3.25)));
    all.push(surface(torus([12, 8]), Free::Default));
    let smooth = torus([8, 5]);
    let sharp = creases::by_angle(smooth.mesh(), smooth.positions(), 0.9);
    assert!(sharp.contains(&true) && sharp.contains(&false));
    let gradients = smooth.mesh().half_edges().map(|h| smooth.gradient(h)).collect();
    let creased =
        HermiteMesh::with_creases(smooth.mesh().clone(), smooth.positions().to_vec(), gradients, sharp);
    all.push(surface(creased.unwrap(), Free::Default));
    for surface in all {
        let bytes = written(&surface);
        let model = read_native(&mut &*bytes).unwrap();
        let read = model.a_patches().unwrap();
        assert_same(read.function(), surface.function());
        for p in surface.patches().step_by(7) {
            let at = [0.375, 0.25];
            assert_eq!(format!("{:?}", read.sample(p, at)), format!("{:?}", surface.sample(p, at)));
        }
        assert_eq!(written(read), bytes);
        let mut again = Vec::new();
        model.write(&mut again).unwrap();
        assert_eq!(again, bytes);
    }
}

#[test]
fn reasons_have_the_numbers_of_the_format() {
    let codes = hull::Reason::ALL.map(write_a_patches::reason_code);
    assert_eq!(codes, [0, 1, 2, 3, 4, 5, 6]);
}

#[test]
fn truncations_and_flipped_bits_are_errors() {
    let small = quadrics().into_iter().find(|(name, ..)| *name == "sphere").unwrap().2;
    let bytes = written(&surface(small, Free::Default));
    for length in (0..bytes.len()).step_by(37) {
        assert!(read_native(&mut &bytes[..length]).is_err());
    }
    for bit in (0..8 * bytes.len()).step_by(101) {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(read_native(&mut &*flipped).is_err(), "bit {bit}");
    }
}

proptest! {
    /// Whatever the bytes of a section, reading returns, and what was read can be evaluated.
    #[test]
    fn planted_bytes_never_panic(at in 0usize..20_000, new in proptest::collection::vec(any::<u8>(), 1..16)) {
        let mut bytes = written(&surface(perturbed(0.1, 0.6), Free::Default));
        let at = at % (bytes.len() - new.len());
        bytes[at..at + new.len()].copy_from_slice(&new);
        let count = u32::from_le_bytes(bytes[12..16].try_into().unwrap());
        if count <= 13 {
            bytes = super::tests::resealed(bytes);
        }
        if let Ok(model) = read_native(&mut &*bytes) {
            let surface = model.a_patches().unwrap();
            (0..surface.patch_count()).for_each(|p| _ = surface.sample(PatchId(p as u32), [0.3, 0.3]));
        }
    }
}
