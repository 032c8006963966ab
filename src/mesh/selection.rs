//! Named subsets of a mesh: boundaries selected by a condition on their points, and parts as meshes.
//!
//! The condition may be a closure of a script, which can fail with an error of its own; it is evaluated once per node of the hull.

use std::collections::HashMap;

use thiserror::Error;

use super::{Boundary, Facet, Mesh, MeshError};

/// Errors of boundaries selected by a condition, and of mapped meshes.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SelectionError<E> {
    /// The condition itself failed.
    #[error("the condition failed")]
    Condition(E),
    /// The mesh refused the boundary.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl<E> SelectionError<E> {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            SelectionError::Condition(_) => "C0261",
            SelectionError::Mesh(error) => error.code(),
        }
    }
}

impl Mesh {
    /// Facets of the hull with all nodes satisfying `condition`, cell by cell; may be empty.
    ///
    /// # Errors
    /// An error of the condition.
    pub fn facets_where<E>(&self, mut condition: impl FnMut([f64; 3]) -> Result<bool, E>) -> Result<Vec<Facet>, E> {
        let mut answers: HashMap<u32, bool> = HashMap::new();
        let mut facets = Vec::new();
        for facet in self.hull() {
            let mut all = true;
            for node in self.facet_nodes(facet) {
                let holds = match answers.get(&node) {
                    Some(&known) => known,
                    None => condition(self.points[node as usize])?,
                };
                answers.insert(node, holds);
                all &= holds;
            }
            if all {
                facets.push(facet);
            }
        }
        Ok(facets)
    }

    /// Mesh with a further boundary: the facets of its hull with all nodes satisfying `condition`. It may be empty.
    ///
    /// # Errors
    /// An error of the condition; a boundary of that name exists.
    pub fn boundary_where<E>(mut self, name: &str, condition: impl FnMut([f64; 3]) -> Result<bool, E>) -> Result<Mesh, SelectionError<E>> {
        if self.boundary(name).is_some() {
            let available = self.boundaries.iter().map(|b| b.name.clone()).collect();
            return Err(SelectionError::Mesh(MeshError::BoundaryExists { name: name.into(), available }));
        }
        let facets = self.facets_where(condition).map_err(SelectionError::Condition)?;
        self.boundaries.push(Boundary::of_facets(name, facets));
        Ok(self)
    }

    /// Mesh with the nodes moved to the positions of `place`; cells and boundaries do not change.
    ///
    /// # Errors
    /// An error of `place`; coordinates that are not finite; inverted cells.
    pub fn mapped<E>(mut self, mut place: impl FnMut([f64; 3]) -> Result<[f64; 3], E>) -> Result<Mesh, SelectionError<E>> {
        for point in &mut self.points {
            *point = place(*point).map_err(SelectionError::Condition)?;
        }
        if let Some(&value) = self.points.as_flattened().iter().find(|value| !value.is_finite()) {
            return Err(SelectionError::Mesh(MeshError::NotFinite { what: "a coordinate of the mapped mesh", value }));
        }
        self.checked().map_err(SelectionError::Mesh)
    }

    /// Part with a name as a mesh: its cells in their order, their nodes renumbered in ascending order, with the boundaries and parts that
    /// lie in it. Parts with common nodes are separated.
    ///
    /// # Errors
    /// A name that is not among the parts.
    pub fn part(&self, name: &str) -> Result<Mesh, MeshError> {
        let Some((_, cells)) = self.parts.iter().find(|(part, _)| part == name) else {
            let available = self.parts.iter().map(|(part, _)| part.clone()).collect();
            return Err(MeshError::UnknownPart { name: name.into(), available });
        };
        Ok(self.of_cells(cells))
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::mesh::{block, rectangle};

    #[test]
    fn a_condition_picks_facets_of_the_hull_by_all_their_nodes() {
        let mesh = rectangle([4.0, 2.0], [4, 2], [0.0; 2]).unwrap();
        let mut asked = 0;
        let mesh = mesh
            .boundary_where("right half of the top", |[x, y, _]| {
                asked += 1;
                Ok::<_, Infallible>(x >= 2.0 && y == 2.0)
            })
            .unwrap();
        let boundary = mesh.boundary("right half of the top").unwrap();
        assert_eq!(boundary.facets, [Facet { cell: 6, local: 2 }, Facet { cell: 7, local: 2 }]);
        // The condition is evaluated once per node of the hull.
        assert_eq!(asked, 2 * (4 + 2));
        // interior facets at x = 2 have nodes that satisfy the condition, but are not on the hull
        let mesh = mesh.boundary_where("middle", |[x, ..]| Ok::<_, Infallible>(x == 2.0)).unwrap();
        assert!(mesh.boundary("middle").unwrap().facets.is_empty());
    }

    #[test]
    fn a_condition_may_fail_and_a_name_be_taken() {
        let mesh = rectangle([1.0, 1.0], [1, 1], [0.0; 2]).unwrap();
        let failed = mesh.clone().boundary_where("a", |_| Err("script error")).unwrap_err();
        assert_eq!(failed, SelectionError::Condition("script error"));
        let taken = mesh.boundary_where("top", |_| Ok::<_, Infallible>(true)).unwrap_err();
        assert!(taken.to_string().starts_with("the mesh already has a boundary \"top\""), "{taken}");
    }

    #[test]
    fn a_condition_picks_a_side_of_a_block() {
        let mesh = block([1.0, 1.0, 1.0], [2, 2, 2], [0.0; 3]).unwrap();
        let mut found = mesh.facets_where(|[.., z]| Ok::<_, Infallible>(z == 1.0)).unwrap();
        let mut front = mesh.boundary("front").unwrap().facets.clone();
        found.sort_unstable();
        front.sort_unstable();
        assert_eq!(found, front);
    }

    #[test]
    fn a_part_is_a_mesh_of_its_own() {
        let mut mesh = rectangle([4.0, 1.0], [4, 1], [0.0; 2]).unwrap();
        mesh.parts = vec![("west".into(), vec![0, 1]), ("east".into(), vec![3, 2]), ("all".into(), vec![0, 1, 2, 3])];
        let east = mesh.part("east").unwrap();
        assert_eq!((east.cell_count(), east.points.len()), (2, 6));
        assert_eq!(east.cell_center(0), [3.5, 0.5]);
        assert_eq!(east.defects(), []);
        let names: Vec<&str> = east.boundaries.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["right", "bottom", "top"]);
        let right = east.boundary("right").unwrap();
        assert_eq!(right.facets, [Facet { cell: 0, local: 1 }]);
        assert!(east.boundary_nodes(right).iter().all(|&n| east.points[n as usize][0] == 4.0));
        assert_eq!(east.parts, [("east".to_string(), vec![0, 1]), ("all".to_string(), vec![1, 0])]);
        // The part has one more open side, where it was connected to the other part.
        assert_eq!(east.hull().len(), 6);
        let error = mesh.part("eats").unwrap_err();
        assert_eq!((error.to_string().contains("\"west\", \"east\", \"all\""), error.hint()), (true, "did you mean \"east\"?".into()));
    }
}
