//! The recorder of a drive (docs/scope.md), and what its transmit PDOs bring live.

use std::collections::BTreeMap;

use canopen::{Duration, Instant};
use master::Line;
use master::axis402::{Node, Problem};
use master::data_sheet::{Address, DataSheet};
use master::scope::{self, Armed, Before, Progress, Report, Request};

use super::poll::number;
use super::{Session, json};
use crate::line::Passed;
use crate::message::{
    Answer, Event, LiveChannel, LiveValues, Recordable, Recorded, Recorder, Wish,
};

/// What the recorder knows (docs/scope.md), and whether most people want to see it.
const RECORDABLE: [(u16, u8, bool); 20] = [
    (0x606C, 0, true),
    (0x6064, 0, true),
    (0x6062, 0, true),
    (0x60F4, 0, true),
    (0x606B, 0, true),
    (0x6041, 0, true),
    (0x6040, 0, true),
    (0x60FD, 0, true),
    (0x6077, 0, true),
    (0x6074, 0, false),
    (0x6078, 0, false),
    (0x607A, 0, false),
    (0x60FF, 0, false),
    (0x6061, 0, false),
    (0x603F, 0, false),
    (0x6063, 0, false),
    (0x6043, 0, false),
    (0x6044, 0, false),
    (0x2034, 1, false),
    (0x2034, 2, false),
];

/// Whether a drive records itself; another maker's 20D0h is something else.
pub(super) fn has_recorder(sheet: &DataSheet) -> bool {
    let is_ours = |object: &od_gen::model::Object| object.name == "Scope";
    sheet.object(0x20D0).is_some_and(is_ours) && sheet.object(0x20D3).is_some()
}

/// From a look at the recorder to the next.
const LOOK: Duration = Duration::from_ticks(50_000);

/// A recorder that is at work.
#[derive(Clone, Debug)]
pub struct Recording {
    node: Node,
    armed: Armed,
    next: Instant,
}

/// Where the channels are in the transmit PDOs.
#[derive(Clone, Debug, Default)]
pub struct Live {
    channels: Vec<LiveChannel>,
    pdos: BTreeMap<u16, Vec<Place>>,
}

/// A channel in a frame.
#[derive(Clone, Copy, Debug)]
struct Place {
    channel: usize,
    first: u32,
    bits: u32,
    is_signed: bool,
}

impl<L: Line> Session<L> {
    /// What of it the drive has; nothing without a recorder.
    pub(super) fn recordable(&mut self) -> Result<Answer, Problem> {
        let sheet = self.chosen_node()?.sheet;
        if !has_recorder(&sheet) {
            return Ok(Answer::Recordable(Vec::new()));
        }
        let known = RECORDABLE.iter().filter_map(|&(index, sub, is_usual)| {
            let address = Address::new(index, sub);
            Some(Recordable {
                object: address.to_string(),
                name: sheet.name(address)?,
                is_usual,
            })
        });
        Ok(Answer::Recordable(known.collect()))
    }

    pub(super) fn record(&mut self, wish: &Wish) -> Result<Answer, Problem> {
        let node = self.chosen_node()?;
        if wish.before.is_some_and(|percent| percent > 99) {
            let text = "0 to 99 per cent can be older than the trigger";
            return Err(Problem::Usage(text.to_owned()));
        }
        let request = Request::parse(
            Some(&wish.channels),
            &wish.trigger,
            wish.divider,
            wish.samples,
            wish.before.map(Before::Percent),
            Duration::from_ticks(0),
            &node.sheet,
        );
        let request = request.map_err(Problem::Usage)?;
        let armed = scope::arm(&mut self.master, &node, &request)?;
        self.recording = Some(Recording {
            node,
            armed,
            next: self.master.now(),
        });
        self.state.recorder = Some(Recorder::Armed);
        Ok(Answer::Text(String::new()))
    }

    pub(super) fn stop_recorder(&mut self) -> Result<Answer, Problem> {
        self.state.recorder = None;
        if let Some(recording) = self.recording.take() {
            scope::disarm(&mut self.master, &recording.node)?;
        }
        Ok(Answer::Text(String::new()))
    }

    pub(super) fn last_recording(&self) -> Result<Answer, Problem> {
        let last = self.recorded.clone();
        last.map(|last| Answer::Recording(Box::new(last)))
            .ok_or_else(|| Problem::Usage("nothing was recorded yet".to_owned()))
    }

    /// Looks at the recorder if it is time, and fetches what it has.
    pub(super) fn mind_recorder(&mut self) {
        let now = self.master.now();
        let Some(mut recording) = self.recording.take() else {
            return;
        };
        if now < recording.next {
            self.recording = Some(recording);
            return;
        }
        recording.next = now + LOOK;
        let result = self.look_at(&mut recording);
        self.state.recorder = match result {
            Ok(Progress::Full) => None,
            Ok(Progress::Armed) => Some(Recorder::Armed),
            Ok(Progress::Triggered) => Some(Recorder::Triggered),
            // Somebody wants to stop the drive; the recorder does not mind.
            Err(_) if self.master.line_mut().urgent().any() => self.state.recorder,
            Err(problem) => {
                self.state.notice = problem.line();
                None
            }
        };
        if self.state.recorder.is_some() {
            self.recording = Some(recording);
        }
    }

    fn look_at(&mut self, recording: &mut Recording) -> Result<Progress, Problem> {
        let node = &recording.node;
        let progress = recording.armed.progress(&mut self.master, node)?;
        if progress == Progress::Full {
            let fetched = scope::fetch(&mut self.master, node)?;
            self.state.recordings += 1;
            self.recorded = Some(Recorded {
                number: self.state.recordings,
                report: Report::new(node.id, &fetched),
            });
        }
        Ok(progress)
    }

    /// What the transmit PDOs of the drive bring, as they are set up now.
    pub(super) fn channels(&mut self) -> Result<Answer, Problem> {
        let node = self.chosen_node()?;
        let mut live = Live::default();
        for pdo in self.read_pdos(&node)? {
            let Ok(cob_id) = u16::try_from(pdo.cob_id) else {
                continue;
            };
            if pdo.receive || !pdo.enabled {
                continue;
            }
            let mut first = 0;
            for mapped in &pdo.mapped {
                let address = node.sheet.find(&mapped.object).ok();
                let data_type = address.and_then(|address| node.sheet.data_type(address));
                live.pdos.entry(cob_id).or_default().push(Place {
                    channel: live.channels.len(),
                    first,
                    bits: mapped.bits.into(),
                    is_signed: data_type.is_some_and(|known| known.is_signed()),
                });
                live.channels.push(LiveChannel {
                    object: mapped.object.clone(),
                    name: address
                        .and_then(|address| node.sheet.name(address))
                        .unwrap_or_default(),
                    pdo: pdo.number,
                });
                first += u32::from(mapped.bits);
            }
        }
        let channels = live.channels.clone();
        self.live = Some(live);
        Ok(Answer::Channels(channels))
    }

    /// Tells those who listen what has come.
    pub(super) fn tell_live(&self, passed: &[Passed], dropped: u64) {
        let Some(live) = &self.live else {
            return;
        };
        if self.outlet.live.receiver_count() == 0 {
            return;
        }
        let values = live.values(passed);
        if !values.is_empty() || dropped > 0 {
            // Whoever has listened may just have gone.
            let _ = (self.outlet.live).send(json(&Event::Live { values, dropped }));
        }
    }
}

impl Live {
    fn values(&self, passed: &[Passed]) -> Vec<LiveValues> {
        let mut all: BTreeMap<usize, LiveValues> = BTreeMap::new();
        for passed in passed.iter().filter(|passed| !passed.own) {
            let places = passed.frame.standard_id().and_then(|id| self.pdos.get(&id));
            let mut data = [0; 8];
            let payload = passed.frame.payload();
            data[..payload.len().min(8)].copy_from_slice(&payload[..payload.len().min(8)]);
            let word = u64::from_le_bytes(data);
            for place in places.into_iter().flatten() {
                // A frame that is shorter than its mapping brings nothing behind its end.
                if (place.first + place.bits) as usize > 8 * payload.len() {
                    continue;
                }
                let bits = (word >> place.first) & (u64::MAX >> (64 - place.bits.clamp(1, 64)));
                let bytes = bits.to_le_bytes();
                let whole = &bytes[..place.bits.div_ceil(8).min(8) as usize];
                let channel = all.entry(place.channel).or_insert_with(|| LiveValues {
                    channel: place.channel,
                    ..LiveValues::default()
                });
                channel.at.push(passed.at.ticks() as f64 / 1e6);
                channel.values.push(number(whole, place.is_signed));
            }
        }
        all.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canopen::Frame;

    #[test]
    fn values_are_read_at_their_place_with_their_sign() {
        let place = |channel, first, bits, is_signed| Place {
            channel,
            first,
            bits,
            is_signed,
        };
        let live = Live {
            channels: Vec::new(),
            pdos: BTreeMap::from([(
                0x184,
                vec![
                    place(0, 0, 16, false),
                    place(1, 16, 32, true),
                    place(2, 48, 8, true),
                ],
            )]),
        };
        let passed = |at, id, data: &[u8], own| Passed {
            at: Instant::from_ticks(at),
            frame: Frame::data_frame(id, data),
            own,
        };
        let values = live.values(&[
            passed(
                1_000,
                0x184,
                &[0x37, 0x06, 0xFE, 0xFF, 0xFF, 0xFF, 0x80],
                false,
            ),
            passed(2_000, 0x184, &[0x27, 0x06, 1, 0, 0, 0], false),
            passed(3_000, 0x185, &[1; 8], false),
            passed(4_000, 0x184, &[1; 8], true),
        ]);
        let told: Vec<_> = values
            .iter()
            .map(|one| (one.channel, one.values.clone()))
            .collect();
        assert_eq!(
            told,
            [(0, vec![0x637, 0x627]), (1, vec![-2, 1]), (2, vec![-128])]
        );
        assert_eq!(values[1].at, [0.001, 0.002]);
    }
}
