//! A point of the vehicle on its way along the path of a run.

use popsteer_core::path::{Follow, Located};
use popsteer_core::{Path, VehicleState};

/// A point of the vehicle, followed along the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Follower {
    pub(crate) follow: Follow,
    pub(crate) waypoint: Option<usize>,
}

impl Follower {
    /// Follows as `follow` says; the point is never looked for anew, as it never jumps.
    pub(crate) fn new(follow: Follow) -> Self {
        Self {
            follow: Follow {
                lost_distance: f64::INFINITY,
                ..follow
            },
            waypoint: None,
        }
    }

    pub(crate) fn find(&self, path: &Path, vehicle: VehicleState, dt: f64) -> Located {
        self.follow.locate(&path.view(), self.waypoint, vehicle, dt)
    }

    pub(crate) fn follow(&mut self, path: &Path, vehicle: VehicleState, dt: f64) -> Located {
        let at = self.find(path, vehicle, dt);
        self.waypoint = Some(at.closest.segment);
        at
    }
}
