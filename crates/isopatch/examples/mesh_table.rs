//! scratch
use isopatch::inspect::seams;
use isopatch::io::read::read_mesh;
use isopatch::recipes::mesh_spline::{MeshSplineRecipe, fit};
use std::time::Instant;

fn main() {
    for path in std::env::args().skip(1) {
        let name = path.rsplit('/').next().unwrap().to_owned();
        let mesh = match read_mesh(path.as_ref()) {
            Ok(m) => m,
            Err(e) => {
                println!("{name} {e}");
                continue;
            }
        };
        let start = Instant::now();
        let var = |n: &str, d: f64| std::env::var(n).map_or(d, |v| v.parse().unwrap());
        let recipe = MeshSplineRecipe {
            sharpenings: var("SHARPENINGS", 20.) as usize,
            crease_angle: std::env::var("CREASE").ok().map(|a| a.parse::<f64>().unwrap().to_radians()),
            ..MeshSplineRecipe::default()
        };
        let fitted = match fit(&mesh, &recipe, &|_| ()) {
            Ok(f) => f,
            Err(e) => {
                println!("{name:30} {} faces: {e} {:.2}", mesh.faces.len(), start.elapsed().as_secs_f64());
                continue;
            }
        };
        let t = start.elapsed().as_secs_f64();
        let (s, dev) = (&fitted.surface, &fitted.normal_deviations);
        let m = seams(s, s.base.diagonal(), 33);
        let over = |deg: f64| dev.iter().filter(|d| **d > deg.to_radians()).count();
        println!(
            "{name:40} faces {:6} open {} >20 {} >40 {} >60 {} jump {:.1e} {t:.3} s {}",
            s.nets.len(),
            !s.base.mesh.is_closed(),
            over(20.),
            over(40.),
            over(60.),
            m.max_normal_jump,
            fitted.repairs.iter().map(|r| r.what.clone()).collect::<Vec<_>>().join("; ")
        );
        if let Ok(dir) = std::env::var("PLY") {
            let mesh = isopatch::tessellate::tessellate(
                s,
                &isopatch::tessellate::TessellateOptions { resolution: 8 },
            )
            .unwrap();
            let mut out = std::fs::File::create(format!("{dir}/{name}.ply")).unwrap();
            isopatch::io::ply::write_ply(&mesh, &mut out).unwrap();
        }
    }
}
