//! From an acceleration to the pedals.

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
