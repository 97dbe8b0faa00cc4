//! Switches on the board that say which node the device is: two hexadecimal rotary switches, or a row of DIP switches.
//!
//! The board reads them once, at power-up, as a number; here it becomes a [`Wish`]. The low bits are the node-ID, and 0 there
//! leaves it to what is stored. The bits above choose the bit rate from a list of the product. One place of that list must be a
//! bit rate that is known to everybody: that position rescues a device whose stored bit rate nobody remembers.
//!
//! ```text
//!   rotary ×10h   ×01h          DIP   10  9  8   7 6 5 4 3 2 1
//!       n          n                  └ rate ┘   └─ node-ID ─┘
//!   └1┘└── 7 ────────┘
//!  rate   node-ID
//! ```

use super::{BitRate, BitTiming, NodeId, Wish};

/// What one value of the rate switches asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// What is stored.
    Stored,
    /// This bit rate, or automatic detection.
    Set(BitTiming),
}

/// What the switches of a product mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// How many of the low bits are the node-ID, 1 to 7.
    node_id_bits: u32,
    /// What the bits above ask for, from 0 on.
    rates: &'static [Field],
}

/// 1 Mbit/s, which every position that rescues has.
const KNOWN: Field = Field::Set(BitTiming::Fixed(BitRate::Kbit1000));

impl Switches {
    /// Two hexadecimal rotary switches, or eight DIP switches. 00h leaves both to what is stored; 01h to 7Fh set the node-ID;
    /// 80h to FFh are the same at 1 Mbit/s, whatever is stored.
    pub const ROTARY: Self = Self::new(7, &[Field::Stored, KNOWN]);

    /// Two hexadecimal rotary switches the other way round, as some devices on the market have them: 00h to 7Fh are at 1 Mbit/s,
    /// 80h to FFh at the stored bit rate.
    pub const ROTARY_REVERSED: Self = Self::new(7, &[KNOWN, Field::Stored]);

    /// One hexadecimal rotary switch of that kind: 0 to 7 at 1 Mbit/s, 8 to Fh at the stored bit rate.
    pub const SINGLE_ROTARY_REVERSED: Self = Self::new(3, &[KNOWN, Field::Stored]);

    /// Ten DIP switches: 1 to 7 the node-ID, 8 to 10 the bit rate: stored, 1000, 500, 250, 125, 50, 20 kbit/s, automatic.
    pub const DIP: Self = Self::new(
        7,
        &[
            Field::Stored,
            KNOWN,
            Field::Set(BitTiming::Fixed(BitRate::Kbit500)),
            Field::Set(BitTiming::Fixed(BitRate::Kbit250)),
            Field::Set(BitTiming::Fixed(BitRate::Kbit125)),
            Field::Set(BitTiming::Fixed(BitRate::Kbit50)),
            Field::Set(BitTiming::Fixed(BitRate::Kbit20)),
            Field::Set(BitTiming::Automatic),
        ],
    );

    /// Switches of a product: so many low bits (1 to 7; others count as the nearest of these) are the node-ID, the bits above
    /// them choose from `rates`.
    pub const fn new(node_id_bits: u32, rates: &'static [Field]) -> Self {
        Self {
            node_id_bits: match node_id_bits {
                0 => 1,
                1..=7 => node_id_bits,
                _ => 7,
            },
            rates,
        }
    }

    /// What a reading asks for. A position that means nothing (above the list of bit rates) asks for nothing at all: the device
    /// starts as if it had no switches.
    pub fn wish(&self, reading: u16) -> Wish {
        let rate = reading.checked_shr(self.node_id_bits).unwrap_or(0);
        let Some(field) = self.rates.get(usize::from(rate)) else {
            return Wish::NOTHING;
        };
        let mask = 1_u16.checked_shl(self.node_id_bits).unwrap_or(0);
        let number = reading & mask.wrapping_sub(1);
        Wish {
            // At most seven bits: 0 is left, which is no node-ID.
            node_id: u8::try_from(number).ok().and_then(NodeId::new),
            bit_timing: match field {
                Field::Stored => None,
                Field::Set(timing) => Some(*timing),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish(node_id: Option<u8>, bit_rate: Option<BitRate>) -> Wish {
        Wish {
            node_id: node_id.map(|number| NodeId::new(number).unwrap()),
            bit_timing: bit_rate.map(BitTiming::Fixed),
        }
    }

    #[test]
    fn every_position_of_two_rotary_switches_has_its_meaning() {
        for reading in 0..=0xFF {
            let node_id = (reading & 0x7F) as u8;
            let is_known = reading >= 0x80;
            assert_eq!(
                Switches::ROTARY.wish(reading),
                wish(
                    (node_id != 0).then_some(node_id),
                    is_known.then_some(BitRate::Kbit1000)
                ),
                "{reading:02X}"
            );
        }
    }

    #[test]
    fn reversed_switches_have_the_known_bit_rate_in_the_lower_half() {
        for (switches, half) in [
            (Switches::ROTARY_REVERSED, 0x80),
            (Switches::SINGLE_ROTARY_REVERSED, 0x08),
        ] {
            let known = Some(BitRate::Kbit1000);
            assert_eq!(switches.wish(0), wish(None, known));
            assert_eq!(switches.wish(1), wish(Some(1), known));
            assert_eq!(switches.wish(half - 1), wish(Some((half - 1) as u8), known));
            assert_eq!(switches.wish(half), wish(None, None));
            assert_eq!(switches.wish(half + 2), wish(Some(2), None));
        }
    }

    #[test]
    fn dip_switches_choose_the_bit_rate_too() {
        let at = |rate: u16| Switches::DIP.wish(rate << 7 | 5);
        assert_eq!(at(0), wish(Some(5), None));
        for (rate, bit_rate) in (1..).zip([
            BitRate::Kbit1000,
            BitRate::Kbit500,
            BitRate::Kbit250,
            BitRate::Kbit125,
            BitRate::Kbit50,
            BitRate::Kbit20,
        ]) {
            assert_eq!(at(rate), wish(Some(5), Some(bit_rate)));
        }
        assert_eq!(at(7).bit_timing, Some(BitTiming::Automatic));
    }

    #[test]
    fn a_position_that_means_nothing_asks_for_nothing() {
        assert_eq!(Switches::DIP.wish(0x0405), Wish::NOTHING);
        for reading in 0x100..=u16::MAX {
            assert_eq!(Switches::ROTARY.wish(reading), Wish::NOTHING);
        }
        assert_eq!(Switches::new(7, &[]).wish(5), Wish::NOTHING);
    }

    #[test]
    fn no_reading_makes_an_illegal_node_id() {
        for bits in 0..=40 {
            let switches = Switches::new(bits, &[Field::Stored; 8]);
            for reading in 0..=u16::MAX {
                let node_id = switches.wish(reading).node_id;
                assert!(node_id.is_none_or(NodeId::is_configured));
            }
        }
    }
}
