use isopatch::{field::*, geom::*, inspect::*, recipes::spline::*};
fn main() {
    let all: [(&str, &str, [f64; 3], usize); 7] = [
        ("sphere", "x^2+y^2+z^2-1", [1.3, 1.3, 1.3], 0),
        ("torus", "(sqrt(x^2+y^2)-5)^2+z^2-1", [6.4, 6.4, 1.4], 600),
        ("dodeca", "x^6+y^6+z^6+20(x^4y^2+y^4z^2+z^4x^2)-1", [1.2, 1.2, 1.2], 1200),
        ("dtorus", "x^8-2x^6+x^4+2x^4y^2-2x^2y^2+y^4+z^2-0.04", [1.3, 0.9, 0.4], 1800),
        ("mcmullen", "(x^2+1)(y^2+1)(z^2+1)+8xyz-2", [2.2, 2.2, 2.2], 2000),
        ("chair", "(x^2+y^2+z^2-0.95*25)^2-0.8((z-5)^2-2x^2)((z+5)^2-2y^2)", [8., 8., 8.], 4000),
        (
            "decocube",
            "((x^2+y^2-0.64)^2+(z^2-1)^2)((y^2+z^2-0.64)^2+(x^2-1)^2)((z^2+x^2-0.64)^2+(y^2-1)^2)-0.02",
            [1.5, 1.5, 1.5],
            5000,
        ),
    ];
    let a: Vec<String> = std::env::args().collect();
    let evening: usize = a[1].parse().unwrap();
    let tol: f64 = a[2].parse().unwrap();
    for (name, text, b, faces) in all {
        if a.len() > 3 && a[3] != name {
            continue;
        }
        let f = Formula::parse(text, &Constants::new()).unwrap();
        let m = Vec3::from(b);
        let size = if tol > 0. {
            Size::Tolerance(tol)
        } else if faces == 0 {
            Size::Automatic
        } else {
            Size::Faces(faces)
        };
        match fit(
            &f,
            &SplineRecipe { bounds: Some(Aabb::new(-m, m)), size, evening, ..Default::default() },
            &|_| (),
        ) {
            Err(e) => println!("{name}: {e}"),
            Ok(r) => {
                let i = inspect(&r.surface, &r.surface.base, Some(&r.formula), &InspectOptions::default());
                let d = i.deviation.as_ref().unwrap();
                println!(
                    "{name} F {} chi {} | fo {:.2e} {:.2e} back {:.2e} n {:.2} bad {} folded {} jump {:.1e} reached {} | {} {:?} rep {}",
                    i.patches,
                    i.topology.euler,
                    d.max_first_order,
                    d.rms_first_order,
                    i.coverage.map_or(f64::NAN, |c| c.max_distance),
                    d.max_normal_error.to_degrees(),
                    d.over_limit,
                    d.folded,
                    i.seams.max_normal_jump,
                    r.reached,
                    r.seconds.stages().iter().map(|s| format!("{} {:.3} ", s.0, s.1)).collect::<String>(),
                    r.figures.sqp_iterations_mean,
                    r.repairs.len()
                );
            }
        }
    }
}
