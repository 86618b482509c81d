//! One vehicle on one episode.

use popsteer_core::math::{cos, sin, wrap};
use popsteer_core::path::projection::reference_speed;
use popsteer_core::{PathView, Point, Status};

use super::Terms;
use crate::longitudinal::Pedalling;
use crate::plant::Control;
use crate::simulation::Simulation;

/// What an observation begins with, and the bound of each number; the preview follows.
pub const FIGURES: [(&str, f64); 7] = [
    ("cross_track_error", 100.0),
    ("heading_error", std::f64::consts::PI),
    ("speed", 100.0),
    ("yaw_rate", 10.0),
    ("wheel", std::f64::consts::FRAC_PI_2),
    ("previous_steer", std::f64::consts::FRAC_PI_2),
    ("reference_speed", 100.0),
];

/// Bound of each coordinate of the preview [m].
pub const PREVIEW_BOUND: f64 = 2000.0;

/// Less of the path than this counts as no progress [m].
const PROGRESS: f64 = 0.1;

/// What is reported in addition to the observation.
pub const INFO: [&str; 8] = [
    "x",
    "y",
    "yaw",
    "speed",
    "cross_track_error",
    "heading_error",
    "progress",
    "time",
];

/// One vehicle on one episode, and the result of its last step.
#[derive(Clone, Debug)]
pub struct Episode {
    simulation: Simulation,
    pedalling: Option<Pedalling>,
    previous_steer: f64,
    failed: bool,
    /// Farthest along the path so far [m], and for how long that has been so [s].
    farthest: f64,
    waited: f64,
    stalled: bool,
    /// What is observed, as [`FIGURES`] says.
    pub observation: Vec<f32>,
    /// What is reported in addition, as [`INFO`] says.
    pub info: [f64; INFO.len()],
    /// The reward of the last step.
    pub reward: f64,
}

impl Episode {
    pub(super) fn new(simulation: Simulation, terms: &Terms) -> Self {
        let mut episode = Self {
            pedalling: terms
                .longitudinal
                .as_ref()
                .map(|longitudinal| Pedalling::new(longitudinal, &simulation)),
            farthest: simulation.run.travelled,
            simulation,
            previous_steer: 0.0,
            failed: false,
            waited: 0.0,
            stalled: false,
            observation: vec![0.0; terms.observations()],
            info: [0.0; INFO.len()],
            reward: 0.0,
        };
        episode.observe(terms);
        episode
    }

    /// The run itself.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Whether the end of the path was reached, or the vehicle cannot go on.
    pub fn is_terminated(&self) -> bool {
        self.failed || self.simulation.run.finished || self.simulation.run.lost
    }

    /// Whether before that the time ran out, or it made no progress for too long.
    pub fn is_truncated(&self) -> bool {
        !self.is_terminated() && (self.simulation.is_over() || self.stalled)
    }

    /// Whether it made no progress for as long as [`Terms::stall_time`] says.
    pub fn is_stalled(&self) -> bool {
        self.stalled
    }

    pub(super) fn fail(&mut self, terms: &Terms) {
        if !self.is_terminated() {
            self.reward -= terms.weights.off_path;
        }
        self.failed = true;
    }

    /// Moves by one control step under an action of finite numbers.
    pub(super) fn step(&mut self, action: &[f64], terms: &Terms) {
        self.reward = 0.0;
        if self.is_terminated() || self.is_truncated() {
            return;
        }
        let limited = |index: usize| action.get(index).map_or(0.0, |a| a.clamp(-1.0, 1.0));
        let steer = self.simulation.plant().vehicle().max_steer * limited(0);
        let travelled = self.simulation.run.travelled;
        let Some(control) = self.control(steer, limited(1)) else {
            return self.fail(terms);
        };
        let nowhere = Point::new(f64::NAN, f64::NAN);
        if self.simulation.step(control, nowhere, Status::OK).is_err() {
            return self.fail(terms);
        }
        let dt = self.simulation.settings().dt;
        self.waited += dt;
        if self.simulation.run.travelled > self.farthest + PROGRESS {
            (self.farthest, self.waited) = (self.simulation.run.travelled, 0.0);
        }
        self.stalled = self.waited >= terms.stall_time;
        let weights = &terms.weights;
        let rate = (steer - self.previous_steer) / dt;
        self.previous_steer = steer;
        let [e, psi] = self.observe(terms);
        let cost = weights.cross_track_error * e * e
            + weights.heading_error * psi * psi
            + weights.steer_rate * rate * rate;
        self.reward = weights.progress * (self.simulation.run.travelled - travelled) - dt * cost;
        if self.simulation.run.lost {
            self.reward -= weights.off_path;
        }
    }

    /// The command; None if a controller refuses the vehicle, whose numbers are no longer finite.
    fn control(&mut self, steer: f64, pedal: f64) -> Option<Control> {
        let reverse = self.simulation.reverse();
        let vehicle = self.simulation.measured();
        match &mut self.pedalling {
            Some(pedalling) => pedalling
                .control(&self.simulation, vehicle, steer, reverse)
                .ok(),
            None => Some(Control {
                steer,
                throttle: pedal.max(0.0),
                brake: (-pedal).max(0.0),
                reverse,
            }),
        }
    }

    /// Looks at the vehicle where it is now; gives the errors of the rear axle.
    fn observe(&mut self, terms: &Terms) -> [f64; 2] {
        let simulation = &self.simulation;
        let state = &simulation.run.plant;
        let at = simulation.locate(&simulation.rear, simulation.run.rear);
        let path = simulation.path().view();
        let place = at.closest.projection(&path);
        let e = place.cross_track_error;
        let psi = wrap(at.vehicle.yaw - place.path_yaw);
        let figures = [
            e,
            psi,
            state.vehicle.speed,
            state.yaw_rate,
            state.wheel,
            self.previous_steer,
            reference_speed(&path, &place).unwrap_or(0.0),
        ];
        let (heads, preview) = self.observation.split_at_mut(FIGURES.len());
        for ((head, figure), (_, bound)) in heads.iter_mut().zip(figures).zip(FIGURES) {
            *head = narrowed(figure, bound);
        }
        let rear = state.vehicle.ahead(simulation.plant().vehicle().rear_axle);
        let (cos, sin) = (cos(rear.yaw), sin(rear.yaw));
        let (pairs, _) = preview.as_chunks_mut::<2>();
        let mut segment = place.segment;
        for ([ahead, left], distance) in pairs.iter_mut().zip(&terms.preview) {
            let (point, found) = point_at(&path, place.arc_length + distance, segment);
            segment = found;
            let (dx, dy) = (point.x - rear.x, point.y - rear.y);
            *ahead = narrowed(dx * cos + dy * sin, PREVIEW_BOUND);
            *left = narrowed(dy * cos - dx * sin, PREVIEW_BOUND);
        }
        let vehicle = state.vehicle;
        self.info = [
            vehicle.x,
            vehicle.y,
            vehicle.yaw,
            vehicle.speed,
            e,
            psi,
            simulation.progress(),
            simulation.time(),
        ];
        [e, psi]
    }
}

/// The point of the path at `arc` [m], looked for from segment `near` on, and its segment. Both
/// ends of an open path go on as straight lines; a closed one goes round.
pub(super) fn point_at(path: &PathView<'_>, arc: f64, near: usize) -> (Point, usize) {
    let length = path.length();
    let arc = if path.is_closed() {
        arc - length * (arc / length).floor()
    } else {
        arc
    };
    let segment = path.segment_by_arc(arc, near);
    let (from, to) = path.segment(segment);
    let share = (arc - path.arc(segment)) / path.segment_length(segment);
    (from + (to - from) * share, segment)
}

/// A number for a learner: within its bound also where its vehicle is far away.
#[expect(
    clippy::cast_possible_truncation,
    reason = "learners take single precision"
)]
fn narrowed(number: f64, bound: f64) -> f32 {
    // The bound itself, rounded like those of the space of observations.
    let bound = bound as f32;
    (number as f32).clamp(-bound, bound)
}
