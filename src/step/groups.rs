//! Instances of an assembly in nested groups of neighbours: readers take a time that grows with the square of what stands under one parent.

use crate::math::halves::split;
use glam::DVec3;
use std::collections::VecDeque;

/// What stands in a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// By position among the instances.
    Instance(usize),
    /// By position among the groups.
    Group(usize),
}

/// The members of each group, at most `most` (2 or more); the first group is the whole assembly, each other is a member of one before it.
/// Neighbours in space are together; the same places give the same groups.
pub fn groups(places: &[DVec3], most: usize) -> Vec<Vec<Member>> {
    let mut groups = vec![];
    let mut waiting = VecDeque::from([(0..places.len()).collect::<Vec<usize>>()]);
    while let Some(mut all) = waiting.pop_front() {
        if all.len() <= most {
            all.sort_unstable();
            groups.push(all.into_iter().map(Member::Instance).collect());
            continue;
        }
        // the most that a group of the next level can hold
        let mut held = most;
        while held * most < all.len() {
            held *= most;
        }
        let first = groups.len() + 1 + waiting.len();
        let before = waiting.len();
        let count = all.len().div_ceil(held);
        split(&mut all, places, count, &mut |part| waiting.push_back(part.to_vec()));
        groups.push((first..first + waiting.len() - before).map(Member::Group).collect());
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(n: usize) -> Vec<DVec3> {
        (0..n * n * n).map(|k| DVec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64)).collect()
    }

    #[test]
    fn all_stand_once_in_groups_that_are_not_too_large() {
        for (n, most) in [(1, 4), (2, 8), (3, 4), (5, 4), (7, 7), (6, 2)] {
            let places = cube(n);
            let groups = groups(&places, most);
            assert!(groups.iter().all(|g| (1..=most).contains(&g.len())));
            let mut instances = vec![0; places.len()];
            let mut parents = vec![0; groups.len()];
            for (k, group) in groups.iter().enumerate() {
                for member in group {
                    match *member {
                        Member::Instance(i) => instances[i] += 1,
                        Member::Group(g) => {
                            assert!(g > k);
                            parents[g] += 1;
                        }
                    }
                }
            }
            assert!(instances.iter().all(|&uses| uses == 1) && parents[0] == 0 && parents[1..].iter().all(|&uses| uses == 1));
        }
    }

    #[test]
    fn few_are_one_group_in_their_order() {
        assert_eq!(groups(&cube(2), 8), [(0..8).map(Member::Instance).collect::<Vec<_>>()]);
    }

    #[test]
    fn neighbours_are_together() {
        let places = cube(8);
        for group in groups(&places, 64).iter().skip(1) {
            let of = |m: &Member| if let Member::Instance(k) = *m { places[k] } else { panic!("two levels are enough") };
            let (low, high) = group.iter().map(of).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
            assert_eq!((group.len(), high - low), (64, DVec3::splat(3.0)));
        }
    }
}
