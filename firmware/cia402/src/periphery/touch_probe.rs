//! Touch probes 1 and 2 of CiA 402-2: objects 60B8h to 60BDh and 60D0h to 60D8h.
//!
//! A probe keeps the position at which an edge of its source came. 60B8h switches it on (bit 0; bit 8 for probe 2) and says which edges are sampled
//! (bit 4 positive, bit 5 negative), and whether each one is (bit 1) or the first alone. The source is its input (bits 3 and 2 = 00), the index
//! pulse (01), or what 60D0h names (10).
//!
//! The contract:
//! - A position is that of the pulse count at the edge, as it was captured, not that of the control tick that sees it: exact to the
//!   increment at any speed. Its time is that of the edge.
//! - Only edges count that come after the tick that switched the probe on, so none of a former motion.
//! - Switched off and on again, even between two ticks, a probe starts anew: the bits of 60B9h are 0. So it does when its source changes, or
//!   whether an input of it is inverted (2032h); an edge that is no longer sampled starts anew alone. Positions and times keep their last values.
//! - Every edge that is sampled counts in 60D5h to 60D8h, whether or not it is kept.
//! - An input with a change that was not captured (a board that cannot) counts as an edge in the tick that sees it.
//! - With a filter (2033h:1, in nanoseconds, where a data sheet has it) an edge counts whose level lasts so long; it is known a tick later if need be.
//! - A source that no input has leaves the probe off: bit 0 (8) of 60B9h stays 0.
//!
//! Probes look at the captured edges that homing looks at, and take none away from it.

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
/// 60B8h: each edge is kept, not only the first.
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

    /// Takes over all of other ones, field by field: as one it would be the only call of `memmove` there is.
    pub(crate) fn assign(&mut self, from: &Self) {
        copy_fields!(Self { status, positions, times, counters }, from => self);
    }
}

/// An edge that is sampled, or not.
#[derive(Clone, Copy, Debug, Default)]
struct Sampler {
    /// 60B9h, bit 1 or 2.
    is_stored: bool,
    /// In increments, as the master counts.
    position: i64,
    time: u32,
    counter: u16,
    /// An edge at the end of a tick, whose level has not lasted long enough yet.
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

    /// The edges whose level lasts for the filter, of the last ones of a tick; `back` are those away from it. `now` is the time in nanoseconds.
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
    /// Those of them that are active while they are low.
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

    /// Another function, source or input than in the last tick.
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
    /// Bits 0 and 8 of 60B8h that were 0 in early ticks since.
    off: u16,
    /// Bare levels in the last tick: another 2032h is no edge.
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

    /// These commands are those of an early tick: they count from the next regular one on, behind the edges that it brings.
    pub(crate) const fn follow_later(&mut self, commands: &Commands) {
        self.off |= commands.touch_probes_off;
    }

    /// Positions have other numbers: those that are stored are news.
    pub(crate) const fn show_anew(&mut self) {
        self.is_news = true;
    }

    /// What has become new since the last call; `shown` gives the position that objects show for one of the drive's.
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

    /// 60B8h, 60D0h or the inputs may have changed. Comes behind the edges of the tick: they came before.
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

    /// Something has happened at the inputs.
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
                // What is not captured is where the motor is now.
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

/// A moment as edges have it.
const fn nanoseconds(now: Instant) -> u32 {
    low::u32(now.ticks().wrapping_mul(1000))
}

#[cfg(test)]
mod tests;
