//! Which poses are believed: the gate before a step.
//!
//! Between two poses the vehicle can only have gone where its speed and its wheels took it. The
//! believed pose is rolled forward with them, and a measured one is compared with it:
//!
//! - One that repeats the last position to the bit, while the vehicle drives, is an old one
//!   ([`Status::POSE_STALE`]). It is rolled forward; after [`Gate::STALE_LIMIT`] that is a fault.
//! - One farther off than speed, wheels and noise explain is an outlier ([`Status::OUTLIER`]); the
//!   pose that was expected takes its place. Outliers that agree with each other for a while, the
//!   longer the farther they are off, are a jump of the localisation: it is believed from then on.
//! - Where the speed signal has jumped, and the speed before explains the pose, it is the signal that is wrong.
//!
//! The distance between believed poses is compared with the speed in a [`Cusum`]: a speed signal that
//! is dead, of another unit or of the wrong sign is a fault, and so is a position that stands still
//! while the heading turns. In another it is compared with the heading: a vehicle that moves aside of
//! that by more than it can slip has a heading that is askew.
//!
//! What the poses alone cannot show: a position that drifts no faster than noise and slip
//! explain, some 0.3 m/s.

use crate::bounds::MIN_DT;
use crate::error::{InputError, input_in_range, input_within};
use crate::geometry::Point;
use crate::math::{larger, rough_direction, saturate, smaller, sqrt, wrap};
use crate::status::Status;
use crate::vehicle::bicycle::advance;
use crate::vehicle::cusum::Cusum;
use crate::vehicle::fault::Fault;
use crate::vehicle::kalman::OUTLIER;
use crate::vehicle::noise::{Jitter, Noise};
use crate::vehicle::{Vehicle, VehicleState};

/// What the gate remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gate {
    /// The believed pose of the vehicle's point, and its speed.
    pub believed: VehicleState,
    /// The last measured pose, believed or not.
    pub measured: VehicleState,
    /// Whether the speed that came with it was not believed.
    pub doubted: bool,
    /// How long ago a measured pose was last believed [s].
    pub since: f64,
    /// For how long the position has repeated itself [s].
    pub stale: f64,
    /// How far off the last outlier was [m], [rad].
    pub jump: (Point, f64),
    /// How far outliers moved from one to the next beyond what is expected, since a pose was last
    /// believed: along the heading, and in all [m].
    pub drift: (f64, f64),
    /// For how long outliers have agreed with each other [s]; 0 without one.
    pub agreed: f64,
    /// How far the vehicle went by its poses beyond what its speed explains [m].
    pub ahead: Cusum,
    /// The same aside of its heading.
    pub aside: Cusum,
    /// How far it went by its poses since it first fell short of its speed [m].
    pub gone: f64,
    /// The noise of the position aside [m]: along the heading a wrong speed would count as noise.
    pub position: Noise,
    /// The noise of the yaw [rad].
    pub heading: Noise,
    /// The noise of the speed signal [m/s].
    pub pace: Jitter,
    /// Age of the newest pose at the last step [s].
    pub age: f64,
}

impl Gate {
    /// How far off a position is believed in any case, in wheelbases, and a yaw [rad].
    const POSITION: f64 = 0.25;
    const YAW: f64 = 0.12;
    /// Besides, this share of the distance and of the turn since the last pose: what the speed
    /// signal and the vehicle's parameters may be wrong by.
    const SHARE: f64 = 0.35;
    /// Besides, the turn by so large a steering offset, which nobody told [rad].
    const OFFSET: f64 = 0.03;
    /// Besides, so many standard deviations of the noise.
    const DEVIATIONS: f64 = 6.0;
    /// Outliers that agree for so long are believed [s], and so much longer for each wheelbase that
    /// they are off; at most `AGREE_MOST`.
    const AGREE: f64 = 0.15;
    const AGREE_PER_WHEELBASE: f64 = 0.35;
    const AGREE_MOST: f64 = 0.8;
    /// A pose that has repeated for so long, while the vehicle drives, is a fault [s].
    pub const STALE_LIMIT: f64 = 0.6;
    /// Outliers that do not agree for so long are a fault [s].
    const DOUBT_LIMIT: f64 = 1.0;
    /// Outliers that move so purely along the heading, as a share, follow another speed.
    const ALONG: f64 = 0.8;
    /// After a gap as long as this any pose is believed [s].
    const GAP: f64 = 1.0;
    /// Speed below which a repeated pose is no sign of anything, in wheelbases a second.
    const STILL: f64 = 0.02;
    /// Standard deviations of the noise before any was seen: of the position [m] and of the yaw [rad].
    const NOISE: (f64, f64) = (0.02, 1e-3);
    /// How much distance by poses and by speed may differ: a share, and in wheelbases, each second and
    /// in all.
    const DISTANCE_SHARE: f64 = 0.3;
    const DISTANCE: f64 = 0.05;
    /// Besides, so many standard deviations of the speed's noise. More: a dead speed is seen later. Less:
    /// noise is a wrong speed.
    const SPEED_DEVIATIONS: f64 = 2.0;
    /// How far it may go aside of its heading, as a share: what is more is no slip.
    const SLIP: f64 = 0.15;

    /// A first pose is believed.
    pub fn new(vehicle: VehicleState, age: f64) -> Self {
        Self {
            believed: vehicle,
            measured: vehicle,
            doubted: false,
            since: 0.0,
            stale: 0.0,
            jump: (Point::new(0.0, 0.0), 0.0),
            drift: (0.0, 0.0),
            agreed: 0.0,
            ahead: Cusum::default(),
            aside: Cusum::default(),
            gone: 0.0,
            position: Noise::new(Self::NOISE.0),
            heading: Noise::new(Self::NOISE.1),
            pace: Jitter::default(),
            age,
        }
    }

    /// What is believed of a pose `dt` [s] after the last one, which is `age` [s] old. The wheels
    /// give the vehicle the mean `curvature` [1/m] meanwhile.
    ///
    /// The pose itself is believed where the status is [`Status::OK`], else
    /// [`believed`](Self::believed). The flag says that the localisation has jumped: the motion
    /// since the last step tells nothing.
    #[inline]
    pub(crate) fn pass(
        &mut self,
        car: &Vehicle,
        vehicle: VehicleState,
        curvature: f64,
        dt: f64,
        age: f64,
    ) -> (Status, bool) {
        let last_age = dt + self.age;
        let elapsed = last_age - age;
        // A pose that comes out of order is not the last one.
        self.age = smaller(age, last_age);
        self.doubted = false;
        if !(MIN_DT..=Self::GAP).contains(&elapsed) {
            return (self.pass_time(vehicle, elapsed), false);
        }
        let before = self.believed;
        let travel = 0.5 * (before.speed + vehicle.speed) * elapsed;
        self.since += elapsed;
        let repeats = vehicle.x.to_bits() == self.measured.x.to_bits()
            && vehicle.y.to_bits() == self.measured.y.to_bits();
        // One that stood at either end may have stood in between, and so may one whose speed changed its
        // sign: noise about 0.
        let slowest = smaller(before.speed.abs(), vehicle.speed.abs());
        let goes_on = before.speed * vehicle.speed > 0.0;
        if repeats && goes_on && slowest > Self::STILL * car.wheelbase {
            let status = self.hold_stale(car, vehicle, (travel, curvature), elapsed);
            return (status, false);
        }
        let waited = self.stale + elapsed;
        self.stale = 0.0;
        self.measured = vehicle;
        let most = car.strongest_braking() * elapsed + OUTLIER * self.pace.deviation();
        if (vehicle.speed - before.speed).abs() > most
            && let Some(status) = self.doubt_speed(car, vehicle, curvature, elapsed)
        {
            return (status, false);
        }
        let (along, off, turned) = self.residual(car, vehicle, (travel, curvature));
        if self.explains(car, (travel, travel * curvature), off, turned) {
            return (self.believe(car, vehicle, along, off, turned), false);
        }
        self.doubt(car, vehicle, (travel, curvature), (off, turned), waited)
    }

    /// What is believed of a `speed` signal [m/s] `dt` [s] after the last step.
    #[inline]
    pub fn hear(&mut self, car: &Vehicle, speed: f64, dt: f64) -> f64 {
        let (last, believed) = (self.measured.speed, self.believed.speed);
        self.listen(car, speed - last, dt);
        let noise = self.pace.deviation();
        car.believed_speed(speed, last, believed, (noise, dt + self.age))
    }

    /// Notes what the speed `signal` said [m/s]; whether it is not believed.
    #[inline]
    pub(crate) fn heard(&mut self, signal: f64) -> bool {
        self.measured.speed = signal;
        self.doubted
    }

    /// Takes in a `change` of the speed signal [m/s] within `dt` [s]: as far as the vehicle can have changed
    /// its speed, and its noise with it.
    #[inline]
    pub(crate) fn listen(&mut self, car: &Vehicle, change: f64, dt: f64) {
        let most = car.believed_speed(f64::INFINITY, 0.0, 0.0, (self.pace.deviation(), dt));
        self.pace.observe(saturate(change, -most, most), dt);
    }

    /// No pose has come for `dt` [s]: of the last one holds what was found of it.
    pub(crate) fn wait(&mut self, dt: f64) -> Status {
        self.age += dt;
        self.found()
    }

    /// A pose that is as old as the last one, or older, of which holds what was found of that; or
    /// one after a gap.
    #[cold]
    fn pass_time(&mut self, vehicle: VehicleState, elapsed: f64) -> Status {
        if elapsed > Self::GAP {
            self.restart(vehicle);
            return Status::OK;
        }
        self.found()
    }

    /// What was found of the last pose.
    fn found(&self) -> Status {
        if self.stale > 0.0 {
            return self.stale_status();
        }
        Status::OUTLIER.when(self.agreed > 0.0)
    }

    /// The status of a position that repeats itself.
    fn stale_status(&self) -> Status {
        Status::POSE_STALE | Status::IMPLAUSIBLE.when(self.stale > Self::STALE_LIMIT)
    }

    /// What the poses show to be wrong, by the last step. Named by the residuals in which it shows:
    /// a position that repeats or jumps for long is wrong itself; so is one that rests in its noise
    /// while the speed signal says that the vehicle drives. Otherwise it is the speed that disagrees
    /// with the distance between poses.
    pub(crate) fn fault(&self, car: &Vehicle) -> Option<Fault> {
        let (off, turned) = self.jump;
        if self.stale > Self::STALE_LIMIT {
            Some(Fault::Position)
        } else if self.agreed > 0.0 && self.since > Self::DOUBT_LIMIT {
            let askew_alone = sqrt(off.dot(&off)) <= Self::POSITION * car.wheelbase;
            let (along, apart) = self.drift;
            Some(if askew_alone && turned.abs() > Self::YAW {
                Fault::Heading
            } else if along.abs() > Self::ALONG * apart {
                Fault::Speed
            } else {
                Fault::Position
            })
        } else if self.ahead.most() > self.distance_limit(car) {
            let rests = self.gone.abs() <= Self::DISTANCE_SHARE * self.ahead.under;
            Some(if rests && self.ahead.under > 0.0 {
                Fault::Position
            } else {
                Fault::Speed
            })
        } else {
            let drifts = self.aside.most() > self.distance_limit(car);
            drifts.then_some(Fault::Heading)
        }
    }

    /// What a sum of distances is beyond where poses and speed differ [m].
    #[inline]
    fn distance_limit(&self, car: &Vehicle) -> f64 {
        Cusum::limit(Self::DISTANCE * car.wheelbase, self.position.at_most())
    }

    /// Standard deviations of the noise by a gate, of the position [m] and of the speed [m/s]; 0 without
    /// one.
    #[inline]
    pub(crate) fn noise_of(gate: Option<&Self>) -> (f64, f64) {
        gate.map_or((0.0, 0.0), |gate| {
            (gate.position.deviation(), gate.pace.deviation())
        })
    }

    /// The signal that differs from the poses most, be it by less than is a fault.
    pub(crate) fn doubts(&self, car: &Vehicle) -> Option<Fault> {
        let (ahead, aside) = (self.ahead.most(), self.aside.most());
        let differs = larger(ahead, aside) > 0.5 * self.distance_limit(car);
        differs.then_some(if ahead > aside {
            Fault::Speed
        } else {
            Fault::Heading
        })
    }

    /// Believes `vehicle` whatever was before, but for the noise.
    fn restart(&mut self, vehicle: VehicleState) {
        *self = Self {
            position: self.position,
            heading: self.heading,
            pace: self.pace,
            ..Self::new(vehicle, self.age)
        };
    }

    /// The direction in which the vehicle went along an arc, and how far its pose is off the end of that: where
    /// [`rolled`] has it, with the chord of a short arc.
    #[inline]
    fn residual(
        &self,
        car: &Vehicle,
        vehicle: VehicleState,
        (travel, curvature): (f64, f64),
    ) -> ((f64, f64), Point, f64) {
        let before = self.believed;
        let turn = travel * curvature;
        let (c, s) = rough_direction(before.yaw + 0.5 * turn);
        let swing = car.no_slip() * turn;
        let off = Point::new(
            vehicle.x - before.x - travel * c - swing * s,
            vehicle.y - before.y - travel * s + swing * c,
        );
        ((c, s), off, wrap(vehicle.yaw - before.yaw - turn))
    }

    /// A speed signal that is farther from the last than any vehicle accelerates. Where the pose is explained by
    /// the speed before, and better, it is not believed; what it says of the pose is still compared.
    #[cold]
    fn doubt_speed(
        &mut self,
        car: &Vehicle,
        vehicle: VehicleState,
        curvature: f64,
        elapsed: f64,
    ) -> Option<Status> {
        let (before, signal) = (self.believed.speed, vehicle.speed);
        let arc = (before * elapsed, curvature);
        let (_, kept, turned) = self.residual(car, vehicle, arc);
        let (along, off, _) = self.residual(car, vehicle, (signal * elapsed, curvature));
        let explained = self.explains(car, (arc.0, arc.0 * curvature), kept, turned);
        if !explained || kept.dot(&kept) >= off.dot(&off) {
            return None;
        }
        self.believed.speed = signal;
        let status = self.believe(car, vehicle, along, off, turned);
        self.believed.speed = before;
        self.doubted = true;
        Some(status)
    }

    /// A pose that is `off` the expected one: an outlier, or the end of a jump.
    #[cold]
    fn doubt(
        &mut self,
        car: &Vehicle,
        vehicle: VehicleState,
        arc: (f64, f64),
        (off, turned): (Point, f64),
        waited: f64,
    ) -> (Status, bool) {
        let (travel, curvature) = arc;
        let (last, last_turned) = self.jump;
        let (apart, askew) = (off - last, wrap(turned - last_turned));
        let agrees =
            self.agreed > 0.0 && self.explains(car, (travel, travel * curvature), apart, askew);
        self.agreed = waited + if agrees { self.agreed } else { 0.0 };
        self.jump = (off, turned);
        let (c, s) = rough_direction(vehicle.yaw);
        // What is noise may be far more than it was; what is not counts no more than the most that is.
        let most = Self::POSITION * car.wheelbase + Self::DEVIATIONS * self.position.deviation();
        let aside = saturate(off.y * c - off.x * s, -most, most);
        let askew = saturate(turned, -Self::YAW, Self::YAW);
        self.position.observe(aside, waited);
        self.heading.observe(askew, waited);
        self.drift.0 += apart.x * c + apart.y * s;
        self.drift.1 += sqrt(apart.dot(&apart));
        let wheelbases = sqrt(off.dot(&off)) / car.wheelbase;
        let patience = Self::AGREE + Self::AGREE_PER_WHEELBASE * wheelbases;
        // One alone agrees with none, however long its period.
        let jumped = agrees && self.agreed > smaller(patience, Self::AGREE_MOST);
        let mut status = Status::OUTLIER;
        if jumped {
            self.restart(vehicle);
        } else {
            status |= Status::IMPLAUSIBLE.when(self.since > Self::DOUBT_LIMIT);
            self.believed = rolled(car, self.believed, arc, vehicle.speed);
        }
        (status, jumped)
    }

    /// A position that repeats: the expected one, with the heading where that is alive.
    #[cold]
    fn hold_stale(
        &mut self,
        car: &Vehicle,
        vehicle: VehicleState,
        arc: (f64, f64),
        elapsed: f64,
    ) -> Status {
        self.believed = rolled(car, self.believed, arc, vehicle.speed);
        if vehicle.yaw.to_bits() != self.measured.yaw.to_bits() {
            self.believed.yaw = vehicle.yaw;
        }
        self.stale += elapsed;
        self.measured = vehicle;
        self.stale_status()
    }

    /// Whether a position `off` the expected one, and a yaw `turned` from it, are explained after the
    /// `travel` [m] and the `turn` [rad] of an arc.
    #[inline]
    fn explains(&self, car: &Vehicle, (travel, turn): (f64, f64), off: Point, turned: f64) -> bool {
        let square = off.dot(&off);
        let (far, askew) = (Self::POSITION * car.wheelbase, Self::YAW);
        if square <= far * far && turned.abs() <= askew {
            // As most poses are.
            return true;
        }
        let far = far + Self::SHARE * travel.abs() + Self::DEVIATIONS * self.position.deviation();
        let by_offset = Self::OFFSET * (travel / car.wheelbase).abs();
        let by_noise = Self::DEVIATIONS * self.heading.deviation();
        let askew = askew + Self::SHARE * turn.abs() + by_offset + by_noise;
        square <= far * far && turned.abs() <= askew
    }

    /// Takes a pose that is believed, and compares how far the vehicle went with the speed: that is
    /// how far the pose lies `off` the expected one along the heading `(c, s)`.
    #[inline]
    fn believe(
        &mut self,
        car: &Vehicle,
        vehicle: VehicleState,
        (c, s): (f64, f64),
        off: Point,
        turned: f64,
    ) -> Status {
        self.agreed = 0.0;
        self.drift = (0.0, 0.0);
        let since = self.since;
        let along = off.x * c + off.y * s;
        let aside = off.y * c - off.x * s;
        self.position.observe(aside, since);
        self.heading.observe(turned, since);

        let driven = 0.5 * (self.believed.speed + vehicle.speed) * since;
        let (drift, far) = (Self::DISTANCE * car.wheelbase, driven + along);
        let travel = larger(far.abs(), driven.abs());
        // The noise of a speed adds up.
        let wanders = Self::SPEED_DEVIATIONS * self.pace.deviation() * since;
        let explained = Self::DISTANCE_SHARE * travel + drift * since + wanders;
        let slipped = Self::SLIP * travel + drift * since;
        let noise = self.position.at_most();
        // One correction of the localisation alone is no speed, and no drift.
        let once = 0.5 * Cusum::limit(drift, noise);
        let add = |sum: &mut Cusum, change: f64, explained: f64| {
            let most = explained + once;
            let change = saturate(change, -most, most);
            sum.add(change, (-explained, explained), (noise, since), drift)
        };
        let differs = add(&mut self.ahead, along, explained) | add(&mut self.aside, aside, slipped);
        self.gone = if self.ahead.under > 0.0 {
            self.gone + far
        } else {
            0.0
        };
        self.since = 0.0;
        self.believed = vehicle;
        Status::IMPLAUSIBLE.when(differs)
    }

    /// The gate itself, where its numbers are ones that poses can have given.
    ///
    /// # Errors
    ///
    /// [`InputError`] where they are not.
    pub fn checked(self) -> Result<Self, InputError> {
        const MOST: f64 = 1e20;
        for vehicle in [self.believed, self.measured] {
            for number in [vehicle.x, vehicle.y, vehicle.yaw, vehicle.speed] {
                input_within("gate", number, MOST)?;
            }
        }
        let (off, turned) = self.jump;
        for number in [off.x, off.y, turned, self.drift.0, self.gone] {
            input_within("gate", number, MOST)?;
        }
        for number in [self.since, self.stale, self.drift.1, self.agreed, self.age] {
            input_in_range("gate", number, 0.0, MOST)?;
        }
        self.position.checked("gate")?;
        self.heading.checked("gate")?;
        self.pace.checked("gate")?;
        self.ahead.checked("gate")?;
        self.aside.checked("gate")?;
        Ok(self)
    }
}

/// Where the vehicle `from` is after `travel` [m] along an arc of `curvature` [1/m], with the `speed`
/// [m/s].
pub(crate) fn rolled(
    car: &Vehicle,
    from: VehicleState,
    (travel, curvature): (f64, f64),
    speed: f64,
) -> VehicleState {
    let point = car.no_slip();
    let expected = advance(from.ahead(point), travel, curvature, 0.0);
    VehicleState {
        speed,
        ..expected.ahead(-point).bounded()
    }
}
