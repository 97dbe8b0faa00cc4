//! Everything that is written to the timers: the start of a train, its end, and what is done when they have failed. Records come in by [`filling`].

mod filling;

use core::fmt;

use super::count::PulseCount;
use super::interrupts::on_break;
use super::registers::{Register, Registers, bits};
use super::ring::{Ring, SLOTS, WORDS};
use super::set_up;
use super::slots::Remainder;
use crate::low;
use crate::record::SHORTEST_RECORD;

/// Slots that are always silent: with the processor stopped they take 6.4 s at 168 MHz.
const SILENT_SLOTS: u32 = 64;

/// Slots that may be written ahead.
const MAX_SLOTS: u32 = low::word(SLOTS) - SILENT_SLOTS;

/// Words of the whole ring.
const ALL_WORDS: u32 = low::word(SLOTS * WORDS);

/// Half of the silence before a train, in ticks: time to write the first slots in.
const LEAD_IN: u32 = 1 << 12;

/// Ticks after which a burst has surely come to its end, wherever it was.
const TWO_BURSTS: u32 = 2 * SHORTEST_RECORD;

/// The most polls of a clock or a register: either changes in less time.
const MAX_POLLS: u32 = 200;

/// Ticks after which the DMA has surely come to another slot of a train: the longest run has 65,535.
const STALL_TICKS: u32 = 80 << 10;

/// A slot is written only if the DMA comes to it 2¹¹ ticks later, or more: writing one takes less, however many interrupts come in
/// between.
const MARGIN_BITS: u32 = 11;

/// Pulses that an advanced timer makes from records. It belongs to the control tick.
pub struct Output<'a, R> {
    registers: R,
    ring: &'a Ring,
    /// The timer runs.
    running: bool,
    /// The stream stood still while the timer ran.
    failed: bool,
    /// The level of the direction signal in the slots that are silent.
    level: u32,
    /// Slots written since the start of the train.
    written: u32,
    /// Slots fetched by the DMA since the start of the train, and made silent again.
    fetched: u32,
    /// When the DMA was last seen to have come to another slot.
    moved: u32,
    /// When the DMA fetches the next slot to be written, by the free-running count.
    request: u32,
    /// When all records taken have been played, by the free-running count.
    end: u32,
    /// The ticks of the last slot written.
    last: u32,
    /// What is left of a record that was taken.
    remainder: Remainder,
    /// Pulses taken, modulo 2³²: what the counter will show.
    pulses: u32,
    counted: PulseCount,
}

impl<R> fmt::Debug for Output<'_, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Output")
            .field("running", &self.running)
            .field("written", &self.written)
            .field("fetched", &self.fetched)
            .finish_non_exhaustive()
    }
}

impl<'a, R: Registers> Output<'a, R> {
    /// Sets up timers and stream. Both timers stand still, the outputs are low; the clocks of the peripherals are on.
    pub fn new(mut registers: R, ring: &'a Ring) -> Self {
        ring.silence(0, low::word(SLOTS), 0);
        set_up::timer(&mut registers, ring);
        set_up::counter(&mut registers);
        let mut output = Self {
            registers,
            ring,
            running: false,
            failed: false,
            level: 0,
            written: 0,
            fetched: 0,
            moved: 0,
            request: 0,
            end: 0,
            last: 0,
            remainder: Remainder::NONE,
            pulses: 0,
            counted: PulseCount::new(0, 0),
        };
        output.enable_outputs();
        output
    }

    /// To be called in every control tick and refill: what was played is made silent, and a train that has ended stops the timer.
    #[inline]
    pub fn service(&mut self) {
        if !self.running {
            return;
        }
        let newly = self.newly_fetched();
        // A transfer error has switched the stream off, or it does not come on.
        let is_stuck =
            !self.is_stream_on() || newly == 0 && (self.is_overdue() || self.is_broken());
        if newly != 0 {
            self.moved = self.registers.now();
            let played = self.fetched;
            self.fetched = played.wrapping_add(newly);
            self.ring.silence(played, newly, self.level);
        }
        if self.has_ended(0) {
            let left = self.remainder;
            self.stop();
            self.go_on(left);
        } else if is_stuck {
            self.end_early();
        } else if !self.remainder.is_empty() {
            self.fill(0);
        }
    }

    /// The train does not go on.
    #[cold]
    fn end_early(&mut self) {
        if self.is_broken() {
            // The interrupt of the break has stopped the timer.
            self.drop_all();
        } else {
            self.give_up();
        }
    }

    /// What was left of a record when the slots before it had been played: a train of its own.
    fn go_on(&mut self, left: Remainder) {
        if left.is_empty() {
            return;
        }
        if self.is_broken() {
            self.drop_all();
        } else {
            self.remainder = left;
            self.start(left.direction());
            self.fill(0);
        }
    }

    /// Pulses that left since the start, forward less reverse: the position in steps. To be called in every control tick.
    pub fn position(&mut self) -> i64 {
        // Captured at an edge whose interrupt is over ([`count_at_edge`](super::count_at_edge)).
        self.registers.write(Register::CounterSr, 0);
        let count = self.registers.read(Register::CounterCnt);
        self.counted.go_on(count);
        self.counted.position_at(count)
    }

    /// The position in steps at which the counter showed `count`, a captured value. It may lie a few changes of direction back.
    pub fn position_at(&self, count: u32) -> i64 {
        self.counted.position_at(count)
    }

    /// Drops what has not been played. A pulse that has begun is cut short but counts.
    pub fn drop_all(&mut self) {
        if self.running && !self.is_stream_on() {
            // An error that the next service would no longer see, as it is the same whoever has switched the stream off.
            self.give_up();
            return;
        }
        let count = self.cut();
        self.counted = PulseCount::new(count, self.counted.position_at(count));
    }

    /// Everything taken has been played, and the counter may have missed some of it: the drive has been told, and goes on from what it shows. Changes
    /// of direction would lie at the wrong pulses otherwise.
    fn resync_to_counter(&mut self) {
        let count = self.registers.read(Register::CounterCnt);
        if count != self.pulses {
            self.pulses = count;
            self.counted = PulseCount::new(count, self.counted.position_at(count));
        }
    }

    /// The stream stands still, and its last slot has been played again and again: all pulses since then had its direction.
    #[cold]
    fn give_up(&mut self) {
        // As a train is dropped, slots may have been fetched since the last service.
        let fetched = self.fetched.wrapping_add(self.newly_fetched());
        let count = self.cut();
        let position = self.counted.position_stuck(count, fetched);
        self.counted = PulseCount::new(count, position);
        self.failed = true;
    }

    /// Ends pulses and train at once; gives the pulses that were counted.
    fn cut(&mut self) -> u32 {
        // No pulse begins from here on, so the counter stands.
        self.registers
            .write(Register::Ccmr1, bits::CHANNEL_1_LOW | bits::CHANNEL_2_PWM);
        self.stop();
        let count = self.registers.read(Register::CounterCnt);
        self.pulses = count;
        count
    }

    /// Whether the break input has cut the outputs off. Pulses that the timer made up to [`on_break`] were counted and did not leave;
    /// nothing is taken until [`Output::mend`].
    pub fn is_broken(&self) -> bool {
        // The flag alone is left where the outputs were let go on after a break that nobody had looked at ([`Output::reset`]).
        self.registers.read(Register::Bdtr) & bits::MOE == 0
            || self.registers.read(Register::Sr) & bits::BIF != 0
    }

    /// Whether the DMA stream stood still while the timer ran, which played its last run again and again: the train was dropped at
    /// the next [`Output::service`], what left was counted, and nothing is taken until [`Output::mend`].
    pub fn has_failed(&self) -> bool {
        self.failed
    }

    /// Re-arms the outputs after a break or a failure, at rest. As long as the break input is active it has no effect on the break.
    pub fn mend(&mut self) {
        if !self.running {
            if self.failed {
                // Nobody knows what the stream has left undone.
                self.reset();
            }
            self.failed = false;
            self.enable_outputs();
            // Behind that: the break may have ended just now, and before that its flag stays. It would end the next train.
            self.registers.write(Register::Sr, !bits::BIF);
        }
    }

    /// The board's side.
    pub fn registers(&self) -> &R {
        &self.registers
    }

    /// Slots that the DMA has fetched since [`Output::fetched`] was brought up to date, whole ones only.
    #[inline]
    fn newly_fetched(&self) -> u32 {
        let left = self.registers.read(Register::StreamNdtr);
        let slots = ALL_WORDS.wrapping_sub(left) / low::word(WORDS);
        slots.wrapping_sub(self.fetched) % low::word(SLOTS)
    }

    /// Whether every slot written has been played, if so many more have been fetched than was known: the silence behind them
    /// is under way once the slot after it has been fetched.
    fn has_ended(&self, newly: u32) -> bool {
        let ahead = self.fetched.wrapping_add(newly).wrapping_sub(self.written);
        ahead.cast_signed() >= 2
    }

    /// Whether the DMA should have come to another slot long ago.
    fn is_overdue(&self) -> bool {
        self.registers.now().wrapping_sub(self.moved) > STALL_TICKS
    }

    /// How many slots can be written now, each of them in time; 0 or less if it may be too late for one.
    #[inline]
    fn in_time(&self) -> i32 {
        let lead = self.request.wrapping_sub(self.registers.now());
        lead.cast_signed() >> MARGIN_BITS
    }

    /// Begins a train with what is in the ring. The silence in front is played twice: once from here, and once because it is
    /// what is preloaded at the first update event, which fetches the first slot. Channel 1 makes pulses only once counter and CCR1
    /// are 0: after [`Output::drop_all`] both still are where a pulse was cut short, and it would rise again.
    #[cold]
    fn start(&mut self, direction: u32) {
        use Register as Reg;
        self.counted.begin_train();
        self.prepare(direction);
        // What is left of an earlier burst comes now, and not at once. No level of channel 1 may come of it.
        self.let_bursts_end();
        if self.registers.read(Reg::StreamNdtr) != ALL_WORDS {
            // The words of this train would come to the wrong registers.
            self.reset();
            self.prepare(direction);
        }
        self.registers.write(Reg::Egr, bits::UG);
        self.registers
            .write(Reg::Ccmr1, bits::CHANNEL_1_PWM | bits::CHANNEL_2_PWM);
        // An interrupt between this and the next may make what follows earlier than the timer is, never later.
        self.moved = self.registers.now();
        self.registers
            .write(Reg::Cr1, bits::URS | bits::ARPE | bits::CEN);
        if self.is_broken() {
            // Its interrupt may have come before this.
            on_break(&mut self.registers);
        }
        // The first slot is fetched when the second silence begins.
        self.request = self.moved.wrapping_add(LEAD_IN);
        self.last = LEAD_IN;
        let began = self.request.wrapping_add(LEAD_IN);
        self.end = began.wrapping_add(self.remainder.ticks());
        self.running = true;
    }

    /// The stream, its requests, and what is preloaded for the silence.
    fn prepare(&mut self, direction: u32) {
        use Register as Reg;
        for (register, value) in [
            (Reg::Dcr, bits::BURST_FROM_PSC),
            (Reg::StreamFlags, bits::STREAM_5_FLAGS),
            (Reg::StreamNdtr, ALL_WORDS),
            (Reg::StreamCr, bits::STREAM),
            (Reg::StreamCr, bits::STREAM | bits::STREAM_ON),
            (Reg::Arr, LEAD_IN - 1),
            (Reg::Rcr, 0),
            (Reg::Ccr1, 0),
            (Reg::Ccr2, direction),
            (Reg::Dier, bits::UDE | bits::BIE),
        ] {
            self.registers.write(register, value);
        }
    }

    /// Waits until a burst is over that the timer may want still.
    fn let_bursts_end(&self) {
        let began = self.registers.now();
        for _ in 0..MAX_POLLS {
            if self.registers.now().wrapping_sub(began) >= TWO_BURSTS {
                break;
            }
        }
    }

    /// Whether the stream is on. A transfer error switches it off by hardware.
    #[inline]
    fn is_stream_on(&self) -> bool {
        self.registers.read(Register::StreamCr) & bits::STREAM_ON != 0
    }

    /// It is off only when the word under way has been written.
    fn switch_stream_off(&mut self) {
        self.registers.write(Register::StreamCr, bits::STREAM);
        for _ in 0..MAX_POLLS {
            if !self.is_stream_on() {
                break;
            }
        }
    }

    /// Resets TIM1 and sets it up again. Its outputs are not driven for a moment, so this is the last resort. A break stays active; it goes
    /// unseen only if it comes and ends between the two writes behind the reset, while nothing is driven.
    #[cold]
    fn reset(&mut self) {
        self.registers.write(Register::Dier, 0);
        self.switch_stream_off();
        let was_broken = self.is_broken();
        self.registers.reset();
        set_up::timer(&mut self.registers, self.ring);
        if !was_broken {
            // If a break has come since, its flag is set.
            self.enable_outputs();
        }
    }

    /// Drives the outputs, unless the break input is active.
    fn enable_outputs(&mut self) {
        self.registers
            .write(Register::Bdtr, bits::BREAK | bits::MOE);
    }

    /// Ends a train: timer and stream stand still, and the ring is silent.
    #[cold]
    fn stop(&mut self) {
        self.registers.write(Register::Cr1, bits::URS | bits::ARPE);
        // An update event just now may have asked for a burst that has not begun, and the words that are left do not tell.
        self.let_bursts_end();
        self.registers.write(Register::Dier, 0);
        self.switch_stream_off();
        let left = self.written.wrapping_sub(self.fetched);
        if left.cast_signed() > 0 {
            self.ring.silence(self.fetched, left, self.level);
        }
        self.running = false;
        self.written = 0;
        self.fetched = 0;
        self.remainder = Remainder::NONE;
    }
}
