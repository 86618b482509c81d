//! What the benchmarks of `popsteer-core` share: a course to drive, and a lap of it.
//!
//! The course is of the kind of the track that popsteer ships: waypoints about 1 m apart, bends
//! of 30 m least radius to both sides. It is closed, so that a lap goes on into the next one and
//! no controller has to find its place anew while it is timed.

use std::f64::consts::TAU;

use popsteer_core::laws::PopParams;
use popsteer_core::math::from_count;
use popsteer_core::tracker::TrackerState;
use popsteer_core::{LateralLaw, Path, PathError, Reported, Tracker, Vehicle, VehicleState};

/// The control period of the paper [s].
pub const DT: f64 = 0.05;

/// Waypoints of a course as long as the track that popsteer ships.
pub const WAYPOINTS: usize = 1274;

/// A vehicle with 0.2 s between a command and the wheels, limited and off centre, whose controllers
/// predict and estimate it.
pub const DELAYED: Vehicle = Vehicle {
    rear_axle: -1.5,
    steer_offset: 0.01,
    dead_time: 0.2,
    max_steer_rate: Some(1.0),
    ..Vehicle::DEFAULT
};

/// A vehicle that no limit holds on the course: what preview POP costs where it need not plan anew.
pub const FREE: Vehicle = Vehicle {
    max_lateral_acceleration: None,
    max_steer_rate: Some(10.0),
    ..Vehicle::DEFAULT
};

/// A vehicle that its limits hold at every step of the course.
pub const SLOW: Vehicle = Vehicle {
    max_lateral_acceleration: Some(2.0),
    max_steer_rate: Some(0.1),
    ..Vehicle::DEFAULT
};

/// POP with the paper's search, which alone knows window and grid.
pub const PAPER: PopParams = PopParams {
    exact_lookahead: false,
    ..PopParams::DEFAULT
};

/// How far the course swings to either side of its circle [m].
const SWING: f64 = 3.0;

/// From one swing to the next [m].
const WAVELENGTH: usize = 60;

/// A closed path, and the states of a vehicle that drives one lap of it.
#[derive(Clone, Debug)]
pub struct Course {
    /// A circle with a sine on it.
    pub path: Path,
    /// One state each control period, a little beside the path and a little askew.
    pub lap: Vec<VehicleState>,
}

impl Course {
    /// A course of so many waypoints, at least 1000, 1.00 to 1.05 m apart.
    ///
    /// # Errors
    ///
    /// [`PathError`] for a count that makes no path.
    pub fn new(waypoints: usize) -> Result<Self, PathError> {
        let ring = Ring::new(waypoints);
        let (x, y): (Vec<_>, Vec<_>) = (0..waypoints)
            .map(|k| ring.point(TAU * from_count(k) / from_count(waypoints)))
            .unzip();
        Ok(Self {
            path: Path::new(&x, &y, None, true)?,
            lap: ring.lap(),
        })
    }
}

/// The curve of a course: radius over bearing.
#[derive(Clone, Copy, Debug)]
struct Ring {
    radius: f64,
    waves: f64,
}

impl Ring {
    fn new(waypoints: usize) -> Self {
        Self {
            radius: from_count(waypoints) / TAU + SWING,
            waves: from_count(waypoints / WAVELENGTH),
        }
    }

    fn point(self, bearing: f64) -> (f64, f64) {
        let radius = self.radius + SWING * (self.waves * bearing).sin();
        (radius * bearing.cos(), radius * bearing.sin())
    }

    /// Direction of the curve [rad].
    fn heading(self, bearing: f64) -> f64 {
        let radius = self.radius + SWING * (self.waves * bearing).sin();
        let slope = SWING * self.waves * (self.waves * bearing).cos();
        bearing + radius.atan2(slope)
    }

    /// A drive at 6 to 16 m/s; errors and speed swing with periods that share no multiple.
    fn lap(self) -> Vec<VehicleState> {
        let mut lap = Vec::new();
        let mut bearing = 0.0;
        while bearing < TAU {
            let k = from_count(lap.len());
            let heading = self.heading(bearing);
            let aside = 0.3 * (0.11 * k).sin();
            let (x, y) = self.point(bearing);
            let speed = 11.0 + 5.0 * (0.013 * k).sin();
            lap.push(VehicleState {
                x: x - aside * heading.sin(),
                y: y + aside * heading.cos(),
                yaw: heading + 0.03 * (0.17 * k).sin(),
                speed,
            });
            bearing += speed * DT / self.radius;
        }
        lap
    }
}

/// A controller on its way around a course, lap after lap.
#[derive(Clone, Debug)]
pub struct LapRunner<'a, L: LateralLaw> {
    course: &'a Course,
    tracker: Tracker<L>,
    state: TrackerState<L::State>,
    next: usize,
}

impl<'a, L: LateralLaw> LapRunner<'a, L> {
    /// The controller after its first lap, with the search for the first waypoint behind it.
    pub fn new(course: &'a Course, tracker: Tracker<L>) -> Self {
        let state = tracker.initial_state();
        let mut drive = Self {
            course,
            tracker,
            state,
            next: 0,
        };
        for _ in &course.lap {
            let _ = drive.steer();
        }
        drive
    }

    /// The next angle [rad]; not a number where the state is refused.
    #[inline]
    pub fn steer(&mut self) -> f64 {
        let (vehicle, path, state) = (self.vehicle(), self.course.path.view(), &mut self.state);
        let answer = self
            .tracker
            .steer(&path, state, vehicle, DT, Reported::NOTHING);
        answer.unwrap_or(f64::NAN)
    }

    /// The next command; none where the state is refused.
    #[inline]
    pub fn step(&mut self) -> Option<popsteer_core::Command> {
        let (vehicle, path, state) = (self.vehicle(), self.course.path.view(), &mut self.state);
        let answer = self
            .tracker
            .step(&path, state, vehicle, DT, Reported::NOTHING);
        answer.ok()
    }

    #[inline]
    fn vehicle(&mut self) -> VehicleState {
        let vehicle = self.course.lap[self.next];
        self.next += 1;
        if self.next == self.course.lap.len() {
            self.next = 0;
        }
        vehicle
    }
}

#[cfg(test)]
mod tests;
