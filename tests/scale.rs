//! Scale and place: the same lattice in micrometres or metres, or far from the origin, becomes the same solid.

use glam::DVec3;
use lattice_brep::graph::check::{Overlaps, admit};
use lattice_brep::graph::{Input, json};
use lattice_brep::options::Options;
use lattice_brep::pipeline::{Silent, solve};
use lattice_brep::report::Report;

/// The shipped irregular example, all lengths times `scale`, moved by `by` (mm) along each axis.
fn placed(scale: f64, by: f64) -> Input {
    let (mut input, _) = json::read(include_bytes!("examples/irregular.json"));
    input.nodes.iter_mut().for_each(|p| *p = *p * scale + DVec3::splat(by));
    input.struts.iter_mut().for_each(|s| (s.ra, s.rb) = (s.ra * scale, s.rb * scale));
    input
}

fn report(input: Input) -> Report {
    let lattice = admit(input, vec![], Overlaps::Refuse).unwrap();
    solve(&lattice, &Options::default(), &Silent).map(|solved| solved.report).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn volume_and_counts_do_not_depend_on_scale_and_place() {
    let plain = report(placed(1.0, 0.0));
    // 1e6 mm away a step of doubles is 1e-10 mm: 1e-7 of the radius of the smallest one here, and the bound with it
    for (scale, by, bound) in [(1e-3, 0.0, 1e-9), (1e3, 0.0, 1e-9), (1.0, 1e6, 1e-9), (1e3, 1e6, 1e-9), (1e-3, 1e6, 1e-6), (1e-6, 0.0, 1e-9)] {
        let other = report(placed(scale, by));
        assert_eq!(other.counts, plain.counts, "scaled by {scale}, moved by {by}");
        let off = (other.volume_mm3 / scale.powi(3) / plain.volume_mm3 - 1.0).abs();
        assert!(off < bound, "volume off by {off:e}, scaled by {scale}, moved by {by}");
        let valley = |report: &Report| report.concave_radius_mm.clone().expect("every node has valleys");
        assert_eq!(valley(&other).place, valley(&plain).place);
        for (name, found, wanted) in [
            ("added", other.added_mm3 / scale.powi(3), plain.added_mm3),
            ("removed", other.removed_mm3 / scale.powi(3), plain.removed_mm3),
            ("tightest valley", valley(&other).value / scale, valley(&plain).value),
        ] {
            assert!(wanted > 0.0 && (found / wanted - 1.0).abs() < 1e3 * bound, "{name}: {found}, wanted {wanted}, scaled by {scale}, moved by {by}");
        }
    }
}
