use super::singular_mesh::{EdgeTag, SingularMesh, VertexKind};
use crate::geom::{Point3, Vec3};

/// A smooth piece of a [`SingularMesh`], cut along its singular edges: an oriented manifold with boundary.
///
/// A vertex where several fans of triangles meet is there once for each fan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Vertices.
    pub positions: Vec<Point3>,
    /// The unit normal at each vertex; at a vertex of a singular arc the limit in this sheet. None where the limit depends on
    /// the direction, as at the apex of a cone.
    pub normals: Vec<Option<Vec3>>,
    /// The number of each vertex in the whole mesh.
    pub vertices: Vec<u32>,
    /// Vertex numbers of this sheet, counter-clockwise seen from where f > 0.
    pub triangles: Vec<[u32; 3]>,
    /// The number of each triangle in the whole mesh.
    pub faces: Vec<u32>,
}

/// Normals at a vertex that differ by more than this (cosine of 45°) have no common limit there.
const COMMON_NORMAL: f64 = 0.7;

/// The sheets of a mesh, in the order of their first triangles.
pub fn sheets(mesh: &SingularMesh) -> Vec<Sheet> {
    let count = mesh.triangles.len();
    let mut faces = Sets::new(count);
    let mut corners = Sets::new(3 * count);
    for (ends, around) in mesh.edges() {
        if let [a, b] = around[..]
            && mesh.tag(ends, 2) == EdgeTag::Smooth
        {
            faces.join(a as usize, b as usize);
            for v in ends {
                corners.join(corner(mesh, a, v), corner(mesh, b, v));
            }
        }
    }
    let mut number = vec![None; count];
    let mut of_corner = vec![None; 3 * count];
    let mut found: Vec<Sheet> = Vec::new();
    for t in 0..count {
        let root = faces.root(t);
        let s = *number[root].get_or_insert_with(|| {
            found.push(Sheet::default());
            found.len() - 1
        });
        let sheet = &mut found[s];
        let triangle = [0, 1, 2].map(|k| {
            *of_corner[corners.root(3 * t + k)].get_or_insert_with(|| {
                let v = mesh.triangles[t][k];
                sheet.vertices.push(v);
                sheet.positions.push(mesh.positions[v as usize]);
                sheet.vertices.len() as u32 - 1
            })
        });
        sheet.triangles.push(triangle);
        sheet.faces.push(t as u32);
    }
    found.iter_mut().for_each(|sheet| sheet.normals = normals(mesh, sheet));
    found
}

/// The mean of the normals of the corners at each vertex.
fn normals(mesh: &SingularMesh, sheet: &Sheet) -> Vec<Option<Vec3>> {
    let mut sums = vec![Vec3::zeros(); sheet.vertices.len()];
    let corners = || {
        let triangles = sheet.triangles.iter().zip(&sheet.faces);
        triangles.flat_map(|(t, f)| (0..3).map(|k| (t[k] as usize, mesh.normals[*f as usize][k])))
    };
    corners().for_each(|(v, n)| sums[v] += n);
    let mut common: Vec<Option<Vec3>> = sums.iter().map(|sum| sum.try_normalize(f64::EPSILON)).collect();
    for (v, n) in corners() {
        let is_regular = mesh.vertices[sheet.vertices[v] as usize] == VertexKind::Regular;
        if !is_regular && common[v].is_some_and(|mean| mean.dot(&n) < COMMON_NORMAL) {
            common[v] = None;
        }
    }
    common
}

/// The number of the corner of triangle `t` at vertex `v`.
fn corner(mesh: &SingularMesh, t: u32, v: u32) -> usize {
    let k = mesh.triangles[t as usize].iter().position(|w| *w == v);
    3 * t as usize + k.unwrap_or(0)
}

/// Disjoint sets of numbers.
pub(super) struct Sets(Vec<usize>);

impl Sets {
    pub(super) fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    pub(super) fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    /// The smaller root becomes the common one.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
