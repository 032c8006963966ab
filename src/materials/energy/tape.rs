//! Graph nodes as a linear list of operations on lanes, in a form that is accurate for small changes.
//!
//! Every node is a known value `c` plus a deviation `d`, and only deviations are computed: products as `(c1 + d1) d2 + c2 d1`, reciprocals
//! as `-d/(c (c + d))`, logarithms as `ln_1p(d/c)`, exponentials as `e^c exp_m1(d)`, roots as `d/(sqrt(c + d) + sqrt c)`. With the value at
//! rest as `c`, small strains are accurate; with the value at the start of a step, small steps: both use the same operations with another
//! [`Base`]. Operations process up to [`POINTS`] times eight lanes, which amortizes their selection.

use std::hint::black_box;

use super::graph::{Graph, Id, Node};
use super::variable::Variable;
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tolerances::KINK_NEAR_REST;

/// Computes a value at each point.
macro_rules! each {
    ($points:ident, $result:ident, $n:ident, $value:expr) => {
        for $n in 0..$points {
            let value: Lanes<FMA> = $value;
            $result[$n] = Lanes(value.0);
        }
    };
}

/// Index of a result among all results.
type Register = usize;

/// Number of points that are computed together.
pub(super) const POINTS: usize = 4;

/// Eight lanes of each point.
pub(super) type Block = [Lanes<false>; POINTS];

/// A register, and its value `rest` at zero strain.
#[derive(Clone, Copy, Debug)]
struct Operand {
    register: Register,
    rest: f64,
    /// Register of the reciprocal, if computed anyway; saves a division.
    reciprocal: Option<Register>,
}

#[derive(Clone, Copy, Debug)]
enum Operation {
    Sum(Register, Register),
    Difference(Register, Register),
    Scaled(f64, Register),
    /// Sum `factor * a + b`.
    ScaledSum(f64, Register, Register),
    Product(Operand, Operand),
    Reciprocal(Operand),
    Logarithm(Operand),
    /// The operand's value at zero strain is replaced by that of the result.
    Exponential(Operand),
    Root(Operand),
    Positive(Operand),
    Step(Operand),
}

/// Root of a stage: register and factor of its deviation (`None` for a constant), and its value at zero strain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    place: Option<ScaledRegister>,
    /// Value at zero strain.
    pub(super) rest: f64,
}

/// A factor times a register.
#[derive(Clone, Copy, Debug)]
struct ScaledRegister {
    factor: f64,
    register: Register,
}

impl Root {
    /// True if the root is identically zero.
    pub(super) fn is_zero(&self) -> bool {
        self.place.is_none() && self.rest == 0.0
    }

    /// Deviation of the root from its value at zero strain; `None` for a constant.
    #[inline(always)]
    pub(super) fn deviation<const FMA: bool>(&self, registers: &[Block], point: usize) -> Option<Lanes<FMA>> {
        self.place.map(|place| Lanes(registers[place.register][point].0) * place.factor)
    }

    /// Value of the root at a point.
    #[inline(always)]
    pub(super) fn value<const FMA: bool>(&self, registers: &[Block], point: usize) -> Lanes<FMA> {
        match self.deviation::<FMA>(registers, point) {
            Some(deviation) => deviation + self.rest,
            None => Lanes::splat(self.rest),
        }
    }
}

/// List of operations. The first registers hold the variables in the given order, followed by `1/J` if `J` is a variable; operation `k`
/// writes the register after these and those of the previous operations. Stages with their own roots allow the energy to be computed
/// without its derivatives.
#[derive(Debug)]
pub(super) struct Tape {
    inputs: usize,
    operations: Vec<Operation>,
    /// Value of each operation's result at zero strain.
    rest: Vec<f64>,
    /// Number of operations needed for the roots of each stage.
    stages: Vec<usize>,
    /// Roots of all stages in a row.
    pub(super) roots: Vec<Root>,
}

impl Tape {
    /// True if the first stage has an operation whose slope jumps.
    pub(super) fn has_kinks(&self) -> bool {
        self.operations[..self.stages[0]].iter().any(|operation| matches!(operation, Operation::Positive(_)))
    }

    /// True if such a slope jumps at a strain that is small but not zero.
    pub(super) fn has_kinks_near_rest(&self) -> bool {
        let is_near = |rest: f64| (8.0 * f64::EPSILON..KINK_NEAR_REST).contains(&rest.abs());
        self.operations[..self.stages[0]].iter().any(|operation| matches!(operation, Operation::Positive(operand) if is_near(operand.rest)))
    }
}

/// Base values from which deviations are counted.
trait Base {
    /// Value of a register.
    fn value<const FMA: bool>(&self, operand: Operand, point: usize) -> Lanes<FMA>;
    /// Quotient of `x` and the value of a register.
    fn below<const FMA: bool>(&self, x: Lanes<FMA>, operand: Operand, point: usize) -> Lanes<FMA>;
}

/// Values at zero strain.
struct AtRest;

impl Base for AtRest {
    #[inline(always)]
    fn value<const FMA: bool>(&self, operand: Operand, _: usize) -> Lanes<FMA> {
        Lanes::splat(operand.rest)
    }
    #[inline(always)]
    fn below<const FMA: bool>(&self, x: Lanes<FMA>, operand: Operand, _: usize) -> Lanes<FMA> {
        x * (1.0 / operand.rest)
    }
}

/// Values at the start of a step, as deviations from the values at zero strain.
struct AtStart<'a>(&'a [Block]);

impl Base for AtStart<'_> {
    #[inline(always)]
    fn value<const FMA: bool>(&self, operand: Operand, point: usize) -> Lanes<FMA> {
        Lanes(self.0[operand.register][point].0) + operand.rest
    }
    #[inline(always)]
    fn below<const FMA: bool>(&self, x: Lanes<FMA>, operand: Operand, point: usize) -> Lanes<FMA> {
        match operand.reciprocal {
            Some(register) => x * (Lanes(self.0[register][point].0) + 1.0 / operand.rest),
            None => x / self.value(operand, point),
        }
    }
}

/// Conversion of a graph to a tape, with the registers of the nodes converted so far.
struct Lowering<'a> {
    graph: &'a Graph,
    variables: &'a [Variable],
    tape: Tape,
    places: Vec<Option<ScaledRegister>>,
}

impl Lowering<'_> {
    fn push(&mut self, operation: Operation, rest: f64) -> ScaledRegister {
        self.tape.operations.push(operation);
        self.tape.rest.push(rest);
        ScaledRegister { factor: 1.0, register: self.tape.registers() - 1 }
    }

    fn place(&self, id: Id) -> ScaledRegister {
        self.places[id].expect("parts stand before what is made of them, and constants are folded")
    }

    /// Register of the node without a factor.
    fn operand(&mut self, id: Id) -> Operand {
        let mut place = self.place(id);
        if place.factor != 1.0 {
            place = self.push(Operation::Scaled(place.factor, place.register), self.graph.rest(id));
            self.places[id] = Some(place);
        }
        let reciprocal = self.is_volume(id).then_some(self.variables.len());
        Operand { register: place.register, rest: self.graph.rest(id), reciprocal }
    }

    fn is_volume(&self, id: Id) -> bool {
        self.graph.node(id) == Node::Variable(Variable::J)
    }

    fn sum(&mut self, a: Id, b: Id, rest: f64) -> ScaledRegister {
        // A constant operand does not change the deviation of a sum.
        if self.graph.as_constant(a).is_some() {
            return self.place(b);
        }
        if self.graph.as_constant(b).is_some() {
            return self.place(a);
        }
        let (scaled, other) = if self.place(a).factor == 1.0 { (b, a) } else { (a, b) };
        let right = self.operand(other);
        let left = self.place(scaled);
        let operation = match left.factor {
            1.0 => Operation::Sum(left.register, right.register),
            -1.0 => Operation::Difference(right.register, left.register),
            factor => Operation::ScaledSum(factor, left.register, right.register),
        };
        self.push(operation, rest)
    }

    fn lower(&mut self, id: Id) -> Option<ScaledRegister> {
        let rest = self.graph.rest(id);
        let operation = match self.graph.node(id) {
            Node::Constant(_) => return None,
            Node::Variable(variable) => {
                let register = self.variables.iter().position(|known| *known == variable)?;
                return Some(ScaledRegister { factor: 1.0, register });
            }
            Node::Reciprocal(a) if self.is_volume(a) => return Some(ScaledRegister { factor: 1.0, register: self.variables.len() }),
            Node::Sum(a, b) => return Some(self.sum(a, b, rest)),
            Node::Scaled(factor, a) => {
                let place = self.place(a);
                return Some(ScaledRegister { factor: place.factor * factor.value(), ..place });
            }
            Node::Product(a, b) => Operation::Product(self.operand(a), self.operand(b)),
            Node::Reciprocal(a) => Operation::Reciprocal(self.operand(a)),
            Node::Logarithm(a) => Operation::Logarithm(self.operand(a)),
            Node::Exponential(a) => Operation::Exponential(self.operand(a)),
            Node::Root(a) => Operation::Root(self.operand(a)),
            Node::Positive(a) => Operation::Positive(self.operand(a)),
            Node::Step(a) => Operation::Step(self.operand(a)),
        };
        Some(self.push(operation, rest))
    }
}

impl Tape {
    /// Operations for the roots of `stages`, stage after stage.
    pub(super) fn new(graph: &Graph, variables: &[Variable], stages: &[&[Id]]) -> Self {
        let inputs = variables.len() + usize::from(variables.contains(&Variable::J));
        let tape = Tape { inputs, operations: Vec::new(), rest: Vec::new(), stages: Vec::new(), roots: Vec::new() };
        let nodes = stages.iter().flat_map(|roots| roots.iter()).max().map_or(0, |last| last + 1);
        let mut lowering = Lowering { graph, variables, tape, places: vec![None; nodes] };
        let mut known = vec![false; nodes];
        for roots in stages {
            for (id, is_needed) in graph.needed(roots).into_iter().enumerate() {
                if is_needed && !known[id] {
                    lowering.places[id] = lowering.lower(id);
                    known[id] = true;
                }
            }
            let roots = roots.iter().map(|&id| Root { place: lowering.places[id], rest: graph.rest(id) });
            lowering.tape.roots.extend(roots);
            lowering.tape.stages.push(lowering.tape.operations.len());
        }
        lowering.tape
    }

    /// Number of registers of the tape.
    pub(super) fn registers(&self) -> usize {
        self.inputs + self.operations.len()
    }

    /// Computes the differences of all registers of some points up to a stage from their values at zero strain; those of the variables are
    /// given.
    #[inline(always)]
    pub(super) fn deviations<const FMA: bool>(&self, stage: usize, points: usize, registers: &mut [Block]) {
        self.run::<FMA>(stage, points, registers, &AtRest);
    }

    /// Computes the changes of all registers of some points up to a stage from `start` (deviations); the first registers already contain
    /// the variables.
    #[inline(always)]
    pub(super) fn changes<const FMA: bool>(&self, stage: usize, points: usize, start: &[Block], registers: &mut [Block]) {
        self.run::<FMA>(stage, points, registers, &AtStart(start));
    }

    #[inline(always)]
    fn run<const FMA: bool>(&self, stage: usize, points: usize, registers: &mut [Block], base: &impl Base) {
        // Prevents unrolling of the loop over the points: unrolled loops would exceed the vector registers.
        let points = black_box(points).min(POINTS);
        for (index, operation) in self.operations[..self.stages[stage]].iter().enumerate() {
            let target = Operand { register: self.inputs + index, rest: self.rest[index], reciprocal: None };
            let (done, rest) = registers.split_at_mut(target.register);
            let result = &mut rest[0];
            // Loops instead of closures: functions that are not inlined are compiled without the instruction set of this function.
            match *operation {
                Operation::Sum(a, b) => each!(points, result, n, at::<FMA>(done, a, n) + at(done, b, n)),
                Operation::Difference(a, b) => each!(points, result, n, at::<FMA>(done, a, n) - at(done, b, n)),
                Operation::Scaled(factor, a) => each!(points, result, n, at::<FMA>(done, a, n) * factor),
                Operation::ScaledSum(factor, a, b) => {
                    each!(points, result, n, at::<FMA>(done, a, n).mul_add(Lanes::splat(factor), at(done, b, n)));
                }
                Operation::Product(a, b) => each!(points, result, n, {
                    let (d, e) = (at::<FMA>(done, a.register, n), at::<FMA>(done, b.register, n));
                    (base.value::<FMA>(a, n) + d).mul_add(e, base.value::<FMA>(b, n) * d)
                }),
                Operation::Reciprocal(a) => each!(points, result, n, {
                    let d = at::<FMA>(done, a.register, n);
                    base.below(-d, a, n) / (base.value::<FMA>(a, n) + d)
                }),
                Operation::Logarithm(a) => {
                    each!(points, result, n, above_minus_one(base.below(at::<FMA>(done, a.register, n), a, n)).ln_1p());
                }
                Operation::Exponential(a) => {
                    each!(points, result, n, at::<FMA>(done, a.register, n).exp_m1() * base.value::<FMA>(target, n));
                }
                Operation::Root(a) => each!(points, result, n, {
                    let d = at::<FMA>(done, a.register, n);
                    d / ((base.value::<FMA>(a, n) + d).sqrt() + base.value::<FMA>(target, n))
                }),
                Operation::Positive(a) => each!(points, result, n, {
                    // max(d, -c) for c > 0, max(c + d, 0) for c <= 0.
                    let (d, c, zero) = (at::<FMA>(done, a.register, n), base.value::<FMA>(a, n), Lanes::ZERO);
                    (d - (-c).greater(zero)).greater(-c.greater(zero))
                }),
                Operation::Step(a) => each!(points, result, n, {
                    let value = base.value::<FMA>(a, n) + at(done, a.register, n);
                    value.if_above(0.0, Lanes::splat(1.0)) - base.value::<FMA>(target, n)
                }),
            }
        }
    }
}

/// A register of a point.
#[inline(always)]
fn at<const FMA: bool>(done: &[Block], register: Register, n: usize) -> Lanes<FMA> {
    Lanes(done[register][n].0)
}

/// Returns `x` where `x > -1`, else NaN: the argument of `ln(1 + x)` must be positive.
#[inline(always)]
fn above_minus_one<const FMA: bool>(x: Lanes<FMA>) -> Lanes<FMA> {
    let mut result = x;
    for i in 0..WIDTH {
        result.0[i] = if x.0[i] > -1.0 { x.0[i] } else { f64::NAN };
    }
    result
}
