use crate::geom::{Point3, Vec3};

/// A side of the mesh, and of each of its faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Where the normals point; its apexes are the paper's u.
    Outer,
    /// The other one; its apexes are the paper's v.
    Inner,
}

impl Side {
    /// Both, the outer one first.
    pub const BOTH: [Self; 2] = [Self::Outer, Self::Inner];

    /// 1 or −1: the function times this is negative at the base and positive at the apex.
    pub fn sign(self) -> f64 {
        match self {
            Self::Outer => 1.0,
            Self::Inner => -1.0,
        }
    }

    /// As an index into a pair.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// How the surface bends over an edge or a face (paper §3, definitions 3.1 and 3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Positive convex: the surface is on the outer side.
    Positive,
    /// Negative convex: the surface is on the inner side.
    Negative,
    /// Zero convex: the surface is the edge, or the face.
    Zero,
    /// Nonconvex: the surface goes through.
    Nonconvex,
}

impl Class {
    /// The class of an edge from (p_i − p_j)·n_i and (p_j − p_i)·n_j, as multiples of what counts as zero.
    pub fn of_edge(at_start: f64, at_end: f64) -> Self {
        let sign = |x: f64| if x.abs() <= 1.0 { 0 } else { x.signum() as i32 };
        match (sign(at_start), sign(at_end)) {
            (0, 0) => Self::Zero,
            (s, t) if s * t < 0 => Self::Nonconvex,
            (s, t) if s + t > 0 => Self::Positive,
            _ => Self::Negative,
        }
    }

    /// The class of a face from those of its edges.
    pub fn of_face(edges: [Self; 3]) -> Self {
        let any = |class| edges.contains(&class);
        match (any(Self::Positive), any(Self::Negative), any(Self::Nonconvex)) {
            (false, false, false) => Self::Zero,
            (true, false, false) => Self::Positive,
            (false, true, false) => Self::Negative,
            _ => Self::Nonconvex,
        }
    }

    /// Does the surface over it reach into this side?
    pub fn reaches(self, side: Side) -> bool {
        match self {
            Self::Positive => side == Side::Outer,
            Self::Negative => side == Side::Inner,
            Self::Zero => false,
            Self::Nonconvex => true,
        }
    }
}

/// What of (p_i − p_j)·n_i counts as zero, relative to |p_i − p_j| |n_i|: far above the rounding of the product, far below
/// any bend that can be seen.
const ZERO: f64 = 1e-12;

/// Roundings of the largest coordinate that an edge vector may be wrong by.
const COORDINATE_ROUNDINGS: f64 = 4.0;

/// Convexity of the edge from `p` to `q` at `p`, where the gradient is `n`, as a multiple of what counts as zero.
pub fn bend(p: &Point3, q: &Point3, n: &Vec3) -> f64 {
    let edge = p - q;
    let rounding = COORDINATE_ROUNDINGS * f64::EPSILON * (p.amax().max(q.amax()));
    edge.dot(n) / ((ZERO * edge.norm() + rounding) * n.norm())
}
