//! Paths and vehicles out of bytes.

use crate::bytes::Bytes;
use popsteer_core::path::view::{MAX_COORDINATE, MAX_SPEED};
use popsteer_core::vehicle::state::{MAX_DT, MAX_YAW, MIN_DT};
use popsteer_core::{Path, PathError, PathView, VehicleState};

/// Waypoints that may or may not make a path.
#[derive(Clone, Debug, Default)]
pub struct Waypoints {
    /// Abscissas [m].
    pub x: Vec<f64>,
    /// Ordinates [m].
    pub y: Vec<f64>,
    /// Reference speeds [m/s].
    pub speed: Option<Vec<f64>>,
    /// Whether the last leads back to the first.
    pub closed: bool,
}

impl Waypoints {
    /// A walk of at most 20 steps: straight, bent, back on itself, crossing itself, far from the
    /// origin; now and then with a waypoint twice, or with numbers that no path can have.
    pub fn draw(bytes: &mut Bytes) -> Self {
        let form = bytes.byte();
        let count = bytes.below(21);
        let spacing = [1.0, 1.0, 0.01, 100.0, 0.2, 5.0, 1e-9, 1e7][bytes.below(8)];
        let origin = [0.0, 0.0, 0.0, 50.0, -1e3, 1e7, -1e9, 1e9][usize::from(form >> 5)];
        let mut waypoints = Self {
            closed: form & 1 == 1,
            speed: (form & 2 == 2).then(Vec::new),
            ..Self::default()
        };
        let (mut x, mut y, mut yaw) = (origin, -origin, 0.0_f64);
        for _ in 0..count {
            waypoints.push(x, y, bytes);
            match bytes.byte() {
                // The same place again, an earlier one, any.
                255 => {}
                254 if !waypoints.x.is_empty() => {
                    let earlier = bytes.below(waypoints.x.len());
                    (x, y) = (waypoints.x[earlier], waypoints.y[earlier]);
                }
                253 => {
                    let whole = [-MAX_COORDINATE, MAX_COORDINATE];
                    x = bytes.number([-10.0, 10.0], whole);
                    y = bytes.number([-10.0, 10.0], whole);
                }
                length => {
                    yaw += f64::from(bytes.byte().cast_signed()) / 40.0;
                    let length = spacing * f64::from(length.saturating_add(1)) / 64.0;
                    x += length * yaw.cos();
                    y += length * yaw.sin();
                }
            }
        }
        waypoints
    }

    fn push(&mut self, x: f64, y: f64, bytes: &mut Bytes) {
        self.x.push(x);
        self.y.push(y);
        if let Some(speed) = &mut self.speed {
            speed.push(bytes.number([0.0, 30.0], [-MAX_SPEED, MAX_SPEED]));
        }
    }

    /// The path of these waypoints.
    pub fn path(&self) -> Result<Path, PathError> {
        Path::new(&self.x, &self.y, self.speed.as_deref(), self.closed)
    }
}

/// A vehicle somewhere by the path, far from it, or nowhere at all.
pub fn vehicle(bytes: &mut Bytes, path: &PathView<'_>) -> VehicleState {
    let coordinates = [-MAX_COORDINATE, MAX_COORDINATE];
    let yaws = [-MAX_YAW, MAX_YAW];
    let speeds = [-MAX_SPEED, MAX_SPEED];
    match bytes.byte() {
        0..=199 => {
            let k = bytes.below(path.len());
            VehicleState {
                x: path.x()[k] + bytes.within(-8.0, 8.0),
                y: path.y()[k] + bytes.within(-8.0, 8.0),
                yaw: bytes.within(-3.2, 3.2),
                speed: bytes.number([-2.0, 30.0], speeds),
            }
        }
        200..=219 => {
            let k = bytes.below(path.len());
            VehicleState {
                x: path.x()[k],
                y: path.y()[k],
                yaw: bytes.number([-7.0, 7.0], yaws),
                speed: bytes.number([0.0, 1e-3], speeds),
            }
        }
        _ => VehicleState {
            x: bytes.number([-100.0, 100.0], coordinates),
            y: bytes.number([-100.0, 100.0], coordinates),
            yaw: bytes.number([-7.0, 7.0], yaws),
            speed: bytes.number([0.0, 30.0], speeds),
        },
    }
}

/// A control period [s].
pub fn dt(bytes: &mut Bytes) -> f64 {
    if bytes.byte() < 160 {
        0.05
    } else {
        bytes.number([0.001, 0.5], [MIN_DT, MAX_DT])
    }
}
