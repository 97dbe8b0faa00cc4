//! From positions to pulses: chords of a plan become pulse-train records.
//!
//! A step belongs where the position crosses the middle between two whole steps. Over a chord the crossings are evenly spaced, so
//! a whole chord is two runs of periods, `base + 1` and `base` ticks long. The period after the last pulse stays open until
//! the next chord tells where it ends. Ticks and pulses therefore add up by construction: nothing is rounded twice.
//!
//! How many steps are due is always the difference between the position and the steps made. A pulse that the driver's timing
//! delays is made later, and never lost.

pub(crate) mod slope;
mod steady;

use crate::clock::Ticks;
use crate::crossings::Crossings;
use crate::fixed::{Position, State, Velocity};
use crate::record::{Direction, DriverTiming, Record, SHORTEST_RECORD};

/// Records that one chord can make at most: three for the open period, one more at a change of direction, three runs, one for a long
/// silence, and two if what is open then is handed out with it.
const MOST_RECORDS: usize = 11;

/// The pulses of a run are counted in 16 bits.
const LONGEST_RUN: u32 = u16::MAX as u32;

const NO_ROOM: &str = "a chord makes more records than it can";

/// Chords per segment at most, however hard the acceleration: it bounds the work of a control tick.
const CHORDS_PER_SEGMENT: u32 = 32;

/// From so many pulses in a chord on, the open period before it is as long as the periods in it.
const MANY: u32 = 8;

/// A microsecond at 168 MHz, in ticks: faster pulses may be off by that, but for an eighth.
const CROWDED: u32 = 168;

/// Pulses of a chord at most: in three runs they are off by an eighth of that in ticks.
const MOST_PULSES: u32 = 8 * CROWDED;

/// A stretch of the plan, taken as a straight line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord {
    /// When it begins.
    pub(crate) begin: Ticks,
    /// How long it takes, in ticks: at least 1, and no longer than a segment.
    pub(crate) length: u32,
    /// Where it begins and ends.
    pub(crate) from: Position,
    pub(crate) to: Position,
    /// Whether the speed grows: the longer periods come first then, and otherwise last.
    pub(crate) speeding_up: bool,
    /// Whether the speed stays: the next chord may be like this one.
    pub(crate) steady: bool,
}

impl Chord {
    /// From one state to the next, so many ticks later.
    pub(crate) fn between((begin, from): (Ticks, State), (length, to): (u32, State)) -> Self {
        let (before, after) = (from.velocity.bits(), to.velocity.bits());
        Self {
            begin,
            length,
            from: from.position,
            to: to.position,
            speeding_up: after.unsigned_abs() >= before.unsigned_abs(),
            steady: after == before,
        }
    }
}

/// Makes records from chords, and keeps the account of steps and ticks.
#[derive(Debug, Clone)]
pub(crate) struct Train {
    /// Ticks of the step signal being high.
    width: u16,
    /// What follows from the driver's times: the shortest period between pulses, the shortest record of one period, and from the
    /// beginning of the last pulse to a change of direction and from there to the next pulse.
    shortest: u32,
    least: u32,
    hold: u32,
    setup: u32,
    segment: u32,
    /// The longest chord, the speed up to which it may be so long, Q24 steps per tick, and the shortest chord.
    longest: u32,
    easy: u32,
    least_chord: u32,
    /// The speed of a pulse in each segment, Q32 steps per tick.
    slowest: u32,
    /// Steps made, modulo 2³².
    steps: i32,
    /// The level of the direction signal; `None` until a record has set it.
    direction: Option<Direction>,
    /// Up to here there are records. What follows is the open period.
    pen: Ticks,
    /// The step of the pulse with which the open period begins, 1 or −1; 0 if it is silent.
    open_step: i32,
    /// Whether the last chord was steady and has all its pulses.
    even: bool,
    /// The period of the last run; 0 if its last pulse is not where it belongs.
    period: u32,
    /// Records made, and how many.
    made: [Record; MOST_RECORDS],
    count: u8,
}

impl Train {
    /// A train that stands at `steps` at tick `pen`. `segment` is brought into a range that `timing` allows.
    pub(crate) fn new(timing: DriverTiming, segment: u32, steps: i32, pen: Ticks) -> Self {
        let timing = timing.checked();
        let shortest = timing.shortest_period();
        let least = shortest.max(SHORTEST_RECORD);
        let hold = timing.pulse_high.saturating_add(timing.direction_hold);
        let (hold, setup) = (least.max(hold), least.max(timing.direction_setup));
        // Long enough that a record of one segment keeps every time of the driver.
        let turn = hold.saturating_add(setup);
        let segment = segment.min(1 << 28).max(turn.saturating_mul(2));
        let longest = segment.min(shortest.saturating_mul(LONGEST_RUN));
        Self {
            width: timing.pulse_high as u16,
            shortest,
            least,
            hold,
            setup,
            segment,
            longest,
            easy: (MOST_PULSES << 20)
                .checked_div(longest >> 4)
                .unwrap_or(u32::MAX)
                .min(1 << 24),
            least_chord: longest.min(segment / CHORDS_PER_SEGMENT),
            slowest: u32::MAX.checked_div(segment).unwrap_or(0).wrapping_add(1),
            steps,
            direction: None,
            pen,
            open_step: 0,
            even: false,
            period: 0,
            made: [Record::NONE; MOST_RECORDS],
            count: 0,
        }
    }

    /// Starts anew at `steps` and `pen`: what was open or not handed out is dropped, and the direction is unknown.
    pub(crate) fn reset(&mut self, steps: i32, pen: Ticks) {
        self.steps = steps;
        self.pen = pen;
        self.open_step = 0;
        self.even = false;
        self.period = 0;
        self.direction = None;
        self.count = 0;
    }

    /// The shortest period between two pulses, in ticks.
    pub(crate) const fn shortest_period(&self) -> u32 {
        self.shortest
    }

    /// The length of a segment in ticks. No record is longer, but for a run that begins with the last pulse before its chord.
    pub(crate) const fn segment(&self) -> u32 {
        self.segment
    }

    /// How long a chord from `velocity` on is if the plan allows `longest`, in ticks: so that it has no more than [`MOST_PULSES`]. It is a
    /// segment of 250 µs where the plan allows it, up to 5 MHz.
    #[inline]
    pub(crate) fn chord(&self, velocity: Velocity, longest: u32) -> u32 {
        let speed = (velocity.bits().unsigned_abs() >> 32) as u32;
        let most = if speed <= self.easy {
            self.longest
        } else {
            self.shorter_chord(speed)
        };
        most.min(longest).max(self.least_chord)
    }

    /// The longest chord, in ticks.
    pub(crate) const fn longest(&self) -> u32 {
        self.longest
    }

    /// The speed up to which a chord may be the longest, Q24 steps per tick.
    #[inline]
    pub(crate) const fn easy(&self) -> u32 {
        self.easy
    }

    /// Whether a chord at `velocity` may be the longest.
    #[inline]
    pub(crate) const fn is_easy(&self, velocity: Velocity) -> bool {
        let speed = (velocity.bits() >> 32) as u32;
        speed.wrapping_add(self.easy) < self.easy << 1
    }

    /// Divisions are dear, and this one is seldom needed.
    #[cold]
    fn shorter_chord(&self, speed: u32) -> u32 {
        let length = (MOST_PULSES << 20).checked_div(speed >> 4);
        length.map_or(self.longest, |length| length.min(self.longest))
    }

    /// The tick up to which there are records.
    pub(crate) const fn pen(&self) -> Ticks {
        self.pen
    }

    /// Whether nothing is open at tick `now`.
    pub(crate) fn is_closed(&self, now: Ticks) -> bool {
        !self.has_pulse() && self.pen >= now
    }

    /// Whether there are records to hand out.
    #[inline]
    pub(crate) const fn is_waiting(&self) -> bool {
        self.count != 0
    }

    /// The records to hand out.
    #[inline]
    pub(crate) fn waiting(&self) -> &[Record] {
        self.made.get(..usize::from(self.count)).unwrap_or_default()
    }

    /// All of them have been handed out.
    #[inline]
    pub(crate) fn handed_out(&mut self) {
        self.count = 0;
    }

    /// Only the first `records` of them have been handed out.
    pub(crate) fn handed_out_part(&mut self, records: usize) {
        self.count = self.count.saturating_sub(records as u8);
        for place in 0..usize::from(self.count) {
            let left = self.made.get(place.wrapping_add(records)).copied();
            if let (Some(place), Some(left)) = (self.made.get_mut(place), left) {
                *place = left;
            }
        }
    }

    /// Steps up to the pen, modulo 2³²: those made, but for the one in the open period.
    #[inline]
    pub(crate) fn steps_at_pen(&self) -> i32 {
        self.steps.wrapping_sub(self.open_step)
    }

    /// Steps due when the axis is at `position`, with their sign.
    pub(crate) fn due(&self, position: Position) -> i32 {
        // Positions wrap at 2³² steps, and so does the difference.
        (position.whole_steps() as i32).wrapping_sub(self.steps)
    }

    /// The next step in the direction of those due, modulo 2³².
    pub(crate) const fn step(&self, due: i32) -> i32 {
        self.steps.wrapping_add(due.signum())
    }

    /// Makes the records of a chord. Those before must have been handed out.
    #[inline(never)]
    pub(crate) fn draw(&mut self, chord: &Chord) {
        self.even = false;
        let way = chord.to.bits().wrapping_sub(chord.from.bits());
        let due = self.due(chord.to);
        // The plan knows the way it goes. Steps due the other way are rounding at a turning point, unless the plan stands.
        let direction = match way {
            0 if due < 0 => Direction::Reverse,
            0.. => Direction::Forward,
            _ => Direction::Reverse,
        };
        let due = due.wrapping_mul(direction.sign());
        if due > 0 {
            let pulses = due.unsigned_abs();
            let crossings = Crossings::new(chord.length, way.unsigned_abs());
            let turn = |value: i64| match direction {
                Direction::Forward => value,
                Direction::Reverse => value.wrapping_neg(),
            };
            let last = crossings.after(self.lead(chord, turn, pulses));
            let joins = self.join(chord, direction, pulses, last);
            let made = if joins {
                pulses
            } else {
                let first = crossings.after(self.lead(chord, turn, 1));
                self.run(chord, direction, pulses, (first, last))
            };
            self.even = chord.steady && made == pulses;
            if made != pulses || !self.is_at(chord, last) {
                self.period = 0;
            }
        }
        self.keep_short(direction, chord);
    }

    /// From the chord's beginning to the crossing of so many steps, Q32 steps.
    #[inline]
    fn lead(&self, chord: &Chord, turn: impl Fn(i64) -> i64, pulses: u32) -> i64 {
        let made = i64::from(self.steps).wrapping_shl(32);
        // In the middle between two steps.
        turn(made.wrapping_sub(chord.from.bits()))
            .wrapping_add(i64::from(pulses).wrapping_shl(32))
            .wrapping_sub(1 << 31)
    }

    /// Whether the open period begins with a pulse.
    #[inline]
    const fn has_pulse(&self) -> bool {
        self.open_step != 0
    }

    /// Ticks from the pen to `now`; negative if the pen is ahead. Never more than a segment and the driver's times, either way.
    #[inline]
    fn open_at(&self, now: Ticks) -> i32 {
        (now as u32).wrapping_sub(self.pen as u32).cast_signed()
    }

    /// Whether the pen is so many ticks behind the chord's beginning.
    #[inline]
    fn is_at(&self, chord: &Chord, offset: u32) -> bool {
        self.open_at(chord.begin)
            .cast_unsigned()
            .wrapping_add(offset)
            == 0
    }

    /// Closes the open period at `now`, or as soon after it as the driver allows. The axis stands.
    pub(crate) fn close(&mut self, now: Ticks) {
        let least = if self.has_pulse() {
            self.hold
        } else {
            self.least
        };
        let open = self.open_at(now).max(0).cast_unsigned();
        if self.has_pulse() || open > 0 {
            let direction = self.direction.unwrap_or(Direction::Forward);
            self.silence(open.max(least), direction);
        }
    }

    /// `pulses` evenly spaced pulses, from `first` to `last`, in ticks from the chord's beginning; as many of them as fit in the chord.
    /// Gives how many were made.
    fn run(
        &mut self,
        chord: &Chord,
        direction: Direction,
        pulses: u32,
        (first, last): (u32, u32),
    ) -> u32 {
        let shortest = self.shortest;
        let open = self.open_at(chord.begin);
        let (first, last) = (first.cast_signed(), last.cast_signed());
        let length = chord.length.cast_signed();
        let joins = pulses >= MANY
            && self.has_pulse()
            && self.direction == Some(direction)
            && is_alike(open.wrapping_add(first), last.wrapping_sub(first), pulses);
        let (begin, gaps) = if joins {
            (open.wrapping_neg(), pulses)
        } else {
            let first = first.max(self.wait(direction).wrapping_sub(open));
            if first > length {
                return 0;
            }
            (first, pulses.wrapping_sub(1))
        };
        let mut gaps = gaps.min(LONGEST_RUN);
        let mut span = last.wrapping_sub(begin).max(0).cast_unsigned();
        if span < gaps.saturating_mul(shortest) {
            // Too dense for the driver: at its highest rate, and what does not fit is due in the next chord.
            let room = length.wrapping_sub(begin).max(0).cast_unsigned();
            gaps = gaps.min(room.checked_div(shortest).unwrap_or(0));
            span = gaps.wrapping_mul(shortest);
        }
        let made = if joins {
            gaps
        } else {
            self.open_pulse(open.wrapping_add(begin).cast_unsigned(), direction);
            gaps.wrapping_add(1)
        };
        if gaps > 0 {
            self.space(gaps, span, chord.speeding_up, direction);
        }
        let steps = made.cast_signed().wrapping_mul(direction.sign());
        self.steps = self.steps.wrapping_add(steps);
        made
    }

    /// So many periods in so many ticks, each beginning with a pulse. What remains when the ticks are shared out is one tick more in
    /// some periods. A run would be too short for a record only at the highest rates; its few ticks are left to the open period.
    fn space(&mut self, gaps: u32, span: u32, speeding_up: bool, direction: Direction) {
        let base = span.checked_div(gaps).unwrap_or(0);
        self.period = base;
        let longer = span.wrapping_sub(base.wrapping_mul(gaps));
        let long = (base.wrapping_add(1), longer);
        let short = (base, gaps.wrapping_sub(longer));
        let (more, fewer) = if long.1 > short.1 {
            (long, short)
        } else {
            (short, long)
        };
        if base.wrapping_mul(fewer.1) < SHORTEST_RECORD {
            // All alike. One gap alone may have to be stretched to be a record.
            let mut period = more.0;
            if period.wrapping_mul(gaps) < SHORTEST_RECORD {
                period = SHORTEST_RECORD.div_ceil(gaps.max(1));
            }
            self.make(period, gaps, true, direction);
            return;
        }
        // The pulses of two runs are off by more · fewer / gaps ticks at most. Where that is too much, the fewer periods stand in the middle of
        // the others: so pulses are ahead in one half and behind in the other, and half as far.
        let enough = if base < CROWDED {
            gaps.wrapping_mul(CROWDED - (CROWDED >> 3))
        } else {
            // A sixteenth of a step.
            span >> 4
        };
        let outer = more.1 >> 1;
        let is_crowded = more.1.wrapping_mul(fewer.1) > enough;
        let (first, second) = if is_crowded && base.wrapping_mul(outer) >= SHORTEST_RECORD {
            self.put(more.0, outer, direction);
            (fewer, (more.0, more.1.wrapping_sub(outer)))
        } else if speeding_up {
            (long, short)
        } else {
            (short, long)
        };
        self.put_both([first, second], direction);
        self.pen = self.pen.wrapping_add(span.into());
    }

    /// Two runs at once, as they are in most chords.
    #[inline]
    fn put_both(&mut self, runs: [(u32, u32); 2], direction: Direction) {
        let (width, made) = (self.width, usize::from(self.count));
        let room = self.made.get_mut(made..);
        let room = room.and_then(|room| room.first_chunk_mut::<2>());
        debug_assert!(room.is_some(), "{NO_ROOM}");
        if let Some(room) = room {
            *room = runs.map(|(period, repeat)| Record {
                period,
                repeat: repeat as u16,
                width,
                direction,
            });
            self.count = self.count.wrapping_add(2);
        }
    }

    /// A run of pulses; the pen follows.
    #[inline]
    fn put(&mut self, period: u32, repeat: u32, direction: Direction) {
        self.keep(Record {
            period,
            repeat: repeat as u16,
            width: self.width,
            direction,
        });
    }

    /// Ticks from the pen to the earliest pulse in `direction`.
    fn wait(&self, direction: Direction) -> i32 {
        let turning = self.direction != Some(direction);
        let wait = match (turning, self.has_pulse()) {
            (false, _) => self.least,
            (true, false) => self.setup,
            (true, true) => self.hold.saturating_add(self.setup),
        };
        wait.cast_signed()
    }

    /// Up to where there have to be chords for [`Train::flush`] to bring the records up to `enough`.
    #[inline]
    pub(crate) fn far_behind(&self, enough: Ticks) -> Ticks {
        // A driver's times have 25 bits.
        enough.wrapping_add(self.hold.wrapping_add(self.least).into())
    }

    /// Makes a record of the open period without waiting for its end, up to just before `now`.
    pub(crate) fn flush(&mut self, now: Ticks) {
        let open = self.open_at(now).max(0).cast_unsigned();
        let open = open.saturating_sub(self.least);
        self.silence(open, self.direction.unwrap_or(Direction::Forward));
    }

    /// Ends the open period, `ticks` long, where a pulse begins, at or after [`Train::wait`]; the period after the pulse is open then.
    fn open_pulse(&mut self, mut ticks: u32, direction: Direction) {
        if self.direction != Some(direction) && self.has_pulse() {
            let before = self.direction.unwrap_or(direction);
            self.silence(self.hold, before);
            ticks = ticks.saturating_sub(self.hold);
        }
        self.silence(ticks, direction);
        self.direction = Some(direction);
        self.open_step = direction.sign();
    }

    /// Keeps the open period at the end of a chord from growing beyond a segment: the pulse and silence so far become a record.
    fn keep_short(&mut self, direction: Direction, chord: &Chord) {
        let open = self.open_at(chord.begin);
        let open = open.wrapping_add(chord.length.cast_signed());
        // What stays open is long enough for a record of its own, so the next pulse need not wait for it.
        if open >= self.segment.wrapping_add(self.least).cast_signed() {
            let level = if self.has_pulse() {
                self.direction.unwrap_or(direction)
            } else {
                direction
            };
            self.direction = Some(level);
            self.silence(self.segment, level);
        }
    }

    /// Records for `ticks` of the open period: its pulse if it has one, then silence. None is longer than a segment or shorter than
    /// the driver's shortest period.
    #[inline]
    fn silence(&mut self, ticks: u32, direction: Direction) {
        let ticks = if ticks > self.segment {
            self.shorten(ticks, direction)
        } else {
            ticks
        };
        if ticks > 0 {
            let width = if self.has_pulse() { self.width } else { 0 };
            self.keep(Record {
                period: ticks,
                repeat: 1,
                width,
                direction,
            });
            self.pen = self.pen.wrapping_add(ticks.into());
        }
        self.open_step = 0;
        // What follows is a pulse by itself, or the first of a run with periods of its own.
        self.period = 0;
    }

    /// Records of all but the last segment of silence.
    #[cold]
    fn shorten(&mut self, mut ticks: u32, direction: Direction) -> u32 {
        while ticks > self.segment {
            let part = self.segment.min(ticks.saturating_sub(self.least));
            self.make(part, 1, self.has_pulse(), direction);
            self.open_step = 0;
            ticks = ticks.saturating_sub(part);
        }
        ticks
    }

    fn make(&mut self, period: u32, repeat: u32, pulse: bool, direction: Direction) {
        if period == 0 || repeat == 0 {
            return;
        }
        let width = if pulse { self.width } else { 0 };
        let record = Record {
            period,
            repeat: repeat as u16,
            width,
            direction,
        };
        self.keep(record);
        self.pen = self.pen.wrapping_add(record.ticks());
    }

    #[inline]
    fn keep(&mut self, record: Record) {
        let room = self.made.get_mut(usize::from(self.count));
        debug_assert!(room.is_some(), "{NO_ROOM}");
        if let Some(room) = room {
            *room = record;
            self.count = self.count.wrapping_add(1);
        }
    }
}

/// Whether the open period, up to the first of so many pulses, is as long as those between them, which take `span` ticks, but for an
/// eighth: it can be one of them then, and needs no record of its own.
fn is_alike(open: i32, span: i32, pulses: u32) -> bool {
    if open < 0 {
        return false;
    }
    let (open, span) = (open.cast_unsigned(), span.cast_unsigned());
    let all = u64::from(open).wrapping_mul(pulses.wrapping_sub(1).into());
    all.abs_diff(span.into()) <= u64::from(span >> 3)
}

#[cfg(test)]
mod tests;
