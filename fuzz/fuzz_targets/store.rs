//! The parameter store: flash in which somebody else has written, or that holds anything. What is loaded is what was stored or told as
//! lost, the next save is taken and loads back exactly, and a power cut at a byte of it leaves the old or the new.
#![no_main]

use std::sync::LazyLock;

use fuzz::stored::{Small, Stored, filled, hold};
use libfuzzer_sys::fuzz_target;

/// Flash after no save, one, and so on.
static FILLED: LazyLock<Vec<(Small, Stored)>> = LazyLock::new(|| (0..16).map(filled).collect());

fuzz_target!(|bytes: &[u8]| {
    let [saves, sub, rest @ ..] = bytes else {
        return;
    };
    let (mut flash, before) = FILLED[usize::from(saves % 16)].clone();
    let sub = sub % 5;
    if let [anything, rest @ ..] = rest
        && *anything == 0xFF
    {
        for (cell, byte) in flash.bytes.iter_mut().zip(rest) {
            *cell = *byte;
        }
        hold(&flash.bytes, None, sub, 97);
        return;
    }
    // A place and what is written there.
    let (changes, _) = rest.as_chunks::<3>();
    for [low, high, byte] in changes {
        let at = usize::from(u16::from_le_bytes([*low, *high])) % flash.bytes.len();
        flash.bytes[at] = *byte;
    }
    hold(&flash.bytes, Some(&before), sub, 97);
});
