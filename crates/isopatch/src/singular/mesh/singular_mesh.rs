use crate::base::BoxSides;
use crate::geom::{Point3, Vec3};
use std::collections::BTreeMap;

/// What a vertex of a [`SingularMesh`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum VertexKind {
    /// ∇f does not vanish there; one sheet, one normal.
    Regular,
    /// In the inside of a singular arc, by its index into [`SingularSet::curves`](crate::singular::SingularSet::curves).
    OnCurve(u32),
    /// Where singular arcs begin, by its index into [`SingularSet::special`](crate::singular::SingularSet::special).
    Special(u32),
    /// An isolated singular point, by its index into [`SingularSet::points`](crate::singular::SingularSet::points).
    Isolated(u32),
}

impl VertexKind {
    /// Does ∇f vanish there?
    pub fn is_singular(self) -> bool {
        self != Self::Regular
    }
}

/// What an edge means for the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeTag {
    /// Two triangles of one smooth sheet meet there.
    Smooth,
    /// It lies on a singular arc.
    Singular,
    /// One triangle: the box cuts the surface there.
    Boundary,
}

/// An edge that is not smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeatureEdge {
    /// Its ends, the smaller number first.
    pub vertices: [u32; 2],
    /// Never [`EdgeTag::Smooth`].
    pub tag: EdgeTag,
    /// How many triangles meet there: 4 where two sheets cross.
    pub valence: usize,
}

/// A part of the surface of dimension 0 or 1.
#[derive(Clone, Debug, PartialEq)]
pub enum LowerPart {
    /// An isolated point.
    Point(Point3),
    /// A curve without sheets, by points in order along it.
    Stick(Vec<Point3>),
}

/// A triangulation of a surface with singularities: singular points are vertices and singular curves are edges of it.
///
/// Triangles are counter-clockwise seen from where f > 0, where ∇f points. That orients every sheet between singular edges;
/// across a crossing the orientations alternate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SingularMesh {
    /// Vertices, on the surface.
    pub positions: Vec<Point3>,
    /// What each vertex is.
    pub vertices: Vec<VertexKind>,
    /// The sides of the box in which each vertex lies, to the bit.
    pub sides: Vec<BoxSides>,
    /// Vertex numbers.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals at the three corners of each triangle: those of the sheet to which the triangle belongs. At a singular
    /// vertex it is the limit along the triangle.
    pub normals: Vec<[Vec3; 3]>,
    /// The edges on singular arcs, by their ends with the smaller number first, in lexicographic order.
    pub singular_edges: Vec<[u32; 2]>,
    /// Parts of lower dimension.
    pub lower: Vec<LowerPart>,
}

impl SingularMesh {
    /// The triangles at every edge, by its ends with the smaller number first.
    pub fn edges(&self) -> BTreeMap<[u32; 2], Vec<u32>> {
        let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (t, corners) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                edges.entry([a.min(b), a.max(b)]).or_default().push(t as u32);
            }
        }
        edges
    }

    /// What an edge with `valence` triangles is; its ends with the smaller number first.
    pub fn tag(&self, ends: [u32; 2], valence: usize) -> EdgeTag {
        match valence {
            _ if self.singular_edges.binary_search(&ends).is_ok() => EdgeTag::Singular,
            1 => EdgeTag::Boundary,
            2 => EdgeTag::Smooth,
            _ => EdgeTag::Singular,
        }
    }

    /// The edges that are not smooth, in lexicographic order.
    pub fn features(&self) -> Vec<FeatureEdge> {
        let edges = self.edges();
        let all = edges.iter().map(|(ends, t)| (*ends, self.tag(*ends, t.len()), t.len()));
        all.filter(|(_, tag, _)| *tag != EdgeTag::Smooth)
            .map(|(vertices, tag, valence)| FeatureEdge { vertices, tag, valence })
            .collect()
    }

    /// Vertices that belong to a triangle − edges + triangles: the Euler number of the part of dimension 2.
    pub fn euler_number(&self) -> i64 {
        let mut used = vec![false; self.positions.len()];
        self.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        let vertices = used.iter().filter(|used| **used).count();
        vertices as i64 - self.edges().len() as i64 + self.triangles.len() as i64
    }
}
