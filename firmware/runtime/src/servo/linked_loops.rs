//! The loops of a board, at their end of the link. In the interrupt of the loops:
//!
//! ```text
//! LinkedLoops::run    orders ──► position, velocity ──► what the current is to be, for the next period
//! LinkedLoops::tell   what tasks have set ──►, ──► what has become of it
//! ```

use super::current::{CurrentLock, CurrentState};
use super::link::{Link, LoopStatus};
use super::loops::{Loops, hundredths};
use super::orders::error_code;

/// See the module.
#[derive(Debug)]
pub struct LinkedLoops {
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
}

impl LinkedLoops {
    /// With a clock of so many counts in a second, which stamps the orders.
    pub fn new(loops: Loops, link: &'static Link, clock: u32) -> Self {
        Self {
            loops,
            link,
            ordered: 0,
            temperature: 0,
            waits: false,
            is_found_published: false,
            count: 1.0 / clock as f32,
        }
    }

    /// A period of the control, at this count of the clock. Returns what it has looked at.
    pub fn run(&mut self, current: &mut impl CurrentLock, now: u32) -> CurrentState {
        self.take_orders(current);
        let since = now.wrapping_sub(self.ordered) as f32 * self.count;
        self.loops.run(current, since, 0, self.temperature)
    }

    /// The share of the time for which the brake chopper is to be on from now on, 0 to 1.
    pub fn chopping(&self, state: &CurrentState) -> f32 {
        self.loops.chopping(state)
    }

    /// Behind it, with nothing that is due in this period: what tasks have set is taken over, and what [`LinkedLoops::run`] has looked at is published.
    pub fn tell(&mut self, current: &mut impl CurrentLock, state: &CurrentState) {
        self.publish(state);
        if !self.is_found_published {
            let is_published = self.link.publish_found(self.loops.found());
            self.is_found_published = is_published && !self.loops.is_measuring();
        }
        let loops = &self.loops;
        (self.link).publish_raw_report(|| loops.raw_report(current, state));
        self.take_set_up(current);
    }

    #[inline(never)]
    fn take_orders(&mut self, current: &mut impl CurrentLock) {
        self.link.take_orders(|orders| {
            self.temperature = orders.temperature;
            let order = orders.order.as_ref();
            self.ordered = order.map_or(0, |(_, at)| *at);
            self.loops.take(order.map(|(order, _)| *order));
            let on = orders.is_on && !orders.is_blocked;
            self.loops.energise(current, on);
        });
    }

    #[inline(never)]
    fn take_set_up(&mut self, current: &mut impl CurrentLock) {
        self.link.take_set_up(self.waits, |settings, request| {
            self.waits = !self.loops.set_up(current, settings);
            if let Some(request) = request {
                self.loops.request(current, request);
                self.is_found_published = false;
            }
        });
    }

    #[inline(never)]
    fn publish(&self, state: &CurrentState) {
        let report = self.loops.control_report(state);
        self.link.publish(hundredths(report.lead), || LoopStatus {
            report: self.loops.reported(state, &report, 0),
            fault: self.loops.fault(state).map(error_code),
            millivolts: (state.seen.bus * 1e3) as u32,
            is_stalled: self.loops.stalls(&report),
            is_hot: report.is_hot,
            position_tolerance: self.loops.position_tolerance(),
        });
    }
}
