//! Graph layer: `bytes ▶ Graph`. Readers, unit cells, and checks that return all faults.
//!
//! In: a file of any format that `import` knows (`json` is our own form), or the name of a unit cell (`catalogue`). Out: a `Graph` in mm that has passed `check`:
//! at least one strut, all ends in range, no two nodes in one place, no two struts between the same nodes,
//! and no two struts closer than their radii except where they share a node.
//! Ids are the positions in the input, so a node without struts keeps its id: skip nodes of degree 0.
//! Between the two, if asked for: `repair`.
//! Not promised: that the cuts fit into the struts. That is the cuts layer's to say.

pub mod catalogue;
pub mod check;
pub mod components;
pub mod crop;
pub mod import;
pub mod json;
pub mod proximity;
pub mod repair;

use crate::error::{Error, Note};
use crate::ids::{NodeId, StrutId};
use glam::DVec3;
use std::f64::consts::PI;

/// What a text says, not yet checked: ends may be out of range, numbers may be NaN. Lengths in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Input {
    pub name: Option<String>,
    pub nodes: Vec<DVec3>,
    pub struts: Vec<Strut>,
}

/// A checked graph, its name, and what was left out or changed on the way in.
#[derive(Clone, Debug)]
pub struct Lattice {
    pub name: Option<String>,
    pub graph: Graph,
    pub notes: Vec<Note>,
}

/// Read and check the JSON form; on failure all faults, of form and of content, at once.
pub fn read(bytes: &[u8]) -> Result<Lattice, Error> {
    read_with(bytes, check::Overlaps::Refuse)
}

/// As `read`, with a say on struts that overlap away from their nodes.
pub fn read_with(bytes: &[u8], overlaps: check::Overlaps) -> Result<Lattice, Error> {
    let (input, faults) = json::read(bytes);
    check::admit(input, faults, overlaps)
}

/// A strut: two node indices and a radius at each end (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strut {
    pub a: NodeId,
    pub b: NodeId,
    pub ra: f64,
    pub rb: f64,
}

impl Strut {
    /// Volume from node to node (mm³) of a strut of this length (mm): a truncated cone.
    pub fn volume(&self, length: f64) -> f64 {
        PI / 3.0 * length * (self.ra * self.ra + self.ra * self.rb + self.rb * self.rb)
    }
}

/// Which end of a strut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum End {
    A,
    B,
}

/// One strut seen from one of its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arm {
    pub strut: StrutId,
    pub end: End,
}

/// A lattice graph that has passed the structural checks. Lengths in mm.
#[derive(Clone, Debug)]
pub struct Graph {
    nodes: Vec<DVec3>,
    struts: Vec<Strut>,
    /// Arms of node n: `arms[first[n]..first[n + 1]]`, ordered by strut id.
    first: Vec<u32>,
    arms: Vec<Arm>,
}

impl Graph {
    /// Build the incidence lists. The caller has checked that all indices are in range.
    pub fn new(nodes: Vec<DVec3>, struts: Vec<Strut>) -> Self {
        let mut first = vec![0u32; nodes.len() + 1];
        for s in &struts {
            first[s.a.index() + 1] += 1;
            first[s.b.index() + 1] += 1;
        }
        for n in 0..nodes.len() {
            first[n + 1] += first[n];
        }
        let mut next = first.clone();
        let mut arms = vec![Arm { strut: StrutId(0), end: End::A }; 2 * struts.len()];
        for (k, s) in struts.iter().enumerate() {
            for (node, end) in [(s.a, End::A), (s.b, End::B)] {
                let at = &mut next[node.index()];
                arms[*at as usize] = Arm { strut: StrutId(k as u32), end };
                *at += 1;
            }
        }
        Graph { nodes, struts, first, arms }
    }

    /// Node positions (mm), indexed by `NodeId`.
    pub fn nodes(&self) -> &[DVec3] {
        &self.nodes
    }

    /// Struts, indexed by `StrutId`.
    pub fn struts(&self) -> &[Strut] {
        &self.struts
    }

    /// The arms of a node, ordered by strut id.
    pub fn arms(&self, node: NodeId) -> &[Arm] {
        let (i, j) = (self.first[node.index()], self.first[node.index() + 1]);
        &self.arms[i as usize..j as usize]
    }

    /// Number of struts at a node.
    pub fn degree(&self, node: NodeId) -> usize {
        self.arms(node).len()
    }

    /// The nodes that have struts, in order: those the solid is made of.
    pub fn used_nodes(&self) -> impl Iterator<Item = NodeId> {
        self.node_ids().filter(|&n| self.degree(n) > 0)
    }

    /// All node ids in order.
    pub fn node_ids(&self) -> impl Iterator<Item = NodeId> + use<> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    /// The node at this end of the strut.
    pub fn near(&self, arm: Arm) -> NodeId {
        let s = &self.struts[arm.strut.index()];
        if arm.end == End::A { s.a } else { s.b }
    }

    /// The node at the other end of the strut.
    pub fn far(&self, arm: Arm) -> NodeId {
        let s = &self.struts[arm.strut.index()];
        if arm.end == End::A { s.b } else { s.a }
    }

    /// The radius at this end of the strut (mm).
    pub fn radius(&self, arm: Arm) -> f64 {
        let s = &self.struts[arm.strut.index()];
        if arm.end == End::A { s.ra } else { s.rb }
    }

    /// The largest radius of the struts at a node (mm): the node's unit of length.
    pub fn largest_radius(&self, node: NodeId) -> f64 {
        self.arms(node).iter().map(|&arm| self.radius(arm)).fold(0.0, f64::max)
    }

    /// How much the strut's radius grows per unit of length away from this end.
    pub fn taper(&self, arm: Arm) -> f64 {
        let s = &self.struts[arm.strut.index()];
        let growth = (s.rb - s.ra) / self.length(arm.strut);
        if arm.end == End::A { growth } else { -growth }
    }

    /// The strut's radius (mm) at a distance (mm) from this end's node; linear along the strut.
    pub fn radius_at(&self, arm: Arm, distance: f64) -> f64 {
        let s = &self.struts[arm.strut.index()];
        let (near, far) = if arm.end == End::A { (s.ra, s.rb) } else { (s.rb, s.ra) };
        near + (far - near) * (distance / self.length(arm.strut))
    }

    /// The larger of the strut's two radii (mm).
    pub fn widest(&self, strut: StrutId) -> f64 {
        let s = &self.struts[strut.index()];
        s.ra.max(s.rb)
    }

    /// The strut's length (mm).
    pub fn length(&self, strut: StrutId) -> f64 {
        let s = &self.struts[strut.index()];
        self.nodes[s.a.index()].distance(self.nodes[s.b.index()])
    }
}
