//! What the laws drive: vehicle models that run finer than the control.

mod bicycle;
mod identified;

pub use bicycle::KinematicBicycle;
pub use identified::CarlaIdentified;

use std::fmt;
use std::sync::Arc;

use popsteer_core::VehicleState;

/// What the actuators are told for one control step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control {
    /// Angle of the front wheels [rad].
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
pub struct PlantState {
    /// Pose of the point that does not slip, and speed.
    pub vehicle: VehicleState,
    /// Yaw rate [rad/s].
    pub yaw_rate: f64,
    /// Throttle as it has reached the wheels, 0 to 1.
    pub throttle: f64,
}

/// Where the laws' reference points lie on the vehicle, and what the laws take for its wheelbase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Front axle ahead of the point whose pose the plant reports [m].
    pub front_offset: f64,
    /// Rear axle ahead of that point [m]; negative behind it.
    pub rear_offset: f64,
    /// Distance of the axles [m].
    pub wheelbase: f64,
}

/// A vehicle model.
pub trait Plant: fmt::Debug + Send + Sync {
    /// Its name on the command line.
    fn name(&self) -> &str;

    /// Where its axles are.
    fn geometry(&self) -> Geometry;

    /// Whether it drives backwards when told to.
    fn reverses(&self) -> bool {
        false
    }

    /// Moves `state` on by `substeps` steps of `dt` [s] under a constant `control`.
    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize);
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
