//! The vehicle: its parameters, prediction, commands in flight, and estimation from its motion.

pub mod bicycle;
pub mod cusum;
pub mod delay;
pub mod drive;
pub mod estimate;
pub mod estimator;
pub mod fault;
pub mod gate;
pub mod kalman;
pub mod noise;
pub mod past;
pub mod state;
pub mod timed;
pub mod wheels;

pub use cusum::Cusum;
pub use delay::InFlight;
pub use drive::{Answer, Drive, Motion};
pub use estimate::{AdaptParams, Estimate, Known};
pub use estimator::Estimator;
pub use fault::Fault;
pub use gate::Gate;
pub use noise::Noise;
pub use past::Past;
pub use state::VehicleState;

use crate::math::{cos, larger, saturate, sin, smaller};
use crate::params;
use crate::vehicle::kalman::OUTLIER;

params! {
    /// All parameters of a car-like vehicle, in one immutable value.
    ///
    /// A *pose* is always that of the vehicle's point, wherever it is measured; the axles are given
    /// relative to it. One chain leads from a command to the motion of the vehicle, in prediction,
    /// in preview POP and in plants that are made from a vehicle:
    ///
    /// ```text
    /// wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, +-max_steer_rate)
    /// |wheel| <= max_steer
    /// yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed^2)
    /// a'     = (acceleration(t - drive_delay) - a) / drive_lag,    speed' = a + what else pushes
    /// ```
    ///
    /// and the no-slip point moves along the vehicle's heading.
    ///
    /// By default: the paper's wheelbase and steering limit, the lag identified from its recorded
    /// run, and the lateral acceleration of a car.
    pub struct Vehicle {
        /// Distance of the axles L [m]; the default lengths of all parameters scale with it.
        wheelbase: f64 = 3.0, in [1e-3, 1e3];
        /// Width over all [m]: how far beside its path is too far scales with it. Absent if it is two
        /// thirds of the wheelbase, as of a car.
        width: Option<f64> = None, in [1e-3, 1e2];
        /// How far ahead of the pose's point the rear axle lies [m]: 0 where the pose is the rear
        /// axle's, negative where it is of a point ahead of that.
        rear_axle: f64 = 0.0, in [-1e3, 1e3];
        /// How far to the left of the centre line the antenna lies whose position is given as the pose's
        /// [m]; negative to the right. The pose's point is on the centre line beside it.
        antenna_left: f64 = 0.0, in [-1e2, 1e2];
        /// How high above ground it lies [m]: what a `roll` moves it aside by.
        antenna_height: f64 = 0.0, in [0.0, 1e2];
        /// How far ahead of the pose's point lies the no-slip point [m], the one that moves along
        /// the vehicle's heading; absent if it is the rear axle.
        no_slip_point: Option<f64> = None, in [-1e3, 1e3];
        /// The wheelbase that the vehicle turns by [m]; absent if it is `wheelbase`.
        turning_wheelbase: Option<f64> = None, in [1e-3, 1e3];
        /// Understeer gradient K [s^2/m].
        understeer: f64 = 0.0, in [0.0, 1e3];
        /// Angle of the wheels at the command 0 [rad].
        steer_offset: f64 = 0.0, in [-0.5, 0.5];
        /// Time constant of the wheels' first-order response to a command [s].
        steer_lag: f64 = 0.1, in [0.0, 10.0];
        /// Time from a command to its first effect on the wheels [s].
        dead_time: f64 = 0.0, in [0.0, 10.0];
        /// Largest angle of the front wheels `delta_max` [rad].
        max_steer: f64 = 1.22, in [1e-3, 1.57];
        /// Largest rate of the front wheels' angle [rad/s]; absent if there is no limit.
        max_steer_rate: Option<f64> = None, in [1e-3, 1e6];
        /// Play of the steering: by how much it turns back before the front wheels do [rad]. Plants
        /// have it; prediction takes its middle.
        steer_play: f64 = 0.0, in [0.0, 0.5];
        /// Largest lateral acceleration that a command may ask for [m/s^2]; absent if there is no limit.
        max_lateral_acceleration: Option<f64> = Some(4.0), in [1e-3, 1e6];
        /// Top speed [m/s]; absent if there is no limit.
        max_speed: Option<f64> = None, in [1e-3, 1e4];
        /// Largest driving acceleration [m/s^2]; absent if it is not known.
        max_acceleration: Option<f64> = None, in [1e-3, 1e3];
        /// Largest deceleration of a plan [m/s^2], one of comfort; absent if it is not known.
        max_deceleration: Option<f64> = None, in [1e-3, 1e3];
        /// What the brakes can do [m/s^2]: asked of them only where the vehicle would overrun a stop;
        /// absent if it is not known.
        brake_deceleration: Option<f64> = None, in [1e-3, 1e3];
        /// Time from a command to its first effect on the drive [s].
        drive_delay: f64 = 0.1, in [0.0, 10.0];
        /// Time constant of the drive's first-order response to the pedals [s].
        drive_lag: f64 = 0.0, in [0.0, 10.0];
        /// How far ahead of the pose's point lies the point that stops at a stop line and at the end
        /// of a path that is driven forwards [m]; absent if it is the rear axle.
        stop_point: Option<f64> = None, in [-1e3, 1e3];
        /// Whether the wheels turn while the vehicle stands: then they do so at a start and at a cusp,
        /// and the speed waits for them.
        steers_at_rest: bool = false;
    }
}

impl Vehicle {
    /// The paper's vehicle: its track asks for more lateral acceleration than a car's.
    pub const PAPER: Self = Self {
        max_lateral_acceleration: None,
        ..Self::DEFAULT
    };

    /// How far ahead of the pose's point the front axle lies [m].
    #[inline]
    pub fn front_axle(&self) -> f64 {
        self.rear_axle + self.wheelbase
    }

    /// How far ahead of the pose's point the no-slip point lies [m].
    #[inline]
    pub fn no_slip(&self) -> f64 {
        self.no_slip_point.unwrap_or(self.rear_axle)
    }

    /// How far to the left of the centre line the antenna of a vehicle with this `roll` [rad] lies [m]:
    ///
    /// ```text
    /// left = antenna_left cos(roll) - antenna_height sin(roll)
    /// ```
    #[inline]
    pub fn antenna_offset(&self, roll: f64) -> f64 {
        if self.antenna_height <= 0.0 && self.antenna_left.abs() <= 0.0 {
            return 0.0;
        }
        self.antenna_left * cos(roll) - self.antenna_height * sin(roll)
    }

    /// How far ahead of the rear axle lies the point that stops [m].
    #[inline]
    pub fn stop_offset(&self) -> f64 {
        self.stop_point.unwrap_or(self.rear_axle) - self.rear_axle
    }

    /// The length that turns an angle of the wheels into a curvature at `speed` [m/s]:
    /// `curvature = tan(wheel) / turning_length` [m].
    #[inline]
    pub fn turning_length(&self, speed: f64) -> f64 {
        self.turning_wheelbase.unwrap_or(self.wheelbase) + self.understeer * speed * speed
    }

    /// Largest braking deceleration of a plan that does not say one [m/s^2]: brisk for an ordinary
    /// car, and far from the grip of a dry road.
    pub const COMFORT_BRAKING: f64 = 3.0;

    /// Largest braking deceleration of a plan for this vehicle [m/s^2], one of comfort.
    #[inline]
    pub fn comfort_braking(&self) -> f64 {
        let comfort = self.max_deceleration.unwrap_or(Self::COMFORT_BRAKING);
        smaller(comfort, self.brake_deceleration.unwrap_or(comfort))
    }

    /// What brakes can do where a vehicle does not say so [m/s^2]: an ordinary car's on a dry road do more.
    pub const BRAKES: f64 = 6.0;

    /// What this vehicle's brakes can do [m/s^2].
    pub fn strongest_braking(&self) -> f64 {
        let assumed = larger(Self::BRAKES, self.comfort_braking());
        self.brake_deceleration.unwrap_or(assumed)
    }

    /// What is believed of a `speed` signal [m/s] with a `noise` of this standard deviation [m/s], `dt` [s]
    /// after the `last`, where the vehicle was `expected` to be so fast: at most what the brakes and the noise
    /// make of either. So two messages can say anything, and one alone can not.
    #[inline]
    pub fn believed_speed(
        &self,
        speed: f64,
        last: f64,
        expected: f64,
        (noise, dt): (f64, f64),
    ) -> f64 {
        let most = self.strongest_braking() * dt + OUTLIER * noise;
        let (low, high) = (smaller(last, expected), larger(last, expected));
        saturate(speed, low - most, high + most)
    }

    /// An angle that the wheels can have [rad].
    #[inline]
    pub fn at_wheels(&self, angle: f64) -> f64 {
        saturate(angle, -self.max_steer, self.max_steer)
    }
}

#[cfg(test)]
mod tests;
