//! Test of the penetration of convex bodies that the constraints of vertices and edges (`corners.rs`) detect, for random pairs of features.
//!
//! Oracle: the least translation that separates two convex polyhedra, over the normals of all faces and cross products of all edges. It is
//! independent of facets, constraints and candidates.

use nalgebra::{Rotation3, Vector3};

use conserva::contact::{CornersInSpace, MotionBound, PredictedMotion, ProxySurfacesInSpace};

type Vector = Vector3<f64>;

/// Pseudorandom numbers between -1 and 1 (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + 0.5 * (most - least) * (self.next() + 1.0)
    }
}

/// Convex body with six faces of four corners, each divided into several facets.
struct Solid {
    corners: Vec<Vector>,
    points: Vec<Vector>,
    facets: Vec<[u32; 4]>,
}

/// Corners of the faces of a cube, numbered by the bits of their coordinates, counter-clockwise as seen from outside.
const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

impl Solid {
    /// Cube between -0.5 and 0.5, deformed.
    fn new(cells: usize, deform: impl Fn(Vector) -> Vector) -> Self {
        let corner = |k: usize| Vector::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64).add_scalar(-0.5);
        let (mut points, mut facets): (Vec<Vector>, Vec<[u32; 4]>) = (Vec::new(), Vec::new());
        for face in FACES {
            let [a, b, c, d] = face.map(corner);
            let at = |i: usize, j: usize| {
                let (x, y) = (i as f64 / cells as f64, j as f64 / cells as f64);
                (a * (1.0 - x) + b * x) * (1.0 - y) + (d * (1.0 - x) + c * x) * y
            };
            let mut number = |x: Vector| {
                let known = points.iter().position(|point| (point - x).norm() < 1e-9);
                known.unwrap_or_else(|| {
                    points.push(x);
                    points.len() - 1
                }) as u32
            };
            for (i, j) in (0..cells * cells).map(|k| (k % cells, k / cells)) {
                facets.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)].map(&mut number));
            }
        }
        Solid { corners: (0..8).map(|k| deform(corner(k))).collect(), points: points.into_iter().map(deform).collect(), facets }
    }

    fn moved(&self, rotation: &Rotation3<f64>, shift: Vector) -> Self {
        let place = |x: &Vector| rotation * x + shift;
        Solid {
            corners: self.corners.iter().map(place).collect(),
            points: self.points.iter().map(place).collect(),
            facets: self.facets.clone(),
        }
    }

    fn normals(&self) -> impl Iterator<Item = Vector> {
        FACES.iter().map(|face| {
            let [a, b, c, d] = face.map(|k| self.corners[k]);
            (c - a).cross(&(d - b)).normalize()
        })
    }

    fn edges(&self) -> impl Iterator<Item = Vector> {
        FACES.iter().flat_map(|face| (0..4).map(|k| (self.corners[face[(k + 1) % 4]] - self.corners[face[k]]).normalize()))
    }

    fn extent(&self, axis: &Vector) -> [f64; 2] {
        self.corners.iter().map(|x| x.dot(axis)).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    }
}

/// Length of the least translation that separates two bodies; if they are apart, the negative distance along the best axis.
fn depth(a: &Solid, b: &Solid) -> f64 {
    let products: Vec<Vector> = a.edges().flat_map(|one| b.edges().map(move |other| one.cross(&other))).collect();
    let axes = a.normals().chain(b.normals()).chain(products.into_iter().filter_map(|axis| axis.try_normalize(1e-9)));
    axes.map(|axis| {
        let ([a_0, a_1], [b_0, b_1]) = (a.extent(&axis), b.extent(&axis));
        (a_1 - b_0).min(b_1 - a_0)
    })
    .fold(f64::INFINITY, f64::min)
}

/// Penetration detected by the constraints, and facet size.
fn seen(upper: &Solid, lower: &Solid) -> [f64; 2] {
    let q: Vec<f64> = upper.points.iter().chain(&lower.points).flat_map(|x| [x.x, x.y, x.z]).collect();
    let first = upper.points.len() as u32;
    let own: Vec<Vec<u32>> = upper.facets.iter().map(|facet| facet.to_vec()).collect();
    let others: Vec<Vec<u32>> = lower.facets.iter().map(|facet| facet.map(|node| node + first).to_vec()).collect();
    let sides = ProxySurfacesInSpace::new([&own, &others], &q);
    let size = sides.secondary.shortest_facet(&q).min(sides.primary.shortest_facet(&q));
    let mut kernel = CornersInSpace::kernel(&sides).expect("both have edges");
    kernel.update_candidates(&PredictedMotion { q: &q, motion_bound: MotionBound::UpTo(0.0), reach: 1.0, depth: 0.0 });
    kernel.begin_step(&q);
    let gaps = kernel.start_gap().into_iter().zip(kernel.weights().to_vec()).map(|(gap, weight)| gap / weight);
    [gaps.fold(0.0, |deepest: f64, gap| deepest.max(-gap)), size]
}

/// Random rotation that places a body on a face (0), an edge (1) or a corner (2).
fn standing(random: &mut Random, on: usize) -> Rotation3<f64> {
    let noise = Vector::from_fn(|_, _| random.next());
    let tilt = Rotation3::new(noise * if random.next() > 0.5 { 0.2 } else { 0.0 });
    let on_edge = Rotation3::new(Vector::x() * std::f64::consts::FRAC_PI_4);
    let rolled = match on {
        0 => Rotation3::identity(),
        1 => on_edge,
        _ => Rotation3::new(Vector::y() * (1.0f64 / 2f64.sqrt()).atan()) * on_edge,
    };
    // Rotation about the vertical by a random angle, including parallel edges.
    let spin = match (random.between(0.0, 4.0)) as usize {
        0 => 0.0,
        1 => 10f64.powf(random.between(-2.5, -1.0)),
        _ => random.between(0.0, std::f64::consts::TAU),
    };
    Rotation3::new(Vector::z() * spin) * tilt * rolled
}

fn shape(random: &mut Random) -> Solid {
    let cells = [2, 3, 4][random.between(0.0, 2.999) as usize];
    match random.between(0.0, 3.999) as usize {
        0 => Solid::new(cells, |x| x),
        // Plate: cube compressed in the third direction.
        1 => Solid::new(cells, |x| Vector::new(x.x, x.y, 0.4 * x.z)),
        // Tapered prism.
        2 => Solid::new(cells, |x| Vector::new(x.x * (0.6 - 0.7 * x.z), x.y, x.z)),
        // Sheared box.
        _ => Solid::new(cells, |x| Vector::new(0.5 * x.x + 0.4 * x.z, 0.5 * x.y, x.z)),
    }
}

/// Errors in one configuration, in facet sizes: undetected penetration, and detected penetration beyond the true one.
fn study(random: &mut Random, kind: usize, wanted: f64) -> Option<[f64; 2]> {
    let (a, b) = (shape(random), shape(random));
    let lower = b.moved(&standing(random, kind % 3), Vector::zeros());
    let rotation = standing(random, kind / 3);
    let aside = if random.next() > 0.0 { 0.45 } else { 0.1 };
    let (x, y) = (aside * random.next(), aside * random.next());
    let at = |z: f64| a.moved(&rotation, Vector::new(x, y, z));
    let size = seen(&at(5.0), &lower)[1];
    let (mut inside, mut outside) = (0.3, 3.0);
    if depth(&at(inside), &lower) < wanted * size {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (inside + outside);
        if depth(&at(middle), &lower) > wanted * size { inside = middle } else { outside = middle }
    }
    let upper = at(inside);
    let (there, [said, _]) = (depth(&upper, &lower).max(0.0), seen(&upper, &lower));
    Some([(there - said) / size, (said - there) / size])
}

/// Constraints of vertices and edges miss at most 0.03 facet sizes of penetration; excessive or false penetration is rare.
#[test]
fn rows_of_vertices_and_edges_see_all_of_a_depth() {
    let (mut random, mut unseen, mut count, mut over, mut alarms, mut apart) = (Random(2007), 0.0f64, 0, 0, 0, 0);
    for k in 0..630 {
        let (kind, wanted) = (k % 9, [0.02, 0.05, 0.1, 0.2, 0.5, -0.05, -0.2][k / 9 % 7]);
        let Some([less, more]) = study(&mut random, kind, wanted) else { continue };
        if wanted > 0.0 {
            count += 1;
            over += usize::from(more > 0.25 * wanted);
            unseen = unseen.max(less);
        } else {
            apart += 1;
            alarms += usize::from(more > 1e-9);
        }
    }
    assert!(count > 420 && apart > 160, "{count} {apart}");
    assert!(unseen <= 0.03, "{unseen}");
    assert!(100 * over < count && alarms == 0, "{over} of {count}, {alarms} of {apart}");
}
