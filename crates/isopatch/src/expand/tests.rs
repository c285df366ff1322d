use super::*;
use crate::field::{Constants, Formula};
use crate::geom::{Aabb, Point3, Vec3};

fn surface(text: &str) -> Formula {
    Formula::parse(text, &Constants::new()).unwrap()
}

fn bounds(b: [f64; 6]) -> Aabb {
    Aabb::new(Point3::new(b[0], b[2], b[4]), Point3::new(b[1], b[3], b[5]))
}

fn run(text: &str, b: [f64; 6], walls: &Walls, seeds: &[[f64; 3]], options: &ExpandOptions) -> Expanded {
    let f = surface(text);
    let seeds: Vec<Point3> = seeds.iter().map(|s| Point3::new(s[0], s[1], s[2])).collect();
    let made = expand(&f, f.polynomial().unwrap(), &bounds(b), walls, &seeds, options).unwrap();
    println!("walls used {} of {}", walls.points.iter().enumerate().filter(|(i, _)| made.triangles.iter().any(|t| t.contains(&(*i as u32)))).count(), walls.points.len());
    println!("{text} {:?} {} triangles {:?}", options.approach, made.triangles.len(), made.check);
    made
}

const BOTH: [Approach; 2] = [Approach::Edge, Approach::Vertex];

fn cone() -> Walls {
    let mut walls = Walls::default();
    walls.add_point(Point3::zeros());
    walls
}

fn line(from: Point3, to: Point3) -> Vec<Point3> {
    (0..=200).map(|i| from + (to - from) * (f64::from(i) / 200.0)).collect()
}

fn whitney(h: f64) -> Walls {
    let mut walls = Walls::default();
    let ends = [walls.add_point(Point3::zeros()), walls.add_point(Point3::new(0.0, 3.0, 0.0))];
    walls.add_arc(ends, &line(Point3::zeros(), Point3::new(0.0, 3.0, 0.0)), h, 2);
    walls
}

fn steiner(h: f64) -> Walls {
    let mut walls = Walls::default();
    let center = walls.add_point(Point3::zeros());
    for axis in 0..3 {
        for s in [-2.0, 2.0] {
            let tip = Point3::ith(axis, s);
            let end = walls.add_point(tip);
            walls.add_arc([center, end], &line(Point3::zeros(), tip), h, 2);
        }
    }
    walls
}

fn toroidal(h: f64) -> Walls {
    let mut walls = Walls::default();
    let at = |t: f64| Point3::new(0.0, 2.0 * t.cos(), 2.0 * t.sin());
    let samples: Vec<Point3> = (0..=400).map(|i| at(f64::from(i) / 400.0 * std::f64::consts::TAU)).collect();
    let first = walls.add_point(samples[0]);
    walls.add_arc([first, first], &samples, h, 3);
    walls
}

const BOX: [f64; 6] = [-3.0, 3.0, -3.0, 3.0, -2.0, 2.0];
const WHITNEY: &str = "x^2 - y z^2";
const STEINER: &str = "x^2 y^2 + y^2 z^2 + z^2 x^2 - 4 x y z";
const TOROIDAL: &str = "(y^2 + z^2 - x^2 + 0.5 x^3 - 4)^2 - 16 x^2 + 8 x^3";

#[test]
fn one() {
        let approach = if std::env::var("EDGE").is_ok() { Approach::Edge } else { Approach::Vertex };
        let env = |k: &str, d: f64| std::env::var(k).map_or(d, |v| v.parse().unwrap());
        let options = ExpandOptions { approach, longest: env("LONG", 0.12), turn: env("TURN", 0.7), segment: env("SEG", 0.06), epsilon: env("EPS", 0.01), ..ExpandOptions::default() };
        let h = env("H", 0.4);
        match std::env::var("WHAT").unwrap().as_str() {
            "cone" => run("x^2+y^2-z^2", BOX, &cone(), &[[1.0, 0.0, 1.0]], &options),
            "whitney" => run(WHITNEY, BOX, &whitney(h), &[[1.0, 1.0, 1.0]], &options),
            "steiner" => run(STEINER, BOX, &steiner(h), &[[4.0/3.0, 4.0/3.0, 4.0/3.0]], &options),
            _ => run(TOROIDAL, [-1.2, 4.0, -4.0, 4.0, -4.0, 4.0], &toroidal(h), &[[1.0, 2.0 + 0.5f64.sqrt(), 0.0]], &options),
        };
}

#[test]
fn try_all() {
    for approach in BOTH {
        let options = ExpandOptions { approach, ..ExpandOptions::default() };
        run("x^2+y^2+z^2-1", [-2.0, 2.0, -2.0, 2.0, -2.0, 2.0], &Walls::default(), &[[1.0, 0.0, 0.0]], &options);
        run("(x^2+y^2+z^2+3)^2-16*(x^2+y^2)", [-4.0, 4.0, -4.0, 4.0, -2.0, 2.0], &Walls::default(), &[[3.0, 0.0, 0.0]], &options);
        run("x^2+y^2-z^2", BOX, &cone(), &[[1.0, 0.0, 1.0]], &options);
        run(WHITNEY, BOX, &whitney(0.4), &[[1.0, 1.0, 1.0]], &options);
        run(STEINER, BOX, &steiner(0.4), &[[4.0/3.0, 4.0/3.0, 4.0/3.0]], &options);
        run(TOROIDAL, [-1.2, 4.0, -4.0, 4.0, -4.0, 4.0], &toroidal(0.6), &[[1.0, 2.0 + 0.5f64.sqrt(), 0.0]], &options);
    }
}
