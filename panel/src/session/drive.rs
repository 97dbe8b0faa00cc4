//! What moves the drive: transitions, modes, moves, jog, and above all the stop (CiA 402-2).

use canopen::Duration;
use master::axis402::{Description, Node, Problem};
use master::data_sheet::Address;
use master::{Line, NmtCommand, tuning};

use super::poll::{Chosen, SetPointOf, modes, unit};
use super::scope::has_recorder;
use super::tuning::Known;
use super::{Session, nodes};
use crate::fsa::{DriveState, Transition};
use crate::message::{Answer, Drive};

/// How long a transition may take; a brake takes its time.
const STATE_TIME: Duration = Duration::from_ticks(3_000_000);

/// How long a change of mode, or the acceptance of a set-point, may take.
const ACCEPT_TIME: Duration = Duration::from_ticks(1_000_000);

/// From a question to the next while one waits.
const PAUSE: Duration = Duration::from_ticks(3_000);

/// How long the answer to a stop may take, and how often it is tried. Then the node is stopped by NMT.
pub(super) const STOP_TIME: Duration = Duration::from_ticks(100_000);
const STOP_ATTEMPTS: u32 = 3;

/// Bits of the controlword.
const NEW_SET_POINT: u16 = 1 << 4;
const IMMEDIATELY: u16 = 1 << 5;
const RELATIVE: u16 = 1 << 6;
const HALT: u16 = 1 << 8;
const ENABLED: u16 = 0x0F;

/// Bit 12 of the statusword: the set-point was taken.
const ACKNOWLEDGED: u16 = 1 << 12;

/// Modes of operation.
pub(super) const PROFILE_POSITION: i8 = 1;
const PROFILE_VELOCITY: i8 = 3;
pub(super) const HOMING: i8 = 6;

/// A stop is for the drive that is open: of another one the panel has given nothing power.
const NOTHING_STOPPED: &str =
    "nothing was stopped: no drive is open. The page of the bus stops nodes by NMT";

/// The abort code for "nobody waits any longer" (CiA 301, table 22).
const GIVEN_UP: u32 = 0x0800_0000;

impl<L: Line> Session<L> {
    /// Shows this node on the page of the drive. Another one is left first.
    pub(super) fn choose(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        if self
            .chosen
            .as_ref()
            .is_some_and(|chosen| chosen.node.id == id)
        {
            return Ok(Answer::Text(String::new()));
        }
        let description = Description::ask(&mut self.master, id)?;
        let told = &mut self.traffic.node_mut(id).told;
        nodes::describe(told, &description);
        if !told.is_drive {
            return Err(Problem::Failed(format!("node {id} is no drive of CiA 402")));
        }
        self.leave_drive();
        let supported = self.optional(&node, 0x6502)?.unwrap_or_default();
        let position = unit(self.optional(&node, 0x60A8)?, "units");
        let velocity = unit(self.optional(&node, 0x60A9)?, "units/s");
        let acceleration = unit(self.optional(&node, 0x60AA)?, "units/s²");
        let drive = Drive {
            node: id,
            name: description.name.unwrap_or_else(|| format!("node {id}")),
            modes: modes(supported),
            units: [position, velocity, acceleration],
            has_recorder: has_recorder(&node.sheet),
            can_tune: tuning::is_possible(&node.sheet),
            answers: true,
            ..Drive::default()
        };
        let drive = Drive {
            homing: self.read_homing(&node, supported)?,
            ..drive
        };
        let now = self.master.now();
        self.chosen = Some(Chosen::new(node, drive, now));
        self.live = None;
        self.known = Known::default();
        if self.state.notice.as_deref() == Some(NOTHING_STOPPED) {
            self.state.notice = None;
        }
        Ok(Answer::Text(String::new()))
    }

    pub(super) fn chosen_node(&self) -> Result<Node, Problem> {
        let chosen = self.chosen.as_ref().map(|chosen| chosen.node.clone());
        chosen.ok_or_else(|| Problem::Usage("no drive is chosen".to_owned()))
    }

    /// One transition; it is there when the statusword says so.
    pub(super) fn transition(&mut self, transition: Transition) -> Result<Answer, Problem> {
        let state = self.drive_state()?;
        let legal = state.transitions();
        let Some(way) = legal.iter().find(|way| way.transition == transition) else {
            let label = transition.label();
            return Err(Problem::Usage(format!(
                "{label} leads nowhere in this state"
            )));
        };
        if transition == Transition::EnableOperation {
            self.prepare()?;
        }
        if transition == Transition::FaultReset {
            // The reset is an edge.
            self.controlword(0)?;
        }
        self.controlword(transition.controlword())?;
        // A quick stop may be over, and the power off, before anybody looks.
        let is_there = |now| {
            now == way.to
                || transition == Transition::QuickStop && now == DriveState::SwitchOnDisabled
        };
        self.wait_for_state(is_there)?;
        Ok(Answer::Text(String::new()))
    }

    /// All transitions to Operation enabled.
    pub(super) fn enable(&mut self) -> Result<Answer, Problem> {
        let mut state = self.drive_state()?;
        while state != DriveState::OperationEnabled {
            let next = state.towards_enabled().ok_or_else(|| {
                Problem::Failed(match state {
                    DriveState::Fault => "the drive has a fault: reset it first".to_owned(),
                    _ => "the drive is not ready to be enabled".to_owned(),
                })
            })?;
            self.transition(next)?;
            state = self.drive_state()?;
        }
        Ok(Answer::Text(String::new()))
    }

    pub(super) fn set_mode(&mut self, mode: i8) -> Result<Answer, Problem> {
        let node = self.chosen_node()?;
        if self.read_mode(&node)? == mode {
            return Ok(Answer::Text(String::new()));
        }
        self.set(&node, 0x6060, &[mode as u8])?;
        let end = self.master.now() + ACCEPT_TIME;
        while self.read_mode(&node)? != mode {
            if self.master.now() >= end {
                let text = format!("node {} does not take mode {mode}", node.id);
                return Err(Problem::Failed(text));
            }
            self.master.wait(PAUSE)?;
        }
        Ok(Answer::Text(String::new()))
    }

    /// A move in profile position mode; it is under way when this returns.
    pub(super) fn go(
        &mut self,
        target: i32,
        relative: bool,
        profile: [Option<u32>; 3],
    ) -> Result<Answer, Problem> {
        self.must_be_enabled()?;
        self.prepare()?;
        let node = self.chosen_node()?;
        self.set_mode(PROFILE_POSITION)?;
        for (index, value) in [0x6081, 0x6083, 0x6084].into_iter().zip(profile) {
            if let Some(value) = value {
                self.set(&node, index, &value.to_le_bytes())?;
            }
        }
        self.set(&node, 0x607A, &target.to_le_bytes())?;
        let word = ENABLED | IMMEDIATELY | if relative { RELATIVE } else { 0 };
        self.controlword(word)?;
        self.wait_for_bit(ACKNOWLEDGED, false)?;
        self.controlword(word | NEW_SET_POINT)?;
        self.wait_for_bit(ACKNOWLEDGED, true)?;
        self.controlword(word)?;
        Ok(Answer::Text(String::new()))
    }

    /// A velocity or a torque, in the mode at work. It counts until another one comes, or a stop.
    pub(super) fn set_point(&mut self, value: i32) -> Result<Answer, Problem> {
        self.must_be_enabled()?;
        self.prepare()?;
        let node = self.chosen_node()?;
        let of = SetPointOf::mode(self.read_mode(&node)?).ok_or_else(|| {
            let text = "the mode at work has no set-point of velocity or torque";
            Problem::Usage(text.to_owned())
        })?;
        if of.length == 2 && i16::try_from(value).is_err() {
            let text = format!("{value} does not fit into 16 bits");
            return Err(Problem::Usage(text));
        }
        let bytes = value.to_le_bytes();
        self.set(&node, of.index, bytes.get(..of.length).unwrap_or(&bytes))?;
        self.controlword(of.controlword)?;
        Ok(Answer::Text(String::new()))
    }

    /// Runs until the button is released. `releases` is how many there had been when it was pressed: it may be up again.
    pub(super) fn jog(&mut self, velocity: i32, releases: u64) -> Result<Answer, Problem> {
        if self.desk.counts().releases != releases {
            return Ok(Answer::Text("released".to_owned()));
        }
        self.must_be_enabled()?;
        self.prepare()?;
        let node = self.chosen_node()?;
        let knows = |chosen: &Chosen| {
            let mut modes = chosen.drive.modes.iter();
            modes.any(|mode| mode.number == PROFILE_VELOCITY)
        };
        if !self.chosen.as_ref().is_some_and(knows) {
            let text = "the drive has no profile velocity mode: it cannot be jogged";
            return Err(Problem::Failed(text.to_owned()));
        }
        self.master.line_mut().set_jogged(true);
        if let Some(chosen) = &mut self.chosen {
            chosen.drive.jogging = true;
        }
        let started = self.begin_jog(&node, velocity);
        // One that was broken off is ended by what broke it off.
        if started.is_err() && !self.master.line_mut().urgent().any() {
            self.end_jog();
        }
        started.map(|()| Answer::Text(String::new()))
    }

    fn begin_jog(&mut self, node: &Node, velocity: i32) -> Result<(), Problem> {
        self.set_mode(PROFILE_VELOCITY)?;
        self.set(node, 0x60FF, &velocity.to_le_bytes())?;
        self.controlword(ENABLED)
    }

    /// The drive halts (605Dh), and nothing goes on when the halt is over.
    pub(super) fn end_jog(&mut self) {
        self.master.line_mut().set_jogged(false);
        let Some(chosen) = self.chosen.as_mut().filter(|chosen| chosen.drive.jogging) else {
            return;
        };
        chosen.drive.jogging = false;
        let node = chosen.node.clone();
        let halted = self.at_once(&node, |session| {
            session.controlword(ENABLED | HALT)?;
            session.set(&node, 0x60FF, &[0; 4])
        });
        if halted.is_err() {
            self.stop();
        }
    }

    /// Homes as it is set up (6098h, 6099h, 609Ah).
    pub(super) fn home(&mut self) -> Result<Answer, Problem> {
        self.must_be_enabled()?;
        self.prepare()?;
        self.set_mode(HOMING)?;
        self.controlword(ENABLED)?;
        self.master.wait(PAUSE)?;
        self.controlword(ENABLED | NEW_SET_POINT)?;
        Ok(Answer::Text(String::new()))
    }

    /// Stops the drive with its quick stop (605Ah, 6085h), whatever it is at. A node that does not answer is stopped by NMT, and does what
    /// its 6007h says.
    pub(super) fn stop(&mut self) {
        self.master.line_mut().set_jogged(false);
        if self.setup.read_only {
            return;
        }
        let Some(chosen) = &mut self.chosen else {
            self.state.notice = Some(NOTHING_STOPPED.to_owned());
            return;
        };
        chosen.drive.jogging = false;
        let node = chosen.node.clone();
        let stopped = self.at_once(&node, |session| {
            session.controlword(Transition::QuickStop.controlword())
        });
        self.state.notice = match stopped {
            Ok(()) => None,
            Err(problem) => {
                self.master.nmt(NmtCommand::Stop, node.id);
                let why = problem.line().unwrap_or_default();
                Some(format!(
                    "the stop was not acknowledged ({why}); node {} was stopped by NMT",
                    node.id
                ))
            }
        };
    }

    /// Does something that nothing breaks off, and soon. A transfer that was under way is given up.
    fn at_once(
        &mut self,
        node: &Node,
        mut work: impl FnMut(&mut Self) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        self.master.line_mut().set_interruptible(false);
        let usual = self.master.set_answer_time(STOP_TIME);
        self.master.abort_sdo(node.id, 0, 0, GIVEN_UP);
        let mut result = work(self);
        for _ in 1..STOP_ATTEMPTS {
            if result.is_ok() {
                break;
            }
            result = work(self);
        }
        self.master.set_answer_time(usual);
        self.master.line_mut().set_interruptible(true);
        result
    }

    /// Nobody looks at the drive any more: it stops if the panel has given it power, and 1016h is as it was.
    pub(super) fn leave_drive(&mut self) {
        if self.setup.read_only {
            return;
        }
        let has_power = |chosen: &Chosen| chosen.drive.state.is_some_and(DriveState::has_power);
        let Some(chosen) = &mut self.chosen else {
            return;
        };
        if std::mem::take(&mut chosen.has_enabled) && has_power(chosen) {
            self.stop();
        }
        self.master.line_mut().set_interruptible(false);
        self.put_guard_back();
        self.master.line_mut().set_interruptible(true);
    }

    /// Before the drive gets power, or moves: it watches the panel, and is operational.
    pub(super) fn prepare(&mut self) -> Result<(), Problem> {
        // It may just have started anew.
        self.follow_traffic();
        self.ensure_guard()?;
        let Some(chosen) = &mut self.chosen else {
            return Ok(());
        };
        chosen.has_enabled = true;
        let id = chosen.node.id;
        let is_operational = |known: &crate::traffic::Known| known.state == Some(0x05);
        if !self.traffic.node(id).is_some_and(is_operational) {
            self.master.nmt(NmtCommand::Start, id);
        }
        Ok(())
    }

    fn must_be_enabled(&mut self) -> Result<(), Problem> {
        match self.drive_state()? {
            DriveState::OperationEnabled => Ok(()),
            _ => Err(Problem::Failed(
                "the drive has no power: enable it first".to_owned(),
            )),
        }
    }

    pub(super) fn drive_state(&mut self) -> Result<DriveState, Problem> {
        self.chosen_node()?;
        let word = self.statusword()?;
        DriveState::of(word).ok_or_else(|| {
            Problem::Failed(format!("statusword {word:04X}h is no state of CiA 402"))
        })
    }

    fn wait_for_state(&mut self, is_there: impl Fn(DriveState) -> bool) -> Result<(), Problem> {
        let end = self.master.now() + STATE_TIME;
        loop {
            let state = self.drive_state()?;
            if is_there(state) {
                return Ok(());
            }
            if state == DriveState::Fault {
                return Err(Problem::Failed("the drive has a fault".to_owned()));
            }
            if self.master.now() >= end {
                let text = "the drive did not follow the command".to_owned();
                return Err(Problem::Failed(text));
            }
            self.master.wait(PAUSE)?;
        }
    }

    fn wait_for_bit(&mut self, bit: u16, wanted: bool) -> Result<(), Problem> {
        let end = self.master.now() + ACCEPT_TIME;
        while (self.statusword()? & bit != 0) != wanted {
            if self.master.now() >= end {
                let text = "the drive did not take the set-point".to_owned();
                return Err(Problem::Failed(text));
            }
            self.master.wait(PAUSE)?;
        }
        Ok(())
    }

    fn read_mode(&mut self, node: &Node) -> Result<i8, Problem> {
        let mode = self.optional(node, 0x6061)?.unwrap_or_default() as i8;
        if let Some(chosen) = &mut self.chosen {
            chosen.drive.mode = Some(mode);
        }
        Ok(mode)
    }

    fn controlword(&mut self, word: u16) -> Result<(), Problem> {
        let node = self.chosen_node()?;
        self.set(&node, 0x6040, &word.to_le_bytes())
    }

    fn set(&mut self, node: &Node, index: u16, bytes: &[u8]) -> Result<(), Problem> {
        node.download(&mut self.master, Address::new(index, 0), bytes)
            .map_err(|failure| Problem::with_node(node.id, failure))
    }
}
