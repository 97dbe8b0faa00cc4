//! A master that does what ros2_canopen does, in virtual time: its PDOs, its masks, its order and its times.
//!
//! As it is set up by the `bus.yml` of its own tests: SYNC every 10 ms; TPDO 1 (6041h, 6061h) and TPDO 2 (6064h, 606Ch) synchronous; RPDO 1
//! (6040h, 6060h) and RPDO 2 (the targets). Every 10 ms, by a timer of its own, it looks at what the TPDOs brought, writes the
//! target of its mode and then the controlword. Its master sends an event-driven RPDO as it is written, and a synchronous one behind each SYNC.
//! What is in no PDO it writes by SDO.
//!
//! It sets halt whenever it has no target, so while the mode changes too; walks one state at a time; and resets a fault by bit 7 on top of
//! whatever controlword it had. It waits 5 s for a state or a mode, and 1 s for a homing to begin.

use canopen::{Duration, Frame};
use sim::drive::Setup;
use sim::plant::{Axis, Switch, Track};
use tests::DriveBench;
use tests::drive::{
    ACKNOWLEDGE, FAULT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON,
    SWITCH_ON_DISABLED, SWITCHED_ON, State, TARGET_REACHED,
};

use crate::cyclic_master::latency;

/// From SYNC to SYNC, and from one run of its timer to the next, in microseconds.
pub(crate) const CYCLE: u64 = 10_000;
/// So many cycles it waits for a state or a mode.
const PATIENCE: u32 = 500;
/// So many it waits for a homing to begin.
const HOMING_BEGINS: u32 = 100;

const HALT: u16 = 1 << 8;
const FAULT_RESET: u16 = 1 << 7;
/// The bits of the controlword that belong to the mode: 4, 5, 6 and 9.
const OF_THE_MODE: u16 = 0x270;
pub(crate) const BIT_4: u16 = 1 << 4;
const IMMEDIATE: u16 = 1 << 5;
/// Statusword bits 12 and 13 in homing.
const ATTAINED: u16 = 1 << 12;
const HOMING_ERROR: u16 = 1 << 13;

const CONTROLWORD: u32 = 0x6040_0010;
const MODE: u32 = 0x6060_0008;
pub(crate) const VELOCITY: u32 = 0x6042_0010;
pub(crate) const TARGET_POSITION: u32 = 0x607A_0020;
pub(crate) const TARGET_VELOCITY: u32 = 0x60FF_0020;
pub(crate) const RECORD: u32 = 0x60C1_0120;

/// How its master sends RPDOs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rpdos {
    Synchronous,
    EventDriven,
}

/// Where home is.
pub(crate) const HOME: i64 = 1_000;

/// The driver and its master.
pub(crate) struct Ros {
    pub(crate) drive: DriveBench,
    rpdos: Rpdos,
    /// RPDO 2: objects and values.
    targets: Vec<(u32, i32)>,
    /// RPDO 1 as it was last written.
    first: (u16, i8),
    /// Its idea of the controlword.
    pub(crate) controlword: u16,
    /// In the next controlword bit 7 is left out, so that there is an edge.
    pub(crate) resets: bool,
    /// The mode that it has chosen, and its target.
    mode: Option<i8>,
    pub(crate) target: Option<i32>,
    /// Profile position: the last target that was sent.
    pub(crate) sent: Option<i32>,
    /// Homing: bit 4 is to be set.
    executes: bool,
    /// 6041h and 6061h of TPDO 1; what it has looked at comes with `look`.
    heard: (u16, i8),
    pub(crate) status: u16,
    pub(crate) display: i8,
    /// 606Ch of TPDO 2.
    pub(crate) velocity: i32,
    next_sync: u64,
    /// When its timer is due, and when it runs.
    due: u64,
    next_look: u64,
    /// How far its timer is off, at most, in microseconds.
    pub(crate) unrest: u64,
    random: u64,
    /// The first target of RPDO 2 as it was last on the bus.
    on_the_bus: i32,
    /// That at each SYNC, and 6064h that came for the SYNC.
    pub(crate) commanded: Vec<i32>,
    pub(crate) shown: Vec<i32>,
}

impl Ros {
    /// A drive, configured and started, and a driver that has not looked at it yet. 60C2h is left alone.
    pub(crate) fn booted(rpdos: Rpdos, targets: &[u32]) -> Self {
        let axis = Axis {
            track: Track {
                home: Some(Switch::within(HOME..=2 * HOME)),
                ..Track::default()
            },
            ..Axis::default()
        };
        let setup = Setup {
            axis: Some(axis),
            ..Setup::with_node_id(1, 4)
        };
        let mut drive = DriveBench::with(setup, 4);
        let transmission_type = match rpdos {
            Rpdos::Synchronous => 1,
            Rpdos::EventDriven => 255,
        };
        drive.map_pdo(0x1400, &[CONTROLWORD, MODE], transmission_type);
        drive.map_pdo(0x1401, targets, transmission_type);
        drive.map_pdo(0x1800, &[0x6041_0010, 0x6061_0008], 1);
        drive.map_pdo(0x1801, &[0x6064_0020, 0x606C_0020], 1);
        for unused in [0x1802, 0x1803] {
            let cob_id = drive.read_u32(unused, 1);
            drive.write_u32(unused, 1, cob_id | 1 << 31);
        }
        drive.start();
        let now = drive.now().ticks();
        Self {
            drive,
            rpdos,
            targets: targets.iter().map(|entry| (*entry, 0)).collect(),
            first: (0, 0),
            controlword: 0,
            resets: false,
            mode: None,
            target: None,
            sent: None,
            executes: false,
            heard: (0, 0),
            status: 0,
            display: 0,
            velocity: 0,
            next_sync: now + CYCLE,
            due: now + CYCLE + CYCLE / 3,
            next_look: now + CYCLE + CYCLE / 3,
            unrest: 0,
            random: 1,
            on_the_bus: 0,
            commanded: Vec::new(),
            shown: Vec::new(),
        }
    }

    /// The same when it has initialised the drive, without homing (6098h is 0).
    pub(crate) fn initialised(rpdos: Rpdos, targets: &[u32]) -> Self {
        let mut ros = Self::booted(rpdos, targets);
        ros.initialises();
        ros
    }

    /// What comes first: SYNC, or a run of its timer.
    fn step(&mut self) -> bool {
        let looks = self.next_look < self.next_sync;
        let at = if looks {
            self.next_look
        } else {
            self.next_sync
        };
        self.listen_until(at);
        if looks {
            self.look();
            self.write();
            self.due += CYCLE;
            self.next_look = self.due + self.off();
        } else {
            self.next_sync += CYCLE;
            self.commanded.push(self.on_the_bus);
            self.drive.queue("080 [0]");
            if self.rpdos == Rpdos::Synchronous {
                self.send_first();
                self.send_targets();
            }
        }
        looks
    }

    /// How late its timer is.
    pub(crate) fn off(&mut self) -> u64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 33) % (self.unrest + 1)
    }

    /// Up to its next run.
    pub(crate) fn cycle(&mut self) {
        while !self.step() {}
    }

    pub(crate) fn cycles(&mut self, count: u32) {
        for _ in 0..count {
            self.cycle();
        }
    }

    /// Takes what the drive sends until a moment.
    fn listen_until(&mut self, at: u64) {
        while let Some(left) = at.checked_sub(self.drive.now().ticks())
            && let Some(frame) = self.drive.next(Duration::micros(left))
        {
            match (frame.standard_id(), *frame.bytes()) {
                (Some(0x184), [low, high, mode, ..]) => {
                    self.heard = (u16::from_le_bytes([low, high]), i8::from_le_bytes([mode]));
                }
                (Some(0x284), [a, b, c, d, velocity @ ..]) => {
                    self.shown.push(i32::from_le_bytes([a, b, c, d]));
                    self.velocity = i32::from_le_bytes(velocity);
                }
                _ => {}
            }
        }
    }

    fn send_first(&mut self) {
        let [low, high] = self.first.0.to_le_bytes();
        let data = [low, high, self.first.1.cast_unsigned()];
        self.drive.queue_frame(Frame::data_frame(0x204, &data));
    }

    fn send_targets(&mut self) {
        let data: Vec<u8> = self
            .targets
            .iter()
            .flat_map(|(entry, value)| {
                value.to_le_bytes()[..(entry & 0xFF) as usize / 8].to_owned()
            })
            .collect();
        self.on_the_bus = self.targets[0].1;
        self.drive.queue_frame(Frame::data_frame(0x304, &data));
    }

    /// Writes an object: into its RPDO, by SDO if there is none.
    pub(crate) fn set(&mut self, entry: u32, value: i32) {
        if let Some(target) = self.targets.iter_mut().find(|target| target.0 == entry) {
            target.1 = value;
            if self.rpdos == Rpdos::EventDriven {
                self.send_targets();
            }
        } else {
            let [sub, low, high] = [entry >> 8, entry >> 16, entry >> 24].map(|part| part as u8);
            let [a, b, c, d] = value.to_le_bytes();
            let command = 0x23 | (4 - (entry & 0xFF) as u8 / 8) << 2;
            let request = [command, low, high, sub, a, b, c, d];
            self.drive.queue_frame(Frame::data_frame(0x604, &request));
        }
    }

    fn set_first(&mut self) {
        if self.rpdos == Rpdos::EventDriven {
            self.send_first();
        }
    }

    pub(crate) fn state(&self) -> State {
        [
            FAULT,
            SWITCH_ON_DISABLED,
            READY_TO_SWITCH_ON,
            SWITCHED_ON,
            OPERATION_ENABLED,
            QUICK_STOP_ACTIVE,
        ]
        .into_iter()
        .find(|state| state.is_shown_by(self.status))
        .unwrap_or(tests::drive::NOT_READY_TO_SWITCH_ON)
    }

    fn look(&mut self) {
        (self.status, self.display) = self.heard;
    }

    /// The target of the mode, then the controlword.
    fn write(&mut self) {
        self.controlword |= HALT;
        if self.state() == OPERATION_ENABLED {
            if self.mode == Some(self.display) {
                if self.write_target() {
                    self.controlword &= !HALT;
                }
            } else {
                self.controlword &= !OF_THE_MODE;
            }
        }
        self.first.0 = self.controlword;
        if std::mem::take(&mut self.resets) {
            self.first.0 &= !FAULT_RESET;
        }
        self.set_first();
    }

    /// Whether there is something to do in the mode.
    fn write_target(&mut self) -> bool {
        let (object, bits) = match self.display {
            1 => return self.write_position(),
            2 => (VELOCITY, 0x70),
            3 | 9 => (TARGET_VELOCITY, 0),
            6 => {
                self.controlword &= !OF_THE_MODE;
                if self.executes {
                    self.controlword |= BIT_4;
                }
                return self.executes;
            }
            7 => (RECORD, BIT_4),
            _ => (TARGET_POSITION, 0),
        };
        match self.target {
            Some(target) => {
                self.controlword |= bits;
                self.set(object, target);
                true
            }
            None => {
                self.controlword &= !bits;
                false
            }
        }
    }

    /// Profile position: 607Ah and bit 4 in one run of the timer; bit 4 falls with bit 12.
    fn write_position(&mut self) -> bool {
        self.controlword |= IMMEDIATE;
        let Some(target) = self.target else {
            return false;
        };
        if self.status & ACKNOWLEDGE != 0 {
            self.controlword &= !BIT_4;
        } else if self.sent != Some(target) {
            if self.controlword & BIT_4 != 0 {
                self.controlword &= !BIT_4;
            } else {
                self.set(TARGET_POSITION, target);
                self.controlword |= BIT_4;
                self.sent = Some(target);
            }
        }
        true
    }

    /// Until it has seen something, for so many cycles at most.
    #[track_caller]
    pub(crate) fn waits_for(&mut self, cycles: u32, what: &str, seen: impl Fn(&Self) -> bool) {
        for _ in 0..cycles {
            if seen(self) {
                return;
            }
            self.cycle();
        }
        panic!("{what}: statusword {:04X}h", self.status);
    }

    /// The next step on the way to a state: the bits that are set, and those that are cleared.
    pub(crate) fn transition(from: State, to: State) -> (u16, u16) {
        let to = match (to, from) {
            (OPERATION_ENABLED, FAULT) => SWITCH_ON_DISABLED,
            (OPERATION_ENABLED, SWITCH_ON_DISABLED) => READY_TO_SWITCH_ON,
            (OPERATION_ENABLED, READY_TO_SWITCH_ON) => SWITCHED_ON,
            _ => to,
        };
        match (from, to) {
            (FAULT, _) => (FAULT_RESET, 0),
            (_, SWITCH_ON_DISABLED) => (0, 0x82),
            (_, READY_TO_SWITCH_ON) => (0x06, 0x81),
            (_, SWITCHED_ON) => (0x07, 0x88),
            (_, QUICK_STOP_ACTIVE) => (0x02, 0x84),
            _ => (0x0F, 0x80),
        }
    }

    #[track_caller]
    pub(crate) fn switches_state(&mut self, target: State) {
        while self.state() != target {
            let from = self.state();
            let (set, clear) = Self::transition(from, target);
            self.controlword = self.controlword & !clear | set;
            self.waits_for(PATIENCE, "transition timed out", |ros| ros.state() != from);
        }
    }

    #[track_caller]
    pub(crate) fn switches_mode(&mut self, mode: i8) {
        self.mode = None;
        self.target = None;
        self.sent = None;
        self.executes = false;
        if mode != 0 {
            self.switches_state(OPERATION_ENABLED);
        }
        self.first.1 = mode;
        self.set_first();
        if mode != 0 {
            self.waits_for(PATIENCE, "mode switch timed out", |ros| ros.display == mode);
            self.mode = Some(mode);
            self.switches_state(OPERATION_ENABLED);
        }
    }

    /// Looks, resets a fault if there is one, enables, and chooses no mode.
    #[track_caller]
    pub(crate) fn initialises(&mut self) {
        self.cycles(2);
        self.controlword = 0;
        self.resets = true;
        self.switches_state(OPERATION_ENABLED);
        self.switches_mode(0);
    }

    /// Homing as it is part of the initialisation, where 6098h is not 0.
    #[track_caller]
    pub(crate) fn homes(&mut self) {
        self.switches_mode(6);
        let bits = |ros: &Self| ros.status & (TARGET_REACHED | ATTAINED | HOMING_ERROR);
        // One second for both.
        self.waits_for(HOMING_BEGINS / 2, "could not prepare homing", |ros| {
            bits(ros) & (TARGET_REACHED | HOMING_ERROR) != 0
        });
        assert_eq!(bits(self) & HOMING_ERROR, 0, "homing error before start");
        self.executes = true;
        self.waits_for(HOMING_BEGINS / 2, "homing did not start", |ros| {
            bits(ros) != TARGET_REACHED
        });
        self.waits_for(1_000, "homing not attained", |ros| {
            bits(ros) & (ATTAINED | HOMING_ERROR) != 0
        });
        self.waits_for(1_000, "homing did not stop", |ros| {
            bits(ros) & (TARGET_REACHED | HOMING_ERROR) != 0
        });
        assert_eq!(bits(self), TARGET_REACHED | ATTAINED, "homing error");
        self.executes = false;
        self.switches_mode(0);
    }

    /// A controller that gives a target in each cycle.
    pub(crate) fn follows(&mut self, targets: impl IntoIterator<Item = i32>) {
        for target in targets {
            self.target = Some(target);
            self.cycle();
        }
    }

    /// From SYNC `first` on the motor was exactly at each target that was on the bus before a SYNC.
    #[track_caller]
    pub(crate) fn is_exact(&self, first: usize) {
        let shown = &self.shown[first + latency(CYCLE)..];
        assert!(shown.len() > 100);
        for (k, (shown, commanded)) in shown.iter().zip(&self.commanded[first..]).enumerate() {
            assert_eq!(shown, commanded, "SYNC {}", first + k);
        }
    }

    /// The distance in ten cycles of SYNC.
    pub(crate) fn distance(&mut self) -> i32 {
        self.cycles(12);
        let [begin, .., end] = self.shown[self.shown.len() - 11..] else {
            unreachable!("eleven SYNCs");
        };
        end - begin
    }
}
