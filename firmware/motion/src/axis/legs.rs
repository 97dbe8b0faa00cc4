//! When the second leg of a motion is planned that has to come to rest before it goes on.

use super::{AdvanceError, Axis};
use crate::record::PulseSink;

impl Axis {
    /// Plans the second leg of a smooth motion that has to come to rest before it goes on, if the last order has left one and came before the last
    /// call. To be called in every regular control tick, behind its orders: so no tick makes more than one step of a plan. While it is made there
    /// are no records; before, two segments of them are handed out, as by [`Axis::advance`].
    ///
    /// Where the stop ends before that, [`Axis::advance`] plans the second leg when it comes there: there is no pause. The motion is the same
    /// whenever it is planned.
    ///
    /// # Errors
    /// [`AdvanceError`]: the sink is full, or ran empty.
    pub fn plan_on<S: PulseSink>(&mut self, sink: &mut S) -> Result<(), AdvanceError> {
        let is_new = core::mem::take(&mut self.is_new);
        if is_new || self.path.is_some() || self.plan.waits_from().is_none() {
            return Ok(());
        }
        let result = self.advance(sink);
        self.plan.complete();
        result
    }
}
