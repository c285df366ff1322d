//! Parameter domains as convex polygons.

use crate::surface::Domain;

/// Parameters of a patch.
pub(super) type Uv = [f64; 2];

/// Corners of a domain, counter-clockwise.
pub(super) fn corners(domain: Domain) -> Vec<Uv> {
    let rectangle = |width: f64| vec![[0.0, 0.0], [width, 0.0], [width, 1.0], [0.0, 1.0]];
    match domain {
        Domain::Triangle => vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        Domain::Square => rectangle(1.0),
        Domain::Polygon(n) => rectangle(f64::from(n)),
    }
}

/// Largest values of both parameters.
pub(super) fn extent(domain: Domain) -> Uv {
    match domain {
        Domain::Triangle | Domain::Square => [1.0; 2],
        Domain::Polygon(n) => [f64::from(n), 1.0],
    }
}

/// The domain as triangles, on each of which the patch is smooth.
pub(super) fn halves(domain: Domain) -> Vec<[Uv; 3]> {
    if let Domain::Polygon(n) = domain {
        let squares = (0..n).map(f64::from).map(|k| [[k, 0.0], [k + 1.0, 0.0], [k + 1.0, 1.0], [k, 1.0]]);
        return squares.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    }
    let c = corners(domain);
    (1..c.len() - 1).map(|i| [c[0], c[i], c[i + 1]]).collect()
}

/// A triangle in four, by the midpoints of its edges.
pub(super) fn quarters([a, b, c]: [Uv; 3]) -> [[Uv; 3]; 4] {
    let middle = |p: Uv, q: Uv| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
}

/// Twice the signed area of a triangle.
fn area(a: Uv, b: Uv, c: Uv) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Is the point in a convex polygon, or outside of it by at most `slack` times its height over an edge?
pub(super) fn contains(polygon: &[Uv], p: Uv, slack: f64) -> bool {
    (0..polygon.len()).all(|i| {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let height = polygon.iter().map(|c| area(a, b, *c)).fold(0.0, f64::max);
        area(a, b, p) >= -slack * height
    })
}

/// A point of the domain near one that may be outside.
pub(super) fn clamped(domain: Domain, [u, v]: Uv) -> Uv {
    let u = u.clamp(0.0, extent(domain)[0]);
    match domain {
        Domain::Triangle => [u, v.clamp(0.0, 1.0 - u)],
        Domain::Square | Domain::Polygon(_) => [u, v.clamp(0.0, 1.0)],
    }
}

/// A convex quadratic function g·x + x·Hx/2 of a step x, H = [[h₀, h₁], [h₁, h₂]] positive definite.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadratic {
    pub g: [f64; 2],
    pub h: [f64; 3],
}

impl Quadratic {
    /// The step from `from` to the lowest point of a domain.
    pub fn lowest(&self, domain: Domain, from: Uv) -> [f64; 2] {
        let ([g0, g1], [h0, h1, h2]) = (self.g, self.h);
        let determinant = h0 * h2 - h1 * h1;
        let newton = [(h1 * g1 - h2 * g0) / determinant, (h1 * g0 - h0 * g1) / determinant];
        let polygon = corners(domain);
        if contains(&polygon, [from[0] + newton[0], from[1] + newton[1]], 0.0) {
            return newton;
        }
        // The lowest point is on the boundary.
        let on_edge = (0..polygon.len()).map(|i| {
            let [a, b] = [i, (i + 1) % polygon.len()].map(|i| [0, 1].map(|c| polygon[i][c] - from[c]));
            let along = [b[0] - a[0], b[1] - a[1]];
            let t = -dot(self.slope(a), along) / dot(self.times(along), along);
            let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
            [a[0] + t * along[0], a[1] + t * along[1]]
        });
        let lower = |best: ([f64; 2], f64), x: [f64; 2]| {
            let value = dot(self.g, x) + 0.5 * dot(self.times(x), x);
            if value < best.1 { (x, value) } else { best }
        };
        on_edge.fold(([0.0; 2], f64::INFINITY), lower).0
    }

    fn times(&self, x: [f64; 2]) -> [f64; 2] {
        [self.h[0] * x[0] + self.h[1] * x[1], self.h[1] * x[0] + self.h[2] * x[1]]
    }

    fn slope(&self, x: [f64; 2]) -> [f64; 2] {
        let hx = self.times(x);
        [self.g[0] + hx[0], self.g[1] + hx[1]]
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_point_is_below_all_others() {
        for n in 0..200 {
            let noise = |k: f64| (f64::from(n) * 12.9898 + k).sin();
            let (a, b, c) = (noise(0.0), noise(1.0), noise(2.0));
            let h = [a * a + b * b + 0.01, b * c, c * c + b * b + 0.01];
            let model = Quadratic { g: [noise(3.0), noise(4.0)], h };
            let value = |x: [f64; 2]| dot(model.g, x) + 0.5 * dot(model.times(x), x);
            for domain in [Domain::Triangle, Domain::Square, Domain::Polygon(5)] {
                let from = [0.3, 0.4];
                let x = model.lowest(domain, from);
                assert!(contains(&corners(domain), [from[0] + x[0], from[1] + x[1]], 1e-15));
                for [u, v, _] in crate::bernstein::triangle::lattice(9) {
                    assert!(value(x) <= value([u - from[0], v - from[1]]) + 1e-15);
                }
            }
        }
    }

    #[test]
    fn points_outside_are_clamped() {
        assert_eq!(clamped(Domain::Triangle, [0.25, 0.25]), [0.25, 0.25]);
        assert_eq!(clamped(Domain::Triangle, [0.75, 0.5]), [0.75, 0.25]);
        assert_eq!(clamped(Domain::Triangle, [-1.0, 2.0]), [0.0, 1.0]);
        assert_eq!(clamped(Domain::Square, [0.75, 1.5]), [0.75, 1.0]);
    }
}
