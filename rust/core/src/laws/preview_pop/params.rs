//! The parameters of preview POP.

use crate::laws::law::or_scaled;
use crate::math::PI;
use crate::vehicle::Vehicle;

/// Parameters of [`PreviewPop`](super::PreviewPop).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewPopParams {
    /// Optimization range `delta_nbd` over the control period [rad/s]: an angle lies at most this
    /// times `dt` from the last one. The vehicle's `max_steer_rate` by default; 60 degrees/s, the
    /// paper's 3 degrees in 50 ms, where it has none.
    pub steer_span_rate: Option<f64>,
    /// How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is
    /// anticipated. If it is shorter than the lag and the return to the path, the vehicle
    /// oscillates. Up to twice as long if the vehicle has a `max_steer_rate` and its wheels need
    /// it.
    pub horizon: f64,
    /// How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]; a
    /// wheelbase by default. More: the path is joined more gently, and offsets take longer to
    /// vanish.
    pub heading_cost: Option<f64>,
    /// How many metres of cross-track error are as bad as turning the wheels at 1 rad/s [m s/rad];
    /// a twelfth of the wheelbase by default. More: calmer wheels, less noise passed on, wider
    /// bends where the model is wrong.
    pub steer_rate_cost: Option<f64>,
    /// Heading at which the path is approached from afar [rad]; less if the vehicle's limits would
    /// not straighten it in time. More: sooner back on the path, by a sharper manoeuvre.
    pub approach_angle: f64,
    /// Below this speed [m/s] the wheels turn in proportion to the distance travelled, and the
    /// prediction looks as far as at this speed; at rest they keep their angle. Where the vehicle's
    /// `max_steer_rate` is given, they turn at all of it down to half this speed. By default 5/3
    /// wheelbases a second.
    pub min_speed: Option<f64>,
    /// Length of path over which its direction is taken [m]; 2/3 of the wheelbase by default.
    /// More: less of the waypoints' noise is steered, and bends shorter than this are cut.
    pub smoothing_length: Option<f64>,
    /// [`Follow::search_distance`](crate::path::Follow::search_distance), by default 2 wheelbases.
    pub search_distance: Option<f64>,
    /// [`Follow::lost_distance`](crate::path::Follow::lost_distance), by default 10 wheelbases.
    pub lost_distance: Option<f64>,
}

impl PreviewPopParams {
    /// The defaults: POP's neighbourhood, and costs that suit a passenger car.
    pub const DEFAULT: Self = Self {
        steer_span_rate: None,
        horizon: 1.0,
        heading_cost: None,
        steer_rate_cost: None,
        approach_angle: 0.25,
        min_speed: None,
        smoothing_length: None,
        search_distance: None,
        lost_distance: None,
    };

    /// The parameters with the defaults that scale with `vehicle` filled in.
    pub fn resolved(self, vehicle: &Vehicle) -> Self {
        let wheelbase = vehicle.wheelbase;
        let rate = vehicle.max_steer_rate.unwrap_or(60.0 * (PI / 180.0));
        Self {
            steer_span_rate: or_scaled(self.steer_span_rate, rate),
            heading_cost: or_scaled(self.heading_cost, wheelbase),
            steer_rate_cost: or_scaled(self.steer_rate_cost, wheelbase / 12.0),
            min_speed: or_scaled(self.min_speed, 5.0 / 3.0 * wheelbase),
            smoothing_length: or_scaled(self.smoothing_length, 2.0 / 3.0 * wheelbase),
            search_distance: or_scaled(self.search_distance, 2.0 * wheelbase),
            lost_distance: or_scaled(self.lost_distance, 10.0 * wheelbase),
            ..self
        }
    }
}
