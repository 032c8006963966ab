//! A recording: data for the animation of a run, kept beside the run and bounded in memory.
//!
//! At first, a *still* of every nominal step is kept, or of every few if many steps are expected; when there are more than allowed, every
//! second one is dropped and the spacing doubles. The stills thus depend only on the steps, not on the clock, and memory is bounded. A
//! still holds displacement, velocity and stress of all visible nodes (in space those of the hull, optionally also inner ones), the plastic
//! strain of bodies with plasticity, and the quantities for which a script asks ([`FURTHER`]), as 16-bit numbers between the extremes of
//! each component: an error of 1/131072 of the range. A simulation cannot be continued from a still.
//!
//! Bytes of a still, body after body, little-endian: for each component its two extremes as f32; the high bytes of all components, then
//! their low bytes, each value as the difference from the node before; the number of contact nodes (u32), their places among the nodes of
//! the body (u32, with [`BodyFields::contact_slip`] in the two highest bits), for each its pressure and the vector of the pressure (f32).
//! Reports have identical bytes, compressed.

use std::fmt;
use std::sync::Arc;

use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::picture::{Field, Vectors};
use super::still_fields::{FURTHER, Further, Rank, StillOptions};
use crate::contact::{Obstacle, ObstaclePlacement};
use crate::dynamics::{BodyDefinition, BodyFields, Model, Partner, PlacedObstacle, Simulation};
use crate::mesh::Mesh;

/// Default of the largest number of stills.
const STILLS: usize = 160;
/// Default of the memory for stills `[bytes]`.
const BYTES: usize = 24 << 20;
/// Least number of stills, also if they exceed [`BYTES`].
const FEWEST: usize = 40;
/// Largest initial spacing.
const FORESIGHT: usize = 4;
/// Largest encoded value of a component.
const TOP: f64 = 65535.0;
/// First bit for stick or slip in the word of a contact node.
const SLIP: u32 = 30;
/// Mask of the bits below `SLIP`.
const PLACE: usize = (1 << SLIP) - 1;

/// Stills of a run. A value: a restored recording continues with identical bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    most: usize,
    spacing: usize,
    steps: usize,
    stills: Vec<Arc<Still>>,
    bodies: Vec<Skin>,
}

/// Recorded nodes and quantities of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skin {
    /// Nodes that are recorded, in ascending order.
    pub nodes: Vec<u32>,
    /// Space dimension.
    pub dimension: usize,
    /// True for a body whose material flows plastically: its plastic strain is recorded.
    pub flows: bool,
    /// Further quantities that are recorded, as ascending indices into [`FURTHER`].
    further: Vec<usize>,
}

impl Skin {
    fn new(mesh: &Mesh, flows: bool, options: &StillOptions) -> Self {
        let dimension = mesh.dimension();
        let mut nodes: Vec<u32> = if dimension == 2 || options.has_inside {
            (0..mesh.points.len() as u32).collect()
        } else {
            mesh.hull().into_iter().flat_map(|facet| mesh.facet_nodes(facet).collect::<Vec<_>>()).collect()
        };
        nodes.sort_unstable();
        nodes.dedup();
        Skin { nodes, dimension, flows, further: options.further() }
    }

    /// Components of the stress in a body of this dimension, as indices into [`BodyFields::stress`].
    pub fn stresses(&self) -> &'static [usize] {
        if self.dimension == 2 { &[0, 1, 2, 3] } else { &[0, 1, 2, 3, 4, 5] }
    }

    /// Further quantities that are recorded.
    fn further(&self) -> impl Iterator<Item = &'static Further> + '_ {
        self.further.iter().filter_map(|&index| FURTHER.get(index))
    }

    /// Names of the further quantities and the numbers of their components, in the order of the bytes.
    pub fn further_names(&self) -> Vec<(&'static str, usize)> {
        self.further().map(|further| (further.name, self.rank(further))).collect()
    }

    fn rank(&self, further: &Further) -> usize {
        match further.rank {
            Rank::Number => 1,
            Rank::Vector => self.dimension,
            Rank::Tensor => self.stresses().len(),
        }
    }

    /// Number of recorded components per node of every recording.
    fn basic_components(&self) -> usize {
        2 * self.dimension + self.stresses().len() + usize::from(self.flows)
    }

    /// Number of recorded components per node.
    fn components(&self) -> usize {
        self.basic_components() + self.further().map(|further| self.rank(further)).sum::<usize>()
    }

    /// Further quantity of a component, and the component of that quantity.
    fn further_at(&self, component: usize) -> Option<(&'static Further, usize)> {
        let mut left = component.checked_sub(self.basic_components())?;
        for further in self.further() {
            match left.checked_sub(self.rank(further)) {
                Some(rest) => left = rest,
                // Tensors in the plane have the first components of those in space.
                None => return Some((further, left)),
            }
        }
        None
    }
}

/// Rigid obstacle in a still: index of its shape in [`shapes`], translation `[length]` and rotation vector `[rad]`.
pub type StillObstacle = (usize, [f64; 3], [f64; 3]);

/// Recorded fields of a state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Still {
    /// Row of the history.
    pub row: usize,
    /// Number of nominal steps from the start of the run to this state.
    steps: usize,
    /// Time `[time]`.
    pub time: f64,
    /// Least and greatest value of each field of [`Field::BASIC`] at the recorded nodes.
    pub extremes: Vec<[f64; 2]>,
    /// Longest vector of contact pressure `[stress]`.
    pub pressing: f64,
    /// Rigid obstacles.
    pub obstacles: Vec<StillObstacle>,
    bytes: Bytes,
}

/// Bytes that are serialized at once.
#[derive(Clone, PartialEq, Default)]
struct Bytes(Vec<u8>);

impl fmt::Debug for Bytes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} bytes", self.0.len())
    }
}

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Bytes;
            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("bytes")
            }
            fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Bytes, E> {
                Ok(Bytes(bytes.to_vec()))
            }
            fn visit_byte_buf<E>(self, bytes: Vec<u8>) -> Result<Bytes, E> {
                Ok(Bytes(bytes))
            }
            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut bytes: A) -> Result<Bytes, A::Error> {
                let mut all = Vec::with_capacity(bytes.size_hint().unwrap_or(0));
                while let Some(byte) = bytes.next_element()? {
                    all.push(byte);
                }
                Ok(Bytes(all))
            }
        }
        deserializer.deserialize_byte_buf(Reader)
    }
}

/// Returns the different shapes of a model's rigid obstacles.
pub fn shapes(model: &Model) -> Vec<Obstacle> {
    let mut shapes: Vec<Obstacle> = Vec::new();
    for interaction in &model.interactions {
        if let Partner::Obstacle { shape, .. } = &interaction.partner
            && !shapes.contains(shape)
        {
            shapes.push(shape.clone());
        }
    }
    shapes
}

impl Recording {
    /// Returns an empty recording of a model.
    pub fn new(model: &Model, options: &StillOptions) -> Self {
        let bodies: Vec<Skin> = model.bodies.iter().map(|body| Skin::new(&body.mesh, body.flows(), options)).collect();
        let size: usize = bodies.iter().map(|skin| 2 * skin.components() * skin.nodes.len()).sum();
        let most = options.most.unwrap_or_else(|| (BYTES / size.max(1)).clamp(FEWEST, STILLS)).max(2);
        Recording { most, spacing: 1, steps: 0, stills: Vec::new(), bodies }
    }

    /// Recorded nodes and quantities of each body.
    pub fn bodies(&self) -> &[Skin] {
        &self.bodies
    }

    /// True if the recording `other`, read from a file, can continue this one: same bodies, complete stills, rows below `rows` in the
    /// history, and obstacle shapes below `shapes`.
    pub fn goes_on_with(&self, other: &Recording, rows: usize, shapes: usize) -> bool {
        let is_whole = |still: &Arc<Still>| {
            still.is_of(&self.bodies)
                && still.extremes.len() == Field::BASIC.len()
                && still.row < rows
                && still.obstacles.iter().all(|(shape, ..)| *shape < shapes)
        };
        (other.most, &other.bodies) == (self.most, &self.bodies) && other.spacing.is_power_of_two() && other.stills.iter().all(is_whole)
    }

    /// Stills in the order of time.
    pub fn stills(&self) -> &[Arc<Still>] {
        &self.stills
    }

    /// Sets the initial spacing for an expected number of nominal steps. It is at most `FORESIGHT`, because a run may end early; explicit
    /// steps, of which a still takes as long as ten or twenty, begin with a spacing that leaves `FEWEST` stills.
    pub fn expect(&mut self, steps: f64, is_explicit: bool) {
        if self.stills.len() <= 1 && self.steps == 0 && self.spacing == 1 {
            let (largest, most) = if is_explicit { (usize::MAX / 2, self.most.min(2 * FEWEST)) } else { (FORESIGHT, self.most) };
            while self.spacing < largest && steps / self.spacing as f64 > most as f64 {
                self.spacing *= 2;
            }
        }
    }

    /// Records the state at the start, whose row of the history is `row`.
    pub fn begin(&mut self, simulation: &Simulation, row: usize) {
        if self.stills.is_empty() {
            self.stills.push(Arc::new(self.still(simulation, row)));
        }
    }

    /// Records the state after a nominal step or a new equilibrium, whose last row of the history is `row`.
    pub fn advanced(&mut self, simulation: &Simulation, row: usize) {
        if self.stills.is_empty() {
            return self.begin(simulation, row);
        }
        self.steps += 1;
        if !self.steps.is_multiple_of(self.spacing) {
            return;
        }
        if self.stills.len() >= self.most {
            self.spacing *= 2;
            let spacing = self.spacing;
            self.stills.retain(|still| still.steps.is_multiple_of(spacing));
            if !self.steps.is_multiple_of(spacing) {
                return;
            }
        }
        self.stills.push(Arc::new(self.still(simulation, row)));
    }

    /// Drops stills behind the first `rows` rows of the history, when a simulation goes back.
    pub fn keep(&mut self, rows: usize) {
        self.stills.retain(|still| still.row < rows);
        // Steps since the last still are unknown here; a substep counts as a step.
        self.steps = self.stills.last().map_or(0, |last| last.steps + rows.saturating_sub(last.row + 1));
    }

    /// Returns a still of the present state.
    pub fn still(&self, simulation: &Simulation, row: usize) -> Still {
        let shapes = shapes_of(&simulation.obstacles());
        Still { row, steps: self.steps, time: simulation.time(), ..self.packed(&simulation.fields(), shapes) }
    }

    fn packed(&self, bodies: &[BodyFields], obstacles: Vec<StillObstacle>) -> Still {
        let mut bytes = Vec::new();
        let mut extremes = vec![[f64::INFINITY, f64::NEG_INFINITY]; Field::BASIC.len()];
        let mut pressing: f64 = 0.0;
        for (body, skin) in bodies.iter().zip(&self.bodies) {
            pack_into(&mut bytes, body, skin);
            for ([low, high], [least, greatest]) in extremes.iter_mut().zip(extremes_of(body, skin)) {
                (*low, *high) = (low.min(least), high.max(greatest));
            }
            pressing = body.contact_pressure.iter().fold(pressing, |longest, pressure| longest.max(pressure.abs()));
        }
        Still { row: 0, steps: 0, time: 0.0, extremes, pressing, obstacles, bytes: Bytes(bytes) }
    }
}

/// Returns obstacles as indices of shapes, numbered in the order of their first occurrence.
fn shapes_of(placed: &[PlacedObstacle]) -> Vec<StillObstacle> {
    let mut shapes: Vec<&Obstacle> = Vec::new();
    let mut number = |shape| match shapes.iter().position(|known| *known == shape) {
        Some(number) => number,
        None => {
            shapes.push(shape);
            shapes.len() - 1
        }
    };
    placed.iter().map(|obstacle| (number(&obstacle.shape), obstacle.place.translation, obstacle.place.rotation)).collect()
}

/// Returns minimum and maximum of each field of [`Field::BASIC`]. Magnitudes are compared by their squares, because the function runs after
/// most steps.
fn extremes_of(body: &BodyFields, skin: &Skin) -> Vec<[f64; 2]> {
    let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; Field::BASIC.len()];
    for node in skin.nodes.iter().map(|&node| node as usize) {
        let [xx, yy, zz, xy, yz, xz] = body.stress[node];
        let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        let square = |[x, y, z]: [f64; 3]| x * x + y * y + z * z;
        let values = [
            0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz),
            -(xx + yy + zz) / 3.0,
            body.contact_pressure[node],
            square(body.displacement[node]),
            square(body.velocity[node]),
            body.plastic_strain[node],
            body.contact_slip[node],
        ];
        for ([low, high], value) in all.iter_mut().zip(values.into_iter().chain(body.stress[node])) {
            // NaN leaves the extremes unchanged.
            (*low, *high) = (low.min(value), high.max(value));
        }
    }
    [0, 3, 4].iter().for_each(|&squared: &usize| all[squared] = all[squared].map(f64::sqrt));
    all.to_vec()
}

fn pack_into(bytes: &mut Vec<u8>, body: &BodyFields, skin: &Skin) {
    let dimension = skin.dimension;
    let value = |component: usize, node: usize| match component {
        c if c < dimension => body.displacement[node][c],
        c if c < 2 * dimension => body.velocity[node][c - dimension],
        c => match (skin.stresses().get(c - 2 * dimension), skin.further_at(c)) {
            (Some(&stress), _) => body.stress[node][stress],
            (None, None) => body.plastic_strain[node],
            (None, Some((further, component))) => (further.value)(body, node, component),
        },
    };
    let count = skin.components() * skin.nodes.len();
    bytes.reserve(8 * skin.components() + 2 * count);
    let (mut high, mut low) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for component in 0..skin.components() {
        let values = || skin.nodes.iter().map(|&node| value(component, node as usize));
        let finite = values().filter(|value| value.is_finite());
        let (least, greatest) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let [least, greatest] = if least <= greatest { [least as f32, greatest as f32] } else { [0.0; 2] };
        bytes.extend(least.to_le_bytes());
        bytes.extend(greatest.to_le_bytes());
        let (origin, range) = (f64::from(least), f64::from(greatest) - f64::from(least));
        let mut before = 0u16;
        for value in values() {
            let place = if range > 0.0 { (value - origin) / range * TOP } else { 0.0 };
            // NaN becomes zero.
            let word = place.round().clamp(0.0, TOP) as u16;
            let [l, h] = word.wrapping_sub(before).to_le_bytes();
            low.push(l);
            high.push(h);
            before = word;
        }
    }
    bytes.extend(high);
    bytes.extend(low);
    let touching: Vec<usize> = (0..skin.nodes.len()).filter(|&place| body.contact_pressure[skin.nodes[place] as usize] != 0.0).collect();
    bytes.extend((touching.len() as u32).to_le_bytes());
    let slip = |place: usize| body.contact_slip[skin.nodes[place] as usize] as u32;
    touching.iter().for_each(|&place| bytes.extend((place as u32 | slip(place) << SLIP).to_le_bytes()));
    for &place in &touching {
        let node = skin.nodes[place] as usize;
        let vector = Vectors::ContactPressure.value(body, node);
        let numbers = std::iter::once(body.contact_pressure[node]).chain(vector[..dimension].iter().copied());
        numbers.for_each(|number| bytes.extend((number as f32).to_le_bytes()));
    }
}

/// Decodes a body from the start of the bytes.
fn unpack(rest: &mut &[u8], body: &BodyDefinition, skin: &Skin) -> BodyFields {
    let mut take = |length: usize| {
        let (taken, left) = rest.split_at(length.min(rest.len()));
        *rest = left;
        taken
    };
    let number = |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    let whole = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize;
    let (components, recorded, dimension) = (skin.components(), skin.nodes.len(), skin.dimension);
    let ranges: Vec<[f64; 2]> = take(8 * components).chunks_exact(8).map(|pair| [number(pair), number(&pair[4..])]).collect();
    let (high, low) = (take(components * recorded), take(components * recorded));
    let nodes = body.mesh.points.len();
    let mut fields = BodyFields {
        name: body.name.clone(),
        mesh: body.mesh.clone(),
        displacement: vec![[0.0; 3]; nodes],
        velocity: vec![[0.0; 3]; nodes],
        acceleration: vec![[0.0; 3]; nodes],
        stress: vec![[0.0; 6]; nodes],
        strain: vec![[0.0; 6]; nodes],
        stress_error: vec![0.0; nodes],
        is_rigid: body.rigid.is_some(),
        flows: skin.flows,
        plastic_strain: vec![0.0; nodes],
        back_stress: vec![0.0; nodes],
        energy_density: vec![0.0; nodes],
        contact_pressure: vec![0.0; nodes],
        contact_gap: vec![f64::NAN; nodes],
        contact_force: vec![[0.0; 3]; nodes],
        contact_pressing: vec![[0.0; 3]; nodes],
        contact_active: vec![0.0; nodes],
        contact_state: vec![0.0; nodes],
        contact_slip: vec![0.0; nodes],
    };
    for (component, [least, greatest]) in ranges.into_iter().enumerate() {
        let mut word = 0u16;
        let mut put = |node: usize, value: f64| match component {
            c if c < dimension => fields.displacement[node][c] = value,
            c if c < 2 * dimension => fields.velocity[node][c - dimension] = value,
            c => match (skin.stresses().get(c - 2 * dimension), skin.further_at(c)) {
                (Some(&stress), _) => fields.stress[node][stress] = value,
                (None, None) => fields.plastic_strain[node] = value,
                (None, Some((further, component))) => *(further.component)(&mut fields, node, component) = value,
            },
        };
        for (place, &node) in skin.nodes.iter().enumerate() {
            let at = component * recorded + place;
            word = word.wrapping_add(u16::from_le_bytes([low[at], high[at]]));
            let value = least + (greatest - least) * f64::from(word) / TOP;
            if place == 0 && recorded < nodes {
                (0..nodes).for_each(|node| put(node, value));
            }
            put(node as usize, value);
        }
    }
    let count = whole(take(4));
    let touching: Vec<usize> = take(4 * count).chunks_exact(4).map(whole).collect();
    for word in touching {
        let node = skin.nodes[word & PLACE] as usize;
        fields.contact_slip[node] = (word >> SLIP) as f64;
        fields.contact_pressure[node] = number(take(4));
        for component in 0..dimension {
            // The direction of the pressure; forces are recorded on request only.
            fields.contact_pressing[node][component] = number(take(4));
        }
        fields.contact_active[node] = 1.0;
    }
    fields
}

impl Still {
    /// Returns the recorded bodies; gaps, and further quantities without a request, are not recorded, and inner nodes of bodies in space
    /// have the values of a node of the hull.
    pub fn fields(&self, bodies: &[BodyDefinition], skins: &[Skin]) -> Vec<BodyFields> {
        let mut rest = self.bytes();
        bodies.iter().zip(skins).map(|(body, skin)| unpack(&mut rest, body, skin)).collect()
    }

    /// Returns the rigid obstacles; `shapes` are those of the model.
    pub fn placed(&self, shapes: &[Obstacle]) -> Vec<PlacedObstacle> {
        let of = |&(number, translation, rotation): &StillObstacle| {
            let place = ObstaclePlacement { rotation, translation };
            shapes.get(number).map(|shape| PlacedObstacle { name: String::new(), shape: shape.clone(), place })
        };
        self.obstacles.iter().filter_map(of).collect()
    }

    /// True if the length and contact nodes of the encoded bytes agree with the recorded bodies.
    fn is_of(&self, skins: &[Skin]) -> bool {
        let mut rest = self.bytes();
        let mut pass = |skin: &Skin| {
            let nodes = skin.nodes.len();
            rest = rest.get(skin.components() * (8 + 2 * nodes)..)?;
            let (count, behind) = rest.split_first_chunk()?;
            let count = u32::from_le_bytes(*count) as usize;
            let (places, pressures) = behind.split_at_checked(count.checked_mul(4)?)?;
            rest = pressures.get(count * 4 * (1 + skin.dimension)..)?;
            let place = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize;
            places.chunks_exact(4).all(|bytes| place(bytes) & PLACE < nodes).then_some(())
        };
        skins.iter().all(|skin| pass(skin).is_some()) && rest.is_empty()
    }

    /// Encoded bytes, in the format described at the head of this file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{block, ring};
    use super::*;
    use crate::dynamics::LocalFrame;

    fn skin(body: &BodyFields) -> Skin {
        let fields = ["strain_xy", "energy_density", "acceleration"].map(|name| Field::from_name(name).unwrap());
        Skin::new(&body.mesh, body.flows, &StillOptions { fields: fields.to_vec(), ..StillOptions::default() })
    }

    #[test]
    fn what_is_packed_comes_back_to_the_last_of_65535_parts() {
        let flowing = |fields: BodyFields| BodyFields {
            flows: true,
            strain: fields.stress.iter().map(|stress| stress.map(|component| 1e-4 * component)).collect(),
            energy_density: fields.displacement.iter().map(|u| u[1].powi(2)).collect(),
            acceleration: fields.velocity.iter().map(|v| v.map(|component| 3.0 * component)).collect(),
            plastic_strain: fields.displacement.iter().map(|u| u[0].abs()).collect(),
            ..fields
        };
        let bodies = [ring("ring", [1.0, 1.5], [3, 20]), block([2, 3, 4], [1.0, 2.0, 3.0])];
        for fields in bodies.clone().into_iter().chain(bodies.map(flowing)) {
            let skin = skin(&fields);
            let mut bytes = Vec::new();
            pack_into(&mut bytes, &fields, &skin);
            let material = crate::materials::NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 }.material().unwrap();
            let body =
                BodyDefinition { name: "a".into(), mesh: fields.mesh.clone(), material, formulation: Default::default(), rigid: None };
            let back = unpack(&mut &bytes[..], &body, &skin);
            for &node in &skin.nodes {
                let node = node as usize;
                for i in 0..3 {
                    assert!((back.displacement[node][i] - fields.displacement[node][i]).abs() < 1e-4);
                    assert!((back.velocity[node][i] - fields.velocity[node][i]).abs() < 1e-4);
                }
                for &i in skin.stresses() {
                    assert!((back.stress[node][i] - fields.stress[node][i]).abs() < 0.1, "of thousands");
                }
                for &i in skin.stresses() {
                    assert!((back.strain[node][i] - fields.strain[node][i]).abs() < 1e-5, "of tenths");
                }
                assert!((0..3).all(|i| (back.acceleration[node][i] - fields.acceleration[node][i]).abs() < 1e-3));
                assert!((back.energy_density[node] - fields.energy_density[node]).abs() < 1e-4);
                assert!((back.plastic_strain[node] - fields.plastic_strain[node]).abs() < 1e-4);
                assert!((back.contact_pressure[node] - fields.contact_pressure[node]).abs() < 1e-6);
                assert_eq!(back.contact_slip[node], fields.contact_slip[node]);
            }
        }
    }

    #[test]
    fn extremes_are_those_of_the_fields() {
        for body in [ring("ring", [1.0, 1.5], [3, 20]), block([2, 3, 4], [1.0, 2.0, 3.0])] {
            let skin = skin(&body);
            for (name, [low, high]) in Field::BASIC.iter().zip(extremes_of(&body, &skin)) {
                let field = Field::from_name(name).unwrap();
                let values = || skin.nodes.iter().map(|&node| field.value(&body, node as usize, &LocalFrame::default()));
                let scale = values().fold(1.0, |scale: f64, value| scale.max(value.abs()));
                assert!((values().fold(f64::INFINITY, f64::min) - low).abs() <= 1e-12 * scale, "{name}");
                assert!((values().fold(f64::NEG_INFINITY, f64::max) - high).abs() <= 1e-12 * scale, "{name}");
            }
        }
    }
}
