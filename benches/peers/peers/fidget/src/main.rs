//! Fidget: machine code for the formula, and manifold dual contouring in an octree of the asked depth, on one thread.

use cpu_time::ProcessTime;
use fidget::context::Tree;
use fidget::jit::JitShape;
use fidget::mesh::{Mesh, Octree, Settings};
use peer_fields::number::Number;
use peer_fields::shape::write_mesh;
use peer_fields::surface::Surface;
use std::error::Error;
use std::io::{self, BufRead, Write};
use std::ops::{Add, Mul, Sub};
use std::time::Instant;

/// An expression of fidget.
#[derive(Clone)]
struct Expression(Tree);

impl Add for Expression {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}
impl Sub for Expression {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}
impl Mul for Expression {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}
impl Number for Expression {
    fn constant(value: f64) -> Self {
        Self(Tree::constant(value as f32))
    }
    fn square(&self) -> Self {
        Self(self.0.square())
    }
    fn sqrt(&self) -> Self {
        Self(self.0.sqrt())
    }
}

/// The mesh in the cube around the box.
fn solve(surface: Surface, half: f64, depth: u8) -> Result<Mesh, Box<dyn Error>> {
    let tree = surface.value([Tree::x(), Tree::y(), Tree::z()].map(Expression)).0;
    let shape = JitShape::from(tree).try_into()?;
    let world_to_model = nalgebra::Matrix4::new_scaling(half as f32);
    let settings = Settings { depth, world_to_model, threads: None, ..Settings::default() };
    Ok(Octree::build(&shape, &settings).ok_or("no octree")?.walk_dual())
}

fn answer(line: &str) -> Result<String, Box<dyn Error>> {
    let words: Vec<&str> = line.trim_end().split('\t').collect();
    let [name, _, bounds, depth, output] = words[..] else { return Err("a request has five words".into()) };
    let surface = Surface::named(name).ok_or("no such surface")?;
    let sides: Vec<f64> = bounds.split(' ').map(str::parse).collect::<Result<_, _>>()?;
    let half = sides.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let depth = depth.parse::<f64>()? as u8;
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let mesh = solve(surface, half, depth)?;
    let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    if output != "-" {
        let points = mesh.vertices.iter().map(|p| [p.x, p.y, p.z].map(f64::from));
        let triangles = mesh.triangles.iter().map(|t| [t.x, t.y, t.z].map(|k| k as u32));
        write_mesh(output, points, triangles)?;
    }
    let [points, triangles] = [mesh.vertices.len(), mesh.triangles.len()];
    let bytes = 12 * (points + triangles);
    Ok(format!("seconds={cpu}\twall={wall}\tbytes={bytes}\tfile=0\telements={triangles}"))
}

fn main() -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "ready")?;
    for line in io::stdin().lock().lines() {
        let text = answer(&line?).unwrap_or_else(|error| format!("error={error}"));
        writeln!(out, "{text}")?;
        out.flush()?;
    }
    Ok(())
}
