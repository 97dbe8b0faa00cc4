//! A device with its drive and motor, and a master that sends frames.

use std::format;
use std::string::String;
use std::vec::Vec;

use canopen::{BitRate, ControllerState, Duration, Event, Frame, Instant, NodeId, Settings};
use motion::{AxisConfig, Clock, DriverTiming, PulseSink};

use super::dictionary::DriveDictionary;
use crate::state_machine::State;
use crate::testing::Player;
use crate::{Device, Drive, DriveConfig, Exchange, Inputs};

const TICK: Duration = Duration::from_ticks(1_000);

pub(super) struct Station {
    pub(super) device: Device<DriveDictionary>,
    drive: Drive,
    pub(super) exchange: Exchange,
    pub(super) motor: Player,
    pub(super) fault: Option<u16>,
    pub(super) power: bool,
    pub(super) now: Instant,
    target: i32,
    sent: Vec<String>,
}

impl Station {
    /// A device that has just been powered on.
    pub(super) fn new() -> Self {
        let axis = AxisConfig {
            clock: Clock::new(1_000_000).unwrap(),
            time_slice: 750,
            timing: DriverTiming {
                pulse_high: 2,
                pulse_low: 2,
                direction_setup: 5,
                direction_hold: 5,
            },
        };
        let settings = Settings {
            node_id: NodeId::new(4).unwrap(),
            bit_rate: BitRate::Kbit1000,
        };
        let mut station = Self {
            device: Device::new(DriveDictionary::new(), settings, 0x0402_1234),
            drive: Drive::new(DriveConfig {
                axis,
                tick: TICK,
                refills: 1,
            }),
            exchange: Exchange::new(),
            motor: Player::with_capacity(256),
            fault: None,
            power: false,
            now: Instant::from_ticks(0),
            target: 0,
            sent: Vec::new(),
        };
        station.device.power_on(station.now, &mut station.exchange);
        station.fetch();
        station
    }

    /// In NMT state Operational, with nothing left to be read.
    pub(super) fn operational() -> Self {
        let mut station = Self::new();
        station.milliseconds(3);
        station.send(0x000, &[0x01, 0x04]);
        station.milliseconds(3);
        station.take();
        station
    }

    /// In operation enabled, commanded by PDO.
    pub(super) fn enabled() -> Self {
        let mut station = Self::operational();
        for controlword in [0x06, 0x07, 0x0F] {
            station.send(0x204, &[controlword, 0x00, 0x01]);
            station.milliseconds(2);
        }
        assert_eq!(station.state(), State::OperationEnabled);
        station.milliseconds(20);
        station.take();
        station
    }

    /// Lets the control tick run once; the device is not called.
    pub(super) fn control_tick(&mut self) {
        self.now += TICK;
        self.motor.play(TICK.ticks());
        let inputs = Inputs {
            supply: true,
            position: self.motor.position,
            warning: None,
            fault: self.fault,
            ..Inputs::default()
        };
        let outputs = self
            .drive
            .tick(self.now, &inputs, &mut self.motor, &mut self.exchange);
        self.power = outputs.power_stage;
        if outputs.drop_pulses {
            self.motor.clear();
        }
    }

    pub(super) fn milliseconds(&mut self, count: usize) {
        for _ in 0..count {
            self.control_tick();
            self.device.poll(self.now, &mut self.exchange);
            self.fetch();
        }
    }

    /// A frame arrives now.
    pub(super) fn send(&mut self, cob_id: u16, data: &[u8]) {
        self.deliver(cob_id, data, self.now);
    }

    /// A frame that arrived at `stamp` is handed over now.
    pub(super) fn deliver(&mut self, cob_id: u16, data: &[u8], stamp: Instant) {
        self.device
            .receive(&Frame::data_frame(cob_id, data), stamp, &mut self.exchange);
        self.fetch();
    }

    /// The CAN controller changes its state.
    pub(super) fn controller(&mut self, state: ControllerState) {
        self.device
            .controller_changed(state, self.now, &mut self.exchange);
    }

    fn fetch(&mut self) {
        while let Some(frame) = self.device.transmit() {
            let mut text = format!("{:03X}", frame.standard_id().unwrap());
            for byte in frame.payload() {
                text += &format!(" {byte:02X}");
            }
            self.sent.push(text);
        }
    }

    /// What the firmware is told.
    pub(super) fn events(&mut self) -> Vec<Event> {
        core::iter::from_fn(|| self.device.event()).collect()
    }

    /// What was sent since the last call.
    pub(super) fn take(&mut self) -> Vec<String> {
        core::mem::take(&mut self.sent)
    }

    fn request(&mut self, data: [u8; 8]) -> [u8; 8] {
        let before = core::mem::take(&mut self.sent);
        self.send(0x604, &data);
        let answers = core::mem::replace(&mut self.sent, before);
        let [answer] = answers.as_slice() else {
            panic!("one answer to {data:02X?}, but {answers:?}");
        };
        let answer = answer.strip_prefix("584 ").unwrap();
        let bytes: Vec<u8> = answer
            .split(' ')
            .map(|byte| u8::from_str_radix(byte, 16).unwrap())
            .collect();
        bytes.try_into().unwrap()
    }

    /// Reads a number by expedited SDO.
    pub(super) fn upload(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let [command, _, _, _, value @ ..] = self.request([0x40, low, high, sub, 0, 0, 0, 0]);
        assert_eq!(command & 0xF3, 0x43, "{index:04X}h is refused");
        u32::from_le_bytes(value)
    }

    /// Writes a number by expedited SDO; an error is the abort code.
    pub(super) fn download(
        &mut self,
        index: u16,
        sub: u8,
        size: u8,
        value: u32,
    ) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        let [v0, v1, v2, v3] = value.to_le_bytes();
        let answer = self.request([0x23 | (4 - size) << 2, low, high, sub, v0, v1, v2, v3]);
        let [command, _, _, _, code @ ..] = answer;
        match command {
            0x60 => Ok(()),
            0x80 => Err(u32::from_le_bytes(code)),
            _ => panic!("{answer:02X?}"),
        }
    }

    /// A set-point by PDO: bit 4 low with the old target, then its edge with the new one.
    pub(super) fn go_to(&mut self, target: i32) {
        for (controlword, target) in [(0x0F, self.target), (0x1F, target)] {
            let [t0, t1, t2, t3] = target.to_le_bytes();
            self.send(0x304, &[controlword, 0x00, t0, t1, t2, t3]);
        }
        self.target = target;
    }

    /// Runs until the motor stands, and returns where.
    pub(super) fn rest(&mut self) -> i64 {
        self.milliseconds(2);
        for _ in 0..20_000 {
            if self.motor.pending() == 0 {
                self.milliseconds(15);
                return self.motor.position;
            }
            self.milliseconds(1);
        }
        panic!("the motor never stands");
    }

    pub(super) fn state(&self) -> State {
        State::from_statusword(self.exchange.actuals_at(self.now).statusword).unwrap()
    }
}
