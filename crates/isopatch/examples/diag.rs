use isopatch::*;
use isopatch::field::Field;
use isopatch::surface::Surface;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let e = gallery::surface(&a[1]).unwrap();
    let formula = e.field().unwrap();
    let recipe = recipes::spline::SplineRecipe { bounds: e.bounds, size: recipes::spline::Size::Faces(a[2].parse().unwrap()), ..Default::default() };
    let fit = recipes::spline::fit(&formula, &recipe, &|_| {}).unwrap();
    let s = &fit.surface;
    let m = &s.base.mesh;
    let d = s.base.diagonal();
    let dist = |p: geom::Point3| { let (f, g) = fit.formula.gradient(p); (f / g.norm() / d).abs() };
    let n = 24;
    let mut rows = vec![];
    for f in m.faces() {
        let (mut inner, mut edge) = (0.0f64, 0.0f64);
        let mut at = [0.0;2];
        for i in 0..=n { for j in 0..=n-i {
            let uv = [i as f64 / n as f64, j as f64 / n as f64];
            let e = dist(s.sample(surface::PatchId(f.0), uv).point);
            if i == 0 || j == 0 || i + j == n { edge = edge.max(e) } else { if e > inner { inner = e; at = uv; } }
        }}
        rows.push((inner.max(edge), inner, edge, f, at));
    }
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    let q = |k: f64, g: &dyn Fn(&(f64,f64,f64,mesh::FaceId,[f64;2])) -> f64| { let mut v: Vec<f64> = rows.iter().map(g).collect(); v.sort_by(f64::total_cmp); v[((v.len()-1) as f64 * k) as usize] };
    println!("{} faces; inner: med {:.1e} p90 {:.1e} p99 {:.1e} max {:.1e}; edge: med {:.1e} p90 {:.1e} p99 {:.1e} max {:.1e}", m.face_count(),
        q(0.5,&|r| r.1), q(0.9,&|r| r.1), q(0.99,&|r| r.1), q(1.0,&|r| r.1), q(0.5,&|r| r.2), q(0.9,&|r| r.2), q(0.99,&|r| r.2), q(1.0,&|r| r.2));
    for (_, inner, edge, f, at) in rows.iter().take(12) {
        let v = m.triangle(*f);
        let x = v.map(|v| s.base.positions[v.index()]);
        let ang: Vec<f64> = (0..3).map(|k| { let (p, q) = (x[(k+1)%3]-x[k], x[(k+2)%3]-x[k]); p.angle(&q).to_degrees() }).collect();
        let len: Vec<f64> = (0..3).map(|k| (x[(k+1)%3]-x[k]).norm()/d).collect();
        let val: Vec<usize> = v.iter().map(|v| m.valence(*v)).collect();
        let k: Vec<f64> = v.iter().map(|v| base::largest_curvature(&s.base.curvatures[v.index()])).collect();
        let kl = k.iter().cloned().fold(0.0,f64::max)*len.iter().cloned().fold(0.0,f64::max)*d;
        println!("face {:5} inner {inner:.2e} edge {edge:.2e} at {:.2} {:.2} angles {:.0?} len {:.3?} valence {:?} kL {kl:.2}", f.0, at[0], at[1], ang, len, val);
    }
}
