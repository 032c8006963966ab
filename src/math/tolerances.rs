//! All tolerances of the program, with their meaning and the reason of their size.

mod friction;
mod meshes;
mod plasticity;
mod surfaces;

pub use friction::*;
pub use meshes::*;
pub use plasticity::*;
pub use surfaces::*;

/// Newton's default: the energy `|r.dq| + |lambda.Phi|` that the residual can still move, relative to the energy scale.
/// Well above round-off (1e-16) and a hundred times below the promised defect of 1e-11 per step.
pub const NEWTON_ENERGY: f64 = 1e-13;

/// Part of [`NEWTON_ENERGY`] that is left in a step where those before it have added up to [`DEFECT`]: a million steps of one sign stay far
/// below that.
pub const EXACT: f64 = 1e-6;

/// Default error tolerance of adaptive steps: growth of the error relative to the path of the bodies, just visible in a picture.
pub const STEP_ERROR: f64 = 1e-3;

/// Growth of the error in a step, relative to the displacements, that is due to round-off and Newton's tolerance alone.
pub const STILL: f64 = 1e-12;

/// Error of the positions in a step, relative to the largest coordinate, that is round-off where contacts or rigid bodies depend on
/// positions: differences of three steps of a body that friction holds reach 1e-14.
pub const STILL_AT: f64 = 1e-13;

/// Default of the smallest adaptive step, relative to the first step: timing an impact to it costs some twenty refused steps.
pub const SMALLEST_STEP: f64 = 1e-6;

/// Weight of the momentum defect of a residual in the energy criterion of Newton's method. With the default tolerance a step ends with a
/// momentum defect of 5e-12 of the momentum that belongs to its energy.
pub const NEWTON_MOMENTUM: f64 = 0.01;

/// Force residual, relative to the largest force, below which the energy criterion alone decides: a guard against a residual that
/// happens to be orthogonal to the motion.
pub const NEWTON_FORCE: f64 = 1e-7;

/// Energy criterion of Newton's method for intermediate equilibria.
pub const ON_THE_WAY: f64 = 1e-8;

/// Round-off floor of the force residual, relative to stiffness times size: a body at rest must converge too.
pub const FORCE_FLOOR: f64 = 1e-14;

/// Unbalanced force at rest that `settle` accepts, of a piece relative to the sum of the forces on it, of a node relative to the largest of
/// them: ten times below the promised 1e-10.
pub const BALANCE: f64 = 1e-11;

/// Relative difference of the accelerations of two bodies below which they count as equal (free fall): round-off of sums over many nodes.
pub const ALIKE: f64 = 1e-9;

/// Stiffness of supports against a rigid motion, relative to their largest, below which the motion is free: round-off of node positions.
pub const HELD: f64 = 1e-10;

/// Relative component of a vector outside of the span of a basis that is round-off: the operator is accurate to about 1e-14.
pub const LANCZOS_DEPENDENT: f64 = 1e-11;

/// Residual of a vibration mode relative to its eigenvalue of the inverse operator; the frequency is accurate to the square.
pub const MODE_RESIDUAL: f64 = 1e-8;

/// Relative distance above the last load factor at which the factors below are counted: above round-off, below the next factor.
pub const COUNTED_BEYOND: f64 = 1e-4;

/// Distance of two eigenvalues, relative to that from the shift, below which a count between them is affected by round-off.
pub const MODE_GAP: f64 = 1e-7;

/// Shift of the eigenvalue problem, relative to the square of the frequency with which waves cross the slowest piece: far below the first
/// vibration of any but the most slender bodies, far above the round-off of a rigid motion.
pub const MODE_SHIFT: f64 = 1e-3;

/// Effective mass of a mode, relative to the mass of the model, that is reported as zero: the square of the round-off of a sum, with a
/// margin for large models.
pub const EFFECTIVE_MASS: f64 = 1e-12;

/// Round-off of an eigenvalue relative to the largest stiffness over mass of an unknown: smaller ones are zero.
pub const MODE_FLOOR: f64 = 1e-14;

/// Part of an increment of the load by which loads are differentiated: most are linear, and round-off is divided by it.
pub const LOAD_DIFFERENCE: f64 = 1e-3;

/// Residual of an equilibrium on a path relative to the largest force: a tenth of the tolerance of `settle`. A correction below this share
/// of the displacements is negligible.
pub const PATH: f64 = 1e-12;

/// Residual of an equilibrium on a path, relative to the largest force, that is accepted where a correction no longer halves it: round-off
/// of stiff cells with small strain.
pub const PATH_STUCK: f64 = 1e-8;

/// Asymmetry of a stiffness relative to its largest entry that is more than round-off: loads that follow the surface.
pub const ASYMMETRY: f64 = 1e-9;

/// Weighted gap that counts as closed, relative to the square of the shortest secondary facet (Newton's target).
pub const GAP: f64 = 1e-12;

/// Round-off floor of the weighted gap, relative to the largest coordinate times the facet size: a few units in the last place.
pub const GAP_FLOOR: f64 = 2e-15;

/// Distance from the axis, relative to the largest coordinate of the mesh, up to which a node of a body of revolution is put onto it:
/// round-off of meshes that were turned or moved there, far below any facet that could be meant.
pub const AXIS: f64 = 1e-12;

/// Distance in shortest secondary facets up to which a node on the axis of bodies of revolution touches the other side: its weighted gap
/// has no force that would close it.
pub const TOUCHES_ON_AXIS: f64 = 1e-3;

/// Weighted gap at the start of a step that counts as closed for the `persistency` rule, relative to the square of the shortest secondary
/// facet: well above Newton's gap tolerance, since nodes would be excluded permanently otherwise; a thousand times below visible gaps.
pub const CLOSED: f64 = 1e-9;

/// Strain increment, relative to the strains, below which the correction of the discrete gradient is dropped: it is 1e-16 of the stress
/// there, and its derivative a quotient of two round-offs.
pub const STRAIN_INCREMENT: f64 = 1e-8;

/// Step strain |dE| above which the energy quotient is accurate enough as it stands; below it a five-point Lobatto rule is exact to
/// round-off.
pub const STRAIN_QUOTIENT: f64 = 5e-3;

/// Change of the mean volume ratio above which the energy quotient is used for an energy whose slope has kinks. At this size, the root of
/// 1e-16, round-off of the quotient equals the quadrature error at a kink.
pub const KINK_QUOTIENT: f64 = 1e-8;

/// Change of the strain across the plane at which its Newton iteration ends: the next one would be its square.
pub const THICKNESS_STRAIN: f64 = 1e-10;

/// Change of a contact pair's invariants, relative to the invariants, below which the correction of the discrete gradient may be under
/// round-off.
pub const INVARIANT_INCREMENT: f64 = 1e-5;

/// Increment of a contact element without its rigid part, relative to the size of the element, below which the correction of the projected
/// discrete gradient is dropped: the round-off 1e-16 of the numerator would give an error of 1e-9 of the contact force, which disturbs
/// Newton's method.
pub const PROJECTED_INCREMENT: f64 = 1e-7;

/// Relative change of a gas volume in a step above which the slope of the mean pressure is a difference quotient, with relative round-off
/// 1e-16/1e-5. Below, the slope in the middle of the step is used, with an error of the square of the change.
pub const VOLUME_CHANGE: f64 = 1e-5;

/// Round-off of differences of positions, relative to these. Between sticking surfaces invariants hardly change, and a remainder caused by
/// their round-off is ignored.
pub const POSITION: f64 = 4e-16;

/// Remainder of a discrete gradient, relative to its terms, that is round-off. Where the increment is so small that a smooth function's
/// remainder would be, too, only a larger one is divided by it: that of a kink.
pub const REMAINDER: f64 = 4e-15;

/// Curvature of an obstacle's distance along an edge, as deviation from linear over the edge length, below which no point within the edge
/// is deepest: the edge lies along a cylinder or cone, and its end nodes suffice.
pub const LIES_ALONG: f64 = 1e-6;

/// Distance of a primary from a secondary node, in secondary facets, within which they count as aligned: a thousand times what round-off
/// and elastic waves before an impact leave of bodies with the same mesh.
pub const ALIGNED: f64 = 1e-4;

/// Share of a facet by which a node may lie beyond the end of a chain and still be opposite it: nodes of bodies that end flush with each
/// other, after their own deformation.
pub const CHAIN_END: f64 = 1e-6;

/// Smallest extent of a primary facet in the secondary coordinate for which the two count as facing each other.
pub const FACING: f64 = 1e-6;

/// Projected area of a triangle of a facet in space along the normal of the opposite facet, over the area of a triangle of that facet,
/// below which the two do not face each other.
pub const FACING_AREA: f64 = 1e-9;

/// Distance between nearly coincident edges of two facets in space, over the height of a triangle of one of them, within which the contact
/// force passes gradually from one facet to the other. Newton's method diverges at a kink; the zone is narrow compared with a facet.
pub const EDGES_MEET: f64 = 0.01;

/// Cosine of the angle between the normals of two facets above which they are no pair: facets that touch face to face have -1, the flank
/// of a needle of 24 degrees on a flat side -0.2; the gap between nearly perpendicular facets is steep and has no meaning.
pub const OPPOSITE: f64 = -0.1;

/// Gap in shortest secondary facets beyond which a pair's beginning to overlap within a step is more than Newton's method copes with: the
/// jump of its gradient. Half a facet stopped piles; gaps of bodies that lie flush, and of facets on curved bodies, are a hundredth.
pub const FAR_SLIVER: f64 = 0.05;

/// Cosine of the angle between two facets of a surface above which their common node has one normal: up to 45 degrees, an octagon's.
pub const SMOOTH: f64 = 0.7;

/// Cosine of the angle between the normals of a secondary node and a primary facet above which they look the same way and cannot touch:
/// facets in contact look opposite ways, -1, and the sharpest corner comes to 0.
pub const SAME_WAY: f64 = 0.5;

/// Sliding of two surfaces within a step, in secondary facets, beyond which the step is halved beforehand: where it slides by a facet or
/// more, a step skips facets, and a bearing loses half of its spin to vibrations within two turns although its energy is exact (at 0.9 it
/// keeps 0.999 of the spin).
pub const SLIDING: f64 = 0.9;

/// Approach of an open node beyond the other side within a step of the persistency rule, in secondary facets, beyond which the step is
/// halved beforehand: it would stay as penetration.
pub const APPROACH: f64 = 0.08;

/// Depth of a node behind the other side in a converged step of the persistency rule, in secondary facets, beyond which the step is taken
/// back. Larger than [`APPROACH`], since elastic motion is not predicted and a step that is taken back has cost all its iterations.
pub const CAME_THROUGH: f64 = 0.09;

/// Growth of the depth of a node within a step of the persistency rule, in secondary facets, above which the step is taken back: slower
/// growth would continue in halved steps.
pub const SUNK_DEEPER: f64 = 0.03;

/// Change of a node's distance from a rigid disk or polyline within a step, in lengths of its facets, beyond which the step is halved
/// beforehand: on the other side the contact would push on, or there would be none.
pub const PASSING: f64 = 1.0;

/// Motion of a node in a step, in shortest secondary facets, up to which its path may cross a rigid obstacle, as at a sharp corner.
pub const CROSSING: f64 = 0.1;

/// Overlap of a corner, in shortest secondary facets, that its own constraint leaves alone: half of what a sharp corner may go in, and far
/// more than the gaps that weighted constraints leave where surfaces lie flat on each other.
pub const CORNER_SLACK: f64 = 0.02;

/// Depth of an overlap in shortest secondary facets above which a run reports it: the promise of a tenth of a facet.
pub const DEPTH: f64 = 0.1;

/// Share of a facet by which a node is moved out of its own body for the test whether it is inside another body, or inside another part of
/// its
/// own: far more than round-off of positions, far less than any depth that matters.
pub const BESIDE: f64 = 1e-6;

/// Depth of an overlap at rest, in the longest facets there, above which sides without contact force are an error. Up to half a facet every
/// pair takes part always, so that deeper overlaps were overlooked; interlocking polygons and weighted gaps leave a tenth.
pub const LEFT: f64 = 0.5;

/// Depth of a body inside the hull of another one, in the shorter facets there, that is an error at rest without contact force.
pub const LEFT_PASSED: f64 = 0.25;

/// Depth of an overlap at rest, in the longest facets there, that is still accepted where a multiplier is positive: an active constraint
/// leaves less.
pub const LEFT_HELD: f64 = 1.0;

/// Rotation of a cell of linear elasticity above which it is reported `[rad]`: stresses have an error of half its square, and spurious
/// strains appear.
pub const TURNED: f64 = 0.1;

/// Stretch of a cell of Saint Venant-Kirchhoff material below which it is reported: the compressive stress decreases below the stretch
/// `sqrt(1/3) = 0.577`.
pub const CRUSHED: f64 = 0.6;

/// Jump of a prescribed motion, in extents of the model, above which it is reported: more than round-off.
pub const JUMP: f64 = 1e-9;

/// Kinetic over strain energy up to which bodies count as being at rest.
pub const AT_REST: f64 = 1e-6;

/// Relative estimated error of the stresses at rest above which it is reported. Its square, 6 %, is about that of the stiffness.
pub const COARSE: f64 = 0.25;

/// Work that contact adds in a step, relative to the energy, above which it is reported: no contact rule adds any, but round-off does.
pub const GIVEN: f64 = 1e-10;

/// Energy defect of a step above which it is reported, in Newton's tolerances: the promise of 1e-11 with the default.
pub const DEFECT: f64 = 100.0;

/// Relative energy defect above which a run does not count as conserving: a thousand steps of round-off stay below.
pub const CONSERVED: f64 = 1e-8;

/// Energy that counts as zero in any units: round-off of a model at rest.
pub const NO_ENERGY: f64 = 1e-40;

/// Relative energy of a step of statics unexplained by the forces at both of its ends, above which it is reported: a large step on a
/// curved path stays below.
pub const LEAP: f64 = 0.05;

/// Energy that contact has dissipated or stores, relative to all energy, above which it is reported: it begins to show in a plot.
pub const LOST: f64 = 1e-3;

/// Step halvings per accepted step and cause of failure above which they are reported; fewer have no noticeable cost.
pub const HALVED: f64 = 0.01;

/// Augmentation of corner constraints for contacts without one: if bodies overlap at the start, corner constraints depend linearly on those
/// of the surfaces.
pub const CORNER_AUGMENTATION: f64 = 1e6;
/// Augmentation of surface constraints in space for contacts without one: constraints over a small part of a facet are nearly dependent.
/// Without effect on the convergence of Newton's method.
pub const SURFACE_AUGMENTATION: f64 = 1e8;

/// Momentum that a push of the `velocity` rule may have, over the sum of its nodal momenta: the promise of 1e-11 a step.
pub const PUSH: f64 = 1e-12;

/// Additional momentum tolerance of the filter of velocities, relative to the sum of momenta exchanged by its stiffness: their round-off,
/// which exceeds that of the velocities where steps are long.
pub const FILTER: f64 = 1e-14;

/// Overlap at the end of a step, in shortest secondary facets, of an excluded facet pair above which the step is taken back.
pub const OVERLOOKED: f64 = 1e-6;

/// Share of a facet that may be missing from the overlap of a facet that counts as wholly covered. At the rims of a press fit the share
/// changes with the gap there; a limit of round-off alternates between shape functions in `settle`.
pub const WHOLE: f64 = 1e-4;

/// Covered share of a secondary node's weight function below which the node is excluded: its constraint would be singular.
pub const SLIVER: f64 = 0.02;

/// Largest nodal increment of one Newton iteration, in shortest secondary facets.
pub const STEP_LIMIT: f64 = 0.1;

/// Covered share of a secondary node below which the node has no constraint in the iteration (a zero row makes the matrix singular).
pub const ZERO_ROW: f64 = 1e-6;

/// Backward error of the linear solve that needs no refinement: three decimal digits above round-off.
pub const LINEAR_REFINED: f64 = 1e-13;

/// Backward error after refinement above which the system is solved again with pivots sought in whole columns: good factors leave
/// 1e-14 to 1e-16, so this is a sign of growth in them.
pub const LINEAR_FALLBACK: f64 = 1e-10;

/// Pivots below this, in a matrix scaled to entries of order one, are no pivots.
pub const LINEAR_PIVOT: f64 = 1e-10;

/// Replacement of a pivot below [`LINEAR_PIVOT`], by which factors do not grow: the square root of round-off.
pub const LINEAR_REPLACEMENT: f64 = 1e-8;

/// Image of a unit vector under a matrix with entries of order one that counts as zero: the round-off of a row's sum.
pub const LINEAR_SINGULAR: f64 = 1e-14;

/// Backward error of the linear solve after refinement above which the solution is refused.
pub const LINEAR_RESIDUAL: f64 = 1e-8;

/// Residual over the right-hand side above which a solution is refused however small its backward error is: it is so much larger than the
/// right-hand side that the matrix is as good as singular.
pub const LINEAR_UNSOLVED: f64 = 1e-3;

/// Part of a tie's offset that a node within the body carries, over the weight of a node, below which it is round-off of positions and the
/// tie joins the surfaces alone.
pub const TIE_OFFSET: f64 = 1e-12;

/// Angle by which a boundary may turn at once on the way to an equilibrium `[rad]`.
pub const EIGHTH_TURN: f64 = std::f64::consts::FRAC_PI_4;

/// Ratio of singular values below which prescribed nodes count as collinear, so that they determine no rotation.
pub const TURNS: f64 = 1e-9;

/// Range of the values of a plot or a picture, relative to their size, below which they are shown as one constant: their differences are
/// round-off, and a scale stretched over them would show noise.
pub const FLAT: f64 = 1e-9;

/// Size of the values of a plot below which they count as zero: the power of ten of smaller values is inaccurate.
pub const NOTHING: f64 = 1e-290;

/// Share of a plot's range by which a value may lie outside it and is still drawn: round-off of the range.
pub const PLOT_END: f64 = 1e-9;

/// Height of a point over the plane of a section, over the largest one, below which it lies in the plane: round-off of a symmetry plane.
pub const ON_SECTION: f64 = 1e-9;

/// Least side of the bounds of a picture relative to the longest side, for bodies without thickness.
pub const PICTURE_THICKNESS: f64 = 1e-3;

/// Distance of a polygon from its circle, relative to the extent of the bodies beside it: half a pixel of a large picture.
pub const PICTURE_ROUNDNESS: f64 = 5e-4;

/// Step of a difference quotient of a time function, relative to the time: the third root of round-off, where truncation and round-off of a
/// central difference are equal.
pub const TIME_DIFFERENCE: f64 = 6e-6;

/// Time below which [`TIME_DIFFERENCE`] is not relative any more `[time]`.
pub const SMALL_TIME: f64 = 1e-3;

/// Distance of two times, relative to the step, within which they count as equal: round-off of sums of some thousand steps.
pub const SAME_MOMENT: f64 = 1e-9;

/// Part of the gradient of a tangential constraint that supports must leave free; below it the node counts as fully constrained.
pub const HELD_ROW: f64 = 1e-8;

/// Part of the gap tolerance by which an inactive constraint must be violated on the frozen linearisation to become active.
pub const CLEARLY: f64 = 1e-3;

/// Residual of a damped step of `settle` over its largest damping force, or over the imbalance that `settle` accepts: the damping leaves
/// more than that, and the energy of a model of rigid bodies is no measure of a residual (8 000 factorizations for five equilibria of a
/// truss).
pub const REST_STEP: f64 = 1e-2;

/// Least damping of a body in `settle` over the stiffness of its slowest elastic motion.
pub const LEAST_DAMPING: f64 = 1e-8;

/// Least damping `d` of a rigid body in `settle` as a factor of `F/(m L)`, with its loads `F`, mass `m` and extent `L`. Round-off of the
/// constraint forces then moves the body by 1e-14 of its size, and what touches it by a hundredth of its own depth less than it should.
pub const RIGID_DAMPING: f64 = 1e-2;

/// Motion in a step of `settle`, in facets, below which a body is not expected to move in the next one.
pub const STANDS: f64 = 1e-3;

/// Resultant over the sum of forces that counts as balanced when a failure is explained: far above round-off.
pub const EXPLAINED: f64 = 1e-6;

/// Largest part of a motion of a singular system that may differ from the rigid one that it is called.
pub const RIGID: f64 = 1e-5;

/// Relative difference below which two values of a finding count as equal: the first is reported, independent of round-off.
pub const EQUAL: f64 = 1e-6;

/// Difference of an angle from a number of quarter turns, in quarter turns, below which it is that number: the last bit of a conversion.
pub const QUARTER_TURN: f64 = 1e-12;

/// Relative difference that `expect_close` allows when none is given.
pub const CLOSE: f64 = 1e-9;

/// Largest relative difference of a run from the same one moved when none is given: round-off of some hundred steps of a collision.
pub const INVARIANT: f64 = 1e-7;

/// Relative error below which an order of convergence is not read from differences: round-off.
pub const ORDER_ROUND_OFF: f64 = 1e-13;

/// Entry off the diagonal, squared and relative to the squared size of a matrix, below which rotations no longer diagonalise it: a
/// hundredth of round-off.
pub const DIAGONAL: f64 = 1e-36;

/// Largest entry of a constraint less those before it, relative to its own, that counts as none: it follows from them.
pub const DEPENDENT: f64 = 1e-9;

/// Entry of a constraint, relative to its largest, that elimination drops.
pub const NEGLIGIBLE_ENTRY: f64 = 1e-14;

/// Largest sum of the squared factors from cell values to a nodal value for which a patch of cells determines a slope: a little more
/// than the 9/4 of two by two cells at a corner.
pub const RECOVERY_AMPLIFICATION: f64 = 2.5;

/// Stress at rest of an energy, relative to the terms that cancel in it, that is the round-off of its constants.
pub const RESIDUAL_STRESS: f64 = 1e-14;

/// Stress on the free faces of a test piece, relative to its stiffness, that counts as zero: round-off of a near-incompressible law.
pub const FREE_STRESS: f64 = 1e-13;

/// Gain of a step of a fit, relative to the squares that are left, below which it is done.
pub const FIT: f64 = 1e-10;

/// Step of a difference quotient of a fit, relative to the constant: the third root of round-off; also the damping to begin with.
pub const FIT_DIFFERENCE: f64 = 1e-5;

/// Deviation from linearity, relative to the stresses, up to which stresses count as linear in a constant: round-off.
pub const FIT_LINEAR: f64 = 1e-10;

/// Singular value, relative to the largest, below which the data do not determine a direction of a fit.
pub const FIT_RANK: f64 = 1e-12;

/// Distance of the end of an arc from its circle, relative to the radius, that is rounding of what was typed: three digits are.
pub const ON_CIRCLE: f64 = 1e-3;

/// Round-off of a sum of a thousand lengths, relative to it.
pub const SUM_OF_LENGTHS: f64 = 1e-12;

/// Default distance of the last points of a minimization, as a share of the range between bounds: six digits, the accuracy of a simulation
/// with discretization error.
pub const MINIMIZED: f64 = 1e-6;

/// Distance of a node of a rigid body from the plane of the other masters over the size of the body, below which its nodes count as flat:
/// shares of masters would be larger than its inverse.
pub const FLAT_FRAME: f64 = 1e-6;

/// Difference of two distances over the larger one, below which two nodes are equally far and the lower index is a master of the rigid
/// body. Round-off of a translated mesh would choose other masters, whose velocities in a step differ by its discretization error
/// (`tests/scripts/multibody.rhai`).
pub const EQUALLY_FAR: f64 = 1e-9;

/// Relative residual of a constraint between points (Newton's target): joints hold to 1e-12 of the size of the joined bodies.
pub const JOINT: f64 = 2e-13;

/// Distance of the two points of a joint, relative to the size of the model, above which they count as apart.
pub const JOINT_APART: f64 = 1e-9;

/// Distance of a point from a node over the size of a cell up to which a joint means that node.
pub const SAME_NODE: f64 = 1e-6;

/// Difference between the prescribed value of a drive at the start and the value of its joint at rest, relative to the size of the model or
/// in radians, above which the drive would jump.
pub const DRIVE_AT_REST: f64 = 1e-9;

/// Largest range of an angle between the stops of a hinge `[rad]`: a little less than a turn, so that a step cannot jump over both.
pub const WIDEST_ANGLE: f64 = 6.0;

/// Separation rate of a joint at the start, relative to the largest velocity, above which initial velocities violate the joint.
pub const LOOSE_JOINT: f64 = 1e-6;

/// Relative error of `omega^2` of the fastest vibration; half of this is the relative error of the stable step.
pub const FASTEST: f64 = 0.005;

/// Displacement by which forces are differentiated for the fastest vibration, relative to the extent of the model: a strain of 1e-5 in
/// cells of a hundredth of it.
pub const SMALL_MOTION: f64 = 1e-7;

/// Unexplained energy, relative to initial energy plus work, at which explicit steps are stopped: near the stable step the energy of the
/// fastest vibrations oscillates by a factor of some ten.
pub const RAN_AWAY: f64 = 100.0;

/// Residual of a steady vibration in the mass norm, relative to the size of the vibration: a hundredth of the tolerance of comparisons with
/// closed forms.
pub const RESPONSE: f64 = 1e-9;

/// Relative difference of the strain energy of a state from that of the linear model above which linear buckling gives a warning.
pub const LINEAR_STATE: f64 = 0.05;

/// Relative difference of the strain energy from that of the linear model, times the load factor, above which the path to the buckling load
/// does not count as straight.
pub const LINEAR_PATH: f64 = 0.2;
