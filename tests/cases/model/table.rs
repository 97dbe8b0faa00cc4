//! The state machine of CiA 402-2 as an executable table: its states, transitions and option codes, written down a second time, from
//! the standard and from what `docs/decisions.md` says where that leaves a choice. It knows nothing of the drive.

use tests::drive::{
    FAULT, FAULT_REACTION_ACTIVE, NOT_READY_TO_SWITCH_ON, OPERATION_ENABLED, QUICK_STOP_ACTIVE,
    READY_TO_SWITCH_ON, SWITCH_ON_DISABLED, SWITCHED_ON, State as Shown,
};

/// Where the drive can be once it has started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    FaultReactionActive,
    Fault,
}

impl State {
    pub(super) fn is_shown_by(self, statusword: u16) -> bool {
        let shown: Shown = match self {
            Self::SwitchOnDisabled => SWITCH_ON_DISABLED,
            Self::ReadyToSwitchOn => READY_TO_SWITCH_ON,
            Self::SwitchedOn => SWITCHED_ON,
            Self::OperationEnabled => OPERATION_ENABLED,
            Self::QuickStopActive => QUICK_STOP_ACTIVE,
            Self::FaultReactionActive => FAULT_REACTION_ACTIVE,
            Self::Fault => FAULT,
        };
        shown.is_shown_by(statusword)
    }

    /// Whether there may be current in the motor.
    pub(super) fn may_have_power(self) -> bool {
        matches!(
            self,
            Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive
        )
    }
}

/// The state of the network as far as the drive is concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Network {
    PreOperational,
    Operational,
    Stopped,
    /// On the way to a new boot-up; with the application (reset node) or without (reset communication).
    Resetting {
        is_node: bool,
    },
}

/// 6007h, 605Ah, 605Bh, 605Ch, 605Eh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Options {
    pub(super) abort_connection: i16,
    pub(super) quick_stop: i16,
    pub(super) shutdown: i16,
    pub(super) disable_operation: i16,
    pub(super) fault_reaction: i16,
}

impl Options {
    /// As the data sheet has them.
    const DEFAULT: Self = Self {
        abort_connection: 3,
        quick_stop: 2,
        shutdown: 0,
        disable_operation: 1,
        fault_reaction: 2,
    };
}

/// What bits 0 to 3 and 7 of a controlword ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Command {
    Shutdown,
    /// In operation enabled: disable operation.
    SwitchOn,
    EnableOperation,
    QuickStop,
    DisableVoltage,
}

impl Command {
    fn of(controlword: u16) -> Option<Self> {
        match controlword & 0x8F {
            low if low & 0x80 != 0 => None,
            low if low & 0x02 == 0 => Some(Self::DisableVoltage),
            low if low & 0x04 == 0 => Some(Self::QuickStop),
            low if low & 0x01 == 0 => Some(Self::Shutdown),
            low if low & 0x08 == 0 => Some(Self::SwitchOn),
            _ => Some(Self::EnableOperation),
        }
    }
}

#[derive(Debug)]
pub(super) struct Table {
    pub(super) state: State,
    /// 6040h.
    controlword: u16,
    pub(super) options: Options,
    /// The quick stop under way: what is written meanwhile counts for the next one.
    running_quick_stop: i16,
    /// The fault reaction under way takes the power at once.
    cuts_power: bool,
    /// "Shutdown" or "disable operation" waits for the motor. A controlword with bit 7 does not take it back.
    pending: Option<Command>,
    pub(super) cause: bool,
    pub(super) network: Network,
    /// The loss of the network has been a fault already (6007h = 1).
    is_abandoned: bool,
    /// 6060h.
    pub(super) mode: i8,
}

impl Table {
    /// A drive in operation enabled, in profile position.
    pub(super) fn new() -> Self {
        Self {
            state: State::OperationEnabled,
            controlword: 0x0F,
            options: Options::DEFAULT,
            running_quick_stop: 2,
            cuts_power: false,
            pending: None,
            cause: false,
            network: Network::Operational,
            is_abandoned: false,
            mode: 1,
        }
    }

    /// Statusword bit 9.
    pub(super) fn is_remote(&self) -> bool {
        matches!(self.network, Network::Operational | Network::PreOperational)
    }

    /// Whether SDO is there.
    pub(super) fn has_sdo(&self) -> bool {
        self.is_remote()
    }

    /// Whether PDOs are.
    pub(super) fn has_pdos(&self) -> bool {
        self.network == Network::Operational
    }

    /// 6040h is written.
    pub(super) fn command(&mut self, controlword: u16) {
        let has_risen = controlword & !self.controlword & 0x80 != 0;
        self.controlword = controlword;
        // 15. A reset with the cause still there stays in fault.
        if has_risen && self.state == State::Fault && !self.cause {
            self.state = State::SwitchOnDisabled;
        }
    }

    /// NMT: start, stop, enter Pre-operational.
    pub(super) fn go(&mut self, network: Network) {
        if !matches!(self.network, Network::Resetting { .. }) {
            self.network = network;
        }
    }

    /// The device boots anew, now that the motor has no power.
    pub(super) fn booted(&mut self) {
        if self.network == (Network::Resetting { is_node: true }) {
            let cause = self.cause;
            *self = Self::new();
            self.state = State::SwitchOnDisabled; // 0 and 1
            self.controlword = 0;
            self.cause = cause;
        }
        self.network = Network::PreOperational;
    }

    /// Whether a statusword is one of a reset node that has begun anew, and has not yet said so: transitions 0, 1, and 13 where there is a fault.
    pub(super) fn begins_anew(&self, statusword: u16) -> bool {
        self.network == (Network::Resetting { is_node: true })
            && !self.has_power()
            && (NOT_READY_TO_SWITCH_ON.is_shown_by(statusword)
                || SWITCH_ON_DISABLED.is_shown_by(statusword)
                || self.cause && FAULT_REACTION_ACTIVE.is_shown_by(statusword))
    }

    /// Whether the motor still has to stop before the state can be left.
    pub(super) fn waits(&mut self, moves: bool) -> bool {
        moves && self.next(true) != self.next(false)
    }

    /// Takes every transition there is, one after the other; `moves` tells whether the motor does.
    pub(super) fn settle(&mut self, moves: bool, mut passed: impl FnMut(State)) {
        // No command leads through more states than there are.
        for _ in 0..8 {
            let Some(next) = self.next(moves) else {
                return;
            };
            self.enter(next);
            passed(next);
        }
        panic!("the table goes round and round: {self:?}");
    }

    fn enter(&mut self, next: State) {
        match next {
            State::QuickStopActive => {
                self.running_quick_stop = self.effective_quick_stop();
            }
            State::FaultReactionActive => {
                let has_power = self.has_power();
                self.cuts_power = !has_power || self.options.fault_reaction == 0;
                self.is_abandoned = self.network == Network::Stopped;
            }
            _ => {}
        }
        self.state = next;
    }

    pub(super) fn has_power(&self) -> bool {
        match self.state {
            State::OperationEnabled => true,
            State::QuickStopActive => self.running_quick_stop != 0,
            State::FaultReactionActive => !self.cuts_power,
            _ => false,
        }
    }

    /// What stands for the controlword: that of the master, or what its silence means.
    fn standing(&mut self) -> Option<Command> {
        let lost = match self.network {
            Network::Operational | Network::PreOperational => {
                self.is_abandoned = false;
                None
            }
            // A reset always stops the motor.
            Network::Resetting { .. } => Some(3),
            Network::Stopped => Some(self.options.abort_connection),
        };
        let given = Command::of(self.controlword);
        if self.state != State::OperationEnabled {
            self.pending = None;
        } else if given.is_some() {
            let leaves = matches!(given, Some(Command::Shutdown | Command::SwitchOn));
            self.pending = given.filter(|_| leaves);
        }
        match lost {
            None | Some(0) => given.or(self.pending),
            Some(2) => Some(Command::DisableVoltage),
            _ => Some(Command::QuickStop),
        }
    }

    /// 605Ah, but for a drive that nobody commands: it never stays.
    fn effective_quick_stop(&self) -> i16 {
        if self.is_quick_stopped() {
            2
        } else {
            self.options.quick_stop
        }
    }

    /// The loss of the network is a quick stop.
    fn is_quick_stopped(&self) -> bool {
        match self.network {
            Network::Operational | Network::PreOperational => false,
            Network::Resetting { .. } => true,
            Network::Stopped => matches!(self.options.abort_connection, 1 | 3),
        }
    }

    /// The table itself.
    fn next(&mut self, moves: bool) -> Option<State> {
        use Command::{DisableVoltage, EnableOperation, QuickStop, Shutdown, SwitchOn};
        use State::{
            Fault, FaultReactionActive, OperationEnabled, QuickStopActive, ReadyToSwitchOn,
            SwitchOnDisabled, SwitchedOn,
        };
        let command = self.standing();
        let is_lost_fault = self.network == Network::Stopped
            && self.options.abort_connection == 1
            && self.has_power()
            && !self.is_abandoned;
        let has_fault = self.cause || is_lost_fault;
        if has_fault && !matches!(self.state, Fault | FaultReactionActive) {
            return Some(FaultReactionActive); // 13
        }
        if self.is_quick_stopped() && self.state == QuickStopActive {
            self.running_quick_stop = match self.running_quick_stop {
                0 => 0,
                _ => 2,
            };
        }
        let stays = self.running_quick_stop >= 5;
        let stands = !moves;
        match (self.state, command) {
            (FaultReactionActive, _) if stands || self.cuts_power => Some(Fault), // 14
            (SwitchOnDisabled, Some(Shutdown)) => Some(ReadyToSwitchOn),          // 2
            (ReadyToSwitchOn, Some(SwitchOn | EnableOperation)) => Some(SwitchedOn), // 3
            (SwitchedOn, Some(EnableOperation)) => Some(OperationEnabled),        // 4
            (OperationEnabled, Some(SwitchOn)) if stands || self.options.disable_operation == 0 => {
                Some(SwitchedOn) // 5
            }
            (SwitchedOn, Some(Shutdown)) => Some(ReadyToSwitchOn), // 6
            (ReadyToSwitchOn, Some(QuickStop | DisableVoltage)) => Some(SwitchOnDisabled), // 7
            (OperationEnabled, Some(Shutdown)) if stands || self.options.shutdown == 0 => {
                Some(ReadyToSwitchOn) // 8
            }
            (OperationEnabled, Some(DisableVoltage)) => Some(SwitchOnDisabled), // 9
            (SwitchedOn, Some(QuickStop | DisableVoltage)) => Some(SwitchOnDisabled), // 10
            (OperationEnabled, Some(QuickStop)) => Some(QuickStopActive),       // 11
            (QuickStopActive, Some(DisableVoltage)) => Some(SwitchOnDisabled),  // 12
            (QuickStopActive, _) if !stays && (stands || self.running_quick_stop == 0) => {
                Some(SwitchOnDisabled) // 12
            }
            (QuickStopActive, Some(EnableOperation)) if stays && stands => Some(OperationEnabled), // 16
            _ => None,
        }
    }
}
