//! What goes wrong at the timers, as the master of the whole drive sees it.

use canopen::{BitRate, Duration};
use cia402::faults::{EXTERNAL, POSITION_MISMATCH, PULSES_STOPPED};

use super::super::board::Board;
use crate::exactness::enabled;
use master::Master;
use master::bus::simulated::{Bus, Handle};

const NODE: u8 = Board::NODE;

/// What an emergency message has told so far, and where the pins are.
struct Bench {
    master: Master,
    board: Handle<Board>,
}

impl Bench {
    /// Operation enabled; a drive that cruises at so many steps/s for 100 ms.
    fn cruising(velocity: i32) -> Self {
        let (mut master, board) =
            enabled(Bus::new(BitRate::Kbit1000), Duration::micros(125)).unwrap();
        master.write(NODE, 0x60FF, 0, velocity).unwrap();
        let mut bench = Self { master, board };
        bench.wait(100);
        bench.master.take_received();
        bench
    }

    fn wait(&mut self, milliseconds: u64) {
        self.master.wait(Duration::millis(milliseconds)).unwrap();
    }

    fn board(&mut self) -> &mut Board {
        self.master.station_mut(self.board)
    }

    fn set_break(&mut self, is_active: bool) {
        let now = self.master.now();
        self.board().set_break(now, is_active);
    }

    /// The codes of the emergency messages since the last look.
    fn told(&mut self) -> Vec<u16> {
        let received = self.master.take_received();
        let emergencies = received
            .iter()
            .filter(|(_, frame)| frame.standard_id() == Some(0x80 + u16::from(NODE)));
        emergencies
            .map(|(_, frame)| u16::from_le_bytes([frame.payload()[0], frame.payload()[1]]))
            .collect()
    }

    fn state(&mut self) -> u16 {
        self.master.read::<u16>(NODE, 0x6041, 0).unwrap() & 0x6F
    }

    /// How far the position that is told is from the pins.
    fn off(&mut self) -> i64 {
        let told: i32 = self.master.read(NODE, 0x6064, 0).unwrap();
        self.pins() - i64::from(told)
    }

    fn pins(&mut self) -> i64 {
        let now = self.master.now();
        self.board().pulses_at(now);
        self.board().model().judge().position
    }

    /// Resets the fault, and goes up to operation enabled again.
    fn go_on(&mut self) {
        self.master.write(NODE, 0x60FF, 0, 0_i32).unwrap();
        self.master.controlword(NODE, 0x80);
        self.wait(5);
        for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
            self.master.controlword(NODE, controlword);
            self.wait(5);
            assert_eq!(self.state(), state);
        }
    }

    /// Through a motion the pins follow what is told.
    fn moves(&mut self, velocity: i32) {
        let (before, off) = (self.pins(), self.off());
        self.master.write(NODE, 0x60FF, 0, velocity).unwrap();
        self.wait(100);
        assert_ne!(self.pins(), before);
        self.master.write(NODE, 0x60FF, 0, 0_i32).unwrap();
        self.wait(200);
        assert_eq!(self.off(), off);
        assert_eq!(self.state(), 0x27);
        assert!(self.told().is_empty());
    }
}

#[test]
fn a_break_is_an_external_error_until_it_is_over_and_reset() {
    for velocity in [0, 3_000, -100_000, 900_000] {
        let mut bench = Bench::cruising(velocity);
        bench.set_break(true);
        bench.wait(3);
        assert_eq!(bench.told(), [EXTERNAL]);
        assert_eq!(bench.state(), 0x08);
        let code: u16 = bench.master.read(NODE, 0x603F, 0).unwrap();
        assert_eq!(code, EXTERNAL);
        // What is still cut off cannot be reset.
        bench.master.controlword(NODE, 0x80);
        bench.wait(5);
        // The one that was known is reset, and there is another.
        assert_eq!((bench.state(), bench.told()), (0x08, vec![0, EXTERNAL]));
        let pins = bench.pins();
        bench.wait(50);
        assert_eq!(bench.pins(), pins);
        bench.master.controlword(NODE, 0);
        bench.set_break(false);
        bench.wait(5);
        assert_eq!(bench.state(), 0x08, "it does not go on by itself");
        // 2 µs of pulses were counted and did not leave.
        assert!(bench.off().abs() <= 3, "{} at {velocity}", bench.off());
        bench.go_on();
        // A fault that is gone is told by code 0.
        assert_eq!(bench.told(), [0]);
        bench.moves(50_000);
    }
}

/// The stream is not served, or has ended with a bus error: the pulses of its last run went on, and are counted.
#[test]
fn a_stream_that_stops_is_a_fault_of_the_control_hardware() {
    for velocity in [3_000, -100_000, 900_000] {
        for is_bus_error in [false, true] {
            let mut bench = Bench::cruising(velocity);
            if is_bus_error {
                bench.board().model().fail_stream();
            } else {
                bench.board().model().stall_stream(true);
            }
            bench.wait(4);
            assert_eq!(bench.told(), [PULSES_STOPPED]);
            assert_eq!(bench.state(), 0x08);
            let pins = bench.pins();
            bench.wait(50);
            assert_eq!((bench.pins(), bench.off()), (pins, 0));
            bench.board().model().stall_stream(false);
            bench.go_on();
            assert_eq!(bench.told(), [0]);
            bench.moves(-velocity);
            assert_eq!(bench.off(), 0);
        }
    }
}

/// The slave timer is the witness of the pulses: a step that it has not seen is found when the motor stands, and not before.
#[test]
fn pulses_that_were_not_counted_are_found_at_rest() {
    for lost in [1, 7, 1_000] {
        for velocity in [0, 20_000, -300_000] {
            let mut bench = Bench::cruising(velocity);
            bench.board().model().lose_count(lost);
            bench.wait(20);
            if velocity != 0 {
                assert_eq!((bench.told(), bench.state()), (vec![], 0x27));
                bench.master.write(NODE, 0x60FF, 0, 0_i32).unwrap();
                bench.wait(100);
            }
            assert_eq!(bench.told(), [POSITION_MISMATCH], "{lost} at {velocity}");
            assert_eq!(bench.state(), 0x08);
            let lost = i64::from(lost);
            // At rest the last committed pulses went forth.
            let way = if velocity < 0 { -lost } else { lost };
            assert_eq!(bench.off(), way);
            bench.go_on();
            assert_eq!(bench.told(), [0]);
            bench.moves(50_000);
        }
    }
}
