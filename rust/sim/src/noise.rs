//! The noise of the measured vehicle.

use popsteer_core::VehicleState;
use popsteer_core::math::wrap;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

popsteer_core::params! {
    /// Noise of pose and speed as a driver gets them: standard deviations of normal noise, drawn
    /// at every step.
    pub struct Noise {
        /// Of x, and of y [m].
        position: f64 = 0.0, in [0.0, 1e3];
        /// Of the heading [rad].
        yaw: f64 = 0.0, in [0.0, 10.0];
        /// Of the speed [m/s].
        speed: f64 = 0.0, in [0.0, 1e3];
    }
}

impl Noise {
    fn perceive(&self, vehicle: VehicleState, random: &mut Pcg64) -> VehicleState {
        let mut draw = |deviation: f64| -> f64 {
            let normal: f64 = StandardNormal.sample(random);
            deviation * normal
        };
        VehicleState {
            x: vehicle.x + draw(self.position),
            y: vehicle.y + draw(self.position),
            yaw: wrap(vehicle.yaw + draw(self.yaw)),
            speed: vehicle.speed + draw(self.speed),
        }
    }
}

/// The vehicle measured with [`Noise`] from one stream of a generator.
#[derive(Clone, Debug)]
pub struct Perception(Option<(Noise, Pcg64)>);

impl Perception {
    /// As it is.
    pub const EXACT: Self = Self(None);

    /// Through `noise`, drawn from stream `stream` of the generator with this `seed`.
    pub fn new(noise: Noise, seed: u64, stream: u64) -> Self {
        if noise == Noise::DEFAULT {
            return Self::EXACT;
        }
        let random = Pcg64::new(u128::from(seed), u128::from(stream));
        Self(Some((noise, random)))
    }

    pub(crate) fn of(&mut self, vehicle: VehicleState) -> VehicleState {
        match &mut self.0 {
            None => vehicle,
            Some((noise, random)) => noise.perceive(vehicle, random),
        }
    }
}
