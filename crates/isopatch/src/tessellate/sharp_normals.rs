use super::SharedLattice;
use crate::bernstein::index;
use crate::geom::Vec3;
use crate::surface::{Continuity, PatchId, Seam, SeamSide, Surface};

/// Adds the normals on the other sides of seams that are not smooth, and gives the numbers of the normals at the corners of each
/// triangle; none if there are no such seams.
///
/// Every point has a normal already, with its own number: a corner that of its owner, a seam that of its first patch. `small` are the
/// triangles of a lattice of `n` intervals, and `normal` is the normal of a patch at a point of it in net order.
pub(super) fn number(
    surface: &dyn Surface,
    lattice: &SharedLattice,
    n: usize,
    small: &[[[usize; 3]; 3]],
    normal: &dyn Fn(PatchId, usize) -> Vec3,
    normals: &mut Vec<Vec3>,
) -> Vec<[u32; 3]> {
    let is_sharp = |seam: &&Seam| seam.second.is_some() && seam.continuity != Continuity::G1;
    if !surface.seams().iter().any(|seam| is_sharp(&seam)) {
        return Vec::new();
    }
    let of_corners = corner_numbers(surface, lattice, n, normal, normals);
    // The number of the first normal along each edge of each patch that is the second of a sharp seam.
    let mut of_edges = vec![[None; 3]; surface.patch_count()];
    for side in surface.seams().iter().filter(is_sharp).filter_map(|seam| seam.second) {
        of_edges[side.patch.index()][usize::from(side.edge)] = Some(normals.len() as u32);
        normals.extend((1..n).map(|m| normal(side.patch, index::row(n, usize::from(side.edge), 0, m))));
    }
    let number = |patch: PatchId, ijk: [usize; 3]| {
        if let Some(corner) = ijk.iter().position(|i| *i == n) {
            return of_corners[3 * patch.index() + corner];
        }
        let own = ijk.iter().position(|i| *i == 0).and_then(|zero| {
            let edge = (zero + 1) % 3;
            // How far from where the edge starts.
            Some(of_edges[patch.index()][edge]? + ijk[(edge + 1) % 3] as u32 - 1)
        });
        own.unwrap_or_else(|| lattice.number(patch, ijk))
    };
    let numbers = &number;
    surface.patches().flat_map(|p| small.iter().map(move |t| t.map(|ijk| numbers(p, ijk)))).collect()
}

/// The number of the normal at each corner of each patch: one for the patches that go round a vertex without a sharp seam between them.
fn corner_numbers(
    surface: &dyn Surface,
    lattice: &SharedLattice,
    n: usize,
    normal: &dyn Fn(PatchId, usize) -> Vec3,
    normals: &mut Vec<Vec3>,
) -> Vec<u32> {
    let mut groups = Groups::new(3 * surface.patch_count());
    let place = |side: &SeamSide, at_end: bool| {
        3 * side.patch.index() + (usize::from(side.edge) + usize::from(at_end)) % 3
    };
    for seam in surface.seams().iter().filter(|seam| seam.continuity == Continuity::G1) {
        let Some(second) = &seam.second else { continue };
        for end in [false, true] {
            groups
                .join(place(&seam.first, end != seam.first.reversed), place(second, end != second.reversed));
        }
    }
    let mut numbers = vec![None; 3 * surface.patch_count()];
    // The group of its owner has the number of the vertex; the others get new ones, in the order of the patches.
    for (v, (patch, corner)) in (0..).zip(lattice.corner_owners()) {
        numbers[groups.of(3 * patch.index() + usize::from(*corner))] = Some(v);
    }
    (0..3 * surface.patch_count())
        .map(|at| {
            *numbers[groups.of(at)].get_or_insert_with(|| {
                normals.push(normal(PatchId((at / 3) as u32), index::row(n, at % 3, 0, 0)));
                normals.len() as u32 - 1
            })
        })
        .collect()
}

/// Disjoint sets.
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn of(&mut self, mut at: usize) -> usize {
        while self.0[at] != at {
            self.0[at] = self.0[self.0[at]];
            at = self.0[at];
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}
