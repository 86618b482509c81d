//! Which signal is wrong where a heading repeats to the bit and the vehicle does not turn as commanded: the
//! heading, of a sensor that is dead, or the steering, whose wheels stick straight ahead.
//!
//! From where the turns begin to differ from the commanded ones, by `theta_k` so far, the vehicle moves aside
//! of its heading. Either by nothing, as the heading is right and the wheels do not obey; or, as the wheels
//! obey and the heading does not tell it, by
//!
//! ```text
//! b = sum of s_k theta_(k-1),     s_k the distance of a period
//! ```
//!
//! Of a measured `a` with the noise `n` of two positions, the likelihood ratio of both is that of
//! `b (a - b / 2)` to 0 (J. Neyman and E. Pearson, *On the problem of the most efficient tests of statistical
//! hypotheses*, 1933). Where `b` is no more than `4 n` it decides nothing; then it is the heading if that was
//! noisy, as no live sensor repeats its noise.
//!
//! Assumed: what the vehicle slips besides is known.

/// The turns and the ways that differ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Course {
    /// `theta`: how far the turns commanded are ahead of those of the heading [rad].
    pub turn: f64,
    /// `a`: how far the vehicle moved aside of its heading [m].
    pub aside: f64,
    /// `b`: how far it would, if it had turned as commanded [m].
    pub commanded: f64,
}

impl Course {
    /// `b` over this many standard deviations of the position decides. Less: noise does. More: a short way
    /// decides nothing.
    const DEVIATIONS: f64 = 4.0;

    /// Adds a period whose turn is `missing` [rad] and in which the vehicle moved `travel` [m], and so far
    /// `aside` of where its heading and its wheels have it.
    #[inline]
    pub(super) fn add(&mut self, missing: f64, travel: f64, aside: f64) {
        self.aside += aside;
        self.commanded += travel * self.turn;
        self.turn += missing;
    }

    /// Whether it is the heading that is wrong, which repeats. `noise` is the position's [m]; the heading
    /// `was_noisy` or not.
    pub(super) fn blames_heading(&self, noise: f64, was_noisy: bool) -> bool {
        if self.commanded.abs() > Self::DEVIATIONS * noise {
            self.commanded * (self.aside - 0.5 * self.commanded) > 0.0
        } else {
            was_noisy
        }
    }
}

#[cfg(test)]
mod tests;
