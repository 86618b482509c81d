//! From waypoints and settings to a run.

use std::sync::Arc;

use popsteer_core::math::{atan2, cos, sin};
use popsteer_core::path::PathView;
use popsteer_core::speed::{SpeedPid, SpeedPidParams, SpeedTracker, SpeedTrackerParams};
use popsteer_core::{Driver, DriverParams, Path, Tracker, Vehicle, VehicleState};
use popsteer_sim::{
    Controller, Driving, Law, Longitudinal, Perception, Settings as Running, Simulation,
    closed_loop,
};

use crate::Refusal;
use crate::settings::Settings;

/// What keeps a constant speed: as `popsteer.sim.run` does.
const KEEPING: SpeedPidParams = SpeedPidParams {
    kp: 1.0,
    ki: 0.5,
    kd: 0.0,
};

/// Lets `law` drive along `track` as `settings` say: alone, at a constant speed, or in a driver, which
/// plans the speeds.
pub(crate) fn drive(
    track: &Path,
    law: &Tracker<Law>,
    settings: &Settings,
) -> Result<Simulation, Refusal> {
    let view = track.view();
    let (mut begun, plant) = (start(&view, settings), Arc::new(settings.plant));
    let running = Running::DEFAULT;
    let longitudinal = Longitudinal::Speed(SpeedPid::new(KEEPING)?);
    if settings.slow_in_bends {
        let car = Vehicle {
            max_speed: Some(settings.speed),
            ..settings.believed
        };
        let speed = SpeedTracker::new(car, SpeedTrackerParams::DEFAULT)?;
        let (plan, path) = (speed.plan(&view)?, Arc::new(track.clone()));
        begun.speed = plan.first().copied().unwrap_or(0.0);
        let mut run = Simulation::new(path, plant, begun, *law.follow(), running)?;
        let driver = Driver::new(*law, speed, DriverParams::DEFAULT)?;
        let (driver, exact) = (&mut Driving::new(&driver, &plan), Perception::EXACT);
        closed_loop::run(&mut run, driver, &longitudinal, exact, |_| true)?;
        return Ok(run);
    }
    let speeds = vec![settings.speed; view.len()];
    let path = Path::new(view.x(), view.y(), Some(&speeds), view.is_closed())?;
    begun.speed = settings.speed;
    let mut run = Simulation::new(Arc::new(path), plant, begun, *law.follow(), running)?;
    let (controller, exact) = (&mut Controller::new(law), Perception::EXACT);
    closed_loop::run(&mut run, controller, &longitudinal, exact, |_| true)?;
    Ok(run)
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
