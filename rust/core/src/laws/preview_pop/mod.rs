//! Preview POP: of the angles near the last one, the one with the least predicted cost.
//!
//! One step of the controller, `PreviewPop::choose`, does the following:
//!
//! 1. `predict`: the model, its cost and the path ahead ([`horizon`]); the cost-to-go over them
//!    ([`cost_to_go`]).
//! 2. `start`: the state of the vehicle, with a large cross-track error limited to what it can
//!    approach.
//! 3. Limits: those of this period's angle (`Neighbourhood`), and those of the plan's moves and
//!    curvatures.
//! 4. Solve: `unlimited_angle` is the best angle in closed form. Only if its plan breaks a limit,
//!    `best_within` replaces it ([`limited`]).
//!
//! Angles in this file are those of the wheels, and of the mirrored vehicle: where the path is
//! driven backwards, the controller sees a vehicle that drives forward. A command is such an angle
//! less the steering offset; the tracker converts.

mod active_set;
mod approach;
pub mod cost_to_go;
pub mod horizon;
pub mod limited;

use crate::error::{ConfigError, InputError};
use crate::laws::law::{Tracked, check_steer};
use crate::laws::params::law_params;
use crate::laws::preview_pop::approach::{Approach, FULL_RATE, Straightening};
use crate::laws::preview_pop::cost_to_go::{BestMove, CostToGo, ModelState, Travel};
use crate::laws::preview_pop::limited::{Horizon, MoveLimit, PlanLimits, ReachedLimits};
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::math::{PI, atan, atan2, decay, from_count, larger, saturate, smaller, sqrt, tan, wrap};
use crate::path::follow::Located;
use crate::path::preview::Preview;
use crate::path::view::PathView;
use crate::status::Status;
use crate::vehicle::Vehicle;
use crate::vehicle::bicycle::{MAX_STEPS, steps};

/// A vehicle that brakes by more than this share of its comfortable braking slows for what is ahead.
const BRAKING: f64 = 1.0 / 6.0;
/// How many horizons ahead sharp bends are looked for.
const FARTHEST: usize = 4;

law_params! {
    /// Parameters of [`PreviewPop`]: POP's neighbourhood, and costs that suit a passenger car.
    pub struct PreviewPopParams<Scaled> of Vehicle(wheelbase, max_steer_rate, steers_at_rest) {
        /// Optimization range `delta_nbd` over the control period [rad/s]: an angle lies at most this
        /// times dt from the last one. The paper has 3 degrees in 50 ms, which are the 60 degrees a
        /// second of the default.
        steer_span_rate: Scaled = max_steer_rate.unwrap_or(60.0 * (PI / 180.0)), in [1e-3, 1e6];
        /// How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is
        /// anticipated. If it is shorter than the lag and the return to the path, the vehicle
        /// oscillates. Up to twice as long below a wheelbase in 0.6 s, and if the vehicle has a
        /// `max_steer_rate` and its wheels need it.
        horizon: f64 = 1.0, in [0.05, 100.0];
        /// How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]. More:
        /// the path is joined more gently, and offsets take longer to vanish.
        heading_cost: Scaled = wheelbase, in [0.0, 1e3];
        /// How many metres of cross-track error are as bad as turning the wheels at 1 rad/s
        /// [m s/rad]. More: calmer wheels, less noise passed on, wider bends where the model is
        /// wrong.
        steer_rate_cost: Scaled = wheelbase / 12.0, in [1e-5, 1e3];
        /// Heading at which the path is approached from afar [rad]; less if the vehicle's limits
        /// would not straighten it in time. More: sooner back on the path, by a sharper manoeuvre.
        approach_angle: f64 = 0.25, in [1e-3, 0.5 * PI];
        /// Below this speed [m/s] the wheels turn in proportion to the distance travelled, and the
        /// prediction looks as far as at this speed; at rest they keep their angle, unless the vehicle
        /// has `steers_at_rest`. Where the
        /// vehicle's `max_steer_rate` is given, they turn at all of it down to half this speed.
        min_speed: Scaled = wheelbase / if steers_at_rest || max_steer_rate.is_some() { 3.0 } else { 0.6 }, in [1e-4, 1e4];
        /// Length of path over which its direction is taken [m]. More: less of the waypoints' noise
        /// is steered, and bends shorter than this are cut.
        smoothing_length: Scaled = wheelbase * if steers_at_rest { 0.2 } else { 2.0 / 3.0 }, in [0.0, 1e3];
    }
}

/// What [`PreviewPop`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PreviewPopState {
    /// The last angle `delta_prev` [rad]: that of the wheels, the command plus the steering offset.
    pub previous_steer: f64,
    /// The limits that the last plan reached, three bits a step. The search for the next plan
    /// starts from them: it gets faster, its result stays the same.
    pub reached_limits: u64,
}

/// Preview POP: of the angles in the neighbourhood of the last one, the angle with the least cost
/// over a horizon.
///
/// The cost of a step is `e^2 + (heading_cost p)^2 + (steer_rate_cost rate)^2`: cross-track error
/// `e`, heading error `p`, and the rate of the commanded angle, linearised about straight wheels. A
/// linear bicycle with steering lag predicts them along the curvature of the path ahead. The moves
/// after the first one are assumed optimal; their cost is the cost-to-go. The cost of an angle is
/// then a parabola, and its minimum is the best angle. There is no list of candidates; the
/// controller is this closed form. Where that plan breaks a limit of the wheels' rate or angle or
/// of the lateral acceleration, at any step, the best plan that keeps them takes its place
/// ([`limited`](super::limited)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewPop {
    steered: Steered,
    params: PreviewPopParams<f64>,
    approach: Approach,
}

/// The prediction of one control step, for the mirrored vehicle: one that drives forward.
struct Prediction<'a> {
    horizon: Horizon<'a>,
    /// Heading of the path beside the vehicle [rad].
    path_yaw: f64,
    /// Turning length over the estimated gain [m]: `angle = atan(curvature * length)`.
    length: f64,
    /// Time of a step of the horizon [s].
    period: f64,
    /// The speed that is predicted with [m/s]: the vehicle's, but at least `min_speed`.
    pace: f64,
    /// The steering lag, as a distance [m].
    lag: f64,
    /// [`Status::TOO_FAST`] before a bend that is too sharp for the speed.
    ahead: Status,
}

/// The angles that can be commanded in this control period.
struct Neighbourhood {
    /// The smallest [rad].
    low: f64,
    /// The largest [rad].
    high: f64,
    /// The wheels' planned rate [rad/s].
    rate: f64,
    /// Control period as a share of a step of the horizon, at most 1.
    share: f64,
}

impl PreviewPop {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: PreviewPopParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle).checked()?;
        let rate = vehicle.max_steer_rate.unwrap_or(f64::INFINITY);
        Ok(Self {
            approach: Approach {
                rate: smaller(params.steer_span_rate, rate),
                rate_is_the_vehicles: rate <= params.steer_span_rate,
                max_tangent: tan(vehicle.max_steer),
                horizon: params.horizon,
                angle: params.approach_angle,
                min_speed: params.min_speed,
            },
            steered: Tracked::NoSlipPoint.of(
                &vehicle,
                params.search_distance,
                params.lost_distance,
            ),
            params,
        })
    }

    /// The best angle in the neighbourhood of `previous_steer`, and the status of the plan. Both
    /// angles are of the mirrored vehicle.
    #[inline]
    fn choose(
        &self,
        path: &PathView<'_>,
        previous_steer: f64,
        guess: &mut ReachedLimits,
        at: &Located,
        belief: &Belief,
    ) -> (f64, Status) {
        let mut turns = [0.0; MAX_STEPS];
        let prediction = self.predict(path, at, belief, &mut turns);
        let mut moves = [BestMove::default(); MAX_STEPS];
        let cost = prediction.horizon.unlimited(&mut moves);

        let speed = at.vehicle.forward_speed();
        let (rate, span) = self.approach.rate_and_span(speed, at.dt);
        let around = Neighbourhood {
            low: previous_steer - span,
            high: previous_steer + span,
            rate,
            share: at.dt / prediction.period,
        };
        let tangent = tan(previous_steer);
        let (start, pull) = self.start(&prediction, &cost, &around, tangent, at, belief);
        let unlimited = prediction.unlimited_angle(&cost, &start, pull, around.share);

        let later = rate * prediction.period * self.tangent_slope(tangent) / prediction.length;
        let limits = |(low, high)| PlanLimits {
            first: (-later, later),
            later,
            low,
            high,
        };
        let keeps = |limits: &PlanLimits| {
            around.low <= unlimited
                && unlimited <= around.high
                && prediction.horizon.keeps(&moves, start, limits)
        };
        // The narrower limits are cheaper, and a plan that keeps them keeps the limits.
        let narrower = self.narrower_curvatures(at, belief, prediction.length);
        if keeps(&limits(narrower)) {
            *guess = ReachedLimits::default();
            return (unlimited, prediction.ahead);
        }
        let limits = limits(self.curvatures(at, belief, prediction.length));
        if keeps(&limits) {
            *guess = ReachedLimits::default();
            return (unlimited, prediction.ahead);
        }
        // At rest the wheels do not turn.
        if span <= 0.0 {
            return (previous_steer, prediction.ahead);
        }
        self.best_within(&prediction, start, limits, &around, guess, at)
    }

    /// Sets the planning problem up: the model over a step of travel, the cost, and how the path
    /// turns in each step, into `turns`.
    #[inline]
    fn predict<'a>(
        &self,
        path: &PathView<'_>,
        at: &Located,
        belief: &Belief,
        turns: &'a mut [f64; MAX_STEPS],
    ) -> Prediction<'a> {
        let (vehicle, estimate) = (self.vehicle(), &belief.estimate);
        let speed = at.vehicle.forward_speed();
        let pace = larger(speed, self.approach.min_speed);
        let length = vehicle.turning_length(speed) / estimate.gain;
        let horizon = self.approach.horizon_at(vehicle, pace);
        let (longer, ahead) = self.sharp_bend_ahead(path, at, pace, length, estimate.acceleration);
        let (count, period) = steps(horizon * longer, at.dt);
        // The model runs over distance: that of a step, and that travelled in the lag.
        let step = pace * period;
        let lag = estimate.steer_lag(vehicle) * speed;
        // A slip of `slip_length` times the curvature acts as if the tracked point lay
        // `slip_length` ahead of the no-slip point; behind it in the mirrored vehicle.
        let offset = at.mirror(estimate.slip_length);
        let move_cost = self.params.steer_rate_cost * length / period;

        let turns = turns.get_mut(..count).unwrap_or_default();
        let (along, aside) = self.turns(path, at, step, turns);
        Prediction {
            horizon: Horizon {
                travel: Travel::new(step, lag, decay(step, lag), offset),
                stage: CostToGo::stage(self.params.heading_cost, offset),
                move_cost: move_cost * move_cost,
                turns,
            },
            path_yaw: atan2(aside, along),
            length,
            period,
            pace,
            lag,
            ahead,
        }
    }

    /// How far the path turns over each of the next steps of `step` [m] beside the vehicle [rad],
    /// into `turns`. Returns its direction there, as the x and y [m] of a chord.
    #[inline]
    fn turns(&self, path: &PathView<'_>, at: &Located, step: f64, turns: &mut [f64]) -> (f64, f64) {
        let arc = at.closest.arc_length(path);
        let (smoothing, distance) = (self.params.smoothing_length, from_count(turns.len()) * step);
        Preview::new(path, smoothing, at.closest.segment, arc, distance).turns(arc, step, turns)
    }

    /// How many times as far as usual to look ahead: past a bend that is sharper than the lateral
    /// acceleration allows, at a speed that the vehicle can no longer leave before it, so that it
    /// turns in early. [`Status::TOO_FAST`] before such a bend, also where the vehicle brakes.
    #[inline]
    fn sharp_bend_ahead(
        &self,
        path: &PathView<'_>,
        at: &Located,
        pace: f64,
        length: f64,
        acceleration: f64,
    ) -> (f64, Status) {
        let vehicle = self.vehicle();
        let braking = vehicle.comfort_braking();
        let Some(most) = vehicle.max_lateral_acceleration else {
            return (1.0, Status::OK);
        };
        let stretch = pace * self.params.horizon;
        let mut turns = [0.0; 2 * FARTHEST];
        self.turns(path, at, 0.5 * stretch, &mut turns);
        let slowest = self.approach.min_speed * self.approach.min_speed;
        let speed = at.vehicle.forward_speed();
        // A stretch turns the vehicle by its mean; it is judged by the speed after a quarter of it. In a
        // chicane, whose halves turn to either side, the sharper one counts.
        let (mut squared, mut driven) = (pace * pace, speed * speed - 0.5 * braking * stretch);
        let (mut longer, mut ahead) = (1.0, Status::OK);
        for (stretches, halves) in turns.as_chunks::<2>().0.iter().enumerate() {
            let [first, second] = *halves;
            let turn = first + second;
            let widest = self.approach.widest(vehicle, sqrt(squared), length);
            let asked = if first * second < 0.0 {
                2.0 * larger(first.abs(), second.abs())
            } else {
                turn.abs()
            };
            ahead |= Status::TOO_FAST.when(asked * driven > stretch * most);
            if turn.abs() > stretch * widest {
                longer = smaller(from_count(stretches + 2), from_count(FARTHEST));
                break;
            }
            squared = larger(squared - 2.0 * braking * stretch, slowest);
            driven -= 2.0 * braking * stretch;
        }
        if acceleration < -BRAKING * braking {
            // It slows for the bend.
            longer = 1.0;
        }
        (longer, ahead)
    }

    /// The state that the plan starts from, and half the slope of its cost by the commanded
    /// curvature that the cross-track error causes: its pull, `S_ec e`.
    ///
    /// The pull of a large error is limited to that of the approach angle, or of the steepest
    /// heading that the vehicle can still straighten before the path: `S_pc` times it. The plan
    /// then starts from the error that has this pull.
    #[inline]
    fn start(
        &self,
        prediction: &Prediction<'_>,
        cost: &CostToGo,
        around: &Neighbourhood,
        tangent: f64,
        at: &Located,
        belief: &Belief,
    ) -> (ModelState, f64) {
        let vehicle = self.vehicle();
        let &Prediction { length, pace, .. } = prediction;
        let error = at.closest.cross_track_error();
        let straightening = Straightening {
            curvature: self.approach.widest(vehicle, pace, length),
            rate: around.rate / (length * pace),
            lag: prediction.lag,
            unlimited: cost.pc / cost.ec,
        };
        let most = self.approach.angle_at(vehicle, error, &straightening) * cost.pc;
        let most = if most > 0.0 { most } else { 0.0 };
        let wanted = error * cost.ec;
        let pull = saturate(wanted, -most, most);
        let wheel = vehicle.at_wheels(belief.wheel + belief.estimate.steer_offset);
        let start = ModelState {
            error: if wanted.abs() > most {
                pull / cost.ec
            } else {
                error
            },
            heading: wrap(at.vehicle.yaw + belief.estimate.slip - prediction.path_yaw),
            driven: tan(at.mirror(wheel)) / length,
            commanded: tangent / length,
        };
        (start, pull)
    }

    /// The angle of the best plan within `limits` and the neighbourhood, and how it was planned.
    fn best_within(
        &self,
        prediction: &Prediction<'_>,
        start: ModelState,
        limits: PlanLimits,
        around: &Neighbourhood,
        guess: &mut ReachedLimits,
        at: &Located,
    ) -> (f64, Status) {
        let &Neighbourhood {
            low, high, share, ..
        } = around;
        let (length, commanded) = (prediction.length, start.commanded);
        let max_steer = self.vehicle().max_steer;
        let move_to = |angle: f64| (tan(angle) / length - commanded) / share;
        // An angle beyond `max_steer` is excluded by the limits of the curvature already.
        let least = if low > -max_steer {
            move_to(low)
        } else {
            f64::NEG_INFINITY
        };
        let most = if high < max_steer {
            move_to(high)
        } else {
            f64::INFINITY
        };
        let limits = PlanLimits {
            first: (least, most),
            ..limits
        };
        let plan = prediction.horizon.limited(start, &limits, *guess);
        *guess = if share > 0.5 {
            plan.limits.later()
        } else {
            plan.limits
        };
        // A move that ends at a limit of the curvature is commanded at once: with only a share of
        // it in each control period, the wheels would get there too late.
        let made = match plan.reached {
            MoveLimit::Curvature => 1.0,
            _ => share,
        };
        let angle = atan((commanded + (plan.first() - commanded) * made) * length);
        // SATURATED means that the vehicle limits the angle. Arriving at a limit of the curvature
        // counts; being held back by `steer_span_rate`, which is a choice, does not.
        let rate_is_the_vehicles = self.approach.rate_is_the_vehicles
            && at.vehicle.forward_speed() >= FULL_RATE * self.approach.min_speed;
        let arrives = low - 1e-10 <= angle && angle <= high + 1e-10;
        let saturated = match plan.reached {
            MoveLimit::Rate if rate_is_the_vehicles => Status::SATURATED | Status::RATE_LIMIT,
            MoveLimit::Curvature if arrives || rate_is_the_vehicles => {
                let pace = at.vehicle.speed;
                let steered = self.approach.max_tangent / length * (pace * pace);
                let lateral = self.vehicle().max_lateral_acceleration;
                Status::SATURATED
                    | match lateral {
                        Some(most) if most <= steered => Status::LATERAL_LIMIT,
                        _ => Status::STEER_LIMIT,
                    }
            }
            _ => Status::OK,
        };
        let cut_short = Status::PLAN_CUT_SHORT.when(plan.cut_short);
        let status = saturated | prediction.ahead | cut_short;
        (saturate(angle, low, high), status)
    }

    /// Least and greatest curvature that may be commanded [1/m]. The wheels keep `max_steer`, and
    /// so does the command, their angle less the steering offset; both keep
    /// `max_lateral_acceleration`.
    #[inline]
    fn curvatures(&self, at: &Located, belief: &Belief, length: f64) -> (f64, f64) {
        let vehicle = self.vehicle();
        let offset = at.mirror(vehicle.steer_offset + belief.estimate.steer_offset);
        let most = vehicle.max_steer;
        let end = |angle: f64| tan(vehicle.at_wheels(angle)) / length;
        self.within_lateral_acceleration(at, end(offset - most), end(offset + most))
    }

    /// Curvatures within [`curvatures`](Self::curvatures), from a linear bound of the tangent. Most
    /// plans keep them, which saves two tangents a step.
    #[inline]
    fn narrower_curvatures(&self, at: &Located, belief: &Belief, length: f64) -> (f64, f64) {
        let offset = self.vehicle().steer_offset + belief.estimate.steer_offset;
        let tangent = self.approach.max_tangent;
        let narrower = tangent - offset.abs() * (1.0 + tangent * tangent) * (1.0 + 1e-9);
        let widest = narrower / length;
        self.within_lateral_acceleration(at, -widest, widest)
    }

    #[inline]
    fn within_lateral_acceleration(&self, at: &Located, low: f64, high: f64) -> (f64, f64) {
        let Some(most) = self.vehicle().max_lateral_acceleration else {
            return (low, high);
        };
        let speed = at.vehicle.speed;
        let widest = most / (speed * speed);
        let within = |curvature| saturate(curvature, -widest, widest);
        (within(low), within(high))
    }

    /// Slope d(tan δ)/dδ used for the rate limit: `1 + tangent²`, where `tangent` is that of the
    /// wheels' angle δ. A plan at the vehicle's own rate uses 1, the slope at straight wheels: it
    /// falls to that while the wheels turn back to straight, and a plan that used more would make
    /// them late.
    #[inline]
    fn tangent_slope(&self, tangent: f64) -> f64 {
        if self.approach.rate_is_the_vehicles {
            1.0
        } else {
            1.0 + tangent * tangent
        }
    }
}

impl Prediction<'_> {
    /// The minimum of the parabola that the cost-to-go is in the commanded curvature `c`, as an
    /// angle of the wheels [rad]:
    ///
    /// ```text
    /// c_wanted = c - share slope / (R + S_cc),    slope = S_ec e + S_pc p + S_ac a + S_cc c + s_c
    /// ```
    ///
    /// `pull` is the term `S_ec e`. This is the move for a whole step of the horizon; a control
    /// period may be shorter, and makes its `share` of the move.
    #[inline]
    fn unlimited_angle(&self, cost: &CostToGo, start: &ModelState, pull: f64, share: f64) -> f64 {
        let slope = pull
            + start.heading * cost.pc
            + start.driven * cost.ac
            + start.commanded * cost.cc
            + cost.c;
        let wanted = start.commanded - slope / (self.horizon.move_cost + cost.cc) * share;
        atan(wanted * self.length)
    }
}

impl LateralState for PreviewPopState {
    #[inline]
    fn set_steer(&mut self, steer: f64) -> bool {
        self.previous_steer = steer;
        true
    }
}

impl LateralLaw for PreviewPop {
    type State = PreviewPopState;

    fn initial_state(&self) -> PreviewPopState {
        PreviewPopState::default()
    }

    fn steered(&self) -> &Steered {
        &self.steered
    }

    fn reads_belief(&self) -> bool {
        true
    }

    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PreviewPopState,
        at: &Located,
        belief: &Belief,
    ) -> Decision {
        let mut reached = ReachedLimits(state.reached_limits);
        let previous = at.mirror(state.previous_steer);
        let (wanted, planned) = self.choose(path, previous, &mut reached, at, belief);
        state.reached_limits = reached.0;
        let (steer, status) = self.vehicle().limit_steer(wanted);
        state.previous_steer = at.mirror(steer);
        Decision {
            steer,
            target: at.closest.point,
            status: planned | status,
        }
    }

    fn check_state(&self, state: &PreviewPopState) -> Result<(), InputError> {
        let most = self.vehicle().max_steer;
        check_steer("law.previous_steer", state.previous_steer, most)
    }
}
