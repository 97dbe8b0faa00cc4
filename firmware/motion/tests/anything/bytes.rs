//! Numbers out of bytes: what a fuzzer changes and keeps. Where there are no more bytes, all are 0.

use motion::{Goal, Limits, Ramps, SignedSpeed, Speed};

/// Bytes that have not been read yet.
#[derive(Debug)]
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// All of them.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Whether there are no more.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next one.
    pub fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => 0,
        }
    }

    /// Two of them as a number.
    pub fn word(&mut self) -> u16 {
        u16::from_le_bytes([self.byte(), self.byte()])
    }

    /// A number below 2^`most`. The first byte says how long it is, so that all magnitudes are as likely.
    pub fn number(&mut self, most: u32) -> u64 {
        let bits = u32::from(self.byte()) % (most + 1);
        let mut value = 0;
        for place in 0..bits.div_ceil(8) {
            value |= u64::from(self.byte()) << (8 * place);
        }
        value & u64::MAX.checked_shr(64 - bits).unwrap_or(0)
    }

    /// The same, 32 bits.
    pub fn rate(&mut self) -> u32 {
        self.number(32) as u32
    }

    /// The same with a sign.
    pub fn signed(&mut self, most: u32) -> i64 {
        let is_negative = self.byte() & 1 != 0;
        let amount = self.number(most.min(63)) as i64;
        if is_negative { -amount } else { amount }
    }

    /// Steps/s, fractions too.
    pub fn speed(&mut self) -> Speed {
        Speed::from_bits(self.number(64))
    }

    /// The same with a sign.
    pub fn signed_speed(&mut self) -> SignedSpeed {
        SignedSpeed::from_bits(self.signed(63))
    }

    /// Limits, zero ones too.
    pub fn limits(&mut self) -> Limits {
        Limits {
            velocity: self.speed(),
            acceleration: self.rate(),
            deceleration: self.rate(),
        }
    }

    /// A form of ramps.
    pub fn ramps(&mut self) -> Ramps {
        match self.byte() % 4 {
            0 => Ramps::Linear,
            1 | 2 => Ramps::SinSquared,
            _ => Ramps::MovingAverage(self.rate()),
        }
    }

    /// A goal; positions of all magnitudes.
    pub fn goal(&mut self) -> Goal {
        match self.byte() % 4 {
            0 => Goal::Rest(self.signed(34)),
            1 => Goal::Pass(self.signed(34), self.speed()),
            2 => Goal::Velocity(self.signed_speed()),
            _ => Goal::Velocity(SignedSpeed::ZERO),
        }
    }
}
