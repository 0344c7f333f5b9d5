//! Ends that are in one place become one node, for formats that give ends and not nodes.

use super::draft::Draft;
use super::limits::ONE_END;
use glam::DVec3;
use std::collections::HashMap;

/// Join the draft's nodes that are equal or nearer than `ONE_END` of the bounding box's diagonal: each goes to the first
/// such node before it. A note says how many, and how far apart they were at most.
pub fn ends(draft: &mut Draft) {
    let nodes = draft.positions();
    let usable = || nodes.iter().copied().filter(|p| p.is_finite());
    let Some((low, high)) = usable().reduce(DVec3::min).zip(usable().reduce(DVec3::max)) else { return };
    // cells as wide as the tolerance: whatever is near enough is in the same cell or one beside it
    let apart = ONE_END * low.distance(high);
    // a box so small that its diagonal is 0 in doubles has cells beyond all integers: they saturate, and the checks refuse such nodes
    let cell = |p: DVec3| ((p - low) / apart.max(f64::MIN_POSITIVE)).floor().as_i64vec3().to_array();
    let mut kept: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut to: Vec<u32> = (0..draft.node_count()).collect();
    let (mut count, mut farthest) = (0, 0.0f64);
    for (n, &p) in nodes.iter().enumerate().filter(|(_, p)| p.is_finite()) {
        let [x, y, z] = cell(p);
        let around =
            (-1..=1).flat_map(|dx| (-1..=1).flat_map(move |dy| (-1..=1).map(move |dz| [x.saturating_add(dx), y.saturating_add(dy), z.saturating_add(dz)])));
        let near = around.filter_map(|c| kept.get(&c)).flatten().copied().filter(|&m| nodes[m as usize].distance(p) <= apart);
        match near.min() {
            Some(first) => {
                to[n] = first;
                count += 1;
                farthest = farthest.max(nodes[first as usize].distance(p));
            }
            None => kept.entry([x, y, z]).or_default().push(n as u32),
        }
    }
    if count == 0 {
        return;
    }
    let how = if farthest > 0.0 { format!("at most {farthest:e} mm apart") } else { "equal in all digits".to_owned() };
    let what = format!("{} ends are {} nodes: ends in one place are joined ({how})", nodes.len(), nodes.len() - count);
    draft.join(&to);
    draft.note("document", what);
}
