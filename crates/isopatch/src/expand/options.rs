//! How a surface is expanded.

/// Which front is pushed outward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Approach {
    /// Algorithm 1: a triangle over an edge.
    Edge,
    /// Algorithm 2: a fan of triangles around a vertex.
    Vertex,
}

/// Options of [`expand`](super::expand). Lengths are relative to the diagonal of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpandOptions {
    /// Default: by vertices, which the paper finds better at singular points.
    pub approach: Approach,
    /// Degree k of the power series, 1 to 6; default 2.
    pub degree: usize,
    /// ε: distance between the series and the surface over the disc of a vertex; default 0.01.
    pub epsilon: f64,
    /// Longest step; default 0.12.
    pub longest: f64,
    /// How far the normal may turn over a step, in radians: the series bounds the error of φ_k only, not that of a chord.
    /// Default 0.7.
    pub turn: f64,
    /// Length of the segments into which singular curves are cut; default 0.06.
    pub segment: f64,
    /// Most triangles; default 200,000.
    pub most_triangles: usize,
}

impl Default for ExpandOptions {
    fn default() -> Self {
        Self {
            approach: Approach::Vertex,
            degree: 2,
            epsilon: 0.01,
            longest: 0.12,
            turn: 0.7,
            segment: 0.06,
            most_triangles: 200_000,
        }
    }
}
