//! What the controllers drive: vehicle models that run finer than the control.

mod bicycle;
mod identified;

pub use bicycle::KinematicBicycle;
pub use identified::CarlaIdentified;

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use popsteer_core::{Vehicle, VehicleState};

/// What a vehicle is commanded for one control step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control {
    /// Steering angle [rad].
    pub steer: f64,
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Brake, 0 to 1.
    pub brake: f64,
    /// Whether the throttle drives backwards.
    pub reverse: bool,
}

/// Everything a plant of this crate remembers; a plain one leaves some of it at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlantState {
    /// Pose of the vehicle's point, and speed.
    pub vehicle: VehicleState,
    /// Yaw rate [rad/s].
    pub yaw_rate: f64,
    /// Angle of the wheels [rad].
    pub wheel: f64,
    /// Angle of the road wheels behind the play of the steering [rad].
    pub road_wheel: f64,
    /// Throttle as it has reached the wheels, 0 to 1.
    pub throttle: f64,
}

impl PlantState {
    /// Moves the road wheels by a steering angle [rad]: they stay within `play` [rad] of it.
    fn push(&mut self, steering: f64, play: f64) -> f64 {
        self.road_wheel = behind_play(self.road_wheel, steering, play);
        self.road_wheel
    }

    /// At rest or rolling at `start`, the wheels where they stand at the command 0.
    pub fn settled(vehicle: &Vehicle, start: VehicleState) -> Self {
        Self {
            vehicle: start,
            yaw_rate: 0.0,
            wheel: vehicle.at_wheels(vehicle.steer_offset),
            road_wheel: vehicle.at_wheels(vehicle.steer_offset),
            throttle: 0.0,
        }
    }
}

/// Road wheels from the angle `wheel` [rad] once the steering before `play` [rad] is at `steering`.
pub fn behind_play(wheel: f64, steering: f64, play: f64) -> f64 {
    let half = 0.5 * play;
    wheel.min(steering + half).max(steering - half)
}

/// A vehicle that moves.
pub trait Plant: fmt::Debug + Send + Sync + Any {
    /// Its name on the command line.
    fn name(&self) -> &str;

    /// What it is.
    fn vehicle(&self) -> &Vehicle;

    /// Whether it drives backwards when commanded to.
    fn reverses(&self) -> bool {
        false
    }

    /// Which pedals give it an acceleration, where that is known.
    fn pedals(&self) -> Option<PedalMap> {
        None
    }

    /// Moves `state` on by `substeps` steps of `dt` [s] under a constant `control`.
    ///
    /// The steering angle is the one that reaches the wheels: dead time and steering offset of the
    /// vehicle are behind it, lag, rate and largest angle are the plant's own.
    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize);
}

/// Which pedals give an acceleration: that of a vehicle whose drive is linear in them.
///
/// ```text
/// a = drive throttle - braking brake - drag v - air_drag v |v|
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PedalMap {
    /// Acceleration at full throttle [m/s^2].
    pub drive: f64,
    /// Deceleration at full brake [m/s^2].
    pub braking: f64,
    /// Drag linear in speed [1/s].
    pub drag: f64,
    /// Drag quadratic in speed [1/m].
    pub air_drag: f64,
}

impl PedalMap {
    /// Throttle and brake, each in 0 to 1, for an acceleration [m/s^2] at a speed [m/s], both along
    /// the direction of driving.
    pub fn of(&self, acceleration: f64, speed: f64) -> (f64, f64) {
        let drag = self.drag * speed + self.air_drag * speed * speed.abs();
        let pull = acceleration + drag;
        // What a drive or brakes of 0 cannot give, they are asked for in full.
        if pull >= 0.0 {
            ((pull / self.drive).min(1.0), 0.0)
        } else {
            (0.0, (-pull / self.braking).min(1.0))
        }
    }
}

/// The vehicle as it answers an angle that has reached its wheels.
fn at_its_wheels(vehicle: &Vehicle) -> Vehicle {
    Vehicle {
        steer_offset: 0.0,
        ..*vehicle
    }
}

/// The names that [`by_name`] knows, in the order of a listing.
pub const NAMES: [&str; 2] = [CarlaIdentified::NAME, KinematicBicycle::NAME];

/// The plant of that name, with its own parameters.
pub fn by_name(name: &str) -> Option<Arc<dyn Plant>> {
    match name {
        CarlaIdentified::NAME => Some(Arc::new(CarlaIdentified::default())),
        KinematicBicycle::NAME => Some(Arc::new(KinematicBicycle::default())),
        _ => None,
    }
}
