//! The PDOs of a device with its dictionary and a recording application; node-ID 4. Writes go the way of an SDO server.

use std::vec::Vec;

use super::objects::Objects;
use crate::agenda::{Agenda, Kind, Word};
use crate::application::Application;
use crate::cia301::error_report::ErrorReport;
use crate::cia301::pdo::{
    Mapped, Receive, ReceivePdo, Received, Transmit, TransmitPdo, validate_list,
};
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, check, find, put, read_u8, set, value, write_u8, write_u32};
use crate::time::{Instant, NEVER};
use crate::wire::Frame;

/// Remembers what it was told, and refuses 7 in 2000h.
#[derive(Debug, Default)]
pub(super) struct Recorder {
    pub(super) written: Vec<u16>,
}

impl Application<Objects> for Recorder {
    fn validate(&mut self, _: &Objects, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        if entry.index == 0x2000 && value == [7] {
            Err(AbortCode::InvalidValue)
        } else {
            Ok(())
        }
    }

    fn written(&mut self, _: &mut Objects, entry: &Entry) {
        self.written.push(entry.index);
    }
}

/// The places for the objects of a mapping.
pub(super) type Places = [Mapped; 64];

#[derive(Debug)]
pub(super) struct Device {
    pub(super) objects: Objects,
    pub(super) receive: Receive<[ReceivePdo<Places>; 4], Places>,
    pub(super) transmit: Transmit<[TransmitPdo<Places>; 4], Places>,
    pub(super) agenda: Agenda<[Word; 1]>,
    pub(super) recorder: Recorder,
    pub(super) now: Instant,
}

/// A mapping entry.
pub(super) const fn mapped(index: u16, sub: u8, bits: u8) -> u32 {
    (index as u32) << 16 | (sub as u32) << 8 | bits as u32
}

impl Device {
    /// All PDOs not valid, with the identifiers of the predefined connection set.
    pub(super) fn new() -> Self {
        let mut objects = Objects::new();
        for (number, receive, transmit) in [
            (0, 0x204, 0x184),
            (1, 0x304, 0x284),
            (2, 0x404, 0x384),
            (3, 0x504, 0x484),
        ] {
            assert!(write_u32(
                &mut objects,
                0x1400 + number,
                1,
                0x8000_0000 | receive
            ));
            assert!(write_u32(
                &mut objects,
                0x1800 + number,
                1,
                0xC000_0000 | transmit
            ));
            assert!(write_u8(&mut objects, 0x1400 + number, 2, 255));
            assert!(write_u8(&mut objects, 0x1800 + number, 2, 255));
        }
        let mut device = Self {
            objects,
            receive: Receive::new(),
            transmit: Transmit::new(),
            agenda: Agenda::new(),
            recorder: Recorder::default(),
            now: Instant::from_ticks(1_000_000),
        };
        device.receive.configure_all(&device.objects, 4);
        let Self {
            objects,
            transmit,
            agenda,
            ..
        } = &mut device;
        transmit.configure_all(objects, 4, agenda);
        agenda.is_mute = false;
        device
    }

    pub(super) fn enter_operational(&mut self) {
        self.receive.enter_operational();
        self.transmit
            .enter_operational(&self.objects, self.now, &mut self.agenda);
    }

    pub(super) fn leave_operational(&mut self) {
        self.receive.leave_operational();
        self.transmit.leave_operational(&mut self.agenda);
    }

    /// A download.
    pub(super) fn write(&mut self, index: u16, sub: u8, bytes: &[u8]) -> Result<(), AbortCode> {
        let entry = find::<Objects>(index, sub)?;
        check(Objects::TABLE, entry, bytes)?;
        match index {
            0x1400..=0x17FF => self.receive.validate(&self.objects, entry, bytes)?,
            0x1800..=0x1BFF => self.transmit.validate(&self.objects, entry, bytes)?,
            0x1FA0..=0x1FFF => validate_list::<Objects>(entry, bytes)?,
            _ => {}
        }
        put(&mut self.objects, entry, bytes);
        match index {
            0x1400..=0x17FF => self.receive.written(&self.objects, entry),
            0x1800..=0x1BFF => {
                self.transmit
                    .written(&self.objects, entry, self.now, &mut self.agenda);
            }
            _ => {}
        }
        self.receive.watch(&self.transmit.watched());
        Ok(())
    }

    pub(super) fn write_u8(&mut self, index: u16, sub: u8, number: u8) -> Result<(), AbortCode> {
        self.write(index, sub, &[number])
    }

    pub(super) fn write_u16(&mut self, index: u16, sub: u8, number: u16) -> Result<(), AbortCode> {
        self.write(index, sub, &number.to_le_bytes())
    }

    pub(super) fn write_u32(&mut self, index: u16, sub: u8, number: u32) -> Result<(), AbortCode> {
        self.write(index, sub, &number.to_le_bytes())
    }

    /// The standard procedure: PDO `number` (from 0) gets this mapping and transmission type, and is valid afterwards.
    pub(super) fn map(
        &mut self,
        first: u16,
        number: u16,
        kind: u8,
        mapping: &[u32],
    ) -> Result<(), AbortCode> {
        let (communication, record) = (first + number, first + number + 0x200);
        let identifier = u32::from(if first == 0x1400 { 0x204 } else { 0x184 } + number * 0x100);
        self.write_u32(communication, 1, 0x8000_0000 | identifier)?;
        self.write_u8(communication, 2, kind)?;
        self.write_u8(record, 0, 0)?;
        for (sub, entry) in (1..).zip(mapping) {
            self.write_u32(record, sub, *entry)?;
        }
        self.write_u8(record, 0, u8::try_from(mapping.len()).unwrap())?;
        self.write_u32(communication, 1, identifier)
    }

    /// PDO `number` (from 0) becomes a multiplexed one: 254 or 255 in sub-index 0 of the mapping.
    pub(super) fn multiplex(
        &mut self,
        first: u16,
        number: u16,
        count: u8,
    ) -> Result<(), AbortCode> {
        let identifier = u32::from(if first == 0x1400 { 0x204 } else { 0x184 } + number * 0x100);
        self.write_u32(first + number, 1, 0x8000_0000 | identifier)?;
        self.write_u8(first + number + 0x200, 0, count)?;
        self.write_u32(first + number, 1, identifier)
    }

    /// A frame from the bus; what has become of it.
    pub(super) fn frame(&mut self, cob_id: u16, bytes: &[u8]) -> Received {
        let frame = Frame::data_frame(cob_id, bytes);
        self.receive.receive(
            cob_id,
            &frame,
            self.now,
            || false,
            &mut self.objects,
            &mut self.recorder,
        )
    }

    /// A remote frame from the bus.
    pub(super) fn request(&mut self, cob_id: u16) {
        self.transmit
            .on_request(cob_id, &self.objects, self.now, &mut self.agenda);
    }

    /// A frame from the bus; how many objects it wrote.
    pub(super) fn writes(&mut self, cob_id: u16, bytes: &[u8]) -> usize {
        let before = self.recorder.written.len();
        self.frame(cob_id, bytes);
        self.recorder.written.len() - before
    }

    pub(super) fn sync(&mut self) {
        self.counted_sync(None);
    }

    /// A SYNC with a counter.
    pub(super) fn counted_sync(&mut self, counter: Option<u8>) {
        self.transmit
            .on_sync(counter, &self.objects, &mut self.agenda);
        self.receive.on_sync(&mut self.objects, &mut self.recorder);
    }

    /// The present bytes of an object.
    pub(super) fn bytes(&self, index: u16, sub: u8) -> Vec<u8> {
        value(&self.objects, find::<Objects>(index, sub).unwrap()).to_vec()
    }

    pub(super) fn u8(&self, index: u16) -> u8 {
        read_u8(&self.objects, index, 0).unwrap()
    }

    /// The application puts a value into the dictionary.
    pub(super) fn put(&mut self, index: u16, bytes: &[u8]) {
        set(&mut self.objects, find::<Objects>(index, 0).unwrap(), bytes).unwrap();
    }

    /// Everything that waits to be sent, in the order of the bus: identifier and data.
    pub(super) fn sent(&mut self) -> Vec<(u16, Vec<u8>)> {
        let mut frames = Vec::new();
        let _ = self.agenda.set_values(NEVER);
        while let Some(first) = self.agenda.first() {
            let Kind::Pdo(number) = first.kind(4) else {
                panic!("only PDOs send");
            };
            let cob_id = self.agenda.cob_id(first);
            let frame = self.transmit.take(number, &mut self.agenda).unwrap();
            assert_eq!(frame.standard_id(), Some(cob_id));
            frames.push((cob_id, frame.payload().to_vec()));
        }
        if self.agenda.has_values(self.now) {
            self.poll();
        }
        frames
    }

    /// Lets the transmit PDOs look for changes and timers.
    pub(super) fn poll(&mut self) -> Instant {
        self.transmit
            .poll(&self.objects, self.now, &mut self.agenda)
    }

    /// `milliseconds` later: polls, and returns what is sent.
    pub(super) fn after(&mut self, milliseconds: u64) -> Vec<(u16, Vec<u8>)> {
        self.now = Instant::from_ticks(self.now.ticks() + milliseconds * 1000);
        self.poll();
        self.receive.poll(self.now);
        self.sent()
    }

    /// What the emergency producer hears: code, PDO number, and whether the error appeared or is gone.
    pub(super) fn reports(&mut self) -> Vec<(u16, u8, bool)> {
        core::iter::from_fn(|| self.receive.report())
            .map(|report| match report {
                ErrorReport::Appeared(emergency) => {
                    assert_eq!(emergency.register, 0x10);
                    (emergency.code, emergency.info[0], true)
                }
                ErrorReport::Gone(emergency) => (emergency.code, emergency.info[0], false),
            })
            .collect()
    }
}
