//! How finely to tessellate for a tolerance.

use super::{APatchResolution, MAX_INTERVALS};
use crate::bernstein::index;
use crate::geom::Point3;
use crate::parallel::Evenly;
use crate::surface::{Domain, PatchId, Surface};
use rayon::prelude::*;

/// Intervals of the coarse tessellation that all patches are measured with, along and across.
const COARSE: [usize; 2] = [4, 2];
/// Patches of each domain that are measured again with what came out: those that were worst.
const WORST: usize = 64;
/// Most rounds of measuring again. The error falls with the square of the interval where patches are smooth, and more slowly
/// where they bend hard, near vertices.
const ROUNDS: usize = 8;
/// Most intervals that are measured with; for more, the error is scaled by the square of the interval.
const MEASURED: usize = 128;
/// What comes out is made finer by this factor, beyond what the error asks for.
const RESERVE: f64 = 1.05;

/// A resolution with what it was chosen for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptedResolution {
    /// Intervals along the edges of all patches, and across the square ones. For a surface of triangular patches only, `along` is
    /// the resolution of [`TessellateOptions`](super::TessellateOptions).
    pub resolution: APatchResolution,
    /// Chord error that was measured with it on the patches where the coarse error was largest, relative to the diagonal; with
    /// more than 128 intervals, scaled from that. Above the tolerance only if the resolution has come to
    /// [`MAX_INTERVALS`].
    pub error: f64,
}

/// The chord errors of one patch.
#[derive(Clone, Copy, Debug, Default)]
struct Chords {
    /// Along the edges of triangles, and along u of squares.
    along: f64,
    /// Along v of squares.
    across: f64,
    /// Along the diagonals of squares.
    diagonal: f64,
}

impl Chords {
    fn max(self, other: Self) -> Self {
        Self {
            along: self.along.max(other.along),
            across: self.across.max(other.across),
            diagonal: self.diagonal.max(other.diagonal),
        }
    }

    fn largest(&self) -> f64 {
        self.along.max(self.across).max(self.diagonal)
    }
}

/// The coarsest resolution found whose chord error is at most `tolerance` times `diagonal`.
///
/// The chord error is the height of the surface over the midpoints of the edges of the tessellation. It is measured with
/// 4 × 2 intervals on every patch, scaled by the square of the interval, and measured again on the worst patches until it
/// holds there. It is measured, not certified. One resolution for all patches keeps the tessellation free of cracks.
///
/// `tolerance` is positive, `diagonal` that of the box of the base mesh's vertices; for anything else, and for a tolerance that
/// is out of reach, the finest resolution is returned with its error. Points that are not defined are left out.
pub fn resolution_for(surface: &dyn Surface, diagonal: f64, tolerance: f64) -> AdaptedResolution {
    let measured = |patches: &[PatchId], [n, m]: [usize; 2]| -> Vec<(PatchId, Chords)> {
        patches.par_iter().evenly().map(|p| (*p, chords(surface, *p, n, m))).collect()
    };
    let all: Vec<PatchId> = surface.patches().collect();
    let coarse = measured(&all, COARSE);
    let is_square = |p: PatchId| surface.domain(p) == Domain::Square;
    let [triangles, squares] = [false, true].map(|square| {
        let mut of_kind: Vec<_> = coarse.iter().filter(|(p, _)| is_square(*p) == square).collect();
        of_kind.sort_by(|a, b| b.1.largest().total_cmp(&a.1.largest()).then(a.0.cmp(&b.0)));
        of_kind
    });
    let worst: Vec<PatchId> =
        triangles.iter().take(WORST).chain(squares.iter().take(WORST)).map(|(p, _)| *p).collect();
    let largest = |of: &[(PatchId, Chords)]| of.iter().fold(Chords::default(), |all, (_, c)| all.max(*c));
    let allowed = tolerance * diagonal;
    let finer = |intervals: usize, error: f64| {
        // A ratio that is not a number asks for the finest.
        let wanted = (intervals as f64 * (error / allowed).sqrt() * RESERVE).ceil();
        if wanted >= 1.0 && wanted < MAX_INTERVALS as f64 { wanted as usize } else { MAX_INTERVALS }
    };
    let clamped = |intervals: usize, error: f64| if error == 0.0 { 1 } else { finer(intervals, error) };
    let first = largest(&coarse);
    // Along and across each get the part of the tolerance at a diagonal that is theirs.
    let sum = first.along + first.across;
    let share = if first.diagonal > 0.0 && sum > 0.0 { (first.diagonal / sum).max(1.0) } else { 1.0 };
    let mut intervals = [clamped(COARSE[0], share * first.along), clamped(COARSE[1], share * first.across)];
    let with = |intervals: [usize; 2]| {
        let measurable = intervals.map(|n| n.min(MEASURED));
        let [along, across] = [0, 1].map(|c| (measurable[c] as f64 / intervals[c] as f64).powi(2));
        let found = largest(&measured(&worst, measurable));
        let diagonal = along.max(across) * found.diagonal;
        Chords { along: along * found.along, across: across * found.across, diagonal }
    };
    let mut error = with(intervals);
    for _ in 0..ROUNDS {
        if error.largest() <= allowed || intervals.iter().all(|n| *n == MAX_INTERVALS) {
            break;
        }
        let [n, m] = intervals;
        let diagonal_too = |e: f64| if error.diagonal > allowed { e.max(error.diagonal) } else { e };
        let next = [diagonal_too(error.along), diagonal_too(error.across)];
        intervals = [finer(n, next[0].max(allowed)).max(n), finer(m, next[1].max(allowed)).max(m)];
        error = with(intervals);
    }
    let [along, across] = intervals;
    AdaptedResolution { resolution: APatchResolution { along, across }, error: error.largest() / diagonal }
}

/// Chord errors of a patch on a lattice with n intervals, or a grid with n × m.
fn chords(surface: &dyn Surface, patch: PatchId, n: usize, m: usize) -> Chords {
    let point = |uv| surface.sample(patch, uv).point;
    // Height of the surface over the midpoint of a chord.
    let height = |ends: [Point3; 2], middle: [f64; 2]| {
        let at = surface.sample(patch, middle);
        let height = (at.point - 0.5 * (ends[0] + ends[1])).dot(&at.normal).abs();
        if height.is_finite() { height } else { 0.0 }
    };
    let mut found = Chords::default();
    match surface.domain(patch) {
        Domain::Triangle => {
            let uv = |[i, j, _]: [usize; 3]| [i as f64 / n as f64, j as f64 / n as f64];
            let points: Vec<Point3> = index::indices(n).map(|ijk| point(uv(ijk))).collect();
            for [i, j, k] in index::indices(n - 1) {
                let corners = [[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]];
                for c in 0..3 {
                    let (a, b) = (corners[c], corners[(c + 1) % 3]);
                    let (p, q) = (uv(a), uv(b));
                    let ends = [a, b].map(|ijk| points[index::position(ijk)]);
                    let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
                    found.along = found.along.max(height(ends, middle));
                }
            }
        }
        // The patch over an edge shrinks to a point at u = 0; others are as long as they are wide.
        Domain::Square if point([0.0, 0.0]) == point([0.0, 1.0]) => {
            found = chords_of_grid([0.0, 1.0], n, m, &point, &height);
        }
        Domain::Square => found.along = chords_of_grid([0.0, 1.0], n, n, &point, &height).largest(),
        Domain::Polygon(count) => {
            for k in (0..count).map(f64::from) {
                let of_sector = chords_of_grid([k, k + 1.0], n, n, &point, &height).largest();
                found.along = found.along.max(of_sector);
            }
        }
    }
    found
}

/// Chord errors of a grid over a rectangle, with u between the two bounds.
fn chords_of_grid(
    [low, high]: [f64; 2],
    n: usize,
    m: usize,
    point: &dyn Fn([f64; 2]) -> Point3,
    height: &dyn Fn([Point3; 2], [f64; 2]) -> f64,
) -> Chords {
    let mut found = Chords::default();
    let uv = |i: f64, j: f64| [low + (high - low) * i / n as f64, j / m as f64];
    let points: Vec<Point3> =
        (0..=n).flat_map(|i| (0..=m).map(move |j| point(uv(i as f64, j as f64)))).collect();
    let at = |i: usize, j: usize| points[i * (m + 1) + j];
    for i in 0..=n {
        for j in 0..=m {
            let (x, y) = (i as f64, j as f64);
            if i < n {
                let error = height([at(i, j), at(i + 1, j)], uv(x + 0.5, y));
                found.along = found.along.max(error);
            }
            if j < m {
                let error = height([at(i, j), at(i, j + 1)], uv(x, y + 0.5));
                found.across = found.across.max(error);
            }
            if i < n && j < m {
                let error = height([at(i, j), at(i + 1, j + 1)], uv(x + 0.5, y + 0.5));
                found.diagonal = found.diagonal.max(error);
            }
        }
    }
    found
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::apatch::{self, APatchOptions, APatchSurface};
    use crate::hull::test_meshes::{quadrics, torus, torus_distance};
    use crate::hull::{self, HermiteMesh, HullOptions};
    use crate::tessellate::{TessellateOptions, tessellate, tessellate_a_patches};

    fn surface(data: HermiteMesh) -> APatchSurface {
        let hull = hull::build(data, &HullOptions::default());
        APatchSurface::new(apatch::build(hull, &APatchOptions::default()))
    }

    /// Largest distance of the centroids of triangles and the midpoints of their edges.
    fn error(
        surface: &APatchSurface,
        resolution: APatchResolution,
        distance: impl Fn(&Point3) -> f64,
    ) -> f64 {
        let mesh = tessellate_a_patches(surface, resolution).unwrap();
        let mut worst: f64 = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            for p in [(a + b + c) / 3.0, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)] {
                worst = worst.max(distance(&p));
            }
        }
        worst
    }

    #[test]
    fn tolerances_hold_and_are_not_undercut_by_far() {
        let sphere = surface(quadrics().swap_remove(0).2);
        let torus = surface(torus([24, 16]));
        let on_sphere = |p: &Point3| (p.norm() - 1.0).abs();
        for tolerance in [1e-2, 1e-3, 1e-4] {
            for (surface, distance, own) in
                [(&sphere, &on_sphere as &dyn Fn(&Point3) -> f64, 0.0), (&torus, &torus_distance, 5e-4)]
            {
                let diagonal = surface.function().hull().data().diagonal();
                let found = resolution_for(surface, diagonal, tolerance);
                assert!(found.error <= tolerance, "{found:?}");
                let reached = error(surface, found.resolution, distance);
                // The centroid of a triangle is 4/3 as far from a sphere as the midpoints of its edges.
                assert!(
                    reached <= 4.0 / 3.0 * tolerance * diagonal + own,
                    "{tolerance}: {reached:e} {found:?}"
                );
                assert!(
                    found.error > tolerance / 8.0 || found.resolution.along < 4,
                    "{tolerance}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn splines_get_a_resolution_too() {
        let spline = crate::golden::sphere();
        let found = resolution_for(&spline, 2.95, 1e-4);
        let resolution = found.resolution.along;
        let mesh = tessellate(&spline, &TessellateOptions { resolution }).unwrap();
        let middle = |t: &[u32; 3]| 0.5 * (mesh.positions[t[0] as usize] + mesh.positions[t[1] as usize]);
        let worst = mesh.triangles.iter().map(|t| (middle(t).norm() - 1.0).abs()).fold(0.0, f64::max);
        // The spline itself is within 8.6e-5 of the diagonal.
        assert!(found.error <= 1e-4 && worst < 2.0e-4 * 2.95 && worst > 2e-5, "{worst:e} {found:?}");
    }

    #[test]
    fn what_is_out_of_reach_gets_the_finest() {
        let data = quadrics().swap_remove(0).2;
        let sphere = surface(data);
        for tolerance in [0.0, -1.0, f64::NAN] {
            let found = chord_free(&sphere, tolerance);
            assert_eq!(found, APatchResolution { along: MAX_INTERVALS, across: MAX_INTERVALS });
        }
    }

    fn chord_free(surface: &APatchSurface, tolerance: f64) -> APatchResolution {
        resolution_for(surface, 1.0, tolerance).resolution
    }
}
