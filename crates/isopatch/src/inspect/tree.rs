//! A bounding volume hierarchy over patches, for searches of the nearest one.

use crate::geom::{Aabb, Point3, Vec3};
use crate::surface::{PatchForm, PatchId, Surface};
use std::borrow::Cow;

/// Most patches in a leaf.
const LEAF: usize = 4;

/// A patch in the tree: the box of its net, and slabs across and around its corner triangle that hold the net.
///
/// Neighbours in a smooth surface have boxes that overlap a lot; the slabs tell them apart.
struct Prism {
    patch: PatchId,
    bounds: Aabb,
    /// Unit directions with the largest value of direction · control point.
    slabs: [(Vec3, f64); 5],
}

impl Prism {
    fn new(surface: &dyn Surface, patch: PatchId) -> Self {
        let hull = hull_points(surface, patch);
        let [a, b, c] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]].map(|uv| surface.sample(patch, uv).point);
        let normal = unit((b - a).cross(&(c - a)));
        let outward = |along: Vec3| unit(along.cross(&normal));
        let slabs = [normal, -normal, outward(b - a), outward(c - b), outward(a - c)]
            .map(|d| (d, hull.iter().map(|b| d.dot(b)).fold(f64::NEG_INFINITY, f64::max)));
        Self { patch, bounds: Aabb::around(hull.iter()), slabs }
    }

    /// Square of a lower bound of the distance from `p` to the patch.
    fn distance_squared(&self, p: &Point3) -> f64 {
        let outside_slabs = self.slabs.iter().map(|(d, support)| d.dot(p) - support).fold(0.0, f64::max);
        box_distance_squared(&self.bounds, p).max(outside_slabs * outside_slabs)
    }
}

/// Points in whose convex hull a patch lies: its control points. None for a patch without control points.
fn hull_points(surface: &dyn Surface, patch: PatchId) -> Cow<'_, [Point3]> {
    match surface.form(patch) {
        PatchForm::BezierTriangle { net, .. } => Cow::Borrowed(net),
        PatchForm::RationalTriangle { weighted, .. } => {
            Cow::Owned(weighted.iter().filter(|p| p.w > 0.0).map(|p| p.xyz() / p.w).collect())
        }
        PatchForm::APatch => Cow::Borrowed(&[]),
    }
}

/// `v` with length 1, or zero, which makes a slab that holds everything.
fn unit(v: Vec3) -> Vec3 {
    v.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

fn box_distance_squared(b: &Aabb, p: &Point3) -> f64 {
    let outside = |a: usize| (b.min[a] - p[a]).max(p[a] - b.max[a]).max(0.0);
    outside(0).powi(2) + outside(1).powi(2) + outside(2).powi(2)
}

/// The patches of a surface in a binary tree of boxes.
pub(super) struct PatchTree {
    /// In the order of the leaves.
    prisms: Vec<Prism>,
    root: Option<Node>,
}

struct Node {
    bounds: Aabb,
    content: Content,
}

enum Content {
    /// Range of prisms.
    Leaf(usize, usize),
    Inner(Box<[Node; 2]>),
}

impl PatchTree {
    /// Splits at the median of the box centres along the longest axis. Patches with a control point that is not
    /// finite are left out.
    pub fn new(surface: &dyn Surface) -> Self {
        let finite = |p: &PatchId| {
            let hull = hull_points(surface, *p);
            !hull.is_empty() && hull.iter().all(|b| b.iter().all(|x| x.is_finite()))
        };
        let mut prisms: Vec<_> = surface.patches().filter(finite).map(|p| Prism::new(surface, p)).collect();
        let root = if prisms.is_empty() { None } else { Some(Node::new(&mut prisms, 0)) };
        Self { prisms, root }
    }

    /// Calls `visit` for patches whose lower bound of the squared distance to `p` is below the limit, nearer boxes
    /// first. `visit` takes the patch and the limit and returns the new limit.
    pub fn search(&self, p: &Point3, limit: f64, mut visit: impl FnMut(PatchId, f64) -> f64) {
        if let Some(root) = &self.root {
            self.descend(root, p, limit, &mut visit);
        }
    }

    fn descend(
        &self,
        node: &Node,
        p: &Point3,
        mut limit: f64,
        visit: &mut impl FnMut(PatchId, f64) -> f64,
    ) -> f64 {
        match &node.content {
            Content::Leaf(start, end) => {
                for prism in &self.prisms[*start..*end] {
                    if prism.distance_squared(p) < limit {
                        limit = visit(prism.patch, limit);
                    }
                }
            }
            Content::Inner(children) => {
                let distance = children.each_ref().map(|c| box_distance_squared(&c.bounds, p));
                let order = if distance[1] < distance[0] { [1, 0] } else { [0, 1] };
                for child in order {
                    if distance[child] < limit {
                        limit = self.descend(&children[child], p, limit, visit);
                    }
                }
            }
        }
        limit
    }
}

impl Node {
    /// The tree over `prisms`, which it sorts; the first of them is number `first` of all.
    fn new(prisms: &mut [Prism], first: usize) -> Self {
        let bounds = prisms.iter().fold(Aabb::EMPTY, |b, p| b.union(&p.bounds));
        if prisms.len() <= LEAF {
            return Self { bounds, content: Content::Leaf(first, first + prisms.len()) };
        }
        let axis = bounds.size().imax();
        let key = |p: &Prism| (p.bounds.min[axis] + p.bounds.max[axis], p.patch);
        prisms.sort_unstable_by(|a, b| key(a).0.total_cmp(&key(b).0).then(key(a).1.cmp(&key(b).1)));
        let (left, right) = prisms.split_at_mut(prisms.len() / 2);
        let middle = first + left.len();
        Self { bounds, content: Content::Inner(Box::new([Self::new(left, first), Self::new(right, middle)])) }
    }
}
