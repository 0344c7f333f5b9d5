//! Points in parts of neighbours: halved again and again, across the longest side of the box around them.

use glam::DVec3;

/// Hands over so many parts (1 or more, at most as many as there are points) of nearly the same number; `all` are positions in `places`.
/// The same places give the same parts.
pub fn split(all: &mut [usize], places: &[DVec3], parts: usize, take: &mut impl FnMut(&[usize])) {
    if parts == 1 {
        return take(all);
    }
    let (low, high) = all.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &k| (low.min(places[k]), high.max(places[k])));
    let axis = (high - low).max_position();
    let lower = parts / 2;
    let at = all.len() * lower / parts;
    all.select_nth_unstable_by(at, |&a, &b| places[a][axis].total_cmp(&places[b][axis]).then(a.cmp(&b)));
    let (below, above) = all.split_at_mut(at);
    split(below, places, lower, take);
    split(above, places, parts - lower, take);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_nearly_equal_and_hold_each_point_once() {
        let places: Vec<DVec3> = (0..60).map(|k| DVec3::new((k % 3) as f64, (k / 3 % 4) as f64, (k / 12) as f64)).collect();
        for parts in 1..=60 {
            let mut found = vec![];
            split(&mut (0..60).collect::<Vec<_>>(), &places, parts, &mut |part| found.push(part.to_vec()));
            assert_eq!(found.len(), parts);
            assert!(found.iter().all(|part| (60 / parts..=60usize.div_ceil(parts)).contains(&part.len())), "{parts}: {found:?}");
            let mut all = found.concat();
            all.sort_unstable();
            assert_eq!(all, (0..60).collect::<Vec<_>>());
        }
    }
}
