//! The tuning of the controllers, and how they adapt and watch: plain structs with defaults.

use popsteer_core::LateralLaw;
use popsteer_core::error::{ConfigError, Requirement};
use popsteer_core::laws::{
    PidParams, PopParams, PreviewPopParams, PurePursuitParams, StanleyParams,
};
use popsteer_core::math::from_count;
use popsteer_core::tracker::{MonitorParams, Tracker};
use popsteer_core::vehicle::AdaptParams;

use crate::error::Failure;
use crate::fields::same_fields;

/// Tuning of POP, the paper's controller. Lengths that are NAN scale with the wheelbase.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CPopParams {
    /// Velocity constant [s]: `lookahead = min_lookahead + lookahead_gain * speed`. Default 0.2.
    pub lookahead_gain: f64,
    /// Lookahead at rest [m]; NAN: two wheelbases.
    pub min_lookahead: f64,
    /// Optimization range [rad]: candidates lie at most this far from the last angle. Default 3
    /// degrees.
    pub steer_span: f64,
    /// Number of candidates, odd. Default 21.
    pub candidate_count: usize,
    /// Not 0: the lookahead point is the path's first crossing of the circle ahead (default); 0:
    /// what the paper's search finds.
    pub exact_lookahead: u32,
    /// Threshold of the paper's search [m]; NAN: 1/300 of the wheelbase.
    pub lookahead_tolerance: f64,
    /// Arc ahead of the vehicle that the paper's search looks at [m]; NAN: 20/3 wheelbases.
    pub window_ahead: f64,
    /// Grid of the paper's search [m]; NAN: 1/300 of the wheelbase.
    pub grid_spacing: f64,
    /// Arc of the path that is searched on each side of the last projection [m], in addition to the
    /// distance travelled in a step; NAN: two wheelbases.
    pub search_distance: f64,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path [m];
    /// NAN: ten wheelbases.
    pub lost_distance: f64,
}

same_fields!(CPopParams, PopParams, {
    lookahead_gain,
    min_lookahead,
    steer_span,
    candidate_count,
    exact_lookahead,
    lookahead_tolerance,
    window_ahead,
    grid_spacing,
    search_distance,
    lost_distance,
});

/// Tuning of preview POP. What is NAN scales with the vehicle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CPreviewPopParams {
    /// Optimization range over the control period [rad/s]; NAN: the vehicle's `max_steer_rate`, or
    /// 60 degrees/s.
    pub steer_span_rate: f64,
    /// How long the prediction looks ahead [s]. Default 1.
    pub horizon: f64,
    /// How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]; NAN: a
    /// wheelbase. More: the path is joined more gently.
    pub heading_cost: f64,
    /// How many metres of cross-track error are as bad as turning the wheels at 1 rad/s
    /// [m s/rad]; NAN: a twelfth of the wheelbase. More: calmer wheels.
    pub steer_rate_cost: f64,
    /// Heading at which the path is approached from afar [rad]. Default 0.25.
    pub approach_angle: f64,
    /// Below this speed [m/s] the wheels turn in proportion to the distance travelled; NAN: 5/3
    /// wheelbases a second.
    pub min_speed: f64,
    /// Length of path over which its direction is taken [m]; NAN: 2/3 of the wheelbase.
    pub smoothing_length: f64,
    /// Arc of the path that is searched on each side of the last projection [m], in addition to the
    /// distance travelled in a step; NAN: two wheelbases.
    pub search_distance: f64,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path [m];
    /// NAN: ten wheelbases.
    pub lost_distance: f64,
}

same_fields!(CPreviewPopParams, PreviewPopParams, {
    steer_span_rate,
    horizon,
    heading_cost,
    steer_rate_cost,
    approach_angle,
    min_speed,
    smoothing_length,
    search_distance,
    lost_distance,
});

/// Tuning of PID on the cross-track error of the front axle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CPidParams {
    /// Proportional gain [rad/m]; NAN: 0.25 at 3 m of wheelbase, inversely proportional to it.
    pub kp: f64,
    /// Integral gain [rad/(m s)], [rad/m] without `integral_with_dt`; NAN: 0.01 at 3 m.
    pub ki: f64,
    /// Derivative gain [rad s/m]; NAN: 0.2 at 3 m.
    pub kd: f64,
    /// How many of the last errors the integral sums. Default 500.
    pub buffer_length: usize,
    /// Not 0: the integral weighs each error with its dt (default); 0: as the paper prints it.
    pub integral_with_dt: u32,
    /// Length of path over which its heading is taken [m]; NAN: two wheelbases.
    pub smoothing_length: f64,
    /// Arc of the path that is searched on each side of the last projection [m], in addition to the
    /// distance travelled in a step; NAN: two wheelbases.
    pub search_distance: f64,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path [m];
    /// NAN: ten wheelbases.
    pub lost_distance: f64,
}

same_fields!(CPidParams, PidParams, {
    kp,
    ki,
    kd,
    buffer_length,
    integral_with_dt,
    smoothing_length,
    search_distance,
    lost_distance,
});

/// Tuning of pure pursuit of the rear axle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CPurePursuitParams {
    /// Velocity constant [s]: `lookahead = max(min_lookahead, lookahead_gain * speed)`. Default 0.9.
    pub lookahead_gain: f64,
    /// Least lookahead [m]; NAN: 10/3 wheelbases.
    pub min_lookahead: f64,
    /// Not 0: the angle to the lookahead point by acos, as in the published code. Default 0.
    pub alpha_by_arccos: u32,
    /// Not 0: the lookahead point is the path's first crossing of the circle ahead (default); 0:
    /// what the paper's search finds.
    pub exact_lookahead: u32,
    /// Threshold of the paper's search [m]; NAN: 1/300 of the wheelbase.
    pub lookahead_tolerance: f64,
    /// Arc ahead of the vehicle that the paper's search looks at [m]; NAN: 20/3 wheelbases.
    pub window_ahead: f64,
    /// Grid of the paper's search [m]; NAN: 1/300 of the wheelbase.
    pub grid_spacing: f64,
    /// Arc of the path that is searched on each side of the last projection [m], in addition to the
    /// distance travelled in a step; NAN: two wheelbases.
    pub search_distance: f64,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path [m];
    /// NAN: ten wheelbases.
    pub lost_distance: f64,
}

same_fields!(CPurePursuitParams, PurePursuitParams, {
    lookahead_gain,
    min_lookahead,
    alpha_by_arccos,
    exact_lookahead,
    lookahead_tolerance,
    window_ahead,
    grid_spacing,
    search_distance,
    lost_distance,
});

/// Tuning of Stanley, by the front axle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CStanleyParams {
    /// Crosstrack error constant [1/s]. Default 1.5.
    pub cross_track_gain: f64,
    /// Velocity constant. Default 1.3.
    pub speed_gain: f64,
    /// Softening constant [m/s]; NAN: 1e-5 at 3 m of wheelbase, in proportion at others.
    pub softening: f64,
    /// Not 0: the path's heading is that of the segment behind the nearest waypoint. Default 0.
    pub heading_behind: u32,
    /// Length of path over which its heading is taken [m]; NAN: a wheelbase.
    pub smoothing_length: f64,
    /// Arc of the path that is searched on each side of the last projection [m], in addition to the
    /// distance travelled in a step; NAN: two wheelbases.
    pub search_distance: f64,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path [m];
    /// NAN: ten wheelbases.
    pub lost_distance: f64,
}

same_fields!(CStanleyParams, StanleyParams, {
    cross_track_gain,
    speed_gain,
    softening,
    heading_behind,
    smoothing_length,
    search_distance,
    lost_distance,
});

/// Of `popsteer_options.adapt` and `.monitor`: as controllers of this kind do; the default.
pub const POPSTEER_AUTO: u32 = 0;
/// Of `popsteer_options.adapt` and `.monitor`: not at all.
pub const POPSTEER_OFF: u32 = 1;
/// Of `popsteer_options.adapt` and `.monitor`: with the numbers beside it.
pub const POPSTEER_ON: u32 = 2;

/// How a controller adapts to its vehicle, and watches it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct COptions {
    /// `POPSTEER_AUTO`: adapts in preview POP, and where the vehicle has a dead time;
    /// `POPSTEER_OFF`: never; `POPSTEER_ON`: with the three numbers below.
    pub adapt: u32,
    /// `POPSTEER_AUTO`: watches with the default numbers; `POPSTEER_OFF`: never;
    /// `POPSTEER_ON`: with the two numbers below.
    pub monitor: u32,
    /// Time over which turning gain, steering offset and dead time are estimated [s]; 0: never.
    /// Default 10.
    pub turn_time: f64,
    /// Time over which the slip is estimated [s]; 0: never. Default 5.
    pub slip_time: f64,
    /// Below this speed the slip is not estimated [m/s]; NAN: 5/3 wheelbases a second.
    pub min_speed: f64,
    /// Cross-track error beyond which a vehicle that was nearer before has
    /// `POPSTEER_STATUS_DEVIATING` [m]; NAN: half a wheelbase.
    pub deviation_limit: f64,
    /// How far the yaw measured over a second may be from what the commands explain without
    /// `POPSTEER_STATUS_IMPLAUSIBLE` [rad]. Default 0.01.
    pub turn_tolerance: f64,
}

/// What a switch says.
enum Wish<T> {
    Usual,
    Told(Option<T>),
}

fn wish<T>(field: &'static str, value: u32, on: T) -> Result<Wish<T>, ConfigError> {
    match value {
        POPSTEER_AUTO => Ok(Wish::Usual),
        POPSTEER_OFF => Ok(Wish::Told(None)),
        POPSTEER_ON => Ok(Wish::Told(Some(on))),
        _ => Err(ConfigError {
            field,
            value: from_count(usize::try_from(value).unwrap_or(usize::MAX)),
            requirement: Requirement::CountInRange(0, 2),
        }),
    }
}

impl Default for COptions {
    fn default() -> Self {
        Self {
            adapt: POPSTEER_AUTO,
            monitor: POPSTEER_AUTO,
            turn_time: AdaptParams::DEFAULT.turn_time,
            slip_time: AdaptParams::DEFAULT.slip_time,
            min_speed: f64::NAN,
            deviation_limit: f64::NAN,
            turn_tolerance: MonitorParams::DEFAULT.turn_tolerance,
        }
    }
}

impl COptions {
    /// The tracker of `law` with these options.
    pub(crate) fn track<L: LateralLaw>(self, law: L) -> Result<Tracker<L>, Failure> {
        let known = |number: f64| (!number.is_nan()).then_some(number);
        let adapt = AdaptParams {
            turn_time: self.turn_time,
            slip_time: self.slip_time,
            min_speed: known(self.min_speed),
        };
        let monitor = MonitorParams {
            deviation_limit: known(self.deviation_limit),
            turn_tolerance: self.turn_tolerance,
        };
        let tracker = match wish("adapt", self.adapt, adapt)? {
            Wish::Usual => Tracker::of(law),
            Wish::Told(adapt) => Tracker::new(law, adapt)?,
        };
        match wish("monitor", self.monitor, monitor)? {
            Wish::Usual => Ok(tracker),
            Wish::Told(monitor) => Ok(tracker.monitored(monitor)?),
        }
    }
}

/// The defaults of `popsteer_pop_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_pop_params_default() -> CPopParams {
    PopParams::DEFAULT.into()
}

/// The defaults of `popsteer_preview_pop_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_preview_pop_params_default() -> CPreviewPopParams {
    PreviewPopParams::DEFAULT.into()
}

/// The defaults of `popsteer_pid_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_pid_params_default() -> CPidParams {
    PidParams::DEFAULT.into()
}

/// The defaults of `popsteer_pure_pursuit_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_pure_pursuit_params_default() -> CPurePursuitParams {
    PurePursuitParams::DEFAULT.into()
}

/// The defaults of `popsteer_stanley_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_stanley_params_default() -> CStanleyParams {
    StanleyParams::DEFAULT.into()
}

/// The defaults of `popsteer_options`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_options_default() -> COptions {
    COptions::default()
}
