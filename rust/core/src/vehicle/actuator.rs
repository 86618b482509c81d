//! What lies between a command and the wheels: dead time, a first-order lag, a rate limit.
//!
//! A law that steers by the vehicle of now while its last commands are still under way steers too
//! late. [`Actuator::predict`] rolls the vehicle forward through them, so that the law sees it as
//! it will be when the next command arrives.

use super::VehicleState;
use super::learning::Learnt;
use super::predict::kinematic_bicycle;
use crate::error::{ConfigError, InputError, config_in_range, input_in_range};
use crate::math::{ceil_to_count, exp, from_count, saturate, tan};

/// Parameters of [`Actuator`]; by default nothing comes between command and wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorParams {
    /// Time from a command to its first effect on the wheels [s].
    pub dead_time: f64,
    /// Time constant with which the wheels then follow it [s]; a lag of the yaw rate counts here
    /// as well.
    pub lag: f64,
    /// Fastest move of the wheels [rad/s]; none for no limit.
    pub max_rate: Option<f64>,
    /// Distance of the axles of the vehicle that is predicted [m].
    pub wheelbase: f64,
    /// Understeer of the vehicle that is predicted [s^2/m]: the yaw rate is
    /// `speed tan(steer) / (wheelbase + understeer speed^2)`.
    pub understeer: f64,
    /// Time over which is learnt, from the way of the vehicle, how much more it turns than the
    /// model says, how much longer the dead time is, and how its speed changes [s]; 0 never.
    pub learning_time: f64,
}

impl ActuatorParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        dead_time: 0.0,
        lag: 0.0,
        max_rate: None,
        wheelbase: 3.0,
        understeer: 0.0,
        learning_time: 0.0,
    };
}

impl Default for ActuatorParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How commands come to the wheels, and what the vehicle does meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    params: ActuatorParams,
}

/// Commands that are given but have not reached the wheels, oldest first, and the wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct UnderWay {
    /// Angle [rad] and how long it was commanded [s].
    commands: [(f64, f64); Self::CAPACITY],
    first: usize,
    count: usize,
    /// Angle of the wheels [rad].
    wheel: f64,
    learnt: Learnt,
}

impl UnderWay {
    /// The most commands under way; shorter ones are joined, see [`Actuator::elapse`].
    pub const CAPACITY: usize = 3 * Actuator::RESOLUTION + 4;

    /// The commands under way, oldest first: angle [rad] and duration [s].
    pub fn commands(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.count).map(|k| self.get(k))
    }

    /// Angle of the wheels [rad].
    pub fn wheel(&self) -> f64 {
        self.wheel
    }

    /// What the prediction has learnt.
    pub fn learnt(&self) -> &Learnt {
        &self.learnt
    }

    /// Forgets where the vehicle was last seen: nothing is learnt from the way to the next place.
    pub fn lose_sight(&mut self) {
        self.learnt.seen = None;
    }

    #[inline]
    fn place(&self, k: usize) -> usize {
        let place = self.first + k;
        if place < Self::CAPACITY {
            place
        } else {
            place - Self::CAPACITY
        }
    }

    #[inline]
    fn get(&self, k: usize) -> (f64, f64) {
        self.commands
            .get(self.place(k))
            .copied()
            .unwrap_or((self.wheel, 0.0))
    }

    #[inline]
    fn set(&mut self, k: usize, command: (f64, f64)) {
        let place = self.place(k);
        if let Some(entry) = self.commands.get_mut(place) {
            *entry = command;
        }
    }

    #[inline]
    fn push(&mut self, command: (f64, f64)) {
        self.set(self.count, command);
        self.count += 1;
    }

    #[inline]
    fn pop(&mut self) {
        self.first = self.place(1);
        self.count -= 1;
    }
}

impl Actuator {
    /// Commands are remembered apart down to this share of the dead time.
    const RESOLUTION: usize = 128;
    /// The longest step of the prediction [s].
    const STEP: f64 = 0.05;

    /// The actuator with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: ActuatorParams) -> Result<Self, ConfigError> {
        config_in_range("dead_time", params.dead_time, 0.0, 10.0)?;
        config_in_range("lag", params.lag, 0.0, 10.0)?;
        if let Some(rate) = params.max_rate {
            config_in_range("max_rate", rate, 1e-3, 1e6)?;
        }
        config_in_range("wheelbase", params.wheelbase, 1e-3, 1e3)?;
        config_in_range("understeer", params.understeer, 0.0, 1e3)?;
        config_in_range("learning_time", params.learning_time, 0.0, 1e6)?;
        Ok(Self { params })
    }

    /// The parameters.
    pub fn params(&self) -> &ActuatorParams {
        &self.params
    }

    /// The wheels at rest at the angle `steer` [rad], and that angle under way.
    pub fn settled(&self, steer: f64) -> UnderWay {
        let mut under_way = UnderWay {
            commands: [(0.0, 0.0); UnderWay::CAPACITY],
            first: 0,
            count: 0,
            wheel: steer,
            learnt: Learnt::default(),
        };
        if self.params.dead_time > 0.0 {
            under_way.push((steer, self.params.dead_time));
        }
        under_way
    }

    /// Commands under way as they were.
    ///
    /// # Errors
    ///
    /// [`InputError`] where this actuator could not have them: an angle beyond a quarter turn, a
    /// duration that is none, durations that do not come to the dead time, too many commands,
    /// what cannot be learnt.
    pub fn restore(
        &self,
        commands: impl ExactSizeIterator<Item = (f64, f64)>,
        wheel: f64,
        learnt: Learnt,
    ) -> Result<UnderWay, InputError> {
        let limit = core::f64::consts::FRAC_PI_2;
        let count = commands.len();
        if count > UnderWay::CAPACITY {
            return Err(InputError {
                field: "under_way",
                value: from_count(count),
                requirement: crate::error::Requirement::CountInRange(0, UnderWay::CAPACITY),
            });
        }
        let mut under_way = self.settled(input_in_range("wheel", wheel, -limit, limit)?);
        under_way.count = 0;
        under_way.learnt = learnt.checked(self.most_delay())?;
        let dead_time = self.params.dead_time + learnt.delay;
        let slack = 1e-9 * (1.0 + dead_time);
        let mut total = 0.0;
        for (steer, duration) in commands {
            input_in_range("under_way", steer, -limit, limit)?;
            input_in_range("under_way", duration, 0.0, dead_time + slack)?;
            under_way.push((steer, duration));
            total += duration;
        }
        input_in_range("under_way", total, dead_time - slack, dead_time + slack)?;
        Ok(under_way)
    }

    /// The angle to command where `wanted` is wanted `dt` [s] after `last`: within the rate.
    #[inline]
    pub fn limit(&self, last: f64, wanted: f64, dt: f64) -> f64 {
        match self.params.max_rate {
            None => wanted,
            Some(rate) => saturate(wanted, last - rate * dt, last + rate * dt),
        }
    }

    /// How far a learnt dead time may be from the one given [s].
    #[inline]
    fn most_delay(&self) -> f64 {
        0.5 * self.params.dead_time
    }

    /// What is known when `vehicle` is seen `dt` [s] after `last` was commanded: what was known,
    /// where nothing is to be learnt.
    #[inline]
    pub fn learn(&self, under_way: &UnderWay, last: f64, vehicle: VehicleState, dt: f64) -> Learnt {
        let learnt = under_way.learnt;
        let time = self.params.learning_time;
        if time <= 0.0 {
            return learnt;
        }
        let before = learnt.seen.map_or(vehicle.speed, |(_, speed)| speed);
        let speed = 0.5 * (before + vehicle.speed);
        let wheelbase = self.params.wheelbase + self.params.understeer * speed * speed;
        let (mut turn, mut wheel, mut gone) = (0.0, under_way.wheel, dt);
        for (steer, duration) in under_way.commands().chain([(last, dt)]) {
            let part = if duration < gone { duration } else { gone };
            turn += part * tan(self.follow(wheel, steer, 0.5 * part));
            wheel = self.follow(wheel, steer, part);
            gone -= part;
        }
        learnt.after(
            vehicle,
            turn * speed / wheelbase,
            dt,
            time,
            self.most_delay(),
        )
    }

    /// The vehicle as it will be when a command given now reaches the wheels, if its acceleration
    /// stays as `learnt`: rolled forward through the commands `under_way` and `last`, the one given
    /// `dt` [s] ago, by a kinematic bicycle whose wheels follow them with the lag.
    pub fn predict(
        &self,
        under_way: &UnderWay,
        last: f64,
        vehicle: VehicleState,
        dt: f64,
        learnt: &Learnt,
    ) -> VehicleState {
        let mut speed = vehicle.speed;
        let wheelbase = self.params.wheelbase + self.params.understeer * speed * speed;
        let wheelbase = wheelbase / learnt.gain();
        let (mut vehicle, mut wheel) = (vehicle, under_way.wheel);
        // What reached the wheels since the last step moved them, and the vehicle is where it is.
        let mut gone = arrived(under_way, dt, learnt);
        for (steer, duration) in under_way.commands().chain([(last, dt)]) {
            let part = if duration < gone { duration } else { gone };
            wheel = self.follow(wheel, steer, part);
            gone -= part;
            let left = duration - part;
            if left > 0.0 {
                let steps = from_count(ceil_to_count(left / Self::STEP));
                let step = left / steps;
                let mut done = 0.0;
                while done < steps {
                    let middle = self.follow(wheel, steer, 0.5 * step);
                    vehicle.speed = learnt.speed_after(speed, 0.5 * step);
                    vehicle = kinematic_bicycle(vehicle, middle, 0.0, wheelbase, step);
                    speed = learnt.speed_after(speed, step);
                    vehicle.speed = speed;
                    wheel = self.follow(wheel, steer, step);
                    done += 1.0;
                }
            }
        }
        vehicle
    }

    /// Lets `dt` [s] pass since `last` was commanded: it goes on its way, and the oldest commands
    /// reach the wheels, whose angle then is returned [rad]. Commands shorter than a 128th of the
    /// dead time are joined to their mean.
    pub fn elapse(&self, under_way: &mut UnderWay, last: f64, dt: f64) -> f64 {
        let learnt = under_way.learnt;
        self.elapse_learning(under_way, last, dt, learnt)
    }

    /// [`elapse`](Self::elapse) with what was `learnt` since: a dead time that is longer than it
    /// seemed keeps commands under way for longer.
    pub fn elapse_learning(
        &self,
        under_way: &mut UnderWay,
        last: f64,
        dt: f64,
        learnt: Learnt,
    ) -> f64 {
        let mut gone = arrived(under_way, dt, &learnt);
        under_way.learnt = learnt;
        let joined = self.params.dead_time / from_count(Self::RESOLUTION);
        let newest = under_way.count.checked_sub(1);
        match newest.map(|k| (k, under_way.get(k))) {
            Some((k, (steer, duration))) if duration + dt <= joined => {
                let total = duration + dt;
                let mean = (steer * duration + last * dt) / total;
                under_way.set(k, (mean, total));
            }
            _ => under_way.push((last, dt)),
        }
        while gone > 0.0 && under_way.count > 0 {
            let (steer, duration) = under_way.get(0);
            if duration > gone {
                under_way.wheel = self.follow(under_way.wheel, steer, gone);
                under_way.set(0, (steer, duration - gone));
                break;
            }
            under_way.wheel = self.follow(under_way.wheel, steer, duration);
            under_way.pop();
            gone -= duration;
        }
        under_way.wheel
    }

    /// The wheels from `wheel` after `time` [s] of the command `steer`.
    #[inline]
    fn follow(&self, wheel: f64, steer: f64, time: f64) -> f64 {
        let lag = self.params.lag;
        let reached = if lag > 0.0 {
            steer + (wheel - steer) * exp(-time / lag)
        } else {
            steer
        };
        if time > 0.0 {
            self.limit(wheel, reached, time)
        } else {
            wheel
        }
    }
}

/// For how long commands have reached the wheels in `dt` [s]: less where the dead time turns out
/// longer.
#[inline]
fn arrived(under_way: &UnderWay, dt: f64, learnt: &Learnt) -> f64 {
    dt - (learnt.delay - under_way.learnt.delay)
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn actuator(dead_time: f64, lag: f64, max_rate: Option<f64>) -> Actuator {
        Actuator::new(ActuatorParams {
            dead_time,
            lag,
            max_rate,
            ..ActuatorParams::DEFAULT
        })
        .unwrap()
    }

    #[test]
    fn test_elapse_brings_a_command_after_the_dead_time() {
        let actuator = actuator(0.2, 0.0, None);
        let mut under_way = actuator.settled(0.0);
        let wheels: Vec<f64> = (1..8)
            .map(|k| actuator.elapse(&mut under_way, 0.1 * f64::from(k), 0.05))
            .collect();
        let expected = [0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3];
        for (wheel, expected) in wheels.iter().zip(expected) {
            assert!((wheel - expected).abs() < 1e-12, "{wheels:?}");
        }
    }

    #[test]
    fn test_elapse_durations_always_come_to_the_dead_time() {
        let actuator = actuator(0.3, 0.1, None);
        let mut under_way = actuator.settled(0.2);
        let mut dt = 1e-6;
        for k in 0..100_000_u32 {
            dt = if k % 1000 == 0 {
                0.7
            } else {
                1e-6 + (dt * 7.3) % 0.004
            };
            actuator.elapse(&mut under_way, 0.001 * f64::from(k % 300), dt);
            let total: f64 = under_way.commands().map(|(_, duration)| duration).sum();
            assert!((total - 0.3).abs() < 1e-9, "{k} {total}");
        }
        let restored = actuator.restore(
            under_way.commands().collect::<Vec<_>>().into_iter(),
            under_way.wheel(),
            Learnt::default(),
        );
        assert!(restored.unwrap().commands().eq(under_way.commands()));
    }

    #[test]
    fn test_follow_lags_and_keeps_the_rate() {
        let lagging = actuator(0.0, 0.1, None);
        let wheel = lagging.elapse(&mut lagging.settled(0.0), 1.0, 0.1);
        assert!((wheel - (1.0 - exp(-1.0))).abs() < 1e-15);
        let slow = actuator(0.0, 0.0, Some(0.5));
        assert_eq!(slow.elapse(&mut slow.settled(0.0), 1.0, 0.1), 0.05);
        assert_eq!(slow.limit(0.2, -1.0, 0.1), 0.150_000_000_000_000_02);
    }

    #[test]
    fn test_predict_is_where_the_vehicle_comes_to_be() {
        let actuator = actuator(0.25, 0.1, None);
        // One line of commands as the law keeps it, and one as the vehicle has it.
        let (mut kept, mut real) = (actuator.settled(0.0), actuator.settled(0.0));
        let mut vehicle = VehicleState {
            x: 1.0,
            y: 2.0,
            yaw: 0.3,
            speed: 8.0,
        };
        let (mut last, mut predicted, mut driven) = (0.0, Vec::new(), Vec::new());
        for command in [0.1, -0.2, 0.3, 0.05, 0.1, 0.0, 0.1, 0.0, 0.2, 0.0] {
            if !driven.is_empty() {
                let nothing = Learnt::default();
                predicted.push(actuator.predict(&kept, last, vehicle, 0.05, &nothing));
                actuator.elapse(&mut kept, last, 0.05);
            }
            driven.push(vehicle);
            last = command;
            for _ in 0..50 {
                let wheel = actuator.elapse(&mut real, last, 0.001);
                vehicle = kinematic_bicycle(vehicle, wheel, 0.0, 3.0, 0.001);
            }
        }
        for (there, predicted) in driven.iter().skip(6).zip(&predicted) {
            assert!(
                (predicted.x - there.x).abs() < 2e-3,
                "{predicted:?} {there:?}"
            );
            assert!(
                (predicted.y - there.y).abs() < 2e-3,
                "{predicted:?} {there:?}"
            );
            assert!(
                (predicted.yaw - there.yaw).abs() < 2e-3,
                "{predicted:?} {there:?}"
            );
        }
    }
}
