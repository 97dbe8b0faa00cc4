//! Fastscan (CiA 305): the master finds the 128 bits of an address with one question per bit.
//!
//! A scan begins with bit check 128, which every slave without a node-ID answers. Then the master asks for one word after
//! another: "does anyone's word `sub` agree with this number from bit 31 down to bit `bit_check`?" Silence means no. After
//! bit 0 the slaves that agree go on to the word `next`; the others wait for the next scan. When the last word agrees,
//! exactly one slave is left.

use super::identity::Identity;

/// The last word of the address, the serial number.
const LAST_WORD: u8 = 3;

/// The parameters of a fastscan request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fastscan {
    /// The word that the master is looking for.
    pub(super) id_number: u32,
    /// Lowest bit that counts, 0 to 31; 128 starts a scan.
    pub(super) bit_check: u8,
    /// Which word of the address `id_number` is.
    pub(super) sub: u8,
    /// Which word the master will ask for next.
    pub(super) next: u8,
}

/// Where a slave is in a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scan {
    /// The word that it listens for; `None` when it is in no scan.
    word: Option<u8>,
}

/// What a slave makes of a fastscan request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Not for this slave.
    Silent,
    /// It agrees.
    Answer,
    /// It agrees in all four words: it is the one that was looked for.
    Found,
}

impl Scan {
    /// In no scan.
    pub(super) const IDLE: Self = Self { word: None };

    /// Bit check of the request that starts a scan.
    const START: u8 = 128;

    /// Takes a request.
    pub(super) fn receive(&mut self, request: Fastscan, identity: &Identity) -> Outcome {
        if request.bit_check == Self::START {
            self.word = Some(0);
            return Outcome::Answer;
        }
        let is_known =
            request.bit_check < 32 && request.sub <= LAST_WORD && request.next <= LAST_WORD;
        let Some(word) = identity.words().get(usize::from(request.sub)).copied() else {
            return Outcome::Silent;
        };
        if !is_known || self.word != Some(request.sub) {
            return Outcome::Silent;
        }
        let counting_bits = u32::MAX.wrapping_shl(u32::from(request.bit_check));
        if (word ^ request.id_number) & counting_bits != 0 {
            return Outcome::Silent;
        }
        if request.bit_check > 0 || request.next == request.sub {
            return Outcome::Answer;
        }
        if request.sub == LAST_WORD {
            *self = Self::IDLE;
            return Outcome::Found;
        }
        // Only the last word may end a scan: an address that agrees in part is not the one, whatever `next` says.
        if request.next > request.sub {
            self.word = Some(request.next);
        }
        Outcome::Answer
    }
}
