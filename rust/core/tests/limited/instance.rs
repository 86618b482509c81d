//! Plans at random, and the dense quadratic programs that they solve.

use super::dense::solve;
use popsteer_core::laws::preview_pop::cost_to_go::{CostToGo, ModelState, Travel};
use popsteer_core::laws::preview_pop::limited::{Horizon, Plan, PlanLimits};

/// Plain numbers at random.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        let share = f64::from(u32::try_from(self.0 >> 33).unwrap()) / f64::from(1_u32 << 31);
        low + share * (high - low)
    }

    pub(crate) fn of<T: Copy>(&mut self, all: &[T]) -> T {
        let mut at = self.uniform(0.0, 1.0);
        let share = 1.0 / f64::from(u32::try_from(all.len()).unwrap());
        let chosen = all.iter().find(|_| {
            at -= share;
            at < 0.0
        });
        *chosen.unwrap_or(&all[0])
    }
}

/// Least and greatest.
pub(crate) type Ends = (f64, f64);

/// An instance, and its matrices: the cost is `u' h u + 2 g' u` of the moves `u`.
pub(crate) struct Instance {
    pub(crate) travel: Travel,
    pub(crate) stage: CostToGo,
    pub(crate) move_cost: f64,
    pub(crate) turns: Vec<f64>,
    pub(crate) start: ModelState,
    pub(crate) limits: PlanLimits,
    /// Of the vehicle: what makes an angle of a curvature [m].
    pub(crate) length: f64,
}

impl Instance {
    pub(crate) fn random(random: &mut Random) -> Self {
        let count = random.of(&[1, 2, 3, 5, 10, 20, 20, 20, 20]);
        let length = random.of(&[0.33, 2.7, 2.7, 6.0]);
        let speed = random.uniform(2.0, 25.0) * f64::sqrt(length / 2.7);
        let period = random.of(&[0.05, 0.05, 0.02, 0.1]);
        let step = speed * period;
        let lag = speed * random.of(&[0.0, 0.05, 0.1, 0.15, 0.3, 0.5]);
        let kept = if lag > 0.0 {
            f64::exp(-step / lag)
        } else {
            0.0
        };
        let offset = length * random.of(&[0.0, 0.0, 0.2, -0.2]);
        let rate_cost = length / 12.0 * random.of(&[1.0, 1.0, 0.2, 3.0]) * length / period;
        let bend = random.uniform(-0.15, 0.15) / length * random.of(&[0.0, 0.3, 1.0]);
        let from = random.uniform(0.0, 1.5 * f64::from(count));
        let turns = (0..count)
            .map(|k| {
                if f64::from(k) >= from {
                    bend * step
                } else {
                    0.0
                }
            })
            .collect();
        let steer: f64 = random.uniform(-0.3, 0.3);
        let fastest = random.of(&[0.3, 0.3, 2.0]);
        let rate = f64::powf(10.0, random.uniform(-1.3, fastest));
        let later = rate * period * (1.0 + steer * steer) / length;
        let high = f64::min(
            0.68 / length,
            random.of(&[2.0, 4.0, 8.0, 100.0]) / speed / speed,
        );
        let low = -high * random.of(&[1.0, 1.0, 1.0, 0.7, -0.5]);
        let commanded = match random.uniform(0.0, 1.0) {
            share if share < 0.6 => (steer / length).clamp(low, high),
            share if share < 0.7 => high,
            share if share < 0.8 => low * random.uniform(1.0, 1.5),
            _ => steer / length,
        };
        let first = later * random.of(&[1.0, 1.0, 0.4]);
        Self {
            travel: Travel::new(step, lag, kept, offset),
            stage: CostToGo::stage(length * random.of(&[1.0, 1.0, 0.3, 3.0]), offset),
            move_cost: rate_cost * rate_cost,
            turns,
            start: {
                let slip = random.of(&[0.0, 0.01]);
                ModelState {
                    error: random.uniform(-2.0, 2.0) * random.of(&[0.1, 1.0, 3.0]) * length / 2.7,
                    heading: slip + random.uniform(-0.4, 0.4),
                    driven: commanded + random.uniform(-0.04, 0.04) / length,
                    commanded,
                }
            },
            limits: PlanLimits {
                first: (-first * random.of(&[1.0, 0.99]), first),
                later,
                low,
                high,
            },
            length,
        }
    }

    pub(crate) fn horizon(&self) -> Horizon<'_> {
        Horizon {
            travel: self.travel,
            stage: self.stage,
            move_cost: self.move_cost,
            turns: &self.turns,
        }
    }

    /// The states after each step, as their constant parts or as their answers to one move alone.
    fn states(&self, moved: Option<usize>) -> Vec<[f64; 3]> {
        let nothing = ModelState {
            error: 0.0,
            heading: 0.0,
            driven: 0.0,
            commanded: 0.0,
        };
        let mut state = if moved.is_some() { nothing } else { self.start };
        let mut all = Vec::new();
        for (k, &turn) in self.turns.iter().enumerate() {
            if moved == Some(k) {
                state.commanded += 1.0;
            }
            let turn = if moved.is_some() { 0.0 } else { turn };
            state = self.travel.after(&state, turn);
            all.push([state.error, state.heading, state.driven]);
        }
        all
    }

    fn matrices(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let count = self.turns.len();
        let plain = self.states(None);
        let answers: Vec<_> = (0..count).map(|k| self.states(Some(k))).collect();
        let stage = &self.stage;
        let product = |a: &[[f64; 3]], b: &[[f64; 3]]| -> f64 {
            a.iter()
                .zip(b)
                .map(|(a, b)| {
                    a[0] * b[0]
                        + stage.pp * a[1] * b[1]
                        + stage.pa * (a[1] * b[2] + a[2] * b[1])
                        + stage.aa * a[2] * b[2]
                })
                .sum()
        };
        let mut h: Vec<Vec<f64>> = answers
            .iter()
            .map(|a| answers.iter().map(|b| product(a, b)).collect())
            .collect();
        for (k, row) in h.iter_mut().enumerate() {
            row[k] += self.move_cost;
        }
        let g = answers.iter().map(|a| product(a, &plain)).collect();
        (h, g)
    }

    /// Ends of the moves and of the curvatures, with the stated relaxation: where the start lies
    /// beyond its limits, the moves go back as fast as they may.
    fn ends(&self) -> (Vec<Ends>, Vec<Ends>) {
        let limits = &self.limits;
        let (mut least, mut most) = (self.start.commanded, self.start.commanded);
        let (mut moves, mut curvatures) = (Vec::new(), Vec::new());
        for k in 0..self.turns.len() {
            let of_move = if k == 0 {
                limits.first
            } else {
                (-limits.later, limits.later)
            };
            moves.push(of_move);
            least += of_move.0;
            most += of_move.1;
            curvatures.push((limits.low.min(most), limits.high.max(least)));
        }
        (moves, curvatures)
    }

    /// A length of move to measure by.
    pub(crate) fn scale(&self) -> f64 {
        self.limits.later.min(self.limits.high - self.limits.low)
    }

    /// How far the plan is from the conditions of Karush, Kuhn and Tucker: in the moves, as shares
    /// of the largest, and in the multipliers, as shares of what goes with such a move.
    ///
    /// `s_k`, the sum of the curvatures' multipliers from `k` on, takes up the gradient where the
    /// move is free, and has to lie to the right side of it where the move is at its end; it
    /// changes only where the curvature is at its end, and to the right side.
    pub(crate) fn residual(&self, plan: &Plan) -> f64 {
        let (h, g) = self.matrices();
        let (moves, curvatures) = self.ends();
        let scale = self.scale();
        let unit = scale
            * h.iter()
                .enumerate()
                .map(|(k, row)| row[k])
                .fold(0.0, f64::max);
        let mut before = self.start.commanded;
        let mut u = Vec::new();
        for &curvature in plan.curvatures.iter().take(g.len()) {
            u.push(curvature - before);
            before = curvature;
        }
        let mut worst: f64 = 0.0;
        let (mut low, mut high) = (0.0, 0.0);
        for k in (0..u.len()).rev() {
            let gradient = h[k].iter().zip(&u).map(|(h, u)| h * u).sum::<f64>() + g[k];
            let (moved, curvature) = (u[k], plan.curvatures[k]);
            let at = |value: f64, end: f64| (value - end).abs() < 1e-9 * scale;
            let beyond = |value: f64, (least, most): Ends| (least - value).max(value - most);
            worst = worst.max(beyond(moved, moves[k]) / scale);
            worst = worst.max(beyond(curvature, curvatures[k]) / scale);
            if at(curvature, curvatures[k].1) {
                high = f64::INFINITY;
            }
            if at(curvature, curvatures[k].0) {
                low = f64::NEG_INFINITY;
            }
            let (mut least, mut most) = (-gradient, -gradient);
            if at(moved, moves[k].1) {
                least = f64::NEG_INFINITY;
            }
            if at(moved, moves[k].0) {
                most = f64::INFINITY;
            }
            worst = worst.max((least - high).max(low - most) / unit);
            low = least.max(low).min(high);
            high = most.min(high).max(low);
        }
        worst
    }

    /// The best moves by a long interior-point method on the dense matrices.
    pub(crate) fn by_interior_points(&self) -> Vec<f64> {
        let (h, g) = self.matrices();
        let (moves, curvatures) = self.ends();
        let count = g.len();
        let scale = self.scale();
        let unit = h
            .iter()
            .enumerate()
            .map(|(k, row)| row[k])
            .fold(0.0, f64::max);
        // Rows of what is limited, over the moves; then by how much.
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for k in 0..count {
            let one: Vec<f64> = (0..count).map(|j| if j == k { 1.0 } else { 0.0 }).collect();
            let sum: Vec<f64> = (0..count).map(|j| if j <= k { 1.0 } else { 0.0 }).collect();
            let start = self.start.commanded;
            for (row, low, high) in [
                (one, moves[k].0, moves[k].1),
                (sum, curvatures[k].0 - start, curvatures[k].1 - start),
            ] {
                rows.push((row.clone(), high / scale + 1e-9));
                rows.push((row.iter().map(|r| -r).collect(), -low / scale + 1e-9));
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut u = vec![0.0; count];
        let mut slacks: Vec<f64> = rows.iter().map(|(_, b)| b.max(0.1)).collect();
        let mut multipliers = vec![1.0; rows.len()];
        for _ in 0..120 {
            let mean = dot(&slacks, &multipliers) / f64::from(u32::try_from(rows.len()).unwrap());
            if mean < 1e-16 {
                break;
            }
            let mut matrix: Vec<Vec<f64>> = (0..count)
                .map(|k| {
                    let mut row: Vec<f64> = h[k].iter().map(|h| h / unit).collect();
                    row.push(-(dot(&h[k], &u) / unit + g[k] / unit / scale));
                    row
                })
                .collect();
            for ((row, b), (s, m)) in rows.iter().zip(slacks.iter().zip(&multipliers)) {
                let residual = dot(row, &u) + s - b;
                let push = m + (m * residual - (s * m - 0.15 * mean)) / s;
                for k in 0..count {
                    for j in 0..count {
                        matrix[k][j] += row[k] * row[j] * m / s;
                    }
                    matrix[k][count] -= row[k] * push;
                }
            }
            let step = solve(matrix);
            if step.iter().any(|step| !step.is_finite()) {
                break;
            }
            let mut share: f64 = 1.0;
            let mut changes = Vec::new();
            for ((row, b), (s, m)) in rows.iter().zip(slacks.iter().zip(&multipliers)) {
                let ds = -(dot(row, &u) + s - b) - dot(row, &step);
                let dm = -(s * m - 0.15 * mean + m * ds) / s;
                for (value, change) in [(s, ds), (m, dm)] {
                    if change < 0.0 {
                        share = share.min(-0.99 * value / change);
                    }
                }
                changes.push((ds, dm));
            }
            for (u, step) in u.iter_mut().zip(&step) {
                *u += share * step;
            }
            for (k, (ds, dm)) in changes.into_iter().enumerate() {
                slacks[k] += share * ds;
                multipliers[k] += share * dm;
            }
        }
        u.iter().map(|u| u * scale).collect()
    }
}
