//! When parameters are stored: writing to flash may stop the processor for a while, so it waits until the motor stands
//! without power.

use canopen::cia301::parameters::ParameterStore;
use canopen::cia301::sdo::AbortCode;
use canopen::{Application, Duration, Instant};

use super::Device;
use crate::behaviour::Behaves;
use crate::exchange::Share;

/// How long an order to store waits for a motor that is just being switched off, before it is refused. A moment is needed in any
/// case: the drive is safe when a control tick has seen the latest commands.
const POWER_OFF_TIMEOUT: Duration = Duration::millis(50);

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// Its board stores parameters: the firmware calls [`Device::serve_store`].
    pub const fn store_parameters_here(&mut self) {
        self.node.store_parameters_here();
        self.hooks.commissioning.support();
    }

    /// Does what there is to do with the store: loads the parameters at a boot, takes one step of storing them. Call it after
    /// [`Device::power_on`] and after each [`Device::poll`], from the task that calls those too: so no command can switch the
    /// drive on during a step.
    ///
    /// While the power stage is on nothing is stored; a master is answered with 08000022h within 50 ms, and what was stored
    /// before stays.
    pub fn serve_store<S: ParameterStore, X: Share>(
        &mut self,
        store: &mut S,
        now: Instant,
        exchange: &mut X,
    ) {
        if self.node.is_loading() {
            self.hooks.protection.load();
            self.node.load_parameters(store, now, &mut self.hooks);
            self.hooks.note_load(self.node.dictionary());
            self.start_commissioning();
            self.refresh(now, false, exchange);
            self.hooks.post_all_anew();
            self.post(exchange);
        }
        self.store_serial_number(store, exchange);
        if !self.node.is_storing() {
            self.unsafe_since = None;
        } else if exchange.lock(|exchange| exchange.is_safe()) {
            self.unsafe_since = None;
            self.node.store_parameters(store, now);
        } else {
            let since = *self.unsafe_since.get_or_insert(now);
            if now.ticks().saturating_sub(since.ticks()) >= POWER_OFF_TIMEOUT.ticks() {
                self.unsafe_since = None;
                self.node.refuse_storing(AbortCode::DeviceState);
            }
        }
    }
}
