//! How the curve f = 0 in a rectangle connects its points on the boundary.
//!
//! The rectangle is halved until every part has at most two points on its boundary, which are then joined. The part around
//! a singular point becomes so small that the curve is a star there.

use crate::field::Field;
use crate::geom::Point3;

use super::roots::Isolator;

/// f in a plane where one coordinate is fixed.
pub(super) struct Plane<'a> {
    pub(super) field: &'a dyn Field,
    pub(super) isolator: &'a Isolator,
    /// The fixed coordinate and the two others, right-handed in the order second, third, first.
    pub(super) axes: [usize; 3],
    pub(super) height: f64,
}

/// A point of the curve on the side of a rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Its coordinate along the side.
    pub(super) at: f64,
    pub(super) node: Node,
    /// Does f rise there with that coordinate?
    pub(super) rises: bool,
}

/// What a part of the curve ends at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// A vertex of the mesh.
    Vertex(u32),
    /// A point inside the rectangle, of no further use.
    Local(usize),
}

/// The rectangle, and the points on its sides in ascending order: lower and upper side along u, then lower and upper along v.
#[derive(Clone, Debug)]
pub(super) struct Rectangle {
    pub(super) range: [[f64; 2]; 2],
    pub(super) sides: [Vec<Crossing>; 4],
}

/// A singular point in the rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pierce {
    pub(super) at: [f64; 2],
    pub(super) vertex: u32,
}

/// A part of the curve between two vertices, f > 0 on its left, with points between them where it turns.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) ends: [u32; 2],
    pub(super) between: Vec<[f64; 2]>,
}

/// Parts of the curve, f > 0 on their left, and whether there was something odd about it.
#[derive(Clone, Debug, Default)]
pub(super) struct Links {
    pub(super) links: Vec<Link>,
    /// Closed parts inside the rectangle, by points on them.
    pub(super) ovals: Vec<Vec<[f64; 2]>>,
    pub(super) doubtful: bool,
}

/// Halvings around a singular point: the rest is 64 times smaller than the rectangle.
const PIERCE_DEPTH: usize = 12;
/// Halvings until the curve is given up: parts of it are then nearer than rounding.
const MAX_DEPTH: usize = 64;
/// Where rectangles are divided; others are tried if a point is too near there.
const SPLITS: [f64; 5] = [0.4871, 0.5237, 0.4519, 0.5563, 0.4133];
/// Halvings where the curve turns: the rest is a thousand times smaller than the rectangle.
const TURN_DEPTH: usize = 20;
/// Cosine of the angle (45°) by which a part of the curve may turn.
const ONE_DIRECTION: f64 = 0.7;
/// The same between two points that are kept (25°).
const KEPT_TURN: f64 = 0.9;
/// A singular point is not this near to a division, as a share of the rectangle.
const CLEARANCE: f64 = 0.02;

impl Plane<'_> {
    fn point(&self, u: f64, v: f64) -> Point3 {
        let mut p = Point3::zeros();
        p[self.axes[0]] = self.height;
        p[self.axes[1]] = u;
        p[self.axes[2]] = v;
        p
    }

    fn value(&self, u: f64, v: f64) -> f64 {
        self.field.value(self.point(u, v))
    }

    /// Zeros on the line where coordinate `fixed` (0 is u) is `at`, with the values of f changing upwards or not.
    pub(super) fn on_line(&self, fixed: usize, at: f64, [lo, hi]: [f64; 2]) -> Vec<(f64, bool)> {
        let f = |t: f64| {
            let c = lo + t * (hi - lo);
            if fixed == 0 { self.value(at, c) } else { self.value(c, at) }
        };
        let mut rises = f(0.0) < 0.0;
        let roots = self.isolator.roots(&f);
        roots
            .into_iter()
            .map(|t| {
                let this = rises;
                rises = !rises;
                (lo + t * (hi - lo), this)
            })
            .collect()
    }

    /// The direction of ∇f in the plane.
    fn gradient(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let g = self.field.gradient(self.point(u, v)).1;
        let g = [g[self.axes[1]], g[self.axes[2]]];
        let norm = g[0].hypot(g[1]);
        if norm > 0.0 { g.map(|c| c / norm) } else { g }
    }

    /// The parts of the curve in the rectangle. It is halved at least `depth` times, to find closed parts; if that is not 0,
    /// the points between the ends of a part follow its turns.
    pub(super) fn links(&self, rectangle: Rectangle, pierce: Option<Pierce>, depth: usize) -> Links {
        let mut search = Search { plane: self, least: depth, links: Vec::new(), locals: Vec::new(), doubtful: false };
        search.visit(rectangle, pierce, 0);
        search.finish()
    }
}

/// Of the angle between two unit vectors.
fn cosine(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

struct Search<'a> {
    plane: &'a Plane<'a>,
    /// Least number of halvings.
    least: usize,
    links: Vec<[Node; 2]>,
    /// Where the local points are.
    locals: Vec<[f64; 2]>,
    doubtful: bool,
}

/// Does the curve with f > 0 on its left run into the rectangle there? `side` as in [`Rectangle::sides`].
fn enters(side: usize, rises: bool) -> bool {
    // Counter-clockwise around the rectangle, f changes from plus to minus there.
    match side {
        0 | 3 => !rises,
        _ => rises,
    }
}

impl Search<'_> {
    fn visit(&mut self, rectangle: Rectangle, pierce: Option<Pierce>, depth: usize) {
        let turns = self.least > 0 && depth < TURN_DEPTH && self.turns(&rectangle);
        let all = || {
            let sides = rectangle.sides.iter().enumerate();
            sides.flat_map(|(side, on)| on.iter().map(move |c| (c.node, enters(side, c.rises))))
        };
        let count = all().count();
        if let Some(pierce) = pierce
            && depth >= PIERCE_DEPTH
        {
            let center = Node::Vertex(pierce.vertex);
            let star = all().map(|(node, enters)| if enters { [node, center] } else { [center, node] });
            self.links.extend(star);
            return;
        }
        let is_simple = count == 0 || count == 2 && !turns;
        if pierce.is_none() && (is_simple && depth >= self.least || depth >= MAX_DEPTH) {
            let (from, to): (Vec<_>, Vec<_>) = all().partition(|(_, enters)| *enters);
            self.doubtful |= from.len() != to.len() || count > 2;
            self.links.extend(from.into_iter().zip(to).map(|((a, _), (b, _))| [a, b]));
            return;
        }
        self.split(&rectangle, pierce, depth);
    }

    /// Has the curve more than one direction between two points on the boundary?
    fn turns(&self, rectangle: &Rectangle) -> bool {
        let [[u0, u1], [v0, v1]] = rectangle.range;
        let place = |(side, c): (usize, &Crossing)| match side {
            0 => [c.at, v0],
            1 => [c.at, v1],
            2 => [u0, c.at],
            _ => [u1, c.at],
        };
        let sides = rectangle.sides.iter().enumerate();
        let ends: Vec<[f64; 2]> = sides.flat_map(|(side, on)| on.iter().map(move |c| place((side, c)))).collect();
        let [a, b] = ends[..] else { return false };
        cosine(self.plane.gradient(a), self.plane.gradient(b)) < ONE_DIRECTION
    }

    fn split(&mut self, rectangle: &Rectangle, pierce: Option<Pierce>, depth: usize) {
        let [[u0, u1], [v0, v1]] = rectangle.range;
        // The first halving decides by the lengths, later ones alternate.
        let across = usize::from(v1 - v0 > u1 - u0);
        let [lo, hi] = rectangle.range[across];
        for ratio in SPLITS {
            let at = lo + ratio * (hi - lo);
            let too_near = pierce.is_some_and(|p| (p.at[across] - at).abs() < CLEARANCE * (hi - lo));
            if too_near && ratio != SPLITS[SPLITS.len() - 1] {
                continue;
            }
            let cut = self.plane.on_line(across, at, rectangle.range[1 - across]);
            let parts = self.parts(rectangle, across, at, &cut);
            let is_even = |r: &Rectangle| r.sides.iter().map(Vec::len).sum::<usize>() % 2 == 0;
            if parts.iter().all(is_even) {
                let place = |(c, _): &(f64, bool)| if across == 0 { [at, *c] } else { [*c, at] };
                self.locals.extend(cut.iter().map(place));
                for (n, part) in parts.into_iter().enumerate() {
                    let inside = pierce.filter(|p| (p.at[across] >= at) == (n == 1));
                    self.visit(part, inside, depth + 1);
                }
                return;
            }
        }
        self.doubtful = true;
    }

    /// The lower and the upper part of a rectangle that is cut where coordinate `across` is `at`.
    fn parts(&self, whole: &Rectangle, across: usize, at: f64, cut: &[(f64, bool)]) -> [Rectangle; 2] {
        // Sides along the coordinate that is divided, and across it.
        let (along, ends) = if across == 0 { ([0, 1], [2, 3]) } else { ([2, 3], [0, 1]) };
        let fresh: Vec<Crossing> = cut
            .iter()
            .enumerate()
            .map(|(i, (at, rises))| Crossing { at: *at, node: Node::Local(self.locals.len() + i), rises: *rises })
            .collect();
        [0, 1].map(|n| {
            let mut part = Rectangle { range: whole.range, sides: Default::default() };
            part.range[across][1 - n] = at;
            for side in along {
                part.sides[side] = whole.sides[side].iter().filter(|c| (c.at >= at) == (n == 1)).copied().collect();
            }
            part.sides[ends[n]] = whole.sides[ends[n]].clone();
            part.sides[ends[1 - n]] = fresh.clone();
            part
        })
    }

    /// Joins the parts of the curve at the local points.
    fn finish(self) -> Links {
        let mut next = vec![None; self.locals.len()];
        let mut used = vec![false; self.locals.len()];
        for [from, to] in &self.links {
            if let Node::Local(i) = from {
                next[*i] = Some(*to);
            }
        }
        let mut found = Links { doubtful: self.doubtful, ..Links::default() };
        for [from, to] in &self.links {
            let Node::Vertex(start) = from else { continue };
            let mut end = Some(*to);
            let mut between = Vec::new();
            let mut last = None;
            while let Some(Node::Local(i)) = end {
                let direction = self.plane.gradient(self.locals[i]);
                if self.least > 0 && last.is_none_or(|last| cosine(last, direction) < KEPT_TURN) {
                    // The first one only says where the curve starts to turn.
                    if last.is_some() {
                        between.push(self.locals[i]);
                    }
                    last = Some(direction);
                }
                end = if std::mem::replace(&mut used[i], true) { None } else { next[i] };
            }
            match end {
                Some(Node::Vertex(end)) => found.links.push(Link { ends: [*start, end], between }),
                _ => found.doubtful = true,
            }
        }
        for start in 0..next.len() {
            let mut oval = Vec::new();
            let mut at = Some(start);
            while let Some(i) = at.filter(|i| !std::mem::replace(&mut used[*i], true)) {
                oval.push(self.locals[i]);
                at = next[i].and_then(|node| if let Node::Local(j) = node { Some(j) } else { None });
            }
            match oval.len() {
                0 => {}
                1 | 2 => found.doubtful = true,
                _ => found.ovals.push(oval),
            }
        }
        found
    }
}
