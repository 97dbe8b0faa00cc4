//! What a drive has recorded: the bytes of 20D3h, read as `docs/scope.md` has them.

use super::CHANNELS;
use crate::data_sheet::{Address, DataSheet};

/// The format that this program reads.
const VERSION: u16 = 1;

/// Bytes of its header.
const HEADER: usize = 64;

/// A recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    /// The period of the control tick in nanoseconds.
    pub tick_ns: u32,
    /// Control ticks from sample to sample.
    pub divider: u16,
    /// How many samples are older than the trigger.
    pub before: usize,
    /// Control ticks from the trigger to the sample behind it.
    pub late: u16,
    /// When the trigger came, in microseconds of the drive's clock.
    pub triggered_us: u64,
    /// The values.
    pub channels: Vec<Channel>,
}

/// One value over time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its object.
    pub address: Address,
    /// Its object and what the data sheet calls it.
    pub title: String,
    /// Its samples, oldest first.
    pub values: Vec<i64>,
}

impl Recording {
    /// From the bytes of 20D3h.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn read(bytes: &[u8], sheet: &DataSheet) -> Result<Self, String> {
        let header = Header(bytes);
        let version = header.u16_at(0)?;
        if version != VERSION {
            return Err(format!(
                "the recording has format {version}; this program reads {VERSION}"
            ));
        }
        let length = usize::from(header.u16_at(2)?).max(HEADER);
        let stride = usize::from(header.u16_at(12)?);
        let count = header.u32_at(16)? as usize;
        let mut mappings = Vec::new();
        for channel in 0..CHANNELS {
            mappings.push(header.u32_at(32 + 4 * channel)?);
        }
        mappings.retain(|mapping| *mapping != 0);
        let used: usize = mappings.iter().map(|mapping| size(*mapping)).sum();
        let data = bytes.get(length..).unwrap_or_default();
        if stride == 0 || used > stride || Some(data.len()) != count.checked_mul(stride) {
            return Err(format!(
                "the recording does not fit its header: {count} samples of {stride} bytes are {} bytes",
                data.len()
            ));
        }
        let mut place = 0;
        let channels = mappings.iter().map(|mapping| {
            let from = place;
            place += size(*mapping);
            let samples = data.chunks_exact(stride);
            let is_signed = is_signed(*mapping, sheet);
            Channel {
                address: address(*mapping),
                title: title(*mapping, sheet),
                values: samples
                    .map(|sample| value(&sample[from..from + size(*mapping)], is_signed))
                    .collect(),
            }
        });
        let channels = channels.collect();
        let [low, high] = [header.u32_at(24)?, header.u32_at(28)?];
        Ok(Self {
            tick_ns: header.u32_at(4)?,
            divider: header.u16_at(8)?.max(1),
            before: header.u32_at(20)? as usize,
            late: header.u16_at(14)?,
            triggered_us: u64::from(high) << 32 | u64::from(low),
            channels,
        })
    }

    /// How many samples there are.
    pub fn count(&self) -> usize {
        self.channels
            .first()
            .map_or(0, |channel| channel.values.len())
    }

    /// When a sample was taken, in seconds from the trigger.
    pub fn time(&self, sample: usize) -> f64 {
        let samples = sample as i64 - self.before as i64;
        let ticks = samples * i64::from(self.divider) + i64::from(self.late);
        (ticks * i64::from(self.tick_ns)) as f64 / 1e9
    }

    /// From sample to sample, in seconds.
    pub fn period(&self) -> f64 {
        f64::from(self.tick_ns) * f64::from(self.divider) / 1e9
    }
}

struct Header<'a>(&'a [u8]);

impl Header<'_> {
    fn u16_at(&self, at: usize) -> Result<u16, String> {
        let bytes = self.0.get(at..).and_then(<[u8]>::first_chunk);
        bytes
            .map(|bytes| u16::from_le_bytes(*bytes))
            .ok_or_else(|| {
                format!(
                    "a recording has {HEADER} bytes at least, and not {}",
                    self.0.len()
                )
            })
    }

    fn u32_at(&self, at: usize) -> Result<u32, String> {
        let [low, high] = [self.u16_at(at)?, self.u16_at(at + 2)?];
        Ok(u32::from(high) << 16 | u32::from(low))
    }
}

/// The bytes of a value.
fn size(mapping: u32) -> usize {
    (mapping & 0xFF).div_ceil(8) as usize
}

fn address(mapping: u32) -> Address {
    Address::new((mapping >> 16) as u16, (mapping >> 8) as u8)
}

fn title(mapping: u32, sheet: &DataSheet) -> String {
    let address = address(mapping);
    match sheet.name(address) {
        Some(name) => format!("{address} {name}"),
        None => address.to_string(),
    }
}

/// Whether the data sheet has numbers of this length with a sign here.
fn is_signed(mapping: u32, sheet: &DataSheet) -> bool {
    let known = sheet.data_type(address(mapping));
    known.is_some_and(|known| {
        known.size().map(usize::from) == Some(size(mapping))
            && known.range().is_some_and(|(least, _)| least < 0)
    })
}

/// A value as the number it is; one that the data sheet does not have is read without a sign.
fn value(bytes: &[u8], is_signed: bool) -> i64 {
    let mut wide = match bytes.last() {
        Some(0x80..) if is_signed => [0xFF; 8],
        _ => [0; 8],
    };
    wide[..bytes.len()].copy_from_slice(bytes);
    i64::from_le_bytes(wide)
}
