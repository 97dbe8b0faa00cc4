//! A model of the hardware that makes step pulses: TIM1, its DMA stream, and the timer that counts.
//!
//! It takes the register writes of [`motion::advanced_timer`] and plays them on virtual time, with the semantics of the reference
//! manual RM0090 that matter: PSC, ARR, RCR, CCR1 and CCR2 are preloaded, so what is written during a run acts in the next one;
//! a run is RCR + 1 periods of ARR + 1 ticks; every update event but a generated one asks for a DMA burst, which comes word by word and reads
//! each word when the one before it is written, the first long before. What the manual leaves open of a burst that is cut short is
//! taken at its worst: it goes on with the next train. Accesses to registers take time. A [`Judge`] watches the pins.
//!
//! It is no model of what software cannot see (synchronisation of the internal trigger, arbitration of the buses).

pub mod board;
mod counter;
mod judge;
mod processor;
pub mod rig;
mod stepping;
mod stream;
#[cfg(test)]
mod tests;
mod timers;

use std::cell::{Ref, RefCell, RefMut};
use std::rc::Rc;

use motion::advanced_timer::{Register, Registers, Ring, bits};

pub use judge::Judge;
use timers::Timers;

/// The timers on virtual time; clones are the same timers. It is what [`motion::advanced_timer::Output`] writes to.
#[derive(Clone, Debug)]
pub struct TimerModel<'a>(Rc<RefCell<Timers<'a>>>);

impl<'a> TimerModel<'a> {
    /// After a reset, with nothing written. `ring` is where the stream reads.
    pub fn new(ring: &'a Ring, judge: Judge) -> Self {
        Self(Rc::new(RefCell::new(Timers::new(ring, judge))))
    }

    /// Lets time pass.
    pub fn run(&self, ticks: u64) {
        let mut timers = self.0.borrow_mut();
        let until = timers.now + ticks;
        timers.run_until(until);
    }

    /// Ticks since the start.
    pub fn time(&self) -> u64 {
        self.0.borrow().now
    }

    /// From now on a burst takes so many ticks from its request.
    pub fn set_burst(&self, ticks: u64) {
        self.0.borrow_mut().stream.burst_ticks = ticks;
    }

    /// From now on the processor takes so many ticks for each access to a register.
    pub fn set_access(&self, ticks: u64) {
        self.0.borrow_mut().processor.access = ticks;
    }

    /// The next write to this register is followed by an interrupt of so many ticks.
    pub fn interrupt_behind(&self, register: Register, ticks: u64) {
        self.0.borrow_mut().processor.behind = Some((register, ticks));
    }

    /// From now on about one access in `seldom` is followed by an interrupt, of up to so many ticks.
    pub fn set_interrupts(&self, seldom: u64, longest: u64) {
        self.0.borrow_mut().processor.interrupts = Some((seldom, longest));
    }

    /// The stream no longer serves requests, or does so again.
    pub fn stall_stream(&self, is_stalled: bool) {
        let mut timers = self.0.borrow_mut();
        let now = timers.now;
        timers.stream.stall(is_stalled, now);
    }

    /// A transfer error: the stream is switched off by hardware.
    pub fn fail_stream(&self) {
        let mut timers = self.0.borrow_mut();
        timers.registers[Register::StreamCr as usize] &= !bits::STREAM_ON;
        timers.switch_stream();
    }

    /// What the slave timer shows, without taking a look at a register.
    pub fn count(&self) -> u32 {
        self.0.borrow().counter.count
    }

    /// The slave timer misses so many edges of those it has counted.
    pub fn lose_count(&self, edges: u32) {
        let mut timers = self.0.borrow_mut();
        timers.counter.count = timers.counter.count.wrapping_sub(edges);
    }

    /// Words that the stream has left in this round, without taking a look at a register.
    pub fn words_left(&self) -> u32 {
        self.0.borrow().stream.left
    }

    /// The level of the break input. While it is active the outputs are cut off by hardware, and software can neither let them go on nor
    /// clear the flag.
    pub fn set_break(&self, is_active: bool) {
        let mut timers = self.0.borrow_mut();
        timers.is_break_active = is_active;
        timers.break_begins_behind = None;
        timers.break_ends_behind = None;
        timers.cut_off();
    }

    /// The break input goes inactive behind so many writes to registers from now on. A reset of TIM1 is one, too.
    pub fn end_break_behind(&self, writes: u32) {
        self.0.borrow_mut().break_ends_behind = Some(writes);
    }

    /// The break input goes active behind so many writes to registers from now on.
    pub fn begin_break_behind(&self, writes: u32) {
        self.0.borrow_mut().break_begins_behind = Some(writes);
    }

    /// Whether a break that was planned has not begun yet.
    pub fn is_break_planned(&self) -> bool {
        self.0.borrow().break_begins_behind.is_some()
    }

    /// Whether the break interrupts.
    pub fn is_break_interrupt(&self) -> bool {
        let timers = self.0.borrow();
        timers.register(Register::Dier) & bits::BIE != 0
            && timers.register(Register::Sr) & bits::BIF != 0
    }

    /// An edge at the pin of a capture channel of the counter (1 to 4), so many ticks from now. It is captured when the channel's filter lets
    /// it through, some ticks later.
    ///
    /// # Panics
    /// If the channel is not set up to capture edges of its pin.
    pub fn edge_at_channel(&self, channel: u32, ticks: u64) {
        let mut timers = self.0.borrow_mut();
        let at = timers.now + ticks + timers.filter_of(channel);
        timers.counter.expect_edge(at, channel as usize - 1);
    }

    /// Whether the timer stands where channel 1 would be high.
    pub fn is_inside_pulse(&self) -> bool {
        self.0.borrow().stands_inside_pulse()
    }

    /// What was seen on the pins.
    pub fn judge(&self) -> Ref<'_, Judge> {
        Ref::map(self.0.borrow(), |timers| &timers.judge)
    }

    /// The judge, to change what it looks for.
    pub fn judge_mut(&self) -> RefMut<'_, Judge> {
        RefMut::map(self.0.borrow_mut(), |timers| &mut timers.judge)
    }
}

impl Registers for TimerModel<'_> {
    fn write(&mut self, register: Register, value: u32) {
        let mut timers = self.0.borrow_mut();
        timers.spend(None);
        timers.move_break_input();
        timers.write(register, value);
        timers.spend(Some(register));
    }

    fn read(&self, register: Register) -> u32 {
        let mut timers = self.0.borrow_mut();
        timers.spend(None);
        timers.read(register)
    }

    fn now(&self) -> u32 {
        let mut timers = self.0.borrow_mut();
        timers.spend(None);
        timers.now as u32
    }

    fn reset(&mut self) {
        let mut timers = self.0.borrow_mut();
        timers.spend(None);
        timers.move_break_input();
        timers.reset();
    }
}
