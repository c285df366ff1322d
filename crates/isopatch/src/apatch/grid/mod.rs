//! Many points of a patch at once: the factors of the coefficients are tabulated for fixed parameters, and points are
//! computed in vector lanes.

mod edge;
mod face;

pub use edge::{EdgeCells, EdgeTable};
pub use face::{FaceCells, FaceTable};

pub use super::lanes::Vectors;

use super::lanes::LANES;
use super::shoot::Shot;
use crate::geom::{PointsMut, Vec3};

/// Where results go: slices of one length for points, and for normals if they are wanted.
#[derive(Debug)]
pub struct GridOut<'a> {
    /// Positions.
    pub points: PointsMut<'a>,
    /// Unit normals, outward.
    pub normals: Option<PointsMut<'a>>,
}

#[inline(always)]
fn copy(out: &mut PointsMut<'_>, at: usize, used: usize, from: &[[f64; LANES]; 3]) {
    for (out, from) in [&mut *out.x, &mut *out.y, &mut *out.z].into_iter().zip(from) {
        // A copy of fixed length is an instruction, one of any length a call.
        match out[at..].first_chunk_mut::<LANES>() {
            Some(out) if used == LANES => *out = *from,
            _ => out[at..at + used].copy_from_slice(&from[..used]),
        }
    }
}

impl GridOut<'_> {
    /// The first `used` of a lane.
    #[inline(always)]
    pub(super) fn put<const NORMALS: bool>(
        &mut self,
        at: usize,
        used: usize,
        points: &[[f64; LANES]; 3],
        normals: &[[f64; LANES]; 3],
    ) {
        copy(&mut self.points, at, used, points);
        if NORMALS && let Some(out) = &mut self.normals {
            copy(out, at, used, normals);
        }
    }

    /// One point and its normal.
    pub fn set(&mut self, at: usize, point: Vec3, normal: Vec3) {
        let set = |out: &mut PointsMut<'_>, v: Vec3| (out.x[at], out.y[at], out.z[at]) = (v.x, v.y, v.z);
        set(&mut self.points, point);
        if let Some(out) = &mut self.normals {
            set(out, normal);
        }
    }

    /// Asks for the points among the first `count` that the lanes have left NaN; they stay so if there is none.
    pub fn complete(&mut self, count: usize, shoot: impl Fn(usize) -> Option<Shot>) {
        let missing = |x: &[f64], at: usize| (at..count).find(|i| x[*i].is_nan());
        let mut next = missing(self.points.x, 0);
        while let Some(at) = next {
            let nan = Vec3::repeat(f64::NAN);
            let (point, normal) = shoot(at).map_or((nan, nan), |s| (s.point, s.gradient.normalize()));
            self.set(at, point, normal);
            next = missing(self.points.x, at + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apatch::{APatchOptions, build};
    use crate::bernstein::triangle;
    use crate::geom::Points;
    use crate::hull::test_meshes::{perturbed, torus};
    use crate::hull::{self, HullOptions};

    /// Bits of the points and normals that are computed in each of the vectors.
    fn bits(count: usize, evaluate: impl Fn(Vectors, &mut GridOut<'_>)) -> [[[Vec<u64>; 3]; 2]; 2] {
        [Vectors::Baseline, Vectors::Widest].map(|vectors| {
            let mut found = [Points::zeros(count), Points::zeros(count)];
            let [points, normals] = &mut found;
            evaluate(vectors, &mut GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) });
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            found.map(|p| [bits(&p.x), bits(&p.y), bits(&p.z)])
        })
    }

    #[test]
    fn the_width_of_vectors_does_not_change_a_bit() {
        // More than one block of chunks, the last one not full.
        let over_edge: Vec<[f64; 3]> = (0..=8)
            .flat_map(|i| (0..=4).map(move |j| (f64::from(i) / 8.0, f64::from(j) / 4.0)))
            .map(|(x, y)| [x, 1.0 - x, y])
            .collect();
        let (faces, edges) = (FaceTable::new(&triangle::lattice(8)), EdgeTable::new(&over_edge));
        for data in [perturbed(0.1, 0.3), torus([16, 10])] {
            let function = build(hull::build(data, &HullOptions::default()), &APatchOptions::default());
            let mesh = function.hull().data().mesh();
            for f in mesh.faces() {
                let [narrow, wide] = bits(faces.len(), |vectors, out| {
                    faces.clone().with_vectors(vectors).evaluate(&function, f, out);
                });
                assert_eq!(narrow, wide, "{f:?}");
            }
            for e in mesh.edges().filter(|e| function.edges()[e.index()].iter().any(Option::is_some)) {
                let [narrow, wide] = bits(edges.len(), |vectors, out| {
                    edges.clone().with_vectors(vectors).evaluate(&function, e, out);
                });
                assert_eq!(narrow, wide, "{e:?}");
            }
        }
    }
}
