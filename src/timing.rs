//! `Graph` ▶ time of each node: its smoothing and its whole construction, the columns of Table 2 in Luo & Zou 2025.
//!
//! Smoothing is the fairing of the control mesh (section 3.3.2). Construction is all that export does for a node before solids: the paper's is the film
//! with its subdivision, ours also fits patches, at both degrees where the first misses the tolerance, and checks them.

use crate::error::Error;
use crate::graph::Graph;
use crate::ids::NodeId;
use crate::ladder::{self, Degrees};
use crate::node::cells::SNAP;
use crate::node::{Cells, Star, fair, film};
use crate::options::Options;
use crate::settle;
use std::time::Duration;

/// What one node takes, ms on one thread: the least of several runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeTime {
    pub degree: usize,
    /// None where no soap film can be faired.
    pub smoothing: Option<f64>,
    pub construction: f64,
}

/// Every node of two or more struts for itself, one after the other, in the order of the nodes.
pub fn nodes(graph: &Graph, options: &Options, runs: u32) -> Result<Vec<NodeTime>, Error> {
    let degrees = Degrees::new();
    let time = |(node, star): (NodeId, &Star)| {
        let (mut built, construction) = least(runs, || ladder::build(star.clone(), options, &degrees));
        if let Err(reasons) = &mut built {
            return Err(settle::cannot_build(graph, &[(node, reasons.as_slice())]));
        }
        Ok(NodeTime { degree: star.degree(), smoothing: smoothing(star, options, runs), construction })
    };
    let stars = settle::negotiated(graph, options)?;
    graph.node_ids().zip(&stars).filter(|(_, star)| star.degree() > 1).map(time).collect()
}

fn smoothing(star: &Star, options: &Options, runs: u32) -> Option<f64> {
    let cells = Cells::joined(star, SNAP).ok()?;
    let fairing = options.fairing.at(star);
    let control = film::mesh_for(star, &cells, fairing);
    let mut meshes = vec![control; runs as usize]; // copied before the clock runs
    let (faired, time) = least(runs, || fair::fair(&mut meshes.pop().expect("one a run"), star, fairing, fair::HOLD));
    faired.ok().map(|()| time)
}

/// What the last of so many runs gave, and the least time of all, ms.
fn least<T>(runs: u32, mut work: impl FnMut() -> T) -> (T, f64) {
    let mut timed = || {
        let start = now();
        let done = work();
        (done, 1e3 * (now() - start).as_secs_f64())
    };
    (1..runs).fold(timed(), |(_, least), _| {
        let (done, time) = timed();
        (done, least.min(time))
    })
}

/// CPU time of this thread: other programs do not lengthen it.
#[cfg(unix)]
fn now() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Where there is no such clock: that on the wall.
#[cfg(not(unix))]
fn now() -> Duration {
    use std::{sync::OnceLock, time::Instant};
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}
