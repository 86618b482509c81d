//! Numbers out of bytes, ordinary and hostile ones.

use std::f64::consts::{PI, TAU};

/// Where laws, paths and mathematics tend to break.
const HOSTILE: [f64; 28] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e308,
    -1e308,
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    0.0,
    -0.0,
    1e-300,
    f64::EPSILON,
    1.0,
    -1.0,
    PI,
    -PI,
    TAU,
    1e9,
    -1e9,
    1e6,
    -1e6,
    1e4,
    -1e4,
    1e3,
    1e-6,
    1e-9,
    1e16,
];

/// The input, byte by byte; zeros once it is used up.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// All of `data`.
    pub fn new(data: &'a [u8]) -> Self {
        Self(data)
    }

    /// Whether the input is used up.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        first
    }

    /// A count below `end`, which is at most 256.
    pub fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end
    }

    /// The next two bytes as a share of one.
    fn share(&mut self) -> f64 {
        f64::from(u16::from_le_bytes([self.byte(), self.byte()])) / 65_535.0
    }

    /// A number of `[low, high]`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + self.share() * (high - low)
    }

    /// Any bits at all, or one of those known to hurt.
    pub fn hostile(&mut self) -> f64 {
        let place = usize::from(self.byte());
        if let Some(&value) = HOSTILE.get(place) {
            return value;
        }
        let mut bits = [0; 8];
        bits.fill_with(|| self.byte());
        f64::from_le_bytes(bits)
    }

    /// A number for a range: mostly one of `usual`, at times an end of `whole`, a neighbour of
    /// an end, any of it, or a hostile one.
    pub fn number(&mut self, usual: [f64; 2], whole: [f64; 2]) -> f64 {
        match self.byte() {
            0..=199 => self.within(usual[0], usual[1]),
            200..=209 => whole[0],
            210..=219 => whole[1],
            220..=224 => whole[0].next_down(),
            225..=229 => whole[1].next_up(),
            230..=243 => self.within(whole[0], whole[1]),
            _ => self.hostile(),
        }
    }

    /// The same for a parameter that need not be given, which it is half the time.
    pub fn optional(&mut self, usual: [f64; 2], whole: [f64; 2]) -> Option<f64> {
        (self.byte() >= 128).then(|| self.number(usual, whole))
    }

    /// The same for a parameter, which is at its default half the time.
    pub fn parameter(&mut self, default: f64, usual: [f64; 2], whole: [f64; 2]) -> f64 {
        if self.byte() < 128 {
            default
        } else {
            self.number(usual, whole)
        }
    }
}
