//! The parameter store: flash in which somebody else has written, or that holds anything. What is loaded is what was stored or told as
//! lost, the next save is taken and loads back exactly, and a power cut at a byte of it leaves the old or the new.
#![no_main]

use std::sync::LazyLock;

use fuzz::stored::{Filled, hold};
use libfuzzer_sys::fuzz_target;

/// Flash after no save, one, and so on.
static FILLED: LazyLock<Vec<Filled>> = LazyLock::new(|| (0..16).map(Filled::new).collect());

fuzz_target!(|input: &[u8]| {
    let [saves, sub, rest @ ..] = input else {
        return;
    };
    let before = &FILLED[usize::from(saves % 16)];
    let mut bytes = before.flash.bytes.clone();
    let sub = sub % 5;
    if let [anything, rest @ ..] = rest
        && *anything == 0xFF
    {
        for (cell, byte) in bytes.iter_mut().zip(rest) {
            *cell = *byte;
        }
        hold(&bytes, None, sub, 97);
        return;
    }
    // A place and what is written there.
    let (changes, _) = rest.as_chunks::<3>();
    for [low, high, byte] in changes {
        let at = usize::from(u16::from_le_bytes([*low, *high])) % bytes.len();
        bytes[at] = *byte;
    }
    hold(&bytes, Some(before), sub, 97);
});
