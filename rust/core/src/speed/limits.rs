//! What limits the speed, and how far a limit lets the speed change.

use core::slice;

use crate::error::{ConfigError, config_in_range};
use crate::math::{larger, powf, smaller, sqrt};
use crate::speed::defaults::LEAST_ON_SLOPES;
use crate::vehicle::Vehicle;

/// The most steps towards a root; a double has no more digits after a dozen.
const ROOT_STEPS: usize = 60;
/// How near to a root is near enough, as a share of the square of the speed.
const ROOT_TOLERANCE: f64 = 1e-13;
/// Halvings of a speed: to 1e-12 of it.
const BISECTIONS: usize = 40;

/// A limit of the acceleration over the speed: linear between points, constant beyond them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverSpeed<'a> {
    /// Speeds [m/s], increasing.
    pub speeds: &'a [f64],
    /// The limit at each [m/s^2].
    pub values: &'a [f64],
}

impl<'a> OverSpeed<'a> {
    /// The same limit at every speed.
    pub fn constant(value: &'a f64) -> Self {
        Self {
            speeds: &[0.0],
            values: slice::from_ref(value),
        }
    }

    /// The limit at the square `squared` of a speed [m^2/s^2].
    #[inline]
    fn at(&self, squared: f64) -> f64 {
        let last = self.values.last().copied().unwrap_or(0.0);
        if self.values.len() < 2 {
            return last;
        }
        let speed = sqrt(squared);
        let next = self.speeds.partition_point(|&known| known <= speed);
        let point = |index: usize| (self.speeds.get(index), self.values.get(index));
        match (next, point(next.saturating_sub(1)), point(next)) {
            (0, (_, Some(&first)), _) => first,
            (_, (Some(&low), Some(&before)), (Some(&high), Some(&after))) => {
                before + (speed - low) / (high - low) * (after - before)
            }
            _ => last,
        }
    }

    /// The largest value [m/s^2].
    pub(super) fn most(&self) -> f64 {
        self.values.iter().copied().fold(0.0, larger)
    }

    fn checked(&self, field: &'static str) -> Result<(), ConfigError> {
        let mut before = -1.0;
        for &speed in self.speeds {
            config_in_range(field, speed, 0.0, 1e4)?;
            // Speeds that do not increase are refused by the least that would do.
            config_in_range(field, speed, f64::max(0.0, before + 1e-6), 1e4)?;
            before = speed;
        }
        for &value in self.values {
            config_in_range(field, value, 1e-3, 1e3)?;
        }
        config_in_range(field, self.most(), 1e-3, 1e3)?;
        Ok(())
    }
}

/// A limit of the acceleration on a segment with a slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Over<'a> {
    /// The limit on level ground.
    pub table: &'a OverSpeed<'a>,
    /// What gravity takes of it [m/s^2].
    pub lost: f64,
    /// What is left of it at most [m/s^2].
    pub most: f64,
}

impl Over<'_> {
    #[inline]
    fn at(&self, squared: f64) -> f64 {
        let level = self.table.at(squared);
        let least = LEAST_ON_SLOPES * level;
        larger(smaller(level - self.lost, self.most), least)
    }
}

/// What limits the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimits<'a> {
    /// Top speed [m/s].
    pub max_speed: f64,
    /// Largest lateral acceleration [m/s^2].
    pub max_lateral_acceleration: f64,
    /// Largest driving acceleration [m/s^2].
    pub acceleration: OverSpeed<'a>,
    /// Largest braking deceleration [m/s^2].
    pub deceleration: OverSpeed<'a>,
    /// What the tyres hold along the vehicle [m/s^2]: the half axis of the friction ellipse, with
    /// the lateral acceleration as the other. If None, each of the two limits above is the half
    /// axis of an ellipse of its own.
    pub longitudinal_grip: Option<f64>,
    /// Exponent `p` of the ellipse `(a_x / grip)^p + (a_y / max_lateral_acceleration)^p <= 1`: 2 an
    /// ellipse, 1 a rhombus, infinite a rectangle.
    pub exponent: f64,
    /// The vehicle, whose wheels have to turn in time for the bends.
    pub vehicle: Vehicle,
}

impl SpeedLimits<'_> {
    /// Refuses a number that is out of its range.
    pub(super) fn checked(&self) -> Result<(), ConfigError> {
        config_in_range("max_speed", self.max_speed, 1e-3, 1e4)?;
        let lateral = self.max_lateral_acceleration;
        config_in_range("max_lateral_acceleration", lateral, 1e-3, 1e3)?;
        self.acceleration.checked("max_acceleration")?;
        self.deceleration.checked("max_deceleration")?;
        if let Some(grip) = self.longitudinal_grip {
            config_in_range("longitudinal_grip", grip, 1e-3, 1e3)?;
        }
        config_in_range("exponent", self.exponent, 1.0, f64::INFINITY)?;
        self.vehicle.checked()?;
        Ok(())
    }

    /// `A(w, k)`: largest acceleration along the path within `over` at the square `w` = `squared` of
    /// the speed [m^2/s^2] and the curvature `k` [1/m], by the friction ellipse:
    ///
    /// ```text
    /// min(over(w), grip share),    share = (1 - (w |k| / max_lateral_acceleration)^p)^(1/p)
    /// ```
    ///
    /// and `over(w) share` without a grip.
    #[inline]
    #[expect(
        clippy::float_cmp,
        reason = "the exponents that have a root of their own are exactly these"
    )]
    pub(super) fn available(&self, over: &Over<'_>, squared: f64, curvature: f64) -> f64 {
        let most = over.at(squared);
        let used = squared * curvature.abs() / self.max_lateral_acceleration;
        let share = if self.exponent == f64::INFINITY || used <= 0.0 {
            1.0
        } else if used >= 1.0 {
            0.0
        } else if self.exponent == 2.0 {
            sqrt(1.0 - used * used)
        } else if self.exponent == 1.0 {
            1.0 - used
        } else {
            powf(1.0 - powf(used, self.exponent), 1.0 / self.exponent)
        };
        match self.longitudinal_grip {
            None => most * share,
            Some(grip) => smaller(grip * share, most),
        }
    }

    /// The largest square of the speed, at most that of `to`, that is reached over `length` [m]:
    /// the largest `w` with
    ///
    /// ```text
    /// w - w_from <= 2 length A(w_from, k_from)    and    w - w_from <= 2 length A(w, k_to)
    /// ```
    ///
    /// The first is a number. The second has `w` on both sides; its root is found by false position
    /// in the Illinois variant, which halves the value of an end that stays twice.
    #[inline]
    pub(super) fn reach(
        &self,
        over: &Over<'_>,
        from: PlanPoint,
        to: PlanPoint,
        length: f64,
    ) -> f64 {
        let PlanPoint { squared, curvature } = from;
        let bound = to.squared;
        if bound <= squared {
            return bound;
        }
        let room = 2.0 * self.available(over, squared, curvature) * length;
        let mut high = smaller(squared + room, bound);
        // By how much `end` breaks the second condition.
        let beyond =
            |end: f64| end - squared - 2.0 * self.available(over, end, to.curvature) * length;
        let mut above = beyond(high);
        if above <= ROOT_TOLERANCE * high {
            return high;
        }
        // `low` always keeps the condition, so it is the answer.
        let mut low = squared;
        let mut below = beyond(low);
        let mut side = 0_i8;
        for _ in 0..ROOT_STEPS {
            if high - low <= ROOT_TOLERANCE * high || below >= 0.0 {
                break;
            }
            let middle = high - above * (high - low) / (above - below);
            let value = beyond(middle);
            if value <= 0.0 {
                low = middle;
                below = value;
                if side < 0 {
                    above *= 0.5;
                }
                side = -1;
            } else {
                high = middle;
                above = value;
                if side > 0 {
                    below *= 0.5;
                }
                side = 1;
            }
        }
        low
    }

    /// The largest speed, at most `most`, at which the wheels turn in time for a segment over which
    /// the curvature goes `from` one value `to` another [m/s]. From `tan(wheel) = k L(v)` with the
    /// turning length `L(v) = L + understeer v²`, and with the change `k'` of the curvature over the
    /// arc and the acceleration `a`:
    ///
    /// ```text
    /// wheel rate = v (k' L(v) + 2 understeer k a) / (1 + (k L(v))²)
    /// ```
    ///
    /// The largest `k` and `a` above, and the smallest `k` with `L` below, bound it from above over
    /// the whole segment. The bound grows with the speed, so bisection finds where it is the rate.
    pub(super) fn in_time(&self, from: f64, to: f64, length: f64, most: f64) -> f64 {
        let Some(rate) = self.vehicle.max_steer_rate else {
            return most;
        };
        let base = self.vehicle.turning_length(0.0);
        let bend = (to - from).abs() / length;
        let (one, other) = (from.abs(), to.abs());
        let (least, largest) = (smaller(one, other), larger(one, other));
        let least = if from * to > 0.0 { least } else { 0.0 };
        let easing = 1.0 + least * base * least * base;
        let understeer = self.vehicle.understeer;
        let strongest = larger(self.acceleration.most(), self.deceleration.most());
        let shift = 2.0 * understeer * strongest * largest;
        let turns =
            |speed: f64| speed * (bend * (base + understeer * speed * speed) + shift) / easing;
        if turns(most) <= rate {
            return most;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if turns(middle) <= rate {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// A waypoint of a plan: the square `w` of the speed there [m^2/s^2], and the curvature [1/m].
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanPoint {
    pub squared: f64,
    pub curvature: f64,
}

#[cfg(test)]
pub(super) mod tests;
