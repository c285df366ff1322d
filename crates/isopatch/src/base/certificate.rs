//! Has the surface of a piecewise linear function the topology of f = 0?
//!
//! The leaves of an octree that may hold zeros of f are cut into tetrahedra (see [`super::tetrahedra`]); g is the
//! continuous function that is linear on each of them, with given values at the nodes, and g_T its gradient on T. On all
//! other cells interval bounds exclude zeros of f.
//!
//! **Claim.** {g = 0} is isotopic to {f = 0} in the box, if
//! 1. for every tetrahedron T and all x ∈ T: g_T · A∇f(x) > 0, with A = diag(h₁², h₂², h₃²), h the edges of a leaf; or f
//!    and g have one and the same sign at x;
//! 2. for every face, edge or corner S of the box and all x ∈ T ∩ S: the same with the components along S alone, or f and
//!    g have one and the same sign at x;
//! 3. where a leaf borders on a cell without zeros, g has at the common nodes the sign that f has there.
//!
//! **Proof.** Let F_t = (1 − t) g + t f, 0 ≤ t ≤ 1, and v = A∇f. At a zero p of F_t, f(p) and g(p) do not both have the
//! same sign, so by 1 every T ∋ p has g_T · v(p) > 0, and ∇f · v > 0 follows (v ≠ 0). Hence all of Clarke's
//! generalised gradient of F_t at p, the hull of (1 − t) g_T + t∇f(p), is positive along v: F_t is strictly monotonic
//! along the flow of v near p. By 2, v can be replaced near the boundary of the box by a field that is tangential to all
//! its faces and edges, blended by a partition of unity; monotonicity stays. By 3 there is no zero of F_t on the rest of
//! the leaves' boundary, so the zeros of F_t stay within a compact set. By the implicit function theorem for Lipschitz
//! functions the set {(p, t) : F_t(p) = 0} → [0, 1] is a proper submersion, locally a product, and therefore the flow of
//! t carries {g = 0} to {f = 0}, box sides into themselves, by an isotopy. ∎
//!
//! The values at the nodes need not be those of f: rounding errors in them do no harm. A zero at a node counts as
//! positive, which is a small change of g, and condition 1 is strict. Moving the mesh's vertices along the edges of
//! the tetrahedra, away from their ends, is another isotopy.
//!
//! g_T is computed in the coordinates u ∈ [−1, 1]³ of the leaf, where A is the identity. Bounds of f and ∇f hold over the
//! whole leaf or, tighter, over its eight children.

use super::octree::Cell;
use super::tetrahedra::{LOCAL_NODES, NodeSet, for_tetrahedra, local};
use crate::geom::{Affine, Vec3};

/// What is known of f and ∇f over a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// f.
    pub(super) value: Affine,
    /// The derivatives by u: half an edge times those by x.
    pub(super) gradient: [Affine; 3],
}

/// Why a leaf has no certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Doubt {
    /// Condition 1.
    Inside,
    /// Condition 2 only.
    OnSide,
}

/// Coordinates u of the local nodes.
const PLACES: [[f64; 3]; LOCAL_NODES] = {
    let mut places = [[0.0; 3]; LOCAL_NODES];
    let mut node = 0;
    while node < LOCAL_NODES {
        places[node] = [(node % 3) as f64 - 1.0, (node / 3 % 3) as f64 - 1.0, (node / 9) as f64 - 1.0];
        node += 1;
    }
    places
};

/// Coordinates u of a local node.
pub(super) fn place(node: usize) -> [f64; 3] {
    PLACES[node]
}

/// Bounds the relative rounding of the dozen operations behind a product of gradients.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Checks conditions 1 and 2 for a leaf: `values` of g at its local nodes (those in `nodes` are read), `sides` which sides
/// of the box it touches, `offset` how far the computed nodes may be from the ideal ones, in units of u. The `pieces`
/// cover the leaf.
pub(super) fn check(
    cell: &Cell,
    pieces: &[Piece],
    nodes: NodeSet,
    values: &[f64; LOCAL_NODES],
    sides: &[[bool; 2]; 3],
    offset: f64,
) -> Result<(), Doubt> {
    let mut doubt = Ok(());
    let rounding = ROUNDING + ROUNDING / f64::EPSILON * offset;
    let on_boundary = sides.iter().flatten().any(|s| *s);
    for_tetrahedra(cell, nodes, |corners| {
        if doubt == Err(Doubt::Inside) {
            return;
        }
        let linear = interpolation(corners, values);
        let gradient = linear.slope;
        let holds = |on: Side| {
            let Some(part) = Part::of(corners, on) else { return true };
            pieces.iter().all(|piece| {
                let Some(region) = piece.region(&part) else { return true };
                piece.has_one_sign(&linear, &region, rounding)
                    || piece.is_rising(&gradient, on, &region, rounding)
            })
        };
        if !holds(INSIDE) {
            doubt = Err(Doubt::Inside);
        } else if on_boundary && !sides_of(sides).all(holds) {
            doubt = Err(Doubt::OnSide);
        }
    });
    doubt
}

/// For each axis, the local coordinate that is fixed: 0 on the lower, 2 on the upper side of the leaf.
type Side = [Option<u32>; 3];

const INSIDE: Side = [None; 3];

/// The faces, edges and corners of the box that a leaf touches.
fn sides_of(sides: &[[bool; 2]; 3]) -> impl Iterator<Item = Side> {
    let choices =
        sides.map(|[lower, upper]| [Some(None), lower.then_some(Some(0)), upper.then_some(Some(2))]);
    let [x, y, z] = choices.map(|c| c.into_iter().flatten());
    let all = x.flat_map(move |x| {
        let z = z.clone();
        y.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z]))
    });
    all.filter(|on| *on != INSIDE)
}

/// A linear function and a bound on the rest.
#[derive(Clone, Copy)]
struct Linear {
    center: f64,
    slope: [f64; 3],
    error: f64,
}

/// Part of a leaf with bounds that hold there.
pub(super) struct Piece {
    /// In coordinates of the leaf: its centre, and half its edge.
    center: [f64; 3],
    half: f64,
    bounds: Bounds,
}

/// The part of a tetrahedron on a side of the leaf.
struct Part {
    /// Its corners, and how many there are.
    corners: [[f64; 3]; 4],
    count: usize,
    /// The box around them.
    low: [f64; 3],
    high: [f64; 3],
}

impl Part {
    /// None where no corner is on the side.
    fn of(nodes: [usize; 4], on: Side) -> Option<Self> {
        let none = [f64::INFINITY; 3];
        let mut part = Self { corners: [[0.0; 3]; 4], count: 0, low: none, high: none.map(|x: f64| -x) };
        for node in nodes {
            if on != INSIDE && !(0..3).all(|a| on[a].is_none_or(|s| local(node)[a] == s)) {
                continue;
            }
            let corner = place(node);
            part.corners[part.count] = corner;
            part.count += 1;
            part.low = [0, 1, 2].map(|a| part.low[a].min(corner[a]));
            part.high = [0, 1, 2].map(|a| part.high[a].max(corner[a]));
        }
        (part.count > 0).then_some(part)
    }

    fn corners(&self) -> &[[f64; 3]] {
        &self.corners[..self.count]
    }
}

/// Where a linear function is looked at, in coordinates of the piece: the hull of points, or a box with centre and half edges.
enum Region<'a> {
    Hull(&'a [[f64; 3]]),
    Box([f64; 3], [f64; 3]),
}

impl Linear {
    /// Smallest and largest value.
    fn range(&self, region: &Region<'_>) -> [f64; 2] {
        let at = |p: &[f64; 3]| self.center + (0..3).map(|i| self.slope[i] * p[i]).sum::<f64>();
        let [low, high] = match region {
            Region::Hull(points) => points
                .iter()
                .map(at)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]),
            Region::Box(center, half) => {
                let spread: f64 = (0..3).map(|i| self.slope[i].abs() * half[i]).sum();
                [at(center) - spread, at(center) + spread]
            }
        };
        [low - self.error, high + self.error]
    }

    fn size(&self) -> f64 {
        self.center.abs() + self.slope.iter().map(|s| s.abs()).sum::<f64>() + self.error
    }
}

impl From<&Affine> for Linear {
    fn from(form: &Affine) -> Self {
        Self { center: form.center, slope: form.slope, error: form.error }
    }
}

impl Piece {
    /// The whole leaf.
    pub(super) fn whole(bounds: &Bounds) -> Self {
        Self { center: [0.0; 3], half: 1.0, bounds: *bounds }
    }

    /// A child, by its number; derivatives of its bounds are by its own half edges.
    pub(super) fn child(number: usize, bounds: &Bounds) -> Self {
        let center = [0, 1, 2].map(|a| if number >> a & 1 == 1 { 0.5 } else { -0.5 });
        let gradient = bounds.gradient.map(|form| form.scaled(2.0));
        Self { center, half: 0.5, bounds: Bounds { gradient, ..*bounds } }
    }

    /// Where the part of a tetrahedron and the piece overlap, or something larger; none if they do not.
    fn region<'a>(&self, part: &'a Part) -> Option<Region<'a>> {
        if self.half == 1.0 {
            return Some(Region::Hull(part.corners()));
        }
        let (mut center, mut half) = ([0.0; 3], [0.0; 3]);
        for a in 0..3 {
            let (low, high) = (part.low[a], part.high[a]);
            let [l, h] = [low.max(self.center[a] - self.half), high.min(self.center[a] + self.half)];
            // Where the tetrahedron extends along the axis, a common plane is covered by the next piece as well.
            if l > h || (l == h && low < high) {
                return None;
            }
            center[a] = (0.5 * (l + h) - self.center[a]) / self.half;
            half[a] = 0.5 * (h - l) / self.half;
        }
        Some(Region::Box(center, half))
    }

    /// Have f and g one and the same sign there? g is given by the coordinates of the leaf.
    fn has_one_sign(&self, g: &Linear, region: &Region<'_>, rounding: f64) -> bool {
        let f = Linear::from(&self.bounds.value);
        let at_center = g.center + (0..3).map(|i| g.slope[i] * self.center[i]).sum::<f64>();
        let g =
            Linear { center: at_center, slope: g.slope.map(|s| s * self.half), error: rounding * g.size() };
        let ([f_low, f_high], [g_low, g_high]) = (f.range(region), g.range(region));
        let slack = rounding * f.size();
        (f_low > slack && g_low > 0.0) || (f_high < -slack && g_high < 0.0)
    }

    /// Is g_T · ∇f positive there, by the components along the side?
    fn is_rising(&self, g: &[f64; 3], on: Side, region: &Region<'_>, rounding: f64) -> bool {
        let f = &self.bounds.gradient;
        let axes = || (0..3).filter(|a| on[*a].is_none());
        // Where components of ∇f change together, their changes are added before anything else.
        let product = Linear {
            center: axes().map(|i| g[i] * f[i].center).sum(),
            slope: [0, 1, 2].map(|j| axes().map(|i| g[i] * f[i].slope[j]).sum()),
            error: axes().map(|i| g[i].abs() * f[i].error).sum(),
        };
        let scale: f64 = axes().map(|i| f[i].center.abs() + f[i].radius()).sum();
        let size: f64 = g.iter().map(|x| x.abs()).sum();
        product.range(region)[0] > rounding * size * scale
    }
}

/// Has g the sign at a node that f has by its bounds?
pub(super) fn has_sign_of(f: &Affine, node: usize, value: f64) -> bool {
    let f = Linear::from(f);
    let [low, high] = f.range(&Region::Hull(&[place(node)]));
    let slack = ROUNDING * f.size();
    if value < 0.0 { high < -slack } else { low > slack }
}

/// The linear function of u with the given values at the corners of a tetrahedron.
fn interpolation(corners: [usize; 4], values: &[f64; LOCAL_NODES]) -> Linear {
    let [o, a, b, c] = corners.map(|n| Vec3::from(place(n)));
    let [fo, fa, fb, fc] = corners.map(|n| values[n]);
    let (a, b, c) = (a - o, b - o, c - o);
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    let gradient = ((fa - fo) * bc + (fb - fo) * ca + (fc - fo) * ab) / a.dot(&bc);
    Linear { center: fo - gradient.dot(&o), slope: gradient.into(), error: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Aabb, Interval, Point3};

    fn cell() -> Cell {
        Cell { corner: [0; 3], level: 3 }
    }

    fn sampled(f: impl Fn([f64; 3]) -> f64) -> [f64; LOCAL_NODES] {
        std::array::from_fn(|n| f(place(n)))
    }

    const AWAY: [[bool; 2]; 3] = [[false; 2]; 3];

    #[test]
    fn gradients_of_linear_functions_are_exact() {
        let values = sampled(|[x, y, z]| 0.3 + 2.0 * x - 3.0 * y + 0.5 * z);
        for set in [
            NodeSet::CORNERS,
            NodeSet::PLAIN,
            NodeSet::beside_finer(|n| n == 1),
            NodeSet::beside_finer(|n| n % 4 == 1),
        ] {
            for_tetrahedra(&cell(), set, |t| {
                let Linear { center, slope: g, .. } = interpolation(t, &values);
                assert!((0..3).all(|i| (g[i] - [2.0, -3.0, 0.5][i]).abs() < 1e-14), "{g:?}");
                assert!((center - 0.3).abs() < 1e-14);
            });
        }
    }

    #[test]
    fn a_plane_is_certain_and_a_saddle_is_not() {
        let one = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0));
        let [x, y, z] = [0, 1, 2].map(|axis| Affine::coordinate(&one, axis));
        let constant = |c: f64| Affine::from(Interval::point(c));
        let plane = Bounds { value: x + z.scaled(0.2), gradient: [1.0, 0.0, 0.2].map(constant) };
        let values = sampled(|[x, _, z]| x + 0.2 * z);
        let check = |bounds: &Bounds, values: &[f64; LOCAL_NODES], sides: &[[bool; 2]; 3]| {
            check(&cell(), &[Piece::whole(bounds)], NodeSet::PLAIN, values, sides, 1e-15)
        };
        assert_eq!(check(&plane, &values, &AWAY), Ok(()));
        let saddle = Bounds { value: x * y, gradient: [y, x, constant(0.0)] };
        assert_eq!(check(&saddle, &sampled(|[x, y, _]| x * y), &AWAY), Err(Doubt::Inside));
        // With the true values but a gradient of the wrong sign, nothing may pass.
        let wrong = Bounds { value: plane.value, gradient: [-1.0, 0.0, -0.2].map(constant) };
        assert_eq!(check(&wrong, &values, &AWAY), Err(Doubt::Inside));
        // Along the side z = −1 the function z + x²/4 hardly changes.
        let bowl = Bounds {
            value: z + x.square().scaled(0.25),
            gradient: [x.scaled(0.5), constant(0.0), constant(1.0)],
        };
        let values = sampled(|[x, _, z]| z + 0.25 * x * x);
        assert_eq!(check(&bowl, &values, &AWAY), Ok(()));
        let lowest = [[false; 2], [false; 2], [true, false]];
        assert_eq!(check(&bowl, &values, &lowest), Ok(()), "the surface is inside");
        let lower = Bounds { value: bowl.value + constant(0.9), ..bowl };
        assert_eq!(check(&lower, &values.map(|v| v + 0.9), &lowest), Err(Doubt::OnSide));
    }
}
