//! The DRV8301, a driver for the gates of three half bridges, and its amplifiers for two shunts: what is written to it over SPI, and what its answers mean.
//!
//! Words of 16 bits, the highest first. A command has bit 15 set to read, a register in bits 11 to 14 and its value in bits 0 to 10; the answer to it comes with the next
//! command, in the same form, and bit 15 of it tells of a frame that was none (data sheet SLOS719, 7.5). With its gate enable low the chip sleeps, speaks to nobody, and forgets.
//!
//! ```text
//! Asleep ──► Waking ──► Setting (control 1, 2) ──► Reading back ──► Watching: status 1, status 2, control 1, control 2, ...
//! ```
//!
//! One word goes with each tick of the control, so nobody waits for it. What it was set to is read again and again: a chip that has lost it, as its
//! supply broke down, is a fault as well.

/// Registers.
const STATUS_1: u16 = 0;
const STATUS_2: u16 = 1;
const CONTROL_1: u16 = 2;
const CONTROL_2: u16 = 3;

/// The bits of a value.
const VALUE: u16 = 0x7FF;

/// Ticks of a millisecond until the chip is awake: 10 at most, and as many more.
const WAKES: u8 = 20;

/// Answers in a row that may be none before the chip is taken for dead.
const PATIENCE: u8 = 3;

/// Ticks in which both status registers were asked for and have answered, whenever they begin: what nFAULT tells is by then known, or has no name.
const ASKED: u8 = 8;

/// A command that reads a register.
pub const fn read(register: u16) -> u16 {
    1 << 15 | register << 11
}

/// A command that writes a register.
pub const fn write(register: u16, value: u16) -> u16 {
    register << 11 | value & VALUE
}

/// The gain of the amplifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gain {
    /// 10 V/V.
    Ten = 0,
    /// 20 V/V.
    Twenty = 1,
    /// 40 V/V.
    Forty = 2,
    /// 80 V/V.
    Eighty = 3,
}

impl Gain {
    /// In V/V.
    pub const fn factor(self) -> f32 {
        match self {
            Self::Ten => 10.0,
            Self::Twenty => 20.0,
            Self::Forty => 40.0,
            Self::Eighty => 80.0,
        }
    }
}

/// What the chip is set to: six inputs, 1.7 A at the gates, a switch above its limit latches all off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The voltage of a switch that is on at which it carries too much, as OC_ADJ_SET has it: 0 is 60 mV, 31 is 2.4 V.
    pub limit: u8,
    /// Of the amplifiers.
    pub gain: Gain,
}

impl Settings {
    /// OCP_MODE 1: latched shut down.
    const fn control_1(self) -> u16 {
        (self.limit as u16 & 0x1F) << 6 | 1 << 4
    }

    /// OCTW_MODE 0: over-current and temperature are both told.
    const fn control_2(self) -> u16 {
        (self.gain as u16) << 2
    }
}

/// What is wrong, as an error code of CiA 402.
mod code {
    /// Over-current of the stage: the voltage of a switch.
    pub const OVER_CURRENT: u16 = 0x2310;
    /// The supply of the stage is too low.
    pub const UNDER_VOLTAGE: u16 = 0x3220;
    /// The chip is too hot.
    pub const TEMPERATURE: u16 = 0x4310;
    /// The supply of the gates.
    pub const GATES: u16 = 0x5110;
    /// It does not answer, or has forgotten what it was set to.
    pub const POWER_SECTION: u16 = 0x5400;
}

/// The error code of the two status registers; `None` if all is well. A warning of its temperature (OTW) is none.
pub fn fault(status_1: u16, status_2: u16) -> Option<u16> {
    let has = |bits: u16| status_1 & bits != 0;
    if has(0x03F) {
        Some(code::OVER_CURRENT)
    } else if has(1 << 7) {
        Some(code::TEMPERATURE)
    } else if has(1 << 8) {
        Some(code::UNDER_VOLTAGE)
    } else if has(1 << 9) || status_2 & 1 << 7 != 0 {
        Some(code::GATES)
    } else if has(1 << 10) {
        Some(code::POWER_SECTION)
    } else {
        None
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Gate enable is low. It is held there for as many ticks, which clears what has latched.
    Asleep(u8),
    Waking(u8),
    /// The next word, of those in [`GateDriver::word`].
    Speaks(u8),
}

/// What to do in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Action {
    /// The level of gate enable.
    pub enable: bool,
    /// The word that is sent; its answer is for the next tick.
    pub send: Option<u16>,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GateDriver {
    settings: Settings,
    state: State,
    /// The registers that the word sent last has asked for, and the one before: the answer to that came with it.
    asked: [Option<u16>; 2],
    status: [u16; 2],
    /// Answers that were none.
    silent: u8,
    /// Ticks in which nFAULT was low.
    unwell: u8,
    is_ready: bool,
    fault: Option<u16>,
}

impl GateDriver {
    /// A chip that sleeps.
    pub const fn new(settings: Settings) -> Self {
        Self {
            settings,
            state: State::Asleep(2),
            asked: [None; 2],
            status: [0; 2],
            silent: 0,
            unwell: 0,
            is_ready: false,
            fault: None,
        }
    }

    /// A tick of a millisecond. `answer` is what came with the word of the tick before, `is_well` the level of nFAULT, `is_fed` whether the stage has its supply.
    pub fn tick(&mut self, answer: Option<u16>, is_well: bool, is_fed: bool) -> Action {
        if !is_fed {
            *self = Self::new(self.settings);
            return Action {
                enable: false,
                send: None,
            };
        }
        self.hear(answer);
        let mut send = None;
        match self.state {
            State::Asleep(0) => self.state = State::Waking(WAKES),
            State::Asleep(left) => self.state = State::Asleep(left - 1),
            State::Waking(0) => self.state = State::Speaks(0),
            State::Waking(left) => self.state = State::Waking(left - 1),
            State::Speaks(at) => {
                let word = self.word(at);
                let register = (word >> 15 != 0).then_some(word >> 11 & 0xF);
                self.asked = [register, self.asked[0]];
                send = Some(word);
                self.state = State::Speaks(if at >= 5 { 2 } else { at + 1 });
                self.unwell = if is_well {
                    0
                } else {
                    self.unwell.saturating_add(1)
                };
                if self.unwell > ASKED {
                    self.fail(code::POWER_SECTION);
                }
            }
        }
        Action {
            enable: !matches!(self.state, State::Asleep(_)),
            send,
        }
    }

    /// The words of a round: set first, then asked for again and again.
    fn word(&self, at: u8) -> u16 {
        match at {
            0 => write(CONTROL_1, self.settings.control_1()),
            1 => write(CONTROL_2, self.settings.control_2()),
            2 => read(STATUS_1),
            3 => read(STATUS_2),
            4 => read(CONTROL_1),
            _ => read(CONTROL_2),
        }
    }

    fn hear(&mut self, answer: Option<u16>) {
        let (Some(register), Some(answer)) = (self.asked[1], answer) else {
            return;
        };
        if answer >> 15 != 0 || answer >> 11 & 0xF != register {
            self.silent = self.silent.saturating_add(1);
            if self.silent >= PATIENCE {
                self.fail(code::POWER_SECTION);
            }
            return;
        }
        self.silent = 0;
        let value = answer & VALUE;
        match register {
            STATUS_1 => self.status[0] = value,
            STATUS_2 => {
                self.status[1] = value;
                if let Some(found) = fault(self.status[0], self.status[1]) {
                    self.fail(found);
                }
            }
            CONTROL_1 if value != self.settings.control_1() => self.fail(code::POWER_SECTION),
            CONTROL_2 if value != self.settings.control_2() => self.fail(code::POWER_SECTION),
            CONTROL_2 => self.is_ready = true,
            _ => {}
        }
    }

    fn fail(&mut self, found: u16) {
        self.is_ready = false;
        self.fault.get_or_insert(found);
    }

    /// Whether the gates may be switched: it was set up, has said so, and nothing is wrong.
    pub fn is_ready(&self) -> bool {
        self.is_ready && self.unwell == 0 && self.fault.is_none()
    }

    /// Whether it was set up, whatever has become of it since.
    pub fn is_set_up(&self) -> bool {
        self.is_ready || self.fault.is_some()
    }

    /// What is wrong, as an error code of CiA 402. It stays until [`GateDriver::mend`].
    pub fn fault(&self) -> Option<u16> {
        self.fault
    }

    /// Forgets a fault: the chip sleeps for a moment, which clears what has latched, and is set up anew.
    pub fn mend(&mut self) {
        *self = Self::new(self.settings);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const SETTINGS: Settings = Settings {
        limit: 21,
        gain: Gain::Eighty,
    };

    /// The chip, as its data sheet has it.
    #[derive(Default)]
    struct Chip {
        registers: [u16; 4],
        answer: u16,
        is_deaf: bool,
    }

    impl Chip {
        fn frame(&mut self, word: u16) -> u16 {
            if self.is_deaf {
                return 0xFFFF;
            }
            let answer = self.answer;
            let register = word >> 11 & 0xF;
            if word >> 15 == 0 {
                self.registers[usize::from(register)] = word & VALUE;
            }
            self.answer = register << 11 | self.registers[usize::from(register)];
            answer
        }
    }

    /// So many ticks; the words that were sent.
    fn run(driver: &mut GateDriver, chip: &mut Chip, ticks: u32) -> Vec<u16> {
        let mut words = Vec::new();
        let mut answer = None;
        for _ in 0..ticks {
            let is_well = fault(chip.registers[0], chip.registers[1]).is_none();
            let action = driver.tick(answer, is_well, true);
            answer = action.send.map(|word| {
                words.push(word);
                chip.frame(word)
            });
            if !action.enable {
                *chip = Chip {
                    is_deaf: chip.is_deaf,
                    ..Chip::default()
                };
            }
        }
        words
    }

    #[test]
    fn words_are_those_of_the_data_sheet() {
        assert_eq!(read(STATUS_2), 0x8800);
        // Control 1: 1.7 A, six inputs, latched, OC_ADJ_SET 21; control 2: gain 80.
        assert_eq!(write(CONTROL_1, SETTINGS.control_1()), 0x1550);
        assert_eq!(write(CONTROL_2, SETTINGS.control_2()), 0x180C);
        assert_eq!(fault(0, 0), None);
        assert_eq!(fault(1 << 6, 0), None);
        for (status_1, status_2, told) in [
            (0x420, 0, 0x2310),
            (0x401, 0, 0x2310),
            (0x480, 0, 0x4310),
            (0x500, 0, 0x3220),
            (0x600, 0, 0x5110),
            (0x400, 0x80, 0x5110),
            (0x400, 0, 0x5400),
        ] {
            assert_eq!(fault(status_1, status_2), Some(told));
        }
    }

    #[test]
    fn it_is_woken_set_up_and_asked() {
        let (mut driver, mut chip) = (GateDriver::new(SETTINGS), Chip::default());
        assert_eq!(run(&mut driver, &mut chip, 22), []);
        let words = run(&mut driver, &mut chip, 10);
        assert_eq!(words[..2], [0x1550, 0x180C]);
        assert_eq!(words[2..6], [0x8000, 0x8800, 0x9000, 0x9800]);
        assert!(driver.is_ready());
        assert_eq!(chip.registers[2..], [0x550, 0x00C]);
    }

    #[test]
    fn a_fault_stays_until_it_is_mended() {
        let (mut driver, mut chip) = (GateDriver::new(SETTINGS), Chip::default());
        run(&mut driver, &mut chip, 40);
        chip.registers[0] = 0x404;
        run(&mut driver, &mut chip, 2);
        assert!(
            !driver.is_ready() && driver.is_set_up(),
            "why is not known yet"
        );
        run(&mut driver, &mut chip, 6);
        assert_eq!(driver.fault(), Some(0x2310));
        chip.registers[0] = 0;
        run(&mut driver, &mut chip, 40);
        assert!(!driver.is_ready());
        driver.mend();
        run(&mut driver, &mut chip, 40);
        assert!(driver.is_ready());
    }

    #[test]
    fn a_chip_that_is_silent_or_has_forgotten_is_a_fault() {
        let (mut driver, mut chip) = (GateDriver::new(SETTINGS), Chip::default());
        chip.is_deaf = true;
        run(&mut driver, &mut chip, 40);
        assert_eq!(driver.fault(), Some(0x5400));
        let (mut driver, mut chip) = (GateDriver::new(SETTINGS), Chip::default());
        run(&mut driver, &mut chip, 40);
        chip.registers[2] = 0;
        run(&mut driver, &mut chip, 8);
        assert_eq!(driver.fault(), Some(0x5400));
    }

    #[test]
    fn without_its_supply_it_sleeps_and_is_no_fault() {
        let (mut driver, mut chip) = (GateDriver::new(SETTINGS), Chip::default());
        run(&mut driver, &mut chip, 40);
        let action = driver.tick(None, false, false);
        assert_eq!((action.enable, action.send), (false, None));
        assert_eq!((driver.is_ready(), driver.fault()), (false, None));
    }
}
