//! From positions to pulses: chords of a plan become pulse-train records.
//!
//! A step belongs where the position crosses the middle between two whole steps. Over a chord the crossings are evenly spaced, so
//! a whole chord is two runs of periods, `base + 1` and `base` ticks long. The period after the last pulse stays open until
//! the next chord tells where it ends. Ticks and pulses therefore add up by construction: nothing is rounded twice.
//!
//! How many steps are due is always the difference between the position and the steps made. A pulse that the driver's timing
//! delays is made later, and never lost.

use crate::clock::Ticks;
use crate::divide::estimate;
use crate::fixed::{Position, Velocity};
use crate::record::{Direction, DriverTiming, Record, SHORTEST_RECORD};

/// Records that one chord can make at most: three for the open period, one more at a change of direction, three runs, and one for
/// a long silence.
const MOST_RECORDS: usize = 8;

/// The pulses of a run are counted in 16 bits.
const LONGEST_RUN: u32 = u16::MAX as u32;

/// From so many pulses in a chord on, the open period before it is as long as the periods in it.
const MANY: u32 = 8;

/// A stretch of the plan, taken as a straight line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord {
    /// Where it begins.
    pub(crate) from: (Ticks, Position),
    /// Where it ends; later than it begins.
    pub(crate) to: (Ticks, Position),
    /// Whether the speed grows: the longer periods come first then, and otherwise last.
    pub(crate) speeding_up: bool,
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
    segment: u64,
    /// Steps made, modulo 2³².
    steps: i32,
    /// The level of the direction signal; `None` until a record has set it.
    direction: Option<Direction>,
    /// Up to here there are records. What follows is the open period.
    pen: Ticks,
    /// Whether the open period begins with a pulse.
    pulse: bool,
    /// Records made, how many, and how many of them have been handed out.
    made: [Record; MOST_RECORDS],
    count: u8,
    handed_out: u8,
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
        let turn = u64::from(hold).saturating_add(setup.into());
        Self {
            width: timing.pulse_high as u16,
            shortest,
            least,
            hold,
            setup,
            segment: u64::from(segment.min(1 << 28)).max(turn.saturating_mul(2)),
            steps,
            direction: None,
            pen,
            pulse: false,
            made: [Record::NONE; MOST_RECORDS],
            count: 0,
            handed_out: 0,
        }
    }

    /// Starts anew at `steps` and `pen`: what was open or not handed out is dropped, and the direction is unknown.
    pub(crate) fn reset(&mut self, steps: i32, pen: Ticks) {
        self.steps = steps;
        self.pen = pen;
        self.pulse = false;
        self.direction = None;
        self.count = 0;
        self.handed_out = 0;
    }

    /// The shortest period between two pulses, in ticks.
    pub(crate) const fn shortest_period(&self) -> u32 {
        self.shortest
    }

    /// The length of a segment in ticks. No record is longer, but for a run that begins with the last pulse before its chord.
    pub(crate) const fn segment(&self) -> u64 {
        self.segment
    }

    /// The longest chord at `velocity`, in ticks: so that no run has more pulses than a record can count, and that evenly
    /// spaced pulses stay within three sixteenths of a step of the chord.
    pub(crate) fn longest_chord(&self, velocity: Velocity) -> u64 {
        // Two kinds of period, one in the middle of the other: v² · length / 8 ≤ 3/16, with v in Q24.
        const MOST: u64 = 3 << 47;
        let speed = velocity.bits().unsigned_abs() >> 32;
        let square = speed.wrapping_mul(speed);
        let longest = self
            .segment
            .min(u64::from(self.shortest).wrapping_mul(LONGEST_RUN.into()));
        // Divisions are dear, and this one seldom limits.
        if longest.saturating_mul(square) <= MOST {
            return longest;
        }
        MOST.checked_div(square).unwrap_or(longest)
    }

    /// The tick up to which there are records.
    pub(crate) const fn pen(&self) -> Ticks {
        self.pen
    }

    /// Whether nothing is open at tick `now`.
    pub(crate) fn is_closed(&self, now: Ticks) -> bool {
        !self.pulse && self.pen >= now
    }

    /// The next record to hand out.
    pub(crate) fn next(&self) -> Option<Record> {
        if self.handed_out < self.count {
            self.made.get(usize::from(self.handed_out)).copied()
        } else {
            None
        }
    }

    /// The record from [`Train::next`] has been handed out.
    pub(crate) fn handed_out(&mut self) {
        self.handed_out = self.handed_out.wrapping_add(1);
        if self.handed_out >= self.count {
            self.handed_out = 0;
            self.count = 0;
        }
    }

    /// Steps due when the axis is at `position`, with their sign.
    pub(crate) fn due(&self, position: Position) -> i32 {
        // Positions wrap at 2³² steps, and so does the difference.
        (position.whole_steps() as i32).wrapping_sub(self.steps)
    }

    /// Makes the records of a chord. Those before must have been handed out.
    pub(crate) fn draw(&mut self, chord: &Chord) {
        let (begin, origin) = chord.from;
        let (end, goal) = chord.to;
        let way = goal.bits().wrapping_sub(origin.bits());
        let due = self.due(goal);
        // The plan knows the way it goes. Steps due the other way are rounding at a turning point, unless the plan stands.
        let direction = match way {
            0 if due < 0 => Direction::Reverse,
            0.. => Direction::Forward,
            _ => Direction::Reverse,
        };
        let due = due.wrapping_mul(direction.sign());
        if due > 0 {
            let crossings = Crossings::new(chord, way.unsigned_abs());
            let lead = i64::from(self.steps)
                .wrapping_shl(32)
                .wrapping_sub(origin.bits());
            let lead = match direction {
                Direction::Forward => lead,
                Direction::Reverse => lead.wrapping_neg(),
            };
            let first = lead.wrapping_add(1 << 31);
            let last = first.wrapping_add(i64::from(due).wrapping_sub(1) << 32);
            let first = begin.wrapping_add(crossings.after(first).into());
            let last = begin.wrapping_add(crossings.after(last).into());
            self.run(
                direction,
                due.unsigned_abs(),
                (first, last),
                end,
                chord.speeding_up,
            );
        }
        self.keep_short(direction, end);
    }

    /// Closes the open period at `now`, or as soon after it as the driver allows. The axis stands.
    pub(crate) fn close(&mut self, now: Ticks) {
        let least = if self.pulse {
            u64::from(self.hold)
        } else {
            u64::from(self.least)
        };
        let open = now.saturating_sub(self.pen);
        if self.pulse || open > 0 {
            let direction = self.direction.unwrap_or(Direction::Forward);
            self.silence(open.max(least), direction);
        }
    }

    /// `pulses` evenly spaced pulses, from tick `first` to tick `last`; as many of them as fit before `end`.
    fn run(
        &mut self,
        direction: Direction,
        pulses: u32,
        (first, last): (Ticks, Ticks),
        end: Ticks,
        speeding_up: bool,
    ) {
        let shortest = self.shortest;
        let joins = pulses >= MANY
            && self.pulse
            && self.direction == Some(direction)
            && self.is_alike(first, last, pulses);
        let (begin, gaps) = if joins {
            (self.pen, pulses)
        } else {
            let first = first.max(self.earliest(direction));
            if first > end {
                return;
            }
            (first, pulses.wrapping_sub(1))
        };
        // A chord is no longer than a segment, so that 32 bits hold its ticks.
        let mut gaps = gaps.min(LONGEST_RUN);
        let mut span = last.saturating_sub(begin) as u32;
        if u64::from(span) < u64::from(gaps).wrapping_mul(shortest.into()) {
            // Too dense for the driver: at its highest rate, and what does not fit is due in the next chord.
            let room = end.saturating_sub(begin) as u32;
            gaps = gaps.min(room.checked_div(shortest).unwrap_or(0));
            span = gaps.wrapping_mul(shortest);
        }
        let made = if joins {
            gaps
        } else {
            self.open_pulse(begin, direction);
            gaps.wrapping_add(1)
        };
        if gaps > 0 {
            self.space(gaps, span, speeding_up, direction);
        }
        let made = made.cast_signed().wrapping_mul(direction.sign());
        self.steps = self.steps.wrapping_add(made);
    }

    /// Whether the open period, up to `first`, is as long as those between so many pulses, but for an eighth: it can be one of
    /// them then, and needs no record of its own.
    fn is_alike(&self, first: Ticks, last: Ticks, pulses: u32) -> bool {
        let Ok(open) = u32::try_from(first.wrapping_sub(self.pen)) else {
            return false;
        };
        // No chord is so long that this does not fit.
        let span = last.wrapping_sub(first) as u32;
        let all = u64::from(open).wrapping_mul(pulses.wrapping_sub(1).into());
        all.abs_diff(span.into()) <= u64::from(span >> 3)
    }

    /// So many periods in so many ticks, each beginning with a pulse. What remains when the ticks are shared out is one tick more in
    /// some periods. A run would be too short for a record only at the highest rates; its few ticks are left to the open period.
    fn space(&mut self, gaps: u32, span: u32, speeding_up: bool, direction: Direction) {
        let base = span.checked_div(gaps).unwrap_or(0);
        let longer = span.wrapping_sub(base.wrapping_mul(gaps));
        let long = (base.wrapping_add(1), longer);
        let short = (base, gaps.wrapping_sub(longer));
        let (more, fewer) = if long.1 > short.1 {
            (long, short)
        } else {
            (short, long)
        };
        if fewer.0.wrapping_mul(fewer.1) < SHORTEST_RECORD {
            // All alike. One gap alone may have to be stretched to be a record.
            let mut period = more.0;
            if period.wrapping_mul(gaps) < SHORTEST_RECORD {
                period = SHORTEST_RECORD.div_ceil(gaps.max(1));
            }
            self.make(period, gaps, true, direction);
        } else if gaps.wrapping_mul(gaps).wrapping_mul(5) <= span {
            // The pulses are off by gaps² / (4 · span) steps at most, a twentieth.
            let [one, other] = if speeding_up {
                [long, short]
            } else {
                [short, long]
            };
            self.make(one.0, one.1, true, direction);
            self.make(other.0, other.1, true, direction);
        } else {
            // Crowded: the fewer in the middle of the others, so that pulses are ahead in one half and behind in the other.
            let half = more.1 / 2;
            self.make(more.0, more.1.wrapping_sub(half), true, direction);
            self.make(fewer.0, fewer.1, true, direction);
            self.make(more.0, half, true, direction);
        }
    }

    /// The earliest tick for a pulse in `direction`.
    fn earliest(&self, direction: Direction) -> Ticks {
        let turning = self.direction != Some(direction);
        let wait = match (turning, self.pulse) {
            (false, _) => u64::from(self.least),
            (true, false) => u64::from(self.setup),
            (true, true) => u64::from(self.hold).saturating_add(u64::from(self.setup)),
        };
        self.pen.saturating_add(wait)
    }

    /// Whether [`Train::flush`] brings the records up to `enough` if there are chords up to `now`.
    pub(crate) fn can_flush(&self, now: Ticks, enough: Ticks) -> bool {
        let least = u64::from(self.hold).saturating_add(u64::from(self.least));
        self.pen < enough && now >= enough.saturating_add(least)
    }

    /// Makes a record of the open period without waiting for its end, up to just before `now`.
    pub(crate) fn flush(&mut self, now: Ticks) {
        let open = now
            .saturating_sub(self.pen)
            .saturating_sub(u64::from(self.least));
        self.silence(open, self.direction.unwrap_or(Direction::Forward));
    }

    /// Ends the open period where a pulse begins, at or after [`Train::earliest`]; the period after the pulse is open then.
    fn open_pulse(&mut self, at: Ticks, direction: Direction) {
        if self.direction != Some(direction) && self.pulse {
            let before = self.direction.unwrap_or(direction);
            self.silence(u64::from(self.hold), before);
        }
        self.silence(at.saturating_sub(self.pen), direction);
        self.direction = Some(direction);
        self.pulse = true;
    }

    /// Keeps the open period at `end` from growing beyond a segment: the pulse and silence so far become a record.
    fn keep_short(&mut self, direction: Direction, end: Ticks) {
        let open = end.saturating_sub(self.pen);
        // What stays open is long enough for a record of its own, so the next pulse need not wait for it.
        if open >= self.segment.saturating_add(u64::from(self.least)) {
            let level = if self.pulse {
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
    fn silence(&mut self, mut ticks: u64, direction: Direction) {
        while ticks > self.segment {
            let part = self
                .segment
                .min(ticks.saturating_sub(u64::from(self.least)));
            self.make(part as u32, 1, self.pulse, direction);
            self.pulse = false;
            ticks = ticks.saturating_sub(part);
        }
        self.make(ticks as u32, 1, self.pulse, direction);
        self.pulse = false;
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
        let room = self.made.get_mut(usize::from(self.count));
        debug_assert!(
            room.is_some(),
            "a chord makes at most {MOST_RECORDS} records"
        );
        if let Some(room) = room {
            *room = record;
            self.count = self.count.wrapping_add(1);
        }
        self.pen = self.pen.wrapping_add(record.ticks());
    }
}

/// When a chord passes a distance from its beginning. One division of 64 bits by 32 for all its crossings.
struct Crossings {
    /// The chord's length in ticks.
    length: u32,
    /// How far ways are shifted so that 32 bits hold them and the chord's has no leading zeros: down, or up if it is less than a
    /// step.
    down: u32,
    up: u32,
    /// Ticks for 2³² units of a way so shifted. A tick is lost at most.
    pace: u32,
}

impl Crossings {
    fn new(chord: &Chord, way: u64) -> Self {
        // A chord is no longer than a segment, which has 29 bits at most.
        let length = chord.to.0.wrapping_sub(chord.from.0) as u32;
        let above = (way >> 32) as u32;
        let mut crossings = Self {
            length,
            down: 32_u32.wrapping_sub(above.leading_zeros()),
            up: 0,
            pace: 0,
        };
        if above == 0 {
            crossings.up = (way as u32).leading_zeros() & 31;
        }
        let leading = crossings.shifted(way);
        crossings.pace = estimate(u64::from(length) << 32, leading);
        crossings
    }

    /// 32 bits of a way, which is not longer than the chord's.
    fn shifted(&self, way: u64) -> u32 {
        if self.down == 0 {
            (way as u32).wrapping_shl(self.up)
        } else {
            // A chord is shorter than 2³¹ steps.
            let above = ((way >> 32) as u32).wrapping_shl(32_u32.wrapping_sub(self.down));
            above | (way as u32).wrapping_shr(self.down)
        }
    }

    /// Ticks from the chord's beginning until it has gone `distance`, Q32 steps; 0 for what lies behind it.
    fn after(&self, distance: i64) -> u32 {
        let part = self.shifted(distance.max(0).cast_unsigned());
        let ticks = u64::from(part).wrapping_mul(self.pace.into()) >> 32;
        (ticks as u32).min(self.length)
    }
}
