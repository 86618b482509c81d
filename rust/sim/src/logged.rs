//! The wheels along the log of a drive, and filters over its samples, for the identification.

use popsteer_core::vehicle::Vehicle;

use crate::plant::behind_play;

/// A shorter lag is none [s]: far shorter than the step by which a derivative is taken.
const NO_LAG: f64 = 1e-7;

/// The wheels under the commands [rad] of a log, in the time of the commands: without dead time.
///
/// Exact between commands: they turn at the limited `rate` [rad/s] until the first-order response
/// of `lag` [s] is slower, and respond from there. A command begins at its time [s], and the last
/// one holds for ever; before the first the wheels stand as it asks.
#[derive(Debug, Clone)]
pub struct LoggedWheels {
    times: Vec<f64>,
    commands: Vec<f64>,
    lag: f64,
    rate: Option<f64>,
    angles: Vec<f64>,
    turning: Vec<f64>,
    /// Integrals of the angle from the first command to each.
    totals: Vec<f64>,
}

/// The wheels at a time: the angle [rad], and its integral from the first command on [rad s].
#[derive(Debug, Clone, Copy)]
struct Turned {
    time: f64,
    angle: f64,
    total: f64,
}

impl LoggedWheels {
    /// The wheels under `commands` that begin at `times`, which are as many and rise.
    pub fn new(times: Vec<f64>, commands: Vec<f64>, lag: f64, rate: Option<f64>) -> Self {
        let lag = lag.max(NO_LAG);
        let vehicle = Vehicle {
            steer_lag: lag,
            max_steer_rate: rate,
            ..Vehicle::DEFAULT
        };
        let count = times.len().min(commands.len());
        let mut wheels = Self {
            times,
            commands,
            lag,
            rate,
            angles: Vec::with_capacity(count),
            turning: Vec::with_capacity(count),
            totals: Vec::with_capacity(count),
        };
        let (mut angle, mut total) = (wheels.commands.first().copied().unwrap_or(0.0), 0.0);
        for place in 0..count {
            let (command, begin) = (wheels.commands[place], wheels.times[place]);
            let step = wheels
                .times
                .get(place + 1)
                .map_or(f64::INFINITY, |next| next - begin);
            let ramp = rate.map_or(0.0, |rate| (command - angle).abs() / rate - lag);
            wheels.angles.push(angle);
            wheels.turning.push(ramp.max(0.0).min(step));
            wheels.totals.push(total);
            if step.is_finite() {
                total += wheels.since(place, step).1;
                angle = vehicle.turn_wheel(angle, command, step).wheel;
            }
        }
        wheels
    }

    /// When the commands begin [s].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The commands [rad].
    pub fn commands(&self) -> &[f64] {
        &self.commands
    }

    /// The lag [s].
    pub fn lag(&self) -> f64 {
        self.lag
    }

    /// The limit of the rate [rad/s].
    pub fn rate(&self) -> Option<f64> {
        self.rate
    }

    /// The angle at the beginning of each command [rad].
    pub fn angles(&self) -> &[f64] {
        &self.angles
    }

    /// For how long the rate is limited from the beginning of each command on [s].
    pub fn turning(&self) -> &[f64] {
        &self.turning
    }

    /// The angle at these times [rad].
    pub fn at(&self, times: &[f64]) -> Vec<f64> {
        self.along(times, 0.0).map(|each| each.angle).collect()
    }

    /// The integral of the angle from the first command to these times [rad s].
    pub fn integral(&self, times: &[f64]) -> Vec<f64> {
        self.along(times, 0.0).map(|each| each.total).collect()
    }

    /// The integral from the first of `edges` [s] to each of the angle behind `play` [rad s].
    ///
    /// The commands come late by `dead_time` [s], ask for `scale` times their angle, and `offset`
    /// [rad] more. The steering turns back only where a command begins: between those, and the
    /// edges, it pushes one way.
    pub fn behind_play(
        &self,
        edges: &[f64],
        dead_time: f64,
        scale: f64,
        offset: f64,
        play: f64,
    ) -> Vec<f64> {
        let Some(first) = edges.first() else {
            return Vec::new();
        };
        let begins = |place: usize| self.times.get(place).map(|time| time + dead_time);
        let mut next = self
            .times
            .partition_point(|time| time + dead_time <= *first);
        let mut before: Option<(Turned, f64, f64)> = None;
        let (mut sum, mut sums) = (0.0, Vec::with_capacity(edges.len()));
        let mut push = |now: Turned| {
            let steer = scale * now.angle + offset;
            let mut wheel = steer;
            if let Some((earlier, steered, held)) = before {
                wheel = behind_play(held, steer, play);
                let (step, moved) = (now.time - earlier.time, wheel - held);
                let mean = scale * (now.total - earlier.total) / step + offset;
                let off = 0.5 * moved + mean - 0.5 * (steer + steered);
                // Of the time for which it pushes.
                let share = if moved == 0.0 {
                    0.0
                } else {
                    moved / (steer - steered)
                };
                sum += (held + share * off) * step;
            }
            before = Some((now, steer, wheel));
            sum
        };
        for edge in self.along(edges, dead_time) {
            while let Some(time) = begins(next).filter(|time| *time < edge.time) {
                let (angle, total) = (self.angles[next], self.totals[next]);
                push(Turned { time, angle, total });
                next += 1;
            }
            next += usize::from(begins(next).is_some_and(|time| time <= edge.time));
            sums.push(push(edge));
        }
        sums
    }

    /// The angle and its integral, `time` [s] after the beginning of a command.
    fn since(&self, place: usize, time: f64) -> (f64, f64) {
        let (begun, target) = (self.angles[place], self.commands[place]);
        let ramp = time.min(self.turning[place]);
        let turn = self.rate.map_or(0.0, |rate| rate.copysign(target - begun));
        let (gap, rest) = (target - (begun + turn * ramp), time - ramp);
        let done = -(-rest / self.lag).exp_m1();
        let ramped = begun * ramp + 0.5 * turn * ramp * ramp;
        let responded = target * rest - gap * self.lag * done;
        (target - gap * (1.0 - done), ramped + responded)
    }

    /// The wheels `late` [s] before each of the times, which are in order or nearly.
    fn along<'a>(&'a self, times: &'a [f64], late: f64) -> impl Iterator<Item = Turned> + 'a {
        let mut place = 0;
        times.iter().map(move |&time| {
            let at = time - late;
            while place > 0 && self.times[place] > at {
                place -= 1;
            }
            while self.times.get(place + 1).is_some_and(|next| *next <= at) {
                place += 1;
            }
            let since = at - self.times[place];
            let (angle, done) = self.since(place, since.max(0.0));
            let total = self.totals[place] + done + since.min(0.0) * self.commands[0];
            Turned { time, angle, total }
        })
    }
}

/// `y_k = kept_k y_{k-1} + added_k` from 0 on; the rows of `added` are as wide as they come.
pub fn recursion(kept: &[f64], added: &[f64]) -> Vec<f64> {
    let width = added.len() / kept.len().max(1);
    let mut found = added.to_vec();
    for (row, factor) in kept.iter().enumerate().skip(1) {
        for place in row * width..(row + 1) * width {
            found[place] += factor * found[place - width];
        }
    }
    found
}

/// The mean of each `cell` [s] of a signal behind first-order lags [s], one for each cell.
///
/// Exact where what is `given` stays the same within a cell; it begins as if it had been before.
pub fn lagged(given: &[f64], lags: &[f64], cell: f64) -> Vec<f64> {
    let mut behind = given.first().copied().unwrap_or(0.0);
    let means = given.iter().zip(lags).map(|(now, lag)| {
        let (lag, gap) = (lag.max(NO_LAG), behind - now);
        let done = -(-cell / lag).exp_m1();
        behind -= gap * done;
        now + gap * done * lag / cell
    });
    means.collect()
}

#[cfg(test)]
mod tests {
    use super::{LoggedWheels, lagged, recursion};

    const TIMES: [f64; 4] = [1.0, 1.4, 2.0, 2.05];
    const COMMANDS: [f64; 4] = [0.1, 0.3, -0.2, 0.0];

    /// Angles and their integrals every `step` from 0 s on, by small steps.
    fn stepped(lag: f64, rate: f64, play: f64, step: f64) -> Vec<(f64, f64)> {
        let (mut angle, mut wheel, mut total, mut time) = (0.1_f64, 0.1_f64, 0.0, 0.0);
        let mut found = Vec::new();
        while time < 4.0 {
            let place = TIMES.partition_point(|begin| *begin <= time).max(1) - 1;
            wheel = wheel.min(angle + 0.5 * play).max(angle - 0.5 * play);
            found.push((wheel, total));
            angle += step * ((COMMANDS[place] - angle) / lag).clamp(-rate, rate);
            total += step * wheel;
            time += step;
        }
        found
    }

    #[test]
    fn wheels_turn_as_in_small_steps_behind_play_too() {
        for (lag, rate, play) in [
            (0.2, None, 0.0),
            (0.1, Some(0.3), 0.0),
            (0.1, Some(0.5), 0.04),
        ] {
            let wheels = LoggedWheels::new(TIMES.into(), COMMANDS.into(), lag, rate);
            let fine = stepped(lag, rate.unwrap_or(f64::INFINITY), play, 1e-4);
            let times: Vec<f64> = (0..39).map(|k| 0.1 * f64::from(k)).collect();
            let behind = wheels.behind_play(&times, 0.0, 1.0, 0.0, play);
            let (angles, totals) = (wheels.at(&times), wheels.integral(&times));
            for (k, (found, total)) in behind.iter().zip(&totals).enumerate() {
                let (angle, integral) = fine[1000 * k];
                assert!(
                    (found - integral).abs() < 1e-4,
                    "{k} of {lag}, {rate:?}, {play}"
                );
                if play == 0.0 {
                    assert!((angles[k] - angle).abs() < 1e-3);
                    assert!((total - totals[0] - found).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn wheels_come_late_are_scaled_and_turned_by_an_offset() {
        let wheels = LoggedWheels::new(TIMES.into(), COMMANDS.into(), 0.1, None);
        let edges = [0.5, 1.1, 1.6, 2.6, 9.0];
        let earlier: Vec<f64> = edges.iter().map(|edge| edge - 0.25).collect();
        let total = wheels.integral(&earlier);
        let found = wheels.behind_play(&edges, 0.25, 0.9, 0.02, 0.0);
        for (k, edge) in edges.iter().enumerate() {
            let wanted = 0.9 * (total[k] - total[0]) + 0.02 * (edge - edges[0]);
            assert!((found[k] - wanted).abs() < 1e-12);
        }
        assert!(wheels.behind_play(&[], 0.25, 0.9, 0.02, 0.0).is_empty());
    }

    #[test]
    fn cells_behind_a_lag_are_those_of_wheels_that_have_it() {
        let given = [0.1, 0.3, -0.2, -0.2, 0.0];
        let edges: Vec<f64> = (0..6).map(|k| 0.1 * f64::from(k)).collect();
        for lag in [0.0, 0.02, 0.3] {
            let wheels = LoggedWheels::new(edges[..5].into(), given.into(), lag, None);
            let totals = wheels.integral(&edges);
            for (k, mean) in lagged(&given, &[lag; 5], 0.1).iter().enumerate() {
                assert!((10.0 * (totals[k + 1] - totals[k]) - mean).abs() < 1e-12);
            }
        }
        assert!(lagged(&[], &[], 0.1).is_empty());
    }

    #[test]
    fn recursion_goes_down_each_column() {
        let found = recursion(&[7.0, 0.5, 0.0], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(found, [1.0, 2.0, 3.5, 5.0, 5.0, 6.0]);
        assert!(recursion(&[], &[]).is_empty());
    }
}
