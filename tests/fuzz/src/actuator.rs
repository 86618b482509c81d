//! What lies between commands and wheels, over a life of periods short and long.

use crate::bytes::Bytes;
use crate::scene::actuator;
use popsteer_core::VehicleState;
use popsteer_core::path::view::{MAX_COORDINATE, MAX_SPEED};
use popsteer_core::vehicle::state::{MAX_DT, MAX_YAW, MIN_DT};
use popsteer_core::vehicle::{Actuator, ActuatorParams, Learnt, UnderWay};
use std::f64::consts::FRAC_PI_2;

/// One life of one actuator.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let params = actuator(&mut bytes);
    let actuator = match Actuator::new(params) {
        Ok(actuator) => actuator,
        Err(error) => return assert!(!error.to_string().is_empty() && !valid(&params)),
    };
    assert!(valid(&params) && actuator.params() == &params);
    let start = angle(&mut bytes);
    let mut life = Life {
        under_way: actuator.settled(start),
        plain: Plain::new(params, start),
        actuator,
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

fn valid(params: &ActuatorParams) -> bool {
    (0.0..=10.0).contains(&params.dead_time)
        && (0.0..=10.0).contains(&params.lag)
        && params
            .max_rate
            .is_none_or(|rate| (1e-3..=1e6).contains(&rate))
        && (1e-3..=1e3).contains(&params.wheelbase)
        && (0.0..=1e3).contains(&params.understeer)
        && (0.0..=1e6).contains(&params.learning_time)
}

/// An angle of the wheels that a law may command.
fn angle(bytes: &mut Bytes) -> f64 {
    let angle = bytes.number([-1.0, 1.0], [-1.57, 1.57]);
    if angle.abs() <= 1.57 { angle } else { 0.1 }
}

fn drawn_vehicle(bytes: &mut Bytes) -> Option<VehicleState> {
    let vehicle = VehicleState {
        x: bytes.number([-50.0, 50.0], [-MAX_COORDINATE, MAX_COORDINATE]),
        y: bytes.number([-50.0, 50.0], [-MAX_COORDINATE, MAX_COORDINATE]),
        yaw: bytes.number([-4.0, 4.0], [-MAX_YAW, MAX_YAW]),
        speed: bytes.number([-5.0, 30.0], [-MAX_SPEED, MAX_SPEED]),
    };
    vehicle.checked().ok()
}

/// What might have been learnt, most often nothing.
fn drawn_learnt(bytes: &mut Bytes) -> Learnt {
    if bytes.byte() < 150 {
        return Learnt::default();
    }
    Learnt {
        seen: (bytes.byte() & 1 == 1).then(|| {
            let yaw = bytes.number([-4.0, 4.0], [-MAX_YAW, MAX_YAW]);
            (yaw, bytes.number([-5.0, 30.0], [-MAX_SPEED, MAX_SPEED]))
        }),
        acceleration: bytes.number([-5.0, 5.0], [-20.0, 20.0]),
        expected: bytes.number([0.0, 1.0], [0.0, 1e100]),
        measured: bytes.number([-1.0, 1.0], [-1e100, 1e100]),
        turn: bytes.number([-0.1, 0.1], [-1e100, 1e100]),
        change: bytes.number([0.0, 1.0], [0.0, 1e100]),
        delay: bytes.number([-0.05, 0.05], [-5.0, 5.0]),
    }
}

struct Life {
    actuator: Actuator,
    under_way: UnderWay,
    plain: Plain,
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
            150..=229 => self.actuator.params().dead_time * bytes.within(0.0, 1.5),
            _ => bytes.number([0.001, 0.5], [MIN_DT, MAX_DT]),
        };
        let dt = if (MIN_DT..=MAX_DT).contains(&dt) {
            dt
        } else {
            0.02
        };
        let vehicle = drawn_vehicle(bytes);
        self.check_predict(vehicle, dt);
        // So often that the room for commands comes round.
        let times = match bytes.byte() {
            place @ 250.. => place,
            _ => 1,
        };
        let wanted = angle(bytes);
        for k in 0..times {
            let wheel = self.elapse(vehicle, dt);
            assert_eq!(wheel.to_bits(), self.under_way.wheel().to_bits());
            if let Some(wanted) = self.plain.elapse(self.last, dt) {
                assert_eq!(wheel.to_bits(), wanted.to_bits());
            }
            self.last = self.check_limit(if k % 2 == 0 { wanted } else { -wanted }, dt);
        }
        self.check_under_way();
        if bytes.byte() < 40 {
            self.restore(bytes);
        }
    }

    /// Time goes on, and what the way of the vehicle teaches keeps within its bounds.
    fn elapse(&mut self, vehicle: Option<VehicleState>, dt: f64) -> f64 {
        let params = *self.actuator.params();
        let Some(vehicle) = vehicle.filter(|_| params.learning_time > 0.0) else {
            return self.actuator.elapse(&mut self.under_way, self.last, dt);
        };
        let learnt = self.actuator.learn(&self.under_way, self.last, vehicle, dt);
        assert_eq!(learnt.checked(0.5 * params.dead_time), Ok(learnt));
        assert!((0.5..=2.0).contains(&learnt.gain()));
        assert_eq!(learnt.seen, Some((vehicle.yaw, vehicle.speed)));
        self.actuator
            .elapse_learning(&mut self.under_way, self.last, dt, learnt)
    }

    fn check_limit(&mut self, wanted: f64, dt: f64) -> f64 {
        let steer = self.actuator.limit(self.last, wanted, dt);
        let most = self.actuator.params().max_rate.unwrap_or(f64::INFINITY) * dt;
        assert!((steer - self.last).abs() <= most + 1e-15 * (1.0 + most.min(1e9)));
        assert!((self.last.min(wanted)..=self.last.max(wanted)).contains(&steer));
        let near = (wanted - self.last).abs() <= most - 1e-12;
        assert!(!near || steer.to_bits() == wanted.to_bits());
        self.least = self.least.min(steer);
        self.most = self.most.max(steer);
        steer
    }

    /// What is under way lasts the dead time, and the wheels are where commands can bring them.
    fn check_under_way(&self) {
        let dead_time = self.actuator.params().dead_time + self.under_way.learnt().delay;
        let total: f64 = self
            .under_way
            .commands()
            .map(|(_, duration)| duration)
            .sum();
        assert!((total - dead_time).abs() <= 1e-9 * (1.0 + dead_time));
        assert!(self.under_way.commands().count() <= UnderWay::CAPACITY);
        let range = self.least - 1e-12..=self.most + 1e-12;
        assert!(range.contains(&self.under_way.wheel()));
        for (steer, duration) in self.under_way.commands() {
            assert!(range.contains(&steer) && duration >= 0.0);
        }
    }

    /// A state that was reached is accepted, and goes on alike.
    fn restore(&mut self, bytes: &mut Bytes) {
        let commands: Vec<_> = self.under_way.commands().collect();
        let wheel = self.under_way.wheel();
        let learnt = *self.under_way.learnt();
        let restored = self
            .actuator
            .restore(commands.iter().copied(), wheel, learnt);
        let restored = restored.expect("it was reached");
        assert!(restored.commands().eq(self.under_way.commands()));
        assert_eq!(restored.wheel().to_bits(), wheel.to_bits());
        assert_eq!(restored.learnt(), &learnt);
        self.under_way = restored;
        // One that was not reached tells the truth where it is refused.
        let made: Vec<_> = (0..bytes.below(5))
            .map(|_| {
                let whole = [0.0, 10.0];
                (
                    bytes.number([-1.0, 1.0], [-1.6, 1.6]),
                    bytes.number([0.0, 0.2], whole),
                )
            })
            .collect();
        let wheel = bytes.number([-1.0, 1.0], [-FRAC_PI_2, FRAC_PI_2]);
        let learnt = drawn_learnt(bytes);
        let given = self.actuator.params().dead_time;
        let dead_time = given + learnt.delay;
        let slack = 1e-9 * (1.0 + dead_time);
        let total = made.iter().fold(0.0, |sum, (_, duration)| sum + duration);
        let good = wheel.abs() <= FRAC_PI_2
            && made.iter().all(|&(steer, duration)| {
                steer.abs() <= FRAC_PI_2 && (0.0..=dead_time + slack).contains(&duration)
            })
            && (dead_time - slack..=dead_time + slack).contains(&total)
            && learnt.checked(0.5 * given).is_ok();
        let answer = self.actuator.restore(made.into_iter(), wheel, learnt);
        assert_eq!(answer.is_ok(), good);
    }

    fn check_predict(&self, vehicle: Option<VehicleState>, dt: f64) {
        let Some(vehicle) = vehicle else {
            return;
        };
        let learnt = self.actuator.learn(&self.under_way, self.last, vehicle, dt);
        let seen = self
            .actuator
            .predict(&self.under_way, self.last, vehicle, dt, &learnt);
        assert!(seen.x.is_finite() && seen.y.is_finite() && seen.yaw.is_finite());
        let ahead = 1.5 * self.actuator.params().dead_time + 1e-9;
        let gained = learnt.acceleration.abs() * ahead;
        let rounding = 1e-9 * (1.0 + gained + vehicle.speed.abs());
        assert!((seen.speed - vehicle.speed).abs() <= gained + rounding);
        let travel = (vehicle.speed.abs() + gained) * ahead;
        let (dx, dy) = (seen.x - vehicle.x, seen.y - vehicle.y);
        let slack = 1e-9 * (1.0 + travel + vehicle.x.abs() + vehicle.y.abs());
        assert!(dx.hypot(dy) <= travel + slack);
        if vehicle.speed.abs() + gained <= 0.0 {
            assert!(seen == vehicle);
        }
    }
}

/// The same by a plain list, as long as no commands are short enough to be joined.
struct Plain {
    params: ActuatorParams,
    list: Vec<(f64, f64)>,
    wheel: f64,
    joins: bool,
}

impl Plain {
    fn new(params: ActuatorParams, steer: f64) -> Self {
        let list = if params.dead_time > 0.0 {
            vec![(steer, params.dead_time)]
        } else {
            Vec::new()
        };
        Self {
            params,
            list,
            wheel: steer,
            // What is learnt shifts commands in time, and the plain list knows nothing of that.
            joins: params.learning_time > 0.0,
        }
    }

    /// The wheels after `dt` [s]; none from where commands are joined.
    fn elapse(&mut self, last: f64, dt: f64) -> Option<f64> {
        let shortest = self
            .list
            .last()
            .map_or(f64::INFINITY, |&(_, left)| left + dt);
        self.joins |= shortest <= self.params.dead_time / 128.0;
        if self.joins {
            return None;
        }
        self.list.push((last, dt));
        let mut gone = dt;
        while gone > 0.0 && !self.list.is_empty() {
            let (steer, duration) = self.list[0];
            let part = duration.min(gone);
            self.follow(steer, part);
            if duration > gone {
                self.list[0].1 = duration - gone;
            } else {
                self.list.remove(0);
            }
            gone -= part;
        }
        Some(self.wheel)
    }

    fn follow(&mut self, steer: f64, time: f64) {
        if time <= 0.0 {
            return;
        }
        let mut kept = 0.0;
        if self.params.lag > 0.0 {
            kept = (-time / self.params.lag).exp();
        }
        let mut reached = steer + (self.wheel - steer) * kept;
        if let Some(rate) = self.params.max_rate {
            reached = reached.clamp(self.wheel - rate * time, self.wheel + rate * time);
        }
        self.wheel = reached;
    }
}
