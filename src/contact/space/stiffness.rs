//! Hessian of the weighted gaps of a facet pair in space (`pair.rs`).
//!
//! `Phi` of a polygon depends on twelve plane coordinates, on heights and, by way of the factors `f_u` of the polynomials of the closed
//! gap, on the tilt of the primary triangle; it is linear in heights and factors. Forces are differentiated with respect to the six plane
//! coordinates of the primary triangle. `Phi` is `det A` times as large where an affine map `A` moves the corners of both triangles, and
//! forces are `det A A^-T` times as large. The maps that move one secondary corner `j` and leave the other two, `x + v N_j(x)`, hence give
//! the derivatives with respect to that corner from those with respect to the primary ones:
//!
//! ```text
//! d F = (grad N_j.v) F - grad N_j (v.F) - sum_m N_j(m) v dF/dm         F: forces in the plane
//! d f = (grad N_j.v) f                  - sum_m N_j(m) v df/dm         f: derivatives with respect to heights and factors
//! ```
//!
//! Derivatives of the factors with respect to the primary triangle add the rest, and the chain rule transforms the sum to the node
//! positions.
//!
//! Stretches `s_a` of the facets (`stretch.rs`) multiply the profiles. With `t_a = ln s_a`, the forces `f` for constant stretches and
//! `S_a = dPhi/dt_a` the Hessian has the further terms
//!
//! ```text
//! df/dt_a x dt_a + dt_a x dS_a/dx + S_a d2t_a + d2Phi/dt_a^2 dt_a x dt_a,      d2t_a = (b_ij/s_a^2) 1 - 2 dt_a x dt_a
//! ```

use super::closing::{Closing, Heights, Moments};
use super::facet_tilt::{PerPolynomial, Tilt};
use super::polygon::{OfHeights, Polygon, shares};
use super::quartic::DEGREES;
use super::vectors::{Jet, LANES, Vec3, columns_into, jets};
use super::vertices::{CORNERS, Forces, NODES, OfPrimary, PerTriangle, shape_gradients, sides};
use super::view::{Curves, POINTS, View};
use crate::contact::numbers::{self, Each};
use crate::math::simd::Kernel;

/// Computation of the Hessian of a pair, compiled for the instruction set of the processor.
pub struct Hessian<'a> {
    pub view: &'a View<f64>,
    pub polygons: &'a [Polygon<f64>],
    /// Weights of the secondary nodes.
    pub weights: &'a [f64; CORNERS],
    /// Width of the band in which forces pass from edge to edge.
    pub band: f64,
    /// Factor of the Hessian, written row-major to `out`.
    pub share: f64,
    pub out: &'a mut [f64],
}

/// Number of plane coordinates and heights of all points.
const SEEN: usize = 3 * POINTS;

/// Number of plane coordinates of two triangles.
const PLACES: usize = 12;

/// Number with its derivatives with respect to plane coordinates and heights of a primary triangle.
type OfTilt = numbers::Jet<9>;

/// Derivatives of forces with respect to plane coordinates and heights, and the forces, for constant stretches of both facets.
struct Stiffness {
    rows: [[f64; SEEN]; SEEN],
    forces: [f64; SEEN],
    /// Derivatives with respect to the logarithms of the stretches.
    stretches: Sums<2>,
    /// Second derivatives of `Phi` with respect to each of these.
    second: [f64; 2],
}

/// Derivatives of `Phi` with respect to `N` parameters of the height profiles, summed over polygons.
struct Sums<const N: usize> {
    sums: [f64; N],
    /// Derivatives of the sums with respect to plane coordinates and heights.
    rows: [[f64; SEEN]; N],
    /// Derivatives of the forces that pass between edges with respect to the parameters.
    passed: [[f64; SEEN]; N],
}

/// Places of the parameters among the columns of [`OfHeights`]: factors of the polynomials of the closed gap, stretches.
const TILTS: usize = 6;
const STRETCHES: usize = 12;

/// Number of polynomials of the closed gap, whose factors are functions of the tilt.
const POLYNOMIALS: usize = 6;

/// Profiles of a polygon with derivatives, and its moments.
type MovedClosing<'a> = Option<(Closing<'a, OfPrimary>, Moments<OfPrimary, OfPrimary>)>;

/// Polygon whose forces are differentiated.
struct Moved {
    /// Columns of the plane coordinates of both triangles.
    columns: [usize; PLACES],
    /// Gradients of the shape functions of both triangles.
    gradients: PerTriangle<[f64; 2]>,
    /// Secondary shape functions at the primary corners.
    beyond: [[f64; 3]; 3],
}

impl Moved {
    /// Derivatives of a number with respect to the plane coordinates of both triangles, secondary ones first. `place`: component of a force
    /// in the plane and both components of it.
    #[inline(always)]
    fn derivatives(&self, of: &OfPrimary, place: Option<(usize, [f64; 2])>) -> [f64; PLACES] {
        let mut derivatives = [0.0; PLACES];
        for j in 0..3 {
            let gradient = self.gradients[0][j];
            for a in 0..2 {
                derivatives[6 + 2 * j + a] = of.eps[2 * j + a];
                let mut of_map = gradient[a] * of.re;
                if let Some((i, force)) = place {
                    of_map -= gradient[i] * force[a];
                }
                for m in 0..3 {
                    of_map -= self.beyond[m][j] * of.eps[2 * m + a];
                }
                derivatives[2 * j + a] = of_map;
            }
        }
        derivatives
    }
}

impl Stiffness {
    /// Adds the contribution of a polygon, for a constant tilt of the height profiles; derivatives with respect to the factors of the
    /// polynomials of the closed gap to `tilts`.
    #[inline(always)]
    fn add(
        &mut self,
        hessian: &Hessian,
        polygon: &Polygon<f64>,
        jets: &mut Polygon<OfPrimary>,
        tilts: Option<(&mut Sums<POLYNOMIALS>, Heights)>,
    ) {
        let Hessian { view, band, .. } = hessian;
        let (corners, weights) = (&polygon.corners, view.weights(polygon.corners[0], hessian.weights));
        let (places, heights) = (view.places(corners), view.heights(corners));
        let gradients = [shape_gradients(&places[0], polygon.areas[0]), shape_gradients(&places[1], polygon.areas[1])];
        let (inverse, mut beyond) = (polygon.areas[0].recip(), [[0.0; 3]; 3]);
        for m in 0..3 {
            beyond[m] = shares(&places[0], inverse, &places[1][m]);
        }
        let mut columns = [0; PLACES];
        for lane in 0..PLACES {
            columns[lane] = 3 * corners[lane / 6][lane / 2 % 3] + lane % 2;
        }
        let moved = Moved { columns, gradients, beyond };
        jets.follow(polygon, &sides(&places[0]), &gradients, tilts.is_some());
        let mut forces = polygon.moved_forces(&gradients, &heights, &weights);
        // No closures, which would be compiled without the wide registers.
        let (mut plain, mut closing): (_, MovedClosing) = (None, None);
        if let Some((_, curved)) = &tilts {
            let mut moving = [[[OfPrimary::from(0.0); 2]; 3]; 2];
            for k in 0..3 {
                for i in 0..2 {
                    (moving[0][k][i].re, moving[1][k][i].re) = (gradients[0][k][i], gradients[1][k][i]);
                    for lane in 0..6 {
                        moving[1][k][i].eps[lane] = -gradients[1][lane / 2][i] * gradients[1][k][lane % 2];
                    }
                }
            }
            let (profiles, tilt) = polygon.closing(&places, &heights, *curved);
            let moved = profiles.with_gradients(moving);
            let moments = profiles.moments_with_derivatives(polygon.vertices(), &weights);
            moved.forces_into(&moments, &weights, &mut forces);
            plain = Some((profiles, tilt));
            closing = Some((moved, moments));
        }
        jets.edges_into(&heights, &closing, &weights, *band, &mut forces);
        let Forces { of_p, of_h, .. } = forces;
        for (&point, (p, h)) in corners.as_flattened().iter().zip(of_p.as_flattened().iter().zip(of_h.as_flattened())) {
            let in_plane = [p[0].re, p[1].re];
            for i in 0..2 {
                self.forces[3 * point + i] += in_plane[i];
                let (row, derivatives) = (&mut self.rows[3 * point + i], moved.derivatives(&p[i], Some((i, in_plane))));
                for lane in 0..PLACES {
                    row[columns[lane]] += derivatives[lane];
                }
            }
            self.forces[3 * point + 2] += h.re;
            // Derivatives of forces in the plane with respect to a height are those of its force with respect to plane coordinates.
            let derivatives = moved.derivatives(h, None);
            for lane in 0..PLACES {
                self.rows[3 * point + 2][columns[lane]] += derivatives[lane];
                self.rows[columns[lane]][3 * point + 2] += derivatives[lane];
            }
        }
        let passed = polygon.passed(plain.as_ref().map(|(profiles, _)| profiles), &weights, *band);
        if let Some(passed) = &passed {
            for (&row, derivatives) in columns.iter().zip(passed) {
                for (&point, derivative) in corners.as_flattened().iter().zip(derivatives) {
                    self.rows[row][3 * point + 2] += derivative;
                }
            }
        }
        if let (Some((tilts, _)), Some((_, tilt)), Some((closing, moments))) = (tilts, &plain, &closing) {
            let tilting = closing.tilting(moments);
            tilts.add(&tilting, TILTS, &moved, passed.as_ref());
            let by_stretches = [-closing.secondary(moments), -tilt.closed(&tilting, 1)];
            self.stretches.add(&by_stretches, STRETCHES, &moved, passed.as_ref());
            self.second[0] += by_stretches[0].re;
        }
    }

    /// Adds what follows from the tilt of a primary triangle with the given corners.
    #[inline(always)]
    fn add_tilts(&mut self, view: &View<f64>, triangle: [usize; 3], tilts: &Sums<POLYNOMIALS>) {
        let places = triangle.map(|point| view.p[point]);
        let sides = sides(&places);
        let area = sides[0][0] * sides[1][1] - sides[0][1] * sides[1][0];
        let (mut unknowns, mut heights) = ([[OfTilt::from(0.0); 2]; 3], [OfTilt::from(0.0); 3]);
        for k in 0..3 {
            for i in 0..2 {
                unknowns[k][i] = OfTilt::unknown(places[k][i], Some(3 * k + i));
            }
            heights[k] = OfTilt::unknown(view.h[triangle[k]], Some(3 * k + 2));
        }
        let [a, b, c] = &unknowns;
        let moved_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let forces = Tilt::new(shape_gradients(&unknowns, moved_area), &heights).forces(&tilts.sums.map(OfTilt::from));
        let plain = Tilt::new(shape_gradients(&places, area), &triangle.map(|point| view.h[point]));
        self.second[1] -= plain.closed(&tilts.sums, 2);
        let mut by_stretch = tilts.sums;
        by_stretch.iter_mut().zip(DEGREES).for_each(|(sum, degree)| *sum *= degree);
        let of_stretch = plain.forces(&by_stretch);
        // Derivatives of the factors with respect to plane coordinates and heights.
        let mut units: PerPolynomial<Each<POLYNOMIALS>> = [Each([0.0; POLYNOMIALS]); POLYNOMIALS];
        (0..POLYNOMIALS).for_each(|u| units[u].0[u] = 1.0);
        let of_tilt = plain.forces(&units);
        for k in 0..3 {
            for i in 0..3 {
                let row = 3 * triangle[k] + i;
                self.stretches.rows[1][row] += of_stretch[k][i];
                let (force, Each(by)) = (forces[k][i], of_tilt[k][i]);
                self.forces[row] += force.re;
                for lane in 0..9 {
                    self.rows[row][3 * triangle[lane / 3] + lane % 3] += force.eps[lane];
                }
                let (mut along, mut across) = ([0.0; SEEN], [0.0; SEEN]);
                for u in 0..POLYNOMIALS {
                    for column in 0..SEEN {
                        along[column] += by[u] * tilts.rows[u][column];
                        across[column] += by[u] * (tilts.rows[u][column] + tilts.passed[u][column]);
                    }
                }
                for column in 0..SEEN {
                    self.rows[row][column] += along[column];
                    self.rows[column][row] += across[column];
                }
            }
        }
    }

    /// Writes the first [`LANES`] columns of the Hessian: those of the secondary nodes, with which the projection rotates.
    #[inline(always)]
    fn turned_into(&self, view: &View<f64>, count: usize, share: f64, out: &mut [f64]) {
        let Some(moved) = View::new(&jets(view.arms[..count].as_flattened(), 0), view.counts) else { return };
        let zero = Jet::from(0.0);
        let (mut of_p, mut of_h) = ([[zero; 2]; NODES], [zero; NODES]);
        for k in 0..count {
            for (i, force) in [0, 1, 2].map(|i| 3 * k + i).into_iter().enumerate() {
                let (row, mut jet) = (&self.rows[force], Jet::from(self.forces[force]));
                for node in 0..count {
                    let seen = [&moved.p[node][0], &moved.p[node][1], &moved.h[node]];
                    for (part, seen) in row[3 * node..].iter().zip(seen) {
                        for lane in 0..LANES {
                            jet.eps[lane] += part * seen.eps[lane];
                        }
                    }
                }
                if i < 2 { of_p[k][i] = jet } else { of_h[k] = jet }
            }
        }
        columns_into(&moved.spread(&of_p, &of_h), 0, share, out);
    }

    /// Writes the columns of the other nodes, all of which are primary and leave the projection as it is.
    #[inline(always)]
    fn shifted_into(&self, view: &View<f64>, count: usize, share: f64, out: &mut [f64]) {
        const FIRST: usize = LANES / 3;
        let (axes, zero) = (view.frame.axes, Each([0.0; LANES]));
        let (mut of_p, mut of_h, mut moment) = ([[zero; 2]; NODES], [zero; NODES], [zero; 3]);
        for k in 0..count {
            for i in 0..3 {
                let (row, mut sum) = (&self.rows[3 * k + i], zero);
                // Entries of nodes that do not exist are zero.
                for node in 0..NODES - FIRST {
                    let [x, y, h] = [0, 1, 2].map(|part| row[3 * (FIRST + node) + part]);
                    for a in 0..3 {
                        sum.0[3 * node + a] = x * axes[0][a] + y * axes[1][a] + h * axes[2][a];
                    }
                }
                if i < 2 { of_p[k][i] = sum } else { of_h[k] = sum }
            }
        }
        // A node that moves along `a` has another arm: its force `f` adds the moment `a x f`.
        for node in FIRST..count {
            let [x, y, h] = [0, 1, 2].map(|i| self.forces[3 * node + i]);
            let force = [0, 1, 2].map(|i| x * axes[0][i] + y * axes[1][i] + h * axes[2][i]);
            for a in 0..3 {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                moment[b].0[3 * (node - FIRST) + a] -= force[c];
                moment[c].0[3 * (node - FIRST) + a] += force[b];
            }
        }
        let columns = view.spread_with(&of_p, &of_h, moment);
        for (row, each) in out.chunks_exact_mut(3 * count).zip(columns.as_flattened()) {
            row[LANES..].iter_mut().zip(each.0).for_each(|(entry, slope)| *entry = share * slope);
        }
    }

    /// Adds what follows from the stretches of both facets.
    #[inline(always)]
    fn stretched_into(&self, view: &View<f64>, curves: &Curves, share: f64, out: &mut [f64]) {
        let [own, other] = view.counts;
        let unknowns = 3 * (own + other);
        for (side, (first, count)) in [(0, own), (own, other)].into_iter().enumerate() {
            let stretched = &curves.stretches[side];
            let (sum, rises) = (self.stretches.sums[side], stretched.rises.as_flattened());
            // Derivatives of `S`, and of the forces with respect to the stretch.
            let of_sum = nodal(view, &self.stretches.rows[side]);
            let passed = nodal(view, &self.stretches.passed[side]);
            let (of_sum, passed) = (of_sum.as_flattened(), passed.as_flattened());
            let squares = self.second[side] - 2.0 * sum;
            for k in 0..3 * count {
                for column in 0..unknowns {
                    out[unknowns * (3 * first + k) + column] += share * rises[k] * of_sum[column];
                    out[unknowns * column + 3 * first + k] += share * rises[k] * (of_sum[column] + passed[column]);
                }
                for column in 0..3 * count {
                    out[unknowns * (3 * first + k) + 3 * first + column] += share * squares * rises[k] * rises[column];
                }
            }
            let inverse = (stretched.by * stretched.by).recip();
            let coefficients = curves.of_nodes[side].coefficients(count);
            for a in 0..count {
                for b in 0..count {
                    for i in 0..3 {
                        out[unknowns * (3 * (first + a) + i) + 3 * (first + b) + i] += share * sum * coefficients[a][b] * inverse;
                    }
                }
            }
        }
    }

    /// Distributes the rows and columns of the mean points to the nodes.
    #[inline(always)]
    fn fold(&mut self, view: &View<f64>) {
        for point in [NODES, NODES + 1] {
            let (nodes, share) = view.shares(point);
            for node in nodes {
                for i in 0..3 {
                    let (to, from) = (3 * node + i, 3 * point + i);
                    self.forces[to] += share * self.forces[from];
                    for k in 0..SEEN {
                        self.rows[to][k] += share * self.rows[from][k];
                    }
                    for k in 0..SEEN {
                        self.rows[k][to] += share * self.rows[k][from];
                    }
                }
            }
        }
    }
}

/// Derivatives with respect to the node positions, from those with respect to plane coordinates and heights of all points.
#[inline(always)]
fn nodal(view: &View<f64>, seen: &[f64; SEEN]) -> [Vec3<f64>; NODES] {
    let (mut of_p, mut of_h) = ([[0.0; 2]; NODES], [0.0; NODES]);
    for k in 0..NODES {
        (of_p[k], of_h[k]) = ([seen[3 * k], seen[3 * k + 1]], seen[3 * k + 2]);
    }
    for point in [NODES, NODES + 1] {
        let (nodes, share) = view.shares(point);
        for node in nodes {
            for i in 0..2 {
                of_p[node][i] += share * seen[3 * point + i];
            }
            of_h[node] += share * seen[3 * point + 2];
        }
    }
    view.spread(&of_p, &of_h)
}

impl<const N: usize> Sums<N> {
    const NONE: Self = Sums { sums: [0.0; N], rows: [[0.0; SEEN]; N], passed: [[0.0; SEEN]; N] };

    /// Adds the derivatives of `Phi` of a polygon with respect to the parameters, which are at `place` of [`OfHeights`].
    #[inline(always)]
    fn add(&mut self, sums: &[OfPrimary; N], place: usize, moved: &Moved, passed: Option<&[OfHeights; PLACES]>) {
        for (k, sum) in sums.iter().enumerate() {
            self.sums[k] += sum.re;
            let derivatives = moved.derivatives(sum, None);
            for lane in 0..PLACES {
                self.rows[k][moved.columns[lane]] += derivatives[lane];
            }
            for (&row, derivatives) in moved.columns.iter().zip(passed.into_iter().flatten()) {
                self.passed[k][row] += derivatives[place + k];
            }
        }
    }
}

impl Kernel for Hessian<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let view = self.view;
        let mut stiffness = Stiffness { rows: [[0.0; SEEN]; SEEN], forces: [0.0; SEEN], stretches: Sums::NONE, second: [0.0; 2] };
        let mut moving = Polygon::empty();
        if view.curves.is_some() {
            // Primary triangles are identified by their second corner.
            for start in view.counts[0]..view.counts[0] + view.counts[1] {
                let mut tilts = Sums::NONE;
                let mut triangle = None;
                for polygon in self.polygons.iter().filter(|polygon| polygon.corners[1][1] == start) {
                    let Some(curved) = view.curved(&polygon.corners) else { continue };
                    stiffness.add(&self, polygon, &mut moving, Some((&mut tilts, curved)));
                    triangle = Some(polygon.corners[1]);
                }
                // No closure, which would be compiled without the wide registers.
                if let Some(triangle) = triangle {
                    stiffness.add_tilts(view, triangle, &tilts);
                }
            }
        } else {
            for polygon in self.polygons {
                stiffness.add(&self, polygon, &mut moving, None);
            }
        }
        stiffness.fold(view);
        let count = view.counts[0] + view.counts[1];
        stiffness.turned_into(view, count, self.share, self.out);
        stiffness.shifted_into(view, count, self.share, self.out);
        if let Some(curves) = &view.curves {
            stiffness.stretched_into(view, curves, self.share, self.out);
        }
    }
}
