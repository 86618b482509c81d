//! The parameters of the lateral controllers.

use popsteer_core::Vehicle;
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use pyo3::prelude::*;

use crate::params::params;
use crate::vehicle::PyVehicle;

/// [`params!`] of a controller: lengths, speeds and gains per metre that are not given scale with
/// the vehicle, and `resolved` gives their values. Two distances are parameters of each.
macro_rules! tuning {
    (
        $(#[doc = $about:literal])+
        $class:ident($core:ident) named $name:literal of $law:ident,
        shown as $shown:literal,
        $($field:ident: $kind:ty, $words:literal, $text:literal;)+
        @examples { $(#[doc = $example:literal])+ }
    ) => {
        params! {
            $(#[doc = $about])+
            ///
            /// What is not given and has no number here scales with the wheelbase of the vehicle:
            /// `resolved` gives the numbers.
            $class($core) named $name in "popsteer",
            shown as $shown,
            defaults $core::DEFAULT, checked by (|params| $law::new(Vehicle::DEFAULT, params)),
            $($field: $kind, $words, $text;)+
            search_distance: Option<f64>, "float, optional",
                "Arc of the path that is searched on each side of the last projection [m], in addition to the distance travelled in a step; two wheelbases by default.";
            lost_distance: Option<f64>, "float, optional",
                "Distance from the path beyond which the vehicle is lost and is searched for on the whole path [m]; ten wheelbases by default.";
            @examples { $(#[doc = $example])+ }
            @extra {
                /// The same with the defaults that scale with a vehicle filled in.
                ///
                /// Parameters
                /// ----------
                /// vehicle : Vehicle
                ///     The vehicle.
                ///
                /// Returns
                /// -------
                /// same as the object
                ///     The parameters, with a number for each.
                fn resolved(&self, vehicle: PyRef<'_, PyVehicle>) -> Self {
                    Self(self.0.resolved(&vehicle.0).into())
                }
            }
        }
    };
}

tuning! {
    /// Parameters of `Pop`; the paper's Table 1 at the paper's car.
    PyPopParams(PopParams) named "PopParams" of Pop,
    shown as "(*, lookahead_gain=0.2, min_lookahead=None, steer_span=0.05235987755982989, candidate_count=21, exact_lookahead=True, lookahead_tolerance=None, window_ahead=None, grid_spacing=None, search_distance=None, lost_distance=None)",
    lookahead_gain: f64, "float, default 0.2",
        "Velocity constant k_v [s]: lookahead = min_lookahead + lookahead_gain * speed.";
    min_lookahead: Option<f64>, "float, optional",
        "Lookahead at rest ld_min [m]; by default two wheelbases, the published code's 6 m at the paper's car. The paper gives none.";
    steer_span: f64, "float, default radians(3)",
        "Optimization range delta_nbd [rad]: candidates lie at most this far from the last angle.";
    candidate_count: usize, "int, default 21",
        "Optimization resolution: the number of candidates, odd.";
    exact_lookahead: bool, "bool, default True",
        "Whether the lookahead point is the path's first crossing of the circle ahead, instead of what the paper's search finds.";
    lookahead_tolerance: Option<f64>, "float, optional",
        "Threshold epsilon of the paper's search [m]; 1/300 of the wheelbase by default.";
    window_ahead: Option<f64>, "float, optional",
        "Arc ahead of the vehicle that the paper's search looks at [m]; 20/3 wheelbases by default.";
    grid_spacing: Option<f64>, "float, optional",
        "Greatest distance of neighbours on the path as the paper's search re-discretises it [m]; 1/300 of the wheelbase by default.";
    @examples {
        /// >>> popsteer.PopParams().resolved(popsteer.Vehicle(wheelbase=0.5)).min_lookahead
        /// 1.0
    }
}

tuning! {
    /// Parameters of `PreviewPop`.
    PyPreviewPopParams(PreviewPopParams) named "PreviewPopParams" of PreviewPop,
    shown as "(*, steer_span_rate=None, horizon=1.0, heading_cost=None, steer_rate_cost=None, approach_angle=0.25, min_speed=None, smoothing_length=None, search_distance=None, lost_distance=None)",
    steer_span_rate: Option<f64>, "float, optional",
        "Optimization range delta_nbd over the control period [rad/s]: an angle lies at most this times dt from the last one; by default the vehicle's max_steer_rate, or 60 degrees/s, the paper's 3 degrees in 50 ms.";
    horizon: f64, "float, default 1.0",
        "How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is anticipated. If it is shorter than the lag and the return to the path, the vehicle oscillates. Up to twice as long where the vehicle's ``max_steer_rate`` is given and its wheels need it.";
    heading_cost: Option<f64>, "float, optional",
        "How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]; a wheelbase by default. More: the path is joined more gently, and offsets take longer to vanish.";
    steer_rate_cost: Option<f64>, "float, optional",
        "How many metres of cross-track error are as bad as turning the wheels at 1 rad/s [m s/rad]; a twelfth of the wheelbase by default. More: calmer wheels, less noise passed on, wider bends where the model is wrong.";
    approach_angle: f64, "float, default 0.25",
        "Heading at which the path is approached from afar [rad]; less if the vehicle's limits would not straighten it in time. More: sooner back on the path, by a sharper manoeuvre.";
    min_speed: Option<f64>, "float, optional",
        "Below this speed [m/s] the wheels turn in proportion to the distance travelled, and the prediction looks as far as at this speed; at rest they keep their angle. Where the vehicle's max_steer_rate is given, they turn at all of it down to half this speed. By default 5/3 wheelbases a second.";
    smoothing_length: Option<f64>, "float, optional",
        "Length of path over which its direction is taken [m]; 2/3 of the wheelbase by default. More: less of the waypoints' noise is steered, and bends shorter than this are cut.";
    @examples {
        /// >>> popsteer.PreviewPopParams().resolved(popsteer.Vehicle(wheelbase=2.7)).heading_cost
        /// 2.7
    }
}

tuning! {
    /// Parameters of `Pid`; the paper's Table 1 at the paper's car.
    PyPidParams(PidParams) named "PidParams" of Pid,
    shown as "(*, kp=None, ki=None, kd=None, buffer_length=500, integral_with_dt=True, smoothing_length=None, search_distance=None, lost_distance=None)",
    kp: Option<f64>, "float, optional",
        "Proportional gain k_P [rad/m]; by default 0.25 at the paper's wheelbase of 3 m, like the others inversely proportional to it at others.";
    ki: Option<f64>, "float, optional",
        "Integral gain k_I [rad/(m s)], or [rad/m] without integral_with_dt; by default 0.01 at the paper's wheelbase.";
    kd: Option<f64>, "float, optional",
        "Derivative gain k_D [rad s/m]; by default 0.2 at the paper's wheelbase.";
    buffer_length: usize, "int, default 500",
        "How many of the last errors the integral sums, against wind-up; at most 500.";
    integral_with_dt: bool, "bool, default True",
        "Whether the integral weighs each error with its dt; the paper's equation does not.";
    smoothing_length: Option<f64>, "float, optional",
        "Length of path over which its heading is taken [m]; two wheelbases by default. The derivative is then how fast the front axle moves across that heading, which noise of the waypoints hardly reaches. 0: that of the error, as printed.";
    @examples {
        /// >>> popsteer.PidParams().resolved(popsteer.Vehicle(wheelbase=0.3)).kp
        /// 2.5
    }
}

tuning! {
    /// Parameters of `PurePursuit`; the paper's Table 1 at the paper's car, with the published
    /// code's least lookahead.
    PyPurePursuitParams(PurePursuitParams) named "PurePursuitParams" of PurePursuit,
    shown as "(*, lookahead_gain=0.9, min_lookahead=None, alpha_by_arccos=False, exact_lookahead=True, lookahead_tolerance=None, window_ahead=None, grid_spacing=None, search_distance=None, lost_distance=None)",
    lookahead_gain: f64, "float, default 0.9",
        "Velocity constant k_v [s]: lookahead = max(min_lookahead, lookahead_gain * speed).";
    min_lookahead: Option<f64>, "float, optional",
        "Least lookahead [m]; by default 10/3 wheelbases, the published code's 10 m at the paper's car. The paper's equation has 0.";
    alpha_by_arccos: bool, "bool, default False",
        "Whether alpha is acos(heading . line / lookahead), as in the published code.";
    exact_lookahead: bool, "bool, default True",
        "Whether the lookahead point is the path's first crossing of the circle ahead, instead of what the paper's search finds; with it, a point behind the vehicle is turned to as one abeam.";
    lookahead_tolerance: Option<f64>, "float, optional",
        "Threshold epsilon of the paper's search [m]; 1/300 of the wheelbase by default.";
    window_ahead: Option<f64>, "float, optional",
        "Arc ahead of the vehicle that the paper's search looks at [m]; 20/3 wheelbases by default.";
    grid_spacing: Option<f64>, "float, optional",
        "Greatest distance of neighbours on the path as the paper's search re-discretises it [m]; 1/300 of the wheelbase by default.";
    @examples {
        /// >>> popsteer.PurePursuitParams().resolved(popsteer.Vehicle(wheelbase=0.3)).min_lookahead
        /// 1.0
    }
}

tuning! {
    /// Parameters of `Stanley`; the paper's Table 1 at the paper's car.
    PyStanleyParams(StanleyParams) named "StanleyParams" of Stanley,
    shown as "(*, cross_track_gain=1.5, speed_gain=1.3, softening=None, heading_behind=False, smoothing_length=None, search_distance=None, lost_distance=None)",
    cross_track_gain: f64, "float, default 1.5",
        "Crosstrack error constant k_chi [1/s].";
    speed_gain: f64, "float, default 1.3",
        "Velocity constant k_v.";
    softening: Option<f64>, "float, optional",
        "Softening constant k_s [m/s], which keeps the quotient finite at rest; by default 1e-5 at the paper's wheelbase of 3 m, in proportion at others.";
    heading_behind: bool, "bool, default False",
        "Whether the path's heading is that of the segment behind the nearest waypoint, as in the published code.";
    smoothing_length: Option<f64>, "float, optional",
        "Length of path over which its heading is taken [m]; a wheelbase by default. More: less of the waypoints' noise is steered, and bends shorter than this are cut. 0, or heading_behind: the heading of one segment, as printed.";
    @examples {
        /// >>> popsteer.StanleyParams().resolved(popsteer.Vehicle(wheelbase=3.0)).lost_distance
        /// 30.0
    }
}
