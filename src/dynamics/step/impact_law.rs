//! Impact of rigid bodies: Poisson's restitution with Coulomb friction along the whole impact (Routh, *Dynamics of a System of Rigid
//! Bodies*, 1905; Glocker and Pfeiffer, *Multiple impacts with friction in rigid multibody systems*, Nonlinear Dynamics 7, 1995).
//!
//! Positions do not change. The impulses `p` of all constraints in contact change their rates, `u = u_0 + W p`, `W = G M^-1 G^T`, in two
//! phases,
//!
//! ```text
//! compression    u_n >= (1 - s) min(u_n0, 0),  dp_n >= 0, complementary,            s from 0 to 1
//! restitution    u_n >= 0,  dp_n >= e p_c ds,  complementary,  p_c of compression,    s from 0 to 1
//! friction       |dp_t| <= mu dp_n, against the slip u_t, in every part of a phase
//! ```
//!
//! so that a slip may stop, stick and reverse within an impact. Parts are halved, down to the shortest, until no slip changes its direction
//! within a part, except at its end: in the plane, slip is then exact. A part is solved contact by contact (block Gauss-Seidel), which
//! also finds a solution for linearly dependent contacts.

use crate::math::tolerances;

/// Length of a part, relative to the phase, that is not halved where a slip stops or turns within it: impulses then have a relative error
/// of this size.
const SHORT: f64 = 1.0 / 16384.0;
/// Shortest part, relative to the phase, that ends at the predicted stop of a slip.
const SHORTEST: f64 = tolerances::IMPACT_SLIP;
/// Number of parts of a phase after which no part is shorter than [`SHORT`].
const MANY: usize = 1000;

/// Angle by which the direction of a slip may change within a part of a phase.
const TURN: f64 = 0.01;

/// Largest number of sweeps per part: what is always allowed, and the upper bound.
const SWEEPS: [usize; 2] = [100, 20_000];
/// Largest number of products in all sweeps of an impact.
const PRODUCTS: usize = 100_000_000;

/// Ratio of the change in a sweep to that of `SWEEPS[0]` sweeps before, above which the iteration has stalled.
const STALLED: f64 = 0.99;

/// Largest number of iterations for the direction of a slip in space.
const DIRECTIONS: usize = 50;

/// Normal constraint with its tangential constraints.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImpactContact {
    /// Index of the normal constraint; its tangential constraints follow.
    pub first: usize,
    /// Number of tangential constraints: 0, 1 or 2.
    pub tangents: usize,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Tributary weight of the contact: proportional first impulses correspond to a uniform pressure.
    pub weight: f64,
}

/// Constraints of an impact.
pub struct ImpactLaw {
    /// Contacts, each with a normal constraint and its tangential constraints.
    pub contacts: Vec<ImpactContact>,
    /// Change of the rate of a constraint by a unit impulse of another one, row by row, symmetric.
    pub response: Vec<f64>,
}

/// Rates and impulses of the constraints in an impact.
#[derive(Clone, Debug, Default)]
pub struct ImpactSolution {
    /// Rates of the constraints.
    pub rates: Vec<f64>,
    /// Impulses of the constraints.
    pub impulses: Vec<f64>,
    /// Work of the normal impulses `[energy]`: negative in compression.
    pub normal_work: f64,
    /// Work of friction of each contact `[energy]`, never positive.
    pub friction: Vec<f64>,
    /// Contacts in the order of their solution, the fastest approach first: impulses of linearly dependent contacts depend on it, and must
    /// not depend on the numbers of nodes.
    order: Vec<usize>,
}

/// Condition of a normal constraint in a part of an impact.
struct Part {
    /// Lower bounds of the normal rates at the end of the part.
    targets: Vec<f64>,
    /// Lower bounds of the normal impulses of the part.
    least: Vec<f64>,
}

impl ImpactContact {
    /// Tangential constraints.
    pub fn slips(&self) -> std::ops::Range<usize> {
        self.first + 1..self.first + 1 + self.tangents
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

impl ImpactLaw {
    fn rows(&self) -> usize {
        self.contacts.iter().map(|contact| 1 + contact.tangents).sum()
    }

    /// State of an impact before its compression, with the given rates.
    pub fn before(&self, rates: Vec<f64>) -> ImpactSolution {
        let mut order: Vec<usize> = (0..self.contacts.len()).collect();
        order.sort_by(|&a, &b| rates[self.contacts[a].first].total_cmp(&rates[self.contacts[b].first]));
        ImpactSolution { impulses: vec![0.0; rates.len()], friction: vec![0.0; self.contacts.len()], normal_work: 0.0, rates, order }
    }

    /// Adds the change `W p` by the impulses `p` to the rates.
    pub fn answer(&self, impulses: &[f64], rates: &mut [f64]) {
        let count = self.rows();
        for (row, rate) in rates.iter_mut().enumerate() {
            *rate += self.response[row * count..(row + 1) * count].iter().zip(impulses).map(|(w, p)| w * p).sum::<f64>();
        }
    }

    /// Compression phase: ends the approach of the participating contacts.
    pub fn compress(&self, course: &mut ImpactSolution, takes_part: impl Fn(usize) -> bool) {
        let approach: Vec<f64> = self.contacts.iter().map(|contact| course.rates[contact.first].min(0.0)).collect();
        let targets =
            |s: f64| (0..approach.len()).map(|c| if takes_part(c) { (1.0 - s) * approach[c] } else { f64::NEG_INFINITY }).collect();
        self.follow(course, |end, _| Part { targets: targets(end), least: vec![0.0; approach.len()] });
    }

    /// Applies the restitution phase: returns compression impulses, scaled by `share` times each contact's coefficient.
    pub fn restore(&self, course: &mut ImpactSolution, share: f64) {
        let given: Vec<f64> =
            self.contacts.iter().map(|contact| share * contact.restitution * course.impulses[contact.first].max(0.0)).collect();
        if given.iter().any(|given| *given > 0.0) {
            self.follow(course, |_, length| Part { targets: vec![0.0; given.len()], least: given.iter().map(|p| length * p).collect() });
        }
    }

    /// Integrates a phase part by part; `part(end, length)` returns the conditions of a part.
    fn follow(&self, course: &mut ImpactSolution, part: impl Fn(f64, f64) -> Part) {
        let (mut done, mut length, mut parts) = (0.0, 1.0, 0);
        let mut guess = vec![0.0; course.rates.len()];
        while done < 1.0 {
            let shortest = if parts < MANY { SHORTEST } else { SHORT };
            let end = if done + length > 1.0 - 0.5 * shortest { 1.0 } else { done + length };
            let conditions = part(end, end - done);
            let mut rates = course.rates.clone();
            let impulses = self.solve(&conditions, &mut rates, &guess, &course.order);
            if length > SHORT && self.turns(&course.rates, &rates, &impulses) {
                length *= 0.5;
                guess.iter_mut().zip(&impulses).for_each(|(guess, p)| *guess = 0.5 * p);
                continue;
            }
            for (contact, friction) in self.contacts.iter().zip(&mut course.friction) {
                let work = |row: usize| 0.5 * impulses[row] * (course.rates[row] + rates[row]);
                let straight = (contact.first + 1..=contact.first + contact.tangents).map(work).sum::<f64>();
                let slipped = self.work_to_a_stop(contact, &course.rates, &rates, &impulses).unwrap_or(straight);
                course.normal_work += work(contact.first) + straight - slipped;
                *friction += slipped;
            }
            course.impulses.iter_mut().zip(&impulses).for_each(|(sum, p)| *sum += p);
            // The next part ends where a slip would stop if its speed continued to decrease as in this part.
            let to_stop = (end - done) * self.parts_to_a_stop(&course.rates, &rates);
            let next = if length < 0.5 { 2.0 * length } else { length }.min(to_stop).max(shortest);
            guess = impulses.iter().map(|p| next / (end - done) * p).collect();
            (course.rates, done, length, parts) = (rates, end, next, parts + 1);
        }
    }

    /// Work of friction in a part in which a slip stops and then sticks; `None` if it does not stop. Jamming is one part.
    fn work_to_a_stop(&self, contact: &ImpactContact, before: &[f64], after: &[f64], impulses: &[f64]) -> Option<f64> {
        let rows = contact.first + 1..contact.first + 1 + contact.tangents;
        let length = |rates: &[f64]| rates[rows.clone()].iter().map(|rate| rate * rate).sum::<f64>().sqrt();
        let slip = length(before);
        if slip == 0.0 || length(after) > tolerances::SLIP_ROUND_OFF * slip {
            return None;
        }
        let (count, mu) = (self.rows(), contact.friction);
        // Loss of slip speed per normal impulse.
        let by = |row: usize, other: usize| before[row] / slip * self.response[row * count + other];
        let along: f64 = rows.clone().map(|row| rows.clone().map(|other| by(row, other) * before[other] / slip).sum::<f64>()).sum();
        let loss = mu * along - rows.clone().map(|row| by(row, contact.first)).sum::<f64>();
        (loss * impulses[contact.first] >= slip).then(|| -0.5 * mu * slip * slip / loss)
    }

    /// True if a slip reverses in a part with these impulses, or stops before its end: friction up to the end has the largest magnitude.
    fn turns(&self, before: &[f64], after: &[f64], impulses: &[f64]) -> bool {
        let size = before.iter().fold(0.0f64, |size, rate| size.max(rate.abs()));
        let is_still = |length: f64| length <= tolerances::IMPACT_SLIP * size;
        self.slipping().any(|contact| {
            let rows = contact.slips();
            let (old, new, friction) = (norm(&before[rows.clone()]), norm(&after[rows.clone()]), norm(&impulses[rows.clone()]));
            let along: f64 = rows.map(|row| before[row] * after[row]).sum();
            let slips_to_end = || friction >= (1.0 - tolerances::IMPACT_SLIP) * contact.friction * impulses[contact.first];
            !is_still(old) && (if is_still(new) { !slips_to_end() } else { along < TURN.cos() * old * new })
        })
    }

    /// Number of further parts, each with the same decrease of the slip speeds, until the first slip stops.
    fn parts_to_a_stop(&self, before: &[f64], after: &[f64]) -> f64 {
        let size = after.iter().fold(0.0f64, |size, rate| size.max(rate.abs()));
        let left = self.slipping().map(|contact| {
            let [old, new] = [before, after].map(|rates| norm(&rates[contact.slips()]));
            if new > tolerances::IMPACT_SLIP * size && new < old { new / (old - new) } else { f64::INFINITY }
        });
        left.fold(f64::INFINITY, f64::min)
    }

    /// Contacts with friction.
    fn slipping(&self) -> impl Iterator<Item = &ImpactContact> {
        self.contacts.iter().filter(|contact| contact.tangents > 0 && contact.friction > 0.0)
    }

    /// Impulses of a part of an impact; `rates` are updated from its start to its end.
    fn solve(&self, part: &Part, rates: &mut [f64], guess: &[f64], order: &[usize]) -> Vec<f64> {
        let count = self.rows();
        let mut impulses = self.first_guess(part, rates, guess);
        let before = rates.to_vec();
        let round_off = f64::EPSILON * before.iter().fold(0.0f64, |largest, rate| largest.max(rate.abs()));
        self.answer(&impulses, rates);
        let mut earlier = f64::INFINITY;
        for sweep in 0..(PRODUCTS / (count * count).max(1)).clamp(SWEEPS[0], SWEEPS[1]) {
            let (mut largest, mut size) = (0.0f64, 0.0f64);
            for (c, contact) in order.iter().map(|&c| (c, &self.contacts[c])) {
                let rows = 1 + contact.tangents;
                let own = |i: usize, j: usize| self.response[(contact.first + i) * count + contact.first + j];
                if own(0, 0) <= 0.0 || part.targets[c] == f64::NEG_INFINITY {
                    continue;
                }
                let mut block =
                    Block { rows, friction: contact.friction, target: part.targets[c], least: part.least[c], ..Block::default() };
                for i in 0..rows {
                    (0..rows).for_each(|j| block.response[i][j] = own(i, j));
                    let own_rate: f64 = (0..rows).map(|j| own(i, j) * impulses[contact.first + j]).sum();
                    block.free[i] = rates[contact.first + i] - own_rate;
                }
                let found = block.solve();
                for (i, p) in found.iter().take(rows).enumerate() {
                    let change = p - impulses[contact.first + i];
                    if change == 0.0 {
                        continue;
                    }
                    impulses[contact.first + i] = *p;
                    largest = largest.max(change.abs() * own(i, i));
                    size = size.max(p.abs() * own(i, i));
                    let column = &self.response[(contact.first + i) * count..(contact.first + i + 1) * count];
                    rates.iter_mut().zip(column).for_each(|(rate, w)| *rate += w * change);
                }
            }
            if largest <= round_off.max(10.0 * tolerances::IMPULSE * size) {
                break;
            }
            if sweep % SWEEPS[0] == 0 {
                // Linearly dependent contacts with round-off differences would be iterated without end.
                if largest > STALLED * earlier {
                    break;
                }
                earlier = largest;
            }
        }
        rates.copy_from_slice(&before);
        self.answer(&impulses, rates);
        impulses
    }

    /// Initial impulses of a part: `guess`, at least the required ones; if all are zero, the equal pressures that best end the approach.
    fn first_guess(&self, part: &Part, rates: &[f64], guess: &[f64]) -> Vec<f64> {
        let mut impulses = guess.to_vec();
        for (contact, least) in self.contacts.iter().zip(&part.least) {
            impulses[contact.first] = impulses[contact.first].max(*least);
        }
        if impulses.iter().any(|p| *p != 0.0) {
            return impulses;
        }
        let responds = |row: usize| self.response[row * self.rows() + row] > 0.0;
        let approaches = |c: usize| part.targets[c] > rates[self.contacts[c].first] && responds(self.contacts[c].first);
        let pressed: Vec<usize> = (0..self.contacts.len()).filter(|&c| approaches(c)).collect();
        pressed.iter().for_each(|&c| impulses[self.contacts[c].first] = self.contacts[c].weight);
        let mut answer = vec![0.0; rates.len()];
        self.answer(&impulses, &mut answer);
        let (mut up, mut down) = (0.0, 0.0);
        for &c in &pressed {
            let row = self.contacts[c].first;
            up += answer[row] * (part.targets[c] - rates[row]);
            down += answer[row] * answer[row];
        }
        let share = if down > 0.0 { (up / down).max(0.0) } else { 0.0 };
        impulses.iter_mut().for_each(|p| *p *= share);
        impulses
    }
}

/// One contact with fixed impulses of all others: `u = free + response p`.
#[derive(Default)]
struct Block {
    rows: usize,
    response: [[f64; 3]; 3],
    free: [f64; 3],
    friction: f64,
    target: f64,
    least: f64,
}

impl Block {
    fn rate(&self, i: usize, p: &[f64; 3]) -> f64 {
        self.free[i] + (0..self.rows).map(|j| self.response[i][j] * p[j]).sum::<f64>()
    }

    /// Normal impulse for tangential impulses `along` relative to it.
    fn normal_impulse(&self, along: [f64; 2]) -> f64 {
        let slope = self.response[0][0] + (1..self.rows).map(|j| self.response[0][j] * along[j - 1]).sum::<f64>();
        if slope > 0.0 { ((self.target - self.free[0]) / slope).max(self.least) } else { self.least }
    }

    fn solve(&self) -> [f64; 3] {
        if self.rows == 1 || self.friction == 0.0 {
            return [self.normal_impulse([0.0; 2]), 0.0, 0.0];
        }
        let stuck = self.stuck();
        let most = self.friction * stuck[0];
        let along = stuck[1].hypot(stuck[2]);
        if along <= most * (1.0 + tolerances::IMPACT_SLIP) {
            return stuck;
        }
        let slid = self.slid(&stuck);
        if self.rate(0, &slid) >= self.target - tolerances::IMPACT_SLIP * (self.free[0].abs() + self.target.abs()) {
            return slid;
        }
        // Slip presses the bodies together faster than it separates them, for any impulse (jamming): slip ends at once.
        let share = most / along;
        [stuck[0], share * stuck[1], share * stuck[2]]
    }

    /// Impulses at which the contact sticks: no tangential rate.
    fn stuck(&self) -> [f64; 3] {
        let t = &self.response;
        // Tangential impulses of stick are `a + b p_n`.
        let solve = |right: [f64; 2]| -> [f64; 2] {
            if self.rows == 2 {
                return [if t[1][1] > 0.0 { right[0] / t[1][1] } else { 0.0 }, 0.0];
            }
            let determinant = t[1][1] * t[2][2] - t[1][2] * t[2][1];
            if determinant <= tolerances::IMPACT_SLIP * (t[1][1] + t[2][2]).powi(2) {
                let one = |i: usize| if t[i + 1][i + 1] > 0.0 { right[i] / (t[1][1] + t[2][2]) } else { 0.0 };
                return [one(0), one(1)];
            }
            [(right[0] * t[2][2] - right[1] * t[1][2]) / determinant, (right[1] * t[1][1] - right[0] * t[2][1]) / determinant]
        };
        let (a, b) = (solve([-self.free[1], -self.free[2]]), solve([-t[1][0], -t[2][0]]));
        let of = |along: [f64; 2]| t[0][1] * along[0] + t[0][2] * along[1];
        let (slope, free) = (t[0][0] + of(b), self.free[0] + of(a));
        // On a rail normal and tangential rates are proportional: the slope is round-off.
        let is_free = slope > tolerances::IMPACT_SLIP * t[0][0];
        let normal = if is_free { ((self.target - free) / slope).max(self.least) } else { self.least };
        [normal, a[0] + b[0] * normal, a[1] + b[1] * normal]
    }

    /// Impulses of a contact that slips, from those that would make it stick.
    fn slid(&self, stuck: &[f64; 3]) -> [f64; 3] {
        if self.rows == 2 {
            let against = |sense: f64| {
                let normal = self.normal_impulse([sense * self.friction, 0.0]);
                [normal, sense * self.friction * normal, 0.0]
            };
            let (first, second) = (against(stuck[1].signum()), against(-stuck[1].signum()));
            // A slip that ends with the part has no direction at its end.
            let round_off = |p: &[f64; 3]| self.free[1].abs() + (0..2).map(|j| (self.response[1][j] * p[j]).abs()).sum::<f64>();
            let loses = |p: &[f64; 3]| p[1] * self.rate(1, p) <= tolerances::IMPACT_SLIP * p[1].abs() * round_off(p);
            return if loses(&first) || !loses(&second) { first } else { second };
        }
        let unit = |x: [f64; 2]| {
            let length = x[0].hypot(x[1]);
            if length > 0.0 { x.map(|x| x / length) } else { [0.0; 2] }
        };
        // Friction has the direction of the impulses that would end the slip.
        let mut along = unit([stuck[1], stuck[2]]);
        let mut p = [0.0; 3];
        for _ in 0..DIRECTIONS {
            p[0] = self.normal_impulse(along.map(|x| self.friction * x));
            (1..3).for_each(|i| p[i] = self.friction * p[0] * along[i - 1]);
            // Fixed-point iteration for the slip direction: the isotropic part of the response does not change the direction and is
            // removed.
            let isotropic = 0.5 * (self.response[1][1] + self.response[2][2]);
            let slip = [1, 2].map(|i| self.rate(i, &p) - isotropic * p[i]);
            let next = unit(slip.map(|x| -x));
            let turned = (next[0] - along[0]).hypot(next[1] - along[1]);
            if turned <= tolerances::IMPACT_SLIP {
                break;
            }
            along = next;
        }
        p
    }
}
