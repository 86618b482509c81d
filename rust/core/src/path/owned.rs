//! The path that owns its waypoints.

use alloc::boxed::Box;
use alloc::vec;

use super::view::{PathView, measure};
use crate::error::PathError;

/// Waypoints copied once; [`Path::view`] lends them to the laws.
///
/// # Examples
///
/// ```
/// let path = popsteer_core::Path::new(&[0.0, 3.0], &[0.0, 4.0], None, false)?;
/// assert_eq!(path.view().length(), 5.0);
/// # Ok::<(), popsteer_core::PathError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    x: Box<[f64]>,
    y: Box<[f64]>,
    s: Box<[f64]>,
    speed: Option<Box<[f64]>>,
    length: f64,
    closed: bool,
}

impl Path {
    /// Copies waypoints `x`, `y` [m] and reference speeds [m/s]; `closed` leads the last
    /// waypoint back to the first.
    ///
    /// # Errors
    ///
    /// [`PathError`], as [`PathView::new`].
    pub fn new(
        x: &[f64],
        y: &[f64],
        speed: Option<&[f64]>,
        closed: bool,
    ) -> Result<Self, PathError> {
        let mut s = vec![0.0; x.len()].into_boxed_slice();
        let length = measure(x, y, speed, closed, &mut s)?;
        Ok(Self {
            x: x.into(),
            y: y.into(),
            s,
            speed: speed.map(Into::into),
            length,
            closed,
        })
    }

    /// The path as the laws take it.
    #[inline]
    pub fn view(&self) -> PathView<'_> {
        PathView::from_measured(
            &self.x,
            &self.y,
            &self.s,
            self.speed.as_deref(),
            self.length,
            self.closed,
        )
    }
}
