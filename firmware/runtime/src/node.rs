//! What the node task does: frames in, time on, frames and events out.
//!
//! It runs after a frame, after room to send, after every control tick and at its own deadlines; CANopen itself is [`Device`]'s. Frames are
//! handed over with the time they arrived, and what the device answers goes to the controller between them. What the
//! device asks of the firmware (store, switch the bit rate) is done here.
//!
//! The contract:
//! - One run takes no more frames than can wait, so timers and the watchdog are served under any load of the bus.
//! - The device keeps its frames until the controller has room for them; those that had to make way for others are offered again
//!   ([`Outbox`]). None is dropped here, unless the device is reset: then the boot-up message is the first.
//! - Settings and parameters are stored only while the drive is safe, as writing to flash may stop the processor. A master that
//!   does not switch the drive off gets an error, in time. Commands come from this task too, so none can switch the drive on
//!   while flash is written. One run writes one chunk, or the settings.
//! - A bit rate is looked for with the frames and errors of that bit rate alone: what was received before the controller has left
//!   another one never counts for it.
//! - The bit rate changes at the moment the device said, not earlier, and after the frame that is on the bus then; one this board
//!   cannot make was refused before.

use canopen::cia301::nmt::NmtState;
use canopen::cia303::{Pattern, Signal};
use canopen::cia305::Detection;
use canopen::node::StoreError;
use canopen::od;
use canopen::outbox::Mailboxes;
use canopen::settings::PowerOn;
use canopen::time::NEVER;
use canopen::{
    Application, BitRate, BitTiming, Configuration, ControllerState, Duration, Event, Instant,
    Outbox, Settings,
};
use cia402::{Behaves, Device, DriveSignal, Share};

use crate::inbox::DEPTH;
use crate::indicator::Signals;
use crate::ports::{Controller, Host, Reception, Stamped, Storage};

/// Writing to flash may stop the processor for a while, so it waits until the motor has no current; a master that asks
/// for it while the drive is enabled is answered with an error after this time.
const STORE_PATIENCE: Duration = Duration::millis(50);

/// As many frames may have to make way as a controller has mailboxes.
const MAILBOXES: usize = 3;

/// Statusword and error code of the dictionary.
const STATUSWORD: u16 = 0x6041;
const ERROR_CODE: u16 = 0x603F;

/// The CANopen device with the dictionary `D` and the application `A`, and what belongs to its task; it stores in `S`.
#[derive(Debug)]
pub struct Node<D: Behaves, A, S> {
    device: Device<D, A>,
    /// `None` on a host without a store.
    store: Option<S>,
    /// How many frames were lost before.
    lost: u32,
    /// The controller is to start again after bus-off.
    restarts: bool,
    /// Frames that had to make way for others.
    outbox: Outbox<MAILBOXES>,
    /// Settings that wait to be stored, and until when they may.
    to_store: Option<(Configuration, Instant)>,
    /// A bit rate that the layer setting services have ordered, and when to change to it.
    switch: Option<(BitTiming, Instant)>,
    /// What the controller is set to.
    bit_rate: BitRate,
    /// The bit rate is not known; the controller listens in silence.
    detection: Option<Detection>,
    /// What this power-on has brought.
    bit_timing: BitTiming,
    /// The device has booted: at power-on it waits for the bit rate.
    booted: bool,
    /// When the lights want the next signal.
    next_signal: Instant,
}

impl<D, A, S> Node<D, A, S>
where
    D: Behaves,
    A: Application<D>,
    S: Storage,
{
    /// A node that starts as `power_on` says, with what is stored. `serial_number` becomes object 1018h:4, unless production has given
    /// another. [`Node::set_up`] comes next.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub fn new(
        dictionary: D,
        application: A,
        power_on: &PowerOn,
        serial_number: u32,
        store: Option<S>,
    ) -> Self {
        let bit_timing = power_on.bit_timing.value;
        let settings = Settings {
            node_id: power_on.node_id.value,
            bit_rate: (bit_timing.bit_rate()).unwrap_or(Settings::default().bit_rate),
        };
        Self {
            store,
            lost: 0,
            restarts: false,
            outbox: Outbox::new(),
            to_store: None,
            switch: None,
            bit_rate: settings.bit_rate,
            detection: None,
            bit_timing,
            booted: false,
            next_signal: Instant::from_ticks(0),
            // Last, as it is large: so it is made where it stays.
            device: Device::with_application(dictionary, settings, serial_number, application),
        }
    }

    /// Its controller makes these bit rates, and its actuator can do these modes (`Actuator::MODES`).
    // Apart from `new`, as it works on the node where that stays.
    pub fn set_up(&mut self, power_on: &PowerOn, bit_rates: &[BitRate], modes: u32) {
        self.device.support(bit_rates);
        self.device.start(power_on);
        self.device.detect();
        self.device.moved_by(modes);
        if let Some(store) = &mut self.store {
            self.device.produced_as(store.serial_number());
            self.device.store_parameters_here();
        }
    }

    /// The CANopen half of the drive, for its dictionary and state.
    pub const fn device(&self) -> &Device<D, A> {
        &self.device
    }

    /// The store; what is put in its place counts from now on.
    pub const fn store_mut(&mut self) -> &mut Option<S> {
        &mut self.store
    }

    /// The object dictionary, for the firmware to put in what it has measured beside the drive.
    pub fn dictionary_mut(&mut self) -> &mut D {
        self.device.dictionary_mut()
    }

    /// The object dictionary, and what the product does that is no data.
    pub fn product(&mut self) -> (&mut D, &mut D::Behaviour) {
        self.device.product()
    }

    /// Goes on the bus and boots the node, or begins to look for the bit rate.
    pub fn power_on(&mut self, host: &mut impl Host, controller: &mut impl Controller) {
        let now = host.now();
        match self.bit_timing {
            BitTiming::Fixed(bit_rate) => {
                self.start(bit_rate, controller);
                self.boot(now, host);
            }
            BitTiming::Automatic => self.find_bit_rate(now, controller),
        }
    }

    fn boot(&mut self, now: Instant, exchange: &mut impl Share) {
        self.booted = true;
        self.device.power_on(now, exchange);
        self.serve_store(now, exchange);
    }

    /// Everything there is to do. Returns when it wants to run again at the latest; what waits for the drive or for the controller is
    /// looked at again after the next control tick.
    pub fn run(
        &mut self,
        host: &mut impl Host,
        controller: &mut impl Controller,
        reception: &mut impl Reception,
    ) -> Instant {
        // No more frames than can wait, so that time passes under any load; answers go out between the requests.
        for _ in 0..DEPTH {
            let Some(Stamped { frame, at }) = reception.receive() else {
                break;
            };
            match &mut self.detection {
                // It shows the bit rate; what it says is for those that have acknowledged it.
                Some(detection) => detection.frame_received(),
                None => {
                    self.device.receive(&frame, at, host);
                    if self.device.calls_early() {
                        host.stop();
                    }
                    self.send(host.now(), controller);
                }
            }
        }
        controller.resume();

        let now = host.now();
        let found = self.serve_detection(now, host, controller, reception);
        if self.detection.is_none() {
            self.watch_controller(now, host, controller.state(), reception.lost());
        }
        let deadline = self.device.poll(now, host);
        if self.device.calls_early() {
            host.stop();
        }
        while let Some(event) = self.device.event() {
            self.heed(&event, now);
            host.tell(&event);
        }
        self.switch_bit_rate(now, controller, reception);
        self.restart_controller(controller);
        self.send(host.now(), controller);
        self.store_settings(now, host);
        self.serve_store(now, host);
        self.send(host.now(), controller);
        let switch = self.switch.map(|(_, at)| at).filter(|at| *at > now);
        let store = self.to_store.map(|(_, until)| until);
        let own = switch.unwrap_or(NEVER).min(store.unwrap_or(NEVER));
        deadline.min(found).min(own)
    }

    /// Hands frames to the controller until it has no more room. While the node is mute, a frame that had to make way waits as
    /// well; after a reset it is void: the first frame is the boot-up message.
    pub fn send(&mut self, now: Instant, mailboxes: &mut impl Mailboxes) {
        let node = self.device.node();
        if node.is_mute() {
            if node.state() == NmtState::Initialisation {
                self.outbox.clear();
                mailboxes.withdraw();
            }
            return;
        }
        self.device.drop_late(now);
        self.outbox.send(&mut self.device, mailboxes);
    }

    /// What the lights are to say, once for each step of their patterns.
    pub fn signal(&mut self, now: Instant) -> Option<Signals> {
        (now >= self.next_signal).then(|| {
            self.next_signal = now.checked_add_duration(Pattern::STEP).unwrap_or(now);
            let node = self.device.node();
            let number = |index| od::read_u16(node.dictionary(), index, 0).unwrap_or_default();
            let signal = node.signal();
            Signals {
                network: Signal {
                    configuring: signal.configuring || self.detection.is_some(),
                    ..signal
                },
                drive: DriveSignal::new(number(STATUSWORD), number(ERROR_CODE)),
            }
        })
    }

    /// What an event asks of the firmware. The device has stopped the drive, or boots, by itself.
    fn heed(&mut self, event: &Event, now: Instant) {
        match *event {
            Event::StoreSettings(settings) => {
                let until = now.checked_add_duration(STORE_PATIENCE).unwrap_or(now);
                self.to_store = Some((settings, until));
            }
            Event::SwitchBitRate { bit_rate, at } => {
                self.switch = Some((BitTiming::Fixed(bit_rate), at));
            }
            Event::FindBitRate { at } => self.switch = Some((BitTiming::Automatic, at)),
            Event::RestartController => self.restarts = true,
            // What is told only: the device has acted on it.
            _ => {}
        }
    }

    fn start(&mut self, bit_rate: BitRate, controller: &mut impl Controller) {
        self.bit_rate = bit_rate;
        if controller.start(bit_rate).is_err() {
            error!(
                "this board does not make {} kbit/s",
                bit_rate.kbit_per_second()
            );
        }
    }

    fn find_bit_rate<C: Controller>(&mut self, now: Instant, controller: &mut C) {
        let detection = Detection::new(C::BIT_RATES, now);
        // One that the board makes: it is of its list.
        let _ = controller.listen(detection.bit_rate());
        self.bit_rate = detection.bit_rate();
        self.detection = Some(detection);
    }

    /// Listens for a while longer; goes on the bus when the bit rate is known. Returns when it wants to be called again.
    fn serve_detection(
        &mut self,
        now: Instant,
        exchange: &mut impl Share,
        controller: &mut impl Controller,
        reception: &mut impl Reception,
    ) -> Instant {
        let Some(detection) = &mut self.detection else {
            return NEVER;
        };
        if controller.error_seen() {
            detection.error_seen();
        }
        let deadline = detection.poll(now);
        // A frame on the bus may take a while; it is asked again after the next control tick.
        if !detection.is_over() || !controller.leave() {
            return deadline;
        }
        // What came until then came at this bit rate. The device never saw them on the bus, so they are not for it.
        while reception.receive().is_some() {
            detection.frame_received();
        }
        detection.left(now);
        let deadline = detection.poll(now);
        let bit_rate = detection.bit_rate();
        if detection.found().is_some() {
            info!("found {=u32} kbit/s", bit_rate.kbit_per_second());
            self.detection = None;
            self.start(bit_rate, controller);
            self.device.bit_rate_found(bit_rate, now);
            if !self.booted {
                self.boot(now, exchange);
            }
        } else {
            self.bit_rate = bit_rate;
            let _ = controller.listen(bit_rate);
        }
        deadline
    }

    fn switch_bit_rate(
        &mut self,
        now: Instant,
        controller: &mut impl Controller,
        reception: &mut impl Reception,
    ) {
        let Some((timing, _)) = self.switch.filter(|(_, at)| now >= *at) else {
            return;
        };
        // Nothing of the old bit rate is sent at the new one.
        self.outbox.clear();
        controller.withdraw();
        // A frame on the bus may take a while; meanwhile the control tick goes on, and so do the pulses.
        if !controller.leave() {
            return;
        }
        self.switch = None;
        match timing {
            BitTiming::Fixed(bit_rate) => {
                self.detection = None;
                self.start(bit_rate, controller);
            }
            BitTiming::Automatic => {
                // What came at the old bit rate says nothing about the one to be found.
                while reception.receive().is_some() {}
                self.find_bit_rate(now, controller);
            }
        }
    }

    /// Tells the device how its controller is, and what it lost.
    fn watch_controller(
        &mut self,
        now: Instant,
        exchange: &mut impl Share,
        state: ControllerState,
        lost: u32,
    ) {
        self.device.controller_changed(state, now, exchange);
        if lost != self.lost {
            self.device.frames_lost(lost.wrapping_sub(self.lost), now);
            self.lost = lost;
        }
    }

    /// Starts the controller again after bus-off.
    fn restart_controller(&mut self, controller: &mut impl Controller) {
        if self.restarts && controller.leave() {
            self.restarts = false;
            self.start(self.bit_rate, controller);
        }
    }

    /// Stores what the layer setting services have ordered.
    fn store_settings(&mut self, now: Instant, exchange: &mut impl Share) {
        let Some((settings, until)) = self.to_store else {
            return;
        };
        let result = if exchange.lock(|exchange| exchange.is_safe()) {
            let store = self.store.as_mut().ok_or(StoreError::NotSupported);
            store.and_then(|store| store.save(&settings))
        } else if now >= until {
            Err(StoreError::Medium)
        } else {
            return;
        };
        self.to_store = None;
        self.device.settings_stored(result);
    }

    /// Loads parameters, or stores the next chunk of them.
    fn serve_store(&mut self, now: Instant, exchange: &mut impl Share) {
        if let Some(store) = &mut self.store {
            self.device.serve_store(store, now, exchange);
        }
    }
}
