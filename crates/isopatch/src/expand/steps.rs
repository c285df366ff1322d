//! The general steps of Algorithms 1 and 2 (Bajaj & Xu 1997, §4): where the front goes on, and how far.

use super::front::{Directed, FAIR, Front, GOOD, POOR};
use super::options::{Approach, ExpandOptions};
use super::p_expression::PExpression;
use super::sheet::Sheet;
use crate::geom::{Point3, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

/// Lengths of [`ExpandOptions`] in model units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub epsilon: f64,
    pub longest: f64,
    pub shortest: f64,
}

impl Scale {
    pub fn new(options: &ExpandOptions, diagonal: f64) -> Self {
        let longest = options.longest * diagonal;
        let shortest = SHORTEST * longest.min(options.segment * diagonal);
        Self { epsilon: options.epsilon * diagonal, longest, shortest }
    }
}

/// The shortest step, in units of the longest one or of the segments of walls: certified radii go to zero at singular
/// points, and there the walls end the expansion.
const SHORTEST: f64 = 0.5;
/// Tries with a shorter step where one does not arrive on the surface.
const SHORTER: usize = 5;
/// What a step is shortened by.
const SHORTEN: f64 = 0.7;

/// Expands a front until nothing fits any more.
pub(super) struct Expansion<'a, 'b> {
    pub front: &'b mut Front<'a>,
    pub options: &'b ExpandOptions,
    pub scale: Scale,
    approach: Approach,
    /// Series and radius at the vertices where they were needed.
    series: BTreeMap<u32, Option<(PExpression, f64)>>,
    /// Edges and vertices at which nothing fitted.
    given_up: BTreeSet<Directed>,
    tired: BTreeSet<u32>,
}

/// The front at one vertex: the edges that come in and go out, and the angle between them that is still empty.
#[derive(Clone, Copy, Debug)]
struct Gap {
    vertex: u32,
    incoming: Directed,
    outgoing: Directed,
    angle: f64,
}

impl<'a, 'b> Expansion<'a, 'b> {
    pub fn new(front: &'b mut Front<'a>, options: &'b ExpandOptions) -> Self {
        let scale = Scale::new(options, front.sheet.bounds.diagonal());
        let (series, given_up, tired) = Default::default();
        Self { front, options, scale, approach: options.approach, series, given_up, tired }
    }

    /// The power series at a point of the surface, and the step it allows.
    pub fn series_at(&self, p: Point3) -> Option<(PExpression, f64)> {
        let series = self.front.sheet.series(p, self.options.degree)?;
        let Scale { epsilon, longest, shortest } = self.scale;
        let curvature = series.curvature();
        let turning = if curvature > 0.0 { self.options.turn / curvature } else { longest };
        let radius = series.radius(epsilon, longest).min(turning).max(shortest).min(longest);
        Some((series, radius))
    }

    fn of_vertex(&mut self, v: u32) -> Option<(PExpression, f64)> {
        if !self.series.contains_key(&v) {
            let made = self.front.normal(v).and_then(|_| self.series_at(self.front.at(v)));
            self.series.insert(v, made);
        }
        self.series.get(&v).cloned().flatten()
    }

    /// A point at distance r from the expansion point in a direction of its P-plane, refined onto the surface by Newton's
    /// method; nearer where that does not arrive on the same sheet.
    fn refined(&self, series: &PExpression, direction: [f64; 2], r: f64) -> Option<Point3> {
        refined(self.front.sheet, series, direction, r)
    }

    /// Repeats the general step until no edge and no vertex is expansible; then closes what is left, and triangulates places
    /// anew that could not be closed.
    pub fn run(&mut self) {
        self.advance();
        for _ in 0..REPAIRS {
            if self.front.edges.is_empty() {
                break;
            }
            self.front.reopen();
            (self.given_up, self.tired) = Default::default();
            self.approach = Approach::Edge;
            self.advance();
        }
    }

    fn advance(&mut self) {
        while self.front.triangles.len() < self.options.most_triangles {
            let step = match self.approach {
                Approach::Edge => self.edge_step(),
                Approach::Vertex => self.vertex_step(),
            };
            if !step {
                break;
            }
        }
        self.close();
    }

    /// Gaps by vertex, sharpest first.
    fn gaps(&self) -> Vec<Gap> {
        let front = &self.front;
        let mut incoming: BTreeMap<u32, Vec<Directed>> = BTreeMap::new();
        for edge in front.edges.keys() {
            incoming.entry(edge.1).or_default().push(*edge);
        }
        let mut gaps: Vec<Gap> = Vec::new();
        for (outgoing, edge) in &front.edges {
            let vertex = outgoing.0;
            let normal = front.normal(vertex).unwrap_or(edge.normal);
            let at = front.at(vertex);
            let among = incoming.get(&vertex).into_iter().flatten();
            let angles =
                among.map(|e| (angle(&normal, &(front.at(outgoing.1) - at), &(front.at(e.0) - at)), *e));
            let sharpest = angles.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if let Some((angle, incoming)) = sharpest {
                gaps.push(Gap { vertex, incoming, outgoing: *outgoing, angle });
            }
        }
        gaps.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.outgoing.cmp(&b.outgoing)));
        gaps
    }

    /// Algorithm 1, general step.
    fn edge_step(&mut self) -> bool {
        let gaps = self.gaps();
        let is_open = |e: &Directed| !self.given_up.contains(e);
        let Some(gap) = gaps.into_iter().find(|gap| is_open(&gap.incoming) && is_open(&gap.outgoing)) else {
            return self.front.edges.keys().copied().find(is_open).is_some_and(|e| self.over_edge(e, &[]));
        };
        let (before, after) = (gap.incoming.0, gap.outgoing.1);
        if gap.angle <= FRAC_PI_2 && before != after {
            // The triangle between the two edges, if it fits.
            let reach = self.front.length(gap.incoming).max(self.front.length(gap.outgoing));
            if self.front.attach(gap.outgoing, None, reach, &[before], FAIR) == Some(before) {
                return true;
            }
        }
        let longer = if self.front.length(gap.incoming) >= self.front.length(gap.outgoing) {
            gap.incoming
        } else {
            gap.outgoing
        };
        self.over_edge(longer, &[])
    }

    /// A triangle over an edge, to the point of Algorithm 1 (a)–(d).
    fn over_edge(&mut self, edge: Directed, preferred: &[u32]) -> bool {
        let Some(front) = self.front.edges.get(&edge).copied() else { return true };
        let (a, b) = (self.front.at(edge.0), self.front.at(edge.1));
        let plane = self.front.plane(edge, &front);
        let half = (b - a).norm() / 2.0;
        // (a), (b): the next expansion point, on the perpendicular bisector and on the circle of the last one.
        let back = -plane.project(&front.center).y;
        let radius = self.series_at(front.center).map_or(self.scale.shortest, |(_, r)| r);
        let step = (radius - back.clamp(0.0, radius))
            .clamp(0.3 * self.scale.shortest, half.max(self.scale.shortest));
        let found =
            self.front.sheet.foot(plane.lift([0.0, step])).and_then(|p| Some((p, self.series_at(p)?)));
        // (c), (d): as far beyond it as its own circle goes.
        let ideal = found.as_ref().and_then(|(p, (series, r))| {
            let away = series.project(p) - series.project(&plane.origin());
            let direction = away.xy().try_normalize(0.0)?;
            let there = (p - plane.origin()).norm();
            let most = (LONG * half - there).max(0.3 * r);
            self.refined(series, [direction.x, direction.y], r.min(most))
        });
        let center = found.map_or(plane.origin(), |(p, _)| p);
        let reach = ideal.map_or(2.0 * half, |q| (q - plane.origin()).norm());
        let done = self.front.attach(edge, ideal, reach, preferred, GOOD).or_else(|| {
            let nearer =
                ideal.and_then(|q| self.front.sheet.foot(plane.origin() + (q - plane.origin()) * 0.5));
            self.front.attach(edge, nearer, reach.max(2.0 * half), preferred, FAIR)
        });
        match done {
            Some(c) => {
                for e in [(edge.0, c), (c, edge.1)] {
                    if let Some(edge) = self.front.edges.get_mut(&e) {
                        edge.center = center;
                    }
                }
                true
            }
            None => {
                self.given_up.insert(edge);
                true
            }
        }
    }

    /// Algorithm 2, general step: fills the gap at the sharpest vertex with a fan.
    fn vertex_step(&mut self) -> bool {
        let is_open =
            |gap: &Gap| !self.tired.contains(&gap.vertex) && self.front.normal(gap.vertex).is_some();
        let Some(gap) = self.gaps().into_iter().find(is_open) else {
            // Vertices on walls have no series; edges between them are expanded as in Algorithm 1.
            let edge = self.front.edges.keys().copied().find(|e| !self.given_up.contains(e));
            return edge.is_some_and(|e| {
                self.given_up.insert(e);
                self.over_edge(e, &[])
            });
        };
        let v = gap.vertex;
        let Some((series, radius)) = self.of_vertex(v) else {
            self.tired.insert(v);
            return true;
        };
        let last = gap.incoming.0;
        let mut edge = gap.outgoing;
        for _ in 0..MOST_IN_FAN {
            let from = series.project(&self.front.at(edge.1));
            let to = series.project(&self.front.at(last));
            let left = (to.y.atan2(to.x) - from.y.atan2(from.x)).rem_euclid(TAU);
            let left = if left < 1e-6 { TAU } else { left };
            let known = [from.xy().norm(), to.xy().norm()];
            let radius = radius.min(GROWTH * known[0].max(known[1]));
            let turn = self.partition(&series, radius, [from.y.atan2(from.x), left]);
            let (ideal, preferred) = if turn >= left - 1e-9 {
                (None, vec![last])
            } else {
                let direction = from.y.atan2(from.x) + turn;
                (self.refined(&series, [direction.cos(), direction.sin()], radius), vec![])
            };
            let demand = if ideal.is_some() { GOOD } else { FAIR };
            let made = self.front.attach(edge, ideal, radius, &preferred, demand).or_else(|| {
                let direction = from.y.atan2(from.x) + turn.min(FRAC_PI_3);
                let nearer = self.refined(&series, [direction.cos(), direction.sin()], 0.6 * radius);
                self.front.attach(edge, nearer, radius, &[last], FAIR)
            });
            match made {
                // The fan goes on from the new vertex, unless its edge joined the front elsewhere.
                Some(c) if self.front.edges.contains_key(&(v, c)) => edge = (v, c),
                Some(_) => return true,
                None => break,
            }
        }
        self.tired.insert(v);
        true
    }

    /// The binary partition process: halves the angle from the first direction until two neighbouring points on the circle
    /// are within each other's spheres. Returns the first part.
    fn partition(&self, series: &PExpression, radius: f64, [start, angle]: [f64; 2]) -> f64 {
        let mut turn = angle;
        while turn > LARGEST_SECTOR {
            turn /= 2.0;
        }
        let at = |a: f64| self.refined(series, [a.cos(), a.sin()], radius);
        while turn > SMALLEST_SECTOR * 2.0 {
            let (Some(p), Some(q)) = (at(start), at(start + turn)) else { break };
            let apart = (q - p).norm();
            let reaches = |p: Point3| self.series_at(p).is_none_or(|(_, r)| r * SLACK >= apart);
            if reaches(p) && reaches(q) {
                break;
            }
            turn /= 2.0;
        }
        turn
    }

    /// Closes what is left, with triangles between vertices that are there.
    fn close(&mut self) {
        for demand in [GOOD, FAIR, POOR] {
            loop {
                let gaps = self.gaps();
                let mut closed = false;
                for gap in gaps {
                    if !self.front.edges.contains_key(&gap.outgoing) {
                        continue;
                    }
                    let reach = CLOSING
                        * self
                            .front
                            .length(gap.outgoing)
                            .max(self.front.length(gap.incoming))
                            .max(self.scale.shortest);
                    closed |=
                        self.front.attach(gap.outgoing, None, reach, &[gap.incoming.0], demand).is_some();
                }
                if !closed {
                    break;
                }
            }
        }
    }
}

/// Times that places which could not be closed are triangulated anew.
const REPAIRS: usize = 3;
/// A triangle over an edge is at most this high, in units of half of the edge.
const LONG: f64 = 2.2;
/// A step is at most this much longer than the longer edge of the front beside it.
const GROWTH: f64 = 1.7;
/// Sectors of a fan have at most this angle, so that triangles are well shaped.
const LARGEST_SECTOR: f64 = 1.25 * FRAC_PI_3;
/// And at least this.
const SMALLEST_SECTOR: f64 = PI / 9.0;
/// Two points on the circle are a radius apart in a sector of 60°.
const SLACK: f64 = 1.3;
/// More triangles than this are not made around a vertex.
const MOST_IN_FAN: usize = 40;
/// How far to look for a vertex to close a gap with, in lengths of its edges.
const CLOSING: f64 = 2.0;

/// See [`Expansion::refined`].
pub(super) fn refined(
    sheet: &Sheet<'_>,
    series: &PExpression,
    direction: [f64; 2],
    r: f64,
) -> Option<Point3> {
    let normal: Vec3 = series.frame().row(2).transpose();
    let mut r = r;
    for _ in 0..SHORTER {
        let q = direction.map(|c| c * r);
        let start = series.lift(q);
        let found = sheet.foot(start).filter(|p| {
            let stays = (p - start).norm() < r;
            stays && sheet.normal(*p).is_none_or(|n| n.dot(&normal) > SAME_SIDE)
        });
        if found.is_some() {
            return found;
        }
        r *= SHORTEN;
    }
    None
}

/// Over a step, normals keep at least this product.
const SAME_SIDE: f64 = 0.25;

/// The angle from u to v, counter-clockwise about the normal, in (0, 2π].
fn angle(normal: &Vec3, u: &Vec3, v: &Vec3) -> f64 {
    let angle = normal.dot(&u.cross(v)).atan2(u.dot(v) - u.dot(normal) * v.dot(normal)).rem_euclid(TAU);
    if angle <= 1e-9 { TAU } else { angle }
}
