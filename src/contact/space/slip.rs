//! Slip of constraints in space in a step, with gradients and tangent: the kinematics of friction (in the plane: `contact/slip.rs`).
//!
//! The slip of constraint `A` has two components, each linear in the displacement `d = q_1 - q_0` of the step,
//!
//! ```text
//! u_Ak = sum_patches G_Ak(q_mid) d,    G_Ak d = t_k . sum_j w_Aj (P d)_j          [length^3]
//! ```
//!
//! with the weights `w` of the gap, whose sum is zero, and two tangents; curved facets have further weights along their normal
//! (`curve_slip.rs`). `P` removes the rigid motions of `q_mid` from the displacement of
//! a contact element, so that forces have zero resultant and moment, and rigid motions of any size have no slip. `P` is symmetric: the
//! force of multipliers `tau` is `P` applied to `sum_A w_Aj (tau_A1 t_1 + tau_A2 t_2)`.
//!
//! Tangents move with the material of the secondary facet: its first axis, rotated about its normal by a constant angle from the reference
//! configuration, so that the facets around a node agree. Multiplier components keep their meaning from step to step, without transport as
//! a body rotates.

use super::curve_slip::{self, NormalPart, PlaneTangents};
use super::facet_profile::Profile;
use super::rigid_part::RigidPart;
use super::vectors::{FacetFrame, Vec3, cross, dot, jets, scaled, sub};
use super::vertices::{CORNERS, NODES, OfNodes, UNKNOWNS};
use crate::contact::faces;
use crate::contact::numbers::Number;
use crate::contact::patches::{Evaluation, Patches};
use crate::contact::slip::SlipStep;
use crate::contact::surface::{Sides, Surface};
use crate::integrators::Configuration;
use crate::math::simd::{Kernel, dispatch};

/// Two tangential constraints of a normal constraint, at a configuration of a contact element.
#[derive(Clone)]
pub struct Group<T> {
    /// Index of the normal constraint in the contact element.
    pub place: usize,
    /// Weights of the nodal displacements, with zero sum `[length^2]`.
    pub weights: [T; NODES],
    /// Tangents along which slip is measured, of unit length or that of the curved area per area of the facet.
    pub tangents: [Vec3<T>; 2],
    /// Covered measure of the constraint.
    pub covered: f64,
    /// Weights along the normal of curved facets.
    pub normal: Option<NormalPart<T>>,
}

/// Slip definition of a contact kernel in space.
pub trait SlipGroups {
    /// Tangential constraints of contact element `p` at the positions of its nodes.
    fn groups(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<f64>>;

    /// Tangential constraints of contact element `p` with their derivatives with respect to the positions of its nodes.
    fn differentiated(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<OfNodes>>;

    /// Motion in the step of the other side, if it is an obstacle; rigid motions of a contact element then have slip. `None` for two
    /// surfaces.
    fn carrier(&self) -> Option<Carrier> {
        None
    }
}

/// Slip definition by one formula for numbers with and without derivatives.
pub trait SlipsInSpace {
    /// Tangential constraints of contact element `p` at the positions of its nodes.
    fn groups<T: Number>(&self, p: usize, z: &[Vec3<T>]) -> Vec<Group<T>>;

    /// Motion in the step of the other side, if it is an obstacle; `None` for two surfaces.
    fn carrier(&self) -> Option<Carrier> {
        None
    }
}

impl<K: SlipsInSpace> SlipGroups for K {
    fn groups(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<f64>> {
        SlipsInSpace::groups(self, p, z)
    }

    fn differentiated(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<OfNodes>> {
        SlipsInSpace::groups(self, p, &jets(z.as_flattened(), 0))
    }

    fn carrier(&self) -> Option<Carrier> {
        SlipsInSpace::carrier(self)
    }
}

/// Rigid motion in a step: displacement `o(x) = shift + turn x (x - center)` of a point `x` in mid-step.
///
/// With the length `2 tan(angle/2)` of `turn`, points of a rotating circle move by the chords of their arcs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Carrier {
    /// Displacement of the center `[length]`.
    pub shift: Vec3<f64>,
    /// Vector along the axis with twice the tangent of half the rotation angle as length.
    pub turn: Vec3<f64>,
    /// Point of the axis in mid-step `[length]`.
    pub center: Vec3<f64>,
}

impl Carrier {
    /// Displacement `moved` of a point at `x` at mid-step, relative to the rigid motion.
    fn against(&self, moved: Vec3<f64>, x: Vec3<f64>) -> Vec3<f64> {
        sub(sub(moved, self.shift), cross(self.turn, sub(x, self.center)))
    }
}

impl Group<OfNodes> {
    fn values(&self) -> Group<f64> {
        let tangents = self.tangents.map(|tangent| tangent.map(|x| x.re));
        let normal = self.normal.as_ref().map(NormalPart::values);
        Group { place: self.place, weights: self.weights.map(|w| w.re), tangents, covered: self.covered, normal }
    }
}

impl Group<f64> {
    /// Gradient of the slip along a tangent with respect to the displacements of `count` nodes, with their rigid motions.
    fn row(&self, tangent: usize, count: usize) -> Vec<Vec3<f64>> {
        let mut row: Vec<Vec3<f64>> = self.weights[..count].iter().map(|weight| scaled(self.tangents[tangent], *weight)).collect();
        if let Some(NormalPart { normal, weights }) = &self.normal {
            row.iter_mut().zip(&weights[tangent]).for_each(|(row, weight)| (0..3).for_each(|i| row[i] += weight * normal[i]));
        }
        row
    }
}

/// Tangential constraints of the secondary nodes of a facet, from the weights, covered measures and axes of the facet, with the tangents of
/// each node in its plane.
pub fn groups_of<T: Number>(
    weights: &[[T; NODES]],
    covered: [f64; CORNERS],
    [first, second, _]: [Vec3<T>; 3],
    tangents: &[PlaneTangents],
) -> Vec<Group<T>> {
    let group = |(place, tangents): (usize, &PlaneTangents)| {
        let tangents = tangents.map(|[x, y]| -> Vec3<T> { std::array::from_fn(|i| first[i] * x + second[i] * y) });
        Group { place, weights: weights[place], tangents, covered: covered[place], normal: None }
    };
    tangents.iter().enumerate().map(group).collect()
}

/// Evaluates slips (as gaps of `out`), their gradients at the end of the step, the gradients that transmit forces, and if requested the
/// tangent for the multipliers `lambda`; coverage is the covered measure in mid-step.
pub fn evaluate(kernel: &impl SlipGroups, sides: &Sides, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
    let patches = sides.slip_patches();
    out.begin_live(patches, lambda.len());
    let mut patch = Patch::default();
    for p in (0..patches.len()).filter(|&p| step.live[p]) {
        patches.gather_into(p, step.q_0, &mut patch.middle);
        patches.gather_into(p, step.q_1, &mut patch.end);
        patches.gather_into(p, step.moved, &mut patch.moved);
        patch.middle.iter_mut().zip(&patch.end).for_each(|(start, end)| *start = 0.5 * (*end + *start));
        patch.evaluate(kernel, (patches, p), step, lambda, out);
    }
}

/// Positions and displacements of a contact element's nodes, reused for all elements.
#[derive(Default)]
struct Patch {
    middle: Vec<f64>,
    end: Vec<f64>,
    moved: Vec<f64>,
}

impl Patch {
    /// Evaluates contact element `p`, unless it has no slip.
    fn evaluate(&self, kernel: &impl SlipGroups, (patches, p): (&Patches, usize), step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let (rows, carrier, width) = (patches.rows(p), kernel.carrier(), self.middle.len());
        let mut motion: Vec<Vec3<f64>> = self.moved.as_chunks().0.to_vec();
        if let Some(carrier) = &carrier {
            motion.iter_mut().zip(self.middle.as_chunks().0).for_each(|(moved, x)| *moved = carrier.against(*moved, *x));
        }
        let is_loaded = step.wants_tangent && rows.iter().any(|&row| lambda[row as usize] != 0.0);
        // Without motion slips are zero at any positions.
        let is_still = carrier.is_none_or(|carrier| carrier.turn == [0.0; 3]) && motion.iter().all(|moved| *moved == [0.0; 3]);
        let acts_there = step.test == Configuration::Middle;
        let middle = Place::new(kernel, p, &self.middle, !is_still || (is_loaded && acts_there));
        if middle.groups.is_empty() {
            return;
        }
        out.open(patches, p, is_loaded);
        let (block, square) = (out.gradient_range(patches, p), out.tangent_range(patches, p));
        if !is_still {
            middle.add_slopes(&motion, carrier, width, &mut out.gradient_end[block.clone()]);
        }
        for (group, k) in middle.groups.iter().flat_map(|group| [(group, 0), (group, 1)]) {
            let (row, gradient) = (rows[2 * group.place + k] as usize, middle.row(group, k));
            out.gap[row] += gradient.iter().zip(&motion).map(|(gradient, moved)| dot(*gradient, *moved)).sum::<f64>();
            out.coverage[row] += group.covered;
            let begin = block.start + (2 * group.place + k) * width;
            out.gradient_end[begin..begin + width].iter_mut().zip(gradient.as_flattened()).for_each(|(sum, part)| *sum += part);
        }
        let acting = if acts_there { middle } else { Place::new(kernel, p, &self.end, is_loaded) };
        for (group, k) in acting.groups.iter().flat_map(|group| [(group, 0), (group, 1)]) {
            let begin = block.start + (2 * group.place + k) * width;
            out.gradient_bar[begin..begin + width].copy_from_slice(acting.row(group, k).as_flattened());
        }
        if is_loaded {
            let shears: Vec<[f64; 2]> =
                acting.groups.iter().map(|group| [0, 1].map(|k| lambda[rows[2 * group.place + k] as usize])).collect();
            acting.write_tangent(&shears, step.test.share(), width, &mut out.tangent[square]);
        }
    }
}

/// Tangential constraints of a contact element at the positions of its nodes.
struct Place {
    groups: Vec<Group<f64>>,
    /// Constraints with derivatives; empty if none are required.
    slopes: Vec<Group<OfNodes>>,
    /// Number of nodes.
    count: usize,
    /// Rigid motions of the nodes; `None` against an obstacle.
    rigid: Option<RigidPart>,
}

impl Place {
    fn new(kernel: &impl SlipGroups, p: usize, z: &[f64], has_slopes: bool) -> Self {
        let z = z.as_chunks().0;
        let slopes = if has_slopes { kernel.differentiated(p, z) } else { Vec::new() };
        let groups = if has_slopes { slopes.iter().map(Group::values).collect() } else { kernel.groups(p, z) };
        Place { groups, slopes, count: z.len(), rigid: kernel.carrier().is_none().then(|| RigidPart::new(z)) }
    }

    /// Vectors without the rigid motion that they contain.
    fn relative(&self, mut vectors: Vec<Vec3<f64>>) -> Vec<Vec3<f64>> {
        self.rigid.iter().for_each(|rigid| rigid.remove_from(&mut vectors));
        vectors
    }

    /// Gradient of a slip with respect to the node displacements, one vector per node.
    fn row(&self, group: &Group<f64>, tangent: usize) -> Vec<Vec3<f64>> {
        self.relative(group.row(tangent, self.count))
    }

    /// Adds the derivatives of the slips for constant displacements `motion`, half of the positions at the end being that in mid-step.
    fn add_slopes(&self, motion: &[Vec3<f64>], carrier: Option<Carrier>, width: usize, out: &mut [f64]) {
        for (group, k) in self.groups.iter().flat_map(|group| [(group, 0), (group, 1)]) {
            let row = group.row(k, self.count);
            let turned = match (&self.rigid, carrier) {
                (Some(rigid), _) => rigid.gradient(&row, motion),
                (None, Some(Carrier { turn, .. })) => row.iter().map(|row| cross(turn, *row)).collect(),
                (None, None) => continue,
            };
            let begin = (2 * group.place + k) * width;
            out[begin..begin + width].iter_mut().zip(turned.as_flattened()).for_each(|(sum, slope)| *sum += 0.5 * slope);
        }
        let motion = self.relative(motion.to_vec());
        dispatch(SlipSlopes { groups: &self.slopes, motion: &motion, width, out });
    }

    /// Writes `share` times the derivatives of the forces of the multipliers `shears`, row-major.
    fn write_tangent(&self, shears: &[[f64; 2]], share: f64, width: usize, out: &mut [f64]) {
        let mut forces = vec![[0.0; 3]; self.count];
        for (group, shears) in self.groups.iter().zip(shears) {
            for (k, shear) in shears.iter().enumerate() {
                forces.iter_mut().zip(group.row(k, self.count)).for_each(|(sum, row)| (0..3).for_each(|i| sum[i] += shear * row[i]));
            }
        }
        dispatch(ForceSlopes { groups: &self.slopes, shears, rigid: self.rigid.as_ref(), forces: &forces, share, width, out });
    }
}

/// Derivatives of slips by those of weights and tangents, for displacements without the rigid motion that they contain.
struct SlipSlopes<'a> {
    groups: &'a [Group<OfNodes>],
    motion: &'a [Vec3<f64>],
    width: usize,
    out: &'a mut [f64],
}

impl Kernel for SlipSlopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        for group in self.groups {
            let mut sum = [0.0; 3];
            for (weight, moved) in group.weights.iter().zip(self.motion) {
                for i in 0..3 {
                    sum[i] += weight.re * moved[i];
                }
            }
            for (k, tangent) in group.tangents.iter().enumerate() {
                let mut slopes = [0.0; UNKNOWNS];
                for (weight, moved) in group.weights.iter().zip(self.motion) {
                    let along = tangent[0].re * moved[0] + tangent[1].re * moved[1] + tangent[2].re * moved[2];
                    for lane in 0..UNKNOWNS {
                        slopes[lane] += weight.eps[lane] * along;
                    }
                }
                for i in 0..3 {
                    for lane in 0..UNKNOWNS {
                        slopes[lane] += tangent[i].eps[lane] * sum[i];
                    }
                }
                if let Some(normal) = &group.normal {
                    normal.add_slopes(k, self.motion, &mut slopes);
                }
                let begin = (2 * group.place + k) * self.width;
                for (out, slope) in self.out[begin..begin + self.width].iter_mut().zip(&slopes) {
                    *out += 0.5 * slope;
                }
            }
        }
    }
}

/// Derivatives of the forces of multipliers.
struct ForceSlopes<'a> {
    groups: &'a [Group<OfNodes>],
    shears: &'a [[f64; 2]],
    rigid: Option<&'a RigidPart>,
    /// Forces with the rigid motion that they contain.
    forces: &'a [Vec3<f64>],
    share: f64,
    width: usize,
    out: &'a mut [f64],
}

impl Kernel for ForceSlopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let mut slopes = [[[0.0; UNKNOWNS]; 3]; NODES];
        for (group, shear) in self.groups.iter().zip(self.shears) {
            let [first, second] = &group.tangents;
            for i in 0..3 {
                let (along, mut turn) = (first[i].re * shear[0] + second[i].re * shear[1], [0.0; UNKNOWNS]);
                for lane in 0..UNKNOWNS {
                    turn[lane] = first[i].eps[lane] * shear[0] + second[i].eps[lane] * shear[1];
                }
                for (slopes, weight) in slopes.iter_mut().zip(&group.weights) {
                    for lane in 0..UNKNOWNS {
                        slopes[i][lane] += weight.eps[lane] * along + weight.re * turn[lane];
                    }
                }
            }
            if let Some(normal) = &group.normal {
                normal.add_force_slopes(shear, &mut slopes);
            }
        }
        if let Some(rigid) = self.rigid {
            rigid.remove_from_slopes(self.forces, &mut slopes);
        }
        for (row, slopes) in self.out.chunks_exact_mut(self.width).zip(slopes.as_flattened()) {
            for (out, slope) in row.iter_mut().zip(slopes) {
                *out = self.share * slope;
            }
        }
    }
}

/// Tangents at a rigid obstacle with the given normal; the first one is the projection of a coordinate axis on the tangent plane.
pub fn tangents<T: Number>(normal: Vec3<T>, axis: usize) -> [Vec3<T>; 2] {
    let mut along = normal.map(|n| -n * normal[axis]);
    along[axis] += T::from(1.0);
    let first = scaled(along, dot(along, along).sqrt().recip());
    [first, cross(normal, first)]
}

/// Index of the coordinate axis with the largest angle to a normal.
pub fn farthest_axis(normal: [f64; 3]) -> usize {
    (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0)
}

/// Linear extrapolation of a function from its value and derivative at `z`, so that numbers with derivatives carry this derivative.
pub fn linear<T: Number>(value: f64, derivative: &[f64], z: &[Vec3<T>]) -> T {
    let by = |sum: T, (slope, z): (&f64, &T)| sum + (*z - z.re()) * *slope;
    derivative.iter().zip(z.as_flattened()).fold(T::from(value), by)
}

/// Tangents at the nodes of each facet, in the axes of the facet, see [`curve_slip::tangents`].
pub fn plane_tangents(surface: &Surface, reference: &[f64], profiles: &[Profile]) -> Vec<Vec<PlaneTangents>> {
    let of_facet = |(facet, turns): (usize, Vec<[f64; 2]>)| {
        let nodes: Vec<Vec3<f64>> = surface.facet(facet).iter().map(|&node| faces::at(node, reference).into()).collect();
        curve_slip::tangents(&profiles[facet], &nodes, turns)
    };
    turns(surface, reference).into_iter().enumerate().map(of_facet).collect()
}

/// Cosine and sine of the angle between the first axis of each facet and the first tangent of each of its nodes. A node's tangent is that
/// of its first facet, projected to the mean tangent plane.
fn turns(surface: &Surface, reference: &[f64]) -> Vec<Vec<[f64; 2]>> {
    let axes = |facet: usize| {
        let nodes: Vec<Vec3<f64>> = surface.facet(facet).iter().map(|&node| faces::at(node, reference).into()).collect();
        FacetFrame::new(&nodes).map(|frame| frame.axes)
    };
    let axes: Vec<Option<[Vec3<f64>; 3]>> = (0..surface.count()).map(axes).collect();
    let along: Vec<Option<Vec3<f64>>> = (0..surface.nodes().len())
        .map(|index| {
            let facets = surface.adjacent_facets(index);
            let mut normal = [0.0; 3];
            for axes in facets.iter().filter_map(|&facet| axes[facet as usize]) {
                (0..3).for_each(|i| normal[i] += axes[2][i]);
            }
            let first = axes[*facets.first()? as usize]?[0];
            let square = dot(normal, normal);
            let out = if square > 0.0 { dot(first, normal) / square } else { 0.0 };
            Some(sub(first, scaled(normal, out)))
        })
        .collect();
    let of_facet = |facet: usize| {
        let turn = |&node: &u32| {
            let (Some([first, second, _]), Some(along)) = (axes[facet], along[node as usize]) else { return [1.0, 0.0] };
            let [x, y] = [dot(first, along), dot(second, along)];
            let size = x.hypot(y);
            if size > 0.0 { [x / size, y / size] } else { [1.0, 0.0] }
        };
        surface.local_facet(facet).iter().map(turn).collect()
    };
    (0..surface.count()).map(of_facet).collect()
}
