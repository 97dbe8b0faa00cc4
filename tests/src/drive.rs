//! The virtual drive on the bus, with the words of CiA 402.

use canopen::Frame;
use cia402::Behaves;
use master::bus::Station;
use sim::drive::{Moving, Setup, VirtualDrive};
use sim::plant::{Axis, ServoAxisData};

use crate::line::Line;

/// The virtual drive with the dictionary of `eds/axis402.eds`.
pub type AxisDrive = sim::Axis402;

/// A virtual drive and a script on one bus.
pub type DriveBench = Line<AxisDrive>;

/// The same with the dictionary of `eds/compact.eds`.
pub type CompactBench = Line<VirtualDrive<products::compact::Dictionary>>;

/// The virtual drive with a servo, with the dictionary of `eds/servo.toml`.
pub type ServoBench = Line<sim::ServoDrive>;

impl ServoBench {
    /// A drive on a ready axis, Operational, in switch on disabled.
    ///
    /// # Panics
    /// If there is no such axis.
    pub fn on_axis(name: &str) -> Self {
        Self::on_changed(name, |_| {})
    }

    /// The same with something else about the axis.
    ///
    /// # Panics
    /// If there is no such axis.
    pub fn on_changed(name: &str, change: impl FnOnce(&mut ServoAxisData)) -> Self {
        let mut data = ServoAxisData::named(name).expect("a ready axis");
        change(&mut data);
        Self::on(Axis::servo(&data))
    }
}

/// A state of CiA 402 as the statusword shows it: mask and value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    mask: u16,
    value: u16,
    name: &'static str,
}

impl State {
    const fn new(mask: u16, value: u16, name: &'static str) -> Self {
        Self { mask, value, name }
    }

    /// Whether a statusword shows this state.
    pub fn is_shown_by(self, statusword: u16) -> bool {
        statusword & self.mask == self.value
    }
}

/// Not ready to switch on, by the mask that masters use.
pub const NOT_READY_TO_SWITCH_ON: State = State::new(0x4F, 0x00, "not ready to switch on");
/// Switch on disabled, by the mask that masters use.
pub const SWITCH_ON_DISABLED: State = State::new(0x4F, 0x40, "switch on disabled");
/// Ready to switch on, by the mask that masters use.
pub const READY_TO_SWITCH_ON: State = State::new(0x6F, 0x21, "ready to switch on");
/// Switched on, by the mask that masters use.
pub const SWITCHED_ON: State = State::new(0x6F, 0x23, "switched on");
/// Operation enabled, by the mask that masters use.
pub const OPERATION_ENABLED: State = State::new(0x6F, 0x27, "operation enabled");
/// Quick stop active, by the mask that masters use.
pub const QUICK_STOP_ACTIVE: State = State::new(0x6F, 0x07, "quick stop active");
/// Fault reaction active, by the mask that masters use.
pub const FAULT_REACTION_ACTIVE: State = State::new(0x4F, 0x0F, "fault reaction active");
/// Fault, by the mask that masters use.
pub const FAULT: State = State::new(0x4F, 0x08, "fault");

/// Statusword bit 10, target reached.
pub const TARGET_REACHED: u16 = 1 << 10;
/// Statusword bit 11, internal limit active.
pub const INTERNAL_LIMIT: u16 = 1 << 11;
/// Statusword bit 12 in profile position: set-point acknowledge.
pub const ACKNOWLEDGE: u16 = 1 << 12;

impl<D, A> Line<VirtualDrive<D, A>>
where
    D: Behaves + Default,
    A: Moving,
    VirtualDrive<D, A>: Station,
{
    /// A drive with this node-ID that has booted and is Pre-operational.
    pub fn booted(node_id: u8) -> Self {
        Self::with(Setup::with_node_id(1, node_id), node_id)
    }

    /// A drive of one's own making, booted.
    pub fn with(setup: Setup, node_id: u8) -> Self {
        let device = VirtualDrive::new(setup);
        let mut bench = Self::new(device, node_id);
        bench.expect(&format!("{:03X} [1] 00", 0x700 + u16::from(node_id)));
        bench
    }

    /// A drive that is Operational, in switch on disabled.
    pub fn started(node_id: u8) -> Self {
        let mut bench = Self::booted(node_id);
        bench.start();
        bench.reaches(SWITCH_ON_DISABLED, 20);
        bench
    }

    /// A drive with this axis as its motor, Operational, in switch on disabled.
    pub fn on(axis: Axis) -> Self {
        let setup = Setup {
            axis: Some(axis),
            ..Setup::with_node_id(1, 4)
        };
        let mut bench = Self::with(setup, 4);
        bench.start();
        bench.reaches(SWITCH_ON_DISABLED, 20);
        bench
    }

    /// A drive in operation enabled, profile position, at position 0.
    pub fn enabled(node_id: u8) -> Self {
        let mut bench = Self::started(node_id);
        bench.enable();
        bench
    }

    /// Walks from switch on disabled to operation enabled.
    #[track_caller]
    pub fn enable(&mut self) {
        for (controlword, state) in [
            (0x06, READY_TO_SWITCH_ON),
            (0x07, SWITCHED_ON),
            (0x0F, OPERATION_ENABLED),
        ] {
            self.command(controlword);
            self.reaches(state, 20);
        }
    }

    /// Gives a PDO (1400h, 1800h and up) its objects as masters do at start-up: invalid, without objects, then each of them, its
    /// transmission type, no timers, valid again.
    #[track_caller]
    pub fn map_pdo(&mut self, index: u16, objects: &[u32], transmission_type: u8) {
        let cob_id = self.read_u32(index, 1) & 0x7FFF_FFFF;
        self.write_u32(index, 1, cob_id | 1 << 31);
        self.write_u8(index + 0x200, 0, 0);
        for (sub, object) in (1..).zip(objects) {
            self.write_u32(index + 0x200, sub, *object);
        }
        self.write_u8(index + 0x200, 0, objects.len() as u8);
        self.write_u8(index, 2, transmission_type);
        if index >= 0x1800 {
            self.write_u16(index, 3, 0);
            self.write_u16(index, 5, 0);
        }
        self.write_u32(index, 1, cob_id);
    }

    /// Sends a controlword by RPDO 1.
    pub fn command(&mut self, controlword: u16) {
        let cob_id = 0x200 + u16::from(self.node_id);
        self.send_frame(Frame::data_frame(cob_id, &controlword.to_le_bytes()));
    }

    /// The statusword the drive published last.
    pub fn statusword(&mut self) -> u16 {
        self.bus.station(self.device).actuals().statusword
    }

    /// The state must be seen within so many milliseconds.
    #[track_caller]
    pub fn reaches(&mut self, state: State, milliseconds: u64) {
        for _ in 0..milliseconds * 4 {
            if state.is_shown_by(self.statusword()) {
                return;
            }
            self.run_micros(250);
        }
        panic!(
            "{} was not reached within {milliseconds} ms; the statusword is {:04X}h",
            state.name,
            self.statusword()
        );
    }

    /// The state must stand for so many milliseconds.
    #[track_caller]
    pub fn stays_in(&mut self, state: State, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.run_millis(1);
            assert!(
                state.is_shown_by(self.statusword()),
                "{} was left, statusword {:04X}h",
                state.name,
                self.statusword()
            );
        }
    }

    /// Gives an absolute set-point; the handshake of bits 4 and 12 must come about.
    #[track_caller]
    pub fn begin_move(&mut self, target: i32) {
        self.write_i32(0x607A, 0, target);
        self.command(0x1F);
        self.run_millis(4);
        assert_ne!(
            self.statusword() & ACKNOWLEDGE,
            0,
            "the set-point was not acknowledged"
        );
        self.command(0x0F);
        self.run_millis(4);
        assert_eq!(
            self.statusword() & ACKNOWLEDGE,
            0,
            "the acknowledge did not fall"
        );
    }

    /// Target reached must come within so many milliseconds. It may come up to a position window before the end, so the motor
    /// is left to finish.
    #[track_caller]
    pub fn reaches_target(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            if self.statusword() & TARGET_REACHED != 0 {
                return self.run_millis(50);
            }
            self.run_millis(1);
        }
        panic!(
            "the target was not reached within {milliseconds} ms; the motor is at {}",
            self.position()
        );
    }

    /// Where the motor is, in steps.
    pub fn position(&self) -> i64 {
        self.bus.station(self.device).plant().position()
    }

    /// The board reports a fault, or no longer.
    pub fn set_fault(&mut self, code: Option<u16>) {
        self.bus.station_mut(self.device).plant_mut().fault = code;
    }

    /// The supply of the power stage comes or goes.
    pub fn set_supply(&mut self, on: bool) {
        self.bus.station_mut(self.device).plant_mut().supply = on;
    }

    /// Keeps where the motor was at each control tick from now on.
    pub fn record_motion(&mut self) {
        self.bus.station_mut(self.device).record_motion();
    }

    /// The greatest acceleration of the motor since [`DriveBench::record_motion`] in steps/s², from positions 20 ms apart, so
    /// that one step more or less does not count as a jerk.
    pub fn greatest_acceleration(&self) -> i64 {
        let samples: Vec<i64> = self
            .bus
            .station(self.device)
            .motion_samples()
            .iter()
            .map(|sample| sample.position)
            .collect();
        samples
            .windows(41)
            .map(|w| (w[40] - 2 * w[20] + w[0]).abs() * 2_500)
            .max()
            .unwrap_or(0)
    }

    /// The virtual drive itself.
    pub fn axis(&mut self) -> &mut VirtualDrive<D, A> {
        self.bus.station_mut(self.device)
    }
}

impl ServoBench {
    /// The motor with what is around it, to load it or to break it.
    ///
    /// # Panics
    /// Never: a servo bench has a servo.
    pub fn plant(&mut self) -> &mut servo_plant::Plant {
        let servo = self.axis().plant_mut().servo_mut();
        servo.expect("it has a servo").plant_mut()
    }
}
