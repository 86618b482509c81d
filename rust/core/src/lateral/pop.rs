//! POP: proximally optimal predictive control, the paper's Algorithm 1.

use super::rollout::{Model, Rollout};
use super::{
    Body, Command, LateralLaw, LateralState, Status, Target, body_params, check_steer,
    check_waypoint, command, search_params,
};
use crate::Point;
use crate::error::{ConfigError, InputError, Requirement, config_in_range};
use crate::math::{PI, atan2, from_count, saturate, to_count, wrap};
use crate::path::follow::{Follow, Located};
use crate::path::view::{PathView, get_distance};
use crate::vehicle::VehicleState;
use crate::vehicle::predict::get_predicted_location;

/// Parameters of [`Pop`]; the paper's Table 1 by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PopParams {
    /// Velocity constant `k_v` [s]: `lookahead = min_lookahead + lookahead_gain speed`.
    pub lookahead_gain: f64,
    /// Lookahead at rest `ld_min` [m]; the published code's 6 m, the paper gives none.
    pub min_lookahead: f64,
    /// Optimization range `delta_nbd` [rad]: candidates lie at most this far from the last angle.
    pub steer_span: f64,
    /// Optimization resolution: the number of candidates, odd.
    pub candidate_count: usize,
    /// Whether the lookahead point is the path's first crossing of the circle ahead of the
    /// vehicle, [`get_crossing`](crate::path::lookahead::get_crossing), instead of what the
    /// paper's search finds.
    pub exact_lookahead: bool,
    /// Threshold `epsilon` of the paper's search [m].
    pub lookahead_tolerance: f64,
    /// Arc ahead of the vehicle that the paper's search looks at [m].
    pub window_ahead: f64,
    /// Greatest distance of neighbours on the path as the paper's search re-discretises it [m].
    pub grid_spacing: f64,
    /// How long a prediction by the kinematic bicycle with steering lag looks ahead [s]; none for
    /// the paper's, a point over one step. The vehicle should come about as far as the lookahead
    /// in it: where it does not, the law swings.
    pub horizon: Option<f64>,
    /// With a horizon, the understeer of the bicycle [s^2/m]:
    /// `yaw rate = speed tan(steer) / (wheelbase + understeer speed^2)`.
    pub understeer: f64,
    /// With a horizon, the time constant with which the wheels follow their command [s].
    pub steer_lag: f64,
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Reference point ahead of the rear axle [m]; the front axle, `wheelbase`, by default.
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

impl PopParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        lookahead_gain: 0.2,
        min_lookahead: 6.0,
        steer_span: 3.0 * (PI / 180.0),
        candidate_count: 21,
        exact_lookahead: true,
        lookahead_tolerance: 0.01,
        window_ahead: 20.0,
        grid_spacing: 0.01,
        horizon: None,
        understeer: 0.0,
        steer_lag: 0.1,
        wheelbase: 3.0,
        reference_offset: None,
        max_steer: 1.22,
        search_distance: None,
        lost_distance: None,
    };
}

impl Default for PopParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`Pop`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PopState {
    /// The waypoint at which the segment of the last foot starts; none before the first step.
    pub waypoint: Option<usize>,
    /// The last angle `delta_prev` [rad].
    pub previous_steer: f64,
    /// With a horizon, the angle of the wheels by the model [rad].
    pub model_steer: f64,
}

/// The POP controller: of the angles in the neighbourhood of the last one, the angle whose
/// predicted location lies closest to the lookahead point.
///
/// With one-step point prediction the wheelbase does not enter; it only places the reference
/// point. The last angle is looked at first and wins ties, so a vehicle at rest, where every
/// candidate predicts the same location, keeps its wheels still.
///
/// With a `horizon` the location is predicted by a bicycle with steering lag, under each candidate
/// held over it, and what counts is the place on the way that lies closest to the lookahead point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pop {
    body: Body,
    search: super::Search,
    model: Option<Model>,
    steer_span: f64,
    candidate_count: usize,
    /// Candidates on either side of the last angle.
    half: f64,
    /// Difference of neighbouring candidates [rad], and its inverse.
    step: f64,
    steps_per_rad: f64,
}

impl Pop {
    /// The largest number of candidates.
    pub const MAX_CANDIDATES: usize = 100_001;

    /// The law with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: PopParams) -> Result<Self, ConfigError> {
        let search = search_params!(params).checked()?;
        let steer_span = config_in_range("steer_span", params.steer_span, 1e-6, PI)?;
        let count = params.candidate_count;
        if count.is_multiple_of(2) || !(3..=Self::MAX_CANDIDATES).contains(&count) {
            return Err(ConfigError {
                field: "candidate_count",
                value: from_count(count),
                requirement: Requirement::OddInRange(3, Self::MAX_CANDIDATES),
            });
        }
        let body = Body::new(body_params!(params), params.wheelbase)?;
        let model = Model {
            // The numbers are checked, whether they count or not.
            horizon: params.horizon.unwrap_or(1.0),
            wheelbase: body.wheelbase,
            understeer: params.understeer,
            steer_lag: params.steer_lag,
            reference_offset: body.follow.reference_offset,
        }
        .checked()?;
        let half = from_count(count / 2);
        let step = steer_span / half;
        let steps_per_rad = 1.0 / step;
        Ok(Self {
            body,
            search,
            model: params.horizon.map(|_| model),
            steer_span,
            candidate_count: count,
            half,
            step,
            steps_per_rad,
        })
    }

    /// Algorithm 1 up to the choice of the angle.
    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<(Located, Target, f64), InputError> {
        let at = self.body.locate(path, state.waypoint, vehicle, dt)?;
        let speed = at.vehicle.forward_speed();
        let lookahead = self.search.min_lookahead + self.search.lookahead_gain * speed;
        let target = self.search.find(path, &at, lookahead);
        let to_target = target.point - at.position;
        let previous_steer = at.turn(state.previous_steer);
        let mut wheel = at.turn(state.model_steer);
        let steer = if let Some(model) = &self.model {
            let rollout = model.rollout(at.vehicle.yaw, speed, wheel, dt);
            let steer = self.choose_over_horizon(to_target, &rollout, previous_steer);
            (wheel, _) = self.body.limit(model.follow(wheel, steer, dt));
            steer
        } else {
            let here = VehicleState {
                x: 0.0,
                y: 0.0,
                yaw: at.vehicle.yaw,
                speed,
            };
            self.choose(to_target, here, previous_steer, dt)
        };
        *state = PopState {
            waypoint: Some(at.foot.segment),
            previous_steer: at.turn(steer),
            model_steer: at.turn(wheel),
        };
        Ok((at, target, steer))
    }

    /// The optimization of Algorithm 1, with the vehicle at the origin: distances are the same
    /// there, and no digits are lost far from it.
    #[inline]
    fn choose(&self, target: Point, vehicle: VehicleState, previous_steer: f64, dt: f64) -> f64 {
        self.choose_in_closed_form(target, vehicle, previous_steer, dt)
            .unwrap_or_else(|| self.choose_by_loop(target, vehicle, previous_steer, dt))
    }

    /// The loop of Algorithm 1: the definition of the law.
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

    /// The same loop with the vehicle's way over the horizon, instead of its location after a
    /// step.
    fn choose_over_horizon(&self, target: Point, rollout: &Rollout, previous_steer: f64) -> f64 {
        let range = get_distance(Point::new(0.0, 0.0), target);
        if rollout.spread(self.steer_span) <= 16.0 * f64::EPSILON * range {
            return previous_steer;
        }
        self.choose_nearest(previous_steer, |steer| {
            rollout.get_least_distance(steer, target)
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

    /// What the loop chooses, where that is certain; none where rounding could decide.
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
        // Near the opposite direction the cosine turns round within the list.
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
        (decided && candidate.abs() + step < self.body.max_steer).then_some(candidate)
    }

    /// Candidate `k` of `delta_list`: evenly over `previous_steer +- steer_span`, within the
    /// limit.
    #[inline]
    fn candidate(&self, previous_steer: f64, k: usize) -> f64 {
        let offset = self.steer_span * ((from_count(k) - self.half) / self.half);
        let max_steer = self.body.max_steer;
        saturate(previous_steer + offset, -max_steer, max_steer)
    }
}

impl LateralState for PopState {
    #[inline]
    fn set_waypoint(&mut self, waypoint: Option<usize>) {
        self.waypoint = waypoint;
    }

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

    fn follow(&self) -> &Follow {
        &self.body.follow
    }

    fn max_steer(&self) -> f64 {
        self.body.max_steer
    }

    fn step(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let (at, target, steer) = self.decide(path, state, vehicle, dt)?;
        let status = if !target.found {
            Status::LookaheadLost
        } else if steer.abs() >= self.body.max_steer {
            Status::Saturated
        } else {
            Status::Ok
        };
        Ok(command(&at, steer, target.point, status))
    }

    fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<f64, InputError> {
        self.decide(path, state, vehicle, dt)
            .map(|(at, _, steer)| at.turn(steer))
    }

    fn check_state(&self, path: &PathView<'_>, state: &PopState) -> Result<(), InputError> {
        check_waypoint(path, state.waypoint)?;
        check_steer("previous_steer", state.previous_steer, self.body.max_steer)?;
        check_steer("model_steer", state.model_steer, self.body.max_steer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, sin};
    use proptest::prelude::*;

    fn law(steer_span: f64, half: usize, max_steer: f64) -> Pop {
        Pop::new(PopParams {
            steer_span,
            candidate_count: 2 * half + 1,
            max_steer,
            ..PopParams::DEFAULT
        })
        .unwrap()
    }

    /// A bearing relative to the last wheel heading: anywhere, on a candidate, or half way
    /// between two, where they tie.
    fn bearings() -> impl Strategy<Value = (f64, f64)> {
        let nudge = prop_oneof![Just(0.0), -1e-15..1e-15, -1e-9..1e-9, -0.5..0.5];
        prop_oneof![
            (-3.2..3.2, Just(f64::NAN)),
            ((-30_i32..=30).prop_map(f64::from), nudge.clone()),
            ((-30_i32..=30).prop_map(|k| f64::from(k) + 0.5), nudge),
        ]
    }

    fn travels() -> impl Strategy<Value = f64> {
        prop_oneof![
            0.01..2.0,
            (-12.0..2.0).prop_map(|e| f64::powf(10.0, e)),
            Just(0.0)
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_choice_in_closed_form_is_that_of_the_loop(
            (place, nudge) in bearings(),
            travel in travels(),
            range in prop_oneof![1.0..20.0, (-6.0..4.0).prop_map(|e| f64::powf(10.0, e))],
            yaw in prop_oneof![-3.2..3.2, -1e6..1e6, Just(0.0)],
            previous in prop_oneof![-1.22..1.22, Just(0.0), Just(-0.0), Just(1.22), Just(-1.22)],
            span in prop_oneof![Just(3.0_f64.to_radians()), 1e-6..3.1],
            half in prop_oneof![Just(10_usize), 1_usize..60],
            max_steer in prop_oneof![Just(1.22), 0.01..1.57],
        ) {
            let law = law(span, half, max_steer);
            let previous = saturate(previous, -max_steer, max_steer);
            let step = span / from_count(half);
            let relative = if nudge.is_nan() { place } else { (place + nudge) * step };
            let bearing = yaw + previous + relative;
            let target = Point::new(range * cos(bearing), range * sin(bearing));
            let vehicle = VehicleState { x: 0.0, y: 0.0, yaw, speed: travel };
            if let Some(steer) = law.choose_in_closed_form(target, vehicle, previous, 1.0) {
                let by_loop = law.choose_by_loop(target, vehicle, previous, 1.0);
                prop_assert_eq!(steer.to_bits(), by_loop.to_bits());
            }
        }
    }

    #[test]
    fn test_closed_form_decides_in_plain_driving() {
        let law = law(3.0_f64.to_radians(), 10, 1.22);
        let vehicle = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed: 10.0,
        };
        let mut decided = 0;
        for k in 0..1000 {
            let bearing = -0.1 + 0.0002 * f64::from(k);
            let target = Point::new(8.0 * cos(bearing), 8.0 * sin(bearing));
            let steer = law.choose_in_closed_form(target, vehicle, 0.0, 0.05);
            decided += usize::from(steer.is_some());
        }
        assert!(decided > 990);
    }

    #[test]
    fn test_pop_at_rest_keeps_its_angle() {
        let law = law(3.0_f64.to_radians(), 10, 1.22);
        let path = crate::Path::new(&[0.0, 10.0, 20.0], &[0.0, 3.0, 0.0], None, false).unwrap();
        let mut state = PopState {
            previous_steer: 0.125,
            ..PopState::default()
        };
        let vehicle = VehicleState {
            x: 0.0,
            y: 1.0,
            yaw: 0.3,
            speed: 0.0,
        };
        for _ in 0..100 {
            assert_eq!(
                law.steer(&path.view(), &mut state, vehicle, 0.05),
                Ok(0.125)
            );
        }
    }
}
