//! Rigid body in global node numbers: its masters, and its other nodes, whose motion follows from them.

use crate::bodies::BarycentricMap;
use crate::math::norms::diameter;

/// A rigid body among the bodies of a model.
pub struct RigidBody {
    /// Frame of the masters, in which all points of the body are fixed.
    pub frame: BarycentricMap,
    /// All nodes of the body in global node numbers; they move together.
    pub nodes: Vec<u32>,
    /// Nodes other than masters, with the weights of the masters.
    pub dependents: Vec<(u32, Vec<f64>)>,
    /// Followers: dependent nodes that are not unknowns, by their index in `dependents`.
    pub followers: Vec<usize>,
    /// Masters in global node numbers.
    pub masters: Vec<u32>,
    /// Size of the body `[length]`.
    pub size: f64,
}

impl RigidBody {
    /// Rigid body whose nodes begin at `first`; all nodes but the masters are followers.
    pub fn new(points: &[[f64; 3]], frame: BarycentricMap, first: usize) -> Self {
        let masters: Vec<u32> = frame.masters.iter().map(|node| node + first as u32).collect();
        let others = (0..points.len() as u32).filter(|node| !frame.masters.contains(node));
        let dependents: Vec<(u32, Vec<f64>)> = others.map(|node| (node + first as u32, frame.shares(points[node as usize]))).collect();
        RigidBody {
            nodes: (first..first + points.len()).map(|node| node as u32).collect(),
            followers: (0..dependents.len()).collect(),
            size: diameter(points.iter()),
            dependents,
            masters,
            frame,
        }
    }

    /// Followers: dependent nodes that are not unknowns.
    pub fn followers(&self) -> impl Iterator<Item = usize> {
        self.followers.iter().map(|&index| self.dependents[index].0 as usize)
    }

    /// Nodes with unknowns: masters, then dependent nodes that are not followers.
    pub fn unknown_nodes(&self) -> impl Iterator<Item = u32> {
        let is_follower = |index: &usize| self.followers.binary_search(index).is_ok();
        let tied = (0..self.dependents.len()).filter(move |index| !is_follower(index)).map(|index| self.dependents[index].0);
        self.masters.iter().copied().chain(tied)
    }

    /// Transfers the forces on followers to the masters: forces with the same work in every motion of the body.
    pub fn hand_over<const D: usize>(&self, forces: &mut [f64]) {
        for &index in &self.followers {
            let (node, shares) = &self.dependents[index];
            for i in 0..D {
                let force = std::mem::take(&mut forces[*node as usize * D + i]);
                self.masters.iter().zip(shares).for_each(|(&master, share)| forces[master as usize * D + i] += share * force);
            }
        }
    }

    /// Computes the followers' components of a vector (displacements, velocities) from those of the masters.
    pub fn lead<const D: usize>(&self, values: &mut [f64]) {
        for &index in &self.followers {
            let (node, shares) = &self.dependents[index];
            for i in 0..D {
                let sum = self.masters.iter().zip(shares).map(|(&master, share)| share * values[master as usize * D + i]).sum();
                values[*node as usize * D + i] = sum;
            }
        }
    }
}
