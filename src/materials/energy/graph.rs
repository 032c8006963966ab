//! Energy as a graph in which equal subexpressions share a node, with the value of every node at zero strain.
//!
//! Powers are `exp(p ln a)` and quotients products with `1/b`, so that derivatives share logarithms and reciprocals. Nodes follow their
//! operands. Sums of constants, factors 0 and 1 and constant nodes are simplified.

use std::collections::HashMap;

use super::variable::{Bits, Variable};

/// Index of a node in its graph.
pub(super) type Id = usize;

/// A node: a number, a variable, or an operation on other nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Constant(Bits),
    Variable(Variable),
    Sum(Id, Id),
    Scaled(Bits, Id),
    Product(Id, Id),
    Reciprocal(Id),
    Logarithm(Id),
    Exponential(Id),
    Root(Id),
    /// Positive part `max(a, 0)`.
    Positive(Id),
    /// 1 where `a > 0`, 0 elsewhere.
    Step(Id),
}

/// Energy as a graph of operations.
#[derive(Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    rest: Vec<f64>,
    known: HashMap<Node, Id>,
}

impl Graph {
    pub(super) fn node(&self, id: Id) -> Node {
        self.nodes[id]
    }

    /// Value at zero strain.
    pub(super) fn rest(&self, id: Id) -> f64 {
        self.rest[id]
    }

    /// Value of a constant node; `None` for other nodes.
    pub(super) fn as_constant(&self, id: Id) -> Option<f64> {
        match self.nodes[id] {
            Node::Constant(bits) => Some(bits.value()),
            _ => None,
        }
    }

    fn add(&mut self, node: Node, rest: f64) -> Id {
        if let Some(&id) = self.known.get(&node) {
            return id;
        }
        let id = self.nodes.len();
        self.nodes.push(node);
        self.rest.push(rest);
        self.known.insert(node, id);
        id
    }

    pub(super) fn constant(&mut self, value: f64) -> Id {
        self.add(Node::Constant(Bits::of(value)), value)
    }

    pub(super) fn variable(&mut self, variable: Variable) -> Id {
        self.add(Node::Variable(variable), variable.rest())
    }

    pub(super) fn sum(&mut self, a: Id, b: Id) -> Id {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(x), Some(y)) => self.constant(x + y),
            (Some(0.0), None) => b,
            (None, Some(0.0)) => a,
            _ => {
                let ((x, inner), (y, other)) = (self.factored(a), self.factored(b));
                if inner == other {
                    return self.scaled(x + y, inner);
                }
                let rest = self.rest[a] + self.rest[b];
                self.add(Node::Sum(a.min(b), a.max(b)), rest)
            }
        }
    }

    /// A node as a product of a constant factor and another node.
    fn factored(&self, a: Id) -> (f64, Id) {
        match self.nodes[a] {
            Node::Scaled(factor, inner) => (factor.value(), inner),
            _ => (1.0, a),
        }
    }

    pub(super) fn difference(&mut self, a: Id, b: Id) -> Id {
        let negative = self.scaled(-1.0, b);
        self.sum(a, negative)
    }

    pub(super) fn scaled(&mut self, factor: f64, a: Id) -> Id {
        match self.nodes[a] {
            _ if factor == 0.0 => self.constant(0.0),
            _ if factor == 1.0 => a,
            Node::Constant(bits) => self.constant(factor * bits.value()),
            Node::Scaled(inner, b) => self.scaled(factor * inner.value(), b),
            _ => {
                let rest = factor * self.rest[a];
                self.add(Node::Scaled(Bits::of(factor), a), rest)
            }
        }
    }

    pub(super) fn product(&mut self, a: Id, b: Id) -> Id {
        // Constant factors are moved to the front, so that equal products are recognized.
        match (self.nodes[a], self.nodes[b]) {
            (Node::Constant(factor), _) => self.scaled(factor.value(), b),
            (_, Node::Constant(factor)) => self.scaled(factor.value(), a),
            (Node::Scaled(factor, inner), _) => {
                let product = self.product(inner, b);
                self.scaled(factor.value(), product)
            }
            (_, Node::Scaled(factor, inner)) => {
                let product = self.product(a, inner);
                self.scaled(factor.value(), product)
            }
            _ => {
                let rest = self.rest[a] * self.rest[b];
                self.add(Node::Product(a.min(b), a.max(b)), rest)
            }
        }
    }

    pub(super) fn reciprocal(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(1.0 / bits.value()),
            Node::Reciprocal(inner) => inner,
            Node::Scaled(factor, inner) => {
                let reciprocal = self.reciprocal(inner);
                self.scaled(1.0 / factor.value(), reciprocal)
            }
            Node::Exponential(exponent) => {
                let negative = self.scaled(-1.0, exponent);
                self.exponential(negative)
            }
            _ => {
                let rest = 1.0 / self.rest[a];
                self.add(Node::Reciprocal(a), rest)
            }
        }
    }

    pub(super) fn logarithm(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(bits.value().ln()),
            Node::Exponential(exponent) => exponent,
            _ => {
                let rest = self.rest[a].ln();
                self.add(Node::Logarithm(a), rest)
            }
        }
    }

    pub(super) fn exponential(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(bits.value().exp()),
            _ => {
                let rest = self.rest[a].exp();
                self.add(Node::Exponential(a), rest)
            }
        }
    }

    pub(super) fn root(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(bits.value().sqrt()),
            _ => {
                let rest = self.rest[a].sqrt();
                self.add(Node::Root(a), rest)
            }
        }
    }

    pub(super) fn positive(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(bits.value().max(0.0)),
            _ => {
                let rest = self.rest[a].max(0.0);
                self.add(Node::Positive(a), rest)
            }
        }
    }

    fn step(&mut self, a: Id) -> Id {
        let rest = if self.rest[a] > 0.0 { 1.0 } else { 0.0 };
        self.add(Node::Step(a), rest)
    }

    /// `a^p` for a constant `p`: repeated products for small whole `p`, a root, or `exp(p ln a)`.
    pub(super) fn power(&mut self, a: Id, p: f64) -> Id {
        const LARGEST: f64 = 32.0;
        if p < 0.0 {
            let positive = self.power(a, -p);
            return self.reciprocal(positive);
        }
        if p == 0.5 {
            return self.root(a);
        }
        if p.fract() != 0.0 || p > LARGEST {
            let logarithm = self.logarithm(a);
            let exponent = self.scaled(p, logarithm);
            return self.exponential(exponent);
        }
        let (mut result, mut square, mut left) = (self.constant(1.0), a, p as u32);
        while left > 0 {
            if left % 2 == 1 {
                result = self.product(result, square);
            }
            left /= 2;
            if left > 0 {
                square = self.product(square, square);
            }
        }
        result
    }

    /// Returns one flag per node: true for the `roots` and the nodes needed to compute them.
    pub(super) fn needed(&self, roots: &[Id]) -> Vec<bool> {
        let mut needed = vec![false; roots.iter().max().map_or(0, |last| last + 1)];
        for &root in roots {
            needed[root] = true;
        }
        for id in (0..needed.len()).rev().filter(|&id| self.as_constant(id).is_none()) {
            if needed[id] {
                for part in self.parts(id).into_iter().flatten() {
                    needed[part] = true;
                }
            }
        }
        needed
    }

    fn parts(&self, id: Id) -> [Option<Id>; 2] {
        match self.nodes[id] {
            Node::Constant(_) | Node::Variable(_) => [None, None],
            Node::Sum(a, b) | Node::Product(a, b) => [Some(a), Some(b)],
            Node::Scaled(_, a)
            | Node::Reciprocal(a)
            | Node::Logarithm(a)
            | Node::Exponential(a)
            | Node::Root(a)
            | Node::Positive(a)
            | Node::Step(a) => [Some(a), None],
        }
    }

    /// Variables that a node depends on, in the order of their first use.
    pub(super) fn variables(&self, root: Id) -> Vec<Variable> {
        let needed = self.needed(&[root]);
        let variable = |id: Id| match self.nodes[id] {
            Node::Variable(variable) if needed[id] => Some(variable),
            _ => None,
        };
        (0..needed.len()).filter_map(variable).collect()
    }

    /// Derivative of a node with respect to a variable, as a node.
    pub(super) fn derivative(&mut self, root: Id, variable: Variable) -> Id {
        let needed = self.needed(&[root]);
        let zero = self.constant(0.0);
        let mut slopes = vec![zero; root + 1];
        for id in (0..=root).filter(|&id| needed[id]) {
            slopes[id] = match self.nodes[id] {
                Node::Constant(_) | Node::Step(_) => zero,
                Node::Variable(found) => self.constant(if found == variable { 1.0 } else { 0.0 }),
                Node::Sum(a, b) => self.sum(slopes[a], slopes[b]),
                Node::Scaled(factor, a) => self.scaled(factor.value(), slopes[a]),
                Node::Product(a, b) => {
                    let (left, right) = (self.product(slopes[a], b), self.product(a, slopes[b]));
                    self.sum(left, right)
                }
                Node::Reciprocal(a) => {
                    let square = self.product(id, id);
                    let product = self.product(square, slopes[a]);
                    self.scaled(-1.0, product)
                }
                Node::Logarithm(a) => {
                    let reciprocal = self.reciprocal(a);
                    self.product(reciprocal, slopes[a])
                }
                Node::Exponential(a) => self.product(id, slopes[a]),
                Node::Root(a) => {
                    let reciprocal = self.reciprocal(id);
                    let half = self.scaled(0.5, reciprocal);
                    self.product(half, slopes[a])
                }
                Node::Positive(a) => {
                    let step = self.step(a);
                    self.product(step, slopes[a])
                }
            };
        }
        slopes[root]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_parts_are_one_node() {
        let mut graph = Graph::default();
        let j = graph.variable(Variable::J);
        let (a, b) = (graph.power(j, 2.0), graph.product(j, j));
        assert_eq!(a, b);
        let (two, one) = (graph.scaled(2.0, j), graph.scaled(0.5, j));
        let product = graph.product(two, one);
        assert_eq!(product, a, "factors are folded");
        let logarithm = graph.logarithm(j);
        let exponential = graph.exponential(logarithm);
        let again = graph.logarithm(exponential);
        assert_eq!(again, logarithm);
        let (three, zero) = (graph.scaled(3.0, a), graph.constant(0.0));
        assert_eq!(graph.difference(three, three), zero);
    }

    #[test]
    fn derivatives_of_powers_share_their_parts() {
        // The derivative of J^-2/3 is -2/3 J^-2/3 / J and needs no second exponential.
        let mut graph = Graph::default();
        let j = graph.variable(Variable::J);
        let power = graph.power(j, -2.0 / 3.0);
        let slope = graph.derivative(power, Variable::J);
        let needed = graph.needed(&[power, slope]);
        let count = |is: fn(Node) -> bool| (0..needed.len()).filter(|&id| needed[id] && is(graph.node(id))).count();
        assert_eq!(count(|node| matches!(node, Node::Exponential(_))), 1);
        assert_eq!(graph.rest(slope), -2.0 / 3.0);
        assert_eq!(graph.derivative(power, Variable::I1), graph.constant(0.0));
    }
}
