//! Pictures: what is where in them.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::geom::{Point3, Vec3};
use isopatch::render::{
    Color, Image, LineSet, Paint, RenderError, RenderOptions, Scene, Style, StyleError, Subject, Veil, View,
    draw, scene,
};
use isopatch::tessellate::{TessellateOptions, Tessellation, tessellate};
use support::golden::{flat_triangle, inverted, joined, scaled, sphere};

const WIDTH: usize = 240;
const HEIGHT: usize = 180;

fn options() -> RenderOptions {
    let white = Color([1.0; 3]);
    RenderOptions {
        size: [WIDTH, HEIGHT],
        view: Some(View { azimuth: -90.0, elevation: 0.0 }),
        background: [white; 2],
        ..RenderOptions::default()
    }
}

fn at(image: &Image, x: usize, y: usize) -> [u8; 3] {
    let start = 3 * (y * image.width + x);
    image.rgb[start..start + 3].try_into().unwrap()
}

/// Pixels that are not of the background, and their mean place.
fn covered(image: &Image) -> (usize, [f64; 2]) {
    let (mut count, mut sum) = (0, [0.0; 2]);
    for y in 0..image.height {
        for x in 0..image.width {
            if at(image, x, y) != [255; 3] {
                count += 1;
                sum = [sum[0] + x as f64 + 0.5, sum[1] + y as f64 + 0.5];
            }
        }
    }
    (count, sum.map(|s| s / count as f64))
}

fn ball() -> Tessellation {
    tessellate(&sphere(), &TessellateOptions { resolution: 16 }).unwrap()
}

fn plain(outside: [f32; 3], inside: [f32; 3]) -> Paint {
    Paint::Plain { outside: Color(outside), inside: Color(inside) }
}

fn is_red(pixel: [u8; 3]) -> bool {
    u32::from(pixel[0]) > 2 * u32::from(pixel[1]) && u32::from(pixel[0]) > 2 * u32::from(pixel[2])
}

#[test]
fn a_sphere_is_a_disc_in_the_middle() {
    let mesh = ball();
    let image = draw(&scene(&mesh, &Subject::default(), Style::Shaded).unwrap(), &options()).unwrap();
    let (count, [x, y]) = covered(&image);
    // The margin is 5.5 % of the height on either side.
    let radius = 0.5 * HEIGHT as f64 * (1.0 - 2.0 * 0.055);
    let disc = std::f64::consts::PI * radius * radius;
    assert!((count as f64 - disc).abs() < 0.03 * disc, "{count} {disc}");
    assert!((x - 0.5 * WIDTH as f64).abs() < 0.5 && (y - 0.5 * HEIGHT as f64).abs() < 0.5);
    let brightness = |x, y| at(&image, x, y).map(u32::from).iter().sum::<u32>();
    assert!(brightness(95, 60) > brightness(150, 125) + 100, "light comes from above on the left");
    assert!(at(&image, 120, 90)[2] > at(&image, 120, 90)[0], "the outside is blue");
}

#[test]
fn edges_are_smooth() {
    let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 1 }).unwrap();
    let view = Some(View { azimuth: -90.0, elevation: 90.0 });
    let drawing = Scene::new(&mesh, plain([0.0; 3], [0.0; 3]));
    let image = draw(&drawing, &RenderOptions { view, ..options() }).unwrap();
    let mut tones: Vec<u8> = image.rgb.clone();
    tones.sort_unstable();
    tones.dedup();
    assert!(tones.len() >= 12, "{tones:?}");
}

#[test]
fn the_nearer_surface_hides_the_farther() {
    // Seen from the front, the eye is at negative y.
    let two = joined(&[sphere(), scaled(&sphere(), 0.5, Vec3::new(0.0, 4.0, 0.0))]);
    let mesh = tessellate(&two, &TessellateOptions { resolution: 8 }).unwrap();
    let mut colors = vec![Color([0.0, 0.0, 1.0]); 20];
    colors.extend([Color([1.0, 0.0, 0.0]); 20]);
    let behind = draw(&Scene::new(&mesh, Paint::Patches(colors.clone())), &options()).unwrap();
    assert!(!behind.rgb.chunks(3).any(|p| is_red(p.try_into().unwrap())));
    let from_back = RenderOptions { view: Some(View { azimuth: 90.0, elevation: 0.0 }), ..options() };
    let before = draw(&Scene::new(&mesh, Paint::Patches(colors)), &from_back).unwrap();
    assert!(is_red(at(&before, WIDTH / 2, HEIGHT / 2)));
}

#[test]
fn the_inside_has_its_own_color() {
    let mesh = tessellate(&inverted(&sphere()), &TessellateOptions { resolution: 6 }).unwrap();
    let image = draw(&Scene::new(&mesh, plain([0.0, 0.0, 1.0], [1.0, 0.0, 0.0])), &options()).unwrap();
    assert!(is_red(at(&image, WIDTH / 2, HEIGHT / 2)), "the normals point away from the eye");
}

#[test]
fn lines_are_hidden_behind_the_surface_or_shine_through() {
    let mesh = ball();
    let count = |hidden: f32, y: f64| {
        let mut drawing = Scene::new(&mesh, plain([0.2, 0.2, 0.9], [0.2; 3]));
        drawing.lines.push(LineSet {
            segments: vec![[Point3::new(-0.4, y, 0.0), Point3::new(0.4, y, 0.0)]],
            color: Color([1.0, 0.0, 0.0]),
            width: 20.0,
            hidden,
        });
        let image = draw(&drawing, &options()).unwrap();
        image.rgb.chunks(3).filter(|p| is_red((*p).try_into().unwrap())).count()
    };
    assert_eq!(count(0.0, 0.5), 0);
    assert!(count(0.9, 0.5) > 100);
    assert!(count(0.0, -1.2) > 100);
}

#[test]
fn veils_let_the_surface_through() {
    let mesh = ball();
    let red = |opacity: f32| {
        let mut drawing = Scene::new(&mesh, plain([0.0, 0.0, 0.8], [0.2; 3]));
        let corners =
            [Point3::new(-1.0, -1.3, -1.0), Point3::new(1.0, -1.3, -1.0), Point3::new(0.0, -1.3, 1.0)];
        drawing.veils.push(Veil { corners, color: Color([1.0, 0.0, 0.0]), opacity });
        at(&draw(&drawing, &options()).unwrap(), WIDTH / 2, HEIGHT / 2)
    };
    let (none, half, all) = (red(0.0), red(0.5), red(1.0));
    assert!(none[0] < half[0] && half[0] < all[0] && half[2] > 60, "{none:?} {half:?} {all:?}");
    assert_eq!(all, [255, 0, 0]);
}

#[test]
fn every_style_draws_and_threads_do_not_matter() {
    let surface = sphere();
    let mesh = tessellate(&surface, &TessellateOptions { resolution: 8 }).unwrap();
    let singular = vec![vec![Point3::new(-0.7, -0.8, 0.0), Point3::new(0.0, -1.05, 0.0)], vec![-Point3::y()]];
    let subject = Subject { surface: Some(&surface), singular: &singular, ..Subject::default() };
    let styles = [
        Style::Shaded,
        Style::Patches,
        Style::Isophotes,
        Style::Reflection,
        Style::Gold,
        Style::GaussianCurvature,
        Style::MeanCurvature,
        Style::Net,
        Style::Mesh,
        Style::Normals,
        Style::Singular,
    ];
    let drawn = |style, threads: usize, size| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = RenderOptions { size, ..options() };
        pool.install(|| draw(&scene(&mesh, &subject, style).unwrap(), &options).unwrap())
    };
    let images = styles.map(|style| drawn(style, 1, [WIDTH, HEIGHT]));
    for (i, a) in images.iter().enumerate() {
        assert!(covered(a).0 > 10_000);
        assert!(images[..i].iter().all(|b| b != a), "{:?}", styles[i]);
    }
    for i in [4, 5, 7] {
        assert!(images[i] == drawn(styles[i], 3, [WIDTH, HEIGHT]), "{:?}", styles[i]);
    }
    let red = drawn(Style::Singular, 1, [800, 600]).rgb;
    let red = red.chunks(3).filter(|p| is_red((*p).try_into().unwrap())).count();
    assert!(red > 300, "the singular set is red: {red}");
    assert_eq!(scene(&mesh, &subject, Style::Hull).unwrap_err(), StyleError::NoHull);
    assert_eq!(scene(&mesh, &Subject::default(), Style::Net).unwrap_err(), StyleError::NoNet);
}

#[test]
fn the_mean_curvature_of_a_sphere_has_one_color_and_a_legend() {
    let mesh = ball();
    let drawing = scene(&mesh, &Subject::default(), Style::MeanCurvature).unwrap();
    let legend = drawing.legend.as_ref().unwrap();
    assert_eq!(legend.title, "Mean curvature");
    let [low, high] = legend.range;
    assert!(low > 0.4 && low < 1.0 && high > 1.0 && high < 1.6, "{low} {high}");
}

#[test]
fn bad_numbers_are_no_panic() {
    let mut mesh = ball();
    mesh.positions[5] = Point3::repeat(f64::NAN);
    mesh.normals[9] = Vec3::repeat(f64::INFINITY);
    mesh.positions[11] = Point3::new(1e300, -1e300, 1e300);
    for style in [Style::Shaded, Style::GaussianCurvature, Style::Gold, Style::Mesh, Style::Normals] {
        draw(&scene(&mesh, &Subject::default(), style).unwrap(), &options()).unwrap();
    }
    let nothing = Tessellation {
        positions: vec![],
        normals: vec![],
        triangles: vec![],
        corner_normals: vec![],
        patches: vec![],
    };
    for style in [Style::Shaded, Style::MeanCurvature, Style::Patches, Style::Normals] {
        let image = draw(&scene(&nothing, &Subject::default(), style).unwrap(), &options()).unwrap();
        assert_eq!(at(&image, 0, 0), [255; 3]);
    }
    let scene = scene(&nothing, &Subject::default(), Style::Shaded).unwrap();
    for size in [[0, 5], [5, 0], [20_000, 5]] {
        let [width, height] = size;
        let error = draw(&scene, &RenderOptions { size, ..options() }).unwrap_err();
        assert_eq!(error, RenderError::Size { width, height });
    }
}
