//! Estimates what the vehicle's parameters do not say, from its motion. All controllers share it.
//!
//! Four extended Kalman filters ([`Walk`]), each of a measured level and of the parameters that its
//! changes show. Their models of the change in a period of `dt`:
//!
//! ```text
//! yaw      gain L / (L + k v²) (a + offset b - (later - t) c)
//! aside    s (slip + (length + compliance v²) bend)
//! speed    acceleration dt
//! ahead    scale s - age (change of the speed)
//!
//! a = v / L ∫ tan(wheel) dt,   b = v / L ∫ (1 + tan(wheel)²) dt,
//! c = v / L (tan(wheel at the end) - tan(wheel at the start))
//! ```
//!
//! with the mean speed `v`, the distance `s = v dt`, and the turning length `L` of the vehicle's
//! parameters at that speed, all lengths in wheelbases, so that vehicles of every size learn alike. What
//! is looked for: a turning `gain`, an understeer `k` [s²], a steering `offset` [rad] and a dead time
//! [s] in addition to those given. A dead time that is longer by
//! `later` shifts the wheels' motion; the wheels of `a`, `b` and `c` are shifted by `t` already. The
//! no-slip point moves `ahead` by a `scale` of what the speed signal says (wheels that slip, tyres of
//! another size, a unit); an `age` [s] of the poses, or of the speed, that nobody told keeps out of it
//! what an acceleration explains. It moves `aside` of the heading by a `slip` [rad], by a wrong place of that point,
//! `length`, and by tyres that slip in proportion to the lateral acceleration `v² bend`,
//! `compliance` [s²]; `bend` is the curvature by the wheels when the period began.
//!
//! What explains a turn or a slip is decided by how far each parameter may be from the given one
//! (the prior's standard deviations) and by where they differ: gain and understeer at other speeds, gain
//! and offset in other bends, the dead time where wheels move. What only one of them explains, the
//! others keep out of.
//!
//! What the models leave open is named in `q`: dynamics of the tyres, a share of the turning rate;
//! play, an angle of the wheels; both change within [`Estimator::OPEN_TIME`], so `q = 2 OPEN_TIME rate²
//! dt`. Aside, the noise of the heading is in it too. The slope `c` by the dead time is that of wheels which
//! have turned evenly for so long: as far as `c` differs from its mean over [`Estimator::MAX_LONGER`], `q` has
//! the square of that times the variance of `later`. Without it, wheels that have not begun to turn count as
//! wheels that turn the vehicle less.
//!
//! A vehicle whose speed, filtered by `speed` above, does not stand out of its noise does not move: of that noise
//! no turn is a multiple, and the way for it would be none.
//!
//! How noisy positions and speeds are, in wheelbases, nobody knows at first: of few of them the noise counts as larger
//! ([`Noise`](super::noise)).
//!
//! Most vehicles hardly slip or accelerate. So slip, its length and the acceleration count only as far
//! as they stand out of what is not known of them ([`Walk::beyond_doubt`]).
//!
//! A lag that is shorter than given is less dead time than none: the lag is shorter by it
//! ([`Estimate::steer_lag`]). One that is longer is mostly taken for dead time.

use super::kalman::{self, Change, Innovation, Walk};
use super::wheels::{Reached, WheelIntegrals};
use super::{AdaptParams, Estimate, Vehicle, VehicleState};
use crate::bounds::{MAX_COORDINATE, MAX_SPEED, MAX_YAW};
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{cos, exp, larger, saturate, sin, smaller, sqrt, wrap};
use nalgebra::SVector;

mod driven;

/// The estimator's state: the filters, and the [`Estimate`] they give.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimator {
    /// State of the no-slip point when it was last measured, with the speed as told; none if the motion since then must not
    /// be used.
    pub last_measured: Option<VehicleState>,
    /// What the wheels did since then, where no pose was measured at the last step.
    pub unseen: Option<Reached>,
    /// The yaw: gain, understeer, steering offset and dead time.
    pub turning: Walk<4>,
    /// The position aside of the heading: slip, length and compliance.
    pub sliding: Walk<3>,
    /// The speed: acceleration.
    pub pace: Walk<1>,
    /// The position along the heading: scale of the speed signal less 1, and age of the pose.
    pub driving: Walk<2>,
    /// How fast the tangent of the wheels' angle lately changed, a mean over
    /// [`MAX_LONGER`](Self::MAX_LONGER) [1/s].
    pub wheel_rate: f64,
    /// Standard deviation of the gain at the present speed.
    pub gain_deviation: f64,
    /// The present estimates.
    pub estimate: Estimate,
}

impl Default for Estimator {
    fn default() -> Self {
        Self {
            last_measured: None,
            unseen: None,
            turning: Walk::new([1.0, 0.0, 0.0, 0.0], &Self::TURNING, Self::YAW_NOISE),
            sliding: Walk::new([0.0; 3], &Self::SLIDING, Self::POSITION_NOISE),
            pace: Walk::new([0.0], &[Self::ACCELERATION], Self::SPEED_NOISE),
            driving: Self::driving(),
            wheel_rate: 0.0,
            gain_deviation: Self::TURNING[0],
            estimate: Estimate::DEFAULT,
        }
    }
}

impl Estimator {
    /// Variances of the noise before any was seen: of the yaw [rad^2], of position and speed
    /// in wheelbases.
    pub(crate) const YAW_NOISE: f64 = 2.5e-5;
    const POSITION_NOISE: f64 = 1.4e-5;
    const SPEED_NOISE: f64 = 3e-5;
    /// Below so many wheelbases a second a vehicle forgets more slowly, at rest not at all.
    pub(crate) const SLOW: f64 = 0.2;
    /// How far gain [-], understeer [s^2], offset [rad] and dead time [s] may be from those given:
    /// standard deviations. 0.012 s² is an understeer of 0.004 s²/m of a vehicle of 3 m.
    const TURNING: [f64; 4] = [0.1, 0.012, 0.05, 0.05];
    /// The same of slip [rad], length, and compliance [s^2].
    const SLIDING: [f64; 3] = [0.02, 0.1, 0.01];
    /// The same of an acceleration in wheelbases [1/s^2], by how much it changes in a second, and for how
    /// long one lasts that is measured no more [s]. More than 0.5, or less noise than 3e-5: the first noise
    /// of a speed is taken for an acceleration. From 0.15 to 1 of change the circuits, the parking and the
    /// loop of docs/loop.md with its noise differ by a tenth.
    const ACCELERATION: f64 = 0.5;
    const ACCELERATION_CHANGE: f64 = 0.3;
    const ACCELERATION_TIME: f64 = 0.2;
    /// What the models leave open: a share of the turning rate, an angle of the wheels [rad], an
    /// angle of slip [rad], each for this time [s].
    const OPEN_TURN: f64 = 0.03;
    const OPEN_WHEEL: f64 = 0.002;
    const OPEN_SLIP: f64 = 0.003;
    const OPEN_TIME: f64 = 0.1;
    /// How fast the dead time changes [s/s]. Faster: one that nobody told costs less; slower: wheels
    /// that stick are not taken for late ones before the monitor sees them.
    const DELAY_RATE: f64 = 0.1;
    /// Shortest dead time that counts where none was given [s].
    const LEAST_DEAD_TIME: f64 = 0.005;
    /// How much longer than given the dead time may turn out [s].
    pub const MAX_LONGER: f64 = 0.25;
    /// Least gain: a lesser one would mean that the parameters are those of another vehicle.
    pub const MIN_GAIN: f64 = 0.4;
    /// Largest gain: a larger one would mean that the parameters are those of another vehicle.
    pub const MAX_GAIN: f64 = 2.5;
    /// The gains of a vehicle of which nothing is known.
    pub(crate) const GAINS: (f64, f64) = (Self::MIN_GAIN, Self::MAX_GAIN);
    /// An estimate may be off by so many of its standard deviations.
    const DEVIATIONS: f64 = 3.0;
    /// Bound of the estimated steering offset [rad].
    pub const MAX_STEER_OFFSET: f64 = 0.15;
    /// Bound of the estimated understeer and compliance [s^2].
    const MAX_UNDERSTEER: f64 = 1.0;
    /// Bound of the estimated slip [rad].
    pub const MAX_SLIP: f64 = 0.15;
    /// Bound of the estimated acceleration, in wheelbases [1/s^2].
    const MAX_ACCELERATION: f64 = 20.0;

    /// Share of the time that counts for forgetting: what a vehicle has shown is not to be forgotten
    /// while it stands and shows nothing.
    #[inline]
    fn moving(vehicle: &Vehicle, speed: f64) -> f64 {
        smaller(speed.abs() / (Self::SLOW * vehicle.wheelbase), 1.0)
    }

    /// Bounds of `longer_dead_time` [s]: from neither dead time nor lag to [`Self::MAX_LONGER`] more.
    #[inline]
    fn longer_range(vehicle: &Vehicle) -> (f64, f64) {
        (-vehicle.dead_time - vehicle.steer_lag, Self::MAX_LONGER)
    }

    /// Updates the scale of the speed, gain, steering offset, dead time and acceleration from the
    /// motion in the last `dt` [s]. `now` is the state of the no-slip point with the speed as told,
    /// `reached` what the wheels did in that time.
    #[inline]
    pub fn observe_turn(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        now: VehicleState,
        reached: WheelIntegrals,
        dt: f64,
    ) {
        let Some(before) = self.last_measured else {
            self.turning.interrupt();
            self.sliding.interrupt();
            self.pace.interrupt();
            self.driving.interrupt();
            // Of an acceleration that is measured no more less and less is believed.
            self.pace.mean *= exp(-dt / Self::ACCELERATION_TIME);
            self.estimate.acceleration *= exp(-dt / Self::ACCELERATION_TIME);
            return;
        };
        if params.speed_time > 0.0 {
            self.observe_driven(params, vehicle, [before, now], dt);
        }
        self.observe_pace(
            vehicle,
            self.estimate.speed_scale * (now.speed - before.speed),
            dt,
        );
        if params.turn_time > 0.0 {
            let speed = self.moving_speed(vehicle, before.speed, now.speed);
            let measured = wrap(now.yaw - before.yaw);
            self.observe_yaw(params.turn_time, vehicle, reached, (measured, speed), dt);
            self.publish(vehicle, self.estimate.speed_scale * now.speed);
        }
    }

    /// The speed without most of its noise, in wheelbases [1/s], by the `last` speed that was told [m/s]; 0 where it
    /// does not stand out of what is left. At rest noise would be a speed whose turns and distances are
    /// none.
    #[inline]
    fn filtered_speed(&self, vehicle: &Vehicle, last: f64) -> f64 {
        let filtered = self.estimate.speed_scale * last / vehicle.wheelbase + self.pace.level;
        let doubt = Self::DEVIATIONS * Self::DEVIATIONS * self.pace.variance;
        if filtered * filtered > doubt {
            filtered
        } else {
            0.0
        }
    }

    /// The mean speed [m/s] of a period, where the vehicle does not stand.
    #[inline]
    fn moving_speed(&self, vehicle: &Vehicle, before: f64, now: f64) -> f64 {
        let speed = self.estimate.speed_scale * (0.5 * (before + now));
        let moves = self.filtered_speed(vehicle, now).abs() > 0.0;
        if moves { speed } else { 0.0 }
    }

    fn observe_pace(&mut self, vehicle: &Vehicle, measured: f64, dt: f64) {
        let change = Change {
            measured: measured / vehicle.wheelbase,
            expected: self.pace.get(0) * dt,
            slopes: SVector::<f64, 1>::new(dt),
            open: 0.0,
            noise: self.pace.noise.variance_at_most(),
            dt,
        };
        self.pace.observe(&change, Self::SPEED_NOISE);
        self.pace
            .keep(0, -Self::MAX_ACCELERATION, Self::MAX_ACCELERATION);
        let found = self.pace.beyond_doubt(&SVector::<f64, 1>::new(1.0));
        self.estimate.acceleration = found * vehicle.wheelbase;
        self.pace
            .drift(dt, &[Self::ACCELERATION_CHANGE], &[Self::ACCELERATION]);
    }

    /// `q` of a turn at `rate` [rad/s] for `dt` [s], where a radian of the wheels turns the vehicle at
    /// `share` [rad/s].
    #[inline]
    pub(crate) fn open_turn(rate: f64, share: f64, dt: f64) -> f64 {
        let (tyres, play) = (Self::OPEN_TURN * rate, Self::OPEN_WHEEL * share);
        2.0 * Self::OPEN_TIME * (tyres * tyres + play * play) * dt
    }

    /// Updates the yaw's parameters from a turn [rad] `measured` at a mean `speed` [m/s].
    #[inline]
    fn observe_yaw(
        &mut self,
        time: f64,
        vehicle: &Vehicle,
        reached: WheelIntegrals,
        (measured, speed): (f64, f64),
        dt: f64,
    ) -> Innovation {
        let [gain, understeer, offset, later] = [0, 1, 2, 3].map(|k| self.turning.get(k));
        let length = vehicle.turning_length(speed);
        let square = speed * speed / vehicle.wheelbase;
        let longer = length + understeer * square;
        // The derivatives by the offset, by the dead time and by the wheels' turn.
        let share = speed / longer;
        let wheels = share
            * (reached.turn + offset * reached.slope
                - (later - self.estimate.longer_dead_time) * reached.change);
        let expected = gain * wheels;
        let slopes = SVector::<f64, 4>::new(
            wheels,
            -expected * (square / longer),
            gain * share * reached.slope,
            -gain * share * reached.change,
        );
        // The slope by the dead time holds for wheels that have turned evenly for that long.
        let uneven = reached.change - self.wheel_rate * dt;
        let late = gain * share * uneven;
        self.wheel_rate += uneven / (Self::MAX_LONGER + dt);
        let change = Change {
            measured,
            expected,
            slopes,
            open: Self::open_turn(expected / dt, gain * share, dt)
                + late * late * self.turning.covariance.m44,
            noise: self.turning.noise.variance,
            dt,
        };
        let innovation = self.turning.observe(&change, Self::YAW_NOISE);
        let turning = &mut self.turning;
        turning.forget(dt * Self::moving(vehicle, speed) / time, &Self::TURNING);
        turning.constrain(0, Self::MIN_GAIN, Self::MAX_GAIN);
        // What oversteers turns at most twice as much.
        let least = -0.5 * smaller(length / square, Self::MAX_UNDERSTEER);
        turning.constrain(1, least, Self::MAX_UNDERSTEER);
        turning.keep(2, -Self::MAX_STEER_OFFSET, Self::MAX_STEER_OFFSET);
        let (least, most) = Self::longer_range(vehicle);
        turning.keep(3, least, most);
        self.publish_delay(vehicle, dt);
        innovation
    }

    /// The dead time that counts from now on.
    fn publish_delay(&mut self, vehicle: &Vehicle, dt: f64) {
        let found = self.turning.get(3);
        // A vehicle that was given without a dead time is predicted only where it shows one.
        let is_none = vehicle.dead_time <= 0.0 && found.abs() < Self::LEAST_DEAD_TIME;
        let found = if is_none { 0.0 } else { found };
        let (most, longer) = (Self::DELAY_RATE * dt, self.estimate.longer_dead_time);
        self.estimate.longer_dead_time = saturate(found, longer - most, longer + most);
    }

    /// The estimates at the present `speed` [m/s].
    #[inline]
    fn publish(&mut self, vehicle: &Vehicle, speed: f64) {
        let length = vehicle.turning_length(speed);
        let square = speed * speed / vehicle.wheelbase;
        let longer = larger(length + self.turning.get(1) * square, 1e-3 * length);
        let gain = self.turning.get(0) * (length / longer);
        self.estimate.gain = saturate(gain, Self::MIN_GAIN, Self::MAX_GAIN);
        self.estimate.steer_offset = self.turning.get(2);
        let share = square / longer;
        let weights = SVector::<f64, 4>::new(1.0, -share, 0.0, 0.0);
        self.gain_deviation = sqrt(larger(self.turning.variance_of(&weights), 0.0));
        let weights = SVector::<f64, 3>::new(0.0, vehicle.wheelbase, square);
        let length = self.sliding.beyond_doubt(&weights);
        self.estimate.slip_length = saturate(length, -vehicle.wheelbase, vehicle.wheelbase);
    }

    /// Gain and steering offset [rad], and what is not known of them: [`DEVIATIONS`](Self::DEVIATIONS)
    /// of their standard deviations.
    #[inline]
    pub(crate) fn known_turning(&self) -> [(f64, f64); 2] {
        let offset = sqrt(larger(self.turning.covariance.m33, 0.0));
        [
            (self.estimate.gain, Self::DEVIATIONS * self.gain_deviation),
            (self.estimate.steer_offset, Self::DEVIATIONS * offset),
        ]
    }

    /// Updates the slip from the motion of the no-slip point in the last `dt` [s].
    ///
    /// `bend` is the vehicle's curvature [1/m] by the angle of its wheels when the period began.
    /// That angle answers earlier poses, so its noise is independent of that of this sample; the
    /// path's curvature would be noisy wherever its waypoints are.
    #[inline]
    pub fn observe_slip(
        &mut self,
        params: &AdaptParams,
        vehicle: &Vehicle,
        now: VehicleState,
        bend: f64,
        dt: f64,
    ) {
        let (Some(before), true) = (self.last_measured, params.slip_time > 0.0) else {
            return;
        };
        let speed = self.moving_speed(vehicle, before.speed, now.speed);
        let travel = speed * dt;
        let (_, measured) = moved(before, now);
        let distance = travel / vehicle.wheelbase;
        let square = speed * speed / vehicle.wheelbase;
        let slopes = SVector::<f64, 3>::new(
            distance,
            distance * bend * vehicle.wheelbase,
            distance * bend * square,
        );
        let slides = Self::OPEN_SLIP * Self::OPEN_SLIP * (2.0 * Self::OPEN_TIME / dt);
        let change = Change {
            measured: measured / vehicle.wheelbase,
            expected: slopes.dot(&self.sliding.mean),
            slopes,
            open: distance * distance * (slides + self.turning.noise.variance),
            noise: self.sliding.noise.variance_at_most(),
            dt,
        };
        self.sliding.observe(&change, Self::POSITION_NOISE);
        let sliding = &mut self.sliding;
        sliding.forget(
            dt * Self::moving(vehicle, speed) / params.slip_time,
            &Self::SLIDING,
        );
        sliding.keep(0, -Self::MAX_SLIP, Self::MAX_SLIP);
        sliding.keep(1, -1.0, 1.0);
        sliding.keep(2, -Self::MAX_UNDERSTEER, Self::MAX_UNDERSTEER);
        let slip = sliding.beyond_doubt(&SVector::<f64, 3>::new(1.0, 0.0, 0.0));
        self.estimate.slip = saturate(slip, -Self::MAX_SLIP, Self::MAX_SLIP);
        self.publish(vehicle, self.estimate.speed_scale * now.speed);
    }

    /// Returns the estimator if it is one that `vehicle` could have.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn checked(self, vehicle: &Vehicle) -> Result<Self, InputError> {
        if let Some(last_measured) = self.last_measured {
            input_within("last_measured", last_measured.x, 2.0 * MAX_COORDINATE)?;
            input_within("last_measured", last_measured.y, 2.0 * MAX_COORDINATE)?;
            input_within("last_measured", last_measured.yaw, MAX_YAW)?;
            input_within("last_measured", last_measured.speed, MAX_SPEED)?;
        }
        self.unseen.map(Reached::checked).transpose()?;
        self.turning.checked("turning")?;
        self.sliding.checked("sliding")?;
        self.pace.checked("pace")?;
        self.driving.checked("driving")?;
        input_within("wheel_rate", self.wheel_rate, kalman::MAX)?;
        input_in_range("gain_deviation", self.gain_deviation, 0.0, kalman::MAX)?;
        let estimate = self.estimate;
        let (least, most) = Self::longer_range(vehicle);
        input_in_range("longer_dead_time", estimate.longer_dead_time, least, most)?;
        let acceleration = Self::MAX_ACCELERATION * vehicle.wheelbase;
        let offset = Self::MAX_STEER_OFFSET;
        input_in_range("gain", estimate.gain, Self::MIN_GAIN, Self::MAX_GAIN)?;
        let (least, most) = Self::SCALES;
        input_in_range("speed_scale", estimate.speed_scale, least, most)?;
        for (field, value, most) in [
            ("steer_offset", estimate.steer_offset, offset),
            ("slip", estimate.slip, Self::MAX_SLIP),
            ("slip_length", estimate.slip_length, vehicle.wheelbase),
            ("acceleration", estimate.acceleration, acceleration),
        ] {
            input_within(field, value, most)?;
        }
        Ok(self)
    }
}

/// How far a vehicle went from `before` to `now` [m]: along the heading in the middle of the period,
/// and across it, to the left.
#[inline]
fn moved(before: VehicleState, now: VehicleState) -> (f64, f64) {
    let direction = before.yaw + 0.5 * wrap(now.yaw - before.yaw);
    let (dx, dy) = (now.x - before.x, now.y - before.y);
    let (c, s) = (cos(direction), sin(direction));
    (dx * c + dy * s, dy * c - dx * s)
}

#[cfg(test)]
mod tests;
