//! From waypoints and settings to a run.

use std::sync::Arc;

use popsteer_core::error::ConfigError;
use popsteer_core::math::{atan2, cos, sin};
use popsteer_core::path::PathView;
use popsteer_core::speed::{
    Course, Limit, OverSpeed, SpeedLimits, defaults, path_curvature, plan_speeds,
};
use popsteer_core::speed::{SpeedPid, SpeedPidParams};
use popsteer_core::{Path, Tracker, VehicleState};
use popsteer_sim::{
    Controller, Law, Longitudinal, Perception, Settings as Running, Simulation, closed_loop,
};

use crate::Refusal;
use crate::settings::Settings;

/// What keeps the speed: as `popsteer.sim.run` keeps a constant one.
const KEEPING: SpeedPidParams = SpeedPidParams {
    kp: 1.0,
    ki: 0.5,
    kd: 0.0,
};

/// Lets `law` drive along `track` as `settings` say.
pub(crate) fn drive(
    track: &Path,
    law: &Tracker<Law>,
    settings: &Settings,
) -> Result<Simulation, Refusal> {
    let view = track.view();
    let speeds = speeds(&view, settings)?;
    let path = Path::new(view.x(), view.y(), Some(&speeds), view.is_closed())?;
    let start = VehicleState {
        speed: speeds.first().copied().unwrap_or(0.0),
        ..start(&view, settings)
    };
    let (path, plant) = (Arc::new(path), Arc::new(settings.plant));
    let mut run = Simulation::new(path, plant, start, *law.follow(), Running::DEFAULT)?;
    let longitudinal = Longitudinal::Speed(SpeedPid::new(KEEPING)?);
    let (controller, exact) = (&mut Controller::new(law), Perception::EXACT);
    closed_loop::run(&mut run, controller, &longitudinal, exact, |_| true)?;
    Ok(run)
}

/// The speed at each waypoint [m/s].
fn speeds(view: &PathView<'_>, settings: &Settings) -> Result<Vec<f64>, ConfigError> {
    let mut speed = vec![settings.speed; view.len()];
    if !settings.slow_in_bends {
        return Ok(speed);
    }
    let vehicle = settings.plant.vehicle;
    let curvature = path_curvature(view, defaults::SMOOTHING * vehicle.wheelbase);
    let segments = 0..view.segments();
    let spacing: Vec<f64> = segments.map(|k| view.segment_length(k)).collect();
    let limits = SpeedLimits {
        max_speed: settings.speed,
        // As on the embedded tracks: all of the lateral acceleration.
        max_lateral_acceleration: defaults::MAX_LATERAL_ACCELERATION,
        acceleration: OverSpeed::constant(&defaults::MAX_ACCELERATION),
        deceleration: OverSpeed::constant(&defaults::MAX_DECELERATION),
        longitudinal_grip: None,
        exponent: f64::INFINITY,
        vehicle,
    };
    let course = Course {
        curvature: &curvature,
        spacing: &spacing,
        closed: view.is_closed(),
        ..Course::default()
    };
    let mut limit = vec![Limit::default(); speed.len()];
    plan_speeds(&course, &limits, &mut speed, &mut limit)?;
    Ok(speed)
}

/// The pose from which the front axle stands beside the first waypoint and looks along the first
/// segment: that of `popsteer.sim.closed_loop.default_start`, operation by operation.
fn start(view: &PathView<'_>, settings: &Settings) -> VehicleState {
    let at = |values: &[f64], index: usize| values.get(index).copied().unwrap_or(0.0);
    let (x, y) = (at(view.x(), 0), at(view.y(), 0));
    let yaw = atan2(at(view.y(), 1) - y, at(view.x(), 1) - x);
    let (offset, ahead) = (settings.start_offset, settings.plant.vehicle.front_axle());
    let (x, y) = (x - offset * sin(yaw), y + offset * cos(yaw));
    VehicleState {
        x: x - ahead * cos(yaw),
        y: y - ahead * sin(yaw),
        yaw,
        speed: 0.0,
    }
}
