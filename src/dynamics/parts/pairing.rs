//! Construction of the contact pairs of a model: contacts, obstacles and ties, then their corner and rolling constraints.

use super::contact_pair::{ContactPair, CornersOf, PairKind};
use super::laws::Bilateral;
use super::round_contacts::RoundContacts;
use crate::bodies::BarycentricMap;
use crate::contact::{
    ContactKernel, CornersInSpace, FacetShape, NodeToSegment, NodesOnObstacle, Obstacle, ObstacleInSpace, ProxyNodes, ProxySurfacesInSpace,
    RigidCorners, RoundInSpace, RowsOf, Setting, Surface, Tie, TouchingPoints, rigid_contact, rolling_contact, round_contact,
};
use crate::dynamics::model::boundaries::{boundary_faces, boundary_facets, facets_of_all, tie_reach, tied_in_space};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::{BodyBoundary, Enforcement, Interaction, ObstacleRotation, Partner};
use crate::dynamics::model::update_rules::UpdateRule;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// All contact pairs of a model. `first` is the first node of each body, `middles` the mid-side nodes of edges of second order,
/// `default_rule` the update rule of contacts without a rule of their own. Pairs of point constraints (`points`) come last. Ties keep the
/// positions `start`.
pub fn contact_pairs(
    model: &Model,
    first: impl Fn(usize) -> usize,
    middles: &ProxyNodes,
    [reference, start]: [&[f64]; 2],
    default_rule: &'static UpdateRule,
    points: Vec<ContactPair>,
) -> Vec<ContactPair> {
    let facets = |on: &BodyBoundary| boundary_facets(model, on, first(on.body));
    let faces = |on: &BodyBoundary| boundary_faces(model, on, first(on.body));
    let made = Pairing {
        model,
        first: &first,
        facets: &facets,
        faces: &faces,
        middles,
        reference,
        start,
        reach: largest_size(reference),
        default_rule,
        round: RoundContacts { model, first: &first, reference },
    };
    let mut pairs = made.contacts();
    let corners = made.corners(&pairs);
    let rolling: Vec<ContactPair> = (0..pairs.len()).filter_map(|of| made.rolling(of)).collect();
    let holding = corners.iter().filter(|pair| !pair.only_measures()).filter_map(|pair| pair.corners);
    holding.for_each(|corners| pairs[corners.pair].kernel.set(Setting::BesideCorners));
    pairs.extend(corners);
    pairs.extend(rolling);
    pairs.extend(points);
    let (mut first, mut joint) = (0, 0);
    for pair in &mut pairs {
        pair.rows = first..first + pair.rows.end;
        // The tangential constraint of a joint refers to the constraints of the joint before it.
        pair.reaction.iter_mut().for_each(|reaction| reaction.rows = joint..joint + reaction.rows.len());
        (joint, first) = (first, pair.rows.end);
    }
    for friction in pairs.iter_mut().filter_map(|pair| pair.friction.as_mut()) {
        friction.rows = first..first + friction.rows.end;
        first = friction.rows.end;
    }
    pairs
}

/// Admitted overlap ([`CornersOf::slack`]) of sharp vertices and edges in space, relative to that of corners in the plane: from a
/// thousandth of a facet on, constraints of flat surfaces and of their borders are no longer linearly dependent.
const SLACK_IN_SPACE: f64 = 0.05;

/// True if none of the `nodes` is among the `others`, ascending.
fn avoids(nodes: &[u32], others: &[u32]) -> bool {
    nodes.iter().all(|node| others.binary_search(node).is_err())
}

/// Data from which contact pairs are made.
struct Pairing<'a> {
    model: &'a Model,
    /// First node of each body.
    first: &'a dyn Fn(usize) -> usize,
    /// Facets of a boundary in global node numbers.
    facets: &'a dyn Fn(&BodyBoundary) -> Vec<[u32; 2]>,
    /// Faces of a boundary in space, in global node numbers.
    faces: &'a dyn Fn(&BodyBoundary) -> Vec<Vec<u32>>,
    /// Mid-side nodes of edges of second order.
    middles: &'a ProxyNodes,
    /// Reference positions.
    reference: &'a [f64],
    /// Positions at the start.
    start: &'a [f64],
    /// Largest coordinate of the reference positions.
    reach: f64,
    /// Update rule of contacts without an explicit rule.
    default_rule: &'static UpdateRule,
    /// Round parts of rigid bodies.
    round: RoundContacts<'a>,
}

impl Pairing<'_> {
    fn pair(&self, name: &str, kind: PairKind, body: usize, mut kernel: Box<dyn ContactKernel>) -> ContactPair {
        let modulus = self.model.modulus(body);
        if self.model.is_axisymmetric() {
            kernel.set(Setting::AboutAxis);
        }
        let mut pair = ContactPair::new(name, kind, kernel, modulus, self.reach);
        pair.is_axisymmetric = self.model.is_axisymmetric();
        pair
    }

    /// Makes a pair with an obstacle in space, whose tolerances account for the size of the obstacle's coordinates.
    fn obstacle_pair(&self, name: &str, shape: &ObstacleInSpace, body: usize, kernel: Box<dyn ContactKernel>) -> ContactPair {
        let far = Pairing { reach: self.reach.max(shape.reach()), ..*self };
        far.pair(name, PairKind::Obstacle, body, kernel)
    }

    /// Contact with an obstacle that turns about an axis, from the contact with the obstacle at rest.
    fn turning(&self, turn: &Option<ObstacleRotation>, kernel: Box<dyn ContactKernel>) -> Box<dyn ContactKernel> {
        ObstacleRotation::turning(turn.as_ref(), kernel, self.reference)
    }

    /// One pair per contact of the model, in the order of [`Model::contact_names`].
    fn contacts(&self) -> Vec<ContactPair> {
        self.model.interactions.iter().map(|interaction| self.pair_of(interaction)).collect()
    }

    /// Surfaces of a contact in space with sub-facet points between their nodes, the secondary surface without the faces at the nodes
    /// `without`; the primary surface of an obstacle is empty.
    fn in_space(&self, interaction: &Interaction, without: &[u32]) -> ProxySurfacesInSpace<'_> {
        let primary = if self.round.bodies(interaction).is_some() { &[] } else { interaction.primary() };
        let mut faces = [std::slice::from_ref(&interaction.secondary), primary].map(|side| facets_of_all(side, self.faces));
        faces[0].retain(|face| avoids(face, without));
        interaction.proxy_surfaces_in_space(&faces, self.reference)
    }

    fn pair_of(&self, interaction: &Interaction) -> ContactPair {
        let Interaction { name, secondary, partner, .. } = interaction;
        if let Partner::Obstacle { shape: obstacle @ Obstacle::InSpace(shape), motion, turn } = partner {
            let surfaces = self.in_space(interaction, &[]);
            let is_hidden = surfaces.belongs_to(&self.round.nodes_inside(interaction));
            let nodes = NodesOnObstacle { is_hidden, heights: surfaces.heights(0), ..Default::default() };
            let kernel = rigid_contact(surfaces.secondary.clone(), obstacle, &surfaces.reference, nodes);
            let kernel = self.turning(turn, surfaces.on_nodes(kernel, true));
            let mut pair = self.obstacle_pair(name, shape, secondary.body, kernel);
            (pair.motion, pair.turn) = (motion.clone(), turn.clone());
            let mut pair = self.held(pair, interaction, false);
            if matches!(shape, ObstacleInSpace::Facets(_)) && pair.has_multipliers() {
                // Sides that meet at a small angle give nearly dependent constraints of a node.
                pair.augmentation = pair.augmentation.or(Some(tolerances::CORNER_AUGMENTATION));
            }
            return pair;
        }
        if let (3, Partner::Tied { to, reach }) = (self.model.dimension(), partner) {
            let (surfaces, tie, _) = tied_in_space(self.model, [secondary, to], *reach, self.first, self.start);
            return self.pair(name, PairKind::Tie, secondary.body, surfaces.on_nodes(Box::new(tie), true));
        }
        if let (3, Some(kernel)) = (self.model.dimension(), interaction.method.in_space) {
            let surfaces = self.in_space(interaction, &[]);
            let kernel = surfaces.on_nodes(kernel(&surfaces), true);
            let mut pair = self.held(self.pair(name, PairKind::Surfaces, secondary.body, kernel), interaction, false);
            if pair.has_multipliers() {
                // Over a small part of a facet the constraints of its nodes are nearly dependent.
                pair.augmentation = pair.augmentation.or(Some(tolerances::SURFACE_AUGMENTATION));
            }
            return pair;
        }
        let facets = (self.facets)(secondary);
        let pair = match partner {
            Partner::Surfaces(_) | Partner::Itself => {
                // The facets of round bodies have no constraints.
                let is_round = self.round.bodies(interaction).is_some();
                let others = if is_round { Vec::new() } else { facets_of_all(interaction.primary(), self.facets) };
                let rows = if interaction.method.is_nodal { RowsOf::Nodes } else { RowsOf::Facets };
                let exact = interaction.exact_shapes();
                let surfaces = self.middles.surfaces([&facets, &others], self.reference, rows).of_shape(interaction.facet_shape(2));
                let surfaces = surfaces.of_exact(exact.each_ref().map(Option::as_ref));
                let kernel = (interaction.method.kernel)(&surfaces.secondary, &surfaces.primary, &surfaces.reference);
                self.pair(name, PairKind::Surfaces, secondary.body, surfaces.on_nodes(kernel))
            }
            Partner::Obstacle { shape, motion, turn } => {
                let (surface, inside) = (Surface::new(&facets), self.round.nodes_inside(interaction));
                let is_hidden = surface.nodes().iter().map(|node| inside.binary_search(node).is_ok()).collect();
                // Constraints of obstacles belong to the nodes of the surface itself, not to a proxy surface.
                let weights = self.middles.lengths(&facets, self.reference);
                let arcs = TouchingPoints::Arcs { radius: interaction.radius() };
                let points = if self.model.touches_with_arcs(interaction) { arcs } else { TouchingPoints::Nodes };
                let nodes = NodesOnObstacle { is_hidden, weights, points, ..Default::default() };
                let kernel = rigid_contact(surface, shape, self.reference, nodes);
                let mut pair = self.pair(name, PairKind::Obstacle, secondary.body, self.turning(turn, kernel));
                (pair.motion, pair.turn) = (motion.clone(), turn.clone());
                pair
            }
            Partner::Tied { to, reach } => {
                let reach = reach.unwrap_or_else(|| tie_reach(&Surface::new(&facets), self.start));
                let others = (self.facets)(to);
                let surfaces = self.middles.surfaces([&facets, &others], self.start, RowsOf::Facets);
                let tie = Tie::new(&surfaces.secondary, &surfaces.primary, &surfaces.reference, reach);
                return self.pair(name, PairKind::Tie, secondary.body, surfaces.on_nodes(Box::new(tie)));
            }
        };
        let has_middles = self.middles.lengths(&facets, self.reference).is_some();
        self.held(pair, interaction, has_middles)
    }

    /// Adds the enforcement, restitution and friction of an interaction to a pair; `has_middles`: edges of the surface are of second order.
    fn held(&self, mut pair: ContactPair, interaction: &Interaction, has_middles: bool) -> ContactPair {
        pair.update = interaction.update.unwrap_or(self.default_rule);
        if interaction.equality {
            pair.law = &Bilateral;
        }
        match interaction.enforcement {
            Enforcement::Multiplier => {}
            Enforcement::Penalty { factor } => pair.penalize(factor, self.reference, has_middles),
            Enforcement::AugmentedLagrange { factor } => pair.augmentation = Some(factor),
        }
        if self.model.bodies[interaction.secondary.body].rigid.is_some() && pair.has_multipliers() {
            // A rigid side has fewer motions than nodes: constraints of its nodes are linearly dependent.
            pair.augmentation = pair.augmentation.or(Some(tolerances::CORNER_AUGMENTATION));
        }
        if (interaction.equality || self.is_coupled(interaction)) && pair.has_multipliers() {
            // Bilateral contacts may hold nodes that joints and couplings hold already, as long as the contact is covered. Where normals
            // are equal, contacts at both sides of a periodic pair, at a boundary that moves with a reference body, and of a node in a
            // plane of symmetry are dependent.
            pair.augmentation = pair.augmentation.or(Some(tolerances::SURFACE_AUGMENTATION));
        }
        pair.restitution = self.restitution(interaction, &pair);
        pair.add_friction(interaction);
        pair
    }

    /// True if couplings join nodes of a body of the contact.
    fn is_coupled(&self, interaction: &Interaction) -> bool {
        let mut sides = std::iter::once(&interaction.secondary).chain(interaction.primary());
        sides.any(|side| self.model.couplings.iter().any(|coupling| coupling.kind.boundaries().iter().any(|on| on.body == side.body)))
    }

    /// Coefficient of restitution of a contact between rigid sides; `None` for deformable sides and for bilateral or penalty contacts.
    fn restitution(&self, interaction: &Interaction, pair: &ContactPair) -> Option<f64> {
        let is_rigid = pair.is_unilateral() && self.model.is_rigid_contact(interaction);
        is_rigid.then(|| interaction.restitution.unwrap_or(pair.update.restitution()))
    }

    /// Pair of the round parts of a rigid body that roll on the obstacle of contact `of`.
    fn rolling(&self, of: usize) -> Option<ContactPair> {
        let interaction = &self.model.interactions[of];
        let (parts, body) = (self.round.parts(interaction), interaction.secondary.body);
        if let Some((secondary, primary)) = self.round.bodies(interaction) {
            let kernel = round_contact(self.round.surface(&interaction.secondary), &secondary, primary, self.reference);
            let mut pair = self.pair(&interaction.name, PairKind::Surfaces, body, kernel);
            pair.corners = Some(CornersOf { pair: of, slack: 0.0 });
            return Some(self.held(pair, interaction, false));
        }
        let Partner::Obstacle { shape, motion, turn } = &interaction.partner else { return None };
        let mesh = &self.model.bodies[body].mesh;
        let frame = BarycentricMap::new(mesh).filter(|_| !parts.is_empty())?;
        let first = (self.first)(body) as u32;
        let shares_of = |point| frame.masters.iter().map(|node| node + first).zip(frame.shares(point)).collect();
        let kernel = rolling_contact(self.round.surface(&interaction.secondary), parts, shape, &shares_of, self.reference);
        let kernel = self.turning(turn, kernel);
        let mut pair = match shape {
            Obstacle::InSpace(shape) => self.obstacle_pair(&interaction.name, shape, body, kernel),
            _ => self.pair(&interaction.name, PairKind::Obstacle, body, kernel),
        };
        (pair.motion, pair.turn, pair.corners) = (motion.clone(), turn.clone(), Some(CornersOf { pair: of, slack: 0.0 }));
        Some(self.held(pair, interaction, false))
    }

    /// Pairs of the corner constraints of contacts, for penetration that their weighted gaps do not detect. Round parts of rigid bodies,
    /// which touch as arcs and spheres, have none.
    fn corners(&self, pairs: &[ContactPair]) -> Vec<ContactPair> {
        let has_corners = |of: usize| pairs[of].is_unilateral() || !pairs[of].has_multipliers();
        let size = |of: usize| pairs[of].kernel.facet_size();
        let mut corners = Vec::new();
        let mut add = |of: usize, kind: PairKind, body: usize, slack: f64, kernel: Box<dyn ContactKernel>| {
            let owner = &pairs[of];
            let factor = owner.augmentation.unwrap_or(tolerances::CORNER_AUGMENTATION);
            let belongs = CornersOf { pair: of, slack: slack * tolerances::CORNER_SLACK * owner.kernel.facet_size() };
            let mut pair = self.pair(&owner.name, kind, body, kernel);
            (pair.corners, pair.augmentation) = (Some(belongs), Some(factor));
            (pair.update, pair.motion, pair.turn) = (owner.update, owner.motion.clone(), owner.turn.clone());
            pair.restitution = owner.restitution;
            if owner.has_multipliers() {
                pair.add_friction(&self.model.interactions[of]);
            } else {
                // A potential of the corner's gap would change where the corner passes a node, without work: only the depth is measured.
                pair.penalize(0.0, self.reference, false);
            }
            corners.push(pair);
        };
        for (of, interaction) in self.model.interactions.iter().enumerate().filter(|&(of, _)| has_corners(of)) {
            if self.round.bodies(interaction).is_some() {
                continue;
            }
            if let Partner::Obstacle { shape: obstacle @ Obstacle::InSpace(shape), turn, .. } = &interaction.partner {
                let surfaces = self.in_space(interaction, &self.round.nodes_inside(interaction));
                if let Some(kernel) = RigidCorners::new(&surfaces.secondary, obstacle, [&surfaces.reference, &surfaces.curve], size(of)) {
                    let kernel = self.turning(turn, surfaces.on_nodes(Box::new(kernel), false));
                    add(of, PairKind::Obstacle, interaction.secondary.body, SLACK_IN_SPACE, kernel);
                }
                if let Some(kernel) = RoundInSpace::new(&surfaces.secondary, shape, &surfaces.reference, size(of)) {
                    let kernel = self.turning(turn, surfaces.on_nodes(Box::new(kernel), false));
                    add(of, PairKind::Obstacle, interaction.secondary.body, SLACK_IN_SPACE, kernel);
                }
                continue;
            }
            if self.model.dimension() == 3 {
                let surfaces = self.in_space(interaction, &[]);
                // Facets without edge constraints of their own would let the primary side enter between secondary nodes.
                let surfaces = if interaction.method.is_nodal { surfaces.of_shape(FacetShape::Straight) } else { surfaces };
                let kernel = CornersInSpace::kernel(&surfaces);
                if let (Partner::Surfaces(_), Some(kernel)) = (&interaction.partner, kernel) {
                    add(of, PairKind::Surfaces, interaction.secondary.body, SLACK_IN_SPACE, surfaces.on_nodes(kernel, false));
                }
                continue;
            }
            if let Partner::Obstacle { shape, turn, .. } = &interaction.partner {
                let mut facets = (self.facets)(&interaction.secondary);
                let inside = self.round.nodes_inside(interaction);
                facets.retain(|facet| avoids(facet, &inside));
                let surfaces = self.middles.surfaces([&facets, &[]], self.reference, RowsOf::Facets);
                let surface = Surface::new(&surfaces.secondary);
                if let Some(kernel) = RigidCorners::new(&surface, shape, [&surfaces.reference; 2], size(of)) {
                    let slack = RigidCorners::slack(shape, size(of));
                    let kernel = self.turning(turn, surfaces.on_nodes(Box::new(kernel)));
                    add(of, PairKind::Obstacle, interaction.secondary.body, slack, kernel);
                }
            }
            let exact = interaction.exact_shapes();
            for Cornered { on, against, is_primary } in cornered(interaction) {
                let shapes = if is_primary { [&exact[1], &exact[0]] } else { [&exact[0], &exact[1]] };
                let [own, others] = [on, against].map(|side| facets_of_all(side, self.facets));
                let surfaces = self.middles.surfaces([&own, &others], self.reference, RowsOf::Nodes).of_shape(interaction.facet_shape(2));
                let surfaces = surfaces.of_exact(shapes.map(Option::as_ref));
                let sides: [&[[u32; 2]]; 2] = [&surfaces.secondary, &surfaces.primary];
                let is_nodal = pairs[of].kernel.is_nodal();
                if let Some(kernel) = NodeToSegment::of_corners(sides, &surfaces.reference, size(of), is_nodal) {
                    add(of, PairKind::Surfaces, on[0].body, 1.0, surfaces.on_nodes(Box::new(kernel)));
                }
            }
        }
        corners
    }
}

/// Side of a contact whose corners may penetrate the other side.
struct Cornered<'a> {
    on: &'a [BodyBoundary],
    against: &'a [BodyBoundary],
    is_primary: bool,
}

/// Sides of a contact between deformable bodies whose corners may penetrate the other side: all but sides with nodal constraints.
fn cornered(interaction: &Interaction) -> Vec<Cornered<'_>> {
    let (secondary, primary) = (std::slice::from_ref(&interaction.secondary), interaction.primary());
    let mut sides = Vec::new();
    if !interaction.method.is_nodal {
        sides.push(Cornered { on: secondary, against: primary, is_primary: false });
    }
    match interaction.partner {
        Partner::Surfaces(_) => sides.push(Cornered { on: primary, against: secondary, is_primary: true }),
        Partner::Itself => {}
        Partner::Obstacle { .. } | Partner::Tied { .. } => sides.clear(),
    }
    sides
}
