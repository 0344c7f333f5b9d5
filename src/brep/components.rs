//! Splits the struts into connected components: two struts that share a node belong together.

use crate::graph::Graph;
use crate::ids::{NodeId, StrutId};

/// One connected component with at least one strut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Ascending.
    pub nodes: Vec<NodeId>,
    /// Ascending.
    pub struts: Vec<StrutId>,
}

/// All components with at least one strut, in the order of their smallest node. Nodes without
/// struts belong to none.
pub fn components(graph: &Graph) -> Vec<Component> {
    const NONE: usize = usize::MAX;
    let mut of_node = vec![NONE; graph.nodes().len()];
    let mut out: Vec<Component> = vec![];
    let mut stack = vec![];
    for start in graph.node_ids() {
        if of_node[start.index()] != NONE || graph.degree(start) == 0 {
            continue;
        }
        let id = out.len();
        out.push(Component { nodes: vec![], struts: vec![] });
        of_node[start.index()] = id;
        stack.push(start);
        while let Some(node) = stack.pop() {
            for &arm in graph.arms(node) {
                let far = graph.far(arm);
                if of_node[far.index()] == NONE {
                    of_node[far.index()] = id;
                    stack.push(far);
                }
            }
        }
    }
    for node in graph.node_ids().filter(|n| of_node[n.index()] != NONE) {
        out[of_node[node.index()]].nodes.push(node);
    }
    for (k, strut) in graph.struts().iter().enumerate() {
        out[of_node[strut.a.index()]].struts.push(StrutId(k as u32));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Strut;
    use glam::DVec3;

    #[test]
    fn two_components_and_a_lonely_node() {
        let strut = |a, b| Strut { a: NodeId(a), b: NodeId(b), ra: 1.0, rb: 1.0 };
        let graph = Graph::new(vec![DVec3::ZERO; 6], vec![strut(5, 1), strut(0, 4), strut(1, 2)]);
        let found = components(&graph);
        assert_eq!(found.len(), 2);
        assert_eq!((&found[0].nodes[..], &found[0].struts[..]), (&[NodeId(0), NodeId(4)][..], &[StrutId(1)][..]));
        assert_eq!(found[1].nodes, [NodeId(1), NodeId(2), NodeId(5)]);
        assert_eq!(found[1].struts, [StrutId(0), StrutId(2)]);
    }
}
