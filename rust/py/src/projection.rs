//! What is found on a path: the projection of a position, and the lookahead point.

use popsteer_core::Point;
use popsteer_core::path::Projection;
use popsteer_core::path::lookahead::Lookahead;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::params::{Count, Field, repr};

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
#[pyclass(frozen, eq, name = "Projection", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyProjection(pub(crate) Projection);

#[pymethods]
impl PyProjection {
    #[new]
    #[pyo3(signature = (*, segment, fraction, point, arc_length, cross_track_error, path_yaw))]
    fn new(
        segment: Count,
        fraction: f64,
        point: (f64, f64),
        arc_length: f64,
        cross_track_error: f64,
        path_yaw: f64,
    ) -> Self {
        Self(Projection {
            segment: segment.saturated(),
            fraction,
            point: Point::new(point.0, point.1),
            arc_length,
            cross_track_error,
            path_yaw,
        })
    }

    /// The segment that carries the point.
    #[getter]
    fn segment(&self) -> usize {
        self.0.segment
    }

    /// Where on the segment: 0 at its start, 1 at its end.
    #[getter]
    fn fraction(&self) -> f64 {
        self.0.fraction
    }

    /// The point (x, y) [m].
    #[getter]
    fn point(&self) -> (f64, f64) {
        (self.0.point.x, self.0.point.y)
    }

    /// Arc length at the point [m].
    #[getter]
    fn arc_length(&self) -> f64 {
        self.0.arc_length
    }

    /// Signed distance to the point [m], positive left of the path.
    #[getter]
    fn cross_track_error(&self) -> f64 {
        self.0.cross_track_error
    }

    /// Direction of the segment [rad].
    #[getter]
    fn path_yaw(&self) -> f64 {
        self.0.path_yaw
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        repr("Projection", &self.__getnewargs_ex__(py)?.1)
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let fields = PyDict::new(py);
        fields.set_item("segment", self.0.segment.argument())?;
        fields.set_item("fraction", self.fraction())?;
        fields.set_item("point", self.point())?;
        fields.set_item("arc_length", self.arc_length())?;
        fields.set_item("cross_track_error", self.cross_track_error())?;
        fields.set_item("path_yaw", self.path_yaw())?;
        Ok((PyTuple::empty(py), fields))
    }
}

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
#[pyclass(frozen, eq, name = "Lookahead", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyLookahead(pub(crate) Lookahead);

#[pymethods]
impl PyLookahead {
    #[new]
    #[pyo3(signature = (*, index, point, found))]
    fn new(index: Count, point: (f64, f64), found: bool) -> Self {
        Self(Lookahead {
            index: index.saturated(),
            point: Point::new(point.0, point.1),
            found,
        })
    }

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

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        repr("Lookahead", &self.__getnewargs_ex__(py)?.1)
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let fields = PyDict::new(py);
        fields.set_item("index", self.0.index.argument())?;
        fields.set_item("point", self.point())?;
        fields.set_item("found", self.found())?;
        Ok((PyTuple::empty(py), fields))
    }
}
