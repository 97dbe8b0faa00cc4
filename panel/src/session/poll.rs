//! What is read from the drive all the time: statusword, position and velocity in each look, the rest in turn.

use std::collections::BTreeSet;

use canopen::{Duration, Instant};
use master::axis402::{Node, Problem};
use master::data_sheet::Address;
use master::trace::{controlword_in, error_words, statusword_in};
use master::{Failure, Line};

use super::Session;
use super::drive::{HOMING, PROFILE_POSITION};
use super::guard::Guarding;
use super::scope::has_recorder;
use crate::fsa::{DriveState, MODES};
use crate::message::{Drive, Mode, SetPoint, Word};

/// From a look at the drive to the next; longer where the looks themselves take long.
const LOOK: Duration = Duration::from_ticks(40_000);

/// How long a drive that does not answer is left alone.
const SILENCE: Duration = Duration::from_ticks(1_000_000);

/// Of an answer to a look.
const ANSWER_TIME: Duration = Duration::from_ticks(250_000);

/// Read in each look.
const ALWAYS: [Watched; 3] = [
    Watched::new(0x6041, 0, |drive, word| {
        let word = word as u16;
        drive.state = DriveState::of(word);
        drive.transitions = drive.state.map(DriveState::transitions).unwrap_or_default();
        let mode = drive.mode.unwrap_or(PROFILE_POSITION);
        drive.statusword = Some(shown(word, statusword_in(word, mode)));
        match drive.mode {
            Some(HOMING) => drive.tell("Homing", homing(word).to_owned()),
            _ => drive.values.retain(|(name, _)| *name != "Homing"),
        }
    }),
    Watched::new(0x6064, 0, |drive, value| drive.position = Some(value)),
    Watched::new(0x606C, 0, |drive, value| drive.velocity = Some(value)),
];

/// Read one in each look.
const IN_TURN: [Watched; 15] = [
    Watched::new(0x6061, 0, |drive, mode| {
        drive.mode = i8::try_from(mode).ok();
        drive.set_point = drive.mode.and_then(SetPointOf::mode).map(|of| SetPoint {
            name: of.name,
            unit: of.unit(&drive.units),
        });
    }),
    Watched::new(0x603F, 0, |drive, code| {
        let code = code as u16;
        let words = error_words(code).unwrap_or("of the manufacturer");
        drive.fault = (code != 0).then(|| format!("{code:04X}h: {words}"));
    }),
    Watched::new(0x6040, 0, |drive, word| {
        let word = word as u16;
        let mode = drive.mode.unwrap_or(PROFILE_POSITION);
        drive.controlword = Some(shown(word, controlword_in(word, mode)));
    }),
    Watched::new(0x6062, 0, |drive, value| drive.demand = Some(value)),
    Watched::new(0x6081, 0, |drive, value| {
        drive.profile_velocity = Some(value);
    }),
    Watched::new(0x6083, 0, |drive, value| {
        drive.profile_acceleration = Some(value);
    }),
    Watched::new(0x6084, 0, |drive, value| {
        drive.profile_deceleration = Some(value);
    }),
    Watched::new(0x60F4, 0, |drive, value| {
        drive.following_error = Some(value);
    }),
    Watched::new(0x60FD, 0, |drive, value| {
        drive.tell("Inputs", inputs(value as u32));
    }),
    Watched::new(0x60FE, 1, |drive, value| {
        drive.tell("Outputs", outputs(value as u32));
    }),
    Watched::new(0x607D, 1, |drive, value| {
        drive.tell("Lowest position", limit(value, i64::from(i32::MIN)));
    }),
    Watched::new(0x607D, 2, |drive, value| {
        drive.tell("Highest position", limit(value, i64::from(i32::MAX)));
    }),
    Watched::new(0x6079, 0, |drive, value| {
        drive.tell(
            "Supply",
            format!("{}.{} V", value / 1_000, value % 1_000 / 100),
        );
    }),
    Watched::new(0x6077, 0, |drive, value| {
        drive.tell("Torque", format!("{value} ‰"));
    }),
    // Of the generic drive; another maker's 2074h is something else, and is asked for by nobody.
    Watched {
        own: Some("Temperature"),
        ..Watched::new(0x2074, 1, |drive, value| {
            let (whole, tenth) = (value / 10, (value % 10).abs());
            drive.tell("Temperature", format!("{whole}.{tenth} °C"));
        })
    },
];

/// An object, and where its value goes.
struct Watched {
    address: Address,
    put: fn(&mut Drive, i64),
    /// Only where the data sheet of the node names it so.
    own: Option<&'static str>,
}

impl Watched {
    const fn new(index: u16, sub: u8, put: fn(&mut Drive, i64)) -> Self {
        Self {
            address: Address::new(index, sub),
            put,
            own: None,
        }
    }
}

impl Drive {
    fn tell(&mut self, name: &'static str, text: String) {
        match self.values.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = text,
            None => self.values.push((name, text)),
        }
    }
}

fn shown(word: u16, words: String) -> Word {
    Word {
        number: format!("{word:04X}h"),
        words,
    }
}

/// How far homing is: bits 10, 12 and 13 of the statusword (CiA 402-2, homing mode).
fn homing(statusword: u16) -> &'static str {
    let bit = |place: u16| statusword >> place & 1 == 1;
    match (bit(13), bit(12), bit(10)) {
        (true, _, false) => "error, still moving",
        (true, _, true) => "error, stands",
        (false, true, true) => "done",
        (false, true, false) => "found, on the way there",
        (false, false, false) => "under way",
        (false, false, true) => "not begun, or interrupted",
    }
}

/// 60FDh in words (CiA 402-2).
fn inputs(value: u32) -> String {
    let bits = [
        (0, "negative limit"),
        (1, "positive limit"),
        (2, "home switch"),
        (3, "interlock"),
    ];
    let active = bits.iter().filter(|(bit, _)| value >> bit & 1 == 1);
    let mut names: Vec<String> = active.map(|(_, name)| (*name).to_owned()).collect();
    names.extend(terminals(value, "input"));
    with_names(value, &names)
}

/// 60FEh in words (CiA 402-2).
fn outputs(value: u32) -> String {
    let brake = match value & 1 {
        1 => "brake applied",
        _ => "brake released",
    };
    let mut names = vec![brake.to_owned()];
    names.extend(terminals(value, "output"));
    with_names(value, &names)
}

/// Bits 16 to 31 are the manufacturer's: its terminals, as a rule.
fn terminals(value: u32, name: &str) -> impl Iterator<Item = String> {
    let active = (0..16).filter(move |bit| value >> (16 + bit) & 1 == 1);
    active.map(move |bit| format!("{name} {}", bit + 1))
}

fn with_names(value: u32, names: &[String]) -> String {
    match names {
        [] => format!("{value:08X}h"),
        names => format!("{value:08X}h, {}", names.join(", ")),
    }
}

/// A software position limit; the end of the range is none.
fn limit(value: i64, none: i64) -> String {
    match value == none {
        true => "no limit".to_owned(),
        false => value.to_string(),
    }
}

/// The set-point of a mode, where it is a velocity or a torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SetPointOf {
    name: &'static str,
    /// Where it is written, and in how many bytes.
    pub index: u16,
    pub length: usize,
    /// The controlword that follows it: a ramp generator of velocity mode has bits of its own.
    pub controlword: u16,
}

impl SetPointOf {
    pub(super) fn mode(mode: i8) -> Option<Self> {
        let of = |name, index, length, controlword| Self {
            name,
            index,
            length,
            controlword,
        };
        match mode {
            2 => Some(of("Target velocity (6042h)", 0x6042, 2, 0x7F)),
            3 => Some(of("Target velocity (60FFh)", 0x60FF, 4, 0x0F)),
            4 => Some(of("Target torque (6071h)", 0x6071, 2, 0x0F)),
            _ => None,
        }
    }

    fn unit(self, [_, velocity, _]: &[String; 3]) -> String {
        match self.index {
            0x60FF => velocity.clone(),
            0x6071 => "‰".to_owned(),
            // 604Ch makes it what the machine has.
            _ => String::new(),
        }
    }
}

/// The drive that was chosen.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// Which node.
    pub node: Node,
    /// What is told of it.
    pub drive: Drive,
    /// What of 1016h is to be put back.
    pub guarding: Option<Guarding>,
    /// Whether the panel has given it power.
    pub has_enabled: bool,
    absent: BTreeSet<Address>,
    turn: usize,
    next: Instant,
}

impl Chosen {
    pub(super) fn new(node: Node, drive: Drive, now: Instant) -> Self {
        Self {
            node,
            drive,
            guarding: None,
            has_enabled: false,
            absent: BTreeSet::new(),
            turn: 0,
            next: now,
        }
    }

    /// It has another data sheet now: what was missing may be there.
    pub(super) fn learn(&mut self, node: Node) {
        self.drive.has_recorder = has_recorder(&node.sheet);
        self.drive.can_tune = master::tuning::is_possible(&node.sheet);
        self.node = node;
        self.absent.clear();
    }

    /// What windows are told.
    pub fn told(&self) -> Drive {
        self.drive.clone()
    }
}

impl<L: Line> Session<L> {
    pub(super) fn is_poll_due(&self) -> bool {
        let now = self.master.now();
        self.chosen
            .as_ref()
            .is_some_and(|chosen| now >= chosen.next)
    }

    /// A look at the drive.
    pub(super) fn poll(&mut self) {
        let usual = self
            .master
            .set_answer_time(ANSWER_TIME.min(self.master.answer_time()));
        let start = self.master.now();
        let turn = self.chosen.as_mut().map_or(0, |chosen| {
            chosen.turn = (chosen.turn + 1) % IN_TURN.len();
            chosen.turn
        });
        let watched = ALWAYS.iter().chain(&IN_TURN[turn..=turn]);
        let mut answers = true;
        for watched in watched {
            match self.watch(watched) {
                Ok(()) => {}
                // Somebody wants to stop it.
                Err(Failure::LineDown(_)) => break,
                Err(_) => {
                    answers = false;
                    break;
                }
            }
        }
        self.master.set_answer_time(usual);
        let now = self.master.now();
        if let Some(chosen) = &mut self.chosen {
            chosen.drive.answers = answers;
            let took = now.checked_duration_since(start).unwrap_or(LOOK);
            chosen.next = match answers {
                true => (start + LOOK).max(now + took),
                false => now + SILENCE,
            };
        }
    }

    fn watch(&mut self, watched: &Watched) -> Result<(), Failure> {
        let Some(chosen) = &mut self.chosen else {
            return Ok(());
        };
        let object = chosen.node.sheet.object(watched.address.index);
        let name = object.map(|object| object.name.as_str());
        let is_other = watched.own.is_some() && watched.own != name;
        if is_other || chosen.absent.contains(&watched.address) {
            return Ok(());
        }
        match chosen.node.upload(&mut self.master, watched.address) {
            Ok(bytes) => {
                let is_signed = (chosen.node.sheet.data_type(watched.address))
                    .is_some_and(|data_type| data_type.is_signed());
                (watched.put)(&mut chosen.drive, number(&bytes, is_signed));
            }
            // It has no such object.
            Err(Failure::Abort { .. }) => {
                chosen.absent.insert(watched.address);
            }
            Err(failure) => return Err(failure),
        }
        Ok(())
    }

    /// The statusword as it is now, while an order waits for it. Windows see what the drive does meanwhile.
    pub(super) fn statusword(&mut self) -> Result<u16, Problem> {
        for watched in &ALWAYS {
            let id = self.chosen.as_ref().map_or(0, |chosen| chosen.node.id);
            self.watch(watched)
                .map_err(|failure| Problem::with_node(id, failure))?;
        }
        self.publish();
        let node = self.chosen_node()?;
        let bytes = node.upload(&mut self.master, Address::new(0x6041, 0));
        let bytes = bytes.map_err(|failure| Problem::with_node(node.id, failure))?;
        Ok(number(&bytes, false) as u16)
    }

    /// An object of the drive that may not be there.
    pub(super) fn optional(&mut self, node: &Node, index: u16) -> Result<Option<i64>, Problem> {
        match node.upload(&mut self.master, Address::new(index, 0)) {
            Ok(bytes) => Ok(Some(number(&bytes, false))),
            Err(Failure::Abort { .. }) => Ok(None),
            Err(failure) => Err(Problem::with_node(node.id, failure)),
        }
    }
}

/// A number as it travels.
pub(super) fn number(bytes: &[u8], is_signed: bool) -> i64 {
    let bytes = &bytes[..bytes.len().min(8)];
    let number = (bytes.iter().rev()).fold(0u64, |number, byte| number << 8 | u64::from(*byte));
    let unused = 64 - 8 * bytes.len() as u32;
    match is_signed && unused < 64 {
        true => ((number << unused) as i64) >> unused,
        false => number as i64,
    }
}

/// The modes in 6502h.
pub(super) fn modes(supported: i64) -> Vec<Mode> {
    let known = MODES
        .iter()
        .filter(|(number, _)| supported >> (number - 1) & 1 == 1);
    known.map(|&(number, name)| Mode { number, name }).collect()
}

/// A unit of CiA 303-2 as 60A8h and 60A9h hold it: prefix, numerator, denominator. What no person would know is "units".
pub(super) fn unit(code: Option<i64>, otherwise: &str) -> String {
    let Some([_, denominator, numerator, prefix]) = code.map(|code| (code as u32).to_le_bytes())
    else {
        return otherwise.to_owned();
    };
    let base = match numerator {
        0x01 => "m",
        0x10 => "rad",
        0x41 => "°",
        0xAC => "steps",
        0xB4 => "rev",
        0xB5 => "inc",
        _ => return otherwise.to_owned(),
    };
    let prefix = match prefix as i8 {
        0 => "",
        -3 => "m",
        -6 => "µ",
        -2 => "c",
        -1 => "d",
        _ => return otherwise.to_owned(),
    };
    let per = match denominator {
        0x00 => "",
        0x03 => "/s",
        0x57 => "/s²",
        0x47 => "/min",
        0x48 => "/h",
        _ => return otherwise.to_owned(),
    };
    format!("{prefix}{base}{per}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_names() {
        assert_eq!(unit(Some(0x00AC_0000), "units"), "steps");
        assert_eq!(unit(Some(0x00AC_0300), "units/s"), "steps/s");
        assert_eq!(unit(Some(0xFD01_0000), "units"), "mm");
        assert_eq!(unit(Some(0xFA01_0300), "units"), "µm/s");
        assert_eq!(unit(Some(0xFD01_5700), "units/s²"), "mm/s²");
        assert_eq!(unit(Some(0x1234_5678), "units"), "units");
        assert_eq!(unit(None, "units"), "units");
    }

    #[test]
    fn inputs_outputs_and_limits_have_words() {
        assert_eq!(
            inputs(0x0003_0005),
            "00030005h, negative limit, home switch, input 1, input 2"
        );
        assert_eq!(inputs(0), "00000000h");
        assert_eq!(outputs(0x0004_0001), "00040001h, brake applied, output 3");
        assert_eq!(outputs(0), "00000000h, brake released");
        assert_eq!(homing(0x1637), "done");
        assert_eq!(homing(0x0237), "under way");
        assert_eq!(homing(0x2637), "error, stands");
        assert_eq!(limit(-5, i64::from(i32::MIN)), "-5");
        assert_eq!(limit(i64::from(i32::MIN), i64::from(i32::MIN)), "no limit");
    }

    #[test]
    fn numbers_have_the_sign_of_their_type() {
        assert_eq!(number(&(-5i32).to_le_bytes(), true), -5);
        assert_eq!(number(&(-5i32).to_le_bytes(), false), 0xFFFF_FFFB);
        assert_eq!(number(&[0xFF], true), -1);
        assert_eq!(number(&[], true), 0);
        assert_eq!(number(&[1; 12], false), 0x0101_0101_0101_0101);
    }

    #[test]
    fn modes_are_told_by_6502h() {
        let numbers: Vec<i8> = modes(0x1E7).iter().map(|mode| mode.number).collect();
        assert_eq!(numbers, [1, 2, 3, 6, 7, 8, 9]);
    }
}
