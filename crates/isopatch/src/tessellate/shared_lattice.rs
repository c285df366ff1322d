use crate::bernstein::index;
use crate::parallel::Evenly;
use crate::surface::{Domain, PatchId, Surface};
use rayon::prelude::*;

/// The seam that an edge of a patch lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// Number of the seam in [`Surface::seams`].
    pub seam: u32,
    /// Does the patch's edge run against the seam?
    pub reversed: bool,
}

/// Why the patches of a surface do not say what they share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SharingError {
    /// An edge of a patch is on no seam, or on more than one.
    #[error("edge {edge} of patch {patch} is not on exactly one seam")]
    Seam {
        /// The patch.
        patch: u32,
        /// Its edge.
        edge: u8,
    },
    /// No patch has a corner with this number, though there are larger ones.
    #[error("no patch has the corner {vertex}")]
    UnusedCorner {
        /// The corner's number.
        vertex: u32,
    },
    /// A patch has another domain than a triangle.
    #[error("patch {patch} is no triangle")]
    NotATriangle {
        /// The patch.
        patch: u32,
    },
    /// More points than 32-bit numbers can tell apart.
    #[error("{points} points are too many to number")]
    TooManyPoints {
        /// How many.
        points: u128,
    },
}

/// One numbering of the lattice points (i, j, k), i + j + k = n, of all patches.
///
/// First the corners, by their own numbers; then n − 1 points a seam, in its direction; then the interior points
/// of each patch in net order. Points that patches share have one number.
#[derive(Clone, Debug)]
pub struct SharedLattice {
    n: usize,
    corners: Vec<[u32; 3]>,
    edges: Vec<[EdgeUse; 3]>,
    /// A patch and one of its corners, per corner number.
    corner_owner: Vec<(PatchId, u8)>,
    /// The patch and edge that give each seam its points.
    seam_owner: Vec<(PatchId, EdgeUse, u8)>,
}

const NO_SEAM: u32 = u32::MAX;

impl SharedLattice {
    /// Numbers the lattices of `n` ≥ 1 intervals an edge.
    pub fn new(surface: &dyn Surface, n: usize) -> Result<Self, SharingError> {
        if let Some(patch) = surface.patches().find(|p| surface.domain(*p) != Domain::Triangle) {
            return Err(SharingError::NotATriangle { patch: patch.0 });
        }
        let corners: Vec<[u32; 3]> = surface.patches().map(|p| surface.corners(p)).collect();
        let edges = edge_uses(surface)?;
        let corner_owner = corner_owners(&corners)?;
        let seam_owner = surface.seams().iter().map(|s| {
            let side = s.first;
            (side.patch, edges[side.patch.index()][side.edge as usize], side.edge)
        });
        let lattice = Self { n, seam_owner: seam_owner.collect(), corners, edges, corner_owner };
        let points = lattice.corner_owner.len() as u128
            + lattice.seam_owner.len() as u128 * (n as u128 - 1)
            + lattice.corners.len() as u128 * ((n as u128 - 1) * (n as u128).saturating_sub(2) / 2);
        match u32::try_from(points) {
            Ok(_) => Ok(lattice),
            Err(_) => Err(SharingError::TooManyPoints { points }),
        }
    }

    /// Number of corners.
    pub fn corner_count(&self) -> usize {
        self.corner_owner.len()
    }

    /// The patch and the edge from which each seam has its points; `reversed` if the edge runs against the seam.
    pub(super) fn seam_owners(&self) -> &[(PatchId, EdgeUse, u8)] {
        &self.seam_owner
    }

    /// The patch, and its corner, from which each corner has its point.
    pub(super) fn corner_owners(&self) -> &[(PatchId, u8)] {
        &self.corner_owner
    }

    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.interior_start() + self.corners.len() * self.interior_count()
    }

    /// The seams under the three edges of a patch.
    pub fn edges(&self, patch: PatchId) -> [EdgeUse; 3] {
        self.edges[patch.index()]
    }

    /// The numbers of the three corners of a patch.
    pub fn corners(&self, patch: PatchId) -> [u32; 3] {
        self.corners[patch.index()]
    }

    /// Number of the point (i, j, k) of a patch.
    pub fn number(&self, patch: PatchId, ijk: [usize; 3]) -> u32 {
        if let Some(c) = ijk.iter().position(|i| *i == self.n) {
            return self.corners[patch.index()][c];
        }
        match ijk.iter().position(|i| *i == 0) {
            // Edge e runs from corner e to e + 1; the coordinate that vanishes on it is e + 2.
            Some(zero) => {
                let edge = (zero + 1) % 3;
                let along = ijk[(edge + 1) % 3];
                let EdgeUse { seam, reversed } = self.edges[patch.index()][edge];
                let m = if reversed { self.n - along } else { along };
                (self.corner_count() + seam as usize * (self.n - 1) + m - 1) as u32
            }
            None => {
                // The interior is a net of degree n − 3.
                let inner = index::position(ijk.map(|i| i - 1));
                (self.interior_start() + patch.index() * self.interior_count() + inner) as u32
            }
        }
    }

    /// Numbers of all points of a patch, in net order, into `numbers`, which has room for them.
    pub fn numbers(&self, patch: PatchId, numbers: &mut [u32]) {
        let n = self.n;
        let corners = self.corners[patch.index()];
        let on_edge = |edge: usize, m: usize| {
            let EdgeUse { seam, reversed } = self.edges[patch.index()][edge];
            let m = if reversed { n - m } else { m };
            (self.corner_count() + seam as usize * (n - 1) + m - 1) as u32
        };
        let inside = (self.interior_start() + patch.index() * self.interior_count()) as u32;
        number_net(n, corners, on_edge, inside, numbers);
    }

    /// One entry for each point, in the order of the numbers: those of the corners, of the seams, and inside patches.
    pub(super) fn parts<'a, T>(&self, all: &'a mut [T]) -> [&'a mut [T]; 3] {
        let (borders, inside) = all.split_at_mut(self.interior_start());
        let (corners, seams) = borders.split_at_mut(self.corner_count());
        [corners, seams, inside]
    }

    /// One value for each point in the order of the numbers, computed in parallel: `value(patch, position)` is
    /// asked once a point, with one patch that has it and the position in that patch's net order.
    pub fn gather<T: Send>(&self, value: impl Fn(PatchId, usize) -> T + Sync) -> Vec<T> {
        let n = self.n;
        let corner = |&(patch, c): &(PatchId, u8)| value(patch, index::row(n, c as usize, 0, 0));
        let mut values: Vec<T> = self.corner_owner.par_iter().evenly().map(corner).collect();
        values.par_extend(self.seam_owner.par_iter().evenly().flat_map_iter(|&(patch, side, edge)| {
            let value = &value;
            (1..n).map(move |m| {
                let along = if side.reversed { n - m } else { m };
                value(patch, index::row(n, edge as usize, 0, along))
            })
        }));
        let inside: Vec<usize> =
            index::indices(n).filter(|ijk| !index::is_boundary(*ijk)).map(index::position).collect();
        values.par_extend((0..self.corners.len() as u32).into_par_iter().evenly().flat_map_iter(|p| {
            let value = &value;
            inside.iter().map(move |position| value(PatchId(p), *position))
        }));
        values
    }

    /// Number of points inside each patch.
    pub(super) fn interior_count(&self) -> usize {
        if self.n < 3 { 0 } else { index::count(self.n - 3) }
    }

    fn interior_start(&self) -> usize {
        self.corner_count() + self.seam_owner.len() * (self.n - 1)
    }
}

/// Numbers the points of a triangular lattice with `n` intervals an edge, in net order: those of its corners, those `on_edge`
/// (e, m), m steps from corner e on, 0 < m < n, and those inside, which follow each other from `inside` on.
pub(super) fn number_net(
    n: usize,
    corners: [u32; 3],
    on_edge: impl Fn(usize, usize) -> u32,
    inside: u32,
    numbers: &mut [u32],
) {
    for (edge, corner) in corners.into_iter().enumerate() {
        numbers[index::row(n, edge, 0, 0)] = corner;
        (1..n).for_each(|m| numbers[index::row(n, edge, 0, m)] = on_edge(edge, m));
    }
    let mut next = inside;
    for row in 2..n {
        for k in 1..row {
            numbers[index::position([n - row, row - k, k])] = next;
            next += 1;
        }
    }
}

fn edge_uses(surface: &dyn Surface) -> Result<Vec<[EdgeUse; 3]>, SharingError> {
    let none = EdgeUse { seam: NO_SEAM, reversed: false };
    let mut edges = vec![[none; 3]; surface.patch_count()];
    for (s, seam) in surface.seams().iter().enumerate() {
        for side in std::iter::once(seam.first).chain(seam.second) {
            let fault = SharingError::Seam { patch: side.patch.0, edge: side.edge };
            let slot = edges.get_mut(side.patch.index()).and_then(|e| e.get_mut(side.edge as usize));
            match slot {
                Some(slot) if slot.seam == NO_SEAM => {
                    *slot = EdgeUse { seam: s as u32, reversed: side.reversed };
                }
                _ => return Err(fault),
            }
        }
    }
    for (patch, uses) in edges.iter().enumerate() {
        if let Some(edge) = uses.iter().position(|u| u.seam == NO_SEAM) {
            return Err(SharingError::Seam { patch: patch as u32, edge: edge as u8 });
        }
    }
    Ok(edges)
}

fn corner_owners(corners: &[[u32; 3]]) -> Result<Vec<(PatchId, u8)>, SharingError> {
    let count = corners.iter().flatten().max().map_or(0, |m| *m as usize + 1);
    let mut owners = vec![None; count];
    for (p, three) in corners.iter().enumerate() {
        for (c, v) in three.iter().enumerate() {
            owners[*v as usize].get_or_insert((PatchId(p as u32), c as u8));
        }
    }
    let owner = |(v, o): (usize, Option<_>)| o.ok_or(SharingError::UnusedCorner { vertex: v as u32 });
    owners.into_iter().enumerate().map(owner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use crate::golden::{flat_triangle, sphere};
    use crate::spline::TriangularSpline;
    use crate::surface::{Domain, PatchForm, Sample, Seam};

    /// A spline that tells something else about its seams and corners.
    struct Misleading {
        spline: TriangularSpline,
        seams: Vec<Seam>,
        corner_shift: u32,
    }

    impl Surface for Misleading {
        fn patch_count(&self) -> usize {
            self.spline.patch_count()
        }
        fn domain(&self, patch: PatchId) -> Domain {
            self.spline.domain(patch)
        }
        fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample {
            self.spline.sample(patch, uv)
        }
        fn form(&self, patch: PatchId) -> PatchForm<'_> {
            self.spline.form(patch)
        }
        fn seams(&self) -> &[Seam] {
            &self.seams
        }
        fn corners(&self, patch: PatchId) -> [u32; 3] {
            self.spline.corners(patch).map(|c| c + self.corner_shift)
        }
        fn bounds(&self, patch: PatchId) -> Aabb {
            self.spline.bounds(patch)
        }
    }

    #[test]
    fn every_patch_finds_its_own_control_points_under_the_numbers() {
        for spline in [sphere(), flat_triangle()] {
            let lattice = SharedLattice::new(&spline, 7).unwrap();
            let points = lattice.gather(|patch, at| spline.nets[patch.index()][at]);
            assert_eq!(points.len(), lattice.point_count());
            for patch in spline.patches() {
                for ijk in index::indices(7) {
                    let shared = points[lattice.number(patch, ijk) as usize];
                    assert_eq!(shared, spline.nets[patch.index()][index::position(ijk)], "{patch:?} {ijk:?}");
                }
            }
        }
    }

    #[test]
    fn seams_can_run_against_their_first_patch() {
        let spline = sphere();
        let mut seams = spline.seams().to_vec();
        for seam in &mut seams {
            seam.first.reversed ^= true;
            if let Some(second) = &mut seam.second {
                second.reversed ^= true;
            }
        }
        let turned = Misleading { spline, seams, corner_shift: 0 };
        let lattice = SharedLattice::new(&turned, 7).unwrap();
        let points = lattice.gather(|patch, at| turned.spline.nets[patch.index()][at]);
        for patch in turned.patches() {
            let mut numbers = [0; 36];
            lattice.numbers(patch, &mut numbers);
            for ijk in index::indices(7) {
                assert_eq!(numbers[index::position(ijk)], lattice.number(patch, ijk));
                let own = turned.spline.nets[patch.index()][index::position(ijk)];
                assert_eq!(points[lattice.number(patch, ijk) as usize], own);
            }
        }
    }

    #[test]
    fn wrong_seams_and_corners_are_named() {
        let build = |change: &dyn Fn(&mut Misleading)| {
            let seams = flat_triangle().seams().to_vec();
            let mut surface = Misleading { spline: flat_triangle(), seams, corner_shift: 0 };
            change(&mut surface);
            SharedLattice::new(&surface, 3).unwrap_err()
        };
        let edge_1 = SharingError::Seam { patch: 0, edge: 1 };
        assert_eq!(build(&|s| _ = s.seams.remove(1)), edge_1);
        assert_eq!(build(&|s| s.seams.push(s.seams[1])), edge_1);
        assert_eq!(build(&|s| s.seams[2].first.patch = PatchId(7)), SharingError::Seam { patch: 7, edge: 2 });
        assert_eq!(build(&|s| s.corner_shift = 1), SharingError::UnusedCorner { vertex: 0 });
    }
}
