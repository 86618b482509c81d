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
pub mod rollout;
pub mod stanley;
#[cfg(feature = "alloc")]
pub mod tracker;

pub use bang_bang::{BangBang, BangBangParams, BangBangState};
pub use pid::{Pid, PidParams, PidState};
pub use pop::{Pop, PopParams, PopState};
pub use preview_pop::{PreviewPop, PreviewPopParams, PreviewPopState};
pub use pure_pursuit::{PurePursuit, PurePursuitParams, PurePursuitState};
pub use stanley::{Stanley, StanleyParams, StanleyState};
#[cfg(feature = "alloc")]
pub use tracker::{Handover, Tracker, TrackerState};

use core::fmt;

use crate::Point;
use crate::error::{ConfigError, InputError, Requirement, config_in_range, input_in_range};
use crate::math::wrap;
use crate::path::follow::{Follow, Located};
use crate::path::jump::find_lookahead_point;
use crate::path::lookahead::get_crossing;
use crate::path::relocalise::relocalise;
use crate::path::view::PathView;
use crate::vehicle::VehicleState;
use crate::vehicle::state::checked_dt;

/// How a step went: as the law wants it, degraded, or at fault. Of several reasons the one that
/// says most is given, the last of this list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// As the law wants it.
    Ok,
    /// Degraded: the law wants a larger angle than `max_steer` or the lateral acceleration allows,
    /// or a faster move than the actuator makes. The command is limited.
    Saturated,
    /// Degraded: no point ahead lies on the lookahead circle. A stand-in is aimed at.
    LookaheadLost,
    /// Degraded: the reference point is past the end of the path, or `LookaheadLost` there. The
    /// last segment is followed on as a straight line.
    EndOfPath,
    /// Degraded: the vehicle was farther than `lost_distance` from its place on the path, and was
    /// looked for on the whole of it. The law steers to where it was found.
    OffPath,
    /// Degraded: the input was refused. The last command is held.
    InputHeld,
    /// Fault: more inputs in a row were refused than are held. The last angle stands; stop.
    InputLost,
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
    /// Whether the path is driven backwards here.
    pub reverse: bool,
    /// How the step went.
    pub status: Status,
}

/// What all states of laws have in common.
pub trait LateralState {
    /// Puts the remembered waypoint, at which the segment of the last foot starts; the rest stays
    /// as it is.
    fn set_waypoint(&mut self, waypoint: Option<usize>);

    /// Forgets what was measured against the path: another one is followed from now on.
    fn leave_path(&mut self) {
        self.set_waypoint(None);
    }

    /// Takes note of the angle [rad] that the wheels were given instead of the law's answer.
    /// Whether the law's next answer goes on from it.
    fn set_steer(&mut self, _steer: f64) -> bool {
        false
    }
}

/// A steering law: validated parameters that step a state.
pub trait LateralLaw {
    /// What the law remembers from one step to the next.
    type State: Clone + PartialEq + fmt::Debug + LateralState;

    /// The state before the first step.
    fn initial_state(&self) -> Self::State;

    /// Which point of the vehicle the law follows along the path, and how.
    fn follow(&self) -> &Follow;

    /// How far ahead of the rear axle the law's reference point lies [m]; where the path is driven
    /// backwards, how far behind it.
    fn reference_offset(&self) -> f64 {
        self.follow().reference_offset
    }

    /// The largest angle that the law commands [rad].
    fn max_steer(&self) -> f64;

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

    /// After a jump of the vehicle, of its localisation or along the path: finds the waypoint
    /// that the next step goes on from, by [`relocalise`](crate::path::relocalise::relocalise) of
    /// the rear axle. The rest of `state` stays.
    ///
    /// Unlike a step it is exact wherever the vehicle is, and visits every segment at worst.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the first of them that is not finite or beyond its bound; `state` is
    /// then unchanged.
    fn relocalise(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        x: f64,
        y: f64,
        yaw: f64,
    ) -> Result<(), InputError> {
        let speed = 0.0;
        let vehicle = VehicleState { x, y, yaw, speed }.checked()?;
        let position = Point::new(vehicle.x, vehicle.y);
        let opposite_distance = self.follow().opposite_distance;
        let segment = relocalise(path, position, vehicle.yaw, opposite_distance);
        state.set_waypoint(Some(segment));
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
    max_steer: f64,
    follow: Follow,
}

/// The parameters that every law has.
#[derive(Clone, Copy, Debug)]
struct BodyParams {
    wheelbase: f64,
    reference_offset: Option<f64>,
    max_steer: f64,
    search_distance: Option<f64>,
    lost_distance: Option<f64>,
}

macro_rules! body_params {
    ($params:expr) => {
        $crate::lateral::BodyParams {
            wheelbase: $params.wheelbase,
            reference_offset: $params.reference_offset,
            max_steer: $params.max_steer,
            search_distance: $params.search_distance,
            lost_distance: $params.lost_distance,
        }
    };
}
use body_params;

impl Body {
    /// Checks the parameters; `reference_offset` falls back on `default_offset`, the distances on
    /// multiples of the wheelbase.
    fn new(params: BodyParams, default_offset: f64) -> Result<Self, ConfigError> {
        let wheelbase = config_in_range("wheelbase", params.wheelbase, 1e-3, 1e3)?;
        let offset = params.reference_offset.unwrap_or(default_offset);
        let reference_offset = config_in_range("reference_offset", offset, -1e3, 1e3)?;
        let max_steer = config_in_range("max_steer", params.max_steer, 1e-3, 1.57)?;
        let search = params.search_distance.unwrap_or(2.0 * wheelbase);
        let lost = params.lost_distance.unwrap_or(10.0 * wheelbase);
        Ok(Self {
            wheelbase,
            max_steer,
            follow: Follow {
                reference_offset,
                rear_axle: 0.0,
                search_distance: config_in_range("search_distance", search, 0.0, 1e6)?,
                lost_distance: config_in_range("lost_distance", lost, 1e-3, 1e9)?,
                arrival_distance: 0.05 * wheelbase,
                // 10 m for the wheelbase of a car, 3 m, to the last bit.
                opposite_distance: wheelbase * 10.0 / 3.0,
            },
        })
    }

    /// Where am I? A checked input, and the place of the law's reference point.
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
        Ok(self.follow.locate(path, last, vehicle, dt))
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

/// The command of the turned vehicle's angle `steer`, with the errors at the reference point.
#[inline]
fn command(at: &Located, steer: f64, target: Point, status: Status) -> Command {
    let status = if at.off_path {
        Status::OffPath
    } else if at.past_end {
        Status::EndOfPath
    } else {
        status
    };
    Command {
        steer: at.turn(steer),
        cross_track_error: at.foot.cross_track_error(),
        heading_error: wrap(at.vehicle.yaw - at.foot.path_yaw()),
        target,
        reverse: at.reverse,
        status,
    }
}

/// The search for the lookahead point, from the parameters of the same names.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Search {
    lookahead_gain: f64,
    min_lookahead: f64,
    exact_lookahead: bool,
    lookahead_tolerance: f64,
    window_ahead: f64,
    grid_spacing: f64,
}

macro_rules! search_params {
    ($params:expr) => {
        $crate::lateral::Search {
            lookahead_gain: $params.lookahead_gain,
            min_lookahead: $params.min_lookahead,
            exact_lookahead: $params.exact_lookahead,
            lookahead_tolerance: $params.lookahead_tolerance,
            window_ahead: $params.window_ahead,
            grid_spacing: $params.grid_spacing,
        }
    };
}
use search_params;

impl Search {
    fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("lookahead_gain", self.lookahead_gain, 0.0, 1e3)?;
        config_in_range("min_lookahead", self.min_lookahead, 0.0, 1e4)?;
        config_in_range("lookahead_tolerance", self.lookahead_tolerance, 1e-9, 1e3)?;
        config_in_range("window_ahead", self.window_ahead, 1e-3, 1e6)?;
        config_in_range("grid_spacing", self.grid_spacing, 1e-4, 1e3)?;
        Ok(self)
    }

    /// The lookahead point at distance `lookahead` [m] from a located vehicle.
    #[inline]
    fn find(&self, path: &PathView<'_>, at: &Located, lookahead: f64) -> Target {
        let (point, found) = if self.exact_lookahead {
            get_crossing(path, &at.foot, at.position, lookahead)
        } else {
            find_lookahead_point(
                path,
                at.foot.nearest_waypoint(path),
                self.window_ahead,
                self.grid_spacing,
                at.position,
                lookahead,
                self.lookahead_tolerance,
            )
        };
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
