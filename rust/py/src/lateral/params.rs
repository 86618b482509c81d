//! The parameters of the lateral laws.

use popsteer_core::lateral::{
    BangBang, BangBangParams, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams,
    PurePursuit, PurePursuitParams, Stanley, StanleyParams,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::params::params;

params! {
    /// Parameters of `Pop`; the paper's Table 1 by default.
    PyPopParams(PopParams) named "PopParams" in "popsteer",
    defaults PopParams::DEFAULT, checked by Pop::new,
    lookahead_gain: f64, "float, default 0.2",
        "Velocity constant k_v [s]: lookahead = min_lookahead + lookahead_gain * speed.";
    min_lookahead: f64, "float, default 6.0",
        "Lookahead at rest ld_min [m]; from the published code, the paper gives none.";
    steer_span: f64, "float, default radians(3)",
        "Optimization range delta_nbd [rad]: candidates lie this far about the last angle.";
    candidate_count: usize, "int, default 21",
        "Optimization resolution: the number of candidates, odd.";
    exact_lookahead: bool, "bool, default True",
        "Whether the lookahead point is the path's first crossing of the circle ahead, instead of what the paper's search finds.";
    lookahead_tolerance: f64, "float, default 0.01",
        "Threshold epsilon of the paper's search [m].";
    window_ahead: f64, "float, default 20.0",
        "Arc ahead of the vehicle that the paper's search looks at [m].";
    grid_spacing: f64, "float, default 0.01",
        "Greatest distance of neighbours on the path as the paper's search re-discretises it [m].";
    horizon: Option<f64>, "float, optional",
        "How long a prediction by the kinematic bicycle with steering lag looks ahead [s]; by default the paper's, a point over one step. The vehicle should come about as far as the lookahead in it: where it does not, the law swings.";
    understeer: f64, "float, default 0.0",
        "With a horizon, the understeer of the bicycle [s^2/m]: yaw rate = speed tan(steer) / (wheelbase + understeer speed^2).";
    steer_lag: f64, "float, default 0.1",
        "With a horizon, the time constant with which the wheels follow their command [s].";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle, in the direction of driving [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
    search_distance: Option<f64>, "float, optional",
        "How far along the path from the last place the vehicle is looked for [m], beside what it travels in a step; two wheelbases by default.";
    lost_distance: Option<f64>, "float, optional",
        "Farther than this from its place the vehicle is lost, and looked for on the whole path [m]; ten wheelbases by default.";
}

params! {
    /// Parameters of `PreviewPop`.
    PyPreviewPopParams(PreviewPopParams) named "PreviewPopParams" in "popsteer",
    defaults PreviewPopParams::DEFAULT, checked by PreviewPop::new,
    steer_span: f64, "float, default radians(12)",
        "Optimization range delta_nbd [rad]: an angle lies at most this far from the last one.";
    max_steer_rate: f64, "float, default radians(60)",
        "Fastest the wheels are told to turn [rad/s]; at a control period of 50 ms, 60 degrees/s are the paper's 3 degrees a step.";
    max_lateral_acceleration: f64, "float, default 15.0",
        "Largest lateral acceleration that an angle may ask for [m/s^2]. Less: a vehicle that is too fast for a bend runs wide instead of sliding.";
    horizon: f64, "float, default 1.0",
        "How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is seen through; shorter than the lag and the way back to the path, the vehicle swings.";
    heading_cost: f64, "float, default 3.0",
        "How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]. More: the path is joined more gently, and offsets take longer to vanish.";
    steer_rate_cost: f64, "float, default 0.25",
        "How many metres of cross-track error are as bad as turning the wheels at 1 rad/s [m s/rad]. More: calmer wheels, less noise passed on, wider bends where the model is wrong.";
    approach_angle: f64, "float, default 0.25",
        "Heading at which the path is approached from afar [rad]. More: sooner back on the path, by a sharper manoeuvre.";
    min_speed: f64, "float, default 5.0",
        "Below this speed [m/s] the wheels turn in proportion to the way travelled, and the prediction looks as far as at this speed; at rest they keep their angle.";
    smoothing_length: f64, "float, default 2.0",
        "Length of path over which its direction is taken [m]. More: less of the waypoints' noise is steered, and bends shorter than this are cut.";
    turn_learning_time: f64, "float, default 0.0",
        "Time in which the law learns how much more the vehicle turns than the model says [s]; 0 never. Shorter: sooner right, and more noise of the heading passed on.";
    slip_learning_time: f64, "float, default 5.0",
        "Time in which it learns at what angle to its heading the vehicle travels, straight on and in bends [s]; 0 never. Shorter: sooner right, and more noise of the position passed on.";
    wheelbase: f64, "float, default 3.0",
        "Effective wheelbase of the model [m].";
    understeer: f64, "float, default 0.0",
        "Understeer of the model [s^2/m]: curvature = tan(steer) / (wheelbase + understeer speed^2).";
    steer_lag: f64, "float, default 0.1",
        "Time constant with which the curvature follows the angle [s].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle, in the direction of driving [m], which is taken not to slip; the rear axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
    search_distance: Option<f64>, "float, optional",
        "How far along the path from the last place the vehicle is looked for [m], beside what it travels in a step; two wheelbases by default.";
    lost_distance: Option<f64>, "float, optional",
        "Farther than this from its place the vehicle is lost, and looked for on the whole path [m]; ten wheelbases by default.";
}

params! {
    /// Parameters of `Pid`; the paper's Table 1 by default.
    PyPidParams(PidParams) named "PidParams" in "popsteer",
    defaults PidParams::DEFAULT, checked by Pid::new,
    kp: f64, "float, default 0.25",
        "Proportional gain k_P [rad/m].";
    ki: f64, "float, default 0.01",
        "Integral gain k_I [rad/(m s)]; [rad/m] without integral_with_dt.";
    kd: f64, "float, default 0.2",
        "Derivative gain k_D [rad s/m].";
    buffer_length: usize, "int, default 500",
        "How many of the last errors the integral sums, against wind-up.";
    integral_with_dt: bool, "bool, default True",
        "Whether the integral weighs each error with its dt; the paper's equation does not.";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle, in the direction of driving [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
    search_distance: Option<f64>, "float, optional",
        "How far along the path from the last place the vehicle is looked for [m], beside what it travels in a step; two wheelbases by default.";
    lost_distance: Option<f64>, "float, optional",
        "Farther than this from its place the vehicle is lost, and looked for on the whole path [m]; ten wheelbases by default.";
}

params! {
    /// Parameters of `PurePursuit`; the paper's Table 1, with the published code's least lookahead.
    PyPurePursuitParams(PurePursuitParams) named "PurePursuitParams" in "popsteer",
    defaults PurePursuitParams::DEFAULT, checked by PurePursuit::new,
    lookahead_gain: f64, "float, default 0.9",
        "Velocity constant k_v [s]: lookahead = max(min_lookahead, lookahead_gain * speed).";
    min_lookahead: f64, "float, default 10.0",
        "Least lookahead [m]; the paper's equation has 0.";
    alpha_by_arccos: bool, "bool, default False",
        "Whether alpha is acos(heading . line / lookahead), as in the published code.";
    exact_lookahead: bool, "bool, default True",
        "Whether the lookahead point is the path's first crossing of the circle ahead, instead of what the paper's search finds; with it, a point behind the vehicle is turned to as one abeam.";
    lookahead_tolerance: f64, "float, default 0.01",
        "Threshold epsilon of the paper's search [m].";
    window_ahead: f64, "float, default 20.0",
        "Arc ahead of the vehicle that the paper's search looks at [m].";
    grid_spacing: f64, "float, default 0.01",
        "Greatest distance of neighbours on the path as the paper's search re-discretises it [m].";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles L [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle [m]; the rear axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
    search_distance: Option<f64>, "float, optional",
        "How far along the path from the last place the vehicle is looked for [m], beside what it travels in a step; two wheelbases by default.";
    lost_distance: Option<f64>, "float, optional",
        "Farther than this from its place the vehicle is lost, and looked for on the whole path [m]; ten wheelbases by default.";
}

params! {
    /// Parameters of `Stanley`; the paper's Table 1 by default.
    PyStanleyParams(StanleyParams) named "StanleyParams" in "popsteer",
    defaults StanleyParams::DEFAULT, checked by Stanley::new,
    cross_track_gain: f64, "float, default 1.5",
        "Crosstrack error constant k_chi [1/s].";
    speed_gain: f64, "float, default 1.3",
        "Velocity constant k_v.";
    softening: f64, "float, default 1e-5",
        "Softening constant k_s [m/s], which keeps the quotient finite at rest.";
    heading_behind: bool, "bool, default False",
        "Whether the path's heading is that of the segment behind the nearest waypoint, as in the published code.";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle, in the direction of driving [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
    search_distance: Option<f64>, "float, optional",
        "How far along the path from the last place the vehicle is looked for [m], beside what it travels in a step; two wheelbases by default.";
    lost_distance: Option<f64>, "float, optional",
        "Farther than this from its place the vehicle is lost, and looked for on the whole path [m]; ten wheelbases by default.";
}

params! {
    /// Parameters of `BangBang`.
    PyBangBangParams(BangBangParams) named "BangBangParams" in "popsteer",
    defaults BangBangParams::DEFAULT, checked by BangBang::new,
    amplitude: f64, "float, default 0.122",
        "The angle that is switched [rad].";
    deadband: f64, "float, default 0.0",
        "Cross-track errors up to this leave the wheels straight [m].";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle, in the direction of driving [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
    search_distance: Option<f64>, "float, optional",
        "How far along the path from the last place the vehicle is looked for [m], beside what it travels in a step; two wheelbases by default.";
    lost_distance: Option<f64>, "float, optional",
        "Farther than this from its place the vehicle is lost, and looked for on the whole path [m]; ten wheelbases by default.";
}
