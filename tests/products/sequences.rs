//! The worked sequences of the manuals (`products/NAME/sequences.jsonl`), played frame by frame.
//!
//! A line is a frame: `rx` to the drive, `tx` from it. An answer is the next frame with its identifier, byte by byte; `??` is any byte.
//! Where the next line is no answer, an SDO request is still confirmed. Where a manual is wrong, the nearest right line is played
//! ([`PUT_RIGHT`]). What stands before a sequence is in [`crate::scenes`], with
//! what does not play yet: a sequence that is listed there and plays is a mistake of the list.

use std::path::Path;

use canopen::Frame;
use serde_json::Value;

use crate::scenes::{self, NOT_YET, PUT_RIGHT};

/// How long a master waits before its next frame.
const PAUSE: u32 = 5;

/// How long the drive may take for a frame, unless a scene says otherwise.
const WITHIN: u32 = 5_500;

pub struct Line {
    pub step: u64,
    is_sent_by_drive: bool,
    is_remote: bool,
    cob_id: Option<u16>,
    data: String,
}

impl Line {
    fn new(line: &Value) -> Self {
        let text = |key: &str| line[key].as_str().unwrap_or_default().to_owned();
        let id = text("cob_id");
        let is_remote = line["rtr"].as_bool() == Some(true) || text("frame") == "remote";
        Self {
            step: line["step"].as_u64().unwrap(),
            is_sent_by_drive: text("dir") == "tx",
            is_remote,
            cob_id: u16::from_str_radix(id.trim_start_matches("0x"), 16).ok(),
            data: text("data"),
        }
    }

    /// The bytes; `None` is any.
    fn bytes(&self) -> Vec<Option<u8>> {
        let bytes = self.data.split_whitespace();
        bytes
            .map(|byte| u8::from_str_radix(byte, 16).ok())
            .collect()
    }

    fn frame(&self, cob_id: u16) -> Frame {
        let data: Vec<u8> = self.bytes().into_iter().map(Option::unwrap).collect();
        if self.is_remote {
            Frame::remote_frame(cob_id, 0)
        } else {
            Frame::data_frame(cob_id, &data)
        }
    }

    fn fits(&self, payload: &[u8]) -> bool {
        let bytes = self.bytes();
        let pairs = bytes.iter().zip(payload);
        bytes.len() == payload.len()
            && pairs
                .into_iter()
                .all(|(told, byte)| told.is_none_or(|told| told == *byte))
    }
}

/// A sequence with its name.
pub struct Sequence {
    pub name: String,
    pub lines: Vec<Line>,
}

pub fn all(product: &str) -> Vec<Sequence> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(format!("../products/{product}/sequences.jsonl"));
    let mut sequences: Vec<Sequence> = Vec::new();
    for line in std::fs::read_to_string(path).unwrap().lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let name = line["seq"].as_str().unwrap();
        let own = sequences.iter().position(|own| own.name == name);
        let own = own.unwrap_or_else(|| {
            let name = name.to_owned();
            let lines = Vec::new();
            sequences.push(Sequence { name, lines });
            sequences.len() - 1
        });
        sequences[own].lines.push(Line::new(&line));
    }
    for (_, name, step, data, _) in PUT_RIGHT.iter().filter(|(own, ..)| *own == product) {
        let own = sequences.iter_mut().find(|own| own.name == *name);
        let mut lines = own.into_iter().flat_map(|own| &mut own.lines);
        let line = lines
            .find(|line| line.step == *step)
            .expect("a line to put right");
        line.data = (*data).to_owned();
    }
    sequences
}

/// Plays a sequence; what went wrong.
fn play(product: &str, sequence: &Sequence) -> Result<(), String> {
    let mut bench = scenes::set(product, sequence.name.as_str());
    let lines = &sequence.lines;
    for (place, line) in lines.iter().enumerate() {
        let said = |what: String| format!("step {}: {what}", line.step);
        let Some(cob_id) = line.cob_id else {
            // Something happens, or a number is shown as bytes.
            scenes::happen(product, &sequence.name, line.step, &mut bench).map_err(said)?;
            continue;
        };
        scenes::before(product, &sequence.name, line.step, &mut bench);
        if line.is_sent_by_drive {
            let Some(frame) = bench.next(cob_id, WITHIN) else {
                return Err(said(format!("{cob_id:03X} {} does not come", line.data)));
            };
            if !line.fits(frame.payload()) {
                let came = frame.payload();
                return Err(said(format!("{came:02X?} comes, and not {}", line.data)));
            }
            // A master takes its time.
            bench.run(PAUSE);
            continue;
        }
        bench.sent.clear();
        let frame = line.frame(cob_id);
        bench.send(&frame);
        let is_answered = lines
            .get(place + 1)
            .is_some_and(|next| next.is_sent_by_drive);
        // 80h ends a transfer, and nothing answers it.
        if (0x601..=0x67F).contains(&cob_id) && !is_answered && frame.payload()[0] != 0x80 {
            let answer = bench.next(cob_id - 0x80, WITHIN);
            let answer = answer.ok_or_else(|| said("no answer".to_owned()))?;
            let (told, came) = (frame.payload(), answer.payload());
            if came[0] == 0x80 || came[1..4] != told[1..4] {
                return Err(said(format!("{came:02X?} answers {told:02X?}")));
            }
            bench.run(PAUSE);
        }
    }
    bench.run(PAUSE);
    scenes::after(product, &sequence.name, &mut bench)
}

/// Plays all of a product and prints what they are.
fn play_all(product: &str) {
    let sequences = all(product);
    let mut wrong = Vec::new();
    let mut played = 0;
    for sequence in &sequences {
        let name = sequence.name.as_str();
        let why = NOT_YET
            .iter()
            .find(|(own, listed, _)| (*own, *listed) == (product, name));
        match (play(product, sequence), why) {
            (Ok(()), None) => played += 1,
            (Ok(()), Some(_)) => wrong.push(format!("{name} plays: take it off the list")),
            (Err(what), None) => wrong.push(format!("{name}: {what}")),
            (Err(what), Some((_, _, why))) => println!("{product} {name}: {why} ({what})"),
        }
    }
    println!("{product}: {played} of {} sequences play", sequences.len());
    assert!(wrong.is_empty(), "{product}:\n{}", wrong.join("\n"));
}

#[test]
fn the_sequences_of_the_lmd_play() {
    play_all("lmd");
}

#[test]
fn the_sequences_of_the_nanotec_play() {
    play_all("nanotec");
}

#[test]
fn the_sequences_of_the_s200_play() {
    play_all("s200");
}

#[test]
fn the_sequences_of_the_tc1_play() {
    play_all("tc1");
}

#[test]
fn what_does_not_play_yet_is_a_sequence() {
    for (product, name, _) in NOT_YET {
        let found = all(product).iter().any(|sequence| sequence.name == *name);
        assert!(found, "{product} has no {name}");
    }
}
