//! What the master of the demonstration does.

use canopen::{BitRate, Duration, Frame, NodeId};

use super::{Chapter, Story, TARGET};
use crate::Axis402;
use crate::drive::Setup;
use master::bus::simulated::{Bus, Handle};
use master::data_sheet::DataSheet;
use master::trace::Interpreter;
use master::{Failure, MappedObject, Master, NmtCommand, PdoSetup};

/// 1018h:4 of the drive, so that the fastscan has something to find.
const SERIAL_NUMBER: u32 = 0x00C0_FFEE;

/// Steps/s and steps/s².
const VELOCITY: u32 = 40_000;
const ACCELERATION: u32 = 100_000;
const DECELERATION: u32 = 200_000;

/// How long a move may take.
const MOVE_TIME: Duration = Duration::from_ticks(5_000_000);

/// How long a change of state may take.
const STATE_TIME: Duration = Duration::from_ticks(100_000);

const CONTROLWORD: MappedObject = MappedObject::new(0x6040, 16);
const STATUSWORD: MappedObject = MappedObject::new(0x6041, 16);
const POSITION: MappedObject = MappedObject::new(0x6064, 32);
const TARGET_POSITION: MappedObject = MappedObject::new(0x607A, 32);
const VELOCITY_OBJECT: MappedObject = MappedObject::new(0x6081, 32);

/// Plays the demonstration on virtual time.
///
/// # Errors
/// The step that failed.
pub fn play(node_id: u8) -> Result<Story, Failure> {
    play_on(Bus::new(BitRate::Kbit1000), node_id)
}

/// [`play`] on a bus that is there already.
pub(super) fn play_on(bus: Bus, node_id: u8) -> Result<Story, Failure> {
    let mut script = Script::new(bus, node_id);
    script.commission()?;
    script.configure()?;
    script.map_position()?;
    script.enable()?;
    script.move_to(TARGET)?;
    script.move_to(0)?;
    script.switch_off()?;
    Ok(script.story())
}

/// Knows what the PDOs of the demonstration carry.
pub fn interpreter(node_id: u8) -> Interpreter {
    let node = u16::from(node_id);
    let mut interpreter = Interpreter::new(DataSheet::axis402());
    interpreter.learn_pdo(0x200 + node, node_id, "RPDO 1", &[CONTROLWORD]);
    interpreter.learn_pdo(
        0x400 + node,
        node_id,
        "RPDO 3",
        &[CONTROLWORD, TARGET_POSITION],
    );
    interpreter.learn_pdo(
        0x500 + node,
        node_id,
        "RPDO 4",
        &[TARGET_POSITION, VELOCITY_OBJECT],
    );
    interpreter.learn_pdo(0x180 + node, node_id, "TPDO 1", &[STATUSWORD]);
    interpreter.learn_pdo(0x380 + node, node_id, "TPDO 3", &[POSITION]);
    interpreter
}

/// The streams in which single frames say little.
pub fn stream(frame: &Frame) -> Option<u16> {
    match (frame.standard_id()?, frame.payload()) {
        (0x7E5, [0x51, ..]) | (0x7E4, [0x4F, ..]) => Some(0x7E5),
        (cob_id @ 0x380..=0x3FF, _) => Some(cob_id),
        _ => None,
    }
}

struct Script {
    master: Master,
    drive: Handle<Axis402>,
    node: u8,
    chapters: Vec<Chapter>,
    arrivals: Vec<(i32, i32)>,
}

impl Script {
    fn new(bus: Bus, node: u8) -> Self {
        let mut master = Master::new(bus);
        let mut drive = Axis402::new(Setup::unconfigured(SERIAL_NUMBER));
        drive.record_motion();
        let drive = master.bus_mut().attach(drive);
        Self {
            master,
            drive,
            node,
            chapters: Vec::new(),
            arrivals: Vec::new(),
        }
    }

    fn commission(&mut self) -> Result<(), Failure> {
        let node_id = NodeId::new(self.node).unwrap_or(NodeId::UNCONFIGURED);
        if self.master.lss_fastscan()?.is_none() {
            return Err(Failure::WrongValue {
                expected: "a drive without a node-ID".to_owned(),
                got: "none".to_owned(),
            });
        }
        self.master.lss_inquire_identity()?;
        self.master.lss_configure_node_id(node_id)?;
        self.master.lss_store()?;
        self.master.lss_switch_to_waiting();
        self.master.expect_boot_up(self.node, STATE_TIME)?;
        self.end_chapter("LSS: find the drive that has no node-ID, and give it one");
        Ok(())
    }

    fn configure(&mut self) -> Result<(), Failure> {
        self.master.read::<String>(self.node, 0x1008, 0)?;
        self.master.read::<u32>(self.node, 0x1000, 0)?;
        self.master.write(self.node, 0x6060, 0, 1i8)?;
        self.master.write(self.node, 0x6081, 0, VELOCITY)?;
        self.master.write(self.node, 0x6083, 0, ACCELERATION)?;
        self.master.write(self.node, 0x6084, 0, DECELERATION)?;
        self.end_chapter("SDO: who are you? Then the profile: mode, velocity, ramps");
        Ok(())
    }

    fn map_position(&mut self) -> Result<(), Failure> {
        let position = PdoSetup {
            cob_id: 0x380 + u16::from(self.node),
            transmission_type: 255,
            inhibit_time: Some(200), // 20 ms
            event_timer: None,
            objects: vec![POSITION],
        };
        self.master.set_up_tpdo(self.node, 3, &position)?;
        self.end_chapter("SDO: map the actual position into TPDO 3, at most every 20 ms");
        Ok(())
    }

    fn enable(&mut self) -> Result<(), Failure> {
        self.master.nmt(NmtCommand::Start, self.node);
        self.master
            .wait_for_statusword(self.node, 0x4F, 0x40, STATE_TIME)?;
        for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
            self.master.controlword(self.node, controlword);
            self.master
                .wait_for_statusword(self.node, 0x6F, state, STATE_TIME)?;
        }
        self.end_chapter("NMT start; PDOs take the drive through its states");
        Ok(())
    }

    /// The set-point handshake: bit 4 of the controlword, bit 12 of the statusword, then bit 10 at the target.
    fn move_to(&mut self, target: i32) -> Result<(), Failure> {
        self.set_point(0x1F, target);
        self.master
            .wait_for_statusword(self.node, 0x1000, 0x1000, STATE_TIME)?;
        self.set_point(0x0F, target);
        self.master
            .wait_for_statusword(self.node, 0x1400, 0x0400, MOVE_TIME)?;
        // The position follows within the inhibit time of its PDO.
        self.master.run_for(Duration::from_ticks(30_000));
        let position = self.master.read(self.node, 0x6064, 0)?;
        self.arrivals.push((target, position));
        self.end_chapter(&format!("PDO: move to {target}"));
        Ok(())
    }

    fn set_point(&mut self, controlword: u16, target: i32) {
        self.master.take_received();
        let mut data = controlword.to_le_bytes().to_vec();
        data.extend_from_slice(&target.to_le_bytes());
        self.master.send_data(0x400 + u16::from(self.node), &data);
    }

    fn switch_off(&mut self) -> Result<(), Failure> {
        self.master.controlword(self.node, 0x06);
        self.master
            .wait_for_statusword(self.node, 0x6F, 0x21, STATE_TIME)?;
        self.master.nmt(NmtCommand::EnterPreOperational, self.node);
        self.master.run_for(Duration::from_ticks(20_000));
        self.end_chapter("PDO: power off");
        Ok(())
    }

    fn end_chapter(&mut self, title: &str) {
        self.chapters.push(Chapter {
            title: title.to_owned(),
            frames: self.master.bus_mut().take_trace(),
        });
    }

    fn story(self) -> Story {
        Story {
            chapters: self.chapters,
            motion: self.master.station(self.drive).motion_samples().to_vec(),
            torques: Vec::new(),
            arrivals: self.arrivals,
        }
    }
}
