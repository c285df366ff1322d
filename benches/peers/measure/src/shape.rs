//! Results of peers as they are handed over in files: triangles, or Bézier triangles of degree 7.
//!
//! A file is a word of eight bytes, `mesh....` or `nets....`, two `u64` counts a and b, and the numbers, little-endian:
//! for a mesh 3a `f64` coordinates and 3b `u32` corners; for nets a patches of 36 control points in `f64` (b is 36), in the
//! order of falling i, then falling j, where the first corner is b_700 and the second b_070.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Degree of the patches.
pub const DEGREE: usize = 7;
/// Control points of a patch.
pub const NET: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// A surface to measure.
pub enum Shape {
    /// Flat triangles.
    Mesh {
        /// Coordinates of vertices.
        points: Vec<[f64; 3]>,
        /// Corners.
        triangles: Vec<[u32; 3]>,
    },
    /// Patches.
    Nets(Vec<[[f64; 3]; NET]>),
}

fn words<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [u8; N]> {
    bytes.chunks_exact(N).map(|chunk| std::array::from_fn(|i| chunk[i]))
}

fn points(bytes: &[u8]) -> Vec<[f64; 3]> {
    let numbers: Vec<f64> = words(bytes).map(f64::from_le_bytes).collect();
    numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
}

impl Shape {
    /// Reads a file.
    pub fn read(path: &str) -> io::Result<Self> {
        let bytes = std::fs::read(path)?;
        let bad = || io::Error::new(io::ErrorKind::InvalidData, "no mesh or nets");
        let (head, body) = bytes.split_at_checked(24).ok_or_else(bad)?;
        let counts: Vec<usize> = words(&head[8..]).map(|w| u64::from_le_bytes(w) as usize).collect();
        match &head[..8] {
            b"mesh...." => {
                let (first, second) = body.split_at_checked(24 * counts[0]).ok_or_else(bad)?;
                let corners: Vec<u32> = words(second).map(u32::from_le_bytes).collect();
                let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
                Ok(Self::Mesh { points: points(first), triangles })
            }
            b"nets...." => {
                let all = points(body);
                Ok(Self::Nets(all.chunks_exact(NET).map(|net| std::array::from_fn(|i| net[i])).collect()))
            }
            _ => Err(bad()),
        }
    }

    /// Triangles or patches.
    pub fn len(&self) -> usize {
        match self {
            Self::Mesh { triangles, .. } => triangles.len(),
            Self::Nets(nets) => nets.len(),
        }
    }

    /// Is there nothing?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Vertices − edges + faces. Corners of patches are one vertex if they agree bit for bit.
    pub fn euler_number(&self) -> i64 {
        match self {
            Self::Mesh { triangles, .. } => euler_number(triangles),
            Self::Nets(nets) => {
                let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
                let corner_places = [0, NET - 1 - DEGREE, NET - 1];
                let triangles: Vec<[u32; 3]> = nets
                    .iter()
                    .map(|net| {
                        corner_places.map(|k| {
                            let next = numbers.len() as u32;
                            *numbers.entry(net[k].map(|x| (x + 0.0).to_bits())).or_insert(next)
                        })
                    })
                    .collect();
                euler_number(&triangles)
            }
        }
    }
}

/// Writes a mesh, for programs that make one.
pub fn write_mesh(
    path: &str,
    points: impl ExactSizeIterator<Item = [f64; 3]>,
    triangles: impl ExactSizeIterator<Item = [u32; 3]>,
) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(b"mesh....")?;
    for count in [points.len(), triangles.len()] {
        out.write_all(&(count as u64).to_le_bytes())?;
    }
    for x in points.flatten() {
        out.write_all(&x.to_le_bytes())?;
    }
    for k in triangles.flatten() {
        out.write_all(&k.to_le_bytes())?;
    }
    out.flush()
}

fn euler_number(triangles: &[[u32; 3]]) -> i64 {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let edge = |t: &[u32; 3], k: usize| {
        let [a, b] = [u64::from(t[k]), u64::from(t[(k + 1) % 3])];
        a.min(b) << 32 | a.max(b)
    };
    let mut edges: Vec<u64> = triangles.iter().flat_map(|t| [edge(t, 0), edge(t, 1), edge(t, 2)]).collect();
    edges.sort_unstable();
    edges.dedup();
    vertices.len() as i64 - edges.len() as i64 + triangles.len() as i64
}
