//! How far the curved surface that facets of three and four nodes stand for lies above them.
//!
//! At a node the surface has the normal of the sphere through its neighbors where there is one (N. Max, J. Graphics Tools 4, 1999), over
//! the facets that go on smoothly from the one in question. Along an edge `e` of a facet with the normal `n` from node `i` to node `j` the
//! turns `e.(n - n_i)` and `e.(n_j - n)` make the sagitta `s_e`, a quarter of their mean, limited to twice the lesser and zero where their
//! signs differ: so a single bend is none of a curve. At a rim one of them stands for both. The surface is quadratic over the facet, so its
//! mean height is `c = sum_e s_e/3`.
//!
//! A node is raised by the mean `c` of the facets about it, a mean point so that its facet holds the volume of what it stands for. In even
//! meshes all is raised alike.

use crate::contact::faces::{self, Vector};
use crate::contact::surface::Surface;
use crate::math::tolerances::STRAIGHT;

/// Cosine of the turn between two facets up to which a curve goes on from one to the other: 25 degrees, so that spheres of 24 cells
/// around are round, whose facets turn by 15 and, over corners, 21 degrees.
const SMOOTH: f64 = 0.906_307_787_036_65;

/// How far an edge that goes on may lead past the facet behind its end, in that facet's own edges.
const ASIDE: f64 = 0.2;

/// Height of the surface above the corners of a facet, and that by which it is higher above its mean point than the mean of these
/// `[length]`, outwards.
pub type Raised = [f64; 5];

/// What facets are of a curve.
#[derive(Clone, Debug, Default)]
pub struct Bulges {
    /// Mean height of the surface above each facet; none where facets are what they are `[length]`.
    heights: Vec<f64>,
    /// By how much each facet is raised.
    pub raised: Vec<Raised>,
}

/// The facets of a surface.
struct Facets<'a> {
    surface: &'a Surface,
    q: &'a [f64],
    normals: Vec<Vector>,
    smooth: f64,
}

impl Bulges {
    /// Those of a surface at the positions `q`.
    pub fn new(surface: &Surface, q: &[f64]) -> Self {
        Self::of_curve(surface, q, SMOOTH)
    }

    /// The same with another cosine of the turn between two facets up to which a curve goes on.
    pub fn of_curve(surface: &Surface, q: &[f64], smooth: f64) -> Self {
        let normals = (0..surface.count()).map(|facet| faces::normal(surface.facet(facet), q)).collect();
        let facets = Facets { surface, q, normals, smooth };
        let heights: Vec<f64> = (0..surface.count()).map(|facet| facets.height(facet)).collect();
        let raised = (0..surface.count()).map(|facet| facets.raised(facet, &heights)).collect();
        Bulges { heights, raised }
    }

    /// Mean height of the surface above a facet, 0 where it is flat `[length]`.
    pub fn height(&self, facet: usize) -> f64 {
        self.heights[facet]
    }

    /// By how much the points of some facets may be raised above a round surface `[length]`.
    pub fn raised_by(&self, facets: &[u32]) -> f64 {
        facets.iter().filter_map(|&facet| self.heights.get(facet as usize)).copied().fold(0.0, f64::max)
    }

    /// How far the middles of some facets lie above a hollow `[length]`: its bottom is deeper by half than the mean of a parabola.
    pub fn hollow(&self, facets: &[u32]) -> f64 {
        -1.5 * facets.iter().filter_map(|&facet| self.heights.get(facet as usize)).copied().fold(0.0, f64::min)
    }
}

impl Facets<'_> {
    /// Facets that meet at the corner `k` of a facet and go on smoothly from it, itself among them.
    fn around(&self, facet: usize, k: usize) -> impl Iterator<Item = usize> {
        let node = self.surface.local_facet(facet)[k] as usize;
        let goes_on = move |&other: &usize| self.normals[other].dot(&self.normals[facet]) >= self.smooth;
        self.surface.adjacent_facets(node).iter().map(|&other| other as usize).filter(goes_on)
    }

    /// The edges of a facet that meet at one of its nodes, away from it.
    fn sides(&self, facet: usize, node: u32) -> [Vector; 2] {
        let nodes = self.surface.facet(facet);
        let place = nodes.iter().position(|&other| other == node).unwrap_or(0);
        [place + 1, place + nodes.len() - 1].map(|k| faces::at(nodes[k % nodes.len()], self.q) - faces::at(node, self.q))
    }

    /// Normal of the surface at the corner `k` of a facet.
    fn normal(&self, facet: usize, k: usize) -> Vector {
        let node = self.surface.facet(facet)[k];
        let weighted = |other: usize| {
            let [a, b] = self.sides(other, node);
            self.normals[other] * (a.cross(&b).norm() / (a.norm_squared() * b.norm_squared()))
        };
        self.around(facet, k).map(weighted).sum::<Vector>().try_normalize(0.0).unwrap_or_default()
    }

    /// How much the surface turns from a facet's middle to its corner `k` along `way`, which leads from there on; nothing where it ends.
    fn turn(&self, facet: usize, k: usize, way: Vector) -> Option<f64> {
        let node = self.surface.facet(facet)[k];
        let goes_on = |other: usize| {
            let ([a, b], normal) = (self.sides(other, node), self.normals[other]);
            let area = a.cross(&b).dot(&normal);
            way.cross(&b).dot(&normal) > -ASIDE * area && a.cross(&way).dot(&normal) > -ASIDE * area
        };
        self.around(facet, k).any(goes_on).then(|| way.dot(&(self.normal(facet, k) - self.normals[facet])))
    }

    /// Mean height of the surface above a facet.
    fn height(&self, facet: usize) -> f64 {
        let nodes = self.surface.facet(facet);
        let sagitta = |k: usize| {
            let next = (k + 1) % nodes.len();
            let edge = faces::at(nodes[next], self.q) - faces::at(nodes[k], self.q);
            let turns = [self.turn(facet, k, -edge), self.turn(facet, next, edge)];
            match turns {
                [Some(a), Some(b)] if a * b > 0.0 => a.signum() * (0.5 * (a + b)).abs().min(2.0 * a.abs().min(b.abs())) / 4.0,
                [Some(a), None] | [None, Some(a)] => a / 4.0,
                _ => 0.0,
            }
        };
        let height = (0..nodes.len()).map(sagitta).sum::<f64>() / 3.0;
        if height.abs() > STRAIGHT * self.surface.facet_size(facet, self.q) { height } else { 0.0 }
    }

    fn raised(&self, facet: usize, heights: &[f64]) -> Raised {
        let count = self.surface.facet(facet).len();
        let mut raised = [0.0; 5];
        for (k, raised) in raised[..count].iter_mut().enumerate() {
            let (number, sum) = self.around(facet, k).fold((0, 0.0), |(number, sum), other| (number + 1, sum + heights[other]));
            *raised = sum / f64::from(number);
        }
        if count == 4 {
            raised[4] = 3.0 * (heights[facet] - 0.25 * raised[..4].iter().sum::<f64>());
        }
        raised
    }
}
