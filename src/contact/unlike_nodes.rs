//! Press fits of nodes on facets between unlike meshes (for `checks.rs`).
//!
//! Forces of nodes on the facets of another mesh do not balance a uniform pressure (Taylor and Papadopoulos, On a patch test for contact
//! problems in two dimensions, 1991): in a press fit nodal pressures oscillate, however fine the meshes are.

use rstar::RTree;

use super::surface::Surface;

/// Mean distance of the secondary nodes from the nearest primary node, in facet lengths, above which meshes count as unlike. It is 1/4 for
/// nodes anywhere along facets, and nearly 0 for nodes opposite nodes.
const UNLIKE: f64 = 0.1;

/// True if the nodes of a surface do not lie opposite nodes of the other one at `q`. Nodes farther away than a facet do not count.
pub fn has_unlike_nodes(secondary: &Surface, primary: &Surface, q: &[f64]) -> bool {
    let dimension = secondary.dimension();
    let at = |node: &u32| -> [f64; 3] { std::array::from_fn(|i| if i < dimension { q[dimension * *node as usize + i] } else { 0.0 }) };
    let tree = RTree::bulk_load(primary.nodes().iter().map(at).collect());
    let size = (0..primary.count()).map(|facet| primary.facet_size(facet, q)).sum::<f64>() / primary.count() as f64;
    let distance = |node: &u32| {
        let x = at(node);
        let near: &[f64; 3] = tree.nearest_neighbor(x)?;
        let distance = (0..3).map(|i| (near[i] - x[i]).powi(2)).sum::<f64>().sqrt() / size;
        (distance < 1.0).then_some(distance)
    };
    let distances: Vec<f64> = secondary.nodes().iter().filter_map(distance).collect();
    distances.iter().sum::<f64>() > UNLIKE * distances.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of 40 facets on 40 and on 48, the inner one pressed in by a hundredth of the radius.
    #[test]
    fn rings_of_unlike_facets_are_found() {
        let found = |inner: u32, outer: u32| {
            let ring = |first: u32, count: u32| -> Vec<[u32; 2]> { (0..count).map(|k| [first + k, first + (k + 1) % count]).collect() };
            let at = |k: u32, count: u32, radius: f64| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
                [radius * angle.cos(), radius * angle.sin()]
            };
            let q: Vec<f64> = (0..inner).flat_map(|k| at(k, inner, 1.01)).chain((0..outer).flat_map(|k| at(k, outer, 1.0))).collect();
            has_unlike_nodes(&Surface::new(&ring(0, inner)), &Surface::new(&ring(inner, outer)), &q)
        };
        assert!(found(40, 48) && found(48, 40) && !found(40, 40));
    }
}
