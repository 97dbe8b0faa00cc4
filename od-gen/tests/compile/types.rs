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
use dictionary::{DESCRIPTIONS, Dictionary, Hooked, Hooks, NAMES, Streams, Values};

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
    zero: i32,
    is_set: bool,
    /// By the sub-index.
    samples: std::collections::BTreeMap<u8, i16>,
}

impl Values for Application {
    fn odometer(&mut self, _: &Dictionary) -> Result<u64, AbortCode> {
        Ok(0x0102_0304_0506_0708)
    }

    fn scale_zero(&mut self, _: &Dictionary) -> Result<i32, AbortCode> {
        Ok(self.zero)
    }

    fn set_scale_zero(&mut self, _: &Dictionary, value: i32) -> Result<(), AbortCode> {
        self.zero = value;
        Ok(())
    }

    fn set_scale_is_set(&mut self, _: &Dictionary, value: bool) -> Result<(), AbortCode> {
        self.is_set = value;
        Ok(())
    }

    fn scale_unit(&mut self, _: &Dictionary) -> Result<u8, AbortCode> {
        Err(AbortCode::DeviceState)
    }

    fn set_scale_unit(&mut self, _: &Dictionary, _: u8) -> Result<(), AbortCode> {
        Err(AbortCode::DeviceState)
    }

    fn samples(&mut self, _: &Dictionary, sub: u8) -> Result<i16, AbortCode> {
        self.samples.get(&sub).copied().ok_or(AbortCode::NoData)
    }

    fn set_samples(&mut self, _: &Dictionary, sub: u8, value: i16) -> Result<(), AbortCode> {
        self.samples.insert(sub, value);
        Ok(())
    }
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
    let place = |index| usize::from(table.position(table.find(index, 0).unwrap()).unwrap());
    let position = place(0x2001);
    assert_eq!(NAMES[position], "Integer24");
    assert_eq!(table.entries.len(), DESCRIPTIONS.len());
    assert_eq!(DESCRIPTIONS[position], "rw INTEGER24, -1000 to 1000, -2 at power-on");
    let position = place(0x2019);
    assert_eq!(DESCRIPTIONS[position], "What runs after power-on. (rw VISIBLE_STRING, up to 4000 bytes)");
    assert_eq!(size_of_val(&table.entries[0]), 10);
}

struct Station {
    node: Node<Dictionary>,
    application: Hooked<Application>,
    now: Instant,
}

impl Station {
    fn booted() -> Self {
        let settings = Settings {
            node_id: NodeId::new(4).unwrap(),
            bit_rate: BitRate::Kbit1000,
        };
        let mut station = Self {
            node: Node::new(Dictionary::new(), settings),
            application: Hooked(Application::default()),
            now: Instant::from_ticks(0),
        };
        station.node.boot(Reset::Node, station.now, &mut station.application);
        station
    }

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
    let mut station = Station::booted();
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
    // Eight bytes and six, lowest first, in a segment or two: INTEGER64, REAL64, TIME_OF_DAY.
    let real = (-1.5_f64).to_le_bytes();
    for (index, value) in [(5, &(-0x0102_0304_0506_0708_i64).to_le_bytes()[..]), (0x0C, &real), (0x10, &[4, 3, 2, 1, 6, 5])] {
        let length = value.len() as u8;
        assert_eq!(station.request(&[0x21, index, 0x20, 0, length, 0, 0, 0])[0], 0x60);
        let (first, rest) = value.split_at(value.len().min(7));
        let mut request = [(7 - first.len() as u8) << 1 | u8::from(rest.is_empty()), 0, 0, 0, 0, 0, 0, 0];
        request[1..=first.len()].copy_from_slice(first);
        assert_eq!(station.request(&request)[0], 0x20);
        if let [last] = rest {
            assert_eq!(station.request(&[0x1D, *last, 0, 0, 0, 0, 0, 0])[0], 0x30);
        }
        assert_eq!(station.request(&[0x40, index, 0x20, 0, 0, 0, 0, 0]), [0x41, index, 0x20, 0, length, 0, 0, 0]);
        let mut read = station.request(&[0x60, 0, 0, 0, 0, 0, 0, 0])[1..].to_vec();
        read.extend(rest.first().map(|_| station.request(&[0x70, 0, 0, 0, 0, 0, 0, 0])[1]));
        assert_eq!(read[..value.len()], *value, "20{index:02X}h");
    }
    let dictionary = station.node.dictionary();
    assert_eq!(dictionary.integer64(), -0x0102_0304_0506_0708);
    assert_eq!(dictionary.real64(), -1.5);
    assert_eq!(dictionary.time_of_day(), DayTime { days: 0x0506, milliseconds: 0x0102_0304 });
    // A DOMAIN, both ways.
    assert_eq!(station.request(&[0x27, 0x18, 0x20, 0, 7, 8, 9, 0])[0], 0x60);
    assert_eq!(station.application.0.scratch.0, [7, 8, 9]);
    assert_eq!(station.request(&[0x40, 0x18, 0x20, 0, 0, 0, 0, 0])[4..], [7, 8, 9, 0]);
    // Its access is that of the data sheet.
    assert_eq!(station.request(&[0x40, 0x16, 0x20, 0, 0, 0, 0, 0])[4..], [1, 0, 1, 6]);
    assert_eq!(station.request(&[0x2F, 0x17, 0x20, 0, 1, 0, 0, 0])[4..], [2, 0, 1, 6]);
}

/// Numbers that are not in memory.
fn with_the_application() {
    let mut station = Station::booted();
    // 64 bits travel in two segments.
    assert_eq!(station.request(&[0x40, 0x1A, 0x20, 0, 0, 0, 0, 0]), [0x41, 0x1A, 0x20, 0, 8, 0, 0, 0]);
    assert_eq!(station.request(&[0x60, 0, 0, 0, 0, 0, 0, 0]), [0, 8, 7, 6, 5, 4, 3, 2]);
    assert_eq!(station.request(&[0x70, 0, 0, 0, 0, 0, 0, 0])[..2], [0x1D, 1]);
    assert_eq!(station.request(&[0x2F, 0x1A, 0x20, 0, 1, 0, 0, 0])[4..], [2, 0, 1, 6]);
    // Elements, within their limits.
    assert_eq!(station.request(&[0x2B, 0x00, 0x21, 200, 0xFE, 0xFF, 0, 0])[0], 0x60);
    assert_eq!(station.request(&[0x40, 0x00, 0x21, 200, 0, 0, 0, 0])[..6], [0x4B, 0x00, 0x21, 200, 0xFE, 0xFF]);
    assert_eq!(station.request(&[0x2B, 0x00, 0x21, 7, 0xE8, 3, 0, 0])[4..], [0x31, 0, 9, 6]);
    assert_eq!(station.request(&[0x2F, 0x00, 0x21, 7, 1, 0, 0, 0])[4..], [0x13, 0, 7, 6]);
    assert_eq!(station.request(&[0x40, 0x00, 0x21, 7, 0, 0, 0, 0])[4..], [0x24, 0, 0, 8]);
    assert_eq!(station.request(&[0x40, 0x00, 0x21, 201, 0, 0, 0, 0])[4..], [0x11, 0, 9, 6]);
    assert_eq!(station.request(&[0x40, 0x00, 0x21, 0, 0, 0, 0, 0])[..5], [0x4F, 0x00, 0x21, 0, 200]);
    assert_eq!(station.application.0.samples.len(), 1);
    // By segments it is the same.
    assert_eq!(station.request(&[0x21, 0x00, 0x21, 1, 2, 0, 0, 0])[0], 0x60);
    assert_eq!(station.request(&[0x0B, 5, 0, 0, 0, 0, 0, 0])[0], 0x20);
    assert_eq!(station.application.0.samples.get(&1), Some(&5));
    // Three bytes, with their sign.
    assert_eq!(station.request(&[0x27, 0x1B, 0x20, 1, 0xFE, 0xFF, 0xFF, 0])[0], 0x60);
    assert_eq!(station.application.0.zero, -2);
    assert_eq!(station.request(&[0x40, 0x1B, 0x20, 1, 0, 0, 0, 0])[..7], [0x47, 0x1B, 0x20, 1, 0xFE, 0xFF, 0xFF]);
    assert_eq!(station.request(&[0x27, 0x1B, 0x20, 1, 0, 0, 0x80, 0])[4..], [0x32, 0, 9, 6]);
    station.application.0.zero = 0x80_0000;
    assert_eq!(station.request(&[0x40, 0x1B, 0x20, 1, 0, 0, 0, 0])[4..], [0, 0, 0, 8], "more than 24 bits");
    assert_eq!(station.request(&[0x2F, 0x1B, 0x20, 2, 1, 0, 0, 0])[0], 0x60);
    assert!(station.application.0.is_set);
    assert_eq!(station.request(&[0x2F, 0x1B, 0x20, 2, 2, 0, 0, 0])[4..], [0x31, 0, 9, 6]);
    assert_eq!(station.request(&[0x2F, 0x1B, 0x20, 3, 2, 0, 0, 0])[4..], [0x22, 0, 0, 8]);
    // None of it takes RAM, and 1010h has nothing to store.
    let table = <Dictionary as canopen::od::Dictionary>::TABLE;
    let entries = table.range(0x201A..=0x2100);
    let in_ram = entries.iter().filter(|entry| matches!(entry.location(), canopen::od::Location::Ram(_)));
    assert_eq!(in_ram.count(), 0);
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
    with_the_application();
    streams();
}
