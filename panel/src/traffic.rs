//! What passes on the bus: frames in words, the nodes that are heard, the load.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use canopen::{Duration, Instant};
use master::data_sheet::DataSheet;
use master::trace::{Interpreter, candump, error_words, node_state};

use crate::line::Passed;
use crate::message::{LoggedFrame, NodeState};

/// Emergency messages that are kept of each node.
const EMERGENCIES: usize = 8;

/// A node that was silent for so long is lost, or for so many of its heartbeats.
const LOST_AFTER: Duration = Duration::from_ticks(1_000_000);
const LOST_BEATS: u32 = 3;

/// The boot-up message, and the NMT states in a heartbeat (CiA 301).
const BOOT_UP: u8 = 0x00;
const STOPPED: u8 = 0x04;
const OPERATIONAL: u8 = 0x05;
const PRE_OPERATIONAL: u8 = 0x7F;

/// What is known of a node.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// What a scan or the node itself has told.
    pub told: NodeState,
    /// Its last frame.
    pub last: Option<Instant>,
    /// Its last heartbeat, and the time from the one before to it.
    pub beat: Option<(Instant, Option<Duration>)>,
    /// Its NMT state, as its heartbeat has told it, or as the last NMT command has ordered it.
    pub state: Option<u8>,
    /// It has started anew, and nobody has minded it yet.
    has_booted: bool,
    /// How often it was asked who it is since it was heard.
    pub asked: u8,
}

impl Known {
    /// Whether its heartbeats have ended, and it was not heard otherwise.
    fn is_lost(&self, age: impl Fn(Instant) -> Duration) -> bool {
        let (Some((_, Some(period))), Some(last)) = (self.beat, self.last) else {
            return false;
        };
        age(last) > LOST_AFTER.max(period * LOST_BEATS)
    }
}

/// Follows the bus.
#[derive(Debug)]
pub struct Traffic {
    interpreter: Interpreter,
    nodes: BTreeMap<u8, Known>,
    counted: VecDeque<(Instant, u64, u64)>,
    emergencies: u64,
}

impl Default for Traffic {
    fn default() -> Self {
        Self::new()
    }
}

impl Traffic {
    /// Nothing was heard yet.
    pub fn new() -> Self {
        Self {
            interpreter: Interpreter::new(DataSheet::standard()),
            nodes: BTreeMap::new(),
            counted: VecDeque::new(),
            emergencies: 0,
        }
    }

    /// What a node is.
    pub fn learn_sheet(&mut self, node: u8, sheet: Arc<DataSheet>) {
        self.interpreter.learn_sheet(node, sheet);
    }

    /// A node, to write down what it tells.
    pub fn node_mut(&mut self, id: u8) -> &mut Known {
        let known = self.nodes.entry(id).or_default();
        known.told.id = id;
        known
    }

    /// What is known of a node.
    pub fn node(&self, id: u8) -> Option<&Known> {
        self.nodes.get(&id)
    }

    /// Whether a node has started anew since this was asked last.
    pub fn take_boot(&mut self, id: u8) -> bool {
        let known = self.nodes.get_mut(&id);
        known.is_some_and(|known| std::mem::take(&mut known.has_booted))
    }

    /// How many emergency messages have told an error.
    pub fn emergencies(&self) -> u64 {
        self.emergencies
    }

    /// A node that was heard, and has not told who it is though it was asked less often than `most`; not this one of ours.
    pub fn stranger(&self, own: u8, most: u8) -> Option<u8> {
        let is_strange = |known: &Known| known.last.is_some() && known.told.device.is_none();
        let mut nodes = self.nodes.iter();
        nodes
            .find(|(id, known)| **id != own && is_strange(known) && known.asked < most)
            .map(|(id, _)| *id)
    }

    /// Forgets all nodes, before a scan.
    pub fn forget_nodes(&mut self) {
        self.nodes.clear();
    }

    /// Follows a frame; in words if they are wanted.
    pub fn follow(&mut self, passed: &Passed, in_words: bool) -> Option<LoggedFrame> {
        match (passed.own, passed.frame.standard_id()) {
            // Of any master: a node without a heartbeat tells its state to nobody.
            (_, Some(0x000)) => self.command(passed.frame.payload()),
            (false, Some(cob_id)) => self.hear(passed, cob_id),
            _ => {}
        }
        // A segment means nothing without its transfer, so all are followed.
        let meaning = self.interpreter.meaning(&passed.frame);
        in_words.then(|| LoggedFrame {
            at: candump::time(passed.at),
            id: candump::identifier(&passed.frame),
            bytes: bytes(passed),
            kind: kind(passed),
            node: node(passed),
            meaning,
            own: passed.own,
        })
    }

    /// An NMT command to one node, or to all (0).
    fn command(&mut self, payload: &[u8]) {
        let [command, node] = *payload else {
            return;
        };
        let state = match command {
            0x01 => OPERATIONAL,
            0x02 => STOPPED,
            0x80 => PRE_OPERATIONAL,
            // A reset: the node tells when it is there again.
            _ => return,
        };
        for (id, known) in &mut self.nodes {
            if node == 0 || node == *id {
                known.state = Some(state);
            }
        }
    }

    fn hear(&mut self, passed: &Passed, cob_id: u16) {
        let Ok(id @ 1..=127) = u8::try_from(cob_id & 0x7F) else {
            return;
        };
        match (cob_id & 0x780, passed.frame.payload()) {
            (0x700, [state]) => {
                let known = self.node_mut(id);
                known.last = Some(passed.at);
                if *state == BOOT_UP {
                    // It goes on to pre-operational by itself, and may send no heartbeat.
                    (known.state, known.beat) = (Some(PRE_OPERATIONAL), None);
                    known.has_booted = true;
                } else {
                    let since = |(at, _): (Instant, _)| passed.at.checked_duration_since(at);
                    known.beat = Some((passed.at, known.beat.and_then(since)));
                    known.state = Some(*state);
                }
            }
            (0x080, [low, high, register, ..]) => {
                let code = u16::from_le_bytes([*low, *high]);
                // 0000h tells that an error is over.
                self.emergencies += u64::from(code != 0);
                let words = error_words(code).unwrap_or("of the manufacturer");
                let time = candump::time(passed.at);
                let line = format!("{time} {code:04X}h {words} (register {register:02X}h)");
                let known = self.node_mut(id);
                known.last = Some(passed.at);
                let kept = &mut known.told.emergencies;
                kept.push(line);
                if kept.len() > EMERGENCIES {
                    kept.remove(0);
                }
            }
            (0x580, [_, ..]) => self.node_mut(id).last = Some(passed.at),
            _ => {}
        }
    }

    /// The nodes as they are now.
    pub fn nodes(&self, now: Instant) -> Vec<NodeState> {
        let none = Duration::from_ticks(0);
        let age = |at: Instant| now.checked_duration_since(at).unwrap_or(none);
        let tenths = |at: Instant| age(at).to_millis() / 100;
        let tell = |known: &Known| NodeState {
            state: known.state.map(node_state),
            silent: known.last.map(tenths),
            heartbeat: known.beat.map(|(at, _)| tenths(at)),
            is_lost: known.is_lost(age),
            ..known.told.clone()
        };
        self.nodes.values().map(tell).collect()
    }

    /// Frames and bits of the last second, from how many have passed so far.
    pub fn rate(&mut self, now: Instant, (frames, bits): (u64, u64)) -> (u64, u64) {
        let second = Duration::from_ticks(1_000_000);
        self.counted.push_back((now, frames, bits));
        while self.counted.len() > 1
            && self
                .counted
                .front()
                .is_some_and(|(at, ..)| *at + second < now)
        {
            self.counted.pop_front();
        }
        let (_, old_frames, old_bits) = self.counted.front().copied().unwrap_or((now, 0, 0));
        (frames - old_frames, bits - old_bits)
    }
}

fn bytes(passed: &Passed) -> String {
    if passed.frame.is_remote() {
        return "remote request".to_owned();
    }
    let bytes = passed.frame.payload().iter();
    let bytes: Vec<String> = bytes.map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

/// The service of a frame by its identifier (CiA 301, predefined connection set).
fn kind(passed: &Passed) -> &'static str {
    match passed.frame.standard_id() {
        Some(0x000) => "NMT",
        Some(0x080) => "SYNC",
        Some(0x100) => "TIME",
        Some(0x081..=0x0FF) => "EMCY",
        Some(0x180..=0x57F) => "PDO",
        Some(0x580..=0x67F) => "SDO",
        Some(0x700..=0x77F) => "Heartbeat",
        Some(0x7E4 | 0x7E5) => "LSS",
        _ => "Other",
    }
}

/// Whose identifier it is in the predefined connection set.
fn node(passed: &Passed) -> Option<u8> {
    match passed.frame.standard_id()? {
        id @ (0x081..=0x0FF | 0x181..=0x67F | 0x701..=0x77F) => {
            Some((id & 0x7F) as u8).filter(|node| *node != 0)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canopen::Frame;

    fn passed(at: u64, cob_id: u16, data: &[u8]) -> Passed {
        Passed {
            at: Instant::from_ticks(at),
            frame: Frame::data_frame(cob_id, data),
            own: false,
        }
    }

    #[test]
    fn nodes_are_known_by_what_they_send() {
        let mut traffic = Traffic::new();
        traffic.follow(&passed(100_000, 0x704, &[0x7F]), false);
        traffic.follow(
            &passed(200_000, 0x084, &[0x30, 0x81, 0x11, 0, 0, 0, 0, 0]),
            false,
        );
        let nodes = traffic.nodes(Instant::from_ticks(1_000_000));
        assert_eq!(nodes.len(), 1);
        assert_eq!((nodes[0].id, nodes[0].state), (4, Some("pre-operational")));
        assert_eq!(nodes[0].silent, Some(8));
        assert_eq!(
            nodes[0].emergencies,
            ["0.200000 8130h life guard or heartbeat error (register 11h)"]
        );
    }

    #[test]
    fn a_node_whose_heartbeat_ends_is_lost() {
        let mut traffic = Traffic::new();
        let node = |traffic: &Traffic, at: u64| traffic.nodes(Instant::from_ticks(at))[0].clone();
        traffic.follow(&passed(0, 0x704, &[0x00]), false);
        assert!(traffic.take_boot(4) && !traffic.take_boot(4));
        let told = node(&traffic, 60_000_000);
        assert_eq!(
            (told.state, told.heartbeat, told.is_lost),
            (Some("pre-operational"), None, false),
            "it may have none"
        );
        for at in [60_000_000, 60_500_000, 61_000_000] {
            traffic.follow(&passed(at, 0x704, &[0x05]), false);
        }
        let told = node(&traffic, 62_400_000);
        assert_eq!(
            (told.state, told.heartbeat, told.is_lost),
            (Some("operational"), Some(14), false)
        );
        assert!(node(&traffic, 62_600_000).is_lost);
        // Somebody has switched its heartbeat off, and it answers.
        traffic.follow(
            &passed(62_500_000, 0x584, &[0x43, 0, 0, 0, 0, 0, 0, 0]),
            false,
        );
        assert!(!node(&traffic, 62_600_000).is_lost);
    }

    #[test]
    fn an_nmt_command_tells_the_state_of_those_without_a_heartbeat() {
        let mut traffic = Traffic::new();
        for id in [0x704, 0x705] {
            traffic.follow(&passed(0, id, &[0x00]), false);
        }
        let states = |traffic: &Traffic| {
            let nodes = traffic.nodes(Instant::from_ticks(0));
            nodes
                .iter()
                .filter_map(|node| node.state)
                .collect::<Vec<_>>()
        };
        for (command, expected) in [
            ([0x01, 0], ["operational", "operational"]),
            ([0x02, 4], ["stopped", "operational"]),
            ([0x80, 5], ["stopped", "pre-operational"]),
            ([0x81, 4], ["stopped", "pre-operational"]),
        ] {
            let command = Passed {
                own: command[1] != 5,
                ..passed(0, 0, &command)
            };
            traffic.follow(&command, false);
            assert_eq!(states(&traffic), expected);
        }
    }

    #[test]
    fn no_more_emergencies_are_kept_than_anybody_reads() {
        let mut traffic = Traffic::new();
        for at in 0..100 {
            traffic.follow(
                &passed(at, 0x084, &[0x10, 0x81, 0x11, 0, 0, 0, 0, 0]),
                false,
            );
        }
        assert_eq!(
            traffic.nodes(Instant::from_ticks(100))[0].emergencies.len(),
            EMERGENCIES
        );
    }

    #[test]
    fn the_load_is_that_of_the_last_second() {
        let mut traffic = Traffic::new();
        let at = |tenths: u64| Instant::from_ticks(tenths * 100_000);
        for tenths in 0..=30 {
            traffic.rate(at(tenths), (10 * tenths, 1_000 * tenths));
        }
        assert_eq!(traffic.rate(at(30), (300, 30_000)), (100, 10_000));
        // Silence.
        for tenths in 31..=50 {
            traffic.rate(at(tenths), (300, 30_000));
        }
        assert_eq!(traffic.rate(at(50), (300, 30_000)), (0, 0));
    }
}
