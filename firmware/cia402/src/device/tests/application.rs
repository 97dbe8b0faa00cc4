//! What the firmware's own application has to say beside the drive.

use std::vec;
use std::vec::Vec;

use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::Entry;
use canopen::{Application, BitRate, Domain, Frame, Instant, NodeId, Settings, Sink, Source};

use super::dictionary::DriveDictionary;
use crate::{Device, Exchange};

/// It remembers what it was asked and told, refuses a profile velocity of 13, and has a DOMAIN.
struct Machine {
    asked: Vec<u16>,
    told: Vec<u16>,
    starts: usize,
    memory: Domain<Vec<u8>>,
}

impl Application<DriveDictionary> for Machine {
    fn validate(
        &mut self,
        _: &DriveDictionary,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        self.asked.push(entry.index);
        if entry.index == 0x6081 && value == [13, 0, 0, 0] {
            return Err(AbortCode::ParameterIncompatible);
        }
        Ok(())
    }

    fn written(&mut self, _: &mut DriveDictionary, entry: &Entry) {
        self.told.push(entry.index);
    }

    fn size(&mut self, dictionary: &DriveDictionary, _: &Entry) -> Result<Option<u32>, AbortCode> {
        self.memory.size(dictionary)
    }

    fn read_at(
        &mut self,
        dictionary: &DriveDictionary,
        _: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        self.memory.read_at(dictionary, position, into)
    }

    fn begin_write(
        &mut self,
        dictionary: &DriveDictionary,
        _: &Entry,
        size: Option<u32>,
    ) -> Result<(), AbortCode> {
        self.memory.begin(dictionary, size)
    }

    fn write_at(
        &mut self,
        dictionary: &DriveDictionary,
        _: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        self.memory.write_at(dictionary, position, data)
    }

    fn end_write(
        &mut self,
        dictionary: &mut DriveDictionary,
        entry: &Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        self.told.push(entry.index);
        self.memory.end(dictionary, length)
    }

    fn abandon_write(&mut self, _: &DriveDictionary, entry: &Entry) {
        self.told.push(entry.index);
    }

    fn power_on(&mut self, _: &mut DriveDictionary) {
        self.starts += 1;
    }
}

struct Bench {
    device: Device<DriveDictionary, Machine>,
    exchange: Exchange,
}

impl Bench {
    fn new() -> Self {
        let settings = Settings {
            node_id: NodeId::new(4).unwrap(),
            bit_rate: BitRate::Kbit1000,
        };
        let machine = Machine {
            asked: Vec::new(),
            told: Vec::new(),
            starts: 0,
            memory: Domain::new(vec![0; 20], vec![0; 20]),
        };
        let mut bench = Self {
            device: Device::with_application(DriveDictionary::new(), settings, 1, machine),
            exchange: Exchange::new(),
        };
        bench
            .device
            .power_on(Instant::from_ticks(0), &mut bench.exchange);
        while bench.device.transmit().is_some() {}
        bench
    }

    fn ask(&mut self, request: [u8; 8]) -> [u8; 8] {
        let now = Instant::from_ticks(1);
        let frame = Frame::data_frame(0x604, &request);
        self.device.receive(&frame, now, &mut self.exchange);
        let answer = self.device.transmit().unwrap();
        answer.payload().try_into().unwrap()
    }

    fn abort_code(&mut self, request: [u8; 8]) -> u32 {
        let [0x80, _, _, _, code @ ..] = self.ask(request) else {
            panic!("{request:02X?} is allowed");
        };
        u32::from_le_bytes(code)
    }
}

#[test]
fn the_application_hears_of_what_the_drive_allows() {
    let mut bench = Bench::new();
    assert_eq!(bench.device.application().starts, 1);
    // No acceleration is for the drive to refuse: the application is not even asked.
    let code = bench.abort_code([0x23, 0x83, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(code, 0x0609_0032);
    assert_eq!(bench.device.application().asked, []);
    // A velocity that it does not like stays what it was.
    let code = bench.abort_code([0x23, 0x81, 0x60, 0, 13, 0, 0, 0]);
    assert_eq!(code, 0x0604_0043);
    assert_eq!(bench.device.application().told, []);
    assert_eq!(
        bench.ask([0x40, 0x81, 0x60, 0, 0, 0, 0, 0])[4..],
        10_000_u32.to_le_bytes()
    );
    // Any other is written, and both learn of it.
    assert_eq!(bench.ask([0x23, 0x81, 0x60, 0, 14, 0, 0, 0])[0], 0x60);
    assert_eq!(bench.device.application().told, [0x6081]);
    let mut commands = crate::Commands::NONE;
    let mut configuration = crate::Configuration::NONE;
    bench.exchange.take(&mut commands);
    bench.exchange.take_configuration(&mut configuration);
    assert_eq!(commands.profile_velocity, 14.into());
}

#[test]
fn the_application_serves_streamed_objects() {
    let mut bench = Bench::new();
    assert_eq!(bench.ask([0x21, 0x20, 0x20, 0, 10, 0, 0, 0])[0], 0x60);
    assert_eq!(bench.ask([0x00, 1, 2, 3, 4, 5, 6, 7])[0], 0x20);
    assert_eq!(bench.ask([0x19, 8, 9, 10, 0, 0, 0, 0])[0], 0x30);
    let value = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10];
    assert_eq!(bench.device.application().memory.value(), value);
    assert_eq!(bench.device.application().told, [0x2020]);
    assert_eq!(
        bench.ask([0x40, 0x20, 0x20, 0, 0, 0, 0, 0]),
        [0x41, 0x20, 0x20, 0, 10, 0, 0, 0]
    );
    assert_eq!(
        bench.ask([0x60, 0, 0, 0, 0, 0, 0, 0]),
        [0x00, 1, 2, 3, 4, 5, 6, 7]
    );
    // It learns of a write that ends early, and has the word on the size.
    assert_eq!(bench.ask([0x21, 0x20, 0x20, 0, 20, 0, 0, 0])[0], 0x60);
    bench.abort_code([0xE0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bench.device.application_mut().told, [0x2020, 0x2020]);
    assert_eq!(
        bench.abort_code([0x21, 0x20, 0x20, 0, 21, 0, 0, 0]),
        0x0607_0012
    );
}
