//! A tick between two control ticks, for a command to stop: halt, quick stop, disable operation or voltage, a network that is lost. It
//! would wait for up to a period.
//!
//! It does what concerns the command and the motor: state machine, mode, plan, and what is published of them. Everything that goes by
//! the regular beat is left to it: switches and their debouncing, edges of inputs and the touch probes, data records and set-points of the cyclic
//! modes, the rhythm of the ticks, pulses for a motor that moves, the sixteen ticks of the actual velocity, samples of the scope. So no
//! time is shortened and nothing is consumed twice. All other times are taken from the clock.

use canopen::Instant;
use motion::PulseSink;

use super::{Drive, Inputs, Outputs};
use crate::actuator::Actuator;
use crate::exchange::{Exchange, Share};
use crate::inputs::DigitalInputs;
use crate::objects::Objects;

impl<D: Objects> Drive<D> {
    /// A tick as soon as a command to stop has come ([`Exchange::calls_early`]); the regular ones come behind it as they would have
    /// come. `now` and `inputs` are as for [`Drive::tick`], but the digital inputs are not looked at: their edges are for the
    /// regular tick.
    pub fn early_tick<S: PulseSink, X: Share>(
        &mut self,
        now: Instant,
        inputs: &Inputs,
        pulses: &mut S,
        exchange: &mut X,
    ) -> Outputs {
        let waiting = exchange.lock(|exchange| exchange.take_early(&mut self.commands));
        if waiting.is_configured {
            exchange.lock(|exchange| exchange.take_configuration(&mut self.configuration));
            self.cyclic.look_anew();
        }
        self.is_early = true;
        self.is_seen = waiting.is_seen;
        self.cyclic.slots.clear();
        self.switches.forget_edges();
        let command = self.command();
        let (position, displaced) = self.look_at_motor(now, inputs, pulses);
        self.look_for_changes(waiting.is_configured, position);
        let inputs = &Inputs {
            digital: DigitalInputs {
                levels: self.switches.levels(),
                ..DigitalInputs::NONE
            },
            ..*inputs
        };
        // What is only written once, to probes and outputs, is in the commands of this tick.
        self.measure(inputs, 0);
        self.periphery.probes.follow_later(&self.commands);
        if self.power {
            let (demand, is_counted) = (self.motor.demand(), inputs.slack == 0);
            (self.observed).look_again(demand, position, is_counted);
        }
        self.restarted &= self.commands.restart;
        self.change_state(now, inputs, command, displaced);
        self.move_brake(now);
        let blocked = self.blocked(inputs, position);
        let mode_bits = self.operate(now, position, 0, blocked, command, pulses);
        if !self.keeps_records() {
            // At the next regular tick they may be kept again, but none of those that came before the stop.
            self.cyclic.buffer.clear();
            exchange.lock(Exchange::forget_records);
        }
        self.hand_over((now, 0), inputs, mode_bits, false, pulses, exchange)
    }
}
