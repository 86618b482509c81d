//! PID on the cross-track error, the paper's Equation 1.

pub mod error_buffer;

use crate::bounds::MAX_COORDINATE;
use crate::error::{ConfigError, InputError, input_within};
use crate::geometry::Point;
use crate::laws::law::Tracked;
use crate::laws::params::law_params;
use crate::laws::pid::error_buffer::{BOUND, ErrorBuffer};
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::math::{cos, larger, saturate, sin};
use crate::path::follow::Located;
use crate::path::preview::Preview;
use crate::path::view::PathView;
use crate::vehicle::Vehicle;
use crate::vehicle::state::check_count;

law_params! {
    /// Parameters of [`Pid`]; the paper's Table 1 at the paper's car, whose wheelbase is 3 m.
    pub struct PidParams<Scaled> of Vehicle(wheelbase) {
        /// Proportional gain `k_P` [rad/m].
        kp: Scaled = 0.25 * (3.0 / wheelbase), in [0.0, 1e6];
        /// Integral gain `k_I` [rad/(m s)], or [rad/m] without `integral_with_dt`.
        ki: Scaled = 0.01 * (3.0 / wheelbase), in [0.0, 1e6];
        /// Derivative gain `k_D` [rad s/m].
        kd: Scaled = 0.2 * (3.0 / wheelbase), in [0.0, 1e6];
        /// How many of the last errors the integral sums, against wind-up.
        buffer_length: usize = 500, in [1, 500];
        /// Whether the integral weighs each error with its dt, as the published code does; the
        /// paper's equation sums the bare errors.
        integral_with_dt: bool = true;
        /// Length of path over which its heading is taken [m]. The derivative is then how fast the
        /// front axle moves across that heading, which noise of the waypoints hardly reaches. 0:
        /// that of the error, as printed.
        smoothing_length: Scaled = 2.0 * wheelbase, in [0.0, 1e4];
        /// Time constant of the first-order filter of the derivative [s]: the common Td/N with
        /// N = 16 at the paper's gains. Without it (0, as printed) noise counts as often as inputs
        /// come, and wheels without a lag oscillate above 1/`kd` m/s, for the front axle moves
        /// across the path as soon as they turn.
        derivative_filter: f64 = 0.05, in [0.0, 1e3];
    }
}

const _: () = assert!(ErrorBuffer::CAPACITY == 500, "the most of `buffer_length`");

/// What [`Pid`] remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PidState {
    /// The last cross-track error [m]; None before the first step.
    pub previous_error: Option<f64>,
    /// Where the front axle was at the last step that the controller decided, which none at rest is
    /// [m]; None before the first, and without a `smoothing_length`.
    pub previous_position: Option<Point>,
    /// The filtered derivative [m/s].
    pub rate: f64,
    /// The terms of the integral.
    pub buffer: ErrorBuffer,
}

/// `steer = -(kp e + ki sum(e dt) + kd r)` on the cross-track error `e` at the front axle, with
/// the derivative `r = (T r_previous + e - e_previous) / (T + dt)`, `T` the `derivative_filter`:
/// the backward difference of `kd s / (1 + T s)` (Åström and Hägglund, Advanced PID Control, 2006,
/// section 3.3). It holds for periods that differ, too.
///
/// The sign is that of this crate's error, positive left of the path. The first step has no
/// derivative. With a `smoothing_length` the derivative is that of the front axle's offset from a
/// line along the path's heading, which on a smooth path is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pid {
    steered: Steered,
    params: PidParams<f64>,
}

impl Pid {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: PidParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle).checked()?;
        Ok(Self {
            steered: Tracked::FrontAxle.of(&vehicle, params.search_distance, params.lost_distance),
            params,
        })
    }

    /// How far the front axle moved across the path since it was at `previous` [m], positive to
    /// the left. The path's heading is that in the middle of the step, so that in a bend the step
    /// is held against its own stretch of the path.
    #[inline]
    fn moved_across(&self, path: &PathView<'_>, previous: Point, at: &Located) -> f64 {
        let step = at.position - previous;
        let half = 0.5 * step.dot(&at.heading);
        let middle = at.closest.arc_length(path) - half;
        let (smoothing, segment) = (self.params.smoothing_length, at.closest.segment);
        let yaw = Preview::yaw_at(path, smoothing, segment, middle);
        step.y * cos(yaw) - step.x * sin(yaw)
    }
}

impl LateralState for PidState {
    fn leave_path(&mut self) {
        self.interrupt();
        self.buffer = ErrorBuffer::new(self.buffer.length());
    }

    /// The integral carries on; the derivative would take all that happened since for one period's.
    fn interrupt(&mut self) {
        self.previous_error = None;
        self.previous_position = None;
        self.rate = 0.0;
    }

    /// The integral carries on, and the derivative sees no jump of the error.
    fn change_path(&mut self, offset: Option<f64>) {
        self.previous_error = match (self.previous_error, offset) {
            (Some(error), Some(offset)) => Some(saturate(error + offset, -BOUND, BOUND)),
            _ => None,
        };
    }
}

impl LateralLaw for Pid {
    type State = PidState;

    fn initial_state(&self) -> PidState {
        PidState {
            previous_error: None,
            previous_position: None,
            rate: 0.0,
            buffer: ErrorBuffer::new(self.params.buffer_length),
        }
    }

    fn steered(&self) -> &Steered {
        &self.steered
    }

    #[inline]
    fn pull(&self, at: &Located) -> f64 {
        // The derivative answers the heading: the front axle moves across the path at speed sin(heading).
        let gain = larger(self.params.kd * at.vehicle.forward_speed(), 1.0);
        self.params.kp * at.closest.cross_track_error() * gain
    }

    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PidState,
        at: &Located,
        _belief: &Belief,
    ) -> Decision {
        let params = &self.params;
        let error = at.closest.cross_track_error();
        if at.direction_changed || at.off_path {
            state.leave_path();
        }
        // At rest an error cannot be steered away; summing it would wind the integral up.
        if at.vehicle.forward_speed() > 0.0 {
            state.buffer.push(if params.integral_with_dt {
                error * at.dt
            } else {
                error
            });
        }
        let moved = if params.smoothing_length > 0.0 {
            let previous = state.previous_position.replace(at.position);
            previous.map(|previous| self.moved_across(path, previous, at))
        } else {
            // One that a state of other parameters brought along does not count.
            state.previous_position = None;
            state.previous_error.map(|previous| error - previous)
        };
        let lag = params.derivative_filter;
        state.rate = moved.map_or(0.0, |moved| (lag * state.rate + moved) / (lag + at.dt));
        let wanted = -(params.kp * error + params.ki * state.buffer.sum() + params.kd * state.rate);
        let (steer, status) = self.vehicle().limit_steer(wanted);
        state.previous_error = Some(error);
        Decision {
            steer,
            target: at.closest.point,
            status,
        }
    }

    fn check_state(&self, state: &PidState) -> Result<(), InputError> {
        if let Some(error) = state.previous_error {
            input_within("law.previous_error", error, BOUND)?;
        }
        if let Some(position) = state.previous_position {
            let most = 4.0 * MAX_COORDINATE;
            input_within("law.previous_position", position.x, most)?;
            input_within("law.previous_position", position.y, most)?;
        }
        input_within("law.rate", state.rate, BOUND)?;
        let length = self.params.buffer_length;
        check_count("law.buffer.length", state.buffer.length(), length, length)?;
        state.buffer.check()
    }
}
