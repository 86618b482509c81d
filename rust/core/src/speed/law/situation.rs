//! Where the vehicle is on its plan: rolled forward to when a command begins to act.

use crate::math::{larger, smaller, sqrt};
use crate::path::follow::Located;
use crate::speed::defaults::gravity_along;
use crate::speed::law::limits::SpeedLaw;
use crate::speed::law::state::SpeedState;
use crate::speed::stops::Planned;
use crate::vehicle::{Answer, Drive, Motion};

/// Halvings of the time to rest: to 1e-6 of it.
const HALVINGS: usize = 20;

/// The vehicle on its plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Situation {
    /// `v` [m/s], and how slow is at rest in its noise.
    pub speed: f64,
    pub rest: f64,
    /// `w`, and what the brakes give.
    pub answer: Answer,
    /// Distance to the next stop as measured, and `D` [m]; infinite if there is none.
    pub stop: (f64, f64),
    /// The vehicle when the command begins to act.
    pub then: Motion,
    /// `y` [m] and `z` [m/s].
    pub y: f64,
    pub z: f64,
    /// `z*` [m/s] and its change in time [m/s²].
    pub target: f64,
    pub change: f64,
    /// `sqrt(w(s))`, at least the creeping speed [m/s].
    pub reference: f64,
}

impl Situation {
    /// The deceleration with which the vehicle comes to rest `beyond` its stop [m/s²].
    pub(super) fn deceleration(&self, beyond: f64) -> f64 {
        let room = self.y + beyond;
        if self.z <= 0.0 {
            0.0
        } else if room <= 0.0 {
            f64::INFINITY
        } else {
            self.z * self.z / (2.0 * room)
        }
    }
}

impl SpeedLaw {
    /// Where the vehicle is on its plan, and what the plan wants there; brings the estimates of
    /// `state` up to date.
    pub(super) fn situation(
        &self,
        planned: &Planned<'_, '_>,
        at: &Located,
        state: &mut SpeedState,
        (measured, age, noise): (f64, f64, (f64, f64)),
    ) -> Situation {
        let (car, dt) = (&self.car, at.dt);
        let arc = at.closest.arc_length(planned.path);
        let plan = planned.at(arc);
        let known = gravity_along(plan.grade);
        let mut drive = state.drive.unwrap_or(Drive::settled(car, 0.0));
        let (mean, given) = drive.elapse(car, state.acceleration, dt, age);
        let answer = state.observer.answer(known);
        let measured = drive.since(car, measured, answer, age).speed;
        state.drive = Some(drive);
        let time = self.params.disturbance_time;
        let spread = (noise.1, time, self.accelerations.1);
        let heard = state.observer.hear(measured, known, given, spread, dt);
        let (speed, rest) = (heard.believed, heard.rest);
        // Brakes that hold say nothing.
        let held = state.rolls || (speed.abs() < rest && given.pull <= 0.0);
        let full = state.acceleration + answer.push > 0.5 * self.accelerations.0;
        let response = car.drive_delay + car.drive_lag;
        let model = (car.drive_lag, time, self.accelerations.1, response);
        let acted = (mean, given, state.acceleration);
        state.observer.step(&heard, acted, (held, full), model, dt);
        if held && !(state.rolls || state.is_held()) {
            // What is believed to push must not keep it from its stop.
            state.observer.fade(time, dt);
        }

        let stop = self.stop_ahead(planned, at, state, (speed, noise.0));
        let answer = state.observer.answer(known);
        let push = answer.push;
        let then = drive.predict(car, speed, answer);
        let lag = car.drive_lag;
        // One that its brakes hold has no acceleration.
        let gains = if then.speed > 0.0 {
            then.pull + push
        } else {
            larger(then.pull + push, 0.0)
        };
        let z = then.speed + lag * gains;
        let ahead = then.travelled + lag * then.speed;
        let y = stop.1 - ahead;
        // What brakes for its stop does so until that is farther off by more than noise.
        let near = if state.stopping {
            self.jump(noise.0)
        } else {
            0.0
        };
        let (target, change, stopping) = self.target(planned, arc + ahead, (y, near), z, dt);
        state.stopping = stopping;
        Situation {
            speed,
            rest,
            answer: state
                .observer
                .answer(gravity_along(planned.at(arc + ahead).grade)),
            stop,
            then,
            y,
            z,
            target,
            change,
            reference: larger(
                sqrt(plan.squared),
                smaller(self.creep(&plan), self.curve(stop.1, dt).0),
            ),
        }
    }

    /// How the drive has moved a vehicle in the `age` [s] until the end of the period `dt` [s] that this step
    /// ends, after the `speed` [m/s]; backwards all of it is negative.
    pub(crate) fn moved(&self, state: &SpeedState, speed: f64, age: f64, dt: f64) -> Motion {
        let Some(mut drive) = state.drive else {
            return Motion {
                pull: 0.0,
                speed,
                travelled: speed * age,
            };
        };
        drive.elapse(&self.car, state.acceleration, dt, age);
        let gear = state.gear();
        let along = drive.since(&self.car, gear * speed, state.observer.answer(0.0), age);
        Motion {
            pull: gear * along.pull,
            speed: gear * along.speed,
            travelled: gear * along.travelled,
        }
    }

    /// What is believed of a `speed` signal [m/s] with a `noise` of this standard deviation, so many seconds
    /// after the `last`.
    pub(crate) fn hear(
        &self,
        state: &SpeedState,
        speed: f64,
        last: Option<f64>,
        noise: (f64, f64),
    ) -> f64 {
        let Some(last) = last else {
            return speed;
        };
        let expected = state.gear() * state.observer.speed.unwrap_or(last);
        self.car.believed_speed(speed, last, expected, noise)
    }

    /// The mean acceleration [m/s²] in the `dt` [s] since the last step, by what the drive was commanded, of
    /// a vehicle that had the `speed` [m/s]; both are negative backwards. Brakes hold one at rest, and bring
    /// one to rest that rolls against its gear.
    pub(crate) fn expected(&self, state: &SpeedState, speed: f64, dt: f64) -> f64 {
        let gear = state.gear();
        let pulls = gear * (self.moved(state, speed, dt, dt).speed - speed) / dt;
        let (along, push) = (gear * speed, state.observer.answer(0.0).push);
        if along > 0.0 || pulls >= smaller(push, 0.0) {
            gear * pulls
        } else if along < 0.0 {
            gear * smaller(2.0 * push - pulls, -along / dt)
        } else {
            0.0
        }
    }

    /// How far the vehicle goes until it rests [m], from when the command begins to act, if it brakes with
    /// the planned deceleration, to which the `last` command [m/s²] changes within the jerk.
    pub(super) fn way_to_rest(&self, now: &Situation, last: f64) -> f64 {
        let (from, lag) = (now.then, self.car.drive_lag);
        if from.speed <= 0.0 {
            return 0.0;
        }
        let braking = self.accelerations.1;
        let (push, command) = (now.answer.push, -braking - now.answer.push);
        let ramp = 0.5 * larger(last - command, 0.0) / self.params.max_jerk;
        let longest = (from.speed + lag * larger(from.pull - command, 0.0)) / braking;
        let (mut low, mut high) = (0.0, longest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let rests = from.after(command, push, lag, middle).speed <= 0.0;
            (low, high) = if rests { (low, middle) } else { (middle, high) };
        }
        let rest = Motion {
            travelled: 0.0,
            ..from
        }
        .after(command, push, lag, low);
        rest.travelled + from.speed * ramp
    }
}
