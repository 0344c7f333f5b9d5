use glam::DVec3;
use lattice_brep::node::{Film, Method, Star, cut};
use lattice_brep::patch::{self, forms::Tables};

fn star(axes: Vec<DVec3>) -> Star {
    let axes: Vec<DVec3> = axes.into_iter().map(|a| a.normalize()).collect();
    let cuts = cut::cuts(&axes, 0.3);
    Star { axes, cuts }
}

fn run(name: &str, s: Star, p: usize, method: Method) {
    let t0 = std::time::Instant::now();
    let film = match Film::build(s, method, Default::default(), 3) { Ok(f) => f, Err(e) => { println!("{name} p{p} FILM {e}"); return; } };
    let t1 = std::time::Instant::now();
    let folded = match &film.shape { lattice_brep::node::Shape::Soap(m) => m.facing(), _ => (1.0, 0) };
    let tables = Tables::new(p);
    let t2 = std::time::Instant::now();
    match patch::fit(&film, &tables) {
        Err(e) => println!("{name} p{p} FAIL {e}"),
        Ok(patch::Fitted { skin, quality: q }) => println!("{name} p{p} deg {} patches {} film {:?}/{:?} fit {:?} facing film {:.3}/{} | jump {:.1e} rim {:.1e} facing {:.3} dev {:.1e}/{:.1e} tilt {:.1}",
        film.star.degree(), skin.patches.len(), t1-t0, match &film.shape { lattice_brep::node::Shape::Soap(m) => m.triangles.0.len(), _ => 0}, t2.elapsed(), folded.0, folded.1, q.jump, q.rim_jump, q.facing, q.deviation, q.mean_deviation, q.tilt),
    }
}

fn rng(state: &mut u64) -> f64 { *state ^= *state << 13; *state ^= *state >> 7; *state ^= *state << 17; (*state >> 11) as f64 / (1u64 << 53) as f64 }

fn random(seed: u64, degree: usize, least: f64) -> Vec<DVec3> {
    let mut st = seed.wrapping_mul(0x9E3779B97F4A7C15) | 1;
    'again: loop {
        let mut axes: Vec<DVec3> = vec![];
        let mut tries = 0;
        while axes.len() < degree {
            tries += 1; if tries > 20000 { continue 'again; }
            let z = 2.0 * rng(&mut st) - 1.0; let a = 6.283185307 * rng(&mut st);
            let r = (1.0 - z * z).sqrt(); let u = DVec3::new(r * a.cos(), r * a.sin(), z);
            if axes.iter().all(|v| v.dot(u) < least.to_radians().cos()) { axes.push(u); }
        }
        return axes;
    }
}

#[test]
fn shapes() {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut cube = vec![]; for x in [-1., 1.] { for y in [-1., 1.] { for z in [-1., 1.] { cube.push(v(x, y, z)); } } }
    let oct = vec![v(1., 0., 0.), v(-1., 0., 0.), v(0., 1., 0.), v(0., -1., 0.), v(0., 0., 1.), v(0., 0., -1.)];
    let cases: Vec<(&str, Vec<DVec3>)> = vec![
        ("oct", oct.clone()), ("bcc", cube.clone()), ("bcc+sc", [cube.clone(), oct.clone()].concat()),
        ("tetra", vec![v(1., 1., 1.), v(1., -1., -1.), v(-1., 1., -1.), v(-1., -1., 1.)]),
        ("deg2 straight", vec![v(0., 0., 1.), v(0., 0., -1.)]), ("deg2 90", vec![v(1., 0., 0.), v(0., 0., 1.)]), ("deg2 160", vec![v(1., 0., 0.), v(160f64.to_radians().cos(), 160f64.to_radians().sin(), 0.)]),
        ("deg2 20", vec![v(1., 0., 0.), v(20f64.to_radians().cos(), 20f64.to_radians().sin(), 0.)]),
        ("deg3 120", vec![v(1., 0., 0.), v(-0.5, 0.75f64.sqrt(), 0.), v(-0.5, -0.75f64.sqrt(), 0.)]),
        ("T", vec![v(1., 0., 0.), v(-1., 0., 0.), v(0., 1., 0.)]), ("cross", oct[..4].to_vec()),
        ("corner3", vec![oct[0], oct[2], oct[4]]), ("edge4", vec![oct[0], oct[1], oct[2], oct[4]]), ("face5", oct[..5].to_vec()),
        ("fan 0/40/80", [0f64, 40., 80.].iter().map(|a| v(a.to_radians().cos(), a.to_radians().sin(), 0.)).collect()),
        ("half 20", [0f64, 120., 240.].iter().map(|a| { let p = 20f64.to_radians(); v(p.sin() * a.to_radians().cos(), p.sin() * a.to_radians().sin(), p.cos()) }).collect()),
        ("pair10+4", vec![v(1., 0., 0.), v(10f64.to_radians().cos(), 10f64.to_radians().sin(), 0.), oct[1], oct[3], oct[4], oct[5]]),
    ];
    for (name, axes) in cases {
        for p in [6, 7] { run(name, star(axes.clone()), p, Method::SoapFilm); }
        run(name, star(axes), 6, Method::LevelSet);
    }
    for (d, a) in [(4, 40.), (6, 35.), (6, 15.), (12, 25.), (12, 12.), (20, 20.), (20, 10.), (30, 14.), (40, 14.)] {
        for seed in 1..4 { run(&format!("random {seed} {a}"), star(random(seed, d, a)), 6, Method::SoapFilm); }
    }
}
