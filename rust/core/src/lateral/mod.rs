//! The steering laws, one a file, all behind [`LateralLaw`].
//!
//! A law is its validated parameters; what it remembers between steps is a state of its own, so
//! that one law can drive many vehicles, and a state can be copied, compared and restored.

pub mod bang_bang;
pub mod cost_to_go;
pub mod pid;
pub mod pop;
pub mod preview_pop;
pub mod pure_pursuit;
pub mod stanley;

pub use bang_bang::{BangBang, BangBangParams, BangBangState};
pub use pid::{Pid, PidParams, PidState};
pub use pop::{Pop, PopParams, PopState};
pub use preview_pop::{PreviewPop, PreviewPopParams, PreviewPopState};
pub use pure_pursuit::{PurePursuit, PurePursuitParams, PurePursuitState};
pub use stanley::{Stanley, StanleyParams, StanleyState};

use core::fmt;

use crate::Point;
use crate::error::{ConfigError, InputError, Requirement, config_in_range, input_in_range};
use crate::math::wrap;
use crate::path::jump::find_lookahead_point;
use crate::path::locate::{Projection, locate, project};
use crate::path::relocalise::relocalise;
use crate::path::view::PathView;
use crate::vehicle::VehicleState;
use crate::vehicle::state::checked_dt;

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// As the law wants it.
    Ok,
    /// No point of the window lies on the lookahead circle; the last one stands in for it.
    LookaheadLost,
    /// The law wants a larger angle than `max_steer`, or than the lateral acceleration allows.
    Saturated,
}

/// What one step answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Angle of the front wheels [rad], positive to the left.
    pub steer: f64,
    /// Offset of the law's reference point from the path [m], positive left of it.
    pub cross_track_error: f64,
    /// Yaw of the vehicle less direction of the path [rad], in `[-pi, pi]`.
    pub heading_error: f64,
    /// The point aimed at: the lookahead point, or the foot on the path [m].
    pub target: Point,
    /// How the step went.
    pub status: Status,
}

/// A state that remembers where on the path the vehicle is.
pub trait WaypointState {
    /// Puts the remembered waypoint; the rest stays as it is.
    fn set_waypoint(&mut self, waypoint: usize);
}

macro_rules! waypoint_states {
    ($($state:ty),+) => {$(
        impl WaypointState for $state {
            #[inline]
            fn set_waypoint(&mut self, waypoint: usize) {
                self.waypoint = Some(waypoint);
            }
        }
    )+};
}
waypoint_states!(
    BangBangState,
    PidState,
    PopState,
    PreviewPopState,
    PurePursuitState,
    StanleyState
);

/// A steering law: validated parameters that step a state.
pub trait LateralLaw {
    /// What the law remembers from one step to the next.
    type State: Clone + PartialEq + fmt::Debug + WaypointState;

    /// The state before the first step.
    fn initial_state(&self) -> Self::State;

    /// How far ahead of the rear axle the law's reference point lies [m].
    fn reference_offset(&self) -> f64;

    /// One control step: locate `vehicle` (pose of the rear axle) on `path`, aim, steer.
    ///
    /// # Errors
    ///
    /// [`InputError`] where a number in `vehicle`, or `dt`, is not finite or beyond its bound;
    /// `state` is then unchanged.
    fn step(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError>;

    /// The angle of [`step`](Self::step) alone [rad]; same state afterwards.
    ///
    /// # Errors
    ///
    /// As [`step`](Self::step).
    fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<f64, InputError> {
        self.step(path, state, vehicle, dt)
            .map(|command| command.steer)
    }

    /// Where the law's reference point is while the rear axle is at (`x`, `y`) [m], its heading
    /// `yaw` [rad].
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the first of them that is not finite or beyond its bound.
    fn reference_point(&self, x: f64, y: f64, yaw: f64) -> Result<Point, InputError> {
        let speed = 0.0;
        let vehicle = VehicleState { x, y, yaw, speed }.checked()?;
        Ok(vehicle.point_ahead(self.reference_offset()))
    }

    /// After a jump of the vehicle, of its localisation or along the path: finds the waypoint
    /// that the next step goes on from, by [`relocalise`]. The rest of `state` stays.
    ///
    /// Visits every waypoint, unlike a step.
    ///
    /// # Errors
    ///
    /// As [`reference_point`](Self::reference_point); `state` is then unchanged.
    fn relocalise(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        x: f64,
        y: f64,
        yaw: f64,
    ) -> Result<(), InputError> {
        let position = self.reference_point(x, y, yaw)?;
        state.set_waypoint(relocalise(path, position, yaw));
        Ok(())
    }

    /// Whether `state` is one that this law could have on `path`.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    fn check_state(&self, path: &PathView<'_>, state: &Self::State) -> Result<(), InputError>;
}

/// The vehicle as every law takes it, from the parameters of the same names.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Body {
    wheelbase: f64,
    reference_offset: f64,
    max_steer: f64,
}

impl Body {
    /// Checks the parameters; `reference_offset` falls back on `default_offset`.
    fn new(
        wheelbase: f64,
        reference_offset: Option<f64>,
        default_offset: f64,
        max_steer: f64,
    ) -> Result<Self, ConfigError> {
        let reference_offset = reference_offset.unwrap_or(default_offset);
        Ok(Self {
            wheelbase: config_in_range("wheelbase", wheelbase, 1e-3, 1e3)?,
            reference_offset: config_in_range("reference_offset", reference_offset, -1e3, 1e3)?,
            max_steer: config_in_range("max_steer", max_steer, 1e-3, 1.57)?,
        })
    }

    /// Where am I? The reference point of a checked vehicle, and the waypoint nearest to it.
    #[inline]
    fn locate(
        &self,
        path: &PathView<'_>,
        last: Option<usize>,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Located, InputError> {
        let vehicle = vehicle.checked()?;
        let dt = checked_dt(dt)?;
        let position = vehicle.point_ahead(self.reference_offset);
        Ok(Located {
            position,
            nearest: locate(path, last, position),
            vehicle,
            dt,
        })
    }

    /// An angle brought within the limit, and whether it had to be.
    #[inline]
    fn limit(&self, steer: f64) -> (f64, Status) {
        if steer > self.max_steer {
            (self.max_steer, Status::Saturated)
        } else if steer < -self.max_steer {
            (-self.max_steer, Status::Saturated)
        } else {
            (steer, Status::Ok)
        }
    }
}

/// A checked input, and where on the path it is.
#[derive(Clone, Copy, Debug)]
struct Located {
    position: Point,
    nearest: usize,
    vehicle: VehicleState,
    dt: f64,
}

impl Located {
    #[inline]
    fn project(&self, path: &PathView<'_>) -> Projection {
        project(path, self.nearest, self.position)
    }

    #[inline]
    fn heading_error(&self, projection: &Projection) -> f64 {
        wrap(self.vehicle.yaw - projection.path_yaw)
    }

    /// The command with the errors at the reference point.
    #[inline]
    fn command(
        &self,
        projection: &Projection,
        steer: f64,
        target: Point,
        status: Status,
    ) -> Command {
        Command {
            steer,
            cross_track_error: projection.cross_track_error,
            heading_error: self.heading_error(projection),
            target,
            status,
        }
    }
}

/// The search for the lookahead point, from the parameters of the same names.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Search {
    lookahead_gain: f64,
    min_lookahead: f64,
    lookahead_tolerance: f64,
    window_ahead: f64,
    grid_spacing: f64,
}

impl Search {
    fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("lookahead_gain", self.lookahead_gain, 0.0, 1e3)?;
        config_in_range("min_lookahead", self.min_lookahead, 0.0, 1e4)?;
        config_in_range("lookahead_tolerance", self.lookahead_tolerance, 1e-9, 1e3)?;
        config_in_range("window_ahead", self.window_ahead, 1e-3, 1e6)?;
        config_in_range("grid_spacing", self.grid_spacing, 1e-4, 1e3)?;
        Ok(self)
    }

    /// The lookahead point at distance `lookahead` [m] in the window around a located vehicle.
    #[inline]
    fn find(&self, path: &PathView<'_>, at: &Located, lookahead: f64) -> Target {
        let (point, found) = find_lookahead_point(
            path,
            at.nearest,
            self.window_ahead,
            self.grid_spacing,
            at.position,
            lookahead,
            self.lookahead_tolerance,
        );
        Target { point, found }
    }
}

/// The point to aim at, and whether it lies on the lookahead circle.
#[derive(Clone, Copy, Debug)]
struct Target {
    point: Point,
    found: bool,
}

/// Whether a remembered waypoint is one of `path`.
fn check_waypoint(path: &PathView<'_>, waypoint: Option<usize>) -> Result<(), InputError> {
    match waypoint {
        Some(index) if index >= path.len() => Err(InputError {
            field: "waypoint",
            value: crate::math::from_count(index),
            requirement: Requirement::Below(path.len()),
        }),
        _ => Ok(()),
    }
}

/// Whether a remembered angle is within the limit.
fn check_steer(field: &'static str, steer: f64, max_steer: f64) -> Result<(), InputError> {
    input_in_range(field, steer, -max_steer, max_steer).map(|_| ())
}
