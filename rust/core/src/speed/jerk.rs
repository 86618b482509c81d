//! A plan whose accelerations change no faster than a jerk allows.
//!
//! # Method
//!
//! A plan within limits of the acceleration alone changes it at once. Where it then rises (from braking to
//! a steady speed, from that to driving) the speeds after are too high, and where it falls (from driving to
//! braking) those before:
//!
//! - A pass backward lowers each speed to what a deceleration comes down from that grows from 0, backward in
//!   time, by the jerk `J`; a pass forward does the same for driving. Over a segment of length `l`
//!
//! ```text
//! v t + a t² / 2 + J t³ / 6 = l,     v' = v + a t + J t² / 2,     a' = min(a + J t, limit)
//! ```
//!
//! - The mean speed over the time from `h` before to `h` after, `(s(t + h) - s(t - h)) / 2 h`, changes its
//!   acceleration over `2 h`: by the jerk where `h` is half of driving and braking, divided by `J`. Where the
//!   acceleration falls the mean is below the speed, by Jensen's inequality. The lesser of both is
//!   the plan; nowhere is it above the plan that it is made of.

use alloc::vec::Vec;

use crate::math::{larger, powf, remainder, smaller, sqrt};

/// Newton's steps to the time on a segment, from above: to the last digits.
const STEPS: usize = 12;

/// A plan along segments.
pub(super) struct Jerk<'a> {
    /// Length of each segment [m].
    pub spacing: &'a [f64],
    /// Whether the last waypoint leads back to the first.
    pub closed: bool,
    /// Largest driving acceleration and braking deceleration [m/s²].
    pub accelerations: (f64, f64),
    /// Largest change of the acceleration [m/s³].
    pub most: f64,
}

impl Jerk<'_> {
    /// Lowers the speeds [m/s] of a plan to those that keep the jerk.
    pub(super) fn limit(&self, speed: &mut [f64]) {
        let (driving, braking) = self.accelerations;
        let segments = self.spacing.len();
        let count = speed.len();
        // A closed path is gone round twice: the second time begins with what the first ends with.
        let rounds = if self.closed { 2 } else { 1 };
        for (ahead, most) in [(false, braking), (true, driving)] {
            let mut acceleration = 0.0;
            for step in 0..rounds * segments {
                let place = step % segments;
                let segment = if ahead { place } else { segments - 1 - place };
                let next = (segment + 1) % count;
                let (from, to) = if ahead {
                    (segment, next)
                } else {
                    (next, segment)
                };
                acceleration = self.pass(speed, (from, to, segment), acceleration, most);
            }
        }
        self.round_off(speed);
    }

    /// Lowers the speed at the waypoint `to` to what is reached from the waypoint `from` with an
    /// acceleration that grows from `acceleration`; the acceleration there.
    fn pass(
        &self,
        speed: &mut [f64],
        (from, to, segment): (usize, usize, usize),
        acceleration: f64,
        most: f64,
    ) -> f64 {
        let at = |index: usize| speed.get(index).copied().unwrap_or(0.0);
        let (start, end) = (at(from), at(to));
        if end <= start {
            return 0.0;
        }
        let length = self.length(segment);
        let time = self.time(start, acceleration, length);
        let reached = start + acceleration * time + 0.5 * self.most * time * time;
        let bound = sqrt(start * start + 2.0 * most * length);
        let reached = smaller(smaller(reached, bound), end);
        let mean = (reached * reached - start * start) / (2.0 * length);
        if let Some(value) = speed.get_mut(to) {
            *value = reached;
        }
        smaller(
            smaller(acceleration + self.most * time, 2.0 * mean - acceleration),
            most,
        )
        .max(0.0)
    }

    fn length(&self, segment: usize) -> f64 {
        self.spacing.get(segment).copied().unwrap_or(1.0)
    }

    /// The time over `length` [m] from `speed` [m/s] and `acceleration` [m/s²].
    fn time(&self, speed: f64, acceleration: f64, length: f64) -> f64 {
        let mut time = powf(6.0 * length / self.most, 1.0 / 3.0);
        if speed > 0.0 {
            time = smaller(time, length / speed);
        }
        for _ in 0..STEPS {
            let rate = speed + time * (acceleration + 0.5 * self.most * time);
            let way = time * (speed + time * (0.5 * acceleration + self.most * time / 6.0));
            let step = (way - length) / rate;
            if step.abs() <= 1e-15 * time {
                break;
            }
            time -= step;
        }
        time
    }

    /// Lowers the speeds to their mean over the time in which the jerk takes the acceleration from
    /// driving to braking.
    fn round_off(&self, speed: &mut [f64]) {
        let (driving, braking) = self.accelerations;
        let half = 0.5 * (driving + braking) / self.most;
        // One more than there are waypoints where the path is closed.
        let mut nodes: Vec<Node> = Vec::with_capacity(self.spacing.len() + 1);
        let mut node = Node::default();
        let count = speed.len();
        for (segment, &length) in self.spacing.iter().enumerate() {
            let at = |index: usize| speed.get(index % count).copied().unwrap_or(0.0);
            node.speed = at(segment);
            nodes.push(node);
            let sum = node.speed + at(segment + 1);
            // Between two stops, as fast as driving and braking allow.
            let slowest = sqrt(length * smaller(driving, braking));
            node.time += 2.0 * length / if sum > 0.0 { sum } else { slowest };
            node.place += length;
            node.speed = at(segment + 1);
        }
        nodes.push(node);
        for (value, node) in speed.iter_mut().zip(&nodes) {
            let ahead = self.place(&nodes, node.time + half);
            let behind = self.place(&nodes, node.time - half);
            *value = smaller(*value, larger(ahead - behind, 0.0) / (2.0 * half));
        }
    }

    /// Where the plan is at `time` [s]; beyond the ends of an open path it keeps its speeds there.
    fn place(&self, nodes: &[Node], time: f64) -> f64 {
        let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
            return 0.0;
        };
        let (mut time, mut offset) = (time, 0.0);
        if self.closed {
            let lap = remainder(time, last.time);
            let within = if lap < 0.0 { lap + last.time } else { lap };
            (time, offset) = (within, (time - within) / last.time * last.place);
        } else if time <= 0.0 {
            return time * first.speed;
        } else if time >= last.time {
            return last.place + (time - last.time) * last.speed;
        }
        let next = nodes.partition_point(|node| node.time <= time);
        let before = nodes.get(next.saturating_sub(1)).unwrap_or(first);
        let after = nodes.get(next).unwrap_or(last);
        let (span, since) = (after.time - before.time, time - before.time);
        if before.speed + after.speed > 0.0 {
            let gained = (after.speed - before.speed) / larger(span, f64::MIN_POSITIVE);
            return offset + before.place + since * (before.speed + 0.5 * gained * since);
        }
        let share = since / larger(span, f64::MIN_POSITIVE);
        // Up to the middle it speeds up, from there it slows down.
        let share = if share > 0.5 {
            1.0 - 2.0 * (1.0 - share) * (1.0 - share)
        } else {
            2.0 * share * share
        };
        offset + before.place + share * (after.place - before.place)
    }
}

/// A waypoint of the plan.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// Time since the first [s], and distance [m].
    time: f64,
    place: f64,
    /// Speed [m/s].
    speed: f64,
}
