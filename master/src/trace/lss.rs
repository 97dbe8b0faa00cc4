//! LSS services in words (CiA 305).

use canopen::BitRate;

/// A request of the LSS master.
pub fn request(frame: &[u8; 8]) -> String {
    let [command, a, b, c, d, bit, sub, _] = *frame;
    let word = u32::from_le_bytes([a, b, c, d]);
    match command {
        0x04 if a == 0 => "LSS: all to waiting state".to_owned(),
        0x04 => "LSS: all to configuration state".to_owned(),
        0x40..=0x43 => format!("LSS: select 1018h:{} = {word:08X}h", command - 0x3F),
        0x11 => format!("LSS: take node-ID {a}"),
        0x13 => match BitRate::from_table_index(b) {
            Some(rate) => format!("LSS: take {} kbit/s", rate.kbit_per_second()),
            None => format!("LSS: take bit timing {a}:{b}"),
        },
        0x15 => format!("LSS: switch bit rate, {} ms", u16::from_le_bytes([a, b])),
        0x17 => "LSS: store".to_owned(),
        0x46..=0x4B => "LSS: whose identity is in this range?".to_owned(),
        0x4C => "LSS: who has no node-ID?".to_owned(),
        0x51 if bit == 0x80 => "LSS fastscan: is anybody there without a node-ID?".to_owned(),
        0x51 if bit > 0 => format!(
            "LSS fastscan: 1018h:{} = {word:08X}h down to bit {bit}?",
            sub + 1
        ),
        0x51 => format!("LSS fastscan: 1018h:{} = {word:08X}h?", sub + 1),
        0x5A..=0x5D => format!("LSS: your 1018h:{}?", command - 0x59),
        0x5E => "LSS: your node-ID?".to_owned(),
        _ => "LSS request".to_owned(),
    }
}

/// An answer of an LSS slave.
pub fn answer(frame: &[u8; 8]) -> String {
    let [command, a, b, c, d, ..] = *frame;
    let word = u32::from_le_bytes([a, b, c, d]);
    let done = |what: &str| match a {
        0 => format!("LSS: {what}"),
        error => format!("LSS: refused, error {error}"),
    };
    match command {
        0x44 => "LSS: selected".to_owned(),
        0x11 => done("node-ID taken"),
        0x13 => done("bit rate taken"),
        0x17 => done("stored"),
        0x4F => "LSS: yes".to_owned(),
        0x50 => "LSS: I have no node-ID".to_owned(),
        0x5A..=0x5D => format!("LSS: 1018h:{} = {word:08X}h", command - 0x59),
        0x5E => format!("LSS: node-ID {a}"),
        _ => "LSS answer".to_owned(),
    }
}
