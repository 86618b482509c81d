//! POP: proximally optimal predictive control, the paper's Algorithm 1.

use crate::error::{ConfigError, InputError};
use crate::geometry::{Point, get_distance};
use crate::laws::law::{Tracked, check_steer};
use crate::laws::params::law_params;
use crate::laws::search::{Search, search_of};
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::math::{PI, atan2, from_count, saturate, to_count, wrap};
use crate::path::follow::Located;
use crate::path::view::PathView;
use crate::status::Status;
use crate::vehicle::bicycle::get_predicted_location;
use crate::vehicle::{Vehicle, VehicleState};

law_params! {
    /// Parameters of [`Pop`]; the paper's Table 1 at the paper's car. The paper gives no
    /// `min_lookahead`: the published code has 6 m.
    pub struct PopParams<Scaled> of Vehicle(wheelbase) {
        /// Velocity constant `k_v` [s]: `lookahead = min_lookahead + lookahead_gain * speed`.
        lookahead_gain: f64 = 0.2, in [0.0, 1e3];
        /// Lookahead at rest `ld_min` [m].
        min_lookahead: Scaled = 2.0 * wheelbase, in [0.0, 1e4];
        /// Optimization range `delta_nbd` [rad]: candidates lie at most this far from the last angle.
        steer_span: f64 = 3.0 * (PI / 180.0), in [1e-6, PI];
        /// Optimization resolution: the number of candidates, odd.
        candidate_count: usize = 21, in odd [3, 100_001];
    }
    with search
}

/// What [`Pop`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PopState {
    /// The last angle `delta_prev` [rad].
    pub previous_steer: f64,
}

/// The POP controller: of the angles in the neighbourhood of the last one, the angle whose
/// predicted location lies closest to the lookahead point.
///
/// With one-step point prediction the wheelbase does not enter; it only places the reference
/// point. The last angle is looked at first and wins ties, so a vehicle at rest, where every
/// candidate predicts the same location, keeps its wheels still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pop {
    steered: Steered,
    search: Search,
    steer_span: f64,
    candidate_count: usize,
    /// Candidates on either side of the last angle.
    half: f64,
    /// Difference of neighbouring candidates [rad], and its inverse.
    step: f64,
    steps_per_rad: f64,
}

impl Pop {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: PopParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle).checked()?;
        let half = from_count(params.candidate_count / 2);
        let step = params.steer_span / half;
        Ok(Self {
            search: search_of!(params),
            steer_span: params.steer_span,
            candidate_count: params.candidate_count,
            half,
            step,
            steps_per_rad: 1.0 / step,
            steered: Tracked::FrontAxle.of(&vehicle, params.search_distance, params.lost_distance),
        })
    }

    /// `ld` [m].
    #[inline]
    fn lookahead(&self, at: &Located) -> f64 {
        self.search.min_lookahead + self.search.lookahead_gain * at.vehicle.forward_speed()
    }

    /// The optimization of Algorithm 1, with the vehicle at the origin: distances are the same
    /// there, and no digits are lost far from it.
    #[inline]
    fn choose(&self, target: Point, vehicle: VehicleState, previous_steer: f64, dt: f64) -> f64 {
        self.choose_in_closed_form(target, vehicle, previous_steer, dt)
            .unwrap_or_else(|| self.choose_by_loop(target, vehicle, previous_steer, dt))
    }

    /// The loop of Algorithm 1: the definition of the controller.
    #[cold]
    fn choose_by_loop(
        &self,
        target: Point,
        vehicle: VehicleState,
        previous_steer: f64,
        dt: f64,
    ) -> f64 {
        let travel = vehicle.speed * dt;
        let range = get_distance(Point::new(0.0, 0.0), target);
        // The candidates' distances differ by about travel * span^2; below the rounding of the
        // distances themselves their order is noise, and following it would wind the wheels up.
        if travel * self.steer_span * self.steer_span <= 16.0 * f64::EPSILON * range {
            return previous_steer;
        }
        self.choose_nearest(previous_steer, |steer| {
            get_distance(get_predicted_location(vehicle, steer, dt), target)
        })
    }

    /// The candidate that is predicted closest; the last angle where none is closer.
    #[inline]
    fn choose_nearest(&self, previous_steer: f64, predict: impl Fn(f64) -> f64) -> f64 {
        let mut steer = previous_steer;
        let mut least = predict(steer);
        for k in 0..self.candidate_count {
            let candidate = self.candidate(previous_steer, k);
            let distance = predict(candidate);
            if distance < least {
                steer = candidate;
                least = distance;
            }
        }
        steer
    }

    /// What the loop chooses, where that is certain; None if rounding could decide.
    ///
    /// With `range` and `bearing` of the target and `travel` of the vehicle, the squared distance
    /// of a candidate is `range^2 + travel^2 - 2 range travel cos(heading - bearing)`: the best
    /// is the one whose heading is nearest to the bearing.
    #[inline]
    fn choose_in_closed_form(
        &self,
        target: Point,
        vehicle: VehicleState,
        previous_steer: f64,
        dt: f64,
    ) -> Option<f64> {
        let Self { half, step, .. } = *self;
        let wanted = wrap(atan2(target.y, target.x) - vehicle.yaw - previous_steer);
        // Near the opposite direction the cosine has its minimum within the list.
        if wanted.abs() >= PI - 2.0 * self.steer_span {
            return None;
        }
        // The place of the wanted angle in the list, and the candidate nearest to it.
        let place = wanted * self.steps_per_rad + half;
        let k = to_count(saturate(place + 0.5, 0.0, 2.0 * half));
        // How far the place is from where the next candidate would be as good, in steps.
        let beyond = place < 0.0 || place > 2.0 * half;
        let clearance = if beyond {
            0.25
        } else {
            0.5 - (place - from_count(k)).abs()
        };
        // The next candidate's distance has to differ by more than rounding can hide. The range
        // lies between the larger of the coordinates and their sum.
        let (x, y) = (target.x.abs(), target.y.abs());
        let travel = vehicle.speed * dt;
        let (least_range, sum) = (if x > y { x } else { y }, x + y + travel);
        let decided = clearance * step * step * least_range * travel
            > 64.0 * f64::EPSILON * sum * sum
            && clearance * step > 64.0 * f64::EPSILON * (vehicle.yaw.abs() + 8.0);
        let middle = self.candidate_count / 2;
        let candidate = if k == middle {
            previous_steer
        } else {
            self.candidate(previous_steer, k)
        };
        // At the limit candidates run together, and a neighbour may be nearer than its place.
        (decided && candidate.abs() + step < self.vehicle().max_steer).then_some(candidate)
    }

    /// Candidate `k` of `delta_list`: evenly over `previous_steer +- steer_span`, within the
    /// limit.
    #[inline]
    fn candidate(&self, previous_steer: f64, k: usize) -> f64 {
        let offset = self.steer_span * ((from_count(k) - self.half) / self.half);
        let max_steer = self.vehicle().max_steer;
        saturate(previous_steer + offset, -max_steer, max_steer)
    }
}

impl LateralState for PopState {
    #[inline]
    fn set_steer(&mut self, steer: f64) -> bool {
        self.previous_steer = steer;
        true
    }
}

impl LateralLaw for Pop {
    type State = PopState;

    fn initial_state(&self) -> PopState {
        PopState::default()
    }

    fn steered(&self) -> &Steered {
        &self.steered
    }

    #[inline]
    fn pull(&self, at: &Located) -> f64 {
        at.closest.cross_track_error() / self.lookahead(at)
    }

    /// Algorithm 1.
    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        at: &Located,
        _belief: &Belief,
    ) -> Decision {
        let speed = at.vehicle.forward_speed();
        let target = self.search.find(path, at, self.lookahead(at));
        let yaw = at.vehicle.yaw;
        let here = VehicleState {
            yaw,
            speed,
            ..VehicleState::ORIGIN
        };
        let previous_steer = at.mirror(state.previous_steer);
        let steer = self.choose(target.point - at.position, here, previous_steer, at.dt);
        state.previous_steer = at.mirror(steer);
        Decision {
            steer,
            target: target.point,
            status: (Status::SATURATED | Status::STEER_LIMIT)
                .when(steer.abs() >= self.vehicle().max_steer)
                | Status::LOOKAHEAD_LOST.when(!target.found),
        }
    }

    fn check_state(&self, state: &PopState) -> Result<(), InputError> {
        let most = self.vehicle().max_steer;
        check_steer("law.previous_steer", state.previous_steer, most)
    }
}

#[cfg(test)]
mod tests;
