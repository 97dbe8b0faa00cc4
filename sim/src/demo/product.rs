//! The demonstration of another maker's drive, or of the drive with a servo: with what its data sheet gives it, by SDO alone.

use canopen::{BitRate, Duration};
use cia402::{Behaves, ServoAxis, StepAxis};

use super::{Chapter, Story, TARGET};
use crate::ServoDrive;
use crate::drive::{Moving, Setup, VirtualDrive};
use crate::plant::{Axis, ServoAxisData};
use crate::products::{Product, fit};
use master::bus::simulated::{Bus, Handle};
use master::{Failure, Master};

/// 1018h:4 of the drive.
const SERIAL_NUMBER: u32 = 0x00C0_FFEE;

/// How long a change of state may take, and a move: some drives are slow by default.
const STATE_TIME: Duration = Duration::from_ticks(500_000);
const MOVE_TIME: Duration = Duration::from_ticks(60_000_000);

/// From a look at the statusword to the next.
const LOOK: Duration = Duration::from_ticks(50_000);

/// The statusword, what it is made of.
const STATE: u16 = 0x6F;
const TARGET_REACHED: u16 = 1 << 10;
const ACKNOWLEDGED: u16 = 1 << 12;

/// Plays the demonstration of this product on virtual time, on an axis with a servo if there is one.
///
/// # Errors
/// The step that failed.
pub fn play(product: Product, axis: Option<ServoAxisData>, node: u8) -> Result<Story, Failure> {
    product.visit(Play(node, axis))
}

/// Plays the demonstration of the drive on this axis on virtual time: a move, back, and a tenth of the rated torque.
///
/// # Errors
/// The step that failed.
pub fn play_axis(axis: &ServoAxisData, node: u8) -> Result<Story, Failure> {
    let setup = Setup {
        axis: Some(Axis::servo(axis)),
        ..Setup::with_node_id(SERIAL_NUMBER, node)
    };
    let mut script = Script::on(ServoDrive::new(setup), node);
    script.meet()?;
    script.enable()?;
    script.move_to(TARGET)?;
    script.move_to(0)?;
    script.give_torque(100)?;
    script.switch_off()?;
    Ok(script.story())
}

struct Play(u8, Option<ServoAxisData>);

impl products::Visitor for Play {
    type Output = Result<Story, Failure>;

    fn visit<D>(self) -> Self::Output
    where
        D: Behaves + Default + std::fmt::Debug + 'static,
    {
        let setup = Setup::with_node_id(SERIAL_NUMBER, self.0);
        let Self(node, Some(mut servo)) = self else {
            return go_there_and_back(VirtualDrive::<D, StepAxis>::new(setup), self.0);
        };
        fit::<D>(&mut servo);
        let setup = Setup {
            axis: Some(Axis::bare_servo(&servo)),
            ..setup
        };
        go_there_and_back(VirtualDrive::<D, ServoAxis>::new(setup), node)
    }
}

fn go_there_and_back<D, A>(drive: VirtualDrive<D, A>, node: u8) -> Result<Story, Failure>
where
    D: Behaves + Default + std::fmt::Debug + 'static,
    A: Moving,
{
    let mut script = Script::on(drive, node);
    script.meet()?;
    script.enable()?;
    script.move_to(TARGET)?;
    script.move_to(0)?;
    script.switch_off()?;
    Ok(script.story())
}

struct Script<D: Behaves, A> {
    master: Master,
    drive: Handle<VirtualDrive<D, A>>,
    node: u8,
    chapters: Vec<Chapter>,
    arrivals: Vec<(i32, i32)>,
    torques: Vec<(i16, i16)>,
}

impl<D, A> Script<D, A>
where
    D: Behaves + Default + std::fmt::Debug + 'static,
    A: Moving,
{
    fn on(mut drive: VirtualDrive<D, A>, node: u8) -> Self {
        let mut master = Master::new(Bus::new(BitRate::Kbit1000));
        drive.record_motion();
        let drive = master.bus_mut().attach(drive);
        Self {
            master,
            drive,
            node,
            chapters: Vec::new(),
            arrivals: Vec::new(),
            torques: Vec::new(),
        }
    }

    /// Profile torque, which the friction of the machine holds.
    fn give_torque(&mut self, target: i16) -> Result<(), Failure> {
        self.master.write(self.node, 0x6060, 0, 4i8)?;
        // The bit of the move before goes with its mode.
        self.master.run_for(STATE_TIME);
        self.master.write(self.node, 0x6071, 0, target)?;
        self.master.run_for(LOOK);
        self.wait_for(TARGET_REACHED, TARGET_REACHED, MOVE_TIME)?;
        self.master.run_for(LOOK);
        let torque = self.master.read(self.node, 0x6077, 0)?;
        self.torques.push((target, torque));
        self.master.write(self.node, 0x6071, 0, 0i16)?;
        self.master.run_for(STATE_TIME);
        self.end_chapter("SDO: profile torque, a tenth of the rated one");
        Ok(())
    }

    fn meet(&mut self) -> Result<(), Failure> {
        self.master.expect_boot_up(self.node, STATE_TIME)?;
        self.master.read::<u32>(self.node, 0x1018, 1)?;
        // Not every maker gives the device type its 32 bits.
        self.master.read::<Vec<u8>>(self.node, 0x1000, 0)?;
        self.end_chapter("SDO: who are you?");
        Ok(())
    }

    fn enable(&mut self) -> Result<(), Failure> {
        self.master.write(self.node, 0x6060, 0, 1i8)?;
        for (controlword, state) in [(0x06_u16, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
            self.master.write(self.node, 0x6040, 0, controlword)?;
            self.wait_for(STATE, state, STATE_TIME)?;
        }
        self.end_chapter("SDO: profile position, and through the states");
        Ok(())
    }

    fn move_to(&mut self, target: i32) -> Result<(), Failure> {
        if self.master.read::<u32>(self.node, 0x6081, 0)? < 1_000 {
            self.master.write(self.node, 0x6081, 0, 20_000_u32)?;
        }
        self.master.write(self.node, 0x607A, 0, target)?;
        self.master.write(self.node, 0x6040, 0, 0x1F_u16)?;
        self.wait_for(ACKNOWLEDGED, ACKNOWLEDGED, STATE_TIME)?;
        self.master.write(self.node, 0x6040, 0, 0x0F_u16)?;
        self.wait_for(ACKNOWLEDGED | TARGET_REACHED, TARGET_REACHED, MOVE_TIME)?;
        let position = self.stand_still()?;
        self.arrivals.push((target, position));
        self.end_chapter(&format!("SDO: move to {target}"));
        Ok(())
    }

    /// A position window may be wide: the target counts as reached before the motor stands, and a servo takes the last
    /// count out of the friction by its integral.
    fn stand_still(&mut self) -> Result<i32, Failure> {
        let mut last = self.master.read(self.node, 0x6064, 0)?;
        loop {
            self.master.run_for(STATE_TIME);
            let position = self.master.read(self.node, 0x6064, 0)?;
            if position == last {
                return Ok(position);
            }
            last = position;
        }
    }

    fn switch_off(&mut self) -> Result<(), Failure> {
        self.master.write(self.node, 0x6040, 0, 0x06_u16)?;
        self.wait_for(STATE, 0x21, STATE_TIME)?;
        self.end_chapter("SDO: power off");
        Ok(())
    }

    fn wait_for(&mut self, mask: u16, value: u16, within: Duration) -> Result<(), Failure> {
        let end = self.master.now() + within;
        loop {
            let statusword: u16 = self.master.read(self.node, 0x6041, 0)?;
            if statusword & mask == value {
                return Ok(());
            }
            if self.master.now() > end {
                return Err(Failure::WrongValue {
                    expected: format!("statusword {value:04X}h under mask {mask:04X}h"),
                    got: format!("{statusword:04X}h"),
                });
            }
            self.master.run_for(LOOK);
        }
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
            arrivals: self.arrivals,
            torques: self.torques,
        }
    }
}
