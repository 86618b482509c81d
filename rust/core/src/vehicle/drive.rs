//! The drive: what throttle and brakes do with the accelerations that they are commanded.
//!
//! # Equations
//!
//! ```text
//! a' = (u(t - drive_delay) - a) / drive_lag
//! v' = a + w                                  w: gravity and what else pushes, constant meanwhile
//! ```
//!
//! A command is held until the next. While one holds for the time `h`, with `k = exp(-h / lag)`,
//!
//! ```text
//! a_h = u + (a - u) k
//! v_h = v + (u + w) h + (a - u) lag (1 - k)
//! s_h = s + v h + (u + w) h² / 2 + (a - u) lag (h - lag (1 - k))
//! ```
//!
//! Brakes that were found to give less than they are told ([`Bias`](crate::speed::bias)) have `(1 + g) u` for
//! each `u < 0`. Brakes hold: a vehicle that they bring to rest stays there. The commands in flight are those of
//! the last `drive_delay`; before them, those that an old measurement is rolled forward through.

use super::Vehicle;
use super::timed::Timed;
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{decay, from_count, larger, smaller};

/// The commands of the drive, oldest first, and what it gives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drive {
    /// Acceleration [m/s²] and how long it was commanded [s].
    commands: Timed<{ Drive::CAPACITY }>,
    /// What the drive gave when the oldest of them began to act [m/s²].
    start: f64,
    /// How far back the oldest measurement lay [s].
    reach: f64,
}

/// A vehicle along its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Acceleration by the drive [m/s²].
    pub pull: f64,
    /// Speed [m/s].
    pub speed: f64,
    /// Distance travelled [m].
    pub travelled: f64,
}

/// How a vehicle answers its drive, by what was found out.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// What else accelerates the vehicle [m/s²].
    pub push: f64,
    /// What the brakes give of what they are commanded.
    pub brakes: f64,
}

impl Answer {
    /// A drive as it is told, on a level road.
    const AS_TOLD: Self = Self {
        push: 0.0,
        brakes: 1.0,
    };

    /// What the drive gives of a command `u` [m/s²].
    #[inline]
    fn given(&self, u: f64) -> f64 {
        if u < 0.0 { self.brakes * u } else { u }
    }

    /// The command that makes the vehicle accelerate as `wanted` [m/s²]: brakes that give less are told more.
    #[inline]
    #[must_use]
    pub fn command(&self, wanted: f64) -> f64 {
        let given = wanted - self.push;
        if given < 0.0 {
            given / self.brakes
        } else {
            given
        }
    }
}

impl Motion {
    /// The motion after `time` [s] of the command `u` [m/s²], with the `push` [m/s²] and the `lag` [s].
    #[inline]
    #[must_use]
    pub fn after(self, u: f64, push: f64, lag: f64, time: f64) -> Self {
        let kept = decay(time, lag);
        let (off, share) = (self.pull - u, lag * (1.0 - kept));
        let gained = (u + push) * time + off * share;
        let pull = u + off * kept;
        let stops = u <= 0.0 && self.speed >= 0.0 && self.speed + gained < 0.0;
        if stops {
            // The mean deceleration until it rests.
            let way = 0.5 * self.speed * self.speed * time / larger(-gained, f64::MIN_POSITIVE);
            return Self {
                pull,
                speed: 0.0,
                travelled: self.travelled + smaller(way, self.speed * time),
            };
        }
        let way = self.speed * time + 0.5 * (u + push) * time * time + off * lag * (time - share);
        Self {
            pull,
            speed: self.speed + gained,
            travelled: self.travelled + way,
        }
    }
}

impl Drive {
    /// Commands are remembered apart down to this share of the time that they are remembered for.
    const RESOLUTION: usize = 64;
    /// The most commands that are remembered; shorter ones are joined.
    pub const CAPACITY: usize = 3 * Self::RESOLUTION + 4;
    /// The oldest measurement [s]: that of a pose, and a period.
    const MOST: f64 = 3e3;

    /// A drive that has given `pull` [m/s²] for long.
    pub fn settled(car: &Vehicle, pull: f64) -> Self {
        let mut drive = Self {
            commands: Timed::EMPTY,
            start: pull,
            reach: 0.0,
        };
        if car.drive_delay > 0.0 {
            drive.commands.push(pull, car.drive_delay);
        }
        drive
    }

    /// How long the commands last that have begun to act [s].
    fn acted(&self, car: &Vehicle) -> f64 {
        let total: f64 = self.commands.iter().map(|(_, time)| time).sum();
        larger(total - car.drive_delay, 0.0)
    }

    /// The time goes on by `dt` [s] under the command `last` [m/s²]; measurements from `age` [s] before
    /// its end are to be rolled forward. The mean of the commands that acted meanwhile, what the drive
    /// gives at the end, and the speed that it has given.
    pub fn elapse(&mut self, car: &Vehicle, last: f64, dt: f64, age: f64) -> (f64, Motion) {
        self.reach = larger(self.reach, age);
        let window = car.drive_delay + larger(self.reach, dt);
        let joined = if self.commands.is_full() {
            f64::INFINITY
        } else {
            window / from_count(Self::RESOLUTION)
        };
        self.commands.push_or_join(last, dt, joined);
        let now = self.acted(car);
        // Brakes hold only what does not roll back: so it counts what the drive gives in any case.
        let from = Motion {
            speed: -Self::MOST,
            ..Motion::default()
        };
        let (mean, mut moved) =
            self.roll(car, (now - smaller(dt, now), now), from, Answer::AS_TOLD);
        moved.speed += Self::MOST;
        let mut beyond = now + car.drive_delay - window;
        while beyond > 0.0
            && let Some((command, time)) = self.commands.take(beyond)
        {
            self.start = command + (self.start - command) * decay(time, car.drive_lag);
            beyond -= time;
        }
        (mean, moved)
    }

    /// A vehicle with the `speed` [m/s] of `age` [s] before, now: through what the drive has given since.
    pub fn since(&self, car: &Vehicle, speed: f64, answer: Answer, age: f64) -> Motion {
        let now = self.acted(car);
        let from = Motion {
            speed,
            ..Motion::default()
        };
        let known = smaller(age, now);
        let mut motion = self.roll(car, (now - known, now), from, answer).1;
        motion.travelled += (age - known) * speed;
        motion
    }

    /// The same when a command that is given now begins to act: through the commands in flight.
    pub fn predict(&self, car: &Vehicle, speed: f64, answer: Answer) -> Motion {
        let now = self.acted(car);
        let from = Motion {
            speed,
            ..Motion::default()
        };
        self.roll(car, (now, f64::INFINITY), from, answer).1
    }

    /// The vehicle `from` the time `begin` until `end`, since the oldest command began to act, and the
    /// mean of the commands.
    fn roll(
        &self,
        car: &Vehicle,
        (begin, end): (f64, f64),
        from: Motion,
        answer: Answer,
    ) -> (f64, Motion) {
        let mut motion = Motion {
            pull: answer.given(self.start),
            ..from
        };
        let (mut passed, mut sum, mut lasted) = (0.0, 0.0, 0.0);
        for (command, time) in self.commands.iter() {
            let command = answer.given(command);
            let before = smaller(larger(begin - passed, 0.0), time);
            let after = smaller(larger(end - passed, 0.0), time);
            passed += time;
            if before > 0.0 {
                motion.pull = command + (motion.pull - command) * decay(before, car.drive_lag);
            }
            let part = after - before;
            if part <= 0.0 {
                continue;
            }
            motion = motion.after(command, answer.push, car.drive_lag, part);
            sum += command * part;
            lasted += part;
        }
        let mean = if lasted > 0.0 {
            sum / lasted
        } else {
            motion.pull
        };
        (mean, motion)
    }

    /// Whether this is what a drive can have been commanded.
    ///
    /// # Errors
    ///
    /// [`InputError`] where a number is beyond `most`.
    pub(crate) fn check(&self, most: f64) -> Result<(), InputError> {
        for (command, time) in self.commands.iter() {
            input_within("drive.commands", command, most)?;
            input_in_range("drive.commands", time, 0.0, Self::MOST)?;
        }
        input_within("drive.start", self.start, most)?;
        input_in_range("drive.reach", self.reach, 0.0, Self::MOST).map(|_| ())
    }
}

impl Default for Drive {
    /// No command, of a drive without a delay.
    fn default() -> Self {
        Self {
            commands: Timed::EMPTY,
            start: 0.0,
            reach: 0.0,
        }
    }
}
