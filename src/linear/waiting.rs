//! Stack positions of the update matrices, and the order of children that minimizes the memory of the stacks.
//!
//! Update matrices are stored on two stacks that grow towards each other in one buffer; the stack alternates with the level of the tree, so
//! that a front and its children are on different ones.

use std::ops::Range;

use super::fronts::Front;
use super::tiles::padded;
use super::tree::Tree;

/// Number of stacked entries (16 MB) above which children are ordered for minimal memory; below, the child with the largest update comes
/// first.
const LARGE: usize = 1 << 21;

/// Location of an update matrix until it is assembled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum UpdateLocation {
    /// Stack that grows from the buffer's start, or from its end.
    #[default]
    Low,
    High,
    /// Among the update matrices handed over by tasks.
    Handed,
}

/// Stack positions of all update matrices.
#[derive(Debug, Default)]
pub(super) struct UpdateStack {
    /// Stack and first position of each front's update matrix.
    pub(super) places: Vec<(UpdateLocation, usize)>,
    /// Buffer length for fronts outside of tasks.
    pub(super) buffer: usize,
    /// Buffer length for the fronts of one task.
    pub(super) of_task: usize,
    /// Buffer length for the update matrices handed over by tasks.
    pub(super) handed: usize,
}

impl UpdateStack {
    /// Stack positions for fronts in postorder. A task, a range of fronts, has separate stacks; its last update matrix is handed over.
    pub(super) fn new(fronts: &[Front], children: &[u32], tasks: &[Range<usize>]) -> Self {
        let mut waiting = UpdateStack { places: vec![(UpdateLocation::Low, 0); fronts.len()], ..UpdateStack::default() };
        for k in (0..fronts.len()).rev() {
            if let Some(parent) = fronts[k].parent {
                waiting.places[k].0 =
                    if waiting.places[parent as usize].0 == UpdateLocation::Low { UpdateLocation::High } else { UpdateLocation::Low };
            }
        }
        let size = |k: usize| fronts[k].u * fronts[k].u;
        let mut is_inside = vec![false; fronts.len()];
        for task in tasks {
            is_inside[task.clone()].fill(true);
            waiting.places[task.end - 1] = (UpdateLocation::Handed, waiting.handed);
            waiting.handed += size(task.end - 1);
        }
        let (mut inside, mut above) = ([0; 2], [0; 2]);
        for (k, front) in fronts.iter().enumerate() {
            let (tops, buffer) = if is_inside[k] { (&mut inside, &mut waiting.of_task) } else { (&mut above, &mut waiting.buffer) };
            let side = waiting.places[k].0;
            if side != UpdateLocation::Handed {
                waiting.places[k].1 = tops[side as usize];
                tops[side as usize] += size(k);
                *buffer = (*buffer).max(tops[0] + tops[1]);
            }
            // The children's update matrices are on top of the other stack; after assembly into this front their space is free.
            for &child in &children[front.children.clone()] {
                let side = waiting.places[child as usize].0;
                if side != UpdateLocation::Handed {
                    tops[side as usize] -= size(child as usize);
                }
            }
        }
        for (k, (_, at)) in waiting.places.iter_mut().enumerate().filter(|(_, place)| place.0 == UpdateLocation::High) {
            *at = if is_inside[k] { waiting.of_task } else { waiting.buffer } - *at - size(k);
        }
        waiting
    }
}

/// For each front, the peak number of stacked entries during the elimination of its subtree minus its own update. Eliminating children in
/// descending order of this number minimizes the peak (Liu 1986). `None` if sorting by size suffices.
pub(super) fn surplus(tree: &Tree) -> Option<Vec<usize>> {
    let by_size = peaks(tree, |c, _| tree.update[c as usize] as usize);
    let largest = tree.roots.iter().map(|&root| by_size[root as usize]).max()?;
    let surplus = |peaks: &[usize], c: u32| peaks[c as usize] - size(tree, c);
    let by_surplus = (largest >= LARGE).then(|| peaks(tree, |c, peaks| surplus(peaks, c)))?;
    Some((0..by_surplus.len() as u32).map(|c| by_surplus[c as usize].saturating_sub(size(tree, c))).collect())
}

fn size(tree: &Tree, front: u32) -> usize {
    padded(tree.update[front as usize] as usize).pow(2)
}

/// Peak number of stacked entries in the subtree of each front, if children are sorted by `rank` in descending order.
fn peaks(tree: &Tree, rank: impl Fn(u32, &[usize]) -> usize) -> Vec<usize> {
    let mut from_above = tree.roots.clone();
    let mut k = 0;
    while let Some(&front) = from_above.get(k) {
        from_above.extend(tree.kids(front));
        k += 1;
    }
    let mut peaks = vec![0; tree.update.len()];
    let mut kids: Vec<u32> = Vec::new();
    for &front in from_above.iter().rev() {
        kids.clear();
        kids.extend(tree.kids(front));
        kids.sort_by_key(|&c| std::cmp::Reverse(rank(c, &peaks)));
        let (mut waiting, mut peak) = (0, 0);
        for &c in &kids {
            peak = peak.max(waiting + peaks[c as usize]);
            waiting += size(tree, c);
        }
        peaks[front as usize] = peak.max(waiting + size(tree, front));
    }
    peaks
}
