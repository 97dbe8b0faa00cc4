//! Instructions as far as they say something of the stack.

use anyhow::{Result, bail};

/// What an instruction is to the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Instruction {
    /// So many bytes of the stack.
    Takes(u64),
    /// Goes on so far from here.
    Branch(i64),
    /// Goes on wherever a register says.
    ByPointer,
    /// One half of an address comes into a register.
    Low(u32, u32),
    High(u32, u32),
    Other,
}

/// Of the first half of an instruction, and the second one of a wide one.
pub(super) fn decode(first: u32, second: Option<u32>) -> Result<Instruction> {
    use Instruction::{Branch, ByPointer, High, Low, Other, Takes};
    let Some(second) = second else {
        return Ok(match first {
            // push
            _ if first & 0xFE00 == 0xB400 => Takes(4 * u64::from((first & 0x1FF).count_ones())),
            // sub sp, #
            _ if first & 0xFF80 == 0xB080 => Takes(4 * u64::from(first & 0x7F)),
            // blx, and bx but to where it came from
            _ if first & 0xFF87 == 0x4780 => ByPointer,
            _ if first & 0xFF87 == 0x4700 && first >> 3 & 0xF != 14 => ByPointer,
            // b
            _ if first & 0xF800 == 0xE000 => Branch(signed(first & 0x7FF, 11) * 2),
            _ if first & 0xF000 == 0xD000 && first >> 9 & 7 != 7 => {
                Branch(signed(first & 0xFF, 8) * 2)
            }
            _ => Other,
        });
    };
    let shifted = || {
        let byte = second & 0xFF;
        let how = (first >> 10 & 1) << 4 | (second >> 12 & 7) << 1 | byte >> 7;
        match how >> 1 {
            0 => byte,
            1 => byte | byte << 16,
            2 => byte << 8 | byte << 24,
            3 => byte * 0x0101_0101,
            _ => (byte | 0x80).rotate_right(how),
        }
    };
    let wide =
        || (first & 0xF) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xFF;
    Ok(match first {
        // stmdb sp!
        0xE92D => Takes(4 * u64::from(second.count_ones())),
        // str and strd with the address counted down
        0xF84D if second & 0x0F00 == 0x0D00 => Takes(u64::from(second & 0xFF)),
        0xE96D => Takes(4 * u64::from(second & 0xFF)),
        // vpush
        _ if first & 0xFFBF == 0xED2D => Takes(4 * u64::from(second & 0xFF)),
        // sub sp, sp, #
        _ if first & 0xFBEF == 0xF1AD && second & 0x8F00 == 0x0D00 => Takes(shifted().into()),
        _ if first & 0xFBFF == 0xF2AD && second & 0x8F00 == 0x0D00 => {
            Takes((wide() & 0xFFF).into())
        }
        // sub sp, sp, register
        0xEBAD if second & 0x0F00 == 0x0D00 => bail!("a stack that grows by a variable"),
        // movw and movt
        _ if first & 0xFBF0 == 0xF240 && second & 0x8000 == 0 => Low(second >> 8 & 0xF, wide()),
        _ if first & 0xFBF0 == 0xF2C0 && second & 0x8000 == 0 => High(second >> 8 & 0xF, wide()),
        // bl and b, far
        _ if first & 0xF800 == 0xF000 && second & 0x9000 == 0x9000 => {
            let sign = first >> 10 & 1;
            let bit = |bit: u32| !(second >> bit ^ sign) & 1;
            let offset = sign << 24
                | bit(13) << 23
                | bit(11) << 22
                | (first & 0x3FF) << 12
                | (second & 0x7FF) << 1;
            Branch(signed(offset, 25))
        }
        // b where a condition holds
        _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0x8000 && first >> 7 & 7 != 7 => {
            let offset = (first >> 10 & 1) << 20
                | (second >> 11 & 1) << 19
                | (second >> 13 & 1) << 18
                | (first & 0x3F) << 12
                | (second & 0x7FF) << 1;
            Branch(signed(offset, 21))
        }
        _ => Other,
    })
}

/// The number in so many bits, the highest of which is the sign.
pub(super) fn signed(value: u32, bits: u32) -> i64 {
    let value = i64::from(value);
    value - (value >> (bits - 1) << bits)
}
