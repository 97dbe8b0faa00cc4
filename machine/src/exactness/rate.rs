//! Pulses and CANopen together: a drive that goes at full speed on a bus that is full.
//!
//! Each millisecond brings SYNC, a synchronous TPDO with the position, an RPDO with the order, and SDO transfers, one after the other;
//! frames for other devices fill what is left of 1 Mbit/s. The refills come late by up to 50 µs ([`Board`]).

use canopen::time::NEVER;
use canopen::{BitRate, Duration, Frame, Instant};

use super::{PROFILE_POSITION, PROFILE_VELOCITY, enabled};
use crate::timer_model::board::Board;
use master::bus::Station;
use master::bus::simulated::{Bus, Handle};
use master::{Failure, MappedObject, Master, PdoSetup};

/// What a second of full speed has brought, and what was at the end of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Pulses in a second, the mean of all.
    pub rate: u64,
    /// By how much the pins were off at rest from what the drive tells (6064h), and behind a move that followed from its target.
    pub error: u64,
    /// SDO transfers that were served meanwhile, each with the right answer.
    pub transfers: u64,
    /// SYNCs that were answered by their TPDO.
    pub samples: u64,
    /// Frames on the bus.
    pub frames: u64,
}

/// The second RPDO and TPDO.
const ORDER: u16 = 0x300 + Board::NODE as u16;
const SAMPLE: u16 = 0x280 + Board::NODE as u16;

/// How far the refills are behind the control ticks.
const PHASE: Duration = Duration::from_ticks(60);

/// Emergency messages.
const EMERGENCY: u16 = 0x80 + Board::NODE as u16;

/// Goes at `velocity` (steps/s) for so many seconds, stops, and makes a move of a second on the same bus.
///
/// # Errors
/// What the drive did not answer rightly.
///
/// # Panics
/// If the pins do what no driver bears.
pub fn at(velocity: u32, seconds: u32) -> Result<Served, Failure> {
    let mut bus = Bus::new(BitRate::Kbit1000);
    bus.attach(Others::default());
    let (master, board) = enabled(bus, PHASE)?;
    let mut traffic = Traffic::new(master, board)?;
    let speed = velocity.cast_signed();

    // The ramp, and a little more.
    let ramp = u64::from(velocity) * 1_000 / u64::from(super::STEEP) + 20;
    traffic.run(ramp, speed)?;
    traffic.served = Served::default();
    let before = traffic.pulses();
    let since = traffic.master.now();
    traffic.run(u64::from(seconds) * 1_000, speed)?;
    let lasted = (traffic.master.now() - since).ticks();
    let pulses = traffic.pulses() - before;
    traffic.served.rate = (pulses * 1_000_000 + lasted / 2) / lasted;

    traffic.run(ramp, 0)?;
    let node = Board::NODE;
    let told: i32 = traffic.master.read(node, 0x6064, 0)?;
    traffic.served.error = traffic.position().abs_diff(told.into());

    traffic.master.write(node, 0x6060, 0, PROFILE_POSITION)?;
    let target = told.wrapping_sub(speed);
    traffic.master.write(node, 0x607A, 0, target)?;
    traffic.master.write(node, 0x6081, 0, velocity)?;
    traffic.new_set_point = true;
    traffic.run(2 * ramp + 1_100, 0)?;
    let off = traffic.position().abs_diff(target.into());
    traffic.served.error = traffic.served.error.max(off);
    Ok(traffic.served)
}

/// The master's part.
struct Traffic {
    master: Master,
    board: Handle<Board>,
    served: Served,
    /// The last position that was sampled.
    sampled: Option<i32>,
    new_set_point: bool,
}

impl Traffic {
    /// Maps what travels each millisecond.
    fn new(mut master: Master, board: Handle<Board>) -> Result<Self, Failure> {
        let node = Board::NODE;
        let controlword = MappedObject::new(0x6040, 16);
        let velocity = MappedObject::new(0x60FF, 32);
        let order = PdoSetup {
            cob_id: ORDER,
            transmission_type: 255,
            inhibit_time: None,
            event_timer: None,
            objects: vec![controlword, velocity],
        };
        master.set_up_rpdo(node, 2, &order)?;
        let sample = PdoSetup {
            cob_id: SAMPLE,
            transmission_type: 1,
            inhibit_time: None,
            event_timer: None,
            objects: vec![MappedObject::new(0x6041, 16), MappedObject::new(0x6064, 32)],
        };
        master.set_up_tpdo(node, 2, &sample)?;
        master.write(node, 0x6060, 0, PROFILE_VELOCITY)?;
        master.take_received();
        Ok(Self {
            master,
            board,
            served: Served::default(),
            sampled: None,
            new_set_point: false,
        })
    }

    fn pulses(&mut self) -> u64 {
        let now = self.master.now();
        self.master.station_mut(self.board).pulses_at(now)
    }

    fn position(&mut self) -> i64 {
        self.pulses();
        self.master.station(self.board).model().judge().position
    }

    /// So many milliseconds.
    fn run(&mut self, milliseconds: u64, velocity: i32) -> Result<(), Failure> {
        let begin = self.master.now();
        for millisecond in 1..=milliseconds {
            let end = begin + Duration::millis(millisecond);
            self.order(velocity);
            self.master.sync();
            self.sample(velocity)?;
            // Two frames, each behind one of the others.
            while self.master.now() + Duration::micros(600) < end {
                self.transfer()?;
            }
            if let Some(rest) = end.checked_duration_since(self.master.now()) {
                self.master.wait(rest)?;
            }
            let trace = self.master.bus_mut().take_trace();
            self.served.frames += trace.len() as u64;
        }
        Ok(())
    }

    /// The controlword, and the velocity that it is about.
    fn order(&mut self, velocity: i32) {
        let controlword: u16 = if self.new_set_point { 0x1F } else { 0x0F };
        let mut data = [0; 6];
        data[..2].copy_from_slice(&controlword.to_le_bytes());
        data[2..].copy_from_slice(&velocity.to_le_bytes());
        self.master.send_data(ORDER, &data);
    }

    /// The TPDO that answers SYNC: operation enabled, no fault, and never a step back on the way forth.
    fn sample(&mut self, velocity: i32) -> Result<(), Failure> {
        let data = self.master.expect_from(SAMPLE)?;
        let wrong = |got| Failure::WrongValue {
            expected: "a TPDO of a drive that goes on".to_owned(),
            got,
        };
        let [low, high, a, b, c, d] = data[..] else {
            return Err(wrong(format!("{data:02X?}")));
        };
        let statusword = u16::from_le_bytes([low, high]);
        let position = i32::from_le_bytes([a, b, c, d]);
        let goes_back = velocity > 0
            && self
                .sampled
                .is_some_and(|before| position.wrapping_sub(before) < 0);
        if statusword & 0x6F != 0x27 || goes_back {
            return Err(wrong(format!("{statusword:04X}h, {position}")));
        }
        self.sampled = Some(position);
        self.served.samples += 1;
        let received = self.master.take_received();
        let emergency = received
            .iter()
            .find(|(_, frame)| frame.standard_id() == Some(EMERGENCY));
        match emergency {
            Some((_, frame)) => Err(wrong(format!("{:02X?}", frame.payload()))),
            None => Ok(()),
        }
    }

    /// One SDO transfer of several kinds.
    fn transfer(&mut self) -> Result<(), Failure> {
        let node = Board::NODE;
        let number = self.served.transfers as u32;
        self.served.transfers += 1;
        let value = 1 + number / 4;
        match number % 4 {
            0 => self.master.write(node, 0x6067, 0, value),
            1 => {
                let got: u32 = self.master.read(node, 0x6067, 0)?;
                if got == value {
                    return Ok(());
                }
                Err(Failure::WrongValue {
                    expected: value.to_string(),
                    got: got.to_string(),
                })
            }
            2 => self.master.read::<i32>(node, 0x606C, 0).map(drop),
            _ => self.master.read::<i32>(node, 0x6064, 0).map(drop),
        }
    }
}

/// Everybody else: frames of the lowest priority, one after the other.
#[derive(Debug, Default)]
struct Others {
    sent: u8,
}

impl Station for Others {
    fn receive(&mut self, _frame: &Frame, _now: Instant) {}

    fn poll(&mut self, _now: Instant) -> Instant {
        NEVER
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.sent = self.sent.wrapping_add(1);
        Some(Frame::data_frame(0x7FF, &[self.sent; 8]))
    }
}
