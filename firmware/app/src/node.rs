//! What the node task does: frames in, time on, frames and events out.
//!
//! It runs after a frame, after room to send, and after every control tick; CANopen itself is [`Device`]'s. Frames are
//! handed over with the time they arrived, and what the device answers goes to the controller between them. What the
//! device asks of the firmware (store, switch the bit rate) is done here.
//!
//! The contract:
//! - One run takes no more frames than can wait, so timers and the watchdog are served under any load of the bus.
//! - The device keeps its frames until the controller has room for them; those that had to make way for others are offered again
//!   ([`Outbox`]). None is dropped here, unless the device is reset: then the boot-up message is the first.
//! - Settings and parameters are stored only while the drive is safe, as writing to flash stops the processor. A master that
//!   does not switch the drive off gets an error, in time. Commands come from this task too, so none can switch the drive on
//!   while flash is written. One run writes one chunk, or the settings.
//! - A bit rate is looked for with the frames and errors of that bit rate alone: what was received before the controller has left
//!   another one never counts for it.
//! - The bit rate changes at the moment the device said, not earlier, and after the frame that is on the bus then; one this board cannot make was refused before.

use canopen::cia301::nmt::NmtState;
use canopen::cia303::{Pattern, Signal};
use canopen::cia305::Detection;
use canopen::node::StoreError;
use canopen::settings::PowerOn;
use canopen::{BitRate, BitTiming, Configuration, Duration, Event, Instant, Outbox, Settings};
use cia402::{Device, DriveSignal, Exchange, Share};
use rtic::Mutex;

use crate::board::{Board, Bus, Receive, Selected};
use crate::clock;
use crate::dictionary::Dictionary;
use crate::inbox::{Lost, Received, Stamped};
use crate::lights::Signals;
use crate::machine::Machine;
use crate::settings::{self, Parameters};
use crate::share::{Locked, LockedBus};

/// Writing to flash may stop the processor for a while, so it waits until the motor has no current; a master that asks
/// for it while the drive is enabled is answered with an error after this time.
const STORE_PATIENCE: Duration = Duration::millis(50);

/// As many frames may have to make way as a controller has mailboxes.
const MAILBOXES: usize = 3;

type CanBus = <Selected as Board>::Bus;
type Receiver = <Selected as Board>::Receiver;

/// The CANopen device and what belongs to its task.
pub struct Node {
    device: Device<Dictionary, Machine>,
    received: Received,
    lost: &'static Lost,
    lost_before: u32,
    /// The controller is to start again after bus-off.
    restarts: bool,
    /// Frames that had to make way for others.
    outbox: Outbox<MAILBOXES>,
    store: Parameters<<Selected as Board>::Parameters>,
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

impl Node {
    /// A node that starts as the settings say, with what is stored. `serial_number` becomes object 1018h:4.
    pub fn new(
        settings: Settings,
        power_on: &PowerOn,
        serial_number: u32,
        machine: Machine,
        received: Received,
        lost: &'static Lost,
        mut store: Parameters<<Selected as Board>::Parameters>,
    ) -> Self {
        let device = Device::with_application(Dictionary::new(), settings, serial_number, machine)
            .supporting(CanBus::BIT_RATES)
            .started(power_on)
            .detecting()
            .produced(settings::serial_number(&mut store));
        let device = match store {
            Some(_) => device.with_parameter_store(),
            None => device,
        };
        Self {
            device,
            lost,
            lost_before: lost.count(),
            restarts: false,
            store,
            received,
            outbox: Outbox::new(),
            to_store: None,
            switch: None,
            bit_rate: settings.bit_rate,
            detection: None,
            bit_timing: power_on.bit_timing.value,
            booted: false,
            next_signal: Instant::from_ticks(0),
        }
    }

    /// Goes on the bus and boots the node, or begins to look for the bit rate.
    pub fn power_on(&mut self, exchange: &mut Exchange, bus: &mut CanBus) {
        match self.bit_timing {
            BitTiming::Fixed(bit_rate) => {
                self.start(bit_rate, bus);
                self.boot(clock::now(), exchange);
            }
            BitTiming::Automatic => self.find_bit_rate(clock::now(), bus),
        }
    }

    fn boot(&mut self, now: Instant, exchange: &mut impl Share) {
        self.booted = true;
        self.device.power_on(now, exchange);
        self.serve_store(now, exchange);
    }

    fn start(&mut self, bit_rate: BitRate, bus: &mut CanBus) {
        self.bit_rate = bit_rate;
        if bus.start(bit_rate).is_err() {
            defmt::error!("no {=u32} kbit/s on this board", bit_rate.kbit_per_second());
        }
    }

    fn find_bit_rate(&mut self, now: Instant, bus: &mut CanBus) {
        let detection = Detection::new(CanBus::BIT_RATES, now);
        // One that the board makes: it is of its list.
        let _ = bus.listen(detection.bit_rate());
        self.bit_rate = detection.bit_rate();
        self.detection = Some(detection);
    }

    /// Listens for a while longer; goes on the bus when the bit rate is known.
    fn serve_detection(
        &mut self,
        now: Instant,
        bus: &mut impl Mutex<T = CanBus>,
        exchange: &mut impl Mutex<T = Exchange>,
    ) {
        let Some(detection) = &mut self.detection else {
            return;
        };
        if bus.lock(|bus| bus.error_seen()) {
            detection.error_seen();
        }
        detection.poll(now);
        if !detection.is_over() {
            return;
        }
        // A frame on the bus may take a while; it is asked again after the next control tick.
        if !bus.lock(|bus| bus.leave()) {
            return;
        }
        // What came until then came at this bit rate. The device never saw them on the bus, so they are not for it.
        while self.received.dequeue().is_some() {
            detection.frame_received();
        }
        detection.left(now);
        let bit_rate = detection.bit_rate();
        if detection.found().is_some() {
            defmt::info!("found {=u32} kbit/s", bit_rate.kbit_per_second());
            self.detection = None;
            bus.lock(|bus| self.start(bit_rate, bus));
            self.device.bit_rate_found(bit_rate, now);
            if !self.booted {
                self.boot(now, &mut Locked(exchange));
            }
        } else {
            self.bit_rate = bit_rate;
            let _ = bus.lock(|bus| bus.listen(bit_rate));
        }
    }

    /// Everything there is to do. `stop` is called as soon as the motor is to stop before the next control tick.
    pub fn run(
        &mut self,
        mut exchange: impl Mutex<T = Exchange>,
        mut bus: impl Mutex<T = CanBus>,
        mut stop: impl FnMut(),
    ) {
        // No more frames than can wait, so that time passes under any load; answers go out between the requests.
        for _ in 0..crate::inbox::DEPTH {
            let Some(Stamped { frame, at }) = self.received.dequeue() else {
                break;
            };
            match &mut self.detection {
                // It shows the bit rate; what it says is for those that have acknowledged it.
                Some(detection) => detection.frame_received(),
                None => {
                    self.device.receive(&frame, at, &mut Locked(&mut exchange));
                    if self.device.calls_early() {
                        stop();
                    }
                    self.send(&mut bus);
                }
            }
        }
        bus.lock(Receiver::resume);

        let now = clock::now();
        self.serve_detection(now, &mut bus, &mut exchange);
        if self.detection.is_none() {
            self.watch_controller(now, &mut bus, &mut exchange);
        }
        // The deadline it gives is never sooner than the next control tick, after which this runs anyway.
        self.device.poll(now, &mut Locked(&mut exchange));
        if self.device.calls_early() {
            stop();
        }
        while let Some(event) = self.device.event() {
            match event {
                // The lights ask for the state when they want it.
                Event::StateChanged(_) => {}
                Event::StoreSettings(settings) => {
                    self.to_store = Some((settings, now + STORE_PATIENCE));
                }
                Event::SwitchBitRate { bit_rate, at } => {
                    self.switch = Some((BitTiming::Fixed(bit_rate), at));
                }
                Event::FindBitRate { at } => self.switch = Some((BitTiming::Automatic, at)),
                // The device stops the drive and boots by itself.
                Event::ResetRequested(_) => {}
                // The device has stopped the drive already.
                Event::CommunicationError(_) | Event::EmergencyReceived(_) => {}
                Event::RestartController => self.restarts = true,
            }
        }
        self.switch_bit_rate(now, &mut bus);
        self.restart_controller(&mut bus);
        self.send(&mut bus);
        self.store_settings(now, &mut exchange);
        self.serve_store(now, &mut Locked(&mut exchange));
        self.send(&mut bus);
    }

    /// Tells the device how its controller is, and what it lost.
    fn watch_controller(
        &mut self,
        now: Instant,
        bus: &mut impl Mutex<T = CanBus>,
        exchange: &mut impl Mutex<T = Exchange>,
    ) {
        let state = bus.lock(|bus| bus.state());
        self.device
            .controller_changed(state, now, &mut Locked(exchange));
        let lost = self.lost.count();
        if lost != self.lost_before {
            self.device
                .frames_lost(lost.wrapping_sub(self.lost_before), now);
            self.lost_before = lost;
        }
    }

    /// Starts the controller again after bus-off.
    fn restart_controller(&mut self, bus: &mut impl Mutex<T = CanBus>) {
        if self.restarts && bus.lock(|bus| bus.leave()) {
            self.restarts = false;
            let bit_rate = self.bit_rate;
            bus.lock(|bus| self.start(bit_rate, bus));
        }
    }

    /// Stores what the layer setting services have ordered.
    fn store_settings(&mut self, now: Instant, exchange: &mut impl Mutex<T = Exchange>) {
        let Some((settings, until)) = self.to_store else {
            return;
        };
        if exchange.lock(|exchange| exchange.is_safe()) {
            self.to_store = None;
            let result = settings::save(&mut self.store, &settings);
            self.device.settings_stored(result);
        } else if now >= until {
            self.to_store = None;
            self.device.settings_stored(Err(StoreError::Medium));
        }
    }

    /// Loads parameters, or stores the next chunk of them.
    fn serve_store(&mut self, now: Instant, exchange: &mut impl Share) {
        if let Some(store) = &mut self.store {
            self.device.serve_store(store, now, exchange);
        }
    }

    /// What the lights are to say, once for each step of their patterns.
    pub fn signal(&mut self) -> Option<Signals> {
        let now = clock::now();
        (now >= self.next_signal).then(|| {
            self.next_signal = now + Pattern::STEP;
            let dictionary = self.device.node().dictionary();
            let signal = self.device.node().signal();
            Signals {
                network: Signal {
                    configuring: signal.configuring || self.detection.is_some(),
                    ..signal
                },
                drive: DriveSignal::new(dictionary.statusword(), dictionary.error_code()),
            }
        })
    }

    fn switch_bit_rate(&mut self, now: Instant, bus: &mut impl Mutex<T = CanBus>) {
        if let Some((timing, _)) = self.switch.filter(|(_, at)| now >= *at) {
            // A frame on the bus may take a while; meanwhile the control tick goes on, and so do the pulses.
            if !bus.lock(|bus| bus.leave()) {
                return;
            }
            self.switch = None;
            if timing == BitTiming::Automatic {
                // What came at the old bit rate says nothing about the one to be found.
                while self.received.dequeue().is_some() {}
            }
            bus.lock(|bus| match timing {
                BitTiming::Fixed(bit_rate) => {
                    self.detection = None;
                    self.start(bit_rate, bus);
                }
                BitTiming::Automatic => self.find_bit_rate(now, bus),
            });
        }
    }

    /// Hands frames to the controller until it has no more room. While the node is mute, a frame that had to make way waits as
    /// well; after a reset it is void: the first frame is the boot-up message.
    fn send(&mut self, bus: &mut impl Mutex<T = CanBus>) {
        let node = self.device.node();
        if node.is_mute() {
            if node.state() == NmtState::Initialisation {
                self.outbox.clear();
            }
            return;
        }
        self.device.drop_late(clock::now());
        self.outbox.send(&mut self.device, &mut LockedBus(bus));
    }
}
