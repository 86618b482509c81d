//! A driver around a plant of the tests' own.

use popsteer_core::driver::{Drive, Driver, DriverParams, DriverState, Sensed};
use popsteer_core::laws::{Law, LawState, PreviewPop, PreviewPopParams};
use popsteer_core::speed::{SpeedTracker, SpeedTrackerParams};
use popsteer_core::{Path, Tracker, Vehicle, VehicleState};

pub(crate) const DT: f64 = 0.05;
pub(crate) const CAR: Vehicle = Vehicle {
    wheelbase: 2.7,
    rear_axle: -1.35,
    max_steer: 0.6,
    max_steer_rate: Some(0.5),
    steer_lag: 0.1,
    dead_time: 0.15,
    max_lateral_acceleration: Some(4.0),
    max_speed: Some(10.0),
    max_deceleration: Some(1.5),
    ..Vehicle::DEFAULT
};

/// A bicycle with a lag and a dead time of its own, whose brakes brake in every gear.
pub(crate) struct Plant {
    pub(crate) rear: VehicleState,
    wheel: f64,
    in_flight: Vec<f64>,
    pub(crate) sign: f64,
}

impl Plant {
    pub(crate) fn at(x: f64, y: f64, yaw: f64, speed: f64) -> Self {
        Self {
            rear: VehicleState { x, y, yaw, speed },
            wheel: 0.0,
            in_flight: vec![0.0; 15],
            sign: 1.0,
        }
    }

    /// The pose of the vehicle's point.
    pub(crate) fn pose(&self) -> VehicleState {
        self.rear.ahead(-CAR.rear_axle)
    }

    pub(crate) fn go(&mut self, drive: &Drive, dt: f64) {
        let gear = if drive.reverse { -1.0 } else { 1.0 };
        for _ in 0..5 {
            let h = dt / 5.0;
            self.in_flight.push(self.sign * drive.steer);
            let gap = self.in_flight.remove(0) - self.wheel;
            self.wheel += (gap * (1.0 - (-h / CAR.steer_lag).exp())).clamp(-0.5 * h, 0.5 * h);
            let v = &mut self.rear.speed;
            if drive.acceleration >= 0.0 && !drive.hold {
                *v += gear * drive.acceleration * h;
            } else {
                *v = (v.abs() + drive.acceleration.min(0.0) * h)
                    .max(0.0)
                    .copysign(*v);
            }
            let rear = &mut self.rear;
            rear.x += h * rear.speed * rear.yaw.cos();
            rear.y += h * rear.speed * rear.yaw.sin();
            rear.yaw += h * rear.speed * self.wheel.tan() / CAR.wheelbase;
        }
    }
}

pub(crate) struct Rig {
    pub(crate) driver: Driver<Law>,
    pub(crate) state: DriverState<LawState>,
    pub(crate) path: Path,
    pub(crate) plan: Vec<f64>,
    pub(crate) plant: Plant,
    /// How far the rear axle was from the path at most [m].
    pub(crate) off: f64,
}

impl Rig {
    pub(crate) fn new(law: impl Into<Law>, path: Path) -> Self {
        let speed = SpeedTracker::new(CAR, SpeedTrackerParams::DEFAULT).unwrap();
        let driver = Driver::new(Tracker::of(law.into()), speed, DriverParams::DEFAULT).unwrap();
        let plan = speed.plan(&path.view()).unwrap();
        let state = driver.initial_state();
        let (x, y) = (path.view().x(), path.view().y());
        let yaw = (y[1] - y[0]).atan2(x[1] - x[0]);
        let plant = Plant::at(x[0], y[0], yaw, 0.0);
        let off = 0.0;
        Self {
            driver,
            state,
            path,
            plan,
            plant,
            off,
        }
    }

    pub(crate) fn preview(path: Path) -> Self {
        Self::new(
            PreviewPop::new(CAR, PreviewPopParams::DEFAULT).unwrap(),
            path,
        )
    }

    pub(crate) fn step(&mut self, sensed: impl Into<Sensed>, dt: f64) -> Drive {
        let (path, state) = (self.path.view(), &mut self.state);
        self.driver
            .step(&path, &self.plan, state, sensed.into(), dt)
    }

    /// Drives for `time` [s] on what `sense` makes of time and pose; the last answer.
    pub(crate) fn drive(
        &mut self,
        time: f64,
        mut sense: impl FnMut(f64, VehicleState) -> VehicleState,
    ) -> Drive {
        let mut last = None;
        let steps = popsteer_core::math::to_count(time / DT + 0.5);
        for k in 0..steps {
            let given = sense(popsteer_core::math::from_count(k) * DT, self.plant.pose());
            let drive = self.step(given, DT);
            assert!(drive.steer.abs() <= CAR.max_steer && drive.acceleration.is_finite());
            self.plant.go(&drive, DT);
            let rear = self.plant.rear;
            let at = self.path.view();
            let distances = at
                .x()
                .iter()
                .zip(at.y())
                .map(|(x, y)| (x - rear.x).hypot(y - rear.y));
            self.off = self.off.max(distances.fold(f64::INFINITY, f64::min));
            last = Some(drive);
        }
        last.unwrap()
    }
}

/// Bends of 4 m to both sides, every 0.25 m a waypoint.
pub(crate) fn bends() -> Path {
    let x: Vec<f64> = (0..800).map(|k| 0.25 * f64::from(k)).collect();
    let y: Vec<f64> = x.iter().map(|x| 4.0 * (1.0 - (x / 15.0).cos())).collect();
    Path::new(&x, &y, None, false).unwrap()
}

pub(crate) const NAN: VehicleState = VehicleState {
    x: f64::NAN,
    y: f64::NAN,
    yaw: f64::NAN,
    speed: f64::NAN,
};
