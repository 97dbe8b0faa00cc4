//! Two models of the timers, this one and the one that the flashed image runs on (`tests/machine/stm32f405`), take the same writes to registers and make the
//! same pulses. This side plays moves and holds their writes and pulses to `tests/machine/registers.txt`; `tests/machine/test_two_models.py` plays that file.
//!
//! A line of it is `time W register value`, `time M slot five words` for what has changed in the memory that the stream reads, `time R` for a
//! reset of TIM1, or `time P step` for a pulse. `AXIS402_UPDATE=1` writes it anew.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::rc::Rc;

use machine::timer_model::rig::{HZ, TIME_SLICE};
use machine::timer_model::{Judge, TimerModel};
use motion::advanced_timer::{Output, Register, Registers, Ring, SLOTS, WORDS};
use motion::{AdvanceError, Axis, AxisConfig, Clock, DriverTiming, Limits, PulseSink};

/// The times of a TMC2209 at 168 MHz.
const TIMING: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

/// The registers of the model, with a record of what is written.
struct Recorded {
    model: TimerModel<'static>,
    record: Rc<RefCell<Record>>,
}

struct Record {
    ring: &'static Ring,
    known: Vec<[u32; WORDS]>,
    text: String,
}

impl Record {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// What has changed in the memory of the stream.
    fn note_memory(&mut self, time: u64) {
        for slot in 0..SLOTS {
            let words = self.ring.words(slot as u32);
            if self.known[slot] != words {
                self.known[slot] = words;
                let [a, b, c, d, e] = words;
                self.line(&format!("{time} M {slot} {a} {b} {c} {d} {e}"));
            }
        }
    }
}

impl Registers for Recorded {
    fn write(&mut self, register: Register, value: u32) {
        let time = self.model.time();
        let mut record = self.record.borrow_mut();
        record.note_memory(time);
        if register == Register::StreamM0ar && value == record.ring.address() {
            // The address is another one on each machine.
            record.line(&format!("{time} W {register:?} ring"));
        } else {
            record.line(&format!("{time} W {register:?} {value}"));
        }
        self.model.write(register, value);
    }

    fn read(&self, register: Register) -> u32 {
        self.model.read(register)
    }

    fn now(&self) -> u32 {
        self.model.now()
    }

    fn reset(&mut self) {
        let time = self.model.time();
        self.record.borrow_mut().line(&format!("{time} R"));
        self.model.reset();
    }
}

/// An axis on recorded registers.
struct Played {
    axis: Axis,
    output: Output<'static, Recorded>,
    model: TimerModel<'static>,
    record: Rc<RefCell<Record>>,
}

impl Played {
    fn new() -> Self {
        // A test is short; its memory may stay.
        let ring: &'static Ring = Box::leak(Box::new(Ring::new()));
        let model = TimerModel::new(ring, Judge::new(TIMING).logging());
        // A write acts at the time that is recorded for it.
        model.set_access(0);
        let record = Rc::new(RefCell::new(Record {
            ring,
            known: vec![[0; WORDS]; SLOTS],
            text: String::new(),
        }));
        let config = AxisConfig {
            clock: Clock::new(HZ).unwrap(),
            time_slice: TIME_SLICE,
            timing: TIMING,
        };
        let registers = Recorded {
            model: model.clone(),
            record: Rc::clone(&record),
        };
        Self {
            axis: Axis::new(config),
            output: Output::new(registers, ring),
            model,
            record,
        }
    }

    fn refill(&mut self) {
        self.output.service();
        match self.axis.advance(&mut self.output) {
            Ok(()) | Err(AdvanceError::SinkFull) => {}
            Err(error) => panic!("{error:?}"),
        }
        self.record.borrow_mut().note_memory(self.model.time());
        self.model.run(TIME_SLICE.into());
    }

    fn move_to(&mut self, target: i64, velocity: u32) {
        let limits = Limits {
            velocity: velocity.into(),
            acceleration: 20_000_000,
            deceleration: 20_000_000,
        };
        self.axis.move_to(target, limits).unwrap();
        while !(self.axis.is_at_rest() && self.output.pending() == 0) {
            self.refill();
        }
        self.refill();
    }
}

#[test]
fn the_same_writes_make_the_same_pulses() {
    let mut played = Played::new();
    for (target, velocity) in [
        (40, 20_000),
        (-25, 7_777),
        (-24, 100),
        (1_200, 1_000_000),
        (0, 333_333),
    ] {
        played.move_to(target, velocity);
    }
    // A train that is dropped in its middle, and a move behind it.
    played
        .axis
        .ramp_to(
            200_000.into(),
            Limits {
                velocity: 200_000.into(),
                acceleration: 20_000_000,
                deceleration: 20_000_000,
            },
        )
        .unwrap();
    for _ in 0..6 {
        played.refill();
    }
    played.output.drop_all();
    let position = played.output.position();
    assert_eq!(position, played.model.judge().position);
    played.axis.set_position(position);
    played.move_to(position - 30, 50_000);

    let mut text = std::mem::take(&mut played.record.borrow_mut().text);
    for (at, step) in played.model.judge().log.as_ref().unwrap() {
        writeln!(text, "{at} P {step}").unwrap();
    }
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/machine/registers.txt");
    if std::env::var_os("AXIS402_UPDATE").is_some() {
        std::fs::write(&file, &text).unwrap();
    }
    let kept = std::fs::read_to_string(&file).unwrap();
    assert!(
        text == kept,
        "writes or pulses have changed: AXIS402_UPDATE=1 keeps them, and `cargo xtask board-test` plays them on the other model"
    );
}
