//! A recording from beginning to end: set up, armed, waited for, fetched.

use canopen::Duration;

use super::{CHANNELS, Recording, Trigger, mapping};
use crate::axis402::{Console, Node, Problem};
use crate::data_sheet::{Address, DataSheet};
use crate::{Failure, Line, Master};

/// What to record. What is `None` stays as the drive has it.
#[derive(Clone, Debug)]
pub struct Request {
    /// Mappings for the channels.
    pub channels: Option<Vec<u32>>,
    /// 20D0h:4.
    pub divider: Option<u16>,
    /// 20D0h:5.
    pub samples: Option<u16>,
    /// What of them is older than the trigger.
    pub before: Option<Before>,
    /// What the trigger is.
    pub trigger: Trigger,
    /// How long to wait for it.
    pub patience: Duration,
}

/// How much of a recording is older than its trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// So many samples.
    Samples(u16),
    /// So much of all samples.
    Percent(u8),
}

/// How long after a change of the state it is asked for again. While nothing happens, each pause is twice as long as the one before.
const PAUSE: Duration = Duration::from_ticks(20_000);

/// The longest pause. Another master that hears an answer of ours among its own may take it for one of these: the fewer the better.
const LONGEST_PAUSE: Duration = Duration::from_ticks(500_000);

/// How often a recording is fetched before it is given up.
const ATTEMPTS: u32 = 6;

/// The pause before it is fetched for the second time; each later one is twice as long. Who disturbed it may be done by then.
const BREATH: Duration = Duration::from_ticks(50_000);

/// Orders of 20D0h:1.
const STOP: u8 = 0;
const ARM: u8 = 1;
const TRIGGER: u8 = 2;

/// What 20D0h:2 says, beside 2 for one that has had its trigger.
const IDLE: u32 = 0;
const ARMED: u32 = 1;
const FULL: u32 = 3;

const fn scope(sub: u8) -> Address {
    Address::new(0x20D0, sub)
}

const fn channel(sub: u8) -> Address {
    Address::new(0x20D1, sub)
}

const fn trigger(sub: u8) -> Address {
    Address::new(0x20D2, sub)
}

const CONTROL: Address = scope(1);
const STATE: Address = scope(2);
const MODE: Address = scope(3);
const DIVIDER: Address = scope(4);
const SAMPLES: Address = scope(5);
const BEFORE: Address = scope(6);
const RECORDED: Address = scope(7);
const MEMORY: Address = scope(8);
const DATA: Address = Address::new(0x20D3, 0);

/// Records and fetches. A person hears of it when the recorder waits.
///
/// # Errors
/// [`Problem::Usage`] if the samples do not fit into the drive, or all of them would be older than the trigger;
/// [`Problem::Failed`] if the node does not answer, has no scope or refuses, or the trigger does not come in time;
/// [`Problem::Stopped`] by a person. The recorder is stopped then.
pub fn record<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    request: &Request,
    console: &mut Console<'_>,
) -> Result<Recording, Problem> {
    let mut armed = arm(master, node, request)?;
    let result = wait(master, node, request, &mut armed, console);
    if result.is_err() {
        // It may be the node that is gone; what went wrong first is told.
        let _ = disarm(master, node);
    }
    result?;
    fetch(master, node)
}

/// A recorder that is at work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Armed {
    /// The trigger is an order, which comes as soon as enough samples are there.
    is_now: bool,
    /// Samples older than the trigger.
    before: u32,
    is_triggered: bool,
}

/// How far a recorder is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It waits for its trigger.
    Armed,
    /// The trigger has come.
    Triggered,
    /// The recording can be fetched.
    Full,
}

/// Sets the recorder up and arms it; [`Armed::progress`] tells when [`fetch`] has something to fetch.
///
/// # Errors
/// As [`record`].
pub fn arm<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    request: &Request,
) -> Result<Armed, Problem> {
    let mut session = Session { master, node };
    session.stop()?;
    session.set_up(request)?;
    session.check()?;
    session.write(CONTROL, &[ARM])?;
    Ok(Armed {
        is_now: request.trigger == Trigger::Now,
        before: session.number(BEFORE)?,
        is_triggered: false,
    })
}

/// Stops the recorder.
///
/// # Errors
/// [`Problem::Failed`] if the node does not answer or has no scope.
pub fn disarm<L: Line>(master: &mut Master<L>, node: &Node) -> Result<(), Problem> {
    Session { master, node }.stop()
}

impl Armed {
    /// How far it is. A trigger that is an order is given here.
    ///
    /// # Errors
    /// [`Problem::Failed`] if the node does not answer, or somebody has stopped the recorder.
    pub fn progress<L: Line>(
        &mut self,
        master: &mut Master<L>,
        node: &Node,
    ) -> Result<Progress, Problem> {
        let mut session = Session { master, node };
        let state = session.number(STATE)?;
        match state {
            FULL => return Ok(Progress::Full),
            IDLE => {
                return Err(Problem::Failed(format!(
                    "node {}: somebody has stopped the scope",
                    node.id
                )));
            }
            _ => {}
        }
        if self.is_now && !self.is_triggered && session.number(RECORDED)? >= self.before {
            session.write(CONTROL, &[TRIGGER])?;
            self.is_triggered = true;
        }
        Ok(match state {
            ARMED => Progress::Armed,
            _ => Progress::Triggered,
        })
    }
}

/// Waits until the recording can be fetched.
fn wait<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    request: &Request,
    armed: &mut Armed,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    if !armed.is_now {
        console.remark(&format!(
            "node {}: the scope is armed and waits for its trigger",
            node.id
        ));
    }
    let end = master.now() + request.patience;
    let (mut last, mut pause) = (None, PAUSE);
    loop {
        let progress = armed.progress(master, node)?;
        if last.replace(progress) != Some(progress) {
            pause = PAUSE;
        }
        if progress == Progress::Full {
            return Ok(());
        }
        let left = end.checked_duration_since(master.now());
        let Some(left) = left.filter(|left| *left > Duration::from_ticks(0)) else {
            return Err(late(node, progress, request.patience));
        };
        // Nobody waits longer than told.
        master.wait(pause.min(left))?;
        // A trigger that is an order shall not be late.
        pause = match armed.is_now {
            true => PAUSE,
            false => (pause * 2).min(LONGEST_PAUSE),
        };
    }
}

fn late(node: &Node, progress: Progress, patience: Duration) -> Problem {
    let what = match progress {
        Progress::Armed => "the trigger has not come",
        _ => "the recording is not done",
    };
    let seconds = patience.to_millis() as f64 / 1e3;
    Problem::Failed(format!("node {}: {what} within {seconds} s", node.id))
}

/// Fetches what was recorded.
///
/// # Errors
/// [`Problem::Failed`] if the node does not answer, or what it sends is no recording.
pub fn fetch<L: Line>(master: &mut Master<L>, node: &Node) -> Result<Recording, Problem> {
    let bytes = Session { master, node }.fetch()?;
    Recording::read(&bytes, &node.sheet)
        .map_err(|why| Problem::Failed(format!("node {}: {why}", node.id)))
}

/// The samples of a recording.
struct Room {
    /// 20D0h:5: how many are asked for, 0 for all that there is room for.
    asked: u16,
    /// How many the memory has room for; `None` without channels.
    fit: Option<u16>,
}

impl Room {
    /// How many there will be.
    fn samples(&self) -> u16 {
        match self.asked {
            0 => self.fit.unwrap_or(0),
            asked => asked,
        }
    }
}

struct Session<'a, L: Line> {
    master: &'a mut Master<L>,
    node: &'a Node,
}

impl<L: Line> Session<'_, L> {
    /// The setup can be written only while nothing is recorded.
    fn stop(&mut self) -> Result<(), Problem> {
        match self.node.download(self.master, CONTROL, &[STOP]) {
            Err(Failure::Abort { code, .. }) if code == NO_OBJECT => Err(Problem::Failed(format!(
                "node {} has no scope: 20D0h is missing",
                self.node.id
            ))),
            other => other.map_err(|failure| Problem::with_node(self.node.id, failure)),
        }
    }

    fn set_up(&mut self, request: &Request) -> Result<(), Problem> {
        if request.trigger != Trigger::AsSetUp {
            self.write(MODE, &[0])?;
        }
        if let Some(mappings) = &request.channels {
            let mappings = mappings.iter().copied().chain(std::iter::repeat(0));
            for (sub, mapping) in (1..=CHANNELS as u8).zip(mappings) {
                self.write(channel(sub), &mapping.to_le_bytes())?;
            }
        }
        if let Some(divider) = request.divider {
            self.write(DIVIDER, &divider.to_le_bytes())?;
        }
        if let Some(samples) = request.samples {
            self.write(SAMPLES, &samples.to_le_bytes())?;
        }
        if let Some(before) = request.before {
            let samples = match before {
                Before::Samples(samples) => samples,
                Before::Percent(percent) => {
                    let room = self.room()?.samples();
                    (u32::from(room) * u32::from(percent) / 100) as u16
                }
            };
            self.write(BEFORE, &samples.to_le_bytes())?;
        }
        match request.trigger {
            Trigger::AsSetUp => Ok(()),
            // Whatever the drive waits for, it would come too early.
            Trigger::Now => self.write(trigger(1), &0_u32.to_le_bytes()),
            Trigger::Edge {
                object,
                edge,
                level,
                mask,
            } => {
                self.write(trigger(1), &object.to_le_bytes())?;
                self.write(trigger(2), &[edge as u8])?;
                self.write(trigger(3), &level.to_le_bytes())?;
                self.write(trigger(4), &mask.to_le_bytes())
            }
        }
    }

    /// How many samples are asked for, and how many can be.
    fn room(&mut self) -> Result<Room, Problem> {
        let asked = self.number(SAMPLES)?;
        let mut bits = 0;
        for sub in 1..=CHANNELS as u8 {
            bits += self.number(channel(sub))? & 0xFF;
        }
        let words = self.number(MEMORY)? / 4;
        let u16_of = |number| u16::try_from(number).unwrap_or(u16::MAX);
        Ok(Room {
            asked: u16_of(asked),
            fit: words.checked_div(bits.div_ceil(32)).map(u16_of),
        })
    }

    /// What the drive would refuse with a code alone.
    fn check(&mut self) -> Result<(), Problem> {
        let room = self.room()?;
        let before = self.number(BEFORE)?;
        match room.fit {
            None => Err(Problem::Usage(
                "no channel records anything: name up to eight objects with --channels".to_owned(),
            )),
            Some(fit) if room.asked > fit => Err(Problem::Usage(format!(
                "{} samples are too many: {fit} samples of these channels fit",
                room.asked
            ))),
            Some(_) if before >= room.samples().into() => Err(Problem::Usage(format!(
                "{before} samples older than the trigger are too many: --pre must be below the samples, which are {}",
                room.samples()
            ))),
            Some(_) => Ok(()),
        }
    }

    /// The bytes of the recording. It stays in the drive, so a transfer that fails is begun anew.
    fn fetch(&mut self) -> Result<Vec<u8>, Problem> {
        let (mut attempt, mut breath) = (1, BREATH);
        loop {
            match (self.master).read_by_blocks(self.node.id, DATA.index, DATA.sub) {
                Ok(bytes) => return Ok(bytes),
                Err(
                    Failure::Timeout { .. }
                    | Failure::Unexpected { .. }
                    | Failure::WrongValue { .. }
                    | Failure::Abort {
                        code: TIMED_OUT..=NO_MEMORY,
                        ..
                    },
                ) if attempt < ATTEMPTS => {
                    attempt += 1;
                    self.master.wait(breath)?;
                    breath *= 2;
                }
                Err(failure) => return Err(Problem::with_node(self.node.id, failure)),
            }
        }
    }

    fn write(&mut self, address: Address, bytes: &[u8]) -> Result<(), Problem> {
        let result = self.node.download(self.master, address, bytes);
        result.map_err(|failure| Problem::with_node(self.node.id, failure))
    }

    fn number(&mut self, address: Address) -> Result<u32, Problem> {
        let bytes = self.node.upload(self.master, address);
        let bytes = bytes.map_err(|failure| Problem::with_node(self.node.id, failure))?;
        let bytes = bytes.iter().rev();
        Ok(bytes.fold(0, |number, byte| number << 8 | u32::from(*byte)))
    }
}

/// Abort codes: of the transfer itself from the first to the second of these, and of an object that is not there.
const TIMED_OUT: u32 = 0x0504_0000;
const NO_MEMORY: u32 = 0x0504_0005;
const NO_OBJECT: u32 = 0x0602_0000;

impl Request {
    /// What a person asks for: `channels` and `trigger` in words, as on the command line. Nothing that somebody else has left in the
    /// drive is a default, but with the trigger "drive".
    ///
    /// # Errors
    /// What the words do not mean.
    pub fn parse(
        channels: Option<&[String]>,
        trigger: &str,
        divider: Option<u16>,
        samples: Option<u16>,
        before: Option<Before>,
        patience: Duration,
        sheet: &DataSheet,
    ) -> Result<Self, String> {
        let channels = match channels {
            Some(objects) if objects.len() > CHANNELS => {
                return Err(format!(
                    "a scope has {CHANNELS} channels, and not {}",
                    objects.len()
                ));
            }
            Some(objects) => {
                let mappings = objects.iter().map(|object| mapping(object, sheet));
                Some(mappings.collect::<Result<_, _>>()?)
            }
            None => None,
        };
        let trigger = Trigger::parse(trigger, sheet)?;
        let is_whole = trigger != Trigger::AsSetUp;
        let usual = match trigger {
            Trigger::Now => Before::Samples(0),
            _ => Before::Percent(20),
        };
        Ok(Self {
            channels,
            divider: divider.or(is_whole.then_some(1)),
            samples: samples.or(is_whole.then_some(0)),
            before: before.or(is_whole.then_some(usual)),
            trigger,
            patience,
        })
    }
}
