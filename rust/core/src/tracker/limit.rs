//! From the wanted angle to the command: hand-over, then the limits of the vehicle.

use crate::laws::{LateralLaw, LateralState};
use crate::math::{atan, saturate};
use crate::status::Status;
use crate::tracker::state::{HANDOVER_TIME, Handover, Tracking, widest_offset};
use crate::tracker::step::Tracker;
use crate::vehicle::{Estimate, Vehicle};

impl<L: LateralLaw> Tracker<L> {
    /// Commands the angle `wanted` of the wheels [rad] as far as the vehicle allows; says what
    /// limited it.
    pub(super) fn limit(
        &self,
        state: &mut Tracking<L::State>,
        wanted: f64,
        speed: f64,
        dt: f64,
        estimate: &Estimate,
    ) -> Status {
        let car = self.law.vehicle();
        let offset = car.steer_offset + estimate.steer_offset;
        let (handover, widest) = (&mut state.handover, widest_offset(car));
        let wanted = fade(handover, state.steer, wanted - offset, dt, widest);
        let angle = car.at_wheels(wanted + offset);
        // The gain is measured: the limit is one of the acceleration that the vehicle has.
        let gain = match &state.monitor {
            Some(monitored) if self.adapt().is_none() => monitored.gain.get(0),
            _ => estimate.gain,
        };
        let wheel = car.limit_lateral_acceleration(angle, speed, gain);
        let command = saturate(wheel - offset, -car.max_steer, car.max_steer);
        let steer = match car.max_steer_rate {
            None => command,
            Some(rate) => saturate(command, state.steer - rate * dt, state.steer + rate * dt),
        };
        state.steer = steer;
        state.law.set_steer(car.at_wheels(steer + offset));
        // The offset is put off and on again, which rounds.
        let differs = |a: f64, b: f64| (a - b).abs() > 1e-12;
        Status::SATURATED.when(differs(steer, wanted))
            | Status::RATE_LIMIT.when(differs(steer, command))
            | Status::LATERAL_LIMIT.when(differs(wheel, angle))
            | Status::STEER_LIMIT
                .when(differs(angle, wanted + offset) || differs(command, wheel - offset))
    }
}

/// The command of a hand-over: the difference to the last one, at most `widest` [rad], fades.
fn fade(handover: &mut Option<Handover>, last: f64, wanted: f64, dt: f64, widest: f64) -> f64 {
    let Some(fading) = handover else {
        return wanted;
    };
    let before = fading.remaining;
    let offset = match fading.offset {
        None if before >= HANDOVER_TIME => last - wanted,
        None => {
            // The path changed again during a hand-over: the difference fades in the remaining
            // time.
            fading.remaining -= dt;
            let share = before / HANDOVER_TIME;
            if fading.remaining > 0.0 {
                saturate((last - wanted) / share, -widest, widest)
            } else {
                0.0
            }
        }
        Some(offset) => {
            fading.remaining -= dt;
            offset
        }
    };
    fading.offset = Some(offset);
    let share = saturate(fading.remaining / HANDOVER_TIME, 0.0, 1.0);
    if fading.remaining <= 0.0 {
        *handover = None;
    }
    wanted + share * offset
}

impl Vehicle {
    /// The angle `wheel` [rad], brought within `max_lateral_acceleration` at `speed` [m/s] for a
    /// vehicle that turns `gain` times as much as its parameters say.
    #[inline]
    fn limit_lateral_acceleration(&self, wheel: f64, speed: f64, gain: f64) -> f64 {
        let Some(most) = self.max_lateral_acceleration else {
            return wheel;
        };
        let (square, length) = (speed * speed * gain, self.turning_length(speed));
        // tan(x) < x + x^3 up to 1.1, by more than rounds: within the limit no arc is needed.
        let tangent = wheel.abs() * (1.0 + 1e-9 + wheel * wheel);
        if wheel.abs() < 1.1 && tangent * square <= most * length {
            return wheel;
        }
        let widest = atan(most * length / square);
        saturate(wheel, -widest, widest)
    }
}

#[cfg(test)]
mod tests;
