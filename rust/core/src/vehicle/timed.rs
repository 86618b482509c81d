//! A ring of angles with durations: commands in flight, or past angles of the wheels.

use super::state::check_count;
use crate::error::InputError;
use crate::math::smaller;
#[cfg(feature = "serde")]
use crate::row::Row;

/// The first `time` [s] of angles that last for so long each; the last of them is cut short.
#[inline]
pub fn clipped(
    timed: impl Iterator<Item = (f64, f64)>,
    time: f64,
) -> impl Iterator<Item = (f64, f64)> {
    let mut remaining = time;
    timed.map_while(move |(angle, duration)| {
        if remaining <= 0.0 {
            return None;
        }
        let part = smaller(duration, remaining);
        remaining -= part;
        Some((angle, part))
    })
}

/// At most `N` angles [rad], oldest first, and how long each lasts [s]: a ring.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Row<(f64, f64), N>", into = "Row<(f64, f64), N>")
)]
pub struct Timed<const N: usize> {
    entries: [(f64, f64); N],
    first: usize,
    count: usize,
}

/// Places of the ring that hold no angle do not count.
impl<const N: usize> PartialEq for Timed<N> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl<const N: usize> Timed<N> {
    /// No angle.
    pub const EMPTY: Self = Self {
        entries: [(0.0, 0.0); N],
        first: 0,
        count: 0,
    };

    /// The angles as they were, oldest first; refused where there are too many.
    pub(super) fn restore(
        field: &'static str,
        timed: impl ExactSizeIterator<Item = (f64, f64)>,
    ) -> Result<Self, InputError> {
        check_count(field, timed.len(), 0, N)?;
        let mut restored = Self::EMPTY;
        for (angle, duration) in timed {
            restored.push(angle, duration);
        }
        Ok(restored)
    }

    /// Takes angles [rad] and durations [s], oldest first, in place of its own.
    #[inline]
    pub(super) fn refill(&mut self, timed: &[(f64, f64)]) {
        (self.first, self.count) = (0, 0);
        for &(angle, duration) in timed {
            self.push(angle, duration);
        }
    }

    /// Angles [rad] and durations [s], oldest first.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.count).map(|k| self.get(k))
    }

    /// Whether there is no place for another angle.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count == N
    }

    /// Adds an angle; where there is no place for it, the oldest is forgotten.
    #[inline]
    pub fn push(&mut self, angle: f64, duration: f64) {
        if self.is_full() {
            self.forget_oldest();
        }
        self.set(self.count, (angle, duration));
        self.count += 1;
    }

    /// Adds an angle, or joins it to the newest where both together last `shortest` [s] at most:
    /// to their mean. One that does not last is none.
    #[inline]
    pub fn push_or_join(&mut self, angle: f64, duration: f64, shortest: f64) {
        if duration <= 0.0 {
            return;
        }
        if let Some(newest) = self.count.checked_sub(1) {
            let (mean, lasted) = self.get(newest);
            let total = lasted + duration;
            if total <= shortest {
                // Written so, it lies between the two however short they are.
                let mean = mean + (angle - mean) * (duration / total);
                return self.set(newest, (mean, total));
            }
        }
        self.push(angle, duration);
    }

    /// Takes off the oldest angle, or the first `time` [s] of one that lasts longer.
    #[inline]
    pub fn take(&mut self, time: f64) -> Option<(f64, f64)> {
        if self.count == 0 {
            return None;
        }
        let (angle, duration) = self.get(0);
        if duration > time {
            self.set(0, (angle, duration - time));
            return Some((angle, time));
        }
        self.forget_oldest();
        Some((angle, duration))
    }

    #[inline]
    fn forget_oldest(&mut self) {
        self.first = self.place(1);
        self.count -= 1;
    }

    #[inline]
    fn place(&self, k: usize) -> usize {
        let place = self.first + k;
        if place < N { place } else { place - N }
    }

    #[inline]
    fn get(&self, k: usize) -> (f64, f64) {
        self.entries.get(self.place(k)).copied().unwrap_or_default()
    }

    #[inline]
    fn set(&mut self, k: usize, entry: (f64, f64)) {
        let place = self.place(k);
        if let Some(kept) = self.entries.get_mut(place) {
            *kept = entry;
        }
    }
}

/// As data a ring is the row of its angles, oldest first.
#[cfg(feature = "serde")]
impl<const N: usize> From<Timed<N>> for Row<(f64, f64), N> {
    fn from(timed: Timed<N>) -> Self {
        timed.iter().collect()
    }
}

#[cfg(feature = "serde")]
impl<const N: usize> From<Row<(f64, f64), N>> for Timed<N> {
    fn from(row: Row<(f64, f64), N>) -> Self {
        let mut timed = Self::EMPTY;
        for &(angle, duration) in row.entries() {
            timed.push(angle, duration);
        }
        timed
    }
}
