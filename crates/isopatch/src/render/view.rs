//! From where a picture is taken.

use crate::geom::{Aabb, Point3, Vec3};
use std::str::FromStr;

/// Which way up the model stands in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// x is up.
    X,
    /// y is up, as in many mesh files.
    Y,
    /// z is up.
    #[default]
    Z,
}

/// A direction of view: the eye is at this azimuth and elevation, in degrees, seen from the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Angle around the vertical axis, counter-clockwise from above, from the x axis (from the next axis in the order x, y, z, x
    /// if x is up).
    pub azimuth: f64,
    /// Angle above the horizon, from −90 to 90.
    pub elevation: f64,
}

/// A text that is no view.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no view: front, back, left, right, top, bottom, or azimuth,elevation in degrees")]
pub struct UnknownView(String);

impl View {
    /// The views with a name.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("front", Self { azimuth: -90.0, elevation: 0.0 }),
        ("back", Self { azimuth: 90.0, elevation: 0.0 }),
        ("left", Self { azimuth: 180.0, elevation: 0.0 }),
        ("right", Self { azimuth: 0.0, elevation: 0.0 }),
        ("top", Self { azimuth: -90.0, elevation: 90.0 }),
        ("bottom", Self { azimuth: -90.0, elevation: -90.0 }),
    ];

    /// A view of a box from above and aside that shows its broader side, and more from above the flatter the box is.
    pub fn three_quarter(bounds: &Aabb, up: Up) -> Self {
        let size = up.upright(bounds.size());
        // 32 degrees beside the normal of the broader side; a third of a right angle would look like a drawing of a box.
        let azimuth = if size.x >= size.y { -90.0 + 32.0 } else { -32.0 };
        let flatness = size.z / size.x.max(size.y);
        let elevation = if flatness < 0.4 { 42.0 } else { 24.0 };
        Self { azimuth, elevation }
    }
}

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(text: &str) -> Result<Self, UnknownView> {
        if let Some((_, view)) = Self::NAMED.iter().find(|(name, _)| *name == text.trim()) {
            return Ok(*view);
        }
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let angles = text.split_once(',').and_then(|(a, e)| Some((number(a)?, number(e)?)));
        let view =
            angles.filter(|(_, e)| e.abs() <= 90.0).map(|(azimuth, elevation)| Self { azimuth, elevation });
        view.ok_or_else(|| UnknownView(text.to_owned()))
    }
}

impl Up {
    /// Coordinates with z up.
    pub(super) fn upright(self, p: Vec3) -> Vec3 {
        match self {
            Self::X => Vec3::new(p.y, p.z, p.x),
            Self::Y => Vec3::new(p.z, p.x, p.y),
            Self::Z => p,
        }
    }
}

/// Distance of the eye from the centre, in radii of the ball around the model: a mild perspective.
pub(super) const DISTANCE: f64 = 5.0;

/// A camera whose picture holds all of a model.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    up_axis: Up,
    center: Point3,
    /// 1 / radius of the ball around the model.
    scale: f64,
    /// Rows: to the right, up, and from the model to the eye.
    axes: [Vec3; 3],
    /// Pixels for a unit of the image plane, and the pixel of its origin.
    focal: f64,
    origin: [f64; 2],
}

/// A point in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    /// To the right and down, in pixels.
    pub x: f64,
    pub y: f64,
    /// Reciprocal of the distance along the axis of the camera: linear in the picture, larger is nearer.
    pub near: f64,
}

/// A part of the picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl Camera {
    /// Looks at the points so that they fill the area.
    pub fn around(points: &[Point3], view: View, up_axis: Up, area: Area) -> Self {
        let finite = || points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let bounds = Aabb::around(finite());
        let center = if bounds.is_empty() { Point3::zeros() } else { bounds.center() };
        let radius = finite().map(|p| (p - center).norm()).fold(0.0, f64::max);
        let scale = if radius > 0.0 { radius.recip() } else { 1.0 };
        let [(sa, ca), (se, ce)] = [view.azimuth, view.elevation].map(|d| d.to_radians().sin_cos());
        let axes =
            [Vec3::new(-sa, ca, 0.0), Vec3::new(-se * ca, -se * sa, ce), Vec3::new(ce * ca, ce * sa, se)];
        let mut camera = Self { up_axis, center, scale, axes, focal: 1.0, origin: [0.0; 2] };
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in finite() {
            let pixel = camera.project(p);
            for (c, x) in [pixel.x, pixel.y].into_iter().enumerate() {
                (min[c], max[c]) = (min[c].min(x), max[c].max(x));
            }
        }
        let extent = |c: usize| (max[c] - min[c]).max(f64::MIN_POSITIVE);
        let room = |c: usize| area.max[c] - area.min[c];
        let focal = (room(0) / extent(0)).min(room(1) / extent(1));
        if focal.is_finite() && radius > 0.0 {
            camera.focal = focal;
            camera.origin =
                std::array::from_fn(|c| 0.5 * (area.min[c] + area.max[c]) - 0.5 * focal * (min[c] + max[c]));
        } else {
            camera.origin = std::array::from_fn(|c| 0.5 * (area.min[c] + area.max[c]));
        }
        camera
    }

    /// A point relative to the eye's axes, in radii: to the right, up, towards the eye.
    pub fn local(&self, p: &Point3) -> Vec3 {
        let q = self.up_axis.upright(self.scale * (p - self.center));
        Vec3::new(q.dot(&self.axes[0]), q.dot(&self.axes[1]), q.dot(&self.axes[2]))
    }

    /// A direction relative to the eye's axes.
    pub fn direction(&self, d: &Vec3) -> Vec3 {
        let q = self.up_axis.upright(*d);
        Vec3::new(q.dot(&self.axes[0]), q.dot(&self.axes[1]), q.dot(&self.axes[2]))
    }

    /// Where a point is seen.
    pub fn project(&self, p: &Point3) -> Pixel {
        let q = self.local(p);
        let near = (DISTANCE - q.z).recip();
        Pixel {
            x: self.origin[0] + self.focal * q.x * near,
            y: self.origin[1] - self.focal * q.y * near,
            near,
        }
    }

    /// The unit direction to the eye, in its own axes, from what is seen at a point of the picture.
    pub fn eye_at(&self, [x, y]: [f64; 2]) -> Vec3 {
        Vec3::new((self.origin[0] - x) / self.focal, (y - self.origin[1]) / self.focal, 1.0).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_read() {
        assert_eq!("front".parse(), Ok(View { azimuth: -90.0, elevation: 0.0 }));
        assert_eq!("30, -12.5".parse(), Ok(View { azimuth: 30.0, elevation: -12.5 }));
        for text in ["", "up", "30", "0,91", "nan,0", "1,2,3"] {
            assert!(text.parse::<View>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_model_fills_the_area_wherever_it_is() {
        let area = Area { min: [10.0, 20.0], max: [310.0, 220.0] };
        for (scale, shift) in [(1.0, 0.0), (1e-6, 0.0), (1e9, 3e9), (1.0, 1e6)] {
            let points: Vec<Point3> = Aabb::new(Point3::new(-1.0, -2.0, -0.5), Point3::new(3.0, 2.0, 1.0))
                .corners()
                .map(|p| scale * p + Vec3::repeat(shift))
                .to_vec();
            for (_, view) in View::NAMED {
                for up in [Up::X, Up::Y, Up::Z] {
                    let camera = Camera::around(&points, view, up, area);
                    let pixels: Vec<Pixel> = points.iter().map(|p| camera.project(p)).collect();
                    let fits = |of: fn(&Pixel) -> f64, c: usize| {
                        let min = pixels.iter().map(of).fold(f64::INFINITY, f64::min);
                        let max = pixels.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
                        assert!(min >= area.min[c] - 1e-6 && max <= area.max[c] + 1e-6);
                        (max - min) / (area.max[c] - area.min[c]) > 1.0 - 1e-6
                    };
                    assert!(fits(|p| p.x, 0) | fits(|p| p.y, 1));
                }
            }
        }
    }

    #[test]
    fn the_axes_are_where_the_names_say() {
        let area = Area { min: [0.0; 2], max: [100.0; 2] };
        let cube: Vec<Point3> = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0)).corners().to_vec();
        let camera = |name: &str| Camera::around(&cube, name.parse().unwrap(), Up::Z, area);
        let front = camera("front");
        assert!((front.local(&Point3::x()).normalize() - Vec3::x()).norm() < 1e-12, "x to the right");
        assert!((front.local(&Point3::z()).normalize() - Vec3::y()).norm() < 1e-12, "z up");
        let top = camera("top");
        assert!((top.local(&Point3::y()).normalize() - Vec3::y()).norm() < 1e-12, "y up seen from above");
        assert!(front.project(&Point3::new(0.0, -1.0, 0.0)).near > front.project(&Point3::y()).near);
        let standing = Camera::around(&cube, "front".parse().unwrap(), Up::Y, area);
        assert!((standing.local(&Point3::y()).normalize() - Vec3::y()).norm() < 1e-12);
    }

    #[test]
    fn nothing_and_a_point_have_a_camera() {
        let area = Area { min: [0.0; 2], max: [100.0; 2] };
        for points in [vec![], vec![Point3::x()], vec![Point3::repeat(f64::NAN)]] {
            let camera = Camera::around(&points, View::NAMED[0].1, Up::Z, area);
            let pixel =
                camera.project(&points.first().copied().filter(|p| p.x.is_finite()).unwrap_or_default());
            assert_eq!((pixel.x, pixel.y), (50.0, 50.0));
        }
    }
}
