//! How good a flat triangle is.

use super::decimate::Limits;
use super::singular_mesh::VertexKind;
use super::triangulate::distance;
use crate::field::Field;
use crate::geom::{Point3, Vec3};

/// Points at which triangles are compared with the surface: a lattice with this many intervals along each edge.
const INTERVALS: usize = 6;
/// Triangles at a larger angle than this one (60°) to the surface at a corner are worse than any with a bad shape.
const TURN: f64 = 0.5;

/// Judges triangles on vertices that do not move.
pub(super) struct Judge<'a> {
    field: &'a dyn Field,
    positions: &'a [Point3],
    kinds: &'a [VertexKind],
    /// Unit normals at regular vertices.
    normals: Vec<Vec3>,
    limits: Limits,
    weights: Vec<[f64; 3]>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(field: &'a dyn Field, positions: &'a [Point3], kinds: &'a [VertexKind], limits: Limits) -> Self {
        let n = INTERVALS;
        let weights = (0..=n)
            .flat_map(|i| (0..=n - i).map(move |j| [i, j, n - i - j]))
            .filter(|w| w.iter().all(|k| *k < n))
            .map(|w| w.map(|k| k as f64 / n as f64))
            .collect();
        let normals = positions.iter().map(|p| field.gradient(*p).1.try_normalize(0.0).unwrap_or_else(Vec3::zeros));
        Self { field, positions, kinds, normals: normals.collect(), limits, weights }
    }

    /// The least cosine of an angle between a triangle and the surface at its regular corners.
    pub(super) fn cosine(&self, corners: [u32; 3]) -> f64 {
        let [p, q, r] = corners.map(|v| self.positions[v as usize]);
        let Some(normal) = (q - p).cross(&(r - p)).try_normalize(0.0) else { return -1.0 };
        let regular = corners.iter().filter(|v| self.kinds[**v as usize] == VertexKind::Regular);
        regular.map(|v| self.normals[*v as usize].dot(&normal)).fold(1.0, f64::min)
    }

    /// 4√3 area over the sum of the squared edges: 1 for a regular triangle.
    pub(super) fn shape(&self, corners: [u32; 3]) -> f64 {
        let [p, q, r] = corners.map(|v| self.positions[v as usize]);
        let edges = (q - p).norm_squared() + (r - q).norm_squared() + (p - r).norm_squared();
        2.0 * 3f64.sqrt() * (q - p).cross(&(r - p)).norm() / edges
    }

    /// The shape, less what is wrong with the direction.
    pub(super) fn quality(&self, corners: [u32; 3]) -> f64 {
        self.shape(corners) + (self.cosine(corners) - TURN).min(0.0) / TURN
    }

    /// The largest distance of a triangle from the surface; less than that where it is above `enough`.
    pub(super) fn distance(&self, corners: [u32; 3], enough: f64) -> f64 {
        let [p, q, r] = corners.map(|v| self.positions[v as usize]);
        let mut largest = 0.0;
        for w in &self.weights {
            let at = p * w[0] + q * w[1] + r * w[2];
            largest = distance(self.field, at, self.limits.floor).max(largest);
            if largest > enough {
                break;
            }
        }
        largest
    }

    /// Is the triangle nowhere farther from the surface than the tolerance?
    pub(super) fn is_near(&self, corners: [u32; 3]) -> bool {
        self.distance(corners, self.limits.tolerance) <= self.limits.tolerance
    }
}
