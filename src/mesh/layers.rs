//! Specification of boundary layers of thin cells: boundaries, thickness, number of layers, and length of their cells.

use rstar::RTree;

use super::MeshError;
use super::cell_size::CellSize;
use super::curves::{OutlineSide, SIDE_LIMIT};
use super::grid::{at_least, positive};

type Point = [f64; 2];

/// Increase of the cell size per distance from layers whose cell length is given.
const GRADING: f64 = 0.3;

/// Layers of thin cells along boundaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Names of the boundaries.
    pub boundaries: Vec<String>,
    /// Thickness of the layer at the boundary `[length]`.
    pub first: f64,
    /// Number of layers.
    pub count: usize,
    /// Ratio of the thicknesses of consecutive layers, from the boundary inward.
    pub growth: f64,
    /// Length of the cells along the boundary `[length]`, from which it grows to the size of the region's cells.
    pub along: Option<f64>,
}

impl Layers {
    /// Distances of the levels from the boundary, from 0 on.
    pub(super) fn levels(&self) -> Vec<f64> {
        let mut levels = vec![0.0];
        let mut thickness = self.first;
        for _ in 0..self.count {
            levels.push(levels[levels.len() - 1] + thickness);
            thickness *= self.growth;
        }
        levels
    }

    /// Thickness of all layers `[length]`.
    pub fn thickness(&self) -> f64 {
        self.levels()[self.count]
    }

    /// Checks the numbers of the layers.
    pub(super) fn check(&self) -> Result<(), MeshError> {
        positive("the thickness of the first layer", self.first)?;
        positive("the growth of layers", self.growth)?;
        at_least("across the layers", self.count, 1)?;
        self.along.map_or(Ok(()), |along| positive("the length of cells along layers", along))?;
        positive("the thickness of all layers", self.thickness())
    }

    /// Points on the sides with layers, as a search tree, for the cell size near layers.
    ///
    /// # Errors
    /// A boundary that no side belongs to.
    pub(super) fn near(&self, outline: &[OutlineSide], holes: &[Vec<OutlineSide>]) -> Result<LayerDistance, MeshError> {
        let loops = std::iter::once(("outer".to_string(), outline));
        let loops = loops.chain((1..).zip(holes).map(|(hole, sides)| (format!("hole {hole}"), &sides[..])));
        let (mut available, mut points): (Vec<String>, Vec<Point>) = (Vec::new(), Vec::new());
        for (whole, sides) in loops {
            for side in sides {
                let names: Vec<&String> = std::iter::once(&whole).chain(&side.name).collect();
                if let (Some(along), true) = (self.along, names.iter().any(|name| self.boundaries.contains(name))) {
                    let places = side.curve.divided(|_| Ok::<f64, MeshError>(0.5 * along), SIDE_LIMIT)?;
                    points.extend(places.iter().map(|&t| side.curve.at(t)));
                }
                available.extend(names.into_iter().filter(|name| !available.contains(name)).cloned().collect::<Vec<_>>());
            }
        }
        match self.boundaries.iter().find(|name| !available.contains(name)) {
            Some(name) => Err(MeshError::UnknownLayers { name: name.clone(), available }),
            None => Ok(LayerDistance {
                sides: RTree::bulk_load(points),
                along: self.along.unwrap_or(f64::INFINITY),
                thickness: self.thickness(),
            }),
        }
    }

    /// Converts the error of an inverted or degenerate cell beside the layers to [`MeshError::LayersCramped`].
    pub(super) fn cramped(&self, error: MeshError) -> MeshError {
        match error {
            MeshError::InvertedCell { center, .. } | MeshError::DegenerateCell { center, .. } => {
                MeshError::LayersCramped { names: self.quoted(), thickness: self.thickness(), near: [center[0], center[1]] }
            }
            error => error,
        }
    }

    /// Names of the boundaries in quotation marks.
    pub(super) fn quoted(&self) -> String {
        let names: Vec<String> = self.boundaries.iter().map(|name| format!("\"{name}\"")).collect();
        names.join(", ")
    }
}

/// Points on the layered sides, near which cells are shorter.
pub(super) struct LayerDistance {
    sides: RTree<Point>,
    along: f64,
    thickness: f64,
}

impl LayerDistance {
    /// Wanted cell size at a point: the minimum of the size in the region and the cell length along the layers, increased with the
    /// distance.
    pub fn size<E: From<MeshError>>(&self, size: &mut CellSize<E>, point: Point) -> Result<f64, E> {
        let wanted = size.at(point)?;
        let away = self.sides.nearest_neighbor(point).map_or(f64::INFINITY, |&[x, y]| (x - point[0]).hypot(y - point[1]));
        Ok(wanted.min(self.along + GRADING * (away - self.thickness).max(0.0)))
    }
}
