//! What is found on a path: the projection of a position, and the lookahead point.

use popsteer_core::Point;
use popsteer_core::path::Projection;
use popsteer_core::path::lookahead::Lookahead;
use pyo3::prelude::*;

use crate::record::record;

record! {
    /// The projection of a position onto a path: its closest point there.
    PyProjection(Projection) named "Projection",
    segment: usize, "int",
        "The segment that carries the point; it starts at the waypoint of the same index.";
    fraction: f64, "float",
        "Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.";
    point: Point, "tuple of float",
        "The point (x, y) [m].";
    arc_length: f64, "float",
        "Arc length at the point [m].";
    cross_track_error: f64, "float",
        "Signed distance to the point [m], positive left of the path.";
    path_yaw: f64, "float",
        "Direction of the segment [rad].";
    @examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
        /// >>> path.project(2.0, 0.5).point
        /// (2.0, 0.0)
    }
}

record! {
    /// What the search for the lookahead point came back with.
    PyLookahead(Lookahead) named "Lookahead",
    index: usize, "int",
        "The index of the point in the re-discretised window.";
    point: Point, "tuple of float",
        "The point (x, y) [m].";
    found: bool, "bool",
        "Whether it lies on the circle; otherwise it is the last point of the window.";
    @examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
        /// >>> path.get_lookahead_point(0.0, 0.0, 6.0).found
        /// True
    }
}
