//! Has the surface of a piecewise linear function the topology of f = 0?
//!
//! The leaves of an octree that may hold zeros of f are cut into tetrahedra (see [`super::tetrahedra`]); g is the
//! continuous function that is linear on each of them, with given values at the nodes, and g_T its gradient on T. On all
//! other cells interval bounds exclude zeros of f.
//!
//! **Claim.** {g = 0} is isotopic to {f = 0} in the box, if
//! 1. for every tetrahedron T of every leaf C: g_T · A∇f(x) > 0 for all x ∈ C, with A = diag(h₁², h₂², h₃²), h the edges
//!    of a leaf; or f and g have one and the same sign on T;
//! 2. for every face, edge or corner S of the box that T meets: the same with the components along S alone, or f and g
//!    have one and the same sign on T ∩ S;
//! 3. where a leaf borders on a cell without zeros, g has at the common nodes the sign that f has there.
//!
//! **Proof.** Let F_t = (1 − t) g + t f, 0 ≤ t ≤ 1, and v = A∇f. At a zero p of F_t, f(p) and g(p) do not both have the
//! same sign, so by 1 every T ∋ p has g_T · v(x) > 0 for x near p, and ∇f · v > 0 follows (v ≠ 0). Hence all of Clarke's
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
//! g_T is computed in the coordinates u ∈ [−1, 1]³ of the leaf, where A is the identity.

use super::octree::Cell;
use super::tetrahedra::{CENTER, LOCAL_NODES, NodeSet, for_triangles, local};
use crate::geom::Affine;

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

/// Coordinates u of a local node.
pub(super) fn place(node: usize) -> [f64; 3] {
    local(node).map(|c| f64::from(c) - 1.0)
}

/// Bounds the relative rounding of the dozen operations behind a product of gradients.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Checks conditions 1 and 2 for a leaf: `values` of g at its local nodes (those in `nodes` are read), `sides` which sides
/// of the box it touches, `offset` how far the computed nodes may be from the ideal ones, in units of u.
pub(super) fn check(
    cell: &Cell,
    bounds: &Bounds,
    nodes: NodeSet,
    values: &[f64; LOCAL_NODES],
    sides: &[[bool; 2]; 3],
    offset: f64,
) -> Result<(), Doubt> {
    let mut doubt = Ok(());
    let rounding = ROUNDING + ROUNDING / f64::EPSILON * offset;
    let on_boundary = sides.iter().flatten().any(|s| *s);
    for_triangles(cell, nodes, |[a, b, c]| {
        let corners = [CENTER, a, b, c];
        if doubt == Err(Doubt::Inside) || has_one_sign(&bounds.value, &corners, values) {
            return;
        }
        let gradient = linear_gradient([a, b, c], values);
        if !is_positive(&gradient, &bounds.gradient, [true; 3], rounding) {
            doubt = Err(Doubt::Inside);
        } else if on_boundary && !check_sides(bounds, &corners, values, &gradient, sides, rounding) {
            doubt = Err(Doubt::OnSide);
        }
    });
    doubt
}

/// Condition 2 for one tetrahedron.
fn check_sides(
    bounds: &Bounds,
    corners: &[usize; 4],
    values: &[f64; LOCAL_NODES],
    gradient: &[f64; 3],
    sides: &[[bool; 2]; 3],
    rounding: f64,
) -> bool {
    // For each axis: not on a side, on the lower or on the upper one.
    let choices =
        sides.map(|[lower, upper]| [Some(None), lower.then_some(Some(0)), upper.then_some(Some(2))]);
    let mut passes = true;
    for x in choices[0].into_iter().flatten() {
        for y in choices[1].into_iter().flatten() {
            for z in choices[2].into_iter().flatten() {
                let on = [x, y, z];
                let lies = |n: &&usize| (0..3).all(|a| on[a].is_none_or(|s| local(**n)[a] == s));
                let common: Vec<usize> = corners.iter().filter(lies).copied().collect();
                if on == [None; 3] || common.is_empty() || has_one_sign(&bounds.value, &common, values) {
                    continue;
                }
                let restricted = bounds.gradient.map(|form| restrict(form, on));
                passes &= is_positive(gradient, &restricted, on.map(|s| s.is_none()), rounding);
            }
        }
    }
    passes
}

/// The linear function on the part of the leaf where some coordinates are fixed to those of local nodes.
fn restrict(mut form: Affine, on: [Option<u32>; 3]) -> Affine {
    for axis in 0..3 {
        if let Some(side) = on[axis] {
            form.center += form.slope[axis] * (f64::from(side) - 1.0);
            form.slope[axis] = 0.0;
        }
    }
    form
}

/// Have f, by its bounds, and g one and the same sign on the hull of these nodes?
pub(super) fn has_one_sign(f: &Affine, nodes: &[usize], values: &[f64; LOCAL_NODES]) -> bool {
    let size = f.center.abs() + f.slope.iter().map(|s| s.abs()).sum::<f64>();
    let slack = f.error + ROUNDING * size;
    let linear = |n: usize| {
        let u = place(n);
        f.center + f.slope[0] * u[0] + f.slope[1] * u[1] + f.slope[2] * u[2]
    };
    nodes.iter().all(|n| values[*n] < 0.0 && linear(*n) < -slack)
        || nodes.iter().all(|n| values[*n] >= 0.0 && linear(*n) > slack)
}

/// Gradient by u of the linear function with the given values at the centre and at three nodes of one side.
fn linear_gradient(triangle: [usize; 3], values: &[f64; LOCAL_NODES]) -> [f64; 3] {
    let [p, q, r] = triangle.map(place);
    let [fp, fq, fr] = triangle.map(|n| values[n]);
    // The side is where one coordinate is ±1 for all three.
    let axis = (0..3).find(|a| p[*a] == q[*a] && q[*a] == r[*a]).unwrap_or(0);
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let (qb, qc, rb, rc) = (q[b] - p[b], q[c] - p[c], r[b] - p[b], r[c] - p[c]);
    let determinant = qb * rc - qc * rb;
    let (dq, dr) = (fq - fp, fr - fp);
    let mut gradient = [0.0; 3];
    gradient[b] = (dq * rc - dr * qc) / determinant;
    gradient[c] = (qb * dr - rb * dq) / determinant;
    gradient[axis] = p[axis] * (fp - values[CENTER] - gradient[b] * p[b] - gradient[c] * p[c]);
    gradient
}

/// Is g_T · ∇f positive over the leaf, by the components along the axes in `along`?
fn is_positive(g: &[f64; 3], f: &[Affine; 3], along: [bool; 3], rounding: f64) -> bool {
    let axes = || (0..3).filter(|a| along[*a]);
    let center: f64 = axes().map(|i| g[i] * f[i].center).sum();
    // Where components of ∇f change together, their changes are added before their size is taken.
    let spread: f64 = (0..3).map(|j| axes().map(|i| g[i] * f[i].slope[j]).sum::<f64>().abs()).sum();
    let error: f64 = axes().map(|i| g[i].abs() * f[i].error).sum();
    let size: f64 = g.iter().map(|x| x.abs()).sum();
    let scale: f64 = axes().map(|i| f[i].center.abs() + f[i].radius()).sum();
    center > spread + error + rounding * size * scale
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

    const INSIDE: [[bool; 2]; 3] = [[false; 2]; 3];

    #[test]
    fn gradients_of_linear_functions_are_exact() {
        let values = sampled(|[x, y, z]| 0.3 + 2.0 * x - 3.0 * y + 0.5 * z);
        for set in [NodeSet::PLAIN, NodeSet::beside_finer(|n| n == 1), NodeSet::beside_finer(|n| n % 4 == 1)]
        {
            let mut count = 0;
            for_triangles(&cell(), set, |t| {
                count += 1;
                let g = linear_gradient(t, &values);
                assert!((0..3).all(|i| (g[i] - [2.0, -3.0, 0.5][i]).abs() < 1e-14), "{g:?}");
            });
            assert!(count >= 12);
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
            check(&cell(), bounds, NodeSet::PLAIN, values, sides, 1e-15)
        };
        assert_eq!(check(&plane, &values, &INSIDE), Ok(()));
        let saddle = Bounds { value: x * y, gradient: [y, x, constant(0.0)] };
        assert_eq!(check(&saddle, &sampled(|[x, y, _]| x * y), &INSIDE), Err(Doubt::Inside));
        // With the true values but a gradient of the wrong sign, nothing may pass.
        let wrong = Bounds { value: plane.value, gradient: [-1.0, 0.0, -0.2].map(constant) };
        assert_eq!(check(&wrong, &values, &INSIDE), Err(Doubt::Inside));
        // Along the side z = −1 the function z + x²/4 hardly changes.
        let bowl = Bounds {
            value: z + x.square().scaled(0.25),
            gradient: [x.scaled(0.5), constant(0.0), constant(1.0)],
        };
        let values = sampled(|[x, _, z]| z + 0.25 * x * x);
        assert_eq!(check(&bowl, &values, &INSIDE), Ok(()));
        let lowest = [[false; 2], [false; 2], [true, false]];
        assert_eq!(check(&bowl, &values, &lowest), Ok(()), "the surface is inside");
        let lower = Bounds { value: bowl.value + constant(0.9), ..bowl };
        assert_eq!(check(&lower, &values.map(|v| v + 0.9), &lowest), Err(Doubt::OnSide));
    }
}
