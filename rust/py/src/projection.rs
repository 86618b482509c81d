//! What is found on a path: the foot of a position, and the lookahead point.

use popsteer_core::path::Projection;
use popsteer_core::path::lookahead::Lookahead;
use pyo3::prelude::*;

/// The foot of a position on a path.
///
/// Attributes
/// ----------
/// segment : int
///     The segment that carries the foot; it starts at the waypoint of the same index.
/// fraction : float
///     Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
/// point : tuple of float
///     The foot (x, y) [m].
/// arc_length : float
///     Arc length at the foot [m].
/// cross_track_error : float
///     Signed distance to the foot [m], positive left of the path.
/// path_yaw : float
///     Direction of the segment [rad].
#[pyclass(frozen, eq, name = "Projection", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyProjection(pub(crate) Projection);

#[pymethods]
impl PyProjection {
    /// The segment that carries the foot.
    #[getter]
    fn segment(&self) -> usize {
        self.0.segment
    }

    /// Where on the segment: 0 at its start, 1 at its end.
    #[getter]
    fn fraction(&self) -> f64 {
        self.0.fraction
    }

    /// The foot (x, y) [m].
    #[getter]
    fn point(&self) -> (f64, f64) {
        (self.0.point.x, self.0.point.y)
    }

    /// Arc length at the foot [m].
    #[getter]
    fn arc_length(&self) -> f64 {
        self.0.arc_length
    }

    /// Signed distance to the foot [m], positive left of the path.
    #[getter]
    fn cross_track_error(&self) -> f64 {
        self.0.cross_track_error
    }

    /// Direction of the segment [rad].
    #[getter]
    fn path_yaw(&self) -> f64 {
        self.0.path_yaw
    }

    fn __repr__(&self) -> String {
        let foot = self.0;
        format!(
            "Projection(segment={}, fraction={:?}, point=({:?}, {:?}), arc_length={:?}, \
             cross_track_error={:?}, path_yaw={:?})",
            foot.segment,
            foot.fraction,
            foot.point.x,
            foot.point.y,
            foot.arc_length,
            foot.cross_track_error,
            foot.path_yaw
        )
    }
}

/// What the search for the lookahead point came back with.
///
/// Attributes
/// ----------
/// index : int
///     The index of the point in the re-discretised window.
/// point : tuple of float
///     The point (x, y) [m].
/// found : bool
///     Whether it lies on the circle; otherwise it is the last point of the window.
#[pyclass(frozen, eq, name = "Lookahead", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyLookahead(pub(crate) Lookahead);

#[pymethods]
impl PyLookahead {
    /// The index of the point in the re-discretised window.
    #[getter]
    fn index(&self) -> usize {
        self.0.index
    }

    /// The point (x, y) [m].
    #[getter]
    fn point(&self) -> (f64, f64) {
        (self.0.point.x, self.0.point.y)
    }

    /// Whether it lies on the circle; otherwise it is the last point of the window.
    #[getter]
    fn found(&self) -> bool {
        self.0.found
    }

    fn __repr__(&self) -> String {
        let Lookahead {
            index,
            point,
            found,
        } = self.0;
        let found = if found { "True" } else { "False" };
        format!(
            "Lookahead(index={index}, point=({:?}, {:?}), found={found})",
            point.x, point.y
        )
    }
}
