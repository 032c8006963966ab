//! Order of elimination: nested dissection or minimum degree on the graph of nodes and multipliers, whichever gives less work.
//!
//! The ordered graph has nodes and multipliers as vertices, not unknowns: it is a few times smaller and keeps the unknowns of a node
//! together. Separators may consist of multipliers only, the cheapest cut of an interface. A multiplier has no diagonal entry until the
//! elimination of a neighbor fills it. If the dissection places it before its *anchor* (the node whose motion it opposes), it is moved to
//! the position right behind the anchor.
//!
//! Dissection uses the crate `feral-metis` (Karypis and Kumar 1998), which orders small parts by approximate minimum degree (Amestoy, Davis
//! and Duff 1996). Dissection gives less work on large meshes, a sixth less on a bearing of 2 000 unknowns, but takes twenty times as long
//! as minimum degree. An order is therefore kept through many changes of contact, and repaired where surfaces have slid.

use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use feral_metis::{CscPattern, MetisOptions, metis_order_full};
use serde::{Deserialize, Serialize};

use super::pattern::Pattern;
use super::watch::InterruptWatch;
use crate::math::workers::Workers;

/// Parts of at most this many vertices are not dissected: measured on the bearing (its matrices factor a fifth faster than with 200).
const SMALLEST_PART: u32 = 25;

/// Imbalances of the parts and seeds of the additional dissections for a large matrix. With the best one cubes of hexahedra took 7.5
/// instead of 12.0 Gflop, and 360 instead of 450. Other values, more starts at the coarsest level, and separators refined as edge cuts gave
/// no further gain.
const ALTERNATIVES: [(f64, u64); 4] = [(0.1, 2), (0.1, 4), (0.05, 1), (0.05, 4)];

/// Number of graph edges above which a dissection is interruptible: some hundredths of a second.
const LONG: usize = 50_000;

/// Longest reaction time to an interrupt.
const PATIENCE: Duration = Duration::from_millis(20);

/// Candidate orders of the vertices, in which multipliers may still precede their anchors; empty after an interrupt.
pub(super) fn candidates(pattern: &Pattern, watch: &InterruptWatch) -> Vec<Vec<u32>> {
    let mut orders = Vec::new();
    if let Some(graph) = Graph::new(pattern) {
        let minimum_degree = graph.dissection(&MetisOptions { nd_to_amd_switch: u32::MAX, ..MetisOptions::default() });
        let options = MetisOptions { nd_to_amd_switch: SMALLEST_PART, ..MetisOptions::default() };
        orders.extend(Arc::new(graph).watched_dissection(&options, watch));
        orders.extend(minimum_degree);
    }
    if orders.is_empty() && !watch.is_interrupted() {
        orders.push((0..pattern.vertices() as u32).collect());
    }
    orders
}

/// Additional dissections for large matrices, in an order independent of the number of threads.
pub(super) fn alternatives(pattern: &Pattern, watch: &InterruptWatch, workers: &Workers) -> Vec<Vec<u32>> {
    let Some(graph) = Graph::new(pattern).map(Arc::new) else { return Vec::new() };
    let mut orders = ALTERNATIVES.map(|_| None);
    workers.for_each(&mut orders, 1, |k, order| {
        let (max_imbalance, seed) = ALTERNATIVES[k];
        let options = MetisOptions { nd_to_amd_switch: SMALLEST_PART, max_imbalance, seed, ..MetisOptions::default() };
        *order = if watch.is_interrupted() { None } else { graph.clone().watched_dissection(&options, watch) };
    });
    orders.into_iter().flatten().collect()
}

/// Graph of a pattern in the format of the crate `feral-metis`.
struct Graph {
    starts: Vec<i32>,
    neighbors: Vec<i32>,
}

impl Graph {
    /// Returns `None` if the graph exceeds the index range of the crate.
    fn new(pattern: &Pattern) -> Option<Self> {
        let count = pattern.vertices();
        let mut graph = Graph { starts: Vec::with_capacity(count + 1), neighbors: Vec::new() };
        graph.starts.push(0);
        for v in 0..count {
            graph.neighbors.extend(pattern.neighbors(v).iter().map(|&u| u as i32));
            graph.starts.push(i32::try_from(graph.neighbors.len()).ok()?);
        }
        Some(graph)
    }

    /// Nested dissection into small parts, each ordered by minimum degree.
    fn dissection(&self, options: &MetisOptions) -> Option<Vec<u32>> {
        let graph = CscPattern::new(self.starts.len() - 1, &self.starts, &self.neighbors)?;
        let (order, ..) = metis_order_full(&graph, options).ok()?;
        Some(order.into_iter().map(|v| v as u32).collect())
    }

    /// Nested dissection into small parts, each ordered by minimum degree; `None` after an interrupt.
    ///
    /// The crate cannot be stopped, so a long dissection runs on a separate thread, which is abandoned after an interrupt.
    fn watched_dissection(self: Arc<Self>, options: &MetisOptions, watch: &InterruptWatch) -> Option<Vec<u32>> {
        if watch.interrupt.is_none() || self.neighbors.len() < LONG {
            return self.dissection(options);
        }
        let (sender, receiver) = mpsc::channel();
        let options = options.clone();
        std::thread::spawn(move || {
            // After an interrupt the receiver no longer exists.
            let _ = sender.send(self.dissection(&options));
        });
        loop {
            match receiver.recv_timeout(PATIENCE) {
                Ok(order) => return order,
                Err(RecvTimeoutError::Timeout) if !watch.is_interrupted() => {}
                Err(_) => return None,
            }
        }
    }
}

/// Order of elimination with its elimination tree; tree vertices are positions in the order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Order {
    /// Vertices in the order of elimination.
    pub(super) vertices: Vec<u32>,
    /// Parent of each position in the elimination tree, `u32::MAX` for a root.
    parents: Vec<u32>,
    /// Range of postorder numbers of the subtree of each position; the position itself is the last one of its range.
    families: Vec<[u32; 2]>,
}

impl Order {
    /// Size in bytes.
    pub(super) fn size(&self) -> usize {
        size_of_val(&self.vertices[..]) + size_of_val(&self.parents[..]) + size_of_val(&self.families[..])
    }

    /// Order with the parents in its elimination tree.
    pub(super) fn new(vertices: Vec<u32>, parents: Vec<u32>) -> Self {
        let count = parents.len();
        let mut sizes = vec![1u32; count];
        for k in 0..count {
            if parents[k] != NONE {
                sizes[parents[k] as usize] += sizes[k];
            }
        }
        // Parents follow their children in the order. From the last position on, each subtree gets its range within that of its parent.
        let mut families = vec![[0; 2]; count];
        let mut roots_end = count as u32;
        let mut free_end: Vec<u32> = vec![0; count];
        for k in (0..count).rev() {
            let end = if parents[k] == NONE { &mut roots_end } else { &mut free_end[parents[k] as usize] };
            families[k] = [*end - sizes[k], *end - 1];
            *end -= sizes[k];
            free_end[k] = families[k][1];
        }
        Order { vertices, parents, families }
    }

    /// True if the order contains every vertex once, parents follow their children, and families agree with the parents.
    pub(super) fn is_sound(&self) -> bool {
        let count = self.vertices.len();
        let mut seen = vec![false; count];
        let is_new = |&v: &u32| seen.get_mut(v as usize).is_some_and(|seen| !std::mem::replace(seen, true));
        let is_parent = |(k, &parent): (usize, &u32)| parent == NONE || (k < parent as usize && (parent as usize) < count);
        self.vertices.iter().all(is_new)
            && self.parents.len() == count
            && self.parents.iter().enumerate().all(is_parent)
            && self.families == Order::new(Vec::new(), self.parents.clone()).families
    }

    /// True if position `ancestor` is an ancestor of position `place` in the elimination tree, or equal to `place`.
    fn is_above(&self, ancestor: u32, place: u32) -> bool {
        let ([first, last], [_, own]) = (self.families[ancestor as usize], self.families[place as usize]);
        (first..=last).contains(&own)
    }

    /// Returns this order with a minimal change for a pattern with other couplings.
    ///
    /// Sliding surfaces couple vertices in separate branches of the elimination tree. In the old order one of two such vertices would
    /// remain in all fronts up to the common ancestor of the branches and couple the branches. One of the two is therefore moved to the
    /// position of this ancestor and becomes part of the separator.
    pub(super) fn repaired(&self, pattern: &Pattern) -> Vec<u32> {
        let count = self.vertices.len();
        let mut place = vec![0u32; count];
        for (k, &v) in self.vertices.iter().enumerate() {
            place[v as usize] = k as u32;
        }
        let mut is_anchor = vec![false; count];
        for node in (0..count).filter_map(|v| pattern.anchor(v)) {
            is_anchor[node as usize] = true;
        }
        // Preferred vertices for a move: first nodes that anchor no multiplier, then multipliers, then anchors.
        let rank = |v: u32| if pattern.is_multiplier(v as usize) { 1 } else { 2 * u8::from(is_anchor[v as usize]) };
        // Position to which each vertex is moved, in front of the vertex there; 0 for vertices that stay.
        let mut targets = vec![0u32; count];
        for (k, &v) in self.vertices.iter().enumerate() {
            let k = k as u32;
            for &u in pattern.neighbors(v as usize) {
                let other = place[u as usize];
                if k < other && !self.is_above(other, k) {
                    let mut meeting = other;
                    while meeting != NONE && !self.is_above(meeting, k) {
                        meeting = self.parents[meeting as usize];
                    }
                    let target = &mut targets[if rank(v) <= rank(u) { k } else { other } as usize];
                    *target = (*target).max(meeting.min(count as u32));
                }
            }
        }
        let mut movers: Vec<(u32, u32)> = (0..count as u32).map(|k| (targets[k as usize], k)).filter(|mover| mover.0 > 0).collect();
        movers.sort_unstable();
        let mut movers = movers.into_iter().peekable();
        let mut order = Vec::with_capacity(count);
        for k in 0..=count as u32 {
            while let Some((_, mover)) = movers.next_if(|mover| mover.0 == k) {
                order.push(self.vertices[mover as usize]);
            }
            if targets.get(k as usize) == Some(&0) {
                order.push(self.vertices[k as usize]);
            }
        }
        order
    }
}

const NONE: u32 = u32::MAX;

/// Returns the order of elimination: every multiplier that precedes its anchor moves behind the anchor, and a multiplier
/// without an anchor behind the last of its neighbors that are no multipliers.
pub(super) fn anchored(pattern: &Pattern, order: &[u32]) -> Vec<u32> {
    let count = pattern.vertices();
    let mut place = vec![0u32; count];
    for (k, &v) in order.iter().enumerate() {
        place[v as usize] = k as u32;
    }
    // Linked lists of the multipliers that are moved behind each vertex.
    let (mut first, mut next, mut moved) = (vec![u32::MAX; count], vec![u32::MAX; count], vec![false; count]);
    for &v in order.iter().rev().filter(|&&v| pattern.is_multiplier(v as usize)) {
        let neighbors = pattern.neighbors(v as usize);
        let node = match pattern.anchor(v as usize).filter(|anchor| neighbors.binary_search(anchor).is_ok()) {
            Some(anchor) => anchor,
            None => {
                let nodes = neighbors.iter().copied().filter(|&u| !pattern.is_multiplier(u as usize));
                let Some(last) = nodes.max_by_key(|&u| place[u as usize]) else { continue };
                last
            }
        };
        if place[v as usize] < place[node as usize] {
            moved[v as usize] = true;
            next[v as usize] = first[node as usize];
            first[node as usize] = v;
        }
    }
    let mut result = Vec::with_capacity(count);
    for &v in order.iter().filter(|&&v| !moved[v as usize]) {
        result.push(v);
        let mut follower = first[v as usize];
        while follower != u32::MAX {
            result.push(follower);
            follower = next[follower as usize];
        }
    }
    result
}
