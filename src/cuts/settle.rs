//! Which cuts, among those that fit: nearest to the preferred ones, by as few means as will do.
//!
//! 1. Preferred cuts where a strut has room for them.
//! 2. Smaller λ: both cuts of a strut come down by one part of the way to touching caps; it concerns no other strut.
//! 3. Unequal cuts: a strut too short even for that keeps the proportion of its cuts, and its neighbours give way.
//! 4. Unequal sharing: where neighbours cannot give way, the struts of that region settle among themselves, starting from
//!    a solution (`bounds`) and moving towards their wanted cuts as far as the others let them.

use super::Means;
use super::bounds::bounds;
use super::problem::{EndIndex, Problem, SETTLED, across};

/// A strut moves half way each round; after so many what is left of the way is below round-off.
const ROUNDS: usize = 200;

/// Cuts by strut end (mm) and means by strut. The problem has a solution.
pub fn settle(p: &Problem) -> (Vec<f64>, Vec<Means>) {
    let mut cuts = p.preferred.clone();
    let mut short = Vec::new();
    for k in 0..p.struts() {
        let ends = [2 * k, 2 * k + 1];
        if p.fits(k, &cuts) {
            continue;
        }
        let [a, b] = if p.fits(k, &p.touching) {
            between(ends.map(|e| p.touching[e]), ends.map(|e| p.preferred[e]), p.room[k])
        } else {
            short.push(k);
            in_proportion(p, k)
        };
        (cuts[2 * k], cuts[2 * k + 1]) = (a, b);
    }
    let stuck = give_way(p, &short, &mut cuts);
    let wanted = cuts.clone();
    if !stuck.is_empty() {
        region(p, &stuck, &mut cuts);
    }
    let means = (0..p.struts()).map(|k| means(p, k, &cuts, &wanted)).collect();
    (cuts, means)
}

/// The same part of the way from `low` to `high` on both ends, as far as the room goes (mm). `low` fits.
fn between(low: [f64; 2], high: [f64; 2], room: f64) -> [f64; 2] {
    let way = high[0] - low[0] + high[1] - low[1];
    let t = (room - low[0] - low[1]) / way;
    if way <= 0.0 || t >= 1.0 { high } else { [0, 1].map(|k| low[k] + t.max(0.0) * (high[k] - low[k])) }
}

/// Touching cuts, shortened by one factor to the strut's room; no cut below its least.
fn in_proportion(p: &Problem, k: usize) -> [f64; 2] {
    let touching = [2 * k, 2 * k + 1].map(|e| p.touching[e]);
    let least = [2 * k, 2 * k + 1].map(|e| p.least(e));
    let part = if touching[0].is_infinite() { 1.0 } else { touching[0] / (touching[0] + touching[1]) };
    let a = (p.room[k] * part).max(least[0]).min(p.room[k] - least[1]);
    [a, p.room[k] - a]
}

/// Lengthen cuts next to the `short` struts until no caps overlap. Returns the short struts whose neighbours have no room for it.
fn give_way(p: &Problem, short: &[usize], cuts: &mut [f64]) -> Vec<usize> {
    let mut is_short = vec![false; p.struts()];
    let mut stuck = vec![false; p.struts()];
    short.iter().for_each(|&k| is_short[k] = true);
    loop {
        let before = stuck.iter().filter(|&&s| s).count();
        let mut need = vec![0.0f64; p.cones.len()];
        let mut asked = Vec::new();
        let asking: Vec<EndIndex> = short.iter().filter(|&&k| !stuck[k]).flat_map(|&k| [2 * k, 2 * k + 1]).filter(|&e| !p.is_free(e)).collect();
        for &i in &asking {
            let cap = p.cap(i, cuts[i]);
            for (j, angle) in p.beside(i) {
                if !is_short[j / 2] {
                    need[j] = need[j].max(p.cut(j, angle - cap));
                    asked.push(j / 2);
                } else if p.cap(j, cuts[j]) + cap > angle + SETTLED {
                    stuck[i / 2] = true;
                    stuck[j / 2] = true;
                }
            }
        }
        asked.sort_unstable();
        asked.dedup();
        let low = |e: EndIndex| p.touching[e].max(need[e]);
        let full = |k: usize| low(2 * k) + low(2 * k + 1) > p.room[k];
        for &i in &asking {
            let cap = p.cap(i, cuts[i]);
            let blocked = p.beside(i).any(|(j, angle)| !is_short[j / 2] && full(j / 2) && p.cut(j, angle - cap) > p.touching[j]);
            stuck[i / 2] |= blocked;
        }
        if stuck.iter().filter(|&&s| s).count() > before {
            continue;
        }
        for k in asked {
            let ends = [2 * k, 2 * k + 1];
            if ends.iter().any(|&e| need[e] > cuts[e]) {
                let high = ends.map(|e| p.preferred[e].max(need[e]));
                [cuts[2 * k], cuts[2 * k + 1]] = between(ends.map(low), high, p.room[k]);
            }
        }
        return (0..p.struts()).filter(|&k| stuck[k]).collect();
    }
}

/// Settle the region around the stuck struts; all others keep their cuts.
fn region(p: &Problem, stuck: &[usize], cuts: &mut [f64]) {
    let wanted = cuts.to_vec();
    let caps: Vec<f64> = (0..cuts.len()).map(|e| if p.is_free(e) { 0.0 } else { p.cap(e, cuts[e]) }).collect();
    let mut moving = vec![false; p.struts()];
    for &k in stuck {
        moving[k] = true;
        for i in [2 * k, 2 * k + 1] {
            p.beside(i).filter(|&(j, angle)| caps[i] + caps[j] > angle + SETTLED).for_each(|(j, _)| moving[j / 2] = true);
        }
    }
    let bounds = loop {
        let bounds = bounds(p, &moving, &caps);
        let crossed: Vec<usize> = bounds.crossed.iter().map(|c| c.0).collect();
        if crossed.is_empty() || !grow(p, &crossed, &mut moving) {
            break bounds;
        }
    };
    let inside: Vec<EndIndex> = (0..cuts.len()).filter(|&e| moving[e / 2] && !p.is_free(e)).collect();
    let mut now = caps.clone();
    inside.iter().for_each(|&e| now[e] = bounds.middle(e));
    for _ in 0..ROUNDS {
        let next: Vec<f64> = inside.iter().map(|&e| 0.5 * (now[e] + answer(p, e, &now, &wanted))).collect();
        inside.iter().zip(&next).for_each(|(&e, &cap)| now[e] = cap);
    }
    for &e in &inside {
        cuts[e] = if (now[e] - caps[e]).abs() <= SETTLED { wanted[e] } else { p.cut(e, now[e]) };
    }
}

/// The cap of end `e` that its strut would take if all others stayed: wanted cuts, but for what the neighbours need. If all
/// struts go half way at once, caps stay apart (½ (now_i + answer_i + now_j + answer_j) <= Θ) and cuts fit (they are convex in caps).
fn answer(p: &Problem, e: EndIndex, now: &[f64], wanted: &[f64]) -> f64 {
    let need = |e: EndIndex| p.beside(e).map(|(j, angle)| angle - now[j]).fold(f64::INFINITY, f64::min);
    let low = [e, across(e)].map(|e| if p.is_free(e) { 0.0 } else { p.cut(e, need(e)).min(p.cut(e, now[e])) });
    let most = p.room[e / 2] - low[1];
    p.cap(e, wanted[e].max(low[0]).min(most.max(low[0])))
}

/// Add the struts around every part of the region that holds a crossed strut; false if there are none.
fn grow(p: &Problem, crossed: &[usize], moving: &mut [bool]) -> bool {
    let mut seen = vec![false; p.struts()];
    let mut todo: Vec<usize> = crossed.to_vec();
    let mut around = Vec::new();
    crossed.iter().for_each(|&k| seen[k] = true);
    while let Some(k) = todo.pop() {
        for e in [2 * k, 2 * k + 1] {
            for j in p.ends_at(p.node[e]).iter().map(|j| j / 2) {
                if !moving[j] {
                    around.push(j);
                } else if !seen[j] {
                    seen[j] = true;
                    todo.push(j);
                }
            }
        }
    }
    around.iter().for_each(|&k| moving[k] = true);
    !around.is_empty()
}

fn means(p: &Problem, k: usize, cuts: &[f64], wanted: &[f64]) -> Means {
    let ends = [2 * k, 2 * k + 1];
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-9 * p.room[k];
    if ends.iter().all(|&e| cuts[e] == p.preferred[e]) {
        Means::Preferred
    } else if ends.iter().all(|&e| cuts[e] <= p.preferred[e] && (cuts[e] >= p.touching[e] || near(cuts[e], p.touching[e]))) {
        Means::SmallerLambda
    } else if near(cuts[2 * k] + cuts[2 * k + 1], p.room[k]) && ends.iter().any(|&e| !near(cuts[e], wanted[e])) {
        Means::UnequalSharing
    } else {
        Means::UnequalCuts
    }
}
