//! What a touch probe looks at.

use super::InputConfiguration;

/// A source of 60D0h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// 1: the input of probe 1.
    Probe1,
    /// 2: the input of probe 2.
    Probe2,
    /// 5: the index pulse.
    Index,
    /// −1 to −6: digital input 1 to 6, whatever its function is. This is its mask.
    Input(u8),
}

impl Source {
    /// The source with this number; `None` if there is none.
    #[inline(never)]
    pub fn from_code(code: i16) -> Option<Self> {
        match code {
            1 => Some(Self::Probe1),
            2 => Some(Self::Probe2),
            5 => Some(Self::Index),
            -6..=-1 => {
                let input = u32::from(code.unsigned_abs()).wrapping_sub(1);
                Some(Self::Input(1_u8.wrapping_shl(input)))
            }
            _ => None,
        }
    }

    /// Its inputs.
    pub(crate) const fn mask(self, inputs: &InputConfiguration) -> u8 {
        match (self, inputs.touch_probes) {
            (Self::Probe1, [mask, _]) | (Self::Probe2, [_, mask]) => mask,
            (Self::Index, _) => inputs.index,
            (Self::Input(mask), _) => mask,
        }
    }
}

/// 60B8h: bits of the source.
pub(crate) const SOURCE: u8 = 0b11 << 2;

/// The functions of both probes in 60B8h: bits 3 and 2 (11 and 10) name a source, or there is none. Bits 6, 7, 14 and 15 are the user's.
pub(crate) const fn probe_functions(value: u16) -> Option<[u8; 2]> {
    let [first, second] = value.to_le_bytes();
    if first & SOURCE != SOURCE && second & SOURCE != SOURCE {
        Some([first, second])
    } else {
        None
    }
}
