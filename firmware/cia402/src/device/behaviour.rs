//! What the module of a product asks for beside commands.

use canopen::cia301::nmt::Reset;
use canopen::{Application, Instant, od};

use super::{Activity, Device};
use crate::behaviour::{Behaves, Behaviour};
use crate::faults::emergency;

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// The object dictionary, and what the product does that is no data.
    pub fn product(&mut self) -> (&mut D, &mut D::Behaviour) {
        (self.node.dictionary_mut(), &mut self.hooks.behaviour)
    }

    /// Does what the module of the product asks for.
    #[inline]
    pub(super) fn serve_behaviour(&mut self, now: Instant) {
        if !D::Behaviour::IS_THERE {
            return;
        }
        let requests = self.hooks.behaviour.take_requests();
        if let Some((index, sub, number)) = requests.write {
            let size = od::find::<D>(index, sub).map_or(0, |entry| usize::from(entry.size()));
            let bytes = number.to_le_bytes();
            let value = bytes.get(..size).unwrap_or_default();
            let result = self.node.write((index, sub), value, now, &mut self.hooks);
            self.hooks.behaviour.wrote(self.node.dictionary(), result);
        }
        if requests.configuration {
            self.hooks.post_all_anew();
        } else if requests.commands {
            self.hooks.post_commands_anew();
        }
        if requests.reset && self.activity == Activity::Running {
            self.activity = Activity::Stopping(Reset::Node);
            self.hooks.post_all_anew();
        }
        if let Some((index, sub)) = requests.order {
            self.node.order(index, sub);
        }
        match requests.error {
            Some((code, true)) => self.node.report(emergency(code), now),
            Some((code, false)) => self.node.clear(code, now),
            None => {}
        }
    }
}
