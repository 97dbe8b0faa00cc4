//! What a touch probe looks at.

use crate::inputs::InputConfiguration;

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
    pub(super) const fn mask(self, inputs: &InputConfiguration) -> u8 {
        match (self, inputs.touch_probes) {
            (Self::Probe1, [mask, _]) | (Self::Probe2, [_, mask]) => mask,
            (Self::Index, _) => inputs.index,
            (Self::Input(mask), _) => mask,
        }
    }
}
