//! Every data type through getters, setters and SDO; hooks; streams.
#![deny(warnings)]
#![forbid(unsafe_code)]

mod dictionary {
    include!("dictionaries/types.rs");
}

use canopen::Application as _;
use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::{DayTime, OutOfRange};
use canopen::{BitRate, Frame, Instant, Node, NodeId, Settings, Sink, Source};
use dictionary::{Dictionary, Hooked, Hooks, NAMES, Streams};

/// A value of any length.
#[derive(Default)]
struct Memory(Vec<u8>);

impl Source<Dictionary> for Memory {
    fn size(&mut self, _: &Dictionary) -> Result<Option<u32>, AbortCode> {
        Ok(Some(self.0.len() as u32))
    }

    fn read_at(&mut self, _: &Dictionary, position: u32, into: &mut [u8]) -> Result<usize, AbortCode> {
        let rest = &self.0[position as usize..];
        let length = rest.len().min(into.len());
        into[..length].copy_from_slice(&rest[..length]);
        Ok(length)
    }
}

impl Sink<Dictionary> for Memory {
    fn begin(&mut self, _: &Dictionary, size: Option<u32>) -> Result<(), AbortCode> {
        self.0.clear();
        match size {
            Some(size) if size > 1000 => Err(AbortCode::OutOfMemory),
            _ => Ok(()),
        }
    }

    fn write_at(&mut self, _: &Dictionary, position: u32, data: &[u8]) -> Result<(), AbortCode> {
        assert_eq!(position as usize, self.0.len());
        self.0.extend(data);
        Ok(())
    }

    fn end(&mut self, _: &mut Dictionary, length: u32) -> Result<Completion, AbortCode> {
        assert_eq!(length as usize, self.0.len());
        Ok(Completion::Now)
    }
}

#[derive(Default)]
struct Application {
    firmware_image: Memory,
    trace: Memory,
    scratch: Memory,
    program_text: Memory,
    applied: Vec<i32>,
}

impl Hooks for Application {
    fn check_integer24(&mut self, dictionary: &Dictionary, value: i32) -> Result<(), AbortCode> {
        // Only ever more.
        if value < dictionary.integer24() {
            return Err(AbortCode::InvalidValue);
        }
        Ok(())
    }

    fn apply_integer24(&mut self, dictionary: &mut Dictionary) {
        self.applied.push(dictionary.integer24());
    }
}

impl Streams for Application {
    type FirmwareImage = Memory;
    fn firmware_image(&mut self) -> &mut Memory {
        &mut self.firmware_image
    }

    type Trace = Memory;
    fn trace(&mut self) -> &mut Memory {
        &mut self.trace
    }

    type Scratch = Memory;
    fn scratch(&mut self) -> &mut Memory {
        &mut self.scratch
    }

    type ProgramText = Memory;
    fn program_text(&mut self) -> &mut Memory {
        &mut self.program_text
    }
}

fn values() {
    let mut dictionary = Dictionary::new();
    assert!(dictionary.boolean());
    assert_eq!(dictionary.integer24(), -2);
    assert_eq!(dictionary.integer40(), -3);
    assert_eq!(dictionary.integer56(), -5);
    assert_eq!(dictionary.unsigned24(), 0xAB_CDEF);
    assert_eq!(dictionary.unsigned40(), 0x01_2345_6789);
    assert_eq!(dictionary.real32(), 1.5);
    assert_eq!(dictionary.real64(), -0.25);
    assert_eq!(dictionary.text(), b"abc");
    assert_eq!(dictionary.octets(), [1, 2]);
    assert_eq!(dictionary.constant_24(), -2);
    assert_eq!(dictionary.constant_real(), 0.5);
    assert_eq!(dictionary.constant_wide(), 0x01_0203_0405_0607);
    assert_eq!(dictionary.constant_text(), "say \"hi\"");

    assert_eq!(dictionary.set_integer24(-0x80_0000), Ok(()));
    assert_eq!(dictionary.integer24(), -0x80_0000);
    assert_eq!(dictionary.set_integer24(0x80_0000), Err(OutOfRange));
    assert_eq!(dictionary.integer24(), -0x80_0000);
    assert_eq!(dictionary.set_unsigned56(1 << 56), Err(OutOfRange));
    assert_eq!(dictionary.set_unsigned56((1 << 56) - 1), Ok(()));
    assert_eq!(dictionary.unsigned56(), (1 << 56) - 1);
    assert_eq!(dictionary.unsigned64(), 3, "the neighbour");
    dictionary.set_boolean(false);
    assert!(!dictionary.boolean());
    let noon = DayTime { days: 3, milliseconds: 43_200_000 };
    dictionary.set_time_of_day(noon);
    assert_eq!(dictionary.time_of_day(), noon);
    assert_eq!(dictionary.set_text(b"hello"), Ok(()));
    assert_eq!(dictionary.text(), b"hello");
    assert_eq!(dictionary.set_text(&[b'x'; 33]), Err(AbortCode::LengthTooHigh));
    assert_eq!(dictionary.text(), b"hello");

    let table = <Dictionary as canopen::od::Dictionary>::TABLE;
    assert_eq!(table.entries.len(), NAMES.len());
    let position = table.position(0x2001, 0).unwrap();
    assert_eq!(NAMES[position], "Integer24");
    assert_eq!(size_of_val(&table.entries[0]), 12);
}

struct Station {
    node: Node<Dictionary>,
    application: Hooked<Application>,
    now: Instant,
}

impl Station {
    fn request(&mut self, data: &[u8; 8]) -> Vec<u8> {
        self.now += canopen::Duration::from_ticks(1000);
        let frame = Frame::data_frame(0x604, data);
        self.node.receive(&frame, self.now, &mut self.application);
        self.node.poll(self.now, &mut self.application);
        let answers = std::iter::from_fn(|| self.node.transmit(&mut self.application));
        let found = answers.filter(|frame| frame.standard_id() == Some(0x584)).last();
        found.map(|frame| frame.payload().to_vec()).unwrap_or_default()
    }
}

fn over_the_bus() {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        bit_rate: BitRate::Kbit1000,
    };
    let mut station = Station {
        node: Node::new(Dictionary::new(), settings),
        application: Hooked(Application::default()),
        now: Instant::from_ticks(0),
    };
    station.node.boot(Reset::Node, station.now, &mut station.application);
    // 24 bits: -2 is there; 5 is more, 4 then is not.
    assert_eq!(station.request(&[0x40, 0x01, 0x20, 0, 0, 0, 0, 0]), [0x47, 0x01, 0x20, 0, 0xFE, 0xFF, 0xFF, 0]);
    assert_eq!(station.request(&[0x27, 0x01, 0x20, 0, 5, 0, 0, 0]), [0x60, 0x01, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(station.request(&[0x27, 0x01, 0x20, 0, 4, 0, 0, 0]), [0x80, 0x01, 0x20, 0, 0x30, 0, 0x09, 0x06]);
    // Beyond HighLimit 1000.
    assert_eq!(station.request(&[0x27, 0x01, 0x20, 0, 0xE9, 3, 0, 0]), [0x80, 0x01, 0x20, 0, 0x31, 0, 0x09, 0x06]);
    assert_eq!(station.application.0.applied, [5]);
    // REAL32: 2.5 is the most.
    assert_eq!(station.request(&[0x23, 0x0B, 0x20, 0, 0, 0, 0x20, 0x40])[0], 0x60);
    assert_eq!(station.request(&[0x23, 0x0B, 0x20, 0, 1, 0, 0x20, 0x40])[4..], [0x31, 0, 0x09, 0x06]);
    assert_eq!(station.node.dictionary().real32(), 2.5);
    // A DOMAIN, both ways.
    assert_eq!(station.request(&[0x27, 0x18, 0x20, 0, 7, 8, 9, 0])[0], 0x60);
    assert_eq!(station.application.0.scratch.0, [7, 8, 9]);
    assert_eq!(station.request(&[0x40, 0x18, 0x20, 0, 0, 0, 0, 0])[4..], [7, 8, 9, 0]);
    // Its access is that of the data sheet.
    assert_eq!(station.request(&[0x40, 0x16, 0x20, 0, 0, 0, 0, 0])[4..], [1, 0, 1, 6]);
    assert_eq!(station.request(&[0x2F, 0x17, 0x20, 0, 1, 0, 0, 0])[4..], [2, 0, 1, 6]);
}

/// What the SDO server does with a streamed object, in its place.
fn streams() {
    let dictionary = &mut Dictionary::new();
    let mut application = Hooked(Application::default());
    let node = &mut application;
    let entry = |index| canopen::od::find::<Dictionary>(index, 0).unwrap();
    let scratch = entry(0x2018);
    assert_eq!(node.begin_write(dictionary, scratch, Some(1001)), Err(AbortCode::OutOfMemory));
    assert_eq!(node.begin_write(dictionary, scratch, Some(3)), Ok(()));
    assert_eq!(node.write_at(dictionary, scratch, 0, &[7, 8]), Ok(()));
    assert_eq!(node.write_at(dictionary, scratch, 2, &[9]), Ok(()));
    assert_eq!(node.end_write(dictionary, scratch, 3), Ok(Completion::Now));
    assert_eq!(node.size(dictionary, scratch), Ok(Some(3)));
    let mut bytes = [0; 7];
    assert_eq!(node.read_at(dictionary, scratch, 1, &mut bytes), Ok(2));
    assert_eq!(bytes, [8, 9, 0, 0, 0, 0, 0]);
    // Each object has its own value, and its own access.
    assert_eq!(node.size(dictionary, entry(0x2017)), Ok(Some(0)));
    assert_eq!(node.size(dictionary, entry(0x2016)), Err(AbortCode::UnsupportedAccess));
    let trace = node.begin_write(dictionary, entry(0x2017), None);
    assert_eq!(trace, Err(AbortCode::UnsupportedAccess));
    assert_eq!(node.begin_write(dictionary, entry(0x2016), None), Ok(()));
    node.abandon_write(dictionary, entry(0x2016));
}

fn main() {
    values();
    over_the_bus();
    streams();
}
