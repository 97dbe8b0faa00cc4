//! What comes before the first frame: sources of node-ID and bit rate, bit timing, the search for the bit rate; and the lights.

use canopen::bit_timing::{Limits, Timing};
use canopen::cia303::Indicators;
use canopen::cia305::Detection;
use canopen::settings::{Field, PowerOn, Sources, Switches, Wish};
use canopen::{BitRate, BitTiming, Configuration, Node, NodeId};
use cia402::{DriveLight, DriveSignal};

use super::{any, any_bit_rate, any_time, look, Everything};

/// A search and the lights, as they go on.
pub struct Commissioning {
    detection: Detection,
    network: Indicators,
    drive: DriveLight,
}

impl Commissioning {
    pub fn new() -> Self {
        Self {
            detection: Detection::new(&[any_bit_rate()], any_time()),
            network: Indicators::new(),
            drive: DriveLight::new(),
        }
    }

    #[inline(never)]
    pub fn advance(&mut self, node: &Node<Everything>) {
        let lit = self.network.advance(node.signal()).bicolour();
        look(u32::from(lit.run) + u32::from(lit.error));
        let signal = DriveSignal::new(any() as u16, any() as u16);
        look(self.drive.advance(signal).into());
        match any() {
            0 => self.detection.error_seen(),
            1 => self.detection.frame_received(),
            2 => self.detection = Detection::new(&[any_bit_rate()], any_time()),
            3 if self.detection.is_over() => self.detection.left(any_time()),
            _ => look(self.detection.poll(any_time()).ticks() as u32),
        }
        look(self.detection.bit_rate() as u32 + u32::from(self.detection.found().is_some()));
        let limits = Limits {
            prescaler: any(),
            segment_1: any(),
            segment_2: any(),
            jump: any(),
        };
        if let Some(timing) = Timing::new(any(), any_bit_rate(), &limits) {
            look(timing.bxcan_register() ^ timing.quanta() ^ timing.sample_point());
        }
    }
}

pub fn any_bit_timing() -> BitTiming {
    BitTiming::from_table_index(any() as u8).unwrap_or(BitTiming::Automatic)
}

fn any_configuration() -> Configuration {
    Configuration {
        node_id: NodeId::new(any() as u8).unwrap_or(NodeId::UNCONFIGURED),
        bit_timing: any_bit_timing(),
    }
}

/// What any sources make of a power-on.
#[inline(never)]
pub fn any_power_on() -> PowerOn {
    const RATES: &[Field] = &[Field::Stored, Field::Set(BitTiming::Automatic)];
    let digits = any().to_le_bytes();
    let text = core::str::from_utf8(&digits).ok();
    let sources = Sources {
        build: Wish::of_build(text, text).unwrap_or(Wish::NOTHING),
        switches: Switches::new(any(), RATES).wish(any() as u16),
        stored: (any() == 0).then(any_configuration),
        factory: any_configuration(),
    };
    let supported: [BitRate; 2] = [any_bit_rate(), any_bit_rate()];
    sources.choose(supported.get(..any() as usize).unwrap_or(&supported))
}
