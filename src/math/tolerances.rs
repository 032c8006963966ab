//! All tolerances of the program, with their meaning and the reason of their size.

mod energies;
mod friction;
mod meshes;
mod plasticity;
mod steps;
mod surfaces;

pub use energies::*;
pub use friction::*;
pub use meshes::*;
pub use plasticity::*;
pub use steps::*;
pub use surfaces::*;

/// Newton's default: the energy `|r.dq| + |lambda.Phi|` that the residual can still move, relative to the energy scale. Well above
/// round-off (1e-16) and a hundred times below the admissible defect of 1e-11 per step.
pub const NEWTON_ENERGY: f64 = 1e-13;

/// Factor of [`NEWTON_ENERGY`] in a step after the accumulated defect has reached [`DEFECT`]: a million such steps add far less.
pub const EXACT: f64 = 1e-6;

/// Default tolerance of adaptive steps: growth of the position error in a step, relative to the length of the bodies' paths. An error of
/// this size is just visible in a picture.
pub const STEP_ERROR: f64 = 1e-3;

/// Weight of the momentum defect of a residual in the energy criterion of Newton's method. With the default tolerance a step ends with a
/// momentum defect of 5e-12 of the momentum that belongs to its energy. With five times the weight, steps of plastic flow are halved
/// (`tests/scripts/plasticity.rhai`).
pub const NEWTON_MOMENTUM: f64 = 0.01;

/// Relative force residual below which energy alone decides convergence: guards against a residual orthogonal to the increment.
pub const NEWTON_FORCE: f64 = 1e-7;

/// Energy criterion of Newton's method for intermediate equilibria.
pub const ON_THE_WAY: f64 = 1e-8;

/// Round-off floor of the force residual, relative to stiffness times size: a body at rest must converge, too.
pub const FORCE_FLOOR: f64 = 1e-14;

/// Unbalanced force that `settle` (damped motion to an equilibrium) accepts at rest, for a connected component relative to the sum of the
/// forces on it, for a node relative to the largest of these forces: ten times below the required 1e-10.
pub const BALANCE: f64 = 1e-11;

/// Relative difference of the accelerations of two bodies below which they count as equal (free fall): round-off of sums over many nodes.
pub const ALIKE: f64 = 1e-9;

/// Stiffness of the supports against a rigid motion, relative to their largest stiffness, below which this motion counts as free.
pub const HELD: f64 = 1e-10;

/// Component of a vector orthogonal to the Lanczos basis, relative to the vector, that is round-off: the operator has errors of 1e-14.
pub const LANCZOS_DEPENDENT: f64 = 1e-11;

/// Residual of a vibration mode relative to its eigenvalue of the inverse operator; the frequency error is of the order of its square.
pub const MODE_RESIDUAL: f64 = 1e-8;

/// Relative distance above the last buckling load factor found, at which the inertia of the stiffness counts the factors below: above
/// round-off, below the next factor.
pub const COUNTED_BEYOND: f64 = 1e-4;

/// Distance of two eigenvalues, relative to their distance from the shift, below which counts of eigenvalues between them are unreliable.
pub const MODE_GAP: f64 = 1e-7;

/// Shift of the eigenvalue problem, relative to the squared wave frequency of the slowest component: far below the first vibration except
/// of very slender bodies, far above round-off of rigid motions.
pub const MODE_SHIFT: f64 = 1e-3;

/// Effective mass of a mode, relative to the mass of the model, that is reported as zero. It is the square of a sum whose round-off is
/// 1e-16 to 1e-14, with a margin for large models.
pub const EFFECTIVE_MASS: f64 = 1e-12;

/// Round-off of an eigenvalue, relative to the largest ratio of a diagonal stiffness entry to its mass; smaller values are set to zero.
pub const MODE_FLOOR: f64 = 1e-14;

/// Fraction of the load increment for difference quotients: most loads are linear, and smaller fractions amplify round-off.
pub const LOAD_DIFFERENCE: f64 = 1e-3;

/// Residual of an equilibrium on a load path, relative to the largest force: a tenth of the tolerance `BALANCE` of a damped relaxation. A
/// correction below this fraction of the displacements is negligible.
pub const PATH: f64 = 1e-12;

/// Relative residual at which an equilibrium on a load path is accepted if corrections no longer halve it: round-off of stiff cells.
pub const PATH_STUCK: f64 = 1e-8;

/// Relative asymmetry of a stiffness matrix that exceeds round-off and indicates follower loads.
pub const ASYMMETRY: f64 = 1e-9;

/// Weighted gap that counts as closed, relative to the square of the shortest secondary facet (Newton's target).
pub const GAP: f64 = 1e-12;

/// Round-off floor of the weighted gap, relative to the largest coordinate times the facet size: a few units in the last place.
pub const GAP_FLOOR: f64 = 2e-15;

/// Distance from the axis of revolution, relative to the largest coordinate, below which a node is moved onto the axis: round-off of
/// rotated or translated meshes, far below any intended facet.
pub const AXIS: f64 = 1e-12;

/// Distance, in shortest secondary facets, below which a node on the axis of revolution counts as touching: its weight is zero, so that no
/// contact force could close its weighted gap.
pub const TOUCHES_ON_AXIS: f64 = 1e-3;

/// Weighted gap at the start of a step that counts as closed for the `persistency` rule, relative to the square of the shortest secondary
/// facet. Well above Newton's gap tolerance: a node that the last step closed up to this tolerance must not count as open, since the rule
/// would exclude it from then on. A thousand times below visible gaps.
pub const CLOSED: f64 = 1e-9;

/// Relative strain increment below which the correction term of the discrete gradient is dropped: the correction is then 1e-16 of the
/// stress, and its derivative a quotient of two round-off values.
pub const STRAIN_INCREMENT: f64 = 1e-8;

/// Strain increment `|dE|` above which the difference quotient of the energy is accurate; below it, a five-point Lobatto rule replaces the
/// quotient and is exact to round-off.
pub const STRAIN_QUOTIENT: f64 = 5e-3;

/// Change of the mean volume ratio above which a difference quotient of the energy is used for energies with kinks in their slope. At this
/// size, the square root of 1e-16, the round-off of the quotient equals the quadrature error at a kink.
pub const KINK_QUOTIENT: f64 = 1e-8;

/// Change of the thickness strain of plane stress at which its Newton iteration ends; convergence is quadratic.
pub const THICKNESS_STRAIN: f64 = 1e-10;

/// Change of the invariants of a facet pair, relative to these, below which the correction of the discrete gradient may be round-off.
pub const INVARIANT_INCREMENT: f64 = 1e-5;

/// Increment of a contact element without its rigid part, relative to the size of the element, below which the correction of the projected
/// discrete gradient is dropped: the round-off 1e-16 of the numerator would give an error of 1e-9 of the contact force, which disturbs
/// Newton's method.
pub const PROJECTED_INCREMENT: f64 = 1e-7;

/// Relative change of a gas volume in a step above which the derivative of the mean pressure is a difference quotient, with a relative
/// round-off of 1e-16/1e-5. Below, the derivative at mid-step is used, with an error of the order of the squared change.
pub const VOLUME_CHANGE: f64 = 1e-5;

/// Round-off of differences of positions, relative to the positions. Invariants of sticking surfaces hardly change, and a remainder of the
/// discrete gradient of this size is ignored.
pub const POSITION: f64 = 4e-16;

/// Remainder of a discrete gradient, relative to its terms, that is round-off. In increments so small that the remainder of a smooth
/// function is round-off, only larger remainders, which kinks cause, are corrected.
pub const REMAINDER: f64 = 4e-15;

/// Curvature of an obstacle's distance along an edge, as the deviation from a linear function relative to the edge length, below which no
/// interior point of the edge is deepest: the edge is parallel to a cylinder or cone, and constraints at its end nodes suffice.
pub const LIES_ALONG: f64 = 1e-6;

/// Distance of a primary from a secondary node, in secondary facets, within which they count as aligned: a thousand times the distance due
/// to round-off and elastic waves in matching meshes before an impact.
pub const ALIGNED: f64 = 1e-4;

/// Distance beyond the end of a chain of facets, in facet lengths, at which a node still counts as opposite the end facet: nodes of bodies
/// with flush ends after deformation.
pub const CHAIN_END: f64 = 1e-6;

/// Smallest extent of a primary facet in the secondary coordinate for which the two count as facing each other.
pub const FACING: f64 = 1e-6;

/// Projected area of a triangle of a space facet along the normal of the opposite facet, relative to the triangle's area, below which the
/// two facets do not face each other.
pub const FACING_AREA: f64 = 1e-9;

/// Width of the zone near coincident edges of two facets in space, in heights of a triangle, in which the contact force passes gradually
/// from one facet to the other. Newton's method diverges at a kink; the zone is narrow compared with a facet.
pub const EDGES_MEET: f64 = 0.01;

/// Cosine of the angle between the normals of two facets above which they form no pair: facing facets have -1, the flank of a needle of 24
/// degrees on a flat side -0.2; gaps between nearly perpendicular facets are steep and meaningless.
pub const OPPOSITE: f64 = -0.1;

/// Gap, in shortest secondary facets, above which a facet pair that begins to overlap changes the constraint gradient too abruptly for
/// Newton's method. With half a facet, steps with piles of bodies found no solution; flush bodies and curved facets have gaps of a
/// hundredth of a facet.
pub const FAR_SLIVER: f64 = 0.05;

/// Cosine of the angle between two facets of a surface above which their common node has one normal: up to 45 degrees, an octagon's.
pub const SMOOTH: f64 = 0.7;

/// Cosine of the angle between the normals of a secondary node and a primary facet above which both sides face the same way and cannot
/// touch: facing facets have -1, the sharpest corners approach 0.
pub const SAME_WAY: f64 = 0.5;

/// Sliding distance of two surfaces within a step, in secondary facets, above which the step is halved beforehand. Larger steps skip
/// facets: a bearing loses half of its spin to vibrations within two turns although its energy is exact (at 0.9 it keeps 0.999 of the
/// spin).
pub const SLIDING: f64 = 0.9;

/// Predicted penetration of an open node within a step of the persistency rule, in secondary facets, above which the step is halved
/// beforehand, because this rule keeps an existing penetration.
pub const APPROACH: f64 = 0.08;

/// Depth of a node behind the other side in a converged step of the persistency rule, in secondary facets, above which the step is undone.
/// Larger than [`APPROACH`], since elastic motion is not predicted and an undone step has cost all its iterations.
pub const CAME_THROUGH: f64 = 0.09;

/// Growth of a node's penetration within a step of the persistency rule, in secondary facets, above which a step that exceeds
/// [`CAME_THROUGH`] is undone. Slower growth would continue in halved steps.
pub const SUNK_DEEPER: f64 = 0.03;

/// Change of a node's distance from a rigid disk or polyline within a step, in facet lengths, above which the step is halved beforehand:
/// beyond the obstacle the contact force would have the wrong direction or be missing.
pub const PASSING: f64 = 1.0;

/// Path of a node in a step, in shortest secondary facets, up to which it may cross a rigid obstacle, for example at a sharp corner.
pub const CROSSING: f64 = 0.1;

/// Penetration of a corner node, in shortest secondary facets, that its own constraint admits: half of the penetration documented for a
/// sharp corner, far above the nodal penetration that weighted constraints leave on flat surfaces.
pub const CORNER_SLACK: f64 = 0.02;

/// Penetration in shortest secondary facets above which a run reports it: the documented limit of a tenth of a facet.
pub const DEPTH: f64 = 0.1;

/// Distance, in facets, by which a node is moved outwards before the test whether it lies inside another body or another part of its own
/// body: far above round-off of positions, far below relevant depths.
pub const BESIDE: f64 = 1e-6;

/// Penetration in the initial equilibrium, in the longest facets nearby, above which sides without contact force are an error. Contact
/// search covers half a facet, so that a deeper overlap had no constraint; interlocking polygons and weighted gaps leave a tenth.
pub const LEFT: f64 = 0.5;

/// Penetration through the hull of another body, in the shorter facets nearby, at which an equilibrium without contact force is refused.
pub const LEFT_PASSED: f64 = 0.25;

/// Penetration in the initial equilibrium, in the longest facets nearby, up to which an overlap at a contact with positive multipliers is
/// accepted: active constraints leave a tenth.
pub const LEFT_HELD: f64 = 1.0;

/// Rotation of a cell of linear elasticity `[rad]` above which the cell is reported: half of the squared angle appears as spurious strain.
pub const TURNED: f64 = 0.1;

/// Stretch of a cell of Saint Venant-Kirchhoff material below which it is reported: the compressive stress decreases below the stretch
/// `sqrt(1/3) = 0.577`.
pub const CRUSHED: f64 = 0.6;

/// Jump of a prescribed motion, relative to the extent of the model, above which it is reported: more than round-off.
pub const JUMP: f64 = 1e-9;

/// Ratio of kinetic to strain energy up to which bodies count as being at rest.
pub const AT_REST: f64 = 1e-6;

/// Estimated relative stress error at rest from which the mesh is reported as coarse: its square, 6 %, is about the stiffness error.
pub const COARSE: f64 = 0.25;

/// Work that contact adds in a step, relative to all energy, above which it is reported: no contact rule adds energy except by round-off.
pub const GIVEN: f64 = 1e-10;

/// Energy defect of a step, in units of Newton's tolerance, above which it is reported: the documented 1e-11 with the default tolerance.
pub const DEFECT: f64 = 100.0;

/// Relative energy defect above which a run does not count as conserving: a thousand steps of round-off stay below.
pub const CONSERVED: f64 = 1e-8;

/// Energy that counts as zero in any units: round-off of a model at rest.
pub const NO_ENERGY: f64 = 1e-40;

/// Energy change in a static step that the work of the forces at both ends of the step does not explain, relative to all energy, above
/// which the step is reported as too large.
pub const LEAP: f64 = 0.05;

/// Energy that contact has dissipated or stores, relative to all energy, above which it is reported: it is then visible in a plot.
pub const LOST: f64 = 1e-3;

/// Step halvings per accepted step, for each cause of failure, above which they are reported; fewer have no noticeable cost.
pub const HALVED: f64 = 0.01;

/// Augmentation of corner constraints in contacts for which no augmentation is given: in initial overlaps corner constraints depend
/// linearly on the surface constraints.
pub const CORNER_AUGMENTATION: f64 = 1e6;
/// Augmentation of surface constraints in space in contacts for which no augmentation is given: constraints over a small part of a facet
/// are nearly linearly dependent. The value has no effect on the convergence of Newton's method.
pub const SURFACE_AUGMENTATION: f64 = 1e8;

/// Admissible resultant momentum of a `velocity` impulse, relative to the sum of its nodal momenta: the documented 1e-11 per step.
pub const PUSH: f64 = 1e-12;

/// Additional momentum tolerance of the velocity filter, relative to the momenta exchanged by the filter's stiffness: in long steps the
/// round-off of these momenta exceeds that of the velocities.
pub const FILTER: f64 = 1e-14;

/// Overlap of an excluded facet pair at the end of a step, in shortest secondary facets, above which the step is repeated with it.
pub const EXCLUDED_OVERLAP: f64 = 1e-6;

/// Uncovered fraction up to which a facet counts as fully covered. At the rims of a press fit the fraction varies with the gap; with a
/// limit at round-off the shape functions would alternate between steps of a damped relaxation to equilibrium.
pub const WHOLE: f64 = 1e-4;

/// Covered fraction of a secondary node's weight function below which the node is excluded: its constraint would be nearly singular.
pub const SLIVER: f64 = 0.02;

/// Largest nodal increment of one Newton iteration, in shortest secondary facets.
pub const STEP_LIMIT: f64 = 0.1;

/// Covered fraction of a node's weight function below which an iteration omits its constraint: a zero row makes the matrix singular.
pub const ZERO_ROW: f64 = 1e-6;

/// Backward error of the linear solve that needs no refinement: three decimal digits above round-off.
pub const LINEAR_REFINED: f64 = 1e-13;

/// Backward error after refinement above which the system is solved again with full column pivoting: good factors leave 1e-14 to 1e-16, so
/// this indicates growth in the factors.
pub const LINEAR_FALLBACK: f64 = 1e-10;

/// Pivot magnitude, in a matrix scaled to entries of order one, below which a pivot is unusable.
pub const LINEAR_PIVOT: f64 = 1e-10;

/// Replacement of a pivot below [`LINEAR_PIVOT`] that avoids growth of the factors: the square root of round-off.
pub const LINEAR_REPLACEMENT: f64 = 1e-8;

/// Norm of the image of a unit vector, for a matrix with entries of order one, that counts as zero: round-off of a row sum.
pub const LINEAR_SINGULAR: f64 = 1e-14;

/// Difference of mirrored entries of order one up to which the distributed solver takes a matrix for symmetric, and refines.
pub const LINEAR_ASYMMETRY: f64 = 1e-13;

/// Backward error of the linear solve after refinement above which the solution is refused.
pub const LINEAR_RESIDUAL: f64 = 1e-8;

/// Residual relative to the right-hand side above which a solution is refused despite a small backward error: such a large solution
/// indicates a numerically singular matrix.
pub const LINEAR_UNSOLVED: f64 = 1e-3;

/// Remaining relative length of a near-null-space vector, orthogonalized on an aggregate of nodes, below which it is dependent there: a
/// single node has no rotations, nodes on one line have none about this line.
pub const AGGREGATE_DEPENDENT: f64 = 1e-6;

/// Share of an interior node in the initial offset of a tie, relative to nodal weights, below which it is round-off of positions and the
/// tie couples the surface nodes only.
pub const TIE_OFFSET: f64 = 1e-12;

/// Largest rotation of a boundary in one increment of the path to an equilibrium `[rad]`.
pub const EIGHTH_TURN: f64 = std::f64::consts::FRAC_PI_4;

/// Ratio of singular values below which prescribed nodes count as collinear, so that they determine no rotation.
pub const TURNS: f64 = 1e-9;

/// Range of the values of a plot or picture, relative to their size, below which they are shown as constant: a scale over round-off would
/// show noise.
pub const FLAT: f64 = 1e-9;

/// Size of the values of a plot below which they count as zero: the power of ten of smaller values is inaccurate.
pub const NOTHING: f64 = 1e-290;

/// Share of a plot's range by which a value may lie outside it and is still drawn: round-off of the range.
pub const PLOT_END: f64 = 1e-9;

/// Height of a point above the plane of a section, relative to the largest one, below which it lies in the plane: round-off of a symmetry
/// plane.
pub const ON_SECTION: f64 = 1e-9;

/// Least side of a picture's bounds relative to the longest side, for bodies without thickness.
pub const PICTURE_THICKNESS: f64 = 1e-3;

/// Deviation of a polygon from its circle, relative to the extent of nearby bodies: half a pixel of a large picture.
pub const PICTURE_ROUNDNESS: f64 = 5e-4;

/// Step of a difference quotient of a time function, relative to the time: the third root of round-off, where truncation and round-off of a
/// central difference are equal.
pub const TIME_DIFFERENCE: f64 = 6e-6;

/// Time below which [`TIME_DIFFERENCE`] is taken relative to this time `[time]`.
pub const SMALL_TIME: f64 = 1e-3;

/// Distance of two times, relative to the step, within which they count as equal: round-off of sums of some thousand steps.
pub const SAME_MOMENT: f64 = 1e-9;

/// Part of the gradient of a tangential constraint that supports must leave free; below it the node counts as fully constrained.
pub const HELD_ROW: f64 = 1e-8;

/// Part of the gap tolerance by which an inactive constraint must be violated on the frozen linearisation to become active.
pub const CLEARLY: f64 = 1e-3;

/// Residual of a step of `settle` (damped motion to an equilibrium), relative to the largest damping force of the step or to the accepted
/// imbalance. An energy criterion is no measure of the residual in models of rigid bodies: with it, five equilibria of a truss took 8 000
/// factorizations.
pub const REST_STEP: f64 = 1e-2;

/// Least damping of a body in a damped relaxation to equilibrium, relative to the stiffness of its slowest elastic motion.
pub const LEAST_DAMPING: f64 = 1e-8;

/// Least damping `d` of a rigid body in a damped relaxation to equilibrium, in units of `F/(m L)` with its loads `F`, mass `m` and extent
/// `L`. Round-off of the constraint forces then moves the body by 1e-14 of its size, and penetrations are inaccurate by a hundredth.
pub const RIGID_DAMPING: f64 = 1e-2;

/// Displacement in a step of a damped relaxation, in facet lengths, below which the bodies count as being at rest.
pub const STANDS: f64 = 1e-3;

/// Resultant force, relative to the sum of the force magnitudes, that counts as balanced in a diagnosis: far above round-off.
pub const EXPLAINED: f64 = 1e-6;

/// Largest non-rigid part of a null vector, relative to the vector, for which messages describe it as a rigid motion.
pub const RIGID: f64 = 1e-5;

/// Relative difference below which two values of a finding count as equal, so that round-off does not decide which place is reported.
pub const EQUAL: f64 = 1e-6;

/// Deviation of an angle from a multiple of a quarter turn, in quarter turns, that is round-off of the conversion from degrees.
pub const QUARTER_TURN: f64 = 1e-12;

/// Default relative tolerance of `expect_close`.
pub const CLOSE: f64 = 1e-9;

/// Default relative tolerance between a run and that of the moved model: round-off of some hundred steps of a collision.
pub const INVARIANT: f64 = 1e-7;

/// Relative error below which no order of convergence is computed from differences: they are round-off.
pub const ORDER_ROUND_OFF: f64 = 1e-13;

/// Squared off-diagonal entry, relative to the squared matrix norm, at which Jacobi rotations end: a hundredth of round-off.
pub const DIAGONAL: f64 = 1e-36;

/// Largest entry of an eliminated constraint, relative to its largest original entry, below which it is redundant.
pub const DEPENDENT: f64 = 1e-9;

/// Entry of a constraint, relative to its largest, that elimination sets to zero.
pub const NEGLIGIBLE_ENTRY: f64 = 1e-14;

/// Largest sum of squared factors from cell values to a nodal value for which a patch determines a slope: slightly above the 9/4 of two by
/// two cells at a corner.
pub const RECOVERY_AMPLIFICATION: f64 = 2.5;

/// Stress of an energy at zero strain, relative to its cancelling terms, that is round-off of the constants.
pub const RESIDUAL_STRESS: f64 = 1e-14;

/// Stress on the free faces of a test piece, relative to its stiffness, that counts as zero: round-off of nearly incompressible laws.
pub const FREE_STRESS: f64 = 1e-13;

/// Relative decrease of the sum of squares in a step below which a fit has converged.
pub const FIT: f64 = 1e-10;

/// Relative step of the difference quotients of a fit: the third root of round-off; also the initial damping.
pub const FIT_DIFFERENCE: f64 = 1e-5;

/// Deviation from linearity, relative to the stresses, up to which stresses count as linear in a constant: round-off.
pub const FIT_LINEAR: f64 = 1e-10;

/// Relative singular value below which the data do not determine a direction of a fit.
pub const FIT_RANK: f64 = 1e-12;

/// Distance of an arc's end from its circle, relative to the radius, that counts as rounding of the input: three digits.
pub const ON_CIRCLE: f64 = 1e-3;

/// Relative round-off of a sum of a thousand lengths.
pub const SUM_OF_LENGTHS: f64 = 1e-12;

/// Default resolution of a minimization, relative to the range between bounds: six digits, as accurate as a simulation.
pub const MINIMIZED: f64 = 1e-6;

/// Distance of a node of a rigid body from the plane of the other master nodes, relative to the body size, below which the nodes count as
/// coplanar: coefficients of nodes in the masters would exceed 1e6.
pub const FLAT_FRAME: f64 = 1e-6;

/// Relative difference of two distances below which two nodes count as equally far, and the lower index becomes master of the rigid body.
/// Otherwise round-off of a translated mesh would choose other masters, whose velocities in a step differ by its discretization error
/// (`tests/scripts/multibody.rhai`).
pub const EQUALLY_FAR: f64 = 1e-9;

/// Relative residual of a constraint between points (Newton's target): joints hold to 1e-12 of the size of the joined bodies.
pub const JOINT: f64 = 2e-13;

/// Distance between the two points of a joint, relative to the model size, above which the joint is refused as open.
pub const JOINT_APART: f64 = 1e-9;

/// Distance of a joint's point from a node, relative to the cell size, up to which the joint acts on that node.
pub const SAME_NODE: f64 = 1e-6;

/// Difference between the initial value of a drive and the present coordinate of its joint, relative to the model size or in radians, above
/// which the drive would jump.
pub const DRIVE_AT_REST: f64 = 1e-9;

/// Largest angle between the stops of a hinge `[rad]`: slightly below a turn, so that a step cannot jump over both.
pub const WIDEST_ANGLE: f64 = 6.0;

/// Separation rate of a joint at the start, relative to the largest velocity, above which initial velocities violate the joint.
pub const LOOSE_JOINT: f64 = 1e-6;

/// Relative error of `omega^2` of the fastest vibration; half of this is the relative error of the stable step.
pub const FASTEST: f64 = 0.005;

/// Displacement of difference quotients of forces for the fastest vibration, relative to the model extent: a strain of 1e-5 in cells of a
/// hundredth of it.
pub const SMALL_MOTION: f64 = 1e-7;

/// Energy without a source, relative to initial energy plus work, at which an explicit run is stopped as unstable. Near the stability limit
/// the energy of the fastest vibrations oscillates by a factor of about ten.
pub const RAN_AWAY: f64 = 100.0;

/// Residual of a steady vibration in the mass norm, relative to the size of the vibration: a hundredth of the tolerance of comparisons with
/// closed forms.
pub const RESPONSE: f64 = 1e-9;

/// Relative difference of the strain energy of a state from that of the linear model above which linear buckling gives a warning.
pub const LINEAR_STATE: f64 = 0.05;

/// Relative difference of the strain energy from that of the linear model, times the load factor, above which the path to the buckling load
/// counts as nonlinear.
pub const LINEAR_PATH: f64 = 0.2;

/// Norm of a difference of two increments of Newton's method, relative to its norm before orthogonalization, below which it depends
/// linearly on later differences.
pub const SAME_DIRECTION: f64 = 1e-6;
