use isopatch::base::BaseMesh;
use isopatch::inspect::seams;
use isopatch::io::read::read_mesh;
use isopatch::mesh::{HalfEdgeMesh, prepare};
use isopatch::network::{CurveOptions, interpolate_edges};
use isopatch::spline::{fill, normal_deviations};
use std::time::Instant;

fn main() {
    for path in std::env::args().skip(1) {
        let name = path.rsplit('/').next().unwrap().to_owned();
        let mesh = match read_mesh(path.as_ref()) { Ok(m) => m, Err(e) => { println!("{name} {e}"); continue } };
        let p = match prepare(&mesh.positions, &mesh.faces, &Default::default()) { Ok(m) => m, Err(e) => { println!("{name} {e}"); continue } };
        let mut faces = Vec::new();
        for f in &p.faces { for i in 2..f.len() { faces.push([f[0], f[i-1], f[i]]); } }
        let he = HalfEdgeMesh::from_faces(p.positions.len(), &faces).unwrap();
        let start = Instant::now();
        let mut base = BaseMesh::estimated(he, p.positions);
        let var = |n: &str, d: f64| std::env::var(n).map_or(d, |v| v.parse().unwrap());
        let w = isopatch::base::Weights { epsilon: var("EPS", 1e-3), prior: var("PRIOR", 1e-3), sweeps: var("SWEEPS", 20.) as usize };
        if w.sweeps > 0 { base.curvatures = isopatch::base::compatible_curvatures(&base, &w); }
        let invisible = base.mesh.faces().filter(|f| { let t = base.mesh.triangle(*f); let q = t.map(|v| base.positions[v.index()]);
            let n = (q[1]-q[0]).cross(&(q[2]-q[0])); t.iter().any(|v| n.dot(&base.normals[v.index()]) <= 0.0) }).count();
        let curves = interpolate_edges(&base, &CurveOptions::default());
        let curves = match curves { Ok(c) => c, Err(e) => { println!("{name} faces {} invisible {invisible}: {e}", faces.len()); continue } };
        let bound = curves.iter().filter(|c| c.at_bound).count();
        let d = base.diagonal();
        let s = match fill(base, &curves) { Ok(s) => s, Err(e) => { println!("{name} {e}"); continue } };
        let t = start.elapsed().as_secs_f64();
        let dev = normal_deviations(&s, 10);
        let folds = dev.iter().filter(|d| **d >= std::f64::consts::FRAC_PI_2).count();
        let m = seams(&s, d, 33);
        let over = |deg: f64| dev.iter().filter(|d| **d > deg.to_radians()).count();
        println!("{name:40} faces {:6} open {} invisible {invisible} at bound {bound} folds {folds} >20 {} >40 {} jump {:.1e} {t:.3} s", faces.len(), !s.base.mesh.is_closed(), over(20.), over(40.), m.max_normal_jump);
    }
}
