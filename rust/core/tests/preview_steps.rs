//! Single steps of preview POP: the problem as `docs/preview_pop.md` states it, put together by hand
//! beside a straight path and solved by interior points; and with any parameters and any vehicle, driven
//! anywhere.

mod dense;
#[path = "limited/instance.rs"]
#[expect(dead_code, reason = "of the plans at random only the solver is used")]
mod instance;

use instance::{Instance, Random};
use popsteer_core::laws::preview_pop::cost_to_go::{BestMove, CostToGo, ModelState, Travel};
use popsteer_core::laws::preview_pop::limited::PlanLimits;
use popsteer_core::laws::{PreviewPop, PreviewPopParams};
use popsteer_core::vehicle::{AdaptParams, Estimate};
use popsteer_core::{Path, Reported, Status, Tracker, Vehicle, VehicleState};
use proptest::prelude::*;

/// A vehicle beside the x axis, what is known of it, and how it is to be steered.
#[derive(Debug)]
struct Scene {
    car: Vehicle,
    horizon: f64,
    span_rate: f64,
    heading_cost: f64,
    rate_cost: f64,
    approach_angle: f64,
    min_speed: f64,
    estimate: Estimate,
    speed: f64,
    error: f64,
    heading: f64,
    /// The last command [rad].
    steer: f64,
    dt: f64,
}

impl Scene {
    fn random(random: &mut Random) -> Self {
        let rate = random.of(&[None, None, Some(0.2), Some(0.5), Some(2.0)]);
        let most = random.of(&[None, None, Some(1.5), Some(4.0)]);
        let understeer = random.of(&[0.0, 0.004]);
        let offset = random.of(&[0.0, 0.03, -0.05]);
        let max_steer = random.of(&[0.5, 0.7]);
        let steer: f64 = random.uniform(-0.4, 0.4) * random.of(&[0.0, 0.3, 1.0, 1.0]);
        Self {
            car: Vehicle {
                turning_wheelbase: random.of(&[None, Some(3.4)]),
                understeer,
                steer_offset: offset,
                steer_lag: random.of(&[0.0, 0.1, 0.3]),
                max_steer,
                max_steer_rate: rate,
                max_lateral_acceleration: most,
                ..Vehicle::PAPER
            },
            horizon: random.of(&[0.3, 1.0, 1.5]),
            span_rate: random.of(&[0.3, 1.0, 20.0]),
            heading_cost: random.of(&[1.0, 3.0, 6.0]),
            rate_cost: random.of(&[0.1, 0.25, 1.0]),
            approach_angle: random.of(&[0.15, 0.25, 0.5]),
            min_speed: random.of(&[0.5, 5.0]),
            estimate: Estimate {
                // The horizon is that of the vehicle's own turning.
                gain: if rate.is_some() {
                    1.0
                } else {
                    random.of(&[1.0, 0.8, 1.2])
                },
                steer_offset: random.of(&[0.0, 0.01]),
                slip: random.of(&[0.0, 0.02]),
                slip_length: random.of(&[0.0, 0.5, -0.3]),
                ..Estimate::DEFAULT
            },
            speed: random.uniform(0.3, 15.0) * random.of(&[0.2, 1.0]),
            error: random.uniform(-1.0, 1.0) * random.of(&[0.05, 1.0, 4.0]),
            heading: random.uniform(-0.2, 0.2),
            steer,
            dt: random.of(&[0.02, 0.05, 0.05, 0.1]),
        }
    }

    fn tracker(&self) -> Tracker<PreviewPop> {
        let params = PreviewPopParams {
            horizon: self.horizon,
            steer_span_rate: Some(self.span_rate),
            heading_cost: Some(self.heading_cost),
            steer_rate_cost: Some(self.rate_cost),
            approach_angle: self.approach_angle,
            min_speed: Some(self.min_speed),
            ..PreviewPopParams::DEFAULT
        };
        let law = PreviewPop::new(self.car, params).unwrap();
        Tracker::new(law, Some(AdaptParams::DEFAULT)).unwrap()
    }

    /// What the tracker commands, and its status.
    fn step(&self) -> (f64, Status) {
        let tracker = self.tracker();
        let x: Vec<f64> = (-50..200).map(f64::from).collect();
        let path = Path::new(&x, &vec![0.0; x.len()], None, false).unwrap();
        let mut state = tracker.state_from(self.steer).unwrap();
        state.model.estimator.estimate = self.estimate;
        let vehicle = VehicleState {
            x: 0.3,
            y: self.error,
            yaw: self.heading,
            speed: self.speed,
        };
        let command = tracker
            .step(
                &path.view(),
                &mut state,
                vehicle,
                self.dt,
                Reported::NOTHING,
            )
            .unwrap();
        (command.steer, command.status)
    }

    fn at_wheels(&self, angle: f64) -> f64 {
        angle.clamp(-self.car.max_steer, self.car.max_steer)
    }

    /// Turning length at a speed [m].
    fn turning(&self, speed: f64) -> f64 {
        let base = self.car.turning_wheelbase.unwrap_or(self.car.wheelbase);
        base + self.car.understeer * speed * speed
    }

    /// The rate of the plan [rad/s], and how far the wheels turn in this period [rad].
    fn rate_and_span(&self) -> (f64, f64) {
        let own = self.car.max_steer_rate.unwrap_or(f64::INFINITY);
        let rate = own.min(self.span_rate);
        let slow = (self.speed / self.min_speed).min(1.0);
        if own > self.span_rate {
            // In proportion to the distance.
            return (rate, rate * slow * self.dt);
        }
        // The full rate down to half of `min_speed`, in proportion to the distance below. The
        // prediction covers a distance sooner than the vehicle by `slow`.
        let full = if slow < 0.5 { 2.0 * slow } else { 1.0 };
        (rate * full / slow, rate * full * self.dt)
    }

    /// The angle to be commanded, by the equations, and whether a limit of the vehicle holds it.
    fn expected(&self) -> (f64, Option<bool>) {
        let (car, known) = (&self.car, &self.estimate);
        let own = car
            .max_steer_rate
            .is_some_and(|rate| rate <= self.span_rate);
        let (rate, span) = self.rate_and_span();
        let pace = self.speed.max(self.min_speed);
        let length = self.turning(self.speed) / known.gain;
        // Longer where a wheelbase takes more than 0.6 s.
        let mut needed = self.horizon * (car.wheelbase / (0.6 * pace)).max(1.0);
        if let (true, Some(rate)) = (own, car.max_steer_rate) {
            let turn = (self.approach_angle * self.turning(pace) / (pace * rate)).sqrt();
            needed = needed.max(3.0 * car.steer_lag + 1.5 * turn);
        }
        let horizon = needed.min(2.0 * self.horizon);
        let count = (horizon / self.dt + 1e-6).floor().clamp(1.0, 20.0);
        let period = (horizon / count).max(self.dt);
        let step = pace * period;
        let lag = car.steer_lag * self.speed;
        let kept = if lag > 0.0 { (-step / lag).exp() } else { 0.0 };

        // The last angle, and that which the wheels have; both with what is known of the offset.
        let last = self.at_wheels(self.steer + car.steer_offset + known.steer_offset);
        let wheel = self.at_wheels(self.steer + car.steer_offset);
        let wheel = self.at_wheels(wheel + known.steer_offset);
        let own_lateral = |speed: f64| {
            let most = car.max_lateral_acceleration.unwrap_or(f64::INFINITY);
            most / (speed * speed)
        };
        let steepness = if own { 1.0 } else { 1.0 + last.tan().powi(2) };
        let offset = car.steer_offset + known.steer_offset;
        let end = |angle: f64| self.at_wheels(angle).tan() / length;
        let lateral = own_lateral(self.speed);
        let share = self.dt / period;
        let start = last.tan() / length;
        // Beyond the angles at which the tangent ends nothing is reached in a period.
        let first = |angle: f64| ((angle.clamp(-1.5, 1.5)).tan() / length - start) / share;
        let mut instance = Instance {
            travel: Travel::new(step, lag, kept, known.slip_length),
            stage: CostToGo::stage(self.heading_cost, known.slip_length),
            move_cost: (self.rate_cost * length / period).powi(2),
            turns: (0..20)
                .map(f64::from)
                .filter(|&k| k < count)
                .map(|_| 0.0)
                .collect(),
            start: ModelState {
                error: self.error,
                // The direction in which the vehicle moves.
                heading: self.heading + known.slip,
                driven: wheel.tan() / length,
                commanded: start,
            },
            limits: PlanLimits {
                first: (first(last - span), first(last + span)),
                later: rate * period * steepness / length,
                low: end(offset - car.max_steer).max(-lateral),
                high: end(offset + car.max_steer).min(lateral),
            },
            length,
        };
        // The error counts as far as its pull is that of the heading of the approach.
        let mut moves = [BestMove::default(); 20];
        let cost = instance
            .horizon()
            .unlimited(&mut moves[..instance.turns.len()]);
        let mut angle = self.approach_angle;
        if own || car.max_lateral_acceleration.is_some() {
            let per_metre = rate / (length * pace);
            let widest = (car.max_steer.tan() / length).min(own_lateral(pace));
            let bend = widest.min((angle * per_metre).sqrt());
            let turning = (0.5 * bend / per_metre + 2.0 * lag).min(cost.pc / cost.ec);
            // angle^2 / (2 bend) + angle turning = |error|
            let root = (turning * turning + 2.0 * self.error.abs() / bend).sqrt();
            angle = angle.min(bend * (root - turning));
        }
        let most = (angle * cost.pc).max(0.0);
        instance.start.error = (self.error * cost.ec).clamp(-most, most) / cost.ec;

        let moved = instance.by_interior_points()[0];
        let next = start + moved;
        let near = 1e-7 * instance.scale();
        let ends = next > instance.limits.high - near || next < instance.limits.low + near;
        let made = if ends { 1.0 } else { share };
        let wanted = ((start + moved * made) * length).atan();
        let angle = wanted.clamp(last - span, last + span);
        let (least, greatest) = instance.limits.first;
        let at_rate = moved > greatest - near || moved < least + near;
        let saturated = match (ends, at_rate) {
            (false, false) => Some(false),
            (false, true) => Some(own && self.speed >= 0.5 * self.min_speed),
            // Arriving at the largest curvature; held back from it is a matter of the rate.
            (true, _) if (wanted - angle).abs() < 1e-12 => Some(true),
            _ => None,
        };
        // What the tracker makes of it: the limits hold for every command, that of the rate last.
        let widest = (lateral * length).atan();
        let mut command = angle.clamp(-widest, widest) - offset;
        command = command.clamp(-car.max_steer, car.max_steer);
        if let Some(rate) = car.max_steer_rate {
            let span = rate * self.dt;
            command = command.clamp(self.steer - span, self.steer + span);
        }
        let limited = (command - (angle - offset)).abs() > 1e-9;
        (command, if limited { Some(true) } else { saturated })
    }
}

#[test]
fn test_step_commands_the_first_move_of_the_best_plan_within_the_limits() {
    let mut random = Random(21);
    let (mut free, mut held) = (0, 0);
    for n in 0..600 {
        let scene = Scene::random(&mut random);
        let (steer, status) = scene.step();
        let (expected, saturated) = scene.expected();
        let off = (steer - expected).abs();
        assert!(off < 1e-6, "{n}: {steer}, not {expected}: {scene:?}");
        if let Some(saturated) = saturated {
            if saturated {
                held += 1;
            } else {
                free += 1;
            }
            let found = status.contains(Status::SATURATED);
            assert_eq!(found, saturated, "{n}: {steer} {scene:?}");
        }
    }
    assert!(free > 100 && held > 50, "{free} {held}");
}

/// Beside the path for long, the wheels end where a limit of the vehicle has them: the command is
/// their angle less the offset, and both keep `max_steer`.
#[test]
fn test_wheels_held_by_a_limit_stand_at_it() {
    for (offset, most, left) in [
        (0.05, None, 0.25),
        (-0.05, None, 0.3),
        (0.0, Some(2.0), f64::atan(2.0 * 3.0 / 36.0)),
        (0.05, Some(2.0), f64::atan(2.0 * 3.0 / 36.0) - 0.05),
    ] {
        for side in [1.0, -1.0] {
            let car = Vehicle {
                steer_offset: side * offset,
                max_steer: 0.3,
                max_lateral_acceleration: most,
                ..Vehicle::PAPER
            };
            let law = PreviewPop::new(car, PreviewPopParams::DEFAULT).unwrap();
            let tracker = Tracker::new(law, None).unwrap();
            let path = Path::new(&[-10.0, 500.0], &[0.0; 2], None, false).unwrap();
            let mut state = tracker.initial_state();
            let vehicle = VehicleState {
                x: 0.0,
                y: side * -30.0,
                yaw: side * -1.2,
                speed: 6.0,
            };
            let mut command = None;
            for _ in 0..20 {
                command = tracker
                    .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
                    .ok();
            }
            let command = command.unwrap();
            assert!((command.steer - side * left).abs() < 1e-9, "{command:?}");
            assert!(command.status.contains(Status::SATURATED));
        }
    }
}

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
        car in (within(1e-3, 1e3, 3.0), within(0.0, 1e3, 0.0), within(-1e3, 1e3, 0.0)),
        limits in (within(1e-3, 1.57, 1.22), within(1e-3, 1e6, 15.0), within(0.1, 1e3, 5.0)),
        delay in (within(0.0, 10.0, 0.0), within(-0.5, 0.5, 0.0), within(1e-3, 1e6, 0.5)),
        speeds in proptest::collection::vec(within(-1e4, 1e4, 12.0), 6),
        spots in proptest::collection::vec(
            (within(-1e9, 1e9, 30.0), within(-1e9, 1e9, 2.0), within(-1e6, 1e6, 0.1)),
            6,
        ),
        periods in proptest::collection::vec(within(1e-6, 1e3, 0.05), 6),
        smoothing in within(0.0, 1e3, 2.0),
        closed: bool,
    ) {
        let car = Vehicle {
            wheelbase: car.0,
            understeer: car.1,
            no_slip_point: Some(car.2),
            steer_lag: times.2,
            dead_time: delay.0,
            steer_offset: delay.1,
            max_steer_rate: Some(delay.2),
            max_steer: limits.0,
            max_lateral_acceleration: Some(limits.1),
            ..Vehicle::DEFAULT
        };
        let law = PreviewPop::new(car, PreviewPopParams {
            heading_cost: Some(costs.0),
            steer_rate_cost: Some(costs.1),
            approach_angle: costs.2,
            horizon: times.0,
            min_speed: Some(limits.2),
            smoothing_length: Some(smoothing),
            ..PreviewPopParams::DEFAULT
        }).unwrap();
        let adapt = AdaptParams {
            turn_time: times.1,
            slip_time: times.1,
            ..AdaptParams::DEFAULT
        };
        let law = Tracker::new(law, Some(adapt)).unwrap();
        let (x, y) = ([0.0, 30.0, 60.0, 61.0, 20.0], [0.0, 2.0, 0.0, 20.0, 20.0]);
        let path = Path::new(&x, &y, None, closed).unwrap();
        let view = path.view();
        let mut state = law.initial_state();
        for ((&speed, &(x, y, yaw)), &dt) in speeds.iter().zip(&spots).zip(&periods) {
            let vehicle = VehicleState { x, y, yaw, speed };
            let command = law.step(&view, &mut state, vehicle, dt, Reported::NOTHING).unwrap();
            prop_assert!(command.steer.abs() <= limits.0, "{command:?}");
            prop_assert!(command.cross_track_error.is_finite(), "{command:?}");
            prop_assert!(command.predicted_cross_track_error.is_finite(), "{command:?}");
            prop_assert_eq!(law.check_state(&view, &state), Ok(()));
        }
    }
}
