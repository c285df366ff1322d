//! How much of the light around a model reaches its surface: shadows of many lights, far away, all around.
//!
//! For each direction of light a map of what is nearest to it is drawn; a point is lit if nothing in the map is above it. The
//! mean over directions is smooth, the same from every side, and cheap: it is taken at the corners of the triangles only.

use super::view::{Camera, DISTANCE};
use crate::geom::Vec3;
use crate::parallel::Evenly;
use crate::tessellate::Tessellation;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Directions of the light from all around.
const SKY: usize = 64;
/// Directions of the main light, which is as wide as a window.
const KEY: usize = 20;
/// Half of the angle that the main light is wide, in radians.
const KEY_ANGLE: f64 = 0.3;
/// Texels along the side of a map.
const MAP: usize = 256;
/// Side of the maps in radii of the model: a little more than its diameter.
const MAP_SIDE: f64 = 2.08;
/// Points are lifted off the surface by so many texels, so that it does not shadow itself.
const LIFT: f64 = 2.0;
/// Light that comes in flatter than this cosine counts as seen: it adds little, and the maps are too coarse for it.
const GRAZING: f32 = 0.05;

/// Light that reaches a point, on the side of its normal and on the other, each from 0 to 1. A side that is not seen counts as lit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Light {
    /// From all around, weighted by the cosine.
    pub sky: [f32; 2],
    /// From the main light.
    pub key: [f32; 2],
}

/// Cosine to the direction of the eye below which both sides are lit, since either may be seen between the corners of a triangle.
const OUTLINE: f32 = 0.25;
/// Normals that are lit together, so that those of one patch find the same part of a map in the cache.
const CHUNK: usize = 1024;

/// The light at every normal of a mesh. `key` is the unit direction to the main light, in the axes of the camera.
pub(super) fn skylight(mesh: &Tessellation, camera: &Camera, key: &Vec3) -> Vec<Light> {
    let positions: Vec<Vec3> = mesh.positions.par_iter().evenly().map(|p| camera.local(p)).collect();
    let normals: Vec<Vec3> = mesh.normals.par_iter().evenly().map(|n| camera.direction(n)).collect();
    let lights: Vec<Vec3> = sphere(SKY).chain(cone(key, KEY)).collect();
    let casters = Casters::new(&positions, &mesh.triangles);
    let maps: Vec<Map> = lights.par_iter().evenly().map(|d| Map::new(*d, &casters)).collect();
    let mut vertex_of: Vec<u32> = (0..normals.len() as u32).collect();
    for (triangle, numbers) in mesh.triangles.iter().zip(&mesh.corner_normals) {
        triangle.iter().zip(numbers).for_each(|(v, n)| vertex_of[*n as usize] = *v);
    }
    let points: Vec<(Single, Single)> = vertex_of
        .iter()
        .zip(&normals)
        .map(|(v, n)| (single(&positions.get(*v as usize).copied().unwrap_or_default()), single(n)))
        .collect();
    points.par_chunks(CHUNK).evenly().flat_map_iter(|points| lit(&maps, points)).collect()
}

/// Coordinates in single precision: a hundredth of a texel is far more than its rounding.
type Single = [f32; 3];

fn single(p: &Vec3) -> Single {
    [p.x as f32, p.y as f32, p.z as f32]
}

fn dot(a: &Single, b: &Single) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The light at points with normals.
fn lit(maps: &[Map], points: &[(Single, Single)]) -> Vec<Light> {
    const LENGTH: f32 = (LIFT * MAP_SIDE / MAP as f64) as f32;
    // Only the side that faces the eye is seen, but near the outline it is not known which one that is.
    let sides: Vec<[bool; 2]> = points
        .iter()
        .map(|(p, n)| {
            let eye = [-p[0], -p[1], DISTANCE as f32 - p[2]];
            let facing = dot(n, &eye) / DISTANCE as f32;
            [facing > -OUTLINE, facing < OUTLINE]
        })
        .collect();
    // Light that is seen, and all light, on both sides: of the sky, and of the key.
    let mut sums = vec![[[[0f32; 2]; 2]; 2]; points.len()];
    for (number, map) in maps.iter().enumerate() {
        let is_key = number >= SKY;
        for (((p, n), sides), sums) in points.iter().zip(&sides).zip(&mut sums) {
            let cosine = dot(&map.light, n);
            let side = usize::from(cosine <= 0.0);
            if !sides[side] {
                continue;
            }
            let length = if side == 0 { LENGTH } else { -LENGTH };
            let weight = if is_key { 1.0 } else { cosine.abs() };
            let visible = if cosine.abs() < GRAZING {
                1.0
            } else {
                map.visible(&[p[0] + length * n[0], p[1] + length * n[1], p[2] + length * n[2]])
            };
            let [seen, all] = &mut sums[usize::from(is_key)];
            seen[side] += weight * visible;
            all[side] += weight;
        }
    }
    let share = |[seen, all]: [[f32; 2]; 2]| {
        [0, 1].map(|side| if all[side] > 0.0 { seen[side] / all[side] } else { 1.0 })
    };
    sums.into_iter().map(|[sky, key]| Light { sky: share(sky), key: share(key) }).collect()
}

/// Directions all around, evenly (the Fibonacci lattice).
fn sphere(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (s, c) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    })
}

/// Directions around one, evenly.
fn cone(axis: &Vec3, count: usize) -> impl Iterator<Item = Vec3> {
    let [u, v] = across(axis);
    let (axis, golden) = (*axis, PI * (3.0 - 5f64.sqrt()));
    (0..count).map(move |i| {
        let r = KEY_ANGLE * ((i as f64 + 0.5) / count as f64).sqrt();
        let (s, c) = (golden * i as f64).sin_cos();
        (axis + r * c * u + r * s * v).normalize()
    })
}

/// Two unit vectors that make a right-handed frame with a third.
fn across(n: &Vec3) -> [Vec3; 2] {
    let other = if n.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let u = n.cross(&other).normalize();
    [u, n.cross(&u)]
}

/// Longest side of a small triangle, in texels: their centres, with the middles of the sides of the larger ones, are then closer
/// together than texels.
const LARGE: f32 = 1.8;

/// What throws shadows: large triangles, and points in all others, which fall between the centres of texels.
struct Casters {
    large: Vec<[Single; 3]>,
    points: Vec<Single>,
}

impl Casters {
    fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let texel = (MAP_SIDE / MAP as f64) as f32;
        let mut casters = Self { large: Vec::new(), points: Vec::new() };
        for t in triangles {
            let corners = t.map(|v| single(&positions[v as usize]));
            let longest = (0..3).map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f32>()
            });
            let longest = longest.fold(0.0, f32::max).sqrt() / texel;
            if longest > LARGE {
                casters.large.push(corners);
                continue;
            }
            let [a, b, c] = corners;
            casters.points.push(std::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0));
            if longest > 0.5 * LARGE {
                let middle = |a: Single, b: Single| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
                casters.points.extend([middle(a, b), middle(b, c), middle(c, a)]);
            }
        }
        casters
    }
}

/// What is nearest to a light.
struct Map {
    light: Single,
    axes: [Single; 2],
    /// Largest coordinate towards the light, for each texel.
    nearest: Vec<f32>,
}

impl Map {
    fn new(light: Vec3, casters: &Casters) -> Self {
        let axes = across(&light).map(|axis| single(&axis));
        let mut map = Self { light: single(&light), axes, nearest: vec![f32::NEG_INFINITY; MAP * MAP] };
        for p in &casters.points {
            let [x, y] = map.texel(p);
            // The cast takes what is not finite to the first texel, where the maximum ignores it.
            let at = (y as usize).min(MAP - 1) * MAP + (x as usize).min(MAP - 1);
            map.nearest[at] = map.nearest[at].max(dot(p, &map.light));
        }
        for corners in &casters.large {
            map.draw(corners.map(|p| {
                let [x, y] = map.texel(&p);
                [x, y, dot(&p, &map.light)]
            }));
        }
        map
    }

    /// Coordinates in the map, in texels.
    fn texel(&self, p: &Single) -> [f32; 2] {
        const TEXELS: f32 = (MAP as f64 / MAP_SIDE) as f32;
        self.axes.map(|axis| dot(&axis, p) * TEXELS + 0.5 * MAP as f32)
    }

    /// Keeps the nearest of what is there and a triangle, at the centres of the texels.
    fn draw(&mut self, [a, b, c]: [Single; 3]) {
        let least = |k: usize| (a[k].min(b[k]).min(c[k]) - 0.5).ceil().max(0.0);
        let most = |k: usize| (a[k].max(b[k]).max(c[k]) - 0.5).floor().min((MAP - 1) as f32);
        let ([x0, y0], [x1, y1]) = ([least(0), least(1)], [most(0), most(1)]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        // Some triangles are between the centres, and some are seen from their edge. False for NaN, too.
        if !(x0 <= x1 && y0 <= y1 && area.abs() > 0.0) {
            return;
        }
        for j in y0 as usize..=y1 as usize {
            for i in x0 as usize..=x1 as usize {
                let (x, y) = (i as f32 + 0.5, j as f32 + 0.5);
                let edge =
                    |p: Single, q: Single| ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / area;
                let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];
                if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                    let nearest = &mut self.nearest[j * MAP + i];
                    *nearest = nearest.max(u * a[2] + v * b[2] + w * c[2]);
                }
            }
        }
    }

    /// How much of a point the light sees, from 0 to 1: the nine texels around it, weighted by a quadratic B-spline.
    fn visible(&self, p: &Single) -> f32 {
        let [x, y] = self.texel(p).map(|t| t.clamp(1.0, (MAP - 2) as f32));
        let (i, j) = (x as usize, y as usize);
        let weights = |t: f32| [0.5 * (1.0 - t) * (1.0 - t), 0.5 + t * (1.0 - t), 0.5 * t * t];
        let (across, down) = (weights(x - i as f32), weights(y - j as f32));
        let height = dot(p, &self.light);
        let mut sum = 0.0;
        for (row, down) in down.into_iter().enumerate() {
            let first = (j + row - 1) * MAP + i - 1;
            for (nearest, across) in self.nearest[first..first + 3].iter().zip(across) {
                sum += if *nearest <= height { across * down } else { 0.0 };
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::view::{Area, Up, View};
    use super::*;
    use crate::golden::sphere as golden_sphere;
    use crate::tessellate::{TessellateOptions, tessellate};

    fn camera(mesh: &Tessellation) -> Camera {
        let area = Area { min: [0.0; 2], max: [100.0; 2] };
        Camera::around(&mesh.positions, View::NAMED[0].1, Up::Z, area)
    }

    #[test]
    fn a_sphere_is_lit_from_everywhere_outside_and_dark_inside() {
        let mesh = tessellate(&golden_sphere(), &TessellateOptions { resolution: 16 }).unwrap();
        let key = Vec3::new(0.6, 0.0, 0.8);
        let light = skylight(&mesh, &camera(&mesh), &key);
        assert_eq!(light.len(), mesh.normals.len());
        for (light, n) in light.iter().zip(&mesh.normals) {
            let facing = camera(&mesh).direction(n);
            assert!(light.sky[0] > 0.97, "{light:?}");
            assert!(facing.z > -0.1 || light.sky[1] < 0.06, "{light:?}");
            assert!(facing.dot(&key) < 0.5 || light.key[0] > 0.97, "{light:?}");
        }
    }

    #[test]
    fn a_sphere_takes_away_what_the_formula_says() {
        let ball = tessellate(&golden_sphere(), &TessellateOptions { resolution: 12 }).unwrap();
        let count = ball.positions.len() as u32;
        let center = Vec3::new(3.0, 0.0, 0.0);
        let mut two = ball.clone();
        two.positions.extend(ball.positions.iter().map(|p| p + center));
        two.normals.extend(&ball.normals);
        two.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + count)));
        two.patches.extend(&ball.patches);
        // From the front, y is away from the eye.
        let light = skylight(&two, &camera(&two), &Vec3::z());
        let mut errors = Vec::new();
        for v in (0..count as usize).filter(|v| ball.normals[*v].x > 0.85 && ball.normals[*v].y < 0.2) {
            let (p, n) = (ball.positions[v], ball.normals[v]);
            // A ball that is all above the horizon takes sin² of its angular radius, times the cosine.
            let hidden = (center - p).norm_squared().recip() * n.dot(&(center - p).normalize());
            errors.push(f64::from(light[v].sky[0]) - (1.0 - hidden));
        }
        // The ball takes about four of the 32 directions above the horizon, each a sixteenth of the light or less.
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(errors.len() > 20 && mean.abs() < 0.03, "{mean}");
        assert!(errors.iter().all(|e| e.abs() < 0.12), "{errors:?}");
        let behind = (0..count as usize).filter(|v| ball.normals[*v].x < -0.5);
        assert!(behind.into_iter().all(|v| light[v].sky[0] > 0.97));
    }
}
