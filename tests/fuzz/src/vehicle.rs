//! The vehicle: its own figures, commands in flight to its wheels, what its motion shows of it, and
//! where it will be, over a life of periods short and long.

use crate::bytes::Bytes;
use crate::scene::{adapt, car, estimate, estimator, symmetric};
use popsteer_core::bounds::{MAX_COORDINATE, MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT};
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::vehicle::{AdaptParams, Estimate, Estimator, InFlight};
use popsteer_core::{Vehicle, VehicleState};
use std::f64::consts::{FRAC_PI_2, PI};

/// One life of one vehicle.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let drawn = car(&mut bytes);
    let car = match drawn.checked() {
        Ok(car) => car,
        Err(error) => {
            assert!(!error.to_string().is_empty() && !valid(&drawn));
            return check_refused(&drawn);
        }
    };
    assert!(valid(&drawn) && car == drawn);
    check_made(&car);
    let adapt = adapt(&mut bytes).checked().unwrap_or(AdaptParams::DEFAULT);
    let start = angle(&mut bytes, &car);
    let mut life = Life {
        in_flight: InFlight::settled(&car, start),
        plain: Plain::new(&car, start),
        estimator: Estimator::default(),
        car,
        adapt,
        last: start,
        least: start,
        most: start,
    };
    for _ in 0..40 {
        if bytes.is_empty() {
            break;
        }
        life.go_on(&mut bytes);
    }
}

fn valid(car: &Vehicle) -> bool {
    let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
    let optional =
        |value: Option<f64>, low, high| value.is_none_or(|value| within(value, low, high));
    within(car.wheelbase, 1e-3, 1e3)
        && within(car.rear_axle, -1e3, 1e3)
        && within(car.antenna_left, -1e2, 1e2)
        && optional(car.width, 1e-3, 1e2)
        && within(car.antenna_height, 0.0, 1e2)
        && optional(car.no_slip_point, -1e3, 1e3)
        && optional(car.turning_wheelbase, 1e-3, 1e3)
        && within(car.understeer, 0.0, 1e3)
        && within(car.steer_offset, -0.5, 0.5)
        && within(car.steer_lag, 0.0, 10.0)
        && within(car.dead_time, 0.0, 10.0)
        && within(car.max_steer, 1e-3, 1.57)
        && optional(car.max_steer_rate, 1e-3, 1e6)
        && within(car.steer_play, 0.0, 0.5)
        && optional(car.max_lateral_acceleration, 1e-3, 1e6)
        && optional(car.max_speed, 1e-3, 1e4)
        && optional(car.max_acceleration, 1e-3, 1e3)
        && optional(car.max_deceleration, 1e-3, 1e3)
        && optional(car.brake_deceleration, 1e-3, 1e3)
        && within(car.drive_delay, 0.0, 10.0)
        && within(car.drive_lag, 0.0, 10.0)
        && optional(car.stop_point, -1e3, 1e3)
}

/// No controller takes what is no vehicle.
fn check_refused(car: &Vehicle) {
    assert!(Pop::new(*car, PopParams::DEFAULT).is_err());
    assert!(PreviewPop::new(*car, PreviewPopParams::DEFAULT).is_err());
}

/// Every controller does with its defaults, which scale with the vehicle.
fn check_made(car: &Vehicle) {
    assert!(Pop::new(*car, PopParams::DEFAULT).is_ok());
    assert!(PreviewPop::new(*car, PreviewPopParams::DEFAULT).is_ok());
    assert!(PurePursuit::new(*car, PurePursuitParams::DEFAULT).is_ok());
    assert!(Stanley::new(*car, StanleyParams::DEFAULT).is_ok());
    assert!(Pid::new(*car, PidParams::DEFAULT).is_ok());
    assert!(car.front_axle() >= car.rear_axle && car.no_slip().is_finite());
    for speed in [0.0, 30.0, -MAX_SPEED] {
        let length = car.turning_length(speed);
        assert!(length > 0.0 && length.is_finite());
    }
}

/// An angle that a controller may command.
fn angle(bytes: &mut Bytes, car: &Vehicle) -> f64 {
    let angle = symmetric(bytes, car.max_steer.min(1.0), car.max_steer);
    if angle.abs() <= car.max_steer {
        angle
    } else {
        0.0
    }
}

fn drawn_state(bytes: &mut Bytes) -> Option<VehicleState> {
    let state = VehicleState {
        x: symmetric(bytes, 50.0, MAX_COORDINATE),
        y: symmetric(bytes, 50.0, MAX_COORDINATE),
        yaw: symmetric(bytes, 4.0, MAX_YAW),
        speed: bytes.number([-5.0, 30.0], [-MAX_SPEED, MAX_SPEED]),
    };
    state.checked().ok()
}

struct Life {
    car: Vehicle,
    adapt: AdaptParams,
    in_flight: InFlight,
    plain: Plain,
    estimator: Estimator,
    /// The angle last commanded, and what angles there have been.
    last: f64,
    least: f64,
    most: f64,
}

impl Life {
    fn go_on(&mut self, bytes: &mut Bytes) {
        let dt = match bytes.byte() {
            0..=99 => 0.05,
            100..=149 => bytes.within(1e-4, 0.01),
            150..=229 => self.car.dead_time * bytes.within(0.0, 1.5),
            _ => bytes.number([0.001, 0.5], [MIN_DT, MAX_DT]),
        };
        let dt = if (MIN_DT..=MAX_DT).contains(&dt) {
            dt
        } else {
            0.02
        };
        let state = drawn_state(bytes);
        // So often that the room for commands comes round.
        let times = match bytes.byte() {
            place @ 250.. => place,
            _ => 1,
        };
        let wanted = angle(bytes, &self.car);
        let turn = bytes.within(-PI, PI) * bytes.within(0.0, 1.0);
        for k in 0..times {
            let late = match state {
                Some(state) if self.plain.shifts => self.observe(state, turn, dt),
                _ => 0.0,
            };
            self.in_flight.elapse(&self.car, self.last, dt, late);
            if let Some(wheel) = self.plain.elapse(self.last, dt, late) {
                assert_eq!(wheel.to_bits(), self.in_flight.wheel().to_bits());
            }
            self.last = if k % 2 == 0 { wanted } else { -wanted };
            self.least = self.least.min(self.last);
            self.most = self.most.max(self.last);
        }
        self.check_in_flight();
        self.check_wheel(bytes, dt);
        if let Some(state) = state {
            self.check_predict(state);
        }
        match bytes.byte() {
            0..=39 => self.restore(bytes),
            40..=79 => self.plain.shifts = true,
            80..=99 => self.draw_estimator(bytes),
            _ => {}
        }
    }

    /// Whatever the motion, what it shows keeps within its bounds; how much later commands arrive.
    fn observe(&mut self, state: VehicleState, turn: f64, dt: f64) -> f64 {
        let before = self.estimator.estimate;
        let now = state.ahead(self.car.no_slip());
        let reached = self.in_flight.wheel_integrals(&self.car, self.last, dt);
        assert!(reached.turn.is_finite() && reached.slope.is_finite());
        assert!(reached.slope >= 0.0 && reached.slope + 1e-12 * dt >= reached.turn.abs());
        self.estimator
            .observe_turn(&self.adapt, &self.car, now, reached, dt);
        let before_speed = self.estimator.last_measured.map_or(0.0, |last| last.speed);
        let travel = 0.5 * (before_speed + now.speed) * dt;
        let bend = if travel.abs() > 0.0 {
            turn / travel
        } else {
            0.0
        };
        self.estimator
            .observe_slip(&self.adapt, &self.car, now, bend, dt);
        self.estimator.last_measured = Some(now);
        assert_eq!(self.estimator.checked(&self.car), Ok(self.estimator));
        let estimate = self.estimator.estimate;
        let turning = |estimate: &Estimate| (estimate.gain, estimate.steer_offset);
        assert!(self.adapt.turn_time > 0.0 || turning(&estimate) == turning(&before));
        let late = estimate.dead_time(&self.car) - before.dead_time(&self.car);
        assert!(late.abs() <= dt * (1.0 + 1e-12) + 1e-15);
        late
    }

    /// Commands in flight last the dead time, and the wheels are where commands can bring them.
    fn check_in_flight(&self) {
        let dead_time = self.estimator.estimate.dead_time(&self.car);
        let total: f64 = self
            .in_flight
            .commands()
            .map(|(_, duration)| duration)
            .sum();
        assert!((total - dead_time).abs() <= 1e-9 * (1.0 + dead_time));
        assert!(self.in_flight.commands().count() <= InFlight::CAPACITY);
        assert_eq!(self.in_flight.check(dead_time), Ok(()));
        for (steer, duration) in self.in_flight.commands() {
            assert!((self.least - 1e-12..=self.most + 1e-12).contains(&steer));
            assert!(duration >= 0.0);
        }
        let at_wheels = |steer: f64| self.car.at_wheels(steer + self.car.steer_offset);
        let range = at_wheels(self.least) - 1e-12..=at_wheels(self.most) + 1e-12;
        assert!(range.contains(&self.in_flight.wheel()));
    }

    /// The wheels move towards what is commanded, no faster than they can, alike in one go and two.
    fn check_wheel(&self, bytes: &mut Bytes, time: f64) {
        let car = &self.car;
        let (start, command) = (self.in_flight.wheel(), angle(bytes, car));
        let target = car.at_wheels(command + car.steer_offset);
        let moved = car.move_wheel(start, command, time);
        // What is left of the difference to 1 over a short time loses digits in the mean.
        let slack = 1e-9 + 16.0 * f64::EPSILON * car.steer_lag / time;
        let range = start.min(target) - slack..=start.max(target) + slack;
        assert!(range.contains(&moved.wheel) && range.contains(&moved.mean));
        let most = car.max_steer_rate.unwrap_or(f64::INFINITY) * time;
        assert!((moved.wheel - start).abs() <= most * (1.0 + 1e-9) + 1e-12);
        let share = bytes.within(0.0, 1.0);
        let half = car.move_wheel(start, command, share * time);
        let rest = car.move_wheel(half.wheel, command, (1.0 - share) * time);
        assert!(
            (rest.wheel - moved.wheel).abs() <= 1e-9,
            "{moved:?} {rest:?}"
        );
        let mean = share * half.mean + (1.0 - share) * rest.mean;
        assert!((mean - moved.mean).abs() <= slack, "{moved:?} {mean}");
        assert_eq!(
            car.move_wheel(start, command, 0.0).wheel.to_bits(),
            start.to_bits()
        );
    }

    fn draw_estimator(&mut self, bytes: &mut Bytes) {
        let mut drawn = estimator(bytes, self.car.wheelbase, self.car.dead_time);
        // The commands in flight go with the dead time as it is.
        drawn.estimate.longer_dead_time = self.estimator.estimate.longer_dead_time;
        if let Ok(drawn) = drawn.checked(&self.car) {
            self.plain.shifts = true;
            self.estimator = drawn;
        }
    }

    /// A state that was reached is accepted, and goes on alike.
    fn restore(&mut self, bytes: &mut Bytes) {
        let (car, wheel) = (&self.car, self.in_flight.wheel());
        let dead_time = self.estimator.estimate.dead_time(car);
        let commands: Vec<_> = self.in_flight.commands().collect();
        let restored = InFlight::restore(commands.iter().copied(), wheel, dead_time);
        let restored = restored.expect("it was reached");
        assert_eq!(restored, self.in_flight);
        self.in_flight = restored;
        // One that was not reached tells the truth where it is refused.
        let made: Vec<_> = (0..bytes.below(5))
            .map(|_| {
                (
                    symmetric(bytes, 1.0, 1.6),
                    bytes.number([0.0, 0.2], [0.0, 10.0]),
                )
            })
            .collect();
        let wheel = symmetric(bytes, 1.0, FRAC_PI_2);
        let dead_time = estimate(bytes, car.wheelbase, car.dead_time).dead_time(car);
        let slack = 1e-9 * (1.0 + dead_time);
        let total = made.iter().fold(0.0, |sum, (_, duration)| sum + duration);
        let good = wheel.abs() <= FRAC_PI_2
            && made.iter().all(|&(steer, duration)| {
                steer.abs() <= FRAC_PI_2 && (0.0..=dead_time + slack).contains(&duration)
            })
            && (dead_time - slack..=dead_time + slack).contains(&total);
        let answer = InFlight::restore(made.into_iter(), wheel, dead_time);
        assert_eq!(answer.is_ok(), good);
    }

    /// No prediction goes farther or turns more than the vehicle can.
    fn check_predict(&self, state: VehicleState) {
        let (car, estimate) = (&self.car, &self.estimator.estimate);
        let (seen, wheel) = self
            .in_flight
            .predict(car, state, self.in_flight.wheel(), estimate);
        assert!(seen.x.is_finite() && seen.y.is_finite() && seen.yaw.is_finite());
        assert!(wheel.abs() <= car.max_steer + 1e-12);
        assert_eq!(seen.bounded().checked(), Ok(seen.bounded()));
        let ahead = estimate.dead_time(car) + 1e-9;
        let gained = estimate.acceleration.abs() * ahead;
        let rounding = 1e-9 * (1.0 + gained + state.speed.abs());
        assert!((seen.speed - state.speed).abs() <= gained + rounding);
        assert!(seen.speed * state.speed >= 0.0 || state.speed.abs() <= 0.0);
        let travel = (state.speed.abs() + gained).min(MAX_SPEED) * ahead;
        let (dx, dy) = (seen.x - state.x, seen.y - state.y);
        let slack = 1e-9 * (1.0 + travel + state.x.abs() + state.y.abs());
        assert!(dx.hypot(dy) <= travel + slack);
        let length = car.turning_length(state.speed) / estimate.gain;
        let turned = travel * car.max_steer.tan() / length;
        assert!(
            (seen.yaw - state.yaw).abs() <= turned * (1.0 + 1e-9) + 1e-9 * (1.0 + state.yaw.abs())
        );
        if travel <= 0.0 {
            assert!(seen == state);
        }
    }
}

/// The same by a plain list, as long as no commands are short enough to be joined.
struct Plain {
    car: Vehicle,
    list: Vec<(f64, f64)>,
    wheel: f64,
    joins: bool,
    /// Whether the motion is observed, which shifts commands in time.
    shifts: bool,
}

impl Plain {
    fn new(car: &Vehicle, steer: f64) -> Self {
        let list = if car.dead_time > 0.0 {
            vec![(steer, car.dead_time)]
        } else {
            Vec::new()
        };
        Self {
            wheel: car.at_wheels(steer + car.steer_offset),
            car: *car,
            list,
            joins: false,
            shifts: false,
        }
    }

    /// The wheels after `dt` [s]; none from where commands are joined.
    fn elapse(&mut self, last: f64, dt: f64, late: f64) -> Option<f64> {
        let shortest = self
            .list
            .last()
            .map_or(f64::INFINITY, |&(_, remaining)| remaining + dt);
        self.joins |=
            shortest <= self.car.dead_time / 64.0 || self.list.len() >= InFlight::CAPACITY;
        if self.joins {
            return None;
        }
        self.list.push((last, dt));
        let mut gone = dt - late;
        while gone > 0.0 && !self.list.is_empty() {
            let (steer, duration) = self.list[0];
            let part = duration.min(gone);
            self.wheel = self.follow(steer, part);
            if duration > gone {
                self.list[0].1 = duration - gone;
            } else {
                self.list.remove(0);
            }
            gone -= part;
        }
        Some(self.wheel)
    }

    /// The response of the wheels, written out.
    fn follow(&self, steer: f64, time: f64) -> f64 {
        let most = self.car.max_steer;
        let (start, target) = (
            self.wheel,
            (steer + self.car.steer_offset).clamp(-most, most),
        );
        if time <= 0.0 {
            return start;
        }
        let approach = |start: f64, time: f64| {
            if self.car.steer_lag <= 0.0 {
                return target + (start - target) * 0.0;
            }
            target + (start - target) * (-time / self.car.steer_lag).exp()
        };
        let gap = target - start;
        let Some(rate) = self.car.max_steer_rate else {
            return approach(start, time);
        };
        if gap.abs() <= rate * self.car.steer_lag {
            return approach(start, time);
        }
        // At the rate as far as it goes.
        let knee = (rate * self.car.steer_lag).copysign(gap);
        let ramp = (gap - knee).abs() / rate;
        if ramp >= time {
            start + (rate * time).copysign(gap)
        } else {
            approach(target - knee, time - ramp)
        }
    }
}
