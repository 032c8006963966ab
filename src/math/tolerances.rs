//! Every tolerance of the program, with its name, its meaning and the reason of its size.

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

/// Growth of the error over the way of the bodies, of steps that choose their size, where no other is asked for: what a picture shows.
pub const STEP_ERROR: f64 = 1e-3;

/// Growth of the error in a step, relative to the displacements, that is no error but round-off and what Newton's tolerance leaves.
pub const STILL: f64 = 1e-12;

/// Error of the positions in a step, relative to the largest coordinate, that is round-off where contacts or rigid bodies depend on
/// positions: differences of three steps of a body that friction holds reach 1e-14.
pub const STILL_AT: f64 = 1e-13;

/// Smallest step, relative to the first one, of those that choose their size, where no other is asked for: an impact that is timed to a
/// millionth costs some twenty refused steps.
pub const SMALLEST_STEP: f64 = 1e-6;

/// What the momentum that a residual gives within a step counts against the energy that it moves: with the default tolerance a step is done
/// with 5e-12 of the momentum that belongs to its energy.
pub const NEWTON_MOMENTUM: f64 = 0.01;

/// Force residual, relative to the largest force, below which the energy criterion alone decides: a guard against a residual that
/// happens to be orthogonal to the motion.
pub const NEWTON_FORCE: f64 = 1e-7;

/// The energy criterion of Newton's method for an equilibrium that is only one on the way to another.
pub const ON_THE_WAY: f64 = 1e-8;

/// Round-off floor of the force residual, relative to stiffness times size: a body at rest must converge too.
pub const FORCE_FLOOR: f64 = 1e-14;

/// Unbalanced force at rest that `settle` accepts, of a piece relative to the sum of the forces on it, of a node relative to the largest of
/// them: ten times below the promised 1e-10.
pub const BALANCE: f64 = 1e-11;

/// Difference of the accelerations of two bodies, relative to them, below which they fall together: round-off of sums over many nodes.
pub const ALIKE: f64 = 1e-9;

/// Stiffness of supports against a rigid motion, relative to their largest, below which the motion is free: round-off of node positions.
pub const HELD: f64 = 1e-10;

/// Part of a vector beyond a basis, relative to all of it, that is round-off: the operator is known to about 1e-14.
pub const LANCZOS_DEPENDENT: f64 = 1e-11;

/// What a vibration mode may miss, relative to its eigenvalue of the inverse operator: the error of the frequency is the square of that.
pub const MODE_RESIDUAL: f64 = 1e-8;

/// How far beyond the last load factor those below are counted, relative to it: farther than round-off, and nearer than the next one.
pub const COUNTED_BEYOND: f64 = 1e-4;

/// Distance of two eigenvalues, relative to that from the shift, below which a count between them would not be safe from round-off.
pub const MODE_GAP: f64 = 1e-7;

/// Shift of the eigenvalue problem, relative to the square of the frequency with which waves cross the slowest piece: far below the first
/// vibration of any but the most slender bodies, far above the round-off of a rigid motion.
pub const MODE_SHIFT: f64 = 1e-3;

/// Effective mass of a mode over that of the model that is told as nothing: the square of a sum's round-off, with room for large models.
pub const EFFECTIVE_MASS: f64 = 1e-12;

/// Round-off of an eigenvalue relative to the largest stiffness over mass of an unknown: smaller ones are zero.
pub const MODE_FLOOR: f64 = 1e-14;

/// Part of an increment of the load by which loads are differentiated: most are linear, and round-off is divided by it.
pub const LOAD_DIFFERENCE: f64 = 1e-3;

/// Residual of an equilibrium on a path relative to the largest force: a tenth of what `settle` accepts. A correction of that share of the
/// displacements is none.
pub const PATH: f64 = 1e-12;

/// The same where a correction no longer halves it: round-off of stiff cells that hardly strain.
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
/// facet: well above Newton's gap tolerance, or nodes would drop out for good; a thousand times below where nodes are held visibly open.
pub const CLOSED: f64 = 1e-9;

/// Strain increment, relative to the strains, below which the correction of the discrete gradient is dropped: it is 1e-16 of the stress
/// there, and its derivative a quotient of two round-offs.
pub const STRAIN_INCREMENT: f64 = 1e-8;

/// Step strain |dE| above which the energy quotient is accurate enough as it stands; below it a five-point Lobatto rule is exact to
/// round-off.
pub const STRAIN_QUOTIENT: f64 = 5e-3;

/// Change of the mean volume ratio above which the energy quotient is taken of an energy whose slope has kinks, which no quadrature knows:
/// at its size the quotient's round-off and what a quadrature misses at a kink are alike, the root of 1e-16.
pub const KINK_QUOTIENT: f64 = 1e-8;

/// Change of the strain across the plane at which its Newton iteration ends: the next one would be its square.
pub const THICKNESS_STRAIN: f64 = 1e-10;

/// Change of a contact pair's invariants, relative to the invariants, below which the correction of the discrete gradient may be under
/// round-off.
pub const INVARIANT_INCREMENT: f64 = 1e-5;

/// Increment of a patch without its rigid part, relative to the patch, below which the correction of the projected discrete gradient is
/// dropped: its numerator is round-off (1e-16) there, which would give a force of 1e-9 of the contact force, as much as Newton notices.
pub const PROJECTED_INCREMENT: f64 = 1e-7;

/// Change of a gas's volume in a step, relative to it, above which the slope of its mean pressure is a quotient with relative round-off
/// 1e-16/1e-5; below it is that in the middle, which is wrong by the square of the change.
pub const VOLUME_CHANGE: f64 = 1e-5;

/// Round-off of differences of positions, relative to these: where surfaces stick to each other, invariants hardly change, and what their
/// round-off makes of a function is no remainder.
pub const POSITION: f64 = 4e-16;

/// Remainder of a discrete gradient, relative to its terms, that is round-off. Where the increment is so small that a smooth function's
/// remainder would be, too, only a larger one is divided by it: that of a kink.
pub const REMAINDER: f64 = 4e-15;

/// Bend of an obstacle's distance along an edge, over the edge's length, below which its deepest point is anywhere on the edge: the edge
/// lies along a cylinder or cone, and its ends see all of it.
pub const LIES_ALONG: f64 = 1e-6;

/// Distance of a primary from a secondary node, in secondary facets, within which they count as aligned: a thousand times what round-off
/// and elastic waves before an impact leave of bodies with the same mesh.
pub const ALIGNED: f64 = 1e-4;

/// Share of a facet by which a node may lie beyond the end of a chain and still be opposite it: nodes of bodies that end flush with each
/// other, after their own deformation.
pub const CHAIN_END: f64 = 1e-6;

/// Smallest extent of a primary facet in the secondary coordinate for which the two count as facing each other.
pub const FACING: f64 = 1e-6;

/// Area of a triangle of a facet in space, over that of one of the facet opposite, as seen along the latter's normal, below which the two
/// do not face each other.
pub const FACING_AREA: f64 = 1e-9;

/// Distance between edges of two facets in space that coincide nearly, over the height of a triangle of one of them, within which the force
/// on what they bound goes from one to the other gradually: wide enough for Newton's method, which finds no solution at a kink, narrow
/// against all that is seen of a facet.
pub const EDGES_MEET: f64 = 0.01;

/// Cosine of the angle between the normals of two facets above which they are no pair: facets that touch face to face have -1, the flank
/// of a needle of 24 degrees on a flat side -0.2; the gap between facets that are nearly perpendicular is steep and means nothing.
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
/// more, a step does not see each facet that passes, and a bearing loses half of its spin to vibrations within two turns although its
/// energy is exact (at 0.9 it keeps 0.999 of it).
pub const SLIDING: f64 = 0.9;

/// Approach of an open node beyond the other side within a step of the persistency rule, in secondary facets, beyond which the step is
/// halved beforehand: it would stay as penetration.
pub const APPROACH: f64 = 0.08;

/// The same for a converged step: more than is foreseen, since elastic motion is not predicted, and a step that is taken back has cost all
/// its iterations.
pub const CAME_THROUGH: f64 = 0.09;

/// Growth of the depth of a node within such a step, in secondary facets, from which on it counts: what grows by less grows as slowly in
/// halves of the step.
pub const SUNK_DEEPER: f64 = 0.03;

/// Change of a node's distance from a rigid disk or polyline within a step, in lengths of its facets, beyond which the step is halved
/// beforehand: on the other side the contact would push on, or there would be none.
pub const PASSING: f64 = 1.0;

/// Motion of a node in a step, in shortest secondary facets, up to which its way may lead through a rigid obstacle: round a sharp corner.
pub const CROSSING: f64 = 0.1;

/// Overlap of a corner, in shortest secondary facets, that its own constraint leaves alone: half of what a sharp corner may go in, and far
/// more than the gaps that weighted constraints leave where surfaces lie flat on each other.
pub const CORNER_SLACK: f64 = 0.02;

/// Depth of an overlap in shortest secondary facets from which on a run is said to have it: the promise of a tenth of a facet.
pub const DEPTH: f64 = 0.1;

/// Share of a facet by which a node is moved out of its own body to ask whether it is inside another one, or inside another part of its
/// own: far more than round-off of positions, far less than any depth that matters.
pub const BESIDE: f64 = 1e-6;

/// Depth in the longest facets there from which on sides that no contact force holds apart are an error at rest. Up to half a facet every
/// pair takes part always, so that what is left deeper was not seen; polygons that interlock and weighted gaps leave a tenth.
pub const LEFT: f64 = 0.5;

/// The same for the hulls of bodies between which no contact presses at all, in the shorter facets there.
pub const LEFT_PASSED: f64 = 0.25;

/// The same where a multiplier presses: no constraint that holds leaves as much.
pub const LEFT_HELD: f64 = 1.0;

/// Rotation of a cell of linear elasticity from which on it is told `[rad]`: stresses are off by half its square, and strains that are not
/// there come in.
pub const TURNED: f64 = 0.1;

/// Stretch of a cell of Saint Venant-Kirchhoff material below which it is told: its stress falls again below the root of a third, 0.577.
pub const CRUSHED: f64 = 0.6;

/// Distance by which a prescribed motion jumps, in extents of the model, from which on it is told: more than round-off.
pub const JUMP: f64 = 1e-9;

/// Kinetic over strain energy up to which bodies count as being at rest.
pub const AT_REST: f64 = 1e-6;

/// Estimated error of the stresses at rest, over their size, from which on it is told. Its square is about that of the stiffness, 6 %.
pub const COARSE: f64 = 0.25;

/// Work that contact gives in a step, relative to the energy, from which on it is told: no rule gives any, but round-off does.
pub const GIVEN: f64 = 1e-10;

/// Energy defect of a step from which on it is told, in Newton's tolerances: the promise of 1e-11 with the default.
pub const DEFECT: f64 = 100.0;

/// Energy that came or went, relative to all, from which on a run does not count as conserving: a thousand steps of round-off stay below.
pub const CONSERVED: f64 = 1e-8;

/// Energy that counts as none in any units: round-off of a model in which nothing happens.
pub const NO_ENERGY: f64 = 1e-40;

/// Energy that the forces at both ends of a step of statics leave unexplained, relative to all, from which on it is told: a large step on a
/// curved path stays below.
pub const LEAP: f64 = 0.05;

/// Energy that contact has taken or keeps, relative to all, from which on it is told: it begins to show in a plot.
pub const LOST: f64 = 1e-3;

/// Halvings for one way of failing per accepted step from which on they are told: fewer cost nothing that one would notice.
pub const HALVED: f64 = 0.01;

/// Augmentation of a corner's constraints, where the contact has none: where bodies overlap at the start, they depend on the surfaces'.
pub const CORNER_AUGMENTATION: f64 = 1e6;
/// The same of surfaces in space, whose rows over a small part of a facet are nearly the same one: Newton's method does not notice it.
pub const SURFACE_AUGMENTATION: f64 = 1e8;

/// Momentum that a push of the `velocity` rule may have, over the sum of its nodal momenta: the promise of 1e-11 a step.
pub const PUSH: f64 = 1e-12;

/// Momentum that the filter of velocities may have besides, over the sum of those that its stiffness exchanges: their round-off, which is
/// above that of the velocities where steps are long.
pub const FILTER: f64 = 1e-14;

/// Overlap in shortest secondary facets, at the end of a step, of a pair that took no part in it, from which on the step is taken back.
pub const OVERLOOKED: f64 = 1e-6;

/// Share of a facet that may be missing from the overlap of a facet that counts as wholly covered. At the rims of a press fit the share
/// changes with the gap there; a limit of round-off alternates between shape functions in `settle`.
pub const WHOLE: f64 = 1e-4;

/// Covered share of a secondary node's weight function below which the node sits out the step (a sliver of overlap gives a singular row).
pub const SLIVER: f64 = 0.02;

/// Largest nodal increment of one Newton iteration, in shortest secondary facets.
pub const STEP_LIMIT: f64 = 0.1;

/// Covered share below which a node has no row at all in this iteration (a zero row makes the matrix singular).
pub const ZERO_ROW: f64 = 1e-6;

/// Backward error of the linear solve that needs no refinement: three decimal digits above round-off.
pub const LINEAR_REFINED: f64 = 1e-13;

/// Backward error after refinement above which the system is solved again with pivots sought in whole columns: good factors leave
/// 1e-14 to 1e-16, so this is a sign of growth in them.
pub const LINEAR_FALLBACK: f64 = 1e-10;

/// Pivots below this, in a matrix scaled to entries of order one, are no pivots.
pub const LINEAR_PIVOT: f64 = 1e-10;

/// What replaces a pivot that is none: the root of the round-off, which weighs the change of the matrix against growth in the factors.
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

/// Second singular value of how prescribed nodes lie and move, over the first, below which they determine no rotation.
pub const TURNS: f64 = 1e-9;

/// Range of the values of a plot or a picture, relative to their size, below which they are shown as one constant: their differences are
/// round-off, and a scale stretched over them would show noise.
pub const FLAT: f64 = 1e-9;

/// Size of the values of a plot below which they count as zero: what is next to nothing has no accurate power of ten.
pub const NOTHING: f64 = 1e-290;

/// Share of a plot's range by which a value may lie outside it and is still drawn: round-off of the range.
pub const PLOT_END: f64 = 1e-9;

/// Height of a point over the plane of a section, over the largest one, below which it lies in the plane: round-off of a symmetry plane.
pub const ON_SECTION: f64 = 1e-9;

/// Thickness of what a picture shows, relative to its length: a body without any still has a frame.
pub const PICTURE_THICKNESS: f64 = 1e-3;

/// Distance of a polygon from the circle that it stands for, relative to the extent of the bodies beside it: half a pixel of a
/// large picture.
pub const PICTURE_ROUNDNESS: f64 = 5e-4;

/// Step of a difference quotient of a time function, relative to the time: the third root of round-off, where truncation and round-off of a
/// central difference are equal.
pub const TIME_DIFFERENCE: f64 = 6e-6;

/// Time below which [`TIME_DIFFERENCE`] is not relative any more `[time]`.
pub const SMALL_TIME: f64 = 1e-3;

/// Distance of two moments, relative to the step, within which they are one: sums of some thousand steps.
pub const SAME_MOMENT: f64 = 1e-9;

/// Part of a tangential row's gradient that supports must leave free, or they hold it.
pub const HELD_ROW: f64 = 1e-8;

/// Part of the gap tolerance by which an inactive constraint must be violated on the frozen linearisation to become active.
pub const CLEARLY: f64 = 1e-3;

/// Residual of a damped step of `settle` over its largest damping force, or over the imbalance that `settle` accepts: the damping leaves
/// more than that, and the energy of a model of rigid bodies is no measure of a residual (8 000 factorizations for five equilibria of a
/// truss).
pub const REST_STEP: f64 = 1e-2;

/// Least damping of a body in `settle` over the stiffness of its slowest elastic motion.
pub const LEAST_DAMPING: f64 = 1e-8;

/// The same of a rigid body over its loads, per length: round-off of the constraints' forces then moves it by 1e-14 of its size, and what
/// touches it by a hundredth of its own depth less than it should.
pub const RIGID_DAMPING: f64 = 1e-2;

/// Motion in a step of `settle`, in facets, below which a body is not expected to move in the next one.
pub const STANDS: f64 = 1e-3;

/// Resultant over the sum of forces that counts as balanced when a failure is explained: far above round-off.
pub const EXPLAINED: f64 = 1e-6;

/// Largest part of a motion of a singular system that may differ from the rigid one that it is called.
pub const RIGID: f64 = 1e-5;

/// Relative difference below which two values of a finding are as good as equal: the first of them is told, whatever round-off says.
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

/// Sum of the squared factors by which values of cells become one of a node, up to which a patch of cells tells a slope: a little more
/// than the 9/4 of two by two cells at a corner.
pub const RECOVERY_AMPLIFICATION: f64 = 2.5;

/// Stress at rest of an energy, relative to the terms that cancel in it, that is the round-off of its constants.
pub const RESIDUAL_STRESS: f64 = 1e-14;

/// Stress on the free faces of a test piece, relative to its stiffness, that counts as none: round-off of a near-incompressible law.
pub const FREE_STRESS: f64 = 1e-13;

/// Gain of a step of a fit, relative to the squares that are left, below which it is done.
pub const FIT: f64 = 1e-10;

/// Step of a difference quotient of a fit, relative to the constant: the third root of round-off; also the damping to begin with.
pub const FIT_DIFFERENCE: f64 = 1e-5;

/// Difference from a straight line, relative to the stresses, that a constant may have which they count as linear in: round-off.
pub const FIT_LINEAR: f64 = 1e-10;

/// Singular value, relative to the largest, below which a direction of a fit is not told by the data.
pub const FIT_RANK: f64 = 1e-12;

/// Distance of the end of an arc from its circle, relative to the radius, that is rounding of what was typed: three digits are.
pub const ON_CIRCLE: f64 = 1e-3;

/// Round-off of a sum of a thousand lengths, relative to it.
pub const SUM_OF_LENGTHS: f64 = 1e-12;

/// Distance of the last points of a search for the least value, as a share of the range between bounds, by default: six digits of what is
/// searched for, as many as a simulation that is not exact itself can tell.
pub const MINIMIZED: f64 = 1e-6;

/// Distance of a node of a rigid body from the plane of the other masters over the size of the body, below which its nodes count as flat:
/// shares of masters would be larger than its inverse.
pub const FLAT_FRAME: f64 = 1e-6;

/// Difference of two distances over the larger one, below which two nodes are equally far and the lower index is a master of the rigid
/// body. Round-off of a translated mesh would choose other masters, whose velocities in a step differ by its discretization error
/// (`tests/scripts/multibody.rhai`).
pub const EQUALLY_FAR: f64 = 1e-9;

/// What is missing in a constraint between points over the size of what they join (Newton's target): joints hold to 1e-12 of the length.
pub const JOINT: f64 = 2e-13;

/// Distance of two points that a joint makes one, over the size of the model, from which they are apart.
pub const JOINT_APART: f64 = 1e-9;

/// Distance of a point from a node over the size of a cell up to which a joint means that node.
pub const SAME_NODE: f64 = 1e-6;

/// Difference of a drive at the start from what its joint is at rest, over the size of the model or in radians, from which it would jump.
pub const DRIVE_AT_REST: f64 = 1e-9;

/// Largest range of an angle between the stops of a hinge `[rad]`: a little less than a turn, so that a step cannot jump over both.
pub const WIDEST_ANGLE: f64 = 6.0;

/// Rate at which a joint would part over the largest velocity at the start, from which the velocities do not fit the joint.
pub const LOOSE_JOINT: f64 = 1e-6;

/// How far `omega^2` of the fastest vibration may be missed, relative to it: half of that is the error of the stable step.
pub const FASTEST: f64 = 0.005;

/// Displacement by which forces are differentiated for the fastest vibration, relative to the extent of the model: a strain of 1e-5 in
/// cells of a hundredth of it.
pub const SMALL_MOTION: f64 = 1e-7;

/// Energy that nothing explains, over all the energy that there was and that came in, at which explicit steps are stopped: near the stable
/// step what they do to the fastest vibrations swings by some ten times.
pub const RAN_AWAY: f64 = 100.0;

/// What a steady vibration may miss in the product of the masses, relative to its size: a hundredth of what closed forms are asked for.
pub const RESPONSE: f64 = 1e-9;

/// Difference of the strain energy of a state from that of the linear model, relative, above which linear buckling says so.
pub const LINEAR_STATE: f64 = 0.05;

/// The same times the load factor: how far the way to the buckling load is from straight.
pub const LINEAR_PATH: f64 = 0.2;
