//! The terms that the integral of a PID sums: the last so many.

use crate::error::{InputError, input_within};
use crate::math::saturate;
#[cfg(feature = "serde")]
use crate::row::Row;
use crate::vehicle::state::check_count;

/// Bound of errors, terms and their sums [m], [m s], which no valid input reaches.
pub(super) const BOUND: f64 = 1e16;

/// The last so many terms of the integral, first in, first out, and their sum.
///
/// The sum is carried along, and taken anew each time the buffer comes round, so that rounding
/// cannot build up over a long run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Saved", into = "Saved")
)]
pub struct ErrorBuffer {
    terms: [f64; Self::CAPACITY],
    length: usize,
    count: usize,
    next: usize,
    sum: f64,
}

impl ErrorBuffer {
    /// The longest buffer: the paper's. Larger values make every state of a PID larger, whatever
    /// the length of its buffer.
    pub const CAPACITY: usize = 500;

    /// An empty buffer for `length` terms, at least one and at most [`CAPACITY`](Self::CAPACITY).
    pub fn new(length: usize) -> Self {
        let length = length.clamp(1, Self::CAPACITY);
        Self {
            terms: [0.0; Self::CAPACITY],
            length,
            count: 0,
            next: 0,
            sum: 0.0,
        }
    }

    /// Takes in a term; the oldest leaves a full buffer.
    #[inline]
    pub fn push(&mut self, term: f64) {
        let full = self.count == self.length;
        if let Some(place) = self.terms.get_mut(self.next) {
            let rest = if full { self.sum - *place } else { self.sum };
            // A state that was restored may have as much as the bound.
            self.sum = saturate(rest + term, -BOUND, BOUND);
            *place = term;
        }
        if !full {
            self.count += 1;
        }
        self.next += 1;
        if self.next == self.length {
            self.next = 0;
            let terms = self.terms.iter().take(self.length);
            self.sum = saturate(terms.fold(0.0, |sum, term| sum + term), -BOUND, BOUND);
        }
    }

    /// A buffer as it was: `terms` oldest first, `next` the place of the next one, `sum` as
    /// carried along.
    ///
    /// # Errors
    ///
    /// [`InputError`] where no buffer of this `length` could have been so.
    pub fn restore(
        length: usize,
        terms: &[f64],
        next: usize,
        sum: f64,
    ) -> Result<Self, InputError> {
        let buffer = Self::of(length.clamp(1, Self::CAPACITY), terms, next, sum);
        buffer.check()?;
        Ok(buffer)
    }

    /// The same, which may be none that could have been.
    fn of(length: usize, terms: &[f64], next: usize, sum: f64) -> Self {
        let mut buffer = Self {
            terms: [0.0; Self::CAPACITY],
            length,
            count: terms.len(),
            next,
            sum,
        };
        let start = if buffer.count == length { next } else { 0 };
        for (k, &term) in terms.iter().enumerate() {
            let place = Self::around(start.saturating_add(k), length);
            if let Some(place) = buffer.terms.get_mut(place) {
                *place = term;
            }
        }
        buffer
    }

    /// The place of the next term.
    pub fn next(&self) -> usize {
        self.next
    }

    /// Whether it is a buffer that so many terms can have been pushed to.
    pub(super) fn check(&self) -> Result<(), InputError> {
        let (count, length) = (self.count, self.length);
        let (low, high) = if count < length {
            (count, count)
        } else {
            (0, length.saturating_sub(1))
        };
        check_count("law.buffer.terms", count, 0, length)?;
        check_count("law.buffer.next", self.next, low, high)?;
        for term in self.terms() {
            input_within("law.buffer.terms", term, BOUND)?;
        }
        input_within("law.buffer.sum", self.sum, BOUND).map(|_| ())
    }

    /// A place in a buffer of this length, counted round its end at most once.
    fn around(place: usize, length: usize) -> usize {
        if place < length {
            place
        } else {
            place - length
        }
    }

    /// The sum of the terms held.
    #[inline]
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// How many terms the buffer has room for.
    pub fn length(&self) -> usize {
        self.length
    }

    /// The terms held, oldest first.
    pub fn terms(&self) -> impl Iterator<Item = f64> + '_ {
        let start = if self.count == self.length {
            self.next
        } else {
            0
        };
        (0..self.count).filter_map(move |k| {
            self.terms
                .get(Self::around(start + k, self.length))
                .copied()
        })
    }
}

/// A buffer as data.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Saved {
    length: usize,
    /// Oldest first.
    terms: Row<f64, { ErrorBuffer::CAPACITY }>,
    next: usize,
    sum: f64,
}

#[cfg(feature = "serde")]
impl From<ErrorBuffer> for Saved {
    fn from(buffer: ErrorBuffer) -> Self {
        Self {
            length: buffer.length,
            terms: buffer.terms().collect(),
            next: buffer.next,
            sum: buffer.sum,
        }
    }
}

#[cfg(feature = "serde")]
impl From<Saved> for ErrorBuffer {
    fn from(saved: Saved) -> Self {
        Self::of(saved.length, saved.terms.entries(), saved.next, saved.sum)
    }
}

#[cfg(test)]
mod tests;
