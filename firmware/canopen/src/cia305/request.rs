//! What an LSS master asks.

/// A request. Numbers are as sent; their ranges are the services' own business.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// 04h switch state global: 0 waiting, 1 configuration.
    SwitchGlobal(u8),
    /// 40h to 43h switch state selective: one word of the address, vendor-ID first.
    SwitchSelective {
        /// 0 to 3.
        step: u8,
        word: u32,
    },
    /// 11h configure node-ID.
    ConfigureNodeId(u8),
    /// 13h configure bit timing.
    ConfigureBitTiming { table: u8, index: u8 },
    /// 15h activate bit timing, with the switch delay in milliseconds.
    ActivateBitTiming(u16),
    /// 17h store configuration.
    Store,
    /// 46h to 4Bh identify remote slave: vendor-ID, product code, lowest and highest revision, lowest and highest
    /// serial number.
    Identify {
        /// 0 to 5.
        step: u8,
        word: u32,
    },
    /// 4Ch identify non-configured remote slave.
    IdentifyNonConfigured,
    /// 51h fastscan.
    Fastscan(Fastscan),
    /// 5Ah to 5Dh inquire identity: one word of the address.
    InquireIdentity {
        /// 0 to 3.
        step: u8,
    },
    /// 5Eh inquire node-ID.
    InquireNodeId,
}

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

impl Request {
    /// A request from its message; `None` for a command specifier that a slave does not know.
    pub(super) fn parse(message: &[u8; 8]) -> Option<Self> {
        let [specifier, a, b, c, d, bit_check, sub, next] = *message;
        let word = u32::from_le_bytes([a, b, c, d]);
        Some(match specifier {
            0x04 => Self::SwitchGlobal(a),
            0x11 => Self::ConfigureNodeId(a),
            0x13 => Self::ConfigureBitTiming { table: a, index: b },
            0x15 => Self::ActivateBitTiming(u16::from_le_bytes([a, b])),
            0x17 => Self::Store,
            0x40..=0x43 => Self::SwitchSelective {
                step: specifier & 3,
                word,
            },
            0x46..=0x4B => Self::Identify {
                step: specifier.wrapping_sub(0x46),
                word,
            },
            0x4C => Self::IdentifyNonConfigured,
            0x51 => Self::Fastscan(Fastscan {
                id_number: word,
                bit_check,
                sub,
                next,
            }),
            0x5A..=0x5D => Self::InquireIdentity {
                step: specifier.wrapping_sub(0x5A),
            },
            0x5E => Self::InquireNodeId,
            _ => return None,
        })
    }
}

/// The command specifiers of answers.
pub(super) mod answer {
    pub(crate) const NODE_ID_CONFIGURED: u8 = 0x11;
    pub(crate) const BIT_TIMING_CONFIGURED: u8 = 0x13;
    pub(crate) const STORED: u8 = 0x17;
    pub(crate) const SWITCHED_SELECTIVE: u8 = 0x44;
    pub(crate) const IDENTIFIED: u8 = 0x4F;
    pub(crate) const NON_CONFIGURED_IDENTIFIED: u8 = 0x50;
    /// Of the first word; the others follow.
    pub(crate) const IDENTITY: u8 = 0x5A;
    pub(crate) const NODE_ID: u8 = 0x5E;
}
