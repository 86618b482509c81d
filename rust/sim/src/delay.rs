//! The dead time of a plant: commands reach it later.

use std::collections::VecDeque;

/// Shorter remainders of a command are rounding [s].
const ROUNDING: f64 = 1e-12;

/// Commands that have not reached the plant yet.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Delay {
    /// Angle [rad] and how long it was commanded [s], oldest first.
    commands: VecDeque<(f64, f64)>,
}

impl Delay {
    /// Of `dead_time` [s], in which straight wheels were commanded.
    pub fn new(dead_time: f64) -> Self {
        let commands = (dead_time > 0.0).then_some((0.0, dead_time));
        Self {
            commands: commands.into_iter().collect(),
        }
    }

    /// Commands in flight, oldest first.
    pub fn commands(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.commands.iter().copied()
    }

    /// Lets `substeps` steps of `dt` [s] pass under `command`: `act` is given each angle that
    /// reaches the plant, the mean over a step, and for how many steps.
    pub fn pass(
        &mut self,
        command: f64,
        dt: f64,
        substeps: usize,
        mut act: impl FnMut(f64, usize),
    ) {
        if self.commands.is_empty() {
            act(command, substeps);
            return;
        }
        let period = popsteer_core::math::from_count(substeps) * dt;
        self.commands.push_back((command, period));
        let (mut acting, mut count) = (self.take(dt), 1);
        for _ in 1..substeps {
            let next = self.take(dt);
            if next.to_bits() == acting.to_bits() {
                count += 1;
            } else {
                act(acting, count);
                (acting, count) = (next, 1);
            }
        }
        act(acting, count);
    }

    /// The mean of what arrives over the next `time` [s].
    fn take(&mut self, time: f64) -> f64 {
        let mut remaining = time;
        let mut sum = 0.0;
        while let Some((command, duration)) = self.commands.front_mut() {
            if *duration > remaining + ROUNDING {
                *duration -= remaining;
                // All of one command is that command to the bit.
                return if remaining < time {
                    sum / time + *command * (remaining / time)
                } else {
                    *command
                };
            }
            let whole = *duration >= time - ROUNDING;
            let command = *command;
            sum += command * duration.min(remaining);
            remaining -= *duration;
            self.commands.pop_front();
            if whole {
                return command;
            }
            if remaining <= ROUNDING {
                break;
            }
        }
        sum / time
    }
}
