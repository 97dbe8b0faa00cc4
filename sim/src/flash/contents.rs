//! What a flash holds, told before anything is believed or written: a log of ours, one that somebody has damaged, or something else.
//!
//! The log (`sequential-storage`) passes by what it cannot read, because a power cut leaves such things behind. A cut is told from damage
//! by its shape: it leaves off, so behind it the flash is still erased. Damage counts until a directory of parameters is written
//! behind it.

use super::{SECTOR, WORD};

/// What a flash holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Nothing, or a log that a power cut may have ended.
    Whole,
    /// A log that somebody else has written into.
    Damaged,
    /// Something else than a log.
    Foreign,
}

/// Checksum, length, checksum of the length.
const HEADER: usize = 8;

/// A header that a power cut has left half written is skipped in so many words.
const HALF_A_HEADER: usize = HEADER / WORD;

/// Key of the directory of parameters, the first byte of its record.
const DIRECTORY: u8 = 0x20;

const ERASED: u8 = 0xFF;

/// What a cut in the middle of a byte leaves set.
const HALF_WRITTEN: u8 = 0xAA;

/// The first word of a sector in use, and the last one of a sector that is full.
const MARKER: [u8; WORD] = [0; WORD];

#[derive(Debug, Default)]
struct Findings {
    records: usize,
    is_damaged: bool,
}

/// Looks through both sectors.
pub(super) fn contents(bytes: &[u8]) -> Contents {
    let mut sectors: Vec<&[u8]> = bytes.chunks(SECTOR).collect();
    // What is older comes first: a sector that is full.
    sectors.sort_by_key(|sector| !sector.ends_with(&MARKER));
    let mut findings = Findings::default();
    for sector in sectors {
        findings.look_at(sector);
    }
    match findings {
        Findings { is_damaged, .. } if !is_damaged => Contents::Whole,
        Findings { records: 0, .. } => Contents::Foreign,
        Findings { .. } => Contents::Damaged,
    }
}

impl Findings {
    fn look_at(&mut self, sector: &[u8]) {
        let (marker, items) = sector.split_at(WORD);
        // The first byte may have been half erased when the power went.
        if marker[1..] != MARKER[1..] {
            // Erased, wholly or until the power went; or a first word that was cut.
            let is_ours = marker.contains(&ERASED) || is_erased(items);
            self.is_damaged |= !is_ours;
            return;
        }
        let mut rest = &items[..items.len() - WORD];
        let mut skipped = 0;
        while rest.len() >= HEADER && !is_erased(&rest[..HEADER]) {
            let Some((record, checksum, after)) = item(rest) else {
                skipped += 1;
                self.is_damaged |= skipped > HALF_A_HEADER;
                rest = &rest[WORD..];
                continue;
            };
            skipped = 0;
            if record_checksum(record) == checksum {
                self.records += 1;
                self.is_damaged &= record.first() != Some(&DIRECTORY);
            } else {
                // A record that was cut ends in what is still erased, or half written.
                let last = rest[rest.len() - after.len() - 1];
                self.is_damaged |= last | HALF_WRITTEN != last;
            }
            rest = after;
        }
        self.is_damaged |= !is_erased(rest);
    }
}

fn is_erased(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| *byte == ERASED)
}

/// The record at the beginning of `bytes`, its checksum, and what is behind it; `None` if there is no header.
fn item(bytes: &[u8]) -> Option<(&[u8], u32, &[u8])> {
    let (header, data) = bytes.split_first_chunk::<HEADER>()?;
    let [c0, c1, c2, c3, l0, l1, k0, k1] = *header;
    if length_checksum([l0, l1]) != u16::from_le_bytes([k0, k1]) {
        return None;
    }
    let length = usize::from(u16::from_le_bytes([l0, l1]));
    let record = data.get(..length)?;
    let after = data.get(length.next_multiple_of(WORD)..)?;
    Some((record, u32::from_le_bytes([c0, c1, c2, c3]), after))
}

/// As the log reckons it, with a polynomial of Koopman's.
fn length_checksum(length: [u8; 2]) -> u16 {
    match !reflected(0xFFFF, 0x1A2E, &length) as u16 {
        0xFFFF => 0xFFFE,
        other => other,
    }
}

/// As the log reckons it: CRC-32C with another start, and no first byte that a cut could leave.
fn record_checksum(record: &[u8]) -> u32 {
    match !reflected(0xEEEE_EEEE, 0x82F6_3B78, record) {
        0 => 1,
        other if matches!(other as u8, 0x00 | 0xFF) => other ^ 1,
        other => other,
    }
}

fn reflected(start: u32, polynomial: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(start, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            crc >> 1 ^ if crc & 1 != 0 { polynomial } else { 0 }
        })
    })
}
