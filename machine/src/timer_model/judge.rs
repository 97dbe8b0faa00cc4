//! The judge: it watches the pins and holds them to what the driver's data sheet says.

use motion::DriverTiming;

/// Watches step and direction.
#[derive(Clone, Debug)]
pub struct Judge {
    timing: DriverTiming,
    high: bool,
    /// When the direction signal changed last, and the last pulse fell.
    turned: Option<u64>,
    fell: Option<u64>,
    /// Since the last change of direction a pulse has come.
    used: bool,
    /// Pulses that left.
    pub pulses: u64,
    /// Their sum by the direction signal, in steps.
    pub position: i64,
    /// Every pulse: when it rose, and +1 or −1. `None` does not keep them.
    pub log: Option<Vec<(u64, i8)>>,
}

impl Judge {
    /// Holds the pins to these times, in ticks. Nothing is logged.
    pub fn new(timing: DriverTiming) -> Self {
        Self {
            timing,
            high: false,
            turned: None,
            fell: None,
            used: false,
            pulses: 0,
            position: 0,
            log: None,
        }
    }

    /// Keeps every pulse.
    #[must_use]
    pub fn logging(mut self) -> Self {
        self.log = Some(Vec::new());
        self
    }

    /// The driver wants other times from now on.
    pub fn set_timing(&mut self, timing: DriverTiming) {
        self.timing = timing;
    }

    /// The direction signal has this level from now on.
    pub(super) fn direction(&mut self, at: u64, high: bool) {
        if high == self.high {
            return;
        }
        self.high = high;
        self.turned = Some(at);
        if let Some(fell) = self.fell.filter(|_| self.used) {
            let hold = at.checked_sub(fell).unwrap_or_else(|| {
                panic!("the direction changes at {at}, while the step signal is high")
            });
            assert!(
                hold >= self.timing.direction_hold.into(),
                "the direction is held for {hold} ticks at {at}"
            );
        }
        self.used = false;
    }

    /// Pulses `period` ticks apart. If the outputs are cut off they do not leave.
    pub(super) fn pulses(&mut self, first: u64, count: u64, period: u64, width: u64, leave: bool) {
        if !leave {
            return;
        }
        assert!(
            width >= self.timing.pulse_high.into(),
            "high for {width} ticks at {first}"
        );
        let low = self.fell.map(|fell| first.saturating_sub(fell));
        for low in low.into_iter().chain((count > 1).then(|| period - width)) {
            assert!(
                low >= self.timing.pulse_low.into(),
                "low for {low} ticks at {first}"
            );
        }
        if let Some(turned) = self.turned.filter(|_| !self.used) {
            let setup = first - turned;
            assert!(
                setup >= self.timing.direction_setup.into(),
                "the direction is set up for {setup} ticks at {first}"
            );
        }
        self.used = true;
        let last = first + (count - 1) * period;
        self.fell = Some(last + width);
        self.pulses += count;
        let sign = if self.high { 1 } else { -1 };
        self.position += sign * count as i64;
        if let Some(log) = &mut self.log {
            log.extend((0..count).map(|pulse| (first + pulse * period, sign as i8)));
        }
    }

    /// The step signal falls now, whatever was intended: power is off, so nobody looks at the width.
    pub(super) fn cut(&mut self, at: u64) {
        self.fell = self.fell.map(|fell| fell.min(at));
        self.used = false;
    }
}
