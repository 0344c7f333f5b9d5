//! Connected parts of a graph: each becomes one solid. Numbered by their smallest strut id.

use super::{Graph, Strut};
use crate::ids::{NodeId, StrutId};

/// A connected part of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ComponentId(pub u32);

impl ComponentId {
    /// The position in a vector indexed by this id.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// How many nodes and struts a part has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComponentSize {
    pub nodes: usize,
    pub struts: usize,
}

impl ComponentSize {
    /// Number of independent loops: the genus of the part's solid.
    pub fn genus(self) -> usize {
        self.struts + 1 - self.nodes
    }
}

/// The part of each node and strut.
#[derive(Clone, Debug)]
pub struct Components {
    /// Indexed by `NodeId`; none for a node without struts.
    pub of_node: Vec<Option<ComponentId>>,
    /// Indexed by `StrutId`.
    pub of_strut: Vec<ComponentId>,
    /// Indexed by `ComponentId`.
    pub sizes: Vec<ComponentSize>,
}

/// The members of a connected part, ids ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Members {
    pub nodes: Vec<NodeId>,
    pub struts: Vec<StrutId>,
}

impl Components {
    /// Number of parts.
    pub fn count(&self) -> usize {
        self.sizes.len()
    }

    /// The members of each part, indexed by `ComponentId`.
    pub fn members(&self) -> Vec<Members> {
        let mut members = vec![Members::default(); self.count()];
        for (n, id) in self.of_node.iter().enumerate() {
            if let Some(id) = id {
                members[id.index()].nodes.push(NodeId(n as u32));
            }
        }
        for (k, id) in self.of_strut.iter().enumerate() {
            members[id.index()].struts.push(StrutId(k as u32));
        }
        members
    }
}

/// The connected parts of a graph.
pub fn components(graph: &Graph) -> Components {
    split(graph.nodes().len(), graph.struts())
}

/// The connected parts that are left where struts between nodes of different groups do not connect; such a strut is in the part of either end.
/// By group, then by their smallest node. `group` is indexed by `NodeId`.
pub fn apart(graph: &Graph, group: &[u32]) -> Vec<Members> {
    let mut parent: Vec<usize> = (0..graph.nodes().len()).collect();
    for s in graph.struts().iter().filter(|s| group[s.a.index()] == group[s.b.index()]) {
        let (a, b) = (root(&mut parent, s.a.index()), root(&mut parent, s.b.index()));
        parent[a.max(b)] = a.min(b);
    }
    // the root is the smallest node
    let roots: Vec<usize> = (0..parent.len()).map(|n| root(&mut parent, n)).collect();
    let mut order: Vec<usize> = graph.used_nodes().map(NodeId::index).filter(|&n| roots[n] == n).collect();
    order.sort_by_key(|&n| (group[n], n));
    let mut part_of = vec![0; roots.len()];
    order.iter().enumerate().for_each(|(part, &n)| part_of[n] = part);
    let mut members = vec![Members::default(); order.len()];
    for node in graph.used_nodes() {
        members[part_of[roots[node.index()]]].nodes.push(node);
    }
    for (k, s) in (0..).zip(graph.struts()) {
        let [a, b] = [s.a, s.b].map(|n| part_of[roots[n.index()]]);
        members[a].struts.push(StrutId(k));
        if b != a {
            members[b].struts.push(StrutId(k));
        }
    }
    members
}

/// As `components`, before there is a graph. All ends are below `node_count`.
pub(super) fn split(node_count: usize, struts: &[Strut]) -> Components {
    let mut parent: Vec<usize> = (0..node_count).collect();
    for s in struts {
        let (a, b) = (root(&mut parent, s.a.index()), root(&mut parent, s.b.index()));
        parent[a.max(b)] = a.min(b);
    }
    let mut id_of_root: Vec<Option<ComponentId>> = vec![None; node_count];
    let mut parts = Components { of_node: vec![None; node_count], of_strut: Vec::with_capacity(struts.len()), sizes: Vec::new() };
    for s in struts {
        let id = *id_of_root[root(&mut parent, s.a.index())].get_or_insert_with(|| {
            parts.sizes.push(ComponentSize::default());
            ComponentId(parts.sizes.len() as u32 - 1)
        });
        parts.of_strut.push(id);
        parts.sizes[id.index()].struts += 1;
        for node in [s.a, s.b] {
            if parts.of_node[node.index()].replace(id).is_none() {
                parts.sizes[id.index()].nodes += 1;
            }
        }
    }
    parts
}

/// The root of a node's tree; halves the path on the way.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}
