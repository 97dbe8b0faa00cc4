//! What a host gives to the runtime: its power stage with the pulses, its CAN controller, its flash, its clock.

use canopen::cia301::parameters::ParameterStore;
use canopen::node::StoreError;
use canopen::outbox::Mailboxes;
use canopen::{BitRate, Configuration, ControllerState, Event, Frame, Instant};
use cia402::{Inputs, Outputs, Share};
use embedded_storage::nor_flash::NorFlash;
use motion::PulseSink;
use store::Store;

/// A frame and when it arrived.
#[derive(Clone, Copy, Debug)]
pub struct Stamped {
    /// The frame.
    pub frame: Frame,
    /// When it arrived.
    pub at: Instant,
}

/// The bit rate cannot be made from the clock of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unreachable;

/// The frames that a CAN controller has received.
pub trait Reception {
    /// The oldest frame that waits to be served.
    fn receive(&mut self) -> Option<Stamped>;

    /// How many received frames were lost since power-on; it wraps.
    fn lost(&self) -> u32;
}

/// A CAN controller: what it sends, and the state of the whole.
pub trait Controller: Mailboxes {
    /// The bit rates that can be made from its clock, 100 kbit/s among them if it is one.
    const BIT_RATES: &'static [BitRate];

    /// There is room for received frames again. Called each time some were taken.
    fn resume(&mut self) {}

    /// Asks the controller to leave the bus, which it does after the frame that is on it. Does not wait: true once it has
    /// left, so that [`Controller::start`] takes no time; false to ask again later.
    fn leave(&mut self) -> bool;

    /// Goes on the bus at this rate, or leaves what it is doing and comes back at this rate. On a bus it waits for the end
    /// of the frame there, unless [`Controller::leave`] has.
    ///
    /// # Errors
    /// [`Unreachable`]: the rate is none of [`Controller::BIT_RATES`]; nothing has changed.
    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable>;

    /// As [`Controller::start`], but in silence: the controller receives frames and sends nothing, neither an acknowledge nor an
    /// error flag.
    ///
    /// # Errors
    /// [`Unreachable`]: as [`Controller::start`].
    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable>;

    /// Whether it has seen a frame that it could not read since the last call, or since it began to listen.
    fn error_seen(&mut self) -> bool;

    /// How well it gets on with the bus. After bus-off it returns when [`Controller::leave`] and [`Controller::start`] have
    /// started it again.
    fn state(&mut self) -> ControllerState;
}

/// The firmware around the node: its clock, and the control tick, with which it shares the exchange.
pub trait Host: Share {
    /// The time now, on the clock that stamps received frames. It never goes back.
    fn now(&self) -> Instant;

    /// A command to stop has come: [`Control::stop`](crate::Control::stop) is to run at once, and then the node again.
    fn stop(&mut self);

    /// What the device has told. The node has done its part already.
    fn tell(&mut self, event: &Event) {
        let _ = event;
    }
}

/// The power stage of the motor, its pulses, its monitors, and the watchdog over the tasks.
pub trait PowerStage {
    /// Where step pulses go.
    type Pulses: PulseSink;

    /// Where step pulses go.
    fn pulses(&mut self) -> &mut Self::Pulses;

    /// What the pulses ask for regularly. Called before each refill.
    fn service(&mut self);

    /// Puts into `inputs` what every tick needs: supply, position, fault. Returns when that was.
    fn look(&mut self, inputs: &mut Inputs) -> Instant;

    /// Puts in what only a regular tick needs: edges of the digital inputs, supply voltage, temperature, analogue input. Called behind
    /// [`PowerStage::look`]. What the host does not measure it leaves alone.
    fn measure(&mut self, inputs: &mut Inputs);

    /// Current in the motor or none, brake, digital outputs, and what a motor driver is set to.
    fn carry_out(&mut self, outputs: &Outputs);

    /// Drops the pulses that have not been played. One that has begun counts.
    fn drop_pulses(&mut self);

    /// Every task is alive.
    fn feed_watchdog(&mut self) {}
}

/// Where settings and parameters are kept without power.
pub trait Storage: ParameterStore {
    /// The settings that were stored last; `None` if there never were any.
    ///
    /// # Errors
    /// They cannot be read.
    fn load(&mut self) -> Result<Option<Configuration>, StoreError>;

    /// Stores settings.
    ///
    /// # Errors
    /// They are not stored.
    fn save(&mut self, settings: &Configuration) -> Result<(), StoreError>;

    /// Factory reset: settings and parameters are as if none were ever stored.
    ///
    /// # Errors
    /// Something is not forgotten.
    fn forget(&mut self) -> Result<(), StoreError>;

    /// The serial number that production has given to the device, if it has.
    fn serial_number(&mut self) -> Option<u32>;
}

impl<F: NorFlash> Storage for Store<F> {
    fn load(&mut self) -> Result<Option<Configuration>, StoreError> {
        Self::load(self).map_err(failed)
    }

    fn save(&mut self, settings: &Configuration) -> Result<(), StoreError> {
        Self::save(self, settings).map_err(failed)
    }

    fn forget(&mut self) -> Result<(), StoreError> {
        Self::forget(self).map_err(failed)
    }

    fn serial_number(&mut self) -> Option<u32> {
        Self::serial_number(self).ok().flatten()
    }
}

/// What a master is told, and the log in more words.
fn failed<E: core::fmt::Debug>(error: store::Error<E>) -> StoreError {
    error!("parameters: {}", error);
    StoreError::Medium
}
