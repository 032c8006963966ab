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
use super::profiles::Profile;
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;
    use crate::contact::fixtures::{dense_rows_of, difference, evaluated, product, tangent_along, unbalance_in_space};
    use crate::contact::space::{CornersInSpace, MortarInSpace, ObstacleInSpace, ProxySurfacesInSpace, RoundInSpace};
    use crate::contact::{ContactKernel, Obstacle, PredictedMotion, rigid_contact};
    use crate::integrators::Derivative;

    /// Facets of a lower body with three by three nodes.
    const FACETS: [[u32; 4]; 4] = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
    const COUNT: usize = 13;
    const UNKNOWNS: usize = 3 * COUNT;

    fn base() -> Vec<f64> {
        let below = (0..9).flat_map(|k| [f64::from(k % 3), f64::from(k / 3), 0.0]);
        let above = [[0.4, 0.3], [0.5, 1.5], [1.6, 1.7], [1.5, 0.4]].into_iter().flat_map(|[x, y]| [x, y, 0.02]);
        below.chain(above).collect()
    }

    fn kernels(q: &[f64]) -> Vec<Box<dyn ContactKernel>> {
        let faces = [FACETS.map(|facet| facet.to_vec()).to_vec(), vec![vec![9, 10, 11, 12]]];
        let base = base();
        let seen = ProxySurfacesInSpace::new(faces.each_ref().map(|faces| &faces[..]), &base);
        let mut kernels = vec![MortarInSpace::kernel(&seen)];
        kernels.extend(CornersInSpace::kernel(&seen));
        // For dual multipliers: one facet that lies entirely over the other side, so that it is fully covered.
        kernels.push(MortarInSpace::dual_kernel(&ProxySurfacesInSpace::new([&faces[1], &faces[0]], &base)));
        // The lower surface is curved in the reference configuration.
        let bent: Vec<f64> = base
            .chunks(3)
            .enumerate()
            .flat_map(|(k, x)| [x[0], x[1], x[2] - if k < 9 { 0.08 * (x[0] - 1.0).powi(2) } else { 0.0 }])
            .collect();
        for sides in [[&faces[0][..], &faces[1]], [&faces[1], &faces[0]]] {
            kernels.push(MortarInSpace::kernel(&ProxySurfacesInSpace::new(sides, &bent)));
            kernels.push(MortarInSpace::dual_kernel(&ProxySurfacesInSpace::new(sides, &bent)));
            kernels.push(CornersInSpace::of_nodes(&ProxySurfacesInSpace::new(sides, &bent)));
        }
        for kernel in &mut kernels {
            kernel.update_candidates(&PredictedMotion::within(q, 1.0));
            kernel.begin_step(q);
        }
        kernels
    }

    /// Contact kernels of the lower surface with moving round obstacles.
    fn obstacles(q: &[f64], angle: f64) -> Vec<Box<dyn ContactKernel>> {
        let below = Surface::in_space(FACETS.iter().map(|facet| &facet[..]));
        let (point, axis) = ([0.9, 1.1, 0.15], [0.1, 1.0, 0.05]);
        let rod = ObstacleInSpace::Cylinder { point, axis, radius: 0.2, is_hollow: false };
        let ball = ObstacleInSpace::Sphere { center: [0.8, 1.3, 1.9], radius: 2.0, axis: [0.0, 0.0, 1.0], is_hollow: false };
        let mut kernels: Vec<Box<dyn ContactKernel>> =
            vec![rigid_contact(below.clone(), &Obstacle::InSpace(ball), &base(), Default::default())];
        let edges = RoundInSpace::new(&below, &rod, &base(), 1.0);
        kernels.extend(edges.map(|kernel| Box::new(kernel) as Box<dyn ContactKernel>));
        assert_eq!(kernels.len(), 2);
        for kernel in &mut kernels {
            kernel.move_obstacle(&[[0.0; 3], [0.05, -0.02, 0.01], [0.1, -0.04, 0.02]]);
            kernel.carry([0.1, -0.04, 0.02], angle);
            kernel.update_candidates(&PredictedMotion::within(q, 1.0));
            kernel.begin_step(q);
        }
        kernels
    }

    fn shears(rows: usize) -> Vec<f64> {
        (0..rows).map(|k| [1.0, -0.5, 2.0, 0.25, -1.5][k % 5]).collect()
    }

    fn slips(kernel: &dyn ContactKernel, q_0: &[f64], q_1: &[f64], test: Configuration) -> Evaluation {
        let normal = evaluated(kernel, Derivative::DiscreteGradient, q_1, &vec![1.0; kernel.rows()]);
        let (moved, mut out) = (difference(q_1, q_0), Evaluation::default());
        kernel.evaluate_slips(
            SlipStep { q_0, q_1, moved: &moved, test, live: &normal.live, wants_tangent: true },
            &shears(2 * kernel.rows()),
            &mut out,
        );
        out = out.with_room(kernel.slip_patches());
        out
    }

    fn rows(kernel: &dyn ContactKernel, blocks: &[f64]) -> Vec<Vec<f64>> {
        dense_rows_of(kernel.slip_patches(), 2 * kernel.rows(), blocks, UNKNOWNS)
    }

    fn steps() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        let noise = || prop::collection::vec(-0.05..0.05f64, UNKNOWNS);
        let moved = |noise: &[f64], shift: [f64; 3]| -> Vec<f64> {
            base().iter().enumerate().map(|(k, x)| x + noise[k] + if k >= 27 { shift[k % 3] } else { 0.0 }).collect()
        };
        (noise(), noise(), -0.2..0.2f64, -0.2..0.2f64)
            .prop_map(move |(first, second, x, y)| (moved(&first, [0.0; 3]), moved(&second, [x, y, -0.01])))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn shear_forces_work_on_slips_alone_and_are_balanced((q_0, q_1) in steps()) {
            let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
            let moved = difference(&q_1, &q_0);
            for kernel in kernels(&q_0) {
                let out = slips(&*kernel, &q_0, &q_1, Configuration::Middle);
                let bar = rows(&*kernel, &out.gradient_bar);
                for (row, slip) in bar.iter().zip(&out.gap) {
                    prop_assert!((product(row, &moved) - slip).abs() < 1e-14);
                }
                prop_assert!(unbalance_in_space(&bar, &middle) < 1e-13);
                let at_end = slips(&*kernel, &q_0, &q_1, Configuration::End);
                prop_assert!(unbalance_in_space(&rows(&*kernel, &at_end.gradient_bar), &q_1) < 1e-13);
            }
        }

        /// Slip is measured relative to the obstacle's motion: zero if all nodes move with the obstacle.
        #[test]
        fn what_an_obstacle_carries_along_does_not_slide((q_0, q_1) in steps()) {
            let against: Vec<f64> = difference(&q_1, &q_0).iter().enumerate().map(|(k, d)| d - [0.1, -0.04, 0.02][k % 3]).collect();
            let along: Vec<f64> = q_0.iter().enumerate().map(|(k, x)| x + [0.1, -0.04, 0.02][k % 3]).collect();
            for kernel in obstacles(&q_0, 0.0) {
                let out = slips(&*kernel, &q_0, &q_1, Configuration::Middle);
                for (row, slip) in rows(&*kernel, &out.gradient_bar).iter().zip(&out.gap) {
                    prop_assert!((product(row, &against) - slip).abs() < 1e-14);
                }
                prop_assert!(out.gap.iter().any(|slip| *slip != 0.0));
                let out = slips(&*kernel, &q_0, &along, Configuration::Middle);
                prop_assert!(out.gap.iter().all(|slip| slip.abs() < 1e-15), "{:?}", out.gap);
            }
        }

        /// Nodes that rotate with a rod by any angle do not slide on it.
        #[test]
        fn what_turns_with_an_obstacle_does_not_slide((q_0, _) in steps(), angle in -1.0..1.0f64) {
            let (point, shift) = (nalgebra::Vector3::new(0.9, 1.1, 0.15), nalgebra::Vector3::new(0.1, -0.04, 0.02));
            let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(0.1, 1.0, 0.05));
            let rotation = nalgebra::Rotation3::from_axis_angle(&axis, angle);
            let turned = |x: &[f64; 3]| -> [f64; 3] { (point + shift + rotation * (nalgebra::Vector3::from(*x) - point)).into() };
            let along: Vec<f64> = q_0.as_chunks::<3>().0.iter().flat_map(turned).collect();
            let rod = &obstacles(&q_0, angle)[1];
            let out = slips(&**rod, &q_0, &along, Configuration::Middle);
            prop_assert!(out.gap.iter().all(|slip| slip.abs() < 1e-14), "{:?}", out.gap);
        }

        /// A rigid motion of both sides, of any size, has no slip.
        #[test]
        fn a_rigid_motion_has_no_slip((q_0, _) in steps(), angles in prop::array::uniform3(-1.0..1.0f64)) {
            let rotation = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
            let turned = |x: &[f64; 3]| -> [f64; 3] { (rotation * nalgebra::Vector3::from(*x)).add_scalar(2.0).into() };
            let q_1: Vec<f64> = q_0.as_chunks::<3>().0.iter().flat_map(turned).collect();
            for kernel in kernels(&q_0) {
                let out = slips(&*kernel, &q_0, &q_1, Configuration::Middle);
                prop_assert!(out.gap.iter().all(|slip| slip.abs() < 1e-13), "{:?}", out.gap);
            }
        }

        /// Gradients and tangents along a random direction against difference quotients, except at kinks.
        #[test]
        fn gradients_and_tangents_are_derivatives((q_0, q_1) in steps(), direction in prop::collection::vec(-1.0..1.0f64, UNKNOWNS)) {
            for kernel in kernels(&q_0).into_iter().chain(obstacles(&q_0, 0.3)) {
                for test in [Configuration::Middle, Configuration::End] {
                    let out = slips(&*kernel, &q_0, &q_1, test);
                    let at = |width: f64| {
                        let moved: Vec<f64> = q_1.iter().zip(&direction).map(|(q, d)| q + width * d).collect();
                        let out = slips(&*kernel, &q_0, &moved, test);
                        let rows = rows(&*kernel, &out.gradient_bar);
                        let shears = shears(rows.len());
                        let force = (0..UNKNOWNS).map(|k| rows.iter().zip(&shears).map(|(row, shear)| shear * row[k]).sum());
                        out.gap.iter().copied().chain(force).collect::<Vec<f64>>()
                    };
                    let slope = |width: f64| -> Vec<f64> {
                        at(width).iter().zip(at(-width)).map(|(a, b)| (a - b) / (2.0 * width)).collect()
                    };
                    let (fine, coarse) = (slope(1e-4), slope(2e-4));
                    let mut exact: Vec<f64> = rows(&*kernel, &out.gradient_end).iter().map(|row| product(row, &direction)).collect();
                    exact.extend(tangent_along(kernel.slip_patches(), &out.tangent, &direction));
                    for ((exact, fine), coarse) in exact.iter().zip(&fine).zip(&coarse) {
                        let scale = 1.0 + fine.abs();
                        prop_assert!((fine - coarse).abs() > 1e-5 * scale || (exact - fine).abs() < 2e-5 * scale, "{exact} {fine}");
                    }
                }
            }
        }
    }

    /// Closed form: the slip is the sliding distance times the covered measure for any direction, and the facets around a node agree on its
    /// tangents for any numbering.
    #[test]
    fn sliding_by_a_length_is_that_slip() {
        let q_0: Vec<f64> = base().iter().map(|&x| if x == 0.02 { 0.0 } else { x }).collect();
        let by = [0.01, -0.007];
        let q_1: Vec<f64> = q_0.iter().enumerate().map(|(k, x)| if k < 27 && k % 3 < 2 { x + by[k % 3] } else { *x }).collect();
        for facets in [FACETS, [[1, 4, 3, 0], [5, 4, 1, 2], [7, 6, 3, 4], [8, 7, 4, 5]]] {
            let faces = [facets.map(|facet| facet.to_vec()).to_vec(), vec![vec![9, 10, 11, 12]]];
            let mut mortar = MortarInSpace::kernel(&ProxySurfacesInSpace::new(faces.each_ref().map(|faces| &faces[..]), &q_0));
            mortar.update_candidates(&PredictedMotion::within(&q_0, 1.0));
            mortar.begin_step(&q_0);
            let out = slips(&*mortar, &q_0, &q_1, Configuration::Middle);
            for node in 0..9 {
                let size = out.gap[2 * node].hypot(out.gap[2 * node + 1]);
                let expected = by[0].hypot(by[1]) * out.coverage[2 * node] * mortar.weights()[node];
                assert!((size - expected).abs() < 1e-16, "{node}: {size} {expected}");
            }
        }
    }
}
