//! Touch probes 1 and 2 of CiA 402-2: objects 60B8h to 60BDh and 60D0h to 60D8h.
//!
//! A probe stores the position of an edge of its source. 60B8h has a byte for each probe: bit 0 switches it on, bit 4 samples positive
//! edges, bit 5 negative ones, bit 1 stores every edge and not only the first. Bits 3 and 2 choose the source: the input of the probe (00), the
//! index pulse (01), or the source in 60D0h (10).
//!
//! The contract:
//! - Position and time are captured at the edge, not in the control tick that sees it: exact to the increment at any speed.
//! - A probe ignores edges before the tick that switched it on, so none of an earlier motion counts.
//! - A probe that is switched off and on again, even between two ticks, starts anew: its bits of 60B9h are 0. It also does when its source
//!   or the polarity of its input (2032h) changes. If only one kind of edge is no longer sampled, only that one starts anew. Positions and times
//!   keep their last values.
//! - 60D5h to 60D8h count every sampled edge, whether or not it is stored.
//! - If the board cannot capture an input, a change of its level counts as an edge in the tick that sees it.
//! - With a filter (2033h:1, in nanoseconds, where a data sheet has it) an edge counts if its level lasts that long; a tick may pass until that is known.
//! - If no input has the chosen source, the probe stays off: bit 0 (8) of 60B9h is 0.
//!
//! Homing uses the same captured edges; neither takes them away from the other.

mod look;

use canopen::Instant;

use motion::low;

use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::copied::copy_fields;
use crate::inputs::{Count, DigitalInputs, Edge, Edges, SOURCE, Source};

use look::Look;

/// 60B8h and 60B9h: the probe is on.
const ENABLE: u8 = 1 << 0;
/// 60B8h: each edge is stored, not only the first.
const CONTINUOUS: u8 = 1 << 1;
const SOURCE_INDEX: u8 = 0b01 << 2;
const SOURCE_SELECTED: u8 = 0b10 << 2;
/// 60B8h: the positive edge is sampled; the negative one is the next bit.
const POSITIVE: u8 = 1 << 4;
/// 60B9h: a positive edge is stored; the negative one is the next bit.
const STORED: u8 = 1 << 1;

/// What the probes have stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Latched {
    /// 60B9h.
    pub status: u16,
    /// 60BAh to 60BDh in user units: probe 1 positive, negative, probe 2 positive, negative.
    pub positions: [i32; 4],
    /// 60D1h to 60D4h in nanoseconds of the drive's time, modulo 2³².
    pub times: [u32; 4],
    /// 60D5h to 60D8h, modulo 2¹⁶.
    pub counters: [u16; 4],
}

impl Latched {
    /// Nothing yet.
    pub const NONE: Self = Self {
        status: 0,
        positions: [0; 4],
        times: [0; 4],
        counters: [0; 4],
    };

    /// Copies field by field: copied as a whole it would be the only call of `memmove` in the image.
    pub(crate) fn assign(&mut self, from: &Self) {
        copy_fields!(Self { status, positions, times, counters }, from => self);
    }
}

/// What a probe has stored of one kind of edge.
#[derive(Clone, Copy, Debug, Default)]
struct Sampler {
    /// 60B9h, bit 1 or 2.
    is_stored: bool,
    /// In increments, as the master counts.
    position: i64,
    time: u32,
    counter: u16,
    /// An edge whose level had not lasted long enough for the filter when the last tick ended.
    held: Option<Edge>,
}

impl Sampler {
    const fn new() -> Self {
        Self {
            is_stored: false,
            position: 0,
            time: 0,
            counter: 0,
            held: None,
        }
    }

    /// Those of the edges of a tick whose level lasts at least for the time of the filter. `back` are the opposite edges; `now` is the time
    /// in nanoseconds.
    fn filtered(
        &mut self,
        edges: Option<Edges>,
        back: Option<Edges>,
        filter: u32,
        now: u32,
    ) -> Option<Edges> {
        let until = |edge: Edge| {
            let back = back.map(|back| [back.first, back.last]);
            let left = back.into_iter().flatten().find_map(|back| {
                let span = back.time.wrapping_sub(edge.time);
                (span.cast_signed() >= 0).then_some(span)
            });
            left.unwrap_or(u32::MAX)
        };
        let held = self.held.take().filter(|held| until(*held) >= filter);
        let last = edges.map(|edges| edges.last);
        let last = last.filter(|last| until(*last) >= filter);
        let lasts = last.filter(|last| now.wrapping_sub(last.time) >= filter);
        self.held = last.filter(|_| lasts.is_none());
        match (held, lasts) {
            (Some(held), Some(lasts)) => {
                let mut both = Edges::one(held);
                both.add(lasts);
                Some(both)
            }
            (one, other) => one.or(other).map(Edges::one),
        }
    }

    fn store(&mut self, edges: &Edges, is_continuous: bool, count: Count) {
        self.counter = self.counter.wrapping_add(edges.count);
        let edge = match (is_continuous, self.is_stored) {
            (true, _) => edges.last,
            (false, false) => edges.first,
            (false, true) => return,
        };
        self.is_stored = true;
        self.position = count.of(edge.position);
        self.time = edge.time;
    }
}

/// One probe.
#[derive(Clone, Copy, Debug)]
struct Probe {
    /// Its byte of 60B8h as the last tick found it.
    function: u8,
    /// The inputs of its source; 0 while it is off.
    mask: u8,
    /// Those of them that are active low.
    inverted: u8,
    /// The positive and the negative edge.
    samplers: [Sampler; 2],
}

impl Probe {
    const fn new() -> Self {
        Self {
            function: 0,
            mask: 0,
            inverted: 0,
            samplers: [const { Sampler::new() }; 2],
        }
    }

    /// Sets another function, source or input than in the last tick.
    fn set_up(&mut self, function: u8, mask: u8, inverted: u8, restarts: bool) {
        let starts_anew = restarts
            || mask != self.mask
            || inverted != self.inverted
            || function & !self.function & ENABLE != 0
            || function & ENABLE == 0;
        let mut bit = POSITIVE;
        for sampler in &mut self.samplers {
            sampler.is_stored &= !starts_anew && function & bit != 0;
            sampler.held = sampler.held.filter(|_| !starts_anew);
            bit <<= 1;
        }
        self.function = function;
        self.mask = mask;
        self.inverted = inverted;
    }

    /// Its byte of 60B9h.
    const fn status(&self) -> u8 {
        let [positive, negative] = self.samplers;
        let is_on = self.mask != 0;
        if is_on {
            ENABLE
                | if positive.is_stored { STORED } else { 0 }
                | if negative.is_stored { STORED << 1 } else { 0 }
        } else {
            0
        }
    }
}

/// Both probes.
#[derive(Debug)]
pub(crate) struct TouchProbes {
    probes: [Probe; 2],
    /// 60B8h and 60D0h as the last tick found them.
    function: u16,
    sources: [Source; 2],
    /// Bits 0 and 8 of 60B8h that were 0 in an early tick since.
    off: u16,
    /// Levels at the pins in the last tick, before 2032h: a change of 2032h is no edge.
    levels: u8,
    inputs: [u8; 4],
    is_news: bool,
    /// An edge waits for its filter.
    is_held: bool,
}

impl TouchProbes {
    pub(crate) const fn new() -> Self {
        Self {
            probes: [const { Probe::new() }; 2],
            function: 0,
            sources: [Source::Probe1, Source::Probe2],
            off: 0,
            levels: 0,
            inputs: [0; 4],
            is_news: false,
            is_held: false,
        }
    }

    /// One tick.
    pub(crate) fn observe(
        &mut self,
        now: Instant,
        inputs: &DigitalInputs,
        commands: &Commands,
        configuration: &Configuration,
        count: Count,
    ) {
        let before = core::mem::replace(&mut self.levels, inputs.levels);
        let is_idle = commands.touch_probe_function == 0 && self.function == 0;
        if is_idle {
            return;
        }
        let changed = (inputs.levels ^ before) | inputs.changed;
        if changed != 0 || self.is_held {
            self.sample(now, inputs, before, configuration, count);
        }
        self.follow(commands, configuration);
    }

    /// Notes the commands of an early tick. The next regular tick carries them out, after the edges that it sees.
    pub(crate) const fn follow_later(&mut self, commands: &Commands) {
        self.off |= commands.touch_probes_off;
    }

    /// The stored positions have other numbers now, and are to be shown again.
    pub(crate) const fn show_anew(&mut self) {
        self.is_news = true;
    }

    /// What the probes have stored, if that has changed since the last call. `shown` converts a position of the drive to that in objects.
    pub(crate) fn take_news(&mut self, shown: impl Fn(i64) -> i32) -> Option<Latched> {
        core::mem::take(&mut self.is_news).then(|| self.latched(shown))
    }

    #[cold]
    #[inline(never)]
    fn latched(&self, shown: impl Fn(i64) -> i32) -> Latched {
        let [first, second] = &self.probes;
        let [a, b] = first.samplers;
        let [c, d] = second.samplers;
        let samplers = [a, b, c, d];
        Latched {
            status: u16::from_le_bytes([first.status(), second.status()]),
            positions: samplers.map(|sampler| shown(sampler.position)),
            times: samplers.map(|sampler| sampler.time),
            counters: samplers.map(|sampler| sampler.counter),
        }
    }

    /// Sets the probes up if 60B8h, 60D0h or the inputs have changed. Called after the edges of the tick are stored, as they came before.
    #[inline(never)]
    fn follow(&mut self, commands: &Commands, configuration: &Configuration) {
        let given = [
            configuration.inputs.index,
            configuration.inputs.touch_probes[0],
            configuration.inputs.touch_probes[1],
            configuration.inputs.inverted,
        ];
        let is_same = commands.touch_probe_function == self.function
            && commands.touch_probes_off | self.off == 0
            && configuration.touch_probe_sources == self.sources
            && given == self.inputs;
        if !is_same {
            self.inputs = given;
            self.set_up(commands, configuration);
        }
    }

    #[cold]
    #[inline(never)]
    fn set_up(&mut self, commands: &Commands, configuration: &Configuration) {
        self.function = commands.touch_probe_function;
        self.sources = configuration.touch_probe_sources;
        let own = [Source::Probe1, Source::Probe2];
        let functions = self.function.to_le_bytes();
        let off = commands.touch_probes_off | core::mem::take(&mut self.off);
        let off = off.to_le_bytes();
        let parts = functions
            .into_iter()
            .zip(off)
            .zip(own.into_iter().zip(self.sources));
        for (probe, ((function, off), (own, selected))) in self.probes.iter_mut().zip(parts) {
            let source = match function & SOURCE {
                SOURCE_INDEX => Source::Index,
                SOURCE_SELECTED => selected,
                _ => own,
            };
            let mask = if function & ENABLE != 0 {
                source.mask(&configuration.inputs)
            } else {
                0
            };
            let inverted = configuration.inputs.inverted & mask;
            probe.set_up(function, mask, inverted, off & ENABLE != 0);
        }
        self.is_news = true;
    }

    /// Stores the edges of this tick.
    #[cold]
    #[inline(never)]
    fn sample(
        &mut self,
        now: Instant,
        inputs: &DigitalInputs,
        before: u8,
        configuration: &Configuration,
        count: Count,
    ) {
        let filter = u32::from(configuration.capture_filter);
        let configuration = &configuration.inputs;
        self.is_held = false;
        let look = Look {
            inputs,
            before: before ^ configuration.inverted,
            active: inputs.levels ^ configuration.inverted,
            inverted: configuration.inverted,
            now: Edge {
                // Without a captured position, that of the motor now counts.
                position: count.board_position(),
                time: nanoseconds(now),
            },
        };
        for probe in &mut self.probes {
            if probe.mask == 0 {
                continue;
            }
            let is_continuous = probe.function & CONTINUOUS != 0;
            let mut bit = POSITIVE;
            for (sampler, to_active) in probe.samplers.iter_mut().zip([true, false]) {
                if probe.function & bit != 0 {
                    let mut edges = look.edges(probe.mask, to_active);
                    if filter != 0 {
                        let back = look.edges(probe.mask, !to_active);
                        edges = sampler.filtered(edges, back, filter, look.now.time);
                        self.is_held |= sampler.held.is_some();
                    }
                    if let Some(edges) = edges {
                        sampler.store(&edges, is_continuous, count);
                        self.is_news = true;
                    }
                }
                bit <<= 1;
            }
        }
    }
}

/// A moment in the unit of the times of edges.
const fn nanoseconds(now: Instant) -> u32 {
    low::u32(now.ticks().wrapping_mul(1000))
}

#[cfg(test)]
mod tests;
