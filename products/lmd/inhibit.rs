//! The inhibit input (2002h:4) and its twelve reactions (2007h), behind its filter (2004h, 2006h).

use canopen::Instant;
use canopen::od::Dictionary;
use cia402::Command;
use cia402::behaviour::{number, put_number};
use cia402::commands::Commands;
use cia402::controlword::HALT;

/// "Fault signal": an error from outside.
const EXTERNAL: u16 = 0x9001;

/// What the input does to the controlword.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Reaction {
    #[default]
    None,
    Fault,
    DisableVoltage,
    QuickStop,
    Shutdown,
    DisableOperation,
    Halt,
}

impl Reaction {
    const fn of(code: i64) -> Self {
        match code {
            1 | 2 => Self::Fault,
            3 | 4 => Self::DisableVoltage,
            5 | 6 => Self::QuickStop,
            7 | 8 => Self::Shutdown,
            9 | 10 => Self::DisableOperation,
            11 | 12 => Self::Halt,
            _ => Self::None,
        }
    }

    /// A controlword with this command in it.
    const fn put_into(self, word: u16) -> u16 {
        match self {
            Self::None | Self::Fault => word,
            Self::DisableVoltage => word & !0b10,
            Self::QuickStop => word & !0b110 | 0b10,
            Self::Shutdown => word & !0b111 | 0b110,
            Self::DisableOperation => word & !0b1111 | 0b111,
            Self::Halt => word | HALT,
        }
    }
}

/// The input.
#[derive(Debug, Default)]
pub(super) struct Inhibit {
    word: u16,
    /// Behind the filter.
    is_active: bool,
    /// Since when the wire is at the other level.
    differs: Option<Instant>,
    reaction: Reaction,
    /// A fault that "overwrite" has set, until the controlword resets it.
    has_failed: bool,
}

/// The longest time, in ms, of the filters of these inputs.
pub(super) fn filter<D: Dictionary>(dictionary: &D, inputs: i64) -> i64 {
    let of_group = |group| {
        let is_theirs = number(dictionary, 0x2004, group) & inputs != 0;
        if is_theirs {
            number(dictionary, 0x2006, group)
        } else {
            0
        }
    };
    (1..=4).map(of_group).max().unwrap_or(0)
}

impl Inhibit {
    /// A controlword; returns its bits that rose.
    pub(super) fn controlword(&mut self, word: u16) -> u16 {
        let rises = word & !core::mem::replace(&mut self.word, word);
        if rises & 1 << 7 != 0 {
            self.has_failed = false;
        }
        rises
    }

    /// Looks at the wires. Returns whether the commands are others now.
    pub(super) fn look<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        wires: u32,
        at: Instant,
    ) -> bool {
        let inputs = number(dictionary, 0x2002, 4);
        let levels = i64::from(wires) ^ number(dictionary, 0x2000, 4);
        let is_active = levels & inputs & 0x0F != 0;
        if is_active == self.is_active {
            self.differs = None;
            return false;
        }
        let since = *self.differs.get_or_insert(at);
        let time = u64::try_from(filter(dictionary, inputs)).unwrap_or(0) * 1_000;
        let lasts = at.checked_duration_since(since);
        if lasts.is_none_or(|lasts| lasts.ticks() < time) {
            return false;
        }
        self.differs = None;
        self.is_active = is_active;
        let code = number(dictionary, 0x2007, 1);
        let reaction = Reaction::of(code);
        let overwrites = code & 1 != 0;
        self.reaction = if is_active && !overwrites {
            reaction
        } else {
            Reaction::None
        };
        if is_active && overwrites {
            self.has_failed |= reaction == Reaction::Fault;
            let word = u16::try_from(number(dictionary, 0x6040, 0)).unwrap_or(0);
            self.word = reaction.put_into(word);
            put_number(dictionary, 0x6040, 0, self.word.into());
        }
        true
    }

    pub(super) fn fault(&self) -> Option<u16> {
        (self.has_failed || self.reaction == Reaction::Fault).then_some(EXTERNAL)
    }

    pub(super) fn command(&self, commands: &mut Commands) {
        commands.controlword = self.reaction.put_into(commands.controlword);
        commands.stop = match self.reaction {
            Reaction::DisableVoltage => Some(Command::DisableVoltage),
            Reaction::QuickStop => commands.stop.or(Some(Command::QuickStop)),
            _ => commands.stop,
        };
    }
}
