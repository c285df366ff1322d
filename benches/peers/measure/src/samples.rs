//! Points with normals inside triangles and patches.

use crate::shape::{DEGREE, NET, Shape};

/// A point of a result, with its unit normal; none where the element is degenerate.
pub struct Sample {
    /// Where.
    pub point: [f64; 3],
    /// The normal.
    pub normal: Option<[f64; 3]>,
}

/// Inside a triangle: the middle, beside the middles of the edges, and between these and the corners.
const IN_TRIANGLE: [[f64; 3]; 7] = [
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
    [0.49, 0.49, 0.02],
    [0.02, 0.49, 0.49],
    [0.49, 0.02, 0.49],
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
];
/// Intervals along the edge of a patch: 91 points, on its border too.
const IN_PATCH: usize = 12;

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Triangles with a height below this share of the diagonal have no normal: rounding to single precision, as most
/// programs give coordinates, would turn it by a degree and more.
const LEAST_HEIGHT: f64 = 3e-6;

/// Unit normal of a triangle.
fn triangle_normal([a, b, c]: [[f64; 3]; 3], diagonal: f64) -> Option<[f64; 3]> {
    let edges = [minus(b, a), minus(c, a), minus(c, b)];
    let n = cross(edges[0], edges[1]);
    let twice_area = length(n);
    let longest = edges.map(length).into_iter().fold(0.0, f64::max);
    (twice_area > LEAST_HEIGHT * diagonal * longest).then(|| n.map(|x| x / twice_area))
}

fn at(corners: [[f64; 3]; 3], uvw: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|k| uvw[k] * corners[k][i]).sum())
}

/// Bernstein values and differences of one degree less at a point of the domain, by the rows of their definition.
struct Basis {
    values: [f64; NET],
    /// Derivatives from the third corner towards the first and the second.
    slopes: [[f64; NET]; 2],
}

fn index(n: usize, i: usize, j: usize) -> usize {
    let below = n - i;
    below * (below + 1) / 2 + (below - j)
}

fn bernstein(n: usize, [u, v, w]: [f64; 3]) -> Vec<f64> {
    let factorial = |m: usize| (1..=m).map(|x| x as f64).product::<f64>();
    let mut all = vec![0.0; (n + 1) * (n + 2) / 2];
    for i in 0..=n {
        for j in 0..=n - i {
            let k = n - i - j;
            let count = factorial(n) / (factorial(i) * factorial(j) * factorial(k));
            all[index(n, i, j)] = count * u.powi(i as i32) * v.powi(j as i32) * w.powi(k as i32);
        }
    }
    all
}

impl Basis {
    fn new(uvw: [f64; 3]) -> Self {
        let all = bernstein(DEGREE, uvw);
        let lower = bernstein(DEGREE - 1, uvw);
        let mut slopes = [[0.0; NET]; 2];
        for i in 0..DEGREE {
            for j in 0..DEGREE - i {
                let b = DEGREE as f64 * lower[index(DEGREE - 1, i, j)];
                slopes[0][index(DEGREE, i + 1, j)] += b;
                slopes[1][index(DEGREE, i, j + 1)] += b;
                slopes.iter_mut().for_each(|row| row[index(DEGREE, i, j)] -= b);
            }
        }
        Self { values: std::array::from_fn(|i| all[i]), slopes }
    }

    fn sample(&self, net: &[[f64; 3]; NET]) -> Sample {
        let sum = |row: &[f64; NET]| {
            let mut p = [0.0; 3];
            for (b, q) in row.iter().zip(net) {
                (0..3).for_each(|i| p[i] += b * q[i]);
            }
            p
        };
        let n = cross(sum(&self.slopes[0]), sum(&self.slopes[1]));
        let size = length(n);
        Sample { point: sum(&self.values), normal: (size > 0.0).then(|| n.map(|x| x / size)) }
    }
}

/// Gives `to` the samples of every `stride`-th element of a surface with this diagonal.
pub fn visit(shape: &Shape, diagonal: f64, stride: usize, mut to: impl FnMut(&Sample)) {
    match shape {
        Shape::Mesh { points, triangles } => {
            for triangle in triangles.iter().step_by(stride) {
                let corners = triangle.map(|k| points[k as usize]);
                let normal = triangle_normal(corners, diagonal);
                IN_TRIANGLE.iter().for_each(|uvw| to(&Sample { point: at(corners, *uvw), normal }));
            }
        }
        Shape::Nets(nets) => {
            let n = IN_PATCH;
            let part = |i: usize| i as f64 / n as f64;
            let bases: Vec<Basis> = (0..=n)
                .flat_map(|i| (0..=n - i).map(move |j| [part(i), part(j), part(n - i - j)]))
                .map(Basis::new)
                .collect();
            for net in nets.iter().step_by(stride) {
                bases.iter().for_each(|basis| to(&basis.sample(net)));
            }
        }
    }
}

/// How many samples an element gets.
pub fn count(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh { .. } => IN_TRIANGLE.len(),
        Shape::Nets(_) => (IN_PATCH + 1) * (IN_PATCH + 2) / 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The patch (u, v) ↦ (u, v, u²), with the control points of u² in degree 7.
    fn parabola() -> Shape {
        let mut net = [[0.0; 3]; NET];
        for i in 0..=DEGREE {
            for j in 0..=DEGREE - i {
                let square = (i * i.saturating_sub(1)) as f64 / (DEGREE * (DEGREE - 1)) as f64;
                net[index(DEGREE, i, j)] = [i as f64 / DEGREE as f64, j as f64 / DEGREE as f64, square];
            }
        }
        Shape::Nets(vec![net])
    }

    #[test]
    fn a_patch_is_sampled_on_it_with_its_normals() {
        let mut seen = 0;
        let shape = parabola();
        visit(&shape, 1.0, 1, |sample| {
            let [x, _, z] = sample.point;
            assert!((z - x * x).abs() < 1e-13);
            let length = (1.0 + 4.0 * x * x).sqrt();
            let truth = [-2.0 * x / length, 0.0, 1.0 / length];
            let normal = sample.normal.expect("the patch is regular");
            assert!((0..3).all(|i| (normal[i] - truth[i]).abs() < 1e-12));
            seen += 1;
        });
        assert_eq!(seen, count(&shape));
    }
}
