//! The scale of the speed signal: how far the vehicle goes by its poses, for what its speed says.

use super::{AdaptParams, Change, Estimator, SVector, Vehicle, VehicleState, Walk, moved};

impl Estimator {
    /// How far the scale of a speed signal may be from 1, and how much older than the speed [s] a
    /// pose, or the other way round: standard deviations.
    pub(super) const DRIVING: [f64; 2] = [0.1, 0.1];
    /// What the model leaves open: a share of the speed, by which tyres slip.
    const OPEN_DRIVE: f64 = 0.03;
    /// Least and largest scale that is one. Beyond, the signal is dead, or of another unit: it
    /// counts as it is, and the monitor says what it is.
    pub const SCALES: (f64, f64) = (0.6, 1.6);

    /// Updates the scale from the motion in the last `dt` [s] from `before` to `now`, both with the
    /// speed that was told.
    #[inline]
    pub(super) fn observe_driven(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        [before, now]: [VehicleState; 2],
        dt: f64,
    ) {
        let wheelbase = vehicle.wheelbase;
        let speed = 0.5 * (before.speed + now.speed);
        let travel = speed * dt / wheelbase;
        let (measured, _) = moved(before, now);
        // Of a speed that is noise no distance is expected to be a multiple.
        let known = self.filtered_speed(vehicle, before.speed) / self.estimate.speed_scale;
        let slopes = SVector::<f64, 2>::new(known * dt, (before.speed - now.speed) / wheelbase);
        let slips = Self::OPEN_DRIVE * speed / wheelbase;
        let by_noise = 0.5 * self.pace.noise.variance * dt * dt;
        let change = Change {
            measured: measured / wheelbase,
            expected: travel + slopes.dot(&self.driving.mean),
            slopes,
            open: 2.0 * Self::OPEN_TIME * slips * slips * dt + by_noise,
            noise: self.driving.noise.variance_at_most(),
            dt,
        };
        self.driving.observe(&change, Self::POSITION_NOISE);
        let share = dt * Self::moving(vehicle, speed) / params.speed_time;
        self.driving.forget(share, &Self::DRIVING);
        let found = self.driving.beyond_doubt(&SVector::<f64, 2>::new(1.0, 0.0));
        let (least, most) = Self::SCALES;
        let is_scale = (least..=most).contains(&(1.0 + found));
        self.estimate.speed_scale = if is_scale { 1.0 + found } else { 1.0 };
    }

    /// The filter of a speed signal that is right.
    pub(super) fn driving() -> Walk<2> {
        Walk::new([0.0; 2], &Self::DRIVING, Self::POSITION_NOISE)
    }
}
