//! Time passes: which of the services has waited for it, and when the next one will.

use super::{Node, Services};
use crate::agenda::{Due, Object};
use crate::application::Application;
use crate::od::Dictionary;
use crate::time::{Instant, NEVER, earlier, has_come};

impl<D: Dictionary> Node<D> {
    /// Lets time pass: timers, change-of-state PDOs. Returns when it wants to be called again at the latest
    /// ([`NEVER`]: not before the next frame).
    #[inline]
    pub fn poll<A: Application<D>>(&mut self, now: Instant, application: &mut A) -> Instant {
        match self.services.agenda.due(now) {
            Due::Nothing => self.services.agenda.next(),
            Due::Values => self.serve_values(now),
            Due::All => self.serve(now, application),
        }
    }

    /// A time has come, or may have. Returns the next deadline.
    #[inline(never)]
    fn serve<A: Application<D>>(&mut self, now: Instant, application: &mut A) -> Instant {
        if self.services.agenda.has_timers(now) {
            let deadline = self.serve_timers(now, application);
            self.services.agenda.set_timers(deadline);
        }
        if self.has_heartbeat() && self.services.heartbeat.poll(now) {
            self.services.agenda.set(Object::HEARTBEAT, true);
        }
        if self.services.agenda.has_values(now) {
            self.serve_values(now);
        }
        self.find_next()
    }

    /// Values may have changed that transmit PDOs look at, or a time of one of those has come. Returns the next deadline.
    #[inline(never)]
    fn serve_values(&mut self, now: Instant) -> Instant {
        let Services { tpdos, agenda, .. } = &mut self.services;
        let deadline = tpdos.poll(&self.dictionary, now, agenda);
        if agenda.set_values(deadline) {
            return self.find_next();
        }
        agenda.next()
    }

    /// Finds the next deadline.
    #[inline(never)]
    fn find_next(&mut self) -> Instant {
        let heartbeat = match self.has_heartbeat() {
            true => self.services.heartbeat.deadline(),
            false => NEVER,
        };
        self.services.agenda.set_next(heartbeat)
    }

    /// Everything that waits for a time, beside heartbeats, which come again and again, and transmit PDOs: the controller, LSS, SDO, SYNC, emergency
    /// messages, watched nodes and receive PDOs. Returns the next of these times.
    #[inline(never)]
    fn serve_timers<A: Application<D>>(&mut self, now: Instant, application: &mut A) -> Instant {
        let deadline = self.serve_controller(now, NEVER);
        self.serve_sdo(now, application);
        if self.is_resetting {
            return deadline;
        }
        let deadline = if D::FEATURES.lss {
            earlier(deadline, self.lss.poll(now))
        } else {
            deadline
        };
        self.services.agenda.is_mute = self.must_be_mute(now);
        if !self.node_id.is_configured() {
            return deadline;
        }
        if D::FEATURES.sync && has_come(self.services.sync.deadline(), now) {
            self.serve_sync(now, application);
        }
        if has_come(self.services.supervision_deadline::<D>(), now) {
            self.supervise(now);
            // It may have stopped the device: the application learns at once that a client will not go on.
            self.serve_sdo(now, application);
        }
        let deadline = earlier(deadline, self.services.rpdos.poll(now));
        self.services.report_errors(&mut self.dictionary, now);
        self.services.emergency.poll(now);
        self.services.emergencies_changed();
        let deadline = earlier(deadline, self.services.emergency.deadline());
        let deadline = earlier(deadline, self.services.sync.deadline());
        let deadline = earlier(deadline, self.services.supervision_deadline::<D>());
        earlier(deadline, self.sdo.deadline())
    }
}
