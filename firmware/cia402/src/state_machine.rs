//! The state machine of CiA 402-2: eight states, sixteen transitions, one table.
//!
//! It takes at most one transition in a control tick, so every state it passes is published at least once. The drive lets quick stop
//! active and fault reaction active last until a transmit PDO has shown them, even when the motor stands already. "Enable operation" in ready to switch on
//! is transition 3 in one tick and transition 4 in the next.
//!
//! Transition 0 (start to not ready to switch on) is [`StateMachine::new`].
//!
//! What the option codes leave open:
//! - disable operation (605Ch) and shutdown (605Bh): with a ramp, transitions 5 and 8 follow once the motor stands; with
//!   power off they follow at once.
//! - fault reaction (605Eh): transition 14 follows once the motor stands; "disable voltage" takes the power away before that.
//! - transition 16 needs an option code that stays, and the motor at rest: a quick stop is never cut short.
//! - no remote control, where 6007h does not say otherwise: as the command "quick stop" with option code 2, for as long as it
//!   lasts; but "disable voltage" is obeyed.

use canopen::Instant;

use crate::controlword::Command;
use crate::option_codes::QuickStopOption;

/// A state of the drive (CiA 402-2, "power drive system state machine").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are the standard's own")]
pub enum State {
    NotReadyToSwitchOn,
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    FaultReactionActive,
    Fault,
}

impl State {
    /// All states.
    pub const ALL: [Self; 8] = [
        Self::NotReadyToSwitchOn,
        Self::SwitchOnDisabled,
        Self::ReadyToSwitchOn,
        Self::SwitchedOn,
        Self::OperationEnabled,
        Self::QuickStopActive,
        Self::FaultReactionActive,
        Self::Fault,
    ];

    /// The bits of the statusword that code the state.
    pub(crate) const BITS: u16 = 0x6F;

    /// Its coding in bits 0 to 3, 5 and 6 of the statusword.
    pub const fn statusword(self) -> u16 {
        match self {
            Self::NotReadyToSwitchOn => 0x00,
            Self::SwitchOnDisabled => 0x40,
            Self::ReadyToSwitchOn => 0x21,
            Self::SwitchedOn => 0x23,
            Self::OperationEnabled => 0x27,
            Self::QuickStopActive => 0x07,
            Self::FaultReactionActive => 0x0F,
            Self::Fault => 0x08,
        }
    }

    /// The state a statusword codes, under the masks of the standard.
    pub const fn from_statusword(statusword: u16) -> Option<Self> {
        match (statusword & 0x4F, statusword & 0x6F) {
            (0x00, _) => Some(Self::NotReadyToSwitchOn),
            (0x40, _) => Some(Self::SwitchOnDisabled),
            (0x0F, _) => Some(Self::FaultReactionActive),
            (0x08, _) => Some(Self::Fault),
            (_, 0x21) => Some(Self::ReadyToSwitchOn),
            (_, 0x23) => Some(Self::SwitchedOn),
            (_, 0x27) => Some(Self::OperationEnabled),
            (_, 0x07) => Some(Self::QuickStopActive),
            _ => None,
        }
    }

    /// Whether the drive leaves it by itself, perhaps at once: masters are to see it all the same.
    pub(crate) const fn is_transient(self) -> bool {
        matches!(self, Self::QuickStopActive | Self::FaultReactionActive)
    }

    /// Whether there may be current in the motor.
    pub const fn may_have_power(self) -> bool {
        matches!(
            self,
            Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive
        )
    }
}

/// What makes a transition happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// The next control tick.
    Automatic,
    /// This command.
    Command(Command),
    /// This command, once the motor stands, or at once if its option code says so.
    AtStandstill(Command),
    /// Quick stop completed: the motor stands, and the option code does not stay.
    QuickStopCompleted,
    /// Enable operation, once the motor stands, with an option code that stays.
    Resume,
    /// A fault appeared.
    Fault,
    /// Fault reaction completed: the motor stands.
    ReactionCompleted,
    /// The rising edge of bit 7, with no cause of a fault left.
    FaultReset,
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// Its number in the standard, 1 to 16.
    pub number: u8,
    /// The state it leaves.
    pub from: State,
    /// The state it enters.
    pub to: State,
    /// What makes it happen.
    pub trigger: Trigger,
}

const fn row(number: u8, from: State, to: State, trigger: Trigger) -> Transition {
    Transition {
        number,
        from,
        to,
        trigger,
    }
}

/// Every transition, the more urgent first. A number stands in several rows where it has several states or triggers.
pub const TRANSITIONS: [Transition; 25] = {
    use Command::{DisableVoltage, EnableOperation, QuickStop, Shutdown, SwitchOn};
    use State::{
        Fault, FaultReactionActive, NotReadyToSwitchOn, OperationEnabled, QuickStopActive,
        ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn,
    };
    use Trigger::{
        AtStandstill, Automatic, FaultReset, QuickStopCompleted, ReactionCompleted, Resume,
    };
    [
        row(13, NotReadyToSwitchOn, FaultReactionActive, Trigger::Fault),
        row(13, SwitchOnDisabled, FaultReactionActive, Trigger::Fault),
        row(13, ReadyToSwitchOn, FaultReactionActive, Trigger::Fault),
        row(13, SwitchedOn, FaultReactionActive, Trigger::Fault),
        row(13, OperationEnabled, FaultReactionActive, Trigger::Fault),
        row(13, QuickStopActive, FaultReactionActive, Trigger::Fault),
        row(14, FaultReactionActive, Fault, ReactionCompleted),
        row(15, Fault, SwitchOnDisabled, FaultReset),
        row(1, NotReadyToSwitchOn, SwitchOnDisabled, Automatic),
        row(
            2,
            SwitchOnDisabled,
            ReadyToSwitchOn,
            Trigger::Command(Shutdown),
        ),
        row(3, ReadyToSwitchOn, SwitchedOn, Trigger::Command(SwitchOn)),
        row(
            3,
            ReadyToSwitchOn,
            SwitchedOn,
            Trigger::Command(EnableOperation),
        ),
        row(
            4,
            SwitchedOn,
            OperationEnabled,
            Trigger::Command(EnableOperation),
        ),
        row(5, OperationEnabled, SwitchedOn, AtStandstill(SwitchOn)),
        row(6, SwitchedOn, ReadyToSwitchOn, Trigger::Command(Shutdown)),
        row(
            7,
            ReadyToSwitchOn,
            SwitchOnDisabled,
            Trigger::Command(QuickStop),
        ),
        row(
            7,
            ReadyToSwitchOn,
            SwitchOnDisabled,
            Trigger::Command(DisableVoltage),
        ),
        row(8, OperationEnabled, ReadyToSwitchOn, AtStandstill(Shutdown)),
        row(
            9,
            OperationEnabled,
            SwitchOnDisabled,
            Trigger::Command(DisableVoltage),
        ),
        row(
            10,
            SwitchedOn,
            SwitchOnDisabled,
            Trigger::Command(QuickStop),
        ),
        row(
            10,
            SwitchedOn,
            SwitchOnDisabled,
            Trigger::Command(DisableVoltage),
        ),
        row(
            11,
            OperationEnabled,
            QuickStopActive,
            Trigger::Command(QuickStop),
        ),
        row(
            12,
            QuickStopActive,
            SwitchOnDisabled,
            Trigger::Command(DisableVoltage),
        ),
        row(12, QuickStopActive, SwitchOnDisabled, QuickStopCompleted),
        row(16, QuickStopActive, OperationEnabled, Resume),
    ]
};

/// What the state machine looks at in one control tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// The state command that is given; see [`Command::decode`].
    pub command: Option<Command>,
    /// The network may command the drive (statusword bit 9). While it may not, of `command` only "disable voltage" counts.
    pub remote: bool,
    /// 605Ah; it counts at transition 11.
    pub quick_stop: QuickStopOption,
    /// 605Bh and 605Ch: whether the power goes off at once where operation enabled is left by `command`.
    pub at_once: bool,
    /// The motor stands and no pulse is on its way; where power is to go off, it is held by something else.
    pub standstill: bool,
    /// A fault appeared since the last tick.
    pub fault: bool,
    /// Bit 7 rose since the last tick, and no cause of a fault is left.
    pub fault_reset: bool,
}

/// How far the drive has come in its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// It has entered the state.
    Entered,
    /// Operation is enabled, as was ordered, and nothing waits.
    Settled,
    /// This command to leave operation enabled waits for the motor to stand.
    Leaving(Command),
    /// The fault reaction is over; the state lasts until a transmit PDO has shown it.
    Shown,
    /// The same, or fault, and the master has reset the fault while it was shown.
    Reset,
}

/// The state, how far the drive has come in it, and the quick stop option that is being carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMachine {
    state: State,
    progress: Progress,
    entered: Instant,
    quick_stop: QuickStopOption,
}

impl StateMachine {
    /// Transition 0: not ready to switch on.
    pub const fn new() -> Self {
        Self {
            state: State::NotReadyToSwitchOn,
            progress: Progress::Entered,
            entered: Instant::from_ticks(0),
            quick_stop: QuickStopOption::QuickStopRamp,
        }
    }

    /// The state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// How far the drive has come in it.
    pub(crate) const fn progress(&self) -> Progress {
        self.progress
    }

    /// When the state began.
    pub(crate) const fn entered(&self) -> Instant {
        self.entered
    }

    /// The command to leave operation enabled that waits for the motor to stand.
    pub(crate) const fn pending(&self) -> Option<Command> {
        match self.progress {
            Progress::Leaving(command) => Some(command),
            _ => None,
        }
    }

    /// Takes a command of the master. One that leaves operation enabled by 605Bh or 605Ch waits for the motor to stand.
    pub(crate) fn order(&mut self, command: Command) {
        if self.state == State::OperationEnabled {
            self.progress = match command {
                Command::Shutdown | Command::SwitchOn => Progress::Leaving(command),
                _ => Progress::Entered,
            };
        }
    }

    /// Notes whether operation is enabled as was ordered, and nothing waits.
    pub(crate) fn settle(&mut self, is_settled: bool) {
        if is_settled && self.state == State::OperationEnabled {
            self.progress = Progress::Settled;
        } else if self.progress == Progress::Settled {
            self.progress = Progress::Entered;
        }
    }

    /// Takes a fault reset that came while the reaction was over and lasted only to be shown. It takes effect in the state fault, where this
    /// returns true; in fault reaction active an `edge` of bit 7 is kept until then, unless another fault `is_new`.
    pub(crate) fn take_fault_reset(
        &mut self,
        edge: bool,
        is_only_shown: bool,
        is_new: bool,
    ) -> bool {
        if self.state != State::FaultReactionActive {
            let resets = self.progress == Progress::Reset;
            if resets {
                self.progress = Progress::Entered;
            }
            return resets;
        }
        let was_shown = matches!(self.progress, Progress::Shown | Progress::Reset);
        let resets = self.progress == Progress::Reset || edge && (is_only_shown || was_shown);
        self.progress = if resets && !is_new {
            Progress::Reset
        } else if is_only_shown {
            Progress::Shown
        } else {
            Progress::Entered
        };
        false
    }

    /// The option code of the quick stop that is under way; outside quick stop active, of the last one.
    pub const fn quick_stop(&self) -> QuickStopOption {
        self.quick_stop
    }

    /// One control tick, at `now`: takes the first row of [`TRANSITIONS`] that applies, and returns it.
    pub fn step(&mut self, now: Instant, conditions: &Conditions) -> Option<Transition> {
        let mut seen = *conditions;
        if !seen.remote {
            if seen.command != Some(Command::DisableVoltage) {
                seen.command = Some(Command::QuickStop);
            }
            seen.quick_stop = QuickStopOption::QuickStopRamp;
            self.quick_stop = QuickStopOption::QuickStopRamp;
        }
        let triggers = seen.triggers(self.quick_stop.stays());
        // In most ticks nothing happens: the table is not searched for that.
        if triggers & leading_out_of(self.state) == 0 {
            return None;
        }
        let transition = TRANSITIONS
            .iter()
            .find(|row| row.from == self.state && triggers & row.trigger.bit() != 0)?;
        if transition.to == State::QuickStopActive {
            self.quick_stop = seen.quick_stop;
        }
        self.state = transition.to;
        self.entered = now;
        // A reset counts in the state behind the reaction.
        if !(self.state == State::Fault && self.progress == Progress::Reset) {
            self.progress = Progress::Entered;
        }
        Some(*transition)
    }
}

impl Default for StateMachine {
    fn default() -> Self {
        Self::new()
    }
}

/// Commands in [`Trigger::bit`].
const COMMAND: u32 = 1;
/// Commands at standstill, behind the five commands.
const AT_STANDSTILL: u32 = COMMAND + 5;

impl Trigger {
    /// A bit for each trigger.
    const fn bit(self) -> u32 {
        let number = match self {
            Self::Automatic => 0,
            Self::Command(command) => COMMAND.wrapping_add(command as u32),
            Self::AtStandstill(command) => AT_STANDSTILL.wrapping_add(command as u32),
            Self::QuickStopCompleted => 11,
            Self::Resume => 12,
            Self::Fault => 13,
            Self::ReactionCompleted => 14,
            Self::FaultReset => 15,
        };
        1_u32.wrapping_shl(number)
    }
}

impl Conditions {
    /// The bits of all triggers that are there. `stays` tells of the quick stop under way.
    fn triggers(&self, stays: bool) -> u32 {
        let bit = |is_there: bool, trigger: Trigger| if is_there { trigger.bit() } else { 0 };
        let command = self
            .command
            .map_or(0, |given| 1_u32.wrapping_shl(given as u32));
        let may_leave = self.standstill || self.at_once;
        let resumes = stays && self.command == Some(Command::EnableOperation);
        bit(true, Trigger::Automatic)
            | command << COMMAND
            | if may_leave {
                command << AT_STANDSTILL
            } else {
                0
            }
            | bit(self.standstill && !stays, Trigger::QuickStopCompleted)
            | bit(self.standstill && resumes, Trigger::Resume)
            | bit(self.fault, Trigger::Fault)
            | bit(self.standstill, Trigger::ReactionCompleted)
            | bit(self.fault_reset, Trigger::FaultReset)
    }
}

/// The bits of the triggers that lead out of a state.
const fn triggers_out_of(state: State) -> u32 {
    let mut bits = 0;
    let mut rows = TRANSITIONS.as_slice();
    while let [row, rest @ ..] = rows {
        if row.from as u8 == state as u8 {
            bits |= row.trigger.bit();
        }
        rows = rest;
    }
    bits
}

/// The same, worked out by the compiler.
const fn leading_out_of(state: State) -> u32 {
    match state {
        State::NotReadyToSwitchOn => const { triggers_out_of(State::NotReadyToSwitchOn) },
        State::SwitchOnDisabled => const { triggers_out_of(State::SwitchOnDisabled) },
        State::ReadyToSwitchOn => const { triggers_out_of(State::ReadyToSwitchOn) },
        State::SwitchedOn => const { triggers_out_of(State::SwitchedOn) },
        State::OperationEnabled => const { triggers_out_of(State::OperationEnabled) },
        State::QuickStopActive => const { triggers_out_of(State::QuickStopActive) },
        State::FaultReactionActive => const { triggers_out_of(State::FaultReactionActive) },
        State::Fault => const { triggers_out_of(State::Fault) },
    }
}

#[cfg(test)]
mod tests;
