//! What a vehicle waits for: at its stop, for its wheels and its gear; and what it keeps where its direction
//! or its path changes.

use crate::bounds::MAX_DT;
use crate::geometry::Point;
use crate::math::{larger, smaller};
use crate::path::PathView;
use crate::path::follow::Located;
use crate::path::preview::wheel_at_rest;
use crate::speed::law::limits::{MOVES, REST, SpeedLaw};
use crate::speed::law::situation::Situation;
use crate::speed::law::state::SpeedState;
use crate::speed::stops::{Planned, STANDSTILL};
use crate::vehicle::Drive;

/// How long a vehicle stands at a cusp until its gear changes [s], and for a gear that is not reported once
/// it rolled the wrong way. Less: it pulls before the gear is in. More: it waits.
const SHIFT: (f64, f64) = (0.3, 2.0);
/// A turn of the wheels that a start does not wait for [rad], and how many lags it waits for a turn.
const TURN: (f64, f64) = (0.02, 3.0);

impl SpeedLaw {
    /// Where the direction of driving changes, or a first step begins: what was commanded and found out
    /// in the other direction counts turned round, or not.
    pub(super) fn turn_round(
        &self,
        path: &PathView<'_>,
        at: &Located,
        state: &mut SpeedState,
        speed: f64,
    ) {
        let rolls = speed < -REST;
        state.passes = None;
        match state.reverse {
            Some(before) if before != at.reverse => {
                let observer = state.observer.turned();
                let drive = state.drive.filter(|_| !rolls);
                let wheels = path.section(at.closest.segment).and_then(|(first, _)| {
                    let end = path.previous(first)?;
                    Some(self.wheels(path, end, path.segment_end(end)))
                });
                *state = SpeedState {
                    acceleration: smaller(state.acceleration, 0.0),
                    drive: drive.or(Some(Drive::settled(&self.car, 0.0))),
                    observer,
                    wheels: wheels.or(Some(0.0)),
                    reverse: state.reverse,
                    rolls,
                    shifting: true,
                    servo: state.servo.turned(),
                    ..SpeedState::default()
                };
            }
            Some(_) => {}
            None => {
                state.drive = Some(Drive::settled(&self.car, 0.0));
                state.wheels = Some(0.0);
                state.rolls = rolls;
            }
        }
    }

    /// Whether the vehicle is held at its stop, or until its wheels are turned and its gear is in.
    pub(super) fn wait(
        &self,
        planned: &Planned<'_, '_>,
        state: &mut SpeedState,
        now: &Situation,
        at: &Located,
        (gear, halts): (Option<bool>, bool),
    ) {
        // One that is held at its stop and came to rest is, as long as its place does not show another thing;
        // one that is to stop anywhere, as long as noise may be what moves it.
        let stays = state.standing || (halts && now.speed.abs() < MOVES);
        let still = now.speed.abs() < now.rest || (stays && state.still > 0.0);
        if now.speed >= -now.rest {
            state.rolls = false;
        } else if state.rolls && state.reverse.is_some() {
            // So it did at the step before.
            state.shifting = true;
        }
        if now.speed > now.rest {
            state.shifting = false;
        }
        // A slope takes it back until its drive has built up: to 86 % in two lags.
        let back = larger(-now.answer.push, 0.0)
            * (self.car.drive_delay + 2.0 * self.car.drive_lag + at.dt);
        if gear == Some(at.reverse) {
            state.shifting = false;
        }
        if state.shifting && !state.rolls && now.speed < -now.rest - back {
            // It still rolls; or the drive moves it the wrong way, as its gear is not in.
            state.rolls = true;
            state.waits.1 = SHIFT.1;
        }
        state.still = if still {
            smaller(state.still + at.dt, MAX_DT)
        } else {
            0.0
        };
        let leaves = self.leaves();
        // The distance to the stop at which it would come to rest now.
        let short = now.stop.1 - now.then.travelled - self.way_to_rest(now, state.acceleration);
        let (moves, arrived) = (!still && now.speed > now.rest, self.arrived());
        let ends = now.then.speed <= 0.5 * self.accelerations.1 * self.end_time(at.dt);
        state.standing = match state.standing {
            true if moves => short <= 2.0 * arrived,
            true => now.stop.1 <= leaves,
            // At the end of the curve: before, what would bring it to rest sooner may yet change.
            false => !state.rolls && ends && now.stop.1.is_finite() && short <= arrived,
        };
        let before = state.wheels.take();
        if still {
            let turn = before.map_or(0.0, |angle| self.turn_time(planned.path, at, angle));
            state.waits.0 = larger(state.waits.0 - at.dt, turn);
            state.waits.1 = larger(state.waits.1 - at.dt, 0.0);
        } else if now.speed > now.rest {
            state.waits.0 = 0.0;
        }
        if let Some(reverse) = gear {
            state.waits.1 = if reverse == at.reverse {
                0.0
            } else {
                larger(state.waits.1, at.dt)
            };
        }
        let cusp = planned
            .end
            .zip(planned.end_stop(0.0))
            .filter(|_| state.standing && state.still >= SHIFT.0);
        state.passes = cusp.and_then(|(end, (waypoint, _))| {
            let is_here = state.stop.is_some_and(|(stop, _, _)| stop == waypoint);
            planned.path.next_segment(end).filter(|_| is_here)
        });
    }

    /// How long the wheels take from `angle` [rad] to that with which the path goes on [s].
    fn turn_time(&self, path: &PathView<'_>, at: &Located, angle: f64) -> f64 {
        let car = &self.car;
        if !car.steers_at_rest {
            return 0.0;
        }
        let closest = &at.closest;
        let turn = (self.wheels(path, closest.segment, closest.arc_length(path)) - angle).abs();
        if turn < TURN.0 {
            return 0.0;
        }
        let rate = car.max_steer_rate.unwrap_or(f64::INFINITY);
        smaller(car.dead_time + TURN.1 * car.steer_lag + turn / rate, MAX_DT)
    }

    /// The wheels' angle with which the vehicle goes on at `arc` [m] of a segment, as it really is [rad].
    fn wheels(&self, path: &PathView<'_>, segment: usize, arc: f64) -> f64 {
        let angle = wheel_at_rest(&self.car, path, segment, arc);
        if path.is_reverse(segment) {
            -angle
        } else {
            angle
        }
    }

    /// The path `new` replaces `old`, where the vehicle was beside segment `from` and is beside segment
    /// `to`. A stop that `new` has at the same place stays, whatever its waypoint; where it is gone, a
    /// vehicle at rest has another task, for which its wheels turn first. A path that is sent again is
    /// none: whoever plans in each cycle would never see it start.
    pub fn set_path(
        &self,
        state: &mut SpeedState,
        (old, from): (&PathView<'_>, usize),
        (new, to): (&PathView<'_>, usize),
    ) {
        state.passes = state.passes.filter(|&segment| segment < new.segments());
        let leaves = self.leaves();
        let Some((waypoint, (x, y), distance)) = state.stop.take() else {
            return;
        };
        let stops = |path: &PathView<'_>, index: usize| {
            let speed = path.speed().and_then(|speed| speed.get(index));
            let is_line = speed.is_some_and(|&speed| speed.abs() < STANDSTILL);
            let ends = index >= path.segments() || path.preceding(index).is_none();
            is_line || (ends && (index > 0 || path.is_closed()))
        };
        let stays = |&index: &usize| {
            let off = new.waypoint(index) - Point::new(x, y);
            stops(new, index) && off.dot(&off) <= leaves * leaves
        };
        // As many waypoints ahead as before, where several lie there.
        let near = |&index: &usize| (index + from).abs_diff(waypoint + to);
        let found = if stops(old, waypoint) {
            (0..new.len()).filter(stays).min_by_key(near)
        } else {
            None
        };
        if found.is_none() && (state.standing || state.waits.0 > 0.0) {
            state.wheels = Some(self.wheels(old, from, old.segment_end(from)));
        }
        state.stop = found.map(|index| (index, (x, y), distance));
        state.standing &= found.is_some();
    }
}
