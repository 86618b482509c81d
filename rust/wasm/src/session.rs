//! What a page works with: room for numbers, a track, and what a run came to.

use popsteer_core::{Path, Point, Status};
use popsteer_sim::{Record, Simulation};

use crate::Refusal;
use crate::controllers;
use crate::course::drive;
use crate::drawn::smoothed;
use crate::settings::{self, Settings};

/// The most numbers that there is room for.
const MOST: usize = 1 << 18;

const METRICS: &str = "steps,time,ending,mean,max,rear_mean,rear_max,rms_steer_rate,faults";

/// The texts that a page asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Text {
    /// Why the last call was refused; empty where it was not.
    Message,
    /// The controllers, separated by commas like all names.
    Controllers,
    /// The settings.
    Settings,
    /// The metrics. `ending` is 0 at the end of the track, 1 out of time, 2 too far from the path;
    /// the errors are those after 5 s, at the tracked point and at the rear axle [m]; `faults` are
    /// the bits of a status.
    Metrics,
    /// The columns of the records.
    Columns,
    /// The conditions of a status, from the lowest bit up.
    Statuses,
    /// The version of popsteer.
    Version,
}

impl Text {
    /// The text of a number; the message of one that there is not.
    pub fn of(number: u32) -> Self {
        match number {
            1 => Self::Controllers,
            2 => Self::Settings,
            3 => Self::Metrics,
            4 => Self::Columns,
            5 => Self::Statuses,
            6 => Self::Version,
            _ => Self::Message,
        }
    }
}

/// What a page works with; without a track to begin with.
#[derive(Debug, Default)]
pub struct Session {
    room: Vec<f64>,
    output: Vec<f64>,
    path: Option<Path>,
    message: String,
    /// The last text that was put together.
    text: String,
}

impl Session {
    /// Room for `count` numbers, 0 to begin with; none for more than a track needs.
    pub fn room(&mut self, count: usize) -> Option<&mut [f64]> {
        self.room.clear();
        if count > MOST {
            self.message = format!("there is room for {MOST} numbers, not for {count}");
            return None;
        }
        self.room.resize(count, 0.0);
        Some(&mut self.room)
    }

    /// Takes the room as the waypoints x, y, x, y, ... of the track. Whether it did; the track
    /// stays where it did not.
    pub fn track(&mut self, closed: bool) -> bool {
        self.output.clear();
        let points = self.points();
        let done = self.take(&points, closed);
        self.answer(done).is_some()
    }

    /// Takes the room as a line drawn by hand. Whether the track made of it is closed; None if
    /// it is refused.
    pub fn draw(&mut self) -> Option<bool> {
        let made = smoothed(&self.points()).and_then(|(points, closed)| {
            self.take(&points, closed)?;
            self.output = points.iter().flat_map(|point| [point.x, point.y]).collect();
            Ok(closed)
        });
        self.answer(made)
    }

    /// Takes the room as settings, and drives the controller of this number along the track.
    /// Whether it did.
    pub fn drive(&mut self, controller: usize) -> bool {
        let done = self.driven(controller).map(|run| self.put(&run));
        self.answer(done).is_some()
    }

    /// What the last line drawn or the last run came to; empty after a refusal.
    pub fn output(&self) -> &[f64] {
        &self.output
    }

    /// A text.
    pub fn text(&mut self, what: Text) -> &str {
        let statuses = Status::NAMES.map(|(_, name)| name);
        self.text = match what {
            Text::Message => return &self.message,
            Text::Metrics => return METRICS,
            Text::Version => return env!("CARGO_PKG_VERSION"),
            Text::Controllers => controllers::NAMES.join(","),
            Text::Settings => settings::NAMES.join(","),
            Text::Columns => [&Record::COLUMNS.map(|(name, _)| name)[..], &["status"]]
                .concat()
                .join(","),
            Text::Statuses => statuses.join(","),
        };
        &self.text
    }

    fn points(&self) -> Vec<Point> {
        let (pairs, _) = self.room.as_chunks::<2>();
        pairs.iter().map(|&[x, y]| Point::new(x, y)).collect()
    }

    fn take(&mut self, points: &[Point], closed: bool) -> Result<(), Refusal> {
        let x: Vec<f64> = points.iter().map(|point| point.x).collect();
        let y: Vec<f64> = points.iter().map(|point| point.y).collect();
        self.path = Some(Path::new(&x, &y, None, closed)?);
        Ok(())
    }

    fn driven(&self, controller: usize) -> Result<Simulation, Refusal> {
        let track = self.path.as_ref().ok_or("there is no track yet")?;
        let settings = Settings::of(&self.room)?;
        let name = controllers::NAMES.get(controller).copied().unwrap_or("");
        let law = controllers::make(name, &settings.believed)?
            .ok_or_else(|| format!("there is no controller {controller}"))?;
        drive(track, &law, &settings)
    }

    fn put(&mut self, run: &Simulation) {
        let metrics = run.metrics();
        let ending = if metrics.finished {
            0.0
        } else if metrics.time >= run.settings().time_limit {
            1.0
        } else {
            2.0
        };
        let (own, rear) = (&metrics.reference, &metrics.rear_axle);
        self.output.clear();
        self.output.extend([
            popsteer_core::math::from_count(metrics.steps),
            metrics.time,
            ending,
            own.settled_cross_track.mean_abs,
            own.settled_cross_track.max_abs,
            rear.settled_cross_track.mean_abs,
            rear.settled_cross_track.max_abs,
            metrics.rms_steer_rate,
            f64::from(metrics.faults.bits()),
        ]);
        for record in run.records() {
            let numbers = Record::COLUMNS.map(|(_, number)| number(record));
            self.output.extend(numbers);
            self.output.push(record.status.bits().into());
        }
    }

    /// What was `done`; the message says why it was not.
    fn answer<T>(&mut self, done: Result<T, Refusal>) -> Option<T> {
        self.message.clear();
        match done {
            Ok(value) => Some(value),
            Err(refusal) => {
                self.output.clear();
                self.message = refusal.to_string();
                None
            }
        }
    }
}
