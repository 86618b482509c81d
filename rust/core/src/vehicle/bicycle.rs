//! Predictions of the vehicle: the paper's one-step prediction, the kinematic bicycle, and a
//! roll-out through the commands.

use super::{Estimate, Vehicle, VehicleState};
use crate::geometry::Point;
use crate::math::{ceil_to_count, cos, from_count, saturate, sin, tan, to_count};

/// The largest number of steps of a prediction.
pub const MAX_STEPS: usize = 20;

/// How many steps a prediction takes over `horizon` [s], and how long each is [s]: the control
/// period `dt` [s], or longer where that would be too many.
#[inline]
pub fn steps(horizon: f64, dt: f64) -> (usize, f64) {
    let whole = to_count(saturate(horizon / dt + 1e-6, 1.0, from_count(MAX_STEPS)));
    let period = horizon / from_count(whole);
    (whole, if period < dt { dt } else { period })
}

/// The vehicle's location after `dt` [s]: the first two rows of the paper's Equation 6,
/// `x + cos(yaw + steer) dt speed` and `y + sin(yaw + steer) dt speed` [m].
#[inline]
pub fn get_predicted_location(vehicle: VehicleState, steer: f64, dt: f64) -> Point {
    let heading = vehicle.yaw + steer;
    Point::new(
        vehicle.x + cos(heading) * dt * vehicle.speed,
        vehicle.y + sin(heading) * dt * vehicle.speed,
    )
}

/// One step of the kinematic bicycle about the rear axle: `yaw rate = speed tan(steer) /
/// wheelbase`, the position moved along the heading of mid-step (second order in `dt`),
/// `speed` changed by `acceleration` [m/s^2] at the end.
#[inline]
pub fn kinematic_bicycle(
    vehicle: VehicleState,
    steer: f64,
    acceleration: f64,
    wheelbase: f64,
    dt: f64,
) -> VehicleState {
    let travel = vehicle.speed * dt;
    let turn = travel * tan(steer) / wheelbase;
    let heading = vehicle.yaw + 0.5 * turn;
    VehicleState {
        x: vehicle.x + travel * cos(heading),
        y: vehicle.y + travel * sin(heading),
        yaw: vehicle.yaw + turn,
        speed: vehicle.speed + acceleration * dt,
    }
}

/// The vehicle after `travel` [m] along an arc of `curvature` [1/m], moving at the angle `slip`
/// [rad] to its heading, left of it: the position moved along the direction of mid-arc (second
/// order in `travel`). The speed stays.
#[inline]
pub fn advance(vehicle: VehicleState, travel: f64, curvature: f64, slip: f64) -> VehicleState {
    let turn = travel * curvature;
    let direction = vehicle.yaw + 0.5 * turn + slip;
    VehicleState {
        x: vehicle.x + travel * cos(direction),
        y: vehicle.y + travel * sin(direction),
        yaw: vehicle.yaw + turn,
        speed: vehicle.speed,
    }
}

/// A vehicle rolled forward through commands that last for their time each.
///
/// ```text
/// curvature = gain tan(wheel + steer_offset) / turning_length,   yaw' = speed curvature
/// ```
///
/// The state is that of the no-slip point; the estimate corrects the vehicle. The speed changes by
/// the acceleration that is estimated, and the turning length is that of the first speed.
#[derive(Clone, Copy, Debug)]
pub struct Rollout<'a> {
    vehicle: &'a Vehicle,
    estimate: &'a Estimate,
    state: VehicleState,
    /// Length that turns an angle of the wheels into a curvature [m].
    length: f64,
    /// Speed at the beginning [m/s].
    start: f64,
    /// Time since then [s].
    time: f64,
}

impl<'a> Rollout<'a> {
    /// The longest step [s]; larger values cut bends short, smaller ones cost more.
    const STEP: f64 = 0.05;

    /// A vehicle that begins at `state`.
    #[inline]
    pub fn new(vehicle: &'a Vehicle, estimate: &'a Estimate, state: VehicleState) -> Self {
        Self {
            vehicle,
            estimate,
            state,
            length: vehicle.turning_length(state.speed) / estimate.gain,
            start: state.speed,
            time: 0.0,
        }
    }

    /// The present vehicle.
    #[inline]
    pub fn state(&self) -> VehicleState {
        self.state
    }

    /// Drives for `time` [s] with the wheels at the mean angle `wheel` [rad]: one step.
    #[inline]
    pub fn turn(&mut self, wheel: f64, time: f64) {
        let (estimate, state) = (self.estimate, self.state);
        self.time += time;
        let speed = estimate.speed_after(self.start, self.time);
        let travel = 0.5 * (state.speed + speed) * time;
        let angle = self.vehicle.at_wheels(wheel + estimate.steer_offset);
        let curvature = tan(angle) / self.length;
        let slip = estimate.slip + estimate.slip_length * curvature;
        self.state = advance(state, travel, curvature, slip);
        self.state.speed = speed;
    }

    /// Drives through `commands`, angles [rad] with how long each lasts [s], from the angle `wheel`
    /// of the wheels [rad] on; that at the end [rad].
    #[inline]
    pub fn drive(&mut self, wheel: f64, commands: impl Iterator<Item = (f64, f64)>) -> f64 {
        let mut wheel = wheel;
        for (steer, duration) in commands {
            let steps = from_count(ceil_to_count(duration / Self::STEP));
            let step = duration / steps;
            let mut done = 0.0;
            while done < steps {
                let moved = self.vehicle.move_wheel(wheel, steer, step);
                self.turn(moved.mean, step);
                wheel = moved.wheel;
                done += 1.0;
            }
        }
        wheel
    }
}
