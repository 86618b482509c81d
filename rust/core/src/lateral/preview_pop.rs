//! Preview POP: POP's neighbourhood, judged by where it leads over a horizon.

use super::cost_to_go::{CostToGo, Travel};
use super::{
    Body, Command, LateralLaw, LateralState, Status, body_params, check_steer, check_waypoint,
    command,
};
use crate::error::{ConfigError, InputError, config_in_range, input_in_range};
use crate::math::{PI, atan, cos, decay, from_count, saturate, sin, tan, wrap};
use crate::path::follow::{Follow, Located};
use crate::path::preview::Preview;
use crate::path::view::{MAX_COORDINATE, PathView};
use crate::vehicle::VehicleState;
use crate::vehicle::predict::{MAX_STEPS, steps};
use crate::vehicle::state::MAX_YAW;

/// Parameters of [`PreviewPop`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewPopParams {
    /// Optimization range `delta_nbd` [rad]: an angle lies at most this far from the last one.
    pub steer_span: f64,
    /// Fastest the wheels are told to turn [rad/s]; at a control period of 50 ms, 60 degrees/s
    /// are the paper's 3 degrees a step.
    pub max_steer_rate: f64,
    /// Largest lateral acceleration that an angle may ask for [m/s^2]. Less: a vehicle that is too
    /// fast for a bend runs wide instead of sliding.
    pub max_lateral_acceleration: f64,
    /// How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is
    /// seen through; shorter than the lag and the way back to the path, the vehicle swings.
    pub horizon: f64,
    /// How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]. More:
    /// the path is joined more gently, and offsets take longer to vanish.
    pub heading_cost: f64,
    /// How many metres of cross-track error are as bad as turning the wheels at 1 rad/s [m s/rad].
    /// More: calmer wheels, less noise passed on, wider bends where the model is wrong.
    pub steer_rate_cost: f64,
    /// Heading at which the path is approached from afar [rad]. More: sooner back on the path, by
    /// a sharper manoeuvre.
    pub approach_angle: f64,
    /// Below this speed [m/s] the wheels turn in proportion to the way travelled, and the
    /// prediction looks as far as at this speed; at rest they keep their angle.
    pub min_speed: f64,
    /// Length of path over which its direction is taken [m]. More: less of the waypoints' noise
    /// is steered, and bends shorter than this are cut.
    pub smoothing_length: f64,
    /// Time in which the law learns how much more the vehicle turns than the model says [s]; 0
    /// never. Shorter: sooner right, and more noise of the heading passed on.
    pub turn_learning_time: f64,
    /// Time in which it learns at what angle to its heading the vehicle travels, straight on and
    /// in bends [s]; 0 never. Shorter: sooner right, and more noise of the position passed on.
    pub slip_learning_time: f64,
    /// Effective wheelbase of the model [m].
    pub wheelbase: f64,
    /// Understeer of the model [s^2/m]: `curvature = tan(steer) / (wheelbase + understeer speed^2)`.
    pub understeer: f64,
    /// Time constant with which the curvature follows the angle [s].
    pub steer_lag: f64,
    /// Reference point ahead of the rear axle, in the direction of driving [m], which is taken not
    /// to slip; the rear axle, 0, by default.
    pub reference_offset: Option<f64>,
    /// Steering limit `delta_max` [rad].
    pub max_steer: f64,
    /// How far along the path from the last place the vehicle is looked for [m], beside what it
    /// travels in a step; two wheelbases by default.
    pub search_distance: Option<f64>,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path
    /// [m]; ten wheelbases by default.
    pub lost_distance: Option<f64>,
}

impl PreviewPopParams {
    /// The defaults: the neighbourhood and limit of POP, and a middling car.
    pub const DEFAULT: Self = Self {
        steer_span: 12.0 * (PI / 180.0),
        max_steer_rate: 60.0 * (PI / 180.0),
        max_lateral_acceleration: 15.0,
        horizon: 1.0,
        heading_cost: 3.0,
        steer_rate_cost: 0.25,
        approach_angle: 0.25,
        min_speed: 5.0,
        smoothing_length: 2.0,
        turn_learning_time: 0.0,
        slip_learning_time: 5.0,
        wheelbase: 3.0,
        understeer: 0.0,
        steer_lag: 0.1,
        reference_offset: None,
        max_steer: 1.22,
        search_distance: None,
        lost_distance: None,
    };
}

impl Default for PreviewPopParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`PreviewPop`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreviewPopState {
    /// The waypoint at which the segment of the last foot starts; none before the first step.
    pub waypoint: Option<usize>,
    /// The last angle `delta_prev` [rad].
    pub previous_steer: f64,
    /// Curvature that the vehicle drives by now, by the model [1/m].
    pub curvature: f64,
    /// Where the vehicle was seen at the last step [m].
    pub previous_x: f64,
    /// The other coordinate [m].
    pub previous_y: f64,
    /// Its heading then [rad].
    pub previous_yaw: f64,
    /// How far it was to come since then [m]; 0 where nothing is to be learnt from it.
    pub travel: f64,
    /// How much it was to turn since then by the model [rad].
    pub turn: f64,
    /// How much more the vehicle turns than the model says, as learnt [1/m].
    pub turn_offset: f64,
    /// Angle of the way it travels to its heading, straight on, as learnt [rad].
    pub slip: f64,
    /// How much that angle grows with the curvature, as learnt [m]: so much farther ahead of the
    /// point that does not slip lies the reference point than the model says.
    pub slip_length: f64,
}

/// Preview POP: of the angles in the neighbourhood of the last one, the angle with the least cost
/// over a horizon.
///
/// The cost of a step is `e^2 + (heading_cost p)^2 + (steer_rate_cost rate)^2`, with the
/// cross-track error `e`, the heading error `p` and the rate of the wheels, predicted by a bicycle
/// with lag along the curvature of the path ahead. What follows the first step is taken at its
/// best, the cost-to-go, so the cost of an angle is a parabola: the best angle of the
/// neighbourhood is the lowest point of it, brought within the neighbourhood and the limits.
/// There is no list of candidates; the law is this closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewPop {
    body: Body,
    params: PreviewPopParams,
}

/// The angle that a step decides on, and whether a limit of the vehicle held it back.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Decision {
    steer: f64,
    status: Status,
}

impl PreviewPop {
    /// The shortest way that teaches anything [m]; a step of the law goes at least ten times as far.
    const LEAST_TRAVEL: f64 = 1e-8;
    /// The largest turn that is learnt [1/m].
    pub const MAX_TURN_OFFSET: f64 = 0.05;
    /// The largest slip that is learnt [rad].
    pub const MAX_SLIP: f64 = 0.15;
    /// Curvature at which a half of what is learnt is laid to the bend [1/m].
    const BEND: f64 = 0.01;

    /// The law with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: PreviewPopParams) -> Result<Self, ConfigError> {
        config_in_range("steer_span", params.steer_span, 1e-6, PI)?;
        config_in_range("max_steer_rate", params.max_steer_rate, 1e-3, 1e3)?;
        config_in_range(
            "max_lateral_acceleration",
            params.max_lateral_acceleration,
            1e-3,
            1e6,
        )?;
        config_in_range("horizon", params.horizon, 0.05, 100.0)?;
        config_in_range("heading_cost", params.heading_cost, 0.0, 1e3)?;
        config_in_range("steer_rate_cost", params.steer_rate_cost, 1e-3, 1e3)?;
        config_in_range("approach_angle", params.approach_angle, 1e-3, 0.5 * PI)?;
        config_in_range("min_speed", params.min_speed, 0.1, 1e3)?;
        config_in_range("smoothing_length", params.smoothing_length, 0.0, 1e3)?;
        config_in_range("turn_learning_time", params.turn_learning_time, 0.0, 1e6)?;
        config_in_range("slip_learning_time", params.slip_learning_time, 0.0, 1e6)?;
        config_in_range("understeer", params.understeer, 0.0, 1e3)?;
        config_in_range("steer_lag", params.steer_lag, 0.0, 10.0)?;
        let body = Body::new(body_params!(params), 0.0)?;
        Ok(Self { body, params })
    }

    /// One step of the law: locate, learn, predict, choose, remember.
    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PreviewPopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<(Located, Decision), InputError> {
        let at = self.body.locate(path, state.waypoint, vehicle, dt)?;
        let mut next = self.learn(path, &state.turned(&at), &at);
        next.waypoint = Some(at.foot.segment);
        let decision = self.choose(path, &next, &at);
        self.remember(&mut next, &at, decision.steer);
        *state = next.turned(&at);
        Ok((at, decision))
    }

    /// Length that turns an angle into a curvature, `tan(steer) / length` [m].
    #[inline]
    fn turning_length(&self, speed: f64) -> f64 {
        self.params.wheelbase + self.params.understeer * speed * speed
    }

    /// The state with what the way since the last step teaches.
    #[inline]
    fn learn(&self, path: &PathView<'_>, state: &PreviewPopState, at: &Located) -> PreviewPopState {
        let mut next = *state;
        if state.travel >= Self::LEAST_TRAVEL && !at.turned {
            let turned = wrap(at.vehicle.yaw - state.previous_yaw);
            next.turn_offset = learnt(
                state.turn_offset,
                (turned - state.turn) / state.travel,
                at.dt,
                self.params.turn_learning_time,
                Self::MAX_TURN_OFFSET,
            );
            (next.slip, next.slip_length) = if self.params.slip_learning_time > 0.0 {
                let heading = state.previous_yaw + 0.5 * turned;
                let aside = (at.vehicle.y - state.previous_y) * cos(heading)
                    - (at.vehicle.x - state.previous_x) * sin(heading);
                let mut turn = [0.0];
                let start = at.foot.arc_length(path) - state.travel;
                let smoothing = self.params.smoothing_length;
                Preview::new(path, smoothing, at.foot.segment, start, state.travel).turns(
                    start,
                    state.travel,
                    &mut turn,
                );
                let [turn] = turn;
                self.learn_slip(state, aside / state.travel, turn / state.travel, at.dt)
            } else {
                (0.0, 0.0)
            };
        }
        next
    }

    /// The slip, straight on and by curvature, after a period `dt` [s] in which the angle `sample`
    /// [rad] was seen: normalised least mean squares.
    ///
    /// The curvature is the path's, `bend` [1/m]. The vehicle's own answers to the errors of the
    /// position, which are in the sample too, and would be taken for slip.
    #[inline]
    fn learn_slip(&self, state: &PreviewPopState, sample: f64, bend: f64, dt: f64) -> (f64, f64) {
        let time = self.params.slip_learning_time;
        let most = self.params.wheelbase;
        let share = if dt < time { dt / time } else { 1.0 };
        let sample = saturate(sample, -4.0 * Self::MAX_SLIP, 4.0 * Self::MAX_SLIP);
        let missed = sample - (state.slip + state.slip_length * bend);
        let gain = share * missed / (Self::BEND * Self::BEND + bend * bend);
        (
            saturate(
                state.slip + gain * (Self::BEND * Self::BEND),
                -Self::MAX_SLIP,
                Self::MAX_SLIP,
            ),
            saturate(state.slip_length + gain * bend, -most, most),
        )
    }

    /// The best angle of the neighbourhood.
    #[inline]
    fn choose(&self, path: &PathView<'_>, state: &PreviewPopState, at: &Located) -> Decision {
        let (params, foot) = (&self.params, &at.foot);
        let reference_offset = self.body.follow.reference_offset;
        let speed = at.vehicle.forward_speed();
        let (count, period) = steps(params.horizon, at.dt);
        let pace = if speed > params.min_speed {
            speed
        } else {
            params.min_speed
        };
        let step = pace * period;
        let lag = params.steer_lag * speed;
        let kept = decay(step, lag);
        let offset = reference_offset + state.slip_length;
        let travel = Travel::new(step, lag, kept, offset);
        let length = self.turning_length(speed);
        let move_cost = params.steer_rate_cost * length / period;
        let move_cost = move_cost * move_cost;

        let mut turns = [0.0; MAX_STEPS];
        let turns = turns.get_mut(..count).unwrap_or_default();
        let arc_length = foot.arc_length(path);
        let distance = from_count(count) * step;
        let smoothing = params.smoothing_length;
        let path_yaw = Preview::new(path, smoothing, foot.segment, arc_length, distance)
            .turns(arc_length, step, turns);
        let gained = step * state.turn_offset;
        let drift = step * state.slip;
        let stage = CostToGo::stage(params.heading_cost, offset);
        let mut after = stage;
        let mut cost = stage;
        for turn in turns.iter().rev() {
            cost = after.before(&travel, turn - gained, drift);
            after = cost.before_best_move(move_cost, &stage);
        }

        // From afar the error counts only as far as it calls for the approach angle.
        let heading_error = wrap(at.vehicle.yaw - path_yaw);
        let most = params.approach_angle * cost.pc;
        let most = if most > 0.0 { most } else { 0.0 };
        let pull = saturate(foot.cross_track_error() * cost.ec, -most, most);
        let told = tan(state.previous_steer) / length;
        let slope =
            pull + heading_error * cost.pc + state.curvature * cost.ac + told * cost.cc + cost.c;
        // The lowest point of the parabola; a control period may be a part of the step.
        let wanted = told - slope / (move_cost + cost.cc) * (at.dt / period);
        self.limit(state.previous_steer, wanted, length, speed, at.dt)
    }

    /// The angle for a curvature, brought within the limits and the neighbourhood.
    #[inline]
    fn limit(
        &self,
        previous_steer: f64,
        curvature: f64,
        length: f64,
        speed: f64,
        dt: f64,
    ) -> Decision {
        let params = &self.params;
        let mut wanted = curvature;
        let mut status = Status::Ok;
        if wanted.abs() * speed * speed > params.max_lateral_acceleration {
            wanted = (params.max_lateral_acceleration / (speed * speed)).copysign(wanted);
            status = Status::Saturated;
        }
        let mut span = params.max_steer_rate * dt;
        if span > params.steer_span {
            span = params.steer_span;
        }
        if speed < params.min_speed {
            span *= speed / params.min_speed;
        }
        let steer = saturate(
            atan(wanted * length),
            previous_steer - span,
            previous_steer + span,
        );
        let (steer, limited) = self.body.limit(steer);
        if limited == Status::Saturated {
            status = limited;
        }
        Decision { steer, status }
    }

    /// Carries the model over the period that begins, under the angle decided on.
    #[inline]
    fn remember(&self, state: &mut PreviewPopState, at: &Located, steer: f64) {
        let speed = at.vehicle.forward_speed();
        let told = tan(steer) / self.turning_length(speed);
        let lag = self.params.steer_lag;
        let kept = decay(at.dt, lag);
        let excess = state.curvature - told;
        let distance = speed * at.dt;
        let teaches = speed >= self.params.min_speed;
        state.previous_steer = steer;
        state.travel = if teaches { distance } else { 0.0 };
        state.turn = told * distance + excess * (lag * (1.0 - kept) * speed);
        state.curvature = told + excess * kept;
        state.previous_x = at.vehicle.x;
        state.previous_y = at.vehicle.y;
        state.previous_yaw = at.vehicle.yaw;
    }
}

/// `value` after a period `dt` [s] in which `sample` was seen; `time` [s] to learn, 0 for never.
///
/// A sample counts up to four times the bound and the value keeps within it, so that neither a
/// jump of the localisation nor a fault that cannot be learnt winds it up.
#[inline]
fn learnt(value: f64, sample: f64, dt: f64, time: f64, bound: f64) -> f64 {
    if time <= 0.0 {
        return 0.0;
    }
    let share = if dt < time { dt / time } else { 1.0 };
    let sample = saturate(sample, -4.0 * bound, 4.0 * bound);
    saturate(value + share * (sample - value), -bound, bound)
}

impl PreviewPopState {
    /// The state of the turned vehicle as that of the vehicle itself, and the other way round: its
    /// wheels, and what it turns, are to the other side, and ahead is behind. Place and way are
    /// those seen.
    #[inline]
    fn turned(&self, at: &Located) -> Self {
        Self {
            previous_steer: at.turn(self.previous_steer),
            curvature: at.turn(self.curvature),
            turn_offset: at.turn(self.turn_offset),
            slip_length: at.turn(self.slip_length),
            ..*self
        }
    }
}

impl LateralState for PreviewPopState {
    /// Nothing is to be learnt of a jump.
    fn set_waypoint(&mut self, waypoint: Option<usize>) {
        self.waypoint = waypoint;
        self.travel = 0.0;
    }

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

    fn follow(&self) -> &Follow {
        &self.body.follow
    }

    fn max_steer(&self) -> f64 {
        self.body.max_steer
    }

    fn step(
        &self,
        path: &PathView<'_>,
        state: &mut PreviewPopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let (at, decision) = self.decide(path, state, vehicle, dt)?;
        Ok(command(&at, decision.steer, at.foot.point, decision.status))
    }

    fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut PreviewPopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<f64, InputError> {
        self.decide(path, state, vehicle, dt)
            .map(|(at, decision)| at.turn(decision.steer))
    }

    fn check_state(&self, path: &PathView<'_>, state: &PreviewPopState) -> Result<(), InputError> {
        check_waypoint(path, state.waypoint)?;
        check_steer("previous_steer", state.previous_steer, self.body.max_steer)?;
        for (field, value, bound) in [
            ("curvature", state.curvature, 1e7),
            ("previous_x", state.previous_x, MAX_COORDINATE),
            ("previous_y", state.previous_y, MAX_COORDINATE),
            ("previous_yaw", state.previous_yaw, MAX_YAW + PI),
            ("turn", state.turn, 1e15),
            ("turn_offset", state.turn_offset, Self::MAX_TURN_OFFSET),
            ("slip", state.slip, Self::MAX_SLIP),
            ("slip_length", state.slip_length, self.params.wheelbase),
        ] {
            input_in_range(field, value, -bound, bound)?;
        }
        input_in_range("travel", state.travel, 0.0, 1e7)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use proptest::prelude::*;

    /// Usual values, and those towards the ends of a range.
    fn within(low: f64, high: f64, usual: f64) -> impl Strategy<Value = f64> {
        prop_oneof![
            Just(usual),
            Just(low),
            Just(high),
            (0.0..1.0).prop_map(move |share: f64| low + share * (high - low)),
            (0.0..1.0).prop_map(move |share: f64| low + share.powi(9) * (high - low)),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_preview_pop_of_any_parameters_answers_numbers_within_the_limit(
            costs in (within(0.0, 1e3, 3.0), within(1e-3, 1e3, 0.25), within(1e-3, 1.5, 0.25)),
            times in (within(0.05, 100.0, 1.0), within(0.0, 1e6, 0.5), within(0.0, 10.0, 0.1)),
            vehicle in (within(1e-3, 1e3, 3.0), within(0.0, 1e3, 0.0), within(-1e3, 1e3, 0.0)),
            limits in (within(1e-3, 1.57, 1.22), within(1e-3, 1e6, 15.0), within(0.1, 1e3, 5.0)),
            speeds in proptest::collection::vec(within(-1e4, 1e4, 12.0), 6),
            spots in proptest::collection::vec(
                (within(-1e9, 1e9, 30.0), within(-1e9, 1e9, 2.0), within(-1e6, 1e6, 0.1)),
                6,
            ),
            periods in proptest::collection::vec(within(1e-6, 1e3, 0.05), 6),
            smoothing in within(0.0, 1e3, 2.0),
            closed: bool,
        ) {
            let law = PreviewPop::new(PreviewPopParams {
                heading_cost: costs.0,
                steer_rate_cost: costs.1,
                approach_angle: costs.2,
                horizon: times.0,
                turn_learning_time: times.1,
                slip_learning_time: times.1,
                steer_lag: times.2,
                wheelbase: vehicle.0,
                understeer: vehicle.1,
                reference_offset: Some(vehicle.2),
                max_steer: limits.0,
                max_lateral_acceleration: limits.1,
                min_speed: limits.2,
                smoothing_length: smoothing,
                ..PreviewPopParams::DEFAULT
            }).unwrap();
            let (x, y) = ([0.0, 30.0, 60.0, 61.0, 20.0], [0.0, 2.0, 0.0, 20.0, 20.0]);
            let path = Path::new(&x, &y, None, closed).unwrap();
            let view = path.view();
            let mut state = law.initial_state();
            for ((&speed, &(x, y, yaw)), &dt) in speeds.iter().zip(&spots).zip(&periods) {
                let vehicle = VehicleState { x, y, yaw, speed };
                let command = law.step(&view, &mut state, vehicle, dt).unwrap();
                prop_assert!(command.steer.abs() <= limits.0, "{command:?}");
                prop_assert_eq!(law.check_state(&view, &state), Ok(()));
            }
        }
    }
}
