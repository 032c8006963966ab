//! Union of two meshes with a common side.

use std::collections::HashSet;

use super::point_index::PointIndex;
use super::topology::{FacetKey, facet_key};
use super::{Block, Boundary, Facet, Mesh, MeshError};
use crate::elements::CellKind;
use crate::math::tolerances::SAME_PLACE;

impl Mesh {
    /// Refuses meshes of another dimension or order.
    fn check_joined(&self, other: &Mesh) -> Result<(), MeshError> {
        let is_like = |kind: CellKind| kind.dimension() == self.dimension() && kind.is_quadratic() == self.is_quadratic();
        match (self.kinds().next(), other.kinds().find(|&kind| !is_like(kind))) {
            (Some(first), Some(second)) => Err(MeshError::JoinedKinds { first: first.name(), second: second.name() }),
            _ => Ok(()),
        }
    }

    /// Joins this mesh with another one: coincident nodes (up to round-off) are merged, boundaries and parts of equal names are united, and
    /// facets that become interior belong to no boundary. Node numbers of this mesh stay. Cells of other kinds become further blocks.
    ///
    /// # Errors
    /// Cells of different dimension or order, no node in common, cells that overlap or do not match.
    pub fn joined(&self, other: &Mesh) -> Result<Mesh, MeshError> {
        self.check_joined(other)?;
        let points = || self.points.iter().chain(&other.points);
        let extent = points().flatten().fold(0.0, |most, x| f64::max(most, x.abs()));
        let near = SAME_PLACE * extent;
        let index = PointIndex::new(&self.points);
        let mut joined = self.clone();
        let mut common = 0;
        let mut number = |point: &[f64; 3]| match index.nearest(*point) {
            Some((node, distance)) if distance <= near => {
                common += 1;
                node as u32
            }
            _ => {
                joined.points.push(*point);
                joined.points.len() as u32 - 1
            }
        };
        let numbers: Vec<u32> = other.points.iter().map(&mut number).collect();
        if common == 0 {
            return Err(MeshError::NothingShared);
        }
        // Number of the first added cell in the block of each kind; added cells follow the existing ones of the same kind.
        let firsts: Vec<usize> = other
            .blocks
            .iter()
            .map(|block| joined.add_cells(block.kind, block.connectivity.iter().map(|&node| numbers[node as usize])))
            .collect();
        let start = |kind: CellKind| joined.numbered_blocks().find(|(_, block)| block.kind == kind).map_or(0, |(first, _)| first);
        let shifts = |mesh: &Mesh, within: &dyn Fn(usize) -> usize| -> Vec<(std::ops::Range<usize>, i64)> {
            let shift = |(index, (first, block)): (usize, (usize, &Block))| {
                (first..first + block.count(), (start(block.kind) + within(index)) as i64 - first as i64)
            };
            mesh.numbered_blocks().enumerate().map(shift).collect()
        };
        let (own_shifts, other_shifts) = (shifts(self, &|_| 0), shifts(other, &|index| firsts[index]));
        let moved = |cell: u32, shifts: &[(std::ops::Range<usize>, i64)]| {
            let shift = shifts.iter().find(|(cells, _)| cells.contains(&(cell as usize))).map_or(0, |(_, shift)| *shift);
            (i64::from(cell) + shift) as u32
        };
        joined.boundaries.iter_mut().flat_map(|b| &mut b.facets).for_each(|facet| facet.cell = moved(facet.cell, &own_shifts));
        joined.parts.iter_mut().flat_map(|(_, cells)| cells).for_each(|cell| *cell = moved(*cell, &own_shifts));
        for boundary in &other.boundaries {
            let added = Boundary {
                name: boundary.name.clone(),
                facets: boundary.facets.iter().map(|facet| Facet { cell: moved(facet.cell, &other_shifts), ..*facet }).collect(),
                nodes: boundary.nodes.iter().map(|&node| numbers[node as usize]).collect(),
            };
            match joined.boundaries.iter_mut().find(|known| known.name == boundary.name) {
                Some(known) => *known = Boundary { name: boundary.name.clone(), ..Boundary::union(&[known.clone(), added]) },
                None => joined.boundaries.push(added),
            }
        }
        for (name, cells) in &other.parts {
            let cells = cells.iter().map(|&cell| moved(cell, &other_shifts));
            match joined.parts.iter_mut().find(|(known, _)| known == name) {
                Some((_, known)) => known.extend(cells),
                None => joined.parts.push((name.clone(), cells.collect())),
            }
        }
        let outside: HashSet<FacetKey> = joined.hull().into_iter().map(|facet| facet_key(joined.facet_nodes(facet))).collect();
        let mut boundaries = std::mem::take(&mut joined.boundaries);
        for boundary in &mut boundaries {
            boundary.facets.retain(|&facet| outside.contains(&facet_key(joined.facet_nodes(facet))));
        }
        boundaries.retain(|boundary| !boundary.facets.is_empty() || !boundary.nodes.is_empty());
        joined.boundaries = boundaries;
        match joined.defects().into_iter().next() {
            Some(defect) => Err(defect),
            None => joined.checked(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{block, rectangle};

    #[test]
    fn a_common_side_becomes_inner_and_boundaries_of_one_name_are_one() {
        let base = rectangle([4.0, 1.0], [8, 2], [0.0; 2]).unwrap();
        let tooth = rectangle([1.0, 1.0], [2, 3], [1.5, 1.0]).unwrap();
        let joined = base.joined(&tooth).unwrap();
        assert_eq!(joined.points.len(), base.points.len() + tooth.points.len() - 3);
        assert!((joined.measure() - 5.0).abs() < 1e-14);
        let length = |name: &str| joined.boundary_measure(joined.boundary(name).unwrap());
        assert!((length("top") - 4.0).abs() < 1e-14 && (length("left") - 2.0).abs() < 1e-14 && (length("bottom") - 4.0).abs() < 1e-14);
        assert_eq!(joined.hull().len(), 2 * (8 + 2) + 2 * 3);
    }

    #[test]
    fn what_cannot_be_joined_is_refused() {
        let base = rectangle([4.0, 1.0], [8, 2], [0.0; 2]).unwrap();
        assert!(matches!(base.joined(&rectangle([1.0, 1.0], [2, 2], [9.0, 0.0]).unwrap()), Err(MeshError::NothingShared)));
        assert!(matches!(base.joined(&block([1.0; 3], [1, 1, 1], [0.0; 3]).unwrap()), Err(MeshError::JoinedKinds { .. })));
        assert!(base.joined(&base).is_err(), "every facet would have two cells on one side");
    }
}
