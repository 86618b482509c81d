//! What is found on a path: the projection of a position, and the lookahead point.

use popsteer_core::Point;
use popsteer_core::path::Projection;
use popsteer_core::path::lookahead::Lookahead;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::record::record;

record! {
    /// The projection of a position onto a path: its closest point there.
    ///
    /// Parameters
    /// ----------
    /// segment : int
    ///     The segment that carries the point; it starts at the waypoint of the same index.
    /// fraction : float
    ///     Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    /// point : tuple of float
    ///     The point (x, y) [m].
    /// arc_length : float
    ///     Arc length at the point [m].
    /// cross_track_error : float
    ///     Signed distance to the point [m], positive left of the path.
    /// path_yaw : float
    ///     Direction of the segment [rad].
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
    /// >>> path.project(2.0, 0.5).point
    /// (2.0, 0.0)
    PyProjection(Projection) named "Projection",
    /// The segment that carries the point.
    segment: usize;
    /// Where on the segment: 0 at its start, 1 at its end.
    fraction: f64;
    /// The point (x, y) [m].
    point: Point;
    /// Arc length at the point [m].
    arc_length: f64;
    /// Signed distance to the point [m], positive left of the path.
    cross_track_error: f64;
    /// Direction of the segment [rad].
    path_yaw: f64;
}

record! {
    /// What the search for the lookahead point came back with.
    ///
    /// Parameters
    /// ----------
    /// index : int
    ///     The index of the point in the re-discretised window.
    /// point : tuple of float
    ///     The point (x, y) [m].
    /// found : bool
    ///     Whether it lies on the circle; otherwise it is the last point of the window.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
    /// >>> path.get_lookahead_point(0.0, 0.0, 6.0).found
    /// True
    PyLookahead(Lookahead) named "Lookahead",
    /// The index of the point in the re-discretised window.
    index: usize;
    /// The point (x, y) [m].
    point: Point;
    /// Whether it lies on the circle; otherwise it is the last point of the window.
    found: bool;
}
