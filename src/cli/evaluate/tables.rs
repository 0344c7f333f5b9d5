//! The tables of `evaluate nodes`, in Markdown.

use super::Figures;
use lattice_brep::evaluate::{Deviation, Measured, Patches};

/// Places of our own film and of Savio's among the readings: `Reading::USUAL`.
const OURS: usize = 0;
const SAVIO: usize = 1;

/// All tables.
pub fn all(figures: &[Figures]) -> String {
    [deviations(figures), against(figures), factors(figures), fairness(figures)].join("\n")
}

impl Figures {
    /// The patches of a reading on all nodes that have them.
    fn patches(&self, reading: usize) -> Vec<&Patches> {
        self.nodes.iter().filter_map(|n| n.patches[reading].as_ref()).collect()
    }

    /// Each kind of surface with the deviations of all nodes that have it.
    fn surfaces(&self) -> Vec<(String, Vec<Deviation>)> {
        let of = |(k, name): (usize, &&str)| {
            let films = self.nodes.iter().filter_map(|n| n.films[k].map(|f| f.deviation)).collect();
            let patches = self.patches(k).iter().map(|p| p.deviation).collect();
            [(format!("{name}, mesh"), films), (format!("{name}, patches"), patches)]
        };
        self.readings.iter().enumerate().flat_map(of).filter(|(_, list): &(String, Vec<Deviation>)| !list.is_empty()).collect()
    }
}

/// Max, Avg and Std.
fn three(list: &[Deviation]) -> [Spread; 3] {
    let of = |figure: fn(&Deviation) -> f64| Spread::new(list.iter().map(figure));
    [of(|d| d.max), of(|d| d.avg), of(|d| d.std)]
}

/// How far Max, Avg and Std are from the paper's: the mean of |ln(ours / paper's)|.
fn off(list: &[Deviation], paper: &[f64; 3]) -> f64 {
    three(list).iter().zip(paper).map(|(ours, paper)| (ours.median / paper).ln().abs()).sum::<f64>() / 3.0
}

/// The table of deviations, after Table 1.
fn deviations(figures: &[Figures]) -> String {
    let mut out =
        String::from("| set | surface | nodes | Max mm | Avg mm | Std mm | most outside | most inside | factor |\n|---|---|---|---|---|---|---|---|---|\n");
    for set in figures {
        for (row, figures) in [("Table 1", set.paper), ("Table 1, Savio", set.savio)] {
            let [max, avg, std] = figures.map(|x| format!("{x:.4}"));
            out += &format!("| {} | {row} | 1 | {max} | {avg} | {std} | | | |\n", set.set);
        }
        for (surface, list) in set.surfaces() {
            let sides: [fn(&Deviation) -> f64; 2] = [|d| d.max_outside, |d| d.max_inside];
            let sides = sides.map(|figure| Spread::new(list.iter().map(figure)));
            let columns = three(&list).iter().chain(&sides).map(|s| s.text(4)).collect::<Vec<_>>().join(" | ");
            out += &format!("| {} | {surface} | {} | {columns} | {:.2} |\n", set.set, list.len(), off(&list, &set.paper).exp());
        }
    }
    out + "\nFactor: exp of the mean |ln(ours / paper's)| of Max, Avg and Std: 1 where they agree. Of several nodes: median (least to largest).\n"
}

/// The table of our patches against the paper's figures, and against Savio's method node by node.
fn against(figures: &[Figures]) -> String {
    let mut out = String::from(
        "| set | our patches: Max / paper's | Avg / paper's | Savio's mesh: Avg / ours | nodes where ours is less: Max | Avg | Std |\n|---|---|---|---|---|---|---|\n",
    );
    for set in figures {
        let ours: Vec<Deviation> = set.patches(OURS).iter().map(|p| p.deviation).collect();
        let [max, avg, _] = [0, 1, 2].map(|k| three(&ours)[k].median / set.paper[k]);
        let pairs: Vec<(Deviation, Deviation)> = set.nodes.iter().filter_map(both).collect();
        let ratio = Spread::new(pairs.iter().map(|(ours, savio)| savio.avg / ours.avg)).text(1);
        let less = |figure: fn(&Deviation) -> f64| pairs.iter().filter(|(ours, savio)| figure(ours) < figure(savio)).count();
        let less = [less(|d| d.max), less(|d| d.avg), less(|d| d.std)].map(|n| format!("{n} of {}", set.nodes.len())).join(" | ");
        out += &format!("| {} | {max:.2} | {avg:.2} | {ratio} | {less} |\n", set.set);
    }
    out
}

/// Deviations of our patches and of Savio's film.
fn both(node: &Measured) -> Option<(Deviation, Deviation)> {
    Some((node.patches[OURS].as_ref()?.deviation, node.films[SAVIO]?.deviation))
}

/// The table of mean factors over all regular and over all irregular sets.
fn factors(figures: &[Figures]) -> String {
    let mut out = String::from("| surface | factor, regular sets | factor, irregular sets |\n|---|---|---|\n");
    let names: Vec<String> = figures.first().map(|set| set.surfaces().into_iter().map(|s| s.0).collect()).unwrap_or_default();
    for name in names {
        let mean = |regular: bool| {
            let sets = || figures.iter().filter(|set| set.least_angle.is_none() == regular);
            let offs: Vec<f64> = sets().flat_map(|set| set.surfaces().into_iter().filter(|s| s.0 == name).map(|s| off(&s.1, &set.paper))).collect();
            if offs.is_empty() || offs.len() < sets().count() { String::new() } else { format!("{:.2}", (offs.iter().sum::<f64>() / offs.len() as f64).exp()) }
        };
        out += &format!("| {name} | {} | {} |\n", mean(true), mean(false));
    }
    out
}

/// The table of curvatures. Savio's film has no patches.
fn fairness(figures: &[Figures]) -> String {
    let mut out = String::from(
        "| set | patches on | not fitted | Avg mm | 99 % of \\|H\\| r, mesh | 99 % of \\|H\\| r | largest \\|H\\| r | least concave radius, r | 99 % of it | thin plate | by area, r² | variation, r² | largest jump, r |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for set in figures {
        for (k, reading) in set.readings.iter().enumerate() {
            let built = set.patches(k);
            let of = |figure: fn(&Patches) -> f64, digits| Spread::new(built.iter().map(|p| figure(p))).text(digits);
            let columns = [
                of(|p| p.deviation.avg, 4),
                Spread::new(set.nodes.iter().filter_map(|n| n.films[k]).map(|f| f.usual_mean_curvature)).text(2),
                of(|p| p.usual_mean_curvature, 2),
                of(|p| p.max_mean_curvature, 1),
                of(|p| p.least_concave_radius, 4),
                of(|p| p.usual_concave_radius, 4),
                of(|p| p.thin_plate, 1),
                of(|p| p.thin_plate / p.area, 2),
                of(|p| p.variation, 0),
                of(|p| p.max_edge_jump, 2),
            ];
            let failed = if k == SAVIO { "-".to_owned() } else { (set.nodes.len() - built.len()).to_string() };
            out += &format!("| {} | {reading} | {failed} | {} |\n", set.set, columns.join(" | "));
        }
    }
    out
}

/// Median, least and largest of some figures.
struct Spread {
    median: f64,
    least: f64,
    largest: f64,
}

impl Spread {
    /// NaN where there are none.
    fn new(figures: impl Iterator<Item = f64>) -> Spread {
        let mut sorted: Vec<f64> = figures.collect();
        sorted.sort_by(f64::total_cmp);
        let at = |k: usize| sorted.get(k).copied().unwrap_or(f64::NAN);
        let (n, last) = (sorted.len(), sorted.len().saturating_sub(1));
        Spread { median: 0.5 * (at(last / 2) + at(n / 2)), least: at(0), largest: at(last) }
    }

    fn text(&self, digits: usize) -> String {
        let Spread { median, least, largest } = self;
        if median.is_nan() {
            "-".to_owned()
        } else if least == largest {
            format!("{median:.digits$}")
        } else {
            format!("{median:.digits$} ({least:.digits$} to {largest:.digits$})")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_or_between_the_two() {
        let spread = |list: &[f64]| Spread::new(list.iter().copied());
        assert_eq!(spread(&[3.0, 1.0, 2.0]).text(1), "2.0 (1.0 to 3.0)");
        assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]).median, 2.5);
        assert_eq!(spread(&[0.25]).text(2), "0.25");
        assert!(spread(&[]).median.is_nan());
    }

    /// Half of the paper's figures everywhere: a factor of two.
    #[test]
    fn the_factor_is_that_of_the_figures() {
        let half = Deviation { max: 0.5, avg: 0.1, std: 0.2, ..Deviation::default() };
        assert!((off(&[half; 3], &[1.0, 0.2, 0.4]).exp() - 2.0).abs() < 1e-12);
        // one figure twice, one half: they do not cancel
        let mixed = Deviation { max: 2.0, avg: 0.1, std: 0.4, ..Deviation::default() };
        assert!((off(&[mixed], &[1.0, 0.2, 0.4]) - 4f64.ln() / 3.0).abs() < 1e-12);
    }
}
