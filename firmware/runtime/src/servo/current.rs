//! The current interrupt of a board: the loops, and their end of the link.
//!
//! ```text
//! every period    counts ──► Current::period ──► widths      at once, then
//!                            Current::control                in one of so many: position, velocity, what the tasks say and read
//! ```

use servo::interrupt::Counts;
use servo::modulation::Widths;

use super::link::{Link, LoopStatus};
use super::{Loops, error_code, leads};

/// See the module.
#[derive(Debug)]
pub struct Current {
    pub(super) loops: Loops,
    link: &'static Link,
    /// The count of the clock for which the order is.
    ordered: u32,
    /// The stage, in 0.1 °C.
    temperature: i16,
    /// What was set waits until the power is off.
    waits: bool,
    /// What a measurement has found is published, and none is under way.
    is_found_published: bool,
    /// Seconds of a count of the clock.
    count: f32,
    /// In which of so many periods it is.
    at: u8,
    period: u8,
}

impl Current {
    /// With a clock of so many counts in a second, which stamps the orders.
    pub fn new(loops: Loops, link: &'static Link, clock: u32) -> Self {
        Self {
            period: loops.data.stage.control.max(5),
            loops,
            link,
            ordered: 0,
            temperature: 0,
            waits: false,
            is_found_published: false,
            count: 1.0 / clock as f32,
            at: 0,
        }
    }

    /// The loops, to tell them before a period what [`Loops::hall`] and [`Loops::word`] take.
    pub fn loops(&mut self) -> &mut Loops {
        &mut self.loops
    }

    /// A period: pulse widths, or none where the gates are to be off.
    #[inline]
    pub fn period(&mut self, counts: &Counts) -> Option<Widths> {
        let widths = self.loops.period(counts, self.temperature)?;
        self.loops.fault().is_none().then_some(widths)
    }

    /// What is above the current, behind [`Current::period`], at this count of the clock. Returns whether the gates may be on.
    #[inline]
    pub fn control(&mut self, counts: &Counts, now: u32) -> bool {
        let since = now.wrapping_sub(self.ordered) as f32 * self.count;
        self.loops.control(counts, since, 0, self.temperature);
        // One at a time, and not where the loops have run, so that no period is much longer than the others.
        match self.at {
            1 => self.take_orders(),
            2 => self.take_set_up(),
            3 => self.publish(counts),
            4 => {
                self.publish_found();
                self.link.publish_raw_report(|| self.loops.raw_report());
            }
            _ => {}
        }
        self.at += 1;
        if self.at >= self.period {
            self.at = 0;
        }
        self.loops.fault().is_none()
    }

    /// The share of the time for which the brake chopper is to be on from now on, 0 to 1; told once in as many periods.
    #[inline]
    pub fn chopping(&self, counts: &Counts) -> Option<f32> {
        (self.at == 0).then(|| self.loops.chopping(counts))
    }

    #[inline(never)]
    fn take_orders(&mut self) {
        self.link.take_orders(|orders| {
            self.temperature = orders.temperature;
            let order = orders.order.as_ref();
            self.ordered = order.map_or(0, |(_, at)| *at);
            self.loops.take(order.map(|(order, _)| *order));
            self.loops.energise(orders.is_on && !orders.is_blocked);
        });
    }

    #[inline(never)]
    fn take_set_up(&mut self) {
        self.link.take_set_up(self.waits, |settings, request| {
            self.waits = !self.loops.set_up(settings);
            if let Some(request) = request {
                self.loops.request(request);
                self.is_found_published = false;
            }
        });
    }

    #[inline(never)]
    fn publish(&self, counts: &Counts) {
        let report = self.loops.control_report();
        self.link.publish(leads(&report), || LoopStatus {
            report: self.loops.reported(&report, 0),
            fault: self.loops.fault().map(error_code),
            millivolts: (self.loops.bus(counts) * 1e3) as u32,
            is_stalled: self.loops.stalls(&report),
            is_hot: report.is_hot,
            position_tolerance: self.loops.position_tolerance(),
        });
    }

    fn publish_found(&mut self) {
        if !self.is_found_published {
            let is_published = self.link.publish_found(self.loops.found());
            self.is_found_published = is_published && !self.loops.is_measuring();
        }
    }
}
