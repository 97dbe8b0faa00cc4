//! What the hardware does: registers that act, runs of the timer, the stream that feeds them, the pulses that rise.

use std::fmt;

use motion::advanced_timer::{Register, Ring, WORDS, bits};

use super::counter::Counter;
use super::judge::Judge;
use super::processor::Processor;
use super::stream::Stream;

/// The counter runs at half the clock of TIM1, and sees a level of OC1REF that lasts for two of its ticks.
const SEEN: u32 = 4;

/// Registers that a reset of TIM1 clears, beside those that are preloaded.
const TIM1: [Register; 9] = [
    Register::Cr1,
    Register::Cr2,
    Register::Smcr,
    Register::Dier,
    Register::Sr,
    Register::Ccmr1,
    Register::Ccer,
    Register::Bdtr,
    Register::Dcr,
];

/// What a run is made from: PSC, ARR, RCR, CCR1, CCR2.
type Preloaded = [u32; WORDS];

/// The hardware itself.
pub(super) struct Timers<'a> {
    ring: &'a Ring,
    pub(super) judge: Judge,
    pub(super) now: u64,
    /// Registers without a life of their own, by [`Register`].
    pub(super) registers: [u32; 40],
    preload: Preloaded,
    /// The run under way: what acts, when it began, and its pulses that have risen.
    active: Preloaded,
    began: u64,
    risen: u64,
    /// What the counter shows while it stands.
    stood: u64,
    pub(super) stream: Stream,
    pub(super) is_break_active: bool,
    /// Writes up to the beginning of a break and to its end, if that is planned.
    pub(super) break_begins_behind: Option<u32>,
    pub(super) break_ends_behind: Option<u32>,
    pub(super) counter: Counter,
    pub(super) processor: Processor,
}

impl fmt::Debug for Timers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Timers")
            .field("now", &self.now)
            .field("active", &self.active)
            .field("stream", &self.stream)
            .finish_non_exhaustive()
    }
}

impl<'a> Timers<'a> {
    pub(super) fn new(ring: &'a Ring, judge: Judge) -> Self {
        Self {
            ring,
            judge,
            now: 0,
            registers: [0; 40],
            preload: [0, 0xFFFF, 0, 0, 0],
            active: [0, 0xFFFF, 0, 0, 0],
            began: 0,
            risen: 0,
            stood: 0,
            stream: Stream::new(),
            is_break_active: false,
            break_begins_behind: None,
            break_ends_behind: None,
            counter: Counter::default(),
            processor: Processor::default(),
        }
        .found_in_use()
    }

    /// A boot loader has left what it needed: its successor relies on nothing that it has not written.
    fn found_in_use(mut self) -> Self {
        for (register, value) in [
            (Register::Smcr, 0b111),
            (Register::StreamFcr, 0b10_0111),
            (Register::StreamPar, 0x4002_6000),
            (Register::StreamM0ar, 0x2000_0000),
            (Register::CounterDier, 1),
            (Register::CounterPsc, 83),
            (Register::CounterArr, 0xFFFF),
        ] {
            self.registers[register as usize] = value;
        }
        self
    }

    pub(super) fn register(&self, register: Register) -> u32 {
        self.registers[register as usize]
    }

    /// The processor is busy: with an access, or with what it does behind a write to a register.
    pub(super) fn spend(&mut self, written: Option<Register>) {
        let ticks = match written {
            Some(register) => self.processor.behind(register),
            None => self.processor.access(),
        };
        if ticks > 0 {
            self.run_until(self.now + ticks);
        }
    }

    /// Holds every register that a train relies on against the manual, when a train begins.
    fn check_set_up(&self) {
        let memory = std::ptr::from_ref(self.ring).addr() as u32;
        for (register, value) in [
            // RM0090, 17.4: PWM mode 1 with preload on both channels, TRGO = OC1REF, OC1N and OC2N, burst of 5 words from PSC (28h / 4).
            (Register::Ccmr1, 0x6868),
            (Register::Cr2, 0x40),
            (Register::Smcr, 0),
            (Register::Dier, 0x180),
            (Register::Ccer, 0x44),
            (Register::Dcr, 0x040A),
            // RM0090, 10.5: channel 6, very high, words, MINC, CIRC, memory to peripheral, on; direct mode.
            (Register::StreamCr, 0x0C03_5541),
            (Register::StreamFcr, 0),
            // RM0090, 2.3 and 17.4.20: TIM1_DMAR; 10.5.9: the memory of the slots.
            (Register::StreamPar, 0x4001_0000 + 0x4C),
            (Register::StreamM0ar, memory),
            // RM0090, 18.4: TIM2 counts ITR0, which is TIM1, in 32 bits; every channel captures both edges of its own pin.
            (Register::CounterCr1, 1),
            (Register::CounterSmcr, 0x07),
            (Register::CounterDier, 0),
            (Register::CounterCcmr1, 0x3131),
            (Register::CounterCcmr2, 0x3131),
            (Register::CounterCcer, 0xBBBB),
            (Register::CounterPsc, 0),
            (Register::CounterArr, u32::MAX),
        ] {
            let found = self.register(register);
            assert_eq!(found, value, "{register:?} is {found:#X}");
        }
        // The break is on, low is active, and outputs that are off are driven low.
        assert_eq!(self.register(Register::Bdtr) & !bits::MOE, 0x1C00);
    }

    pub(super) fn write(&mut self, register: Register, value: u32) {
        match register {
            Register::Psc => self.preload[0] = value,
            Register::Arr => self.preload[1] = value & 0xFFFF,
            Register::Rcr => self.preload[2] = value & 0xFF,
            Register::Ccr1 => self.preload[3] = value & 0xFFFF,
            Register::Ccr2 => self.preload[4] = value & 0xFFFF,
            Register::Egr => {
                assert_eq!(value, bits::UG);
                assert!(
                    self.register(Register::Cr1) & bits::URS != 0,
                    "an update that is generated would ask for DMA"
                );
                self.update();
            }
            Register::Ccmr1 => {
                let was_pwm = self.makes_pulses();
                self.registers[register as usize] = value;
                if was_pwm && !self.makes_pulses() {
                    self.judge.cut(self.now);
                }
                if !was_pwm && self.makes_pulses() {
                    self.compare_anew();
                }
                assert_eq!(value & 1 << 11, 1 << 11, "CCR2 is preloaded");
            }
            Register::Cr1 => {
                let was_running = self.counts();
                self.registers[register as usize] = value;
                assert_eq!(value & bits::ARPE, bits::ARPE, "ARR is preloaded");
                if self.counts() && !was_running {
                    assert_eq!(self.stood, 0, "the counter was not generated anew");
                    self.check_set_up();
                    self.began = self.now;
                    self.risen = 0;
                } else if was_running && !self.counts() {
                    self.stood = (self.now - self.began) % self.period();
                }
            }
            Register::StreamNdtr => {
                assert!(!self.streams(), "NDTR is written while the stream is on");
                self.stream.left = value;
            }
            Register::StreamPar | Register::StreamM0ar => {
                assert!(!self.streams(), "written while the stream is on");
                self.registers[register as usize] = value;
            }
            Register::StreamCr => {
                self.registers[register as usize] = value;
                assert!(
                    self.streams() || self.register(Register::Dier) & bits::UDE == 0,
                    "a request could be left for the next train"
                );
                self.switch_stream();
            }
            Register::CounterCnt => self.counter.count = value,
            Register::CounterSr => self.counter.clear(value),
            Register::Sr => {
                self.registers[register as usize] &= value;
                self.cut_off();
            }
            Register::Bdtr => {
                self.registers[register as usize] = value;
                self.cut_off();
            }
            _ => self.registers[register as usize] = value,
        }
    }

    pub(super) fn read(&mut self, register: Register) -> u32 {
        let [prescaler, reload, repetitions, width, level] = self.preload;
        match register {
            Register::StreamNdtr => self.stream.left,
            // Of what is preloaded the manual shows no more than that.
            Register::Psc => prescaler,
            Register::Arr => reload,
            Register::Rcr => repetitions,
            Register::Ccr1 => width,
            Register::Ccr2 => level,
            _ => (self.counter.read(register)).unwrap_or_else(|| self.register(register)),
        }
    }

    pub(super) fn switch_stream(&mut self) {
        self.stream.switch(self.streams(), self.ring, self.now);
    }

    /// TIM1 after a reset: nothing is driven, nothing is wanted.
    pub(super) fn reset(&mut self) {
        for register in TIM1 {
            self.registers[register as usize] = 0;
        }
        self.judge.cut(self.now);
        self.preload = [0, 0xFFFF, 0, 0, 0];
        self.active = self.preload;
        self.stood = 0;
        self.stream.forget();
    }

    /// Before a write.
    pub(super) fn move_break_input(&mut self) {
        let is_due = |behind: &mut Option<u32>| {
            let is_due = *behind == Some(0);
            *behind = behind.and_then(|writes| writes.checked_sub(1));
            is_due
        };
        if is_due(&mut self.break_begins_behind) {
            self.is_break_active = true;
            self.cut_off();
        }
        self.is_break_active &= !is_due(&mut self.break_ends_behind);
    }

    /// An active break input cuts the outputs off, if it is switched on.
    pub(super) fn cut_off(&mut self) {
        if self.is_break_active && self.register(Register::Bdtr) & bits::BREAK == bits::BREAK {
            self.registers[Register::Bdtr as usize] &= !bits::MOE;
            self.registers[Register::Sr as usize] |= bits::BIF;
            self.judge.cut(self.now);
        }
    }

    /// How long the input filter of a capture channel takes, in ticks of TIM1, which has twice the clock of the counter.
    pub(super) fn filter_of(&self, channel: u32) -> u64 {
        assert!((1..=4).contains(&channel));
        let pair = if channel <= 2 {
            Register::CounterCcmr1
        } else {
            Register::CounterCcmr2
        };
        let mode = self.register(pair) >> (8 * ((channel - 1) % 2)) & 0xFF;
        let polarity = self.register(Register::CounterCcer) >> (4 * (channel - 1)) & 0xF;
        assert_eq!(mode & 0b11, 0b01, "the channel captures its own pin");
        assert_eq!(polarity, 0b1011, "both edges are captured");
        assert_eq!(mode >> 4, 3, "the filter wants 8 samples");
        2 * 8
    }

    /// CEN.
    fn counts(&self) -> bool {
        self.register(Register::Cr1) & bits::CEN != 0
    }

    fn streams(&self) -> bool {
        self.register(Register::StreamCr) & bits::STREAM_ON != 0
    }

    fn makes_pulses(&self) -> bool {
        self.register(Register::Ccmr1) & bits::OC1M == bits::CHANNEL_1_PWM & bits::OC1M
    }

    fn period(&self) -> u64 {
        let [prescaler, reload, ..] = self.active;
        assert_eq!(prescaler, 0, "the prescaler never changes");
        u64::from(reload) + 1
    }

    fn repeat(&self) -> u64 {
        let [_, _, repetitions, ..] = self.active;
        u64::from(repetitions) + 1
    }

    pub(super) fn run_until(&mut self, until: u64) {
        while let Some(edge) = self.counter.next_edge().filter(|edge| *edge <= until) {
            self.play_until(edge);
            self.counter.capture(edge);
        }
        self.play_until(until);
    }

    fn play_until(&mut self, until: u64) {
        loop {
            let end = self.began + self.period() * self.repeat();
            let end = self.counts().then_some(end);
            let next = end.unwrap_or(until).min(until);
            if let Some(due) = self.stream.due().filter(|due| *due <= next) {
                self.now = due;
                self.rise_up_to(due);
                let (place, word) = self.stream.deliver(self.ring, due);
                self.preload[place] = word;
                continue;
            }
            let Some(end) = end.filter(|end| *end <= until) else {
                break;
            };
            self.rise_up_to(end - 1);
            self.now = end;
            assert!(
                !self.stream.is_busy(),
                "the run that ends at {end} was shorter than the DMA burst for the next one"
            );
            self.update();
            if self.register(Register::Dier) & bits::UDE != 0 {
                self.stream.request(end);
            }
        }
        self.rise_up_to(until);
        self.now = until;
    }

    /// An update event: what was preloaded acts, and the counter begins anew.
    fn update(&mut self) {
        self.active = self.preload;
        self.began = self.now;
        self.risen = 0;
        self.stood = 0;
        let [_, reload, _, _, level] = self.active;
        assert!(
            level == 0 || level > reload,
            "the direction signal would be neither high nor low"
        );
        self.judge.direction(self.now, level > reload);
    }

    /// Channel 1 was forced low and is in PWM mode again. RM0090 (17.4.7, OC1M) leaves open whether OC1REF compares at once; here it
    /// does, and a counter that stands below CCR1 makes a rising edge: too short to be a pulse for the driver, and counted.
    fn compare_anew(&mut self) {
        if self.stands_inside_pulse() {
            let leaves = self.leaves();
            self.judge.pulses(self.now, 1, 1, 0, leaves);
            self.count_pulses(1);
        }
    }

    /// The counter stands below CCR1.
    pub(super) fn stands_inside_pulse(&self) -> bool {
        let [_, _, _, width, _] = self.active;
        !self.counts() && self.stood < width.into()
    }

    /// The pulses of the run under way that rise up to a time.
    fn rise_up_to(&mut self, time: u64) {
        let [_, reload, _, width, _] = self.active;
        if width == 0 || !self.counts() || !self.makes_pulses() || time < self.began {
            return;
        }
        assert!(width <= reload, "a pulse that does not fall");
        let low = reload + 1 - width;
        assert!(
            width >= SEEN && low >= SEEN,
            "the counter sees no pulse of {width} ticks, {low} ticks behind another"
        );
        let period = self.period();
        let due = ((time - self.began) / period + 1).min(self.repeat());
        let fresh = due - self.risen;
        if fresh > 0 {
            let first = self.began + self.risen * period;
            let leaves = self.leaves();
            self.judge
                .pulses(first, fresh, period, width.into(), leaves);
            self.risen = due;
            self.count_pulses(fresh);
        }
    }

    /// The outputs are driven: no break has cut them off.
    fn leaves(&self) -> bool {
        self.register(Register::Bdtr) & bits::MOE != 0
    }

    /// Edges of OC1REF, whether they leave or not.
    fn count_pulses(&mut self, edges: u64) {
        if self.register(Register::CounterCr1) & bits::CEN != 0
            && self.register(Register::Cr2) == bits::TRGO_OC1REF
            && self.register(Register::CounterSmcr) == bits::COUNT_TIM1
        {
            self.counter.count = self.counter.count.wrapping_add(edges as u32);
        }
    }
}
