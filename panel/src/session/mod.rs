//! The session with the bus. One thread owns the master: orders come in through a bounded queue, states and frames go out to whoever
//! listens. What may not wait in a queue is on the [`Desk`].
//!
//! The session knows its bus as a [`Line`], so what it does on copper is what its tests see on virtual time.

mod drive;
mod files;
mod guard;
mod homing;
mod nodes;
mod objects;
mod pdos;
mod poll;
mod scope;
#[cfg(test)]
mod tests;
mod tuning;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};

use canopen::{Duration, Instant};
use master::axis402::{Node, Problem};
use master::data_sheet::DataSheet;
use master::{Line, LineDown, Master};
use tokio::sync::{broadcast, watch};

use crate::desk::{Counts, Desk};
use crate::line::PanelLine;
use crate::message::{Answer, Event, Order, Outcome, Recorded, State};
use crate::traffic::Traffic;
use poll::Chosen;

/// From a look at the bus to the next.
const TURN: Duration = Duration::from_ticks(10_000);

/// From a state of everything to the next, and from what has passed to the next: a screen shows 60 pictures a second.
const PICTURE: Duration = Duration::from_ticks(40_000);
const BATCH: Duration = Duration::from_ticks(16_000);

/// Batches that a window may be behind.
const BATCHES: usize = 64;

/// An order of a window.
pub struct Ticket {
    /// The window.
    pub window: u64,
    /// What it wants.
    pub order: Order,
    /// How many stops and releases there had been on the desk when it was ordered.
    pub counts: Counts,
    /// Where the outcome goes.
    pub reply: Box<dyn FnOnce(Outcome) + Send>,
}

impl fmt::Debug for Ticket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ticket")
            .field("window", &self.window)
            .field("order", &self.order)
            .finish_non_exhaustive()
    }
}

/// What goes out to all windows: the newest state, and frames as they come, as JSON.
#[derive(Clone, Debug)]
pub struct Outlet {
    /// The newest state; who is slow misses the ones between.
    pub states: watch::Sender<Arc<str>>,
    /// Frames in batches; who is slow misses the oldest.
    pub frames: broadcast::Sender<Arc<str>>,
    /// What transmit PDOs bring, in batches as well.
    pub live: broadcast::Sender<Arc<str>>,
}

impl Outlet {
    /// Nothing was told yet.
    pub fn new() -> Self {
        Self {
            states: watch::Sender::new(json(&Event::State(Box::default()))),
            frames: broadcast::Sender::new(BATCHES),
            live: broadcast::Sender::new(BATCHES),
        }
    }
}

impl Default for Outlet {
    fn default() -> Self {
        Self::new()
    }
}

/// A message as it travels.
pub fn json(event: &Event) -> Arc<str> {
    // Numbers, texts and lists of them always have a JSON.
    serde_json::to_string(event).unwrap_or_default().into()
}

/// How a session is.
#[derive(Clone, Debug)]
pub struct Setup {
    /// What the bus is called.
    pub title: String,
    /// The drive is the virtual one of this program.
    pub is_virtual: bool,
    /// Its bit rate in bit/s, where it is known.
    pub bit_rate: Option<u32>,
    /// Nothing but uploads is sent.
    pub read_only: bool,
    /// The node-ID of the panel's heartbeat.
    pub own_node: u8,
    /// The data sheets that a person has given.
    pub sheets: Vec<Arc<DataSheet>>,
    /// Something that a person should know from the start.
    pub notice: Option<String>,
}

/// The session.
#[derive(Debug)]
pub struct Session<L> {
    master: Master<PanelLine<L>>,
    desk: Arc<Desk>,
    tickets: Receiver<Ticket>,
    outlet: Outlet,
    setup: Setup,
    traffic: Traffic,
    state: State,
    chosen: Option<Chosen>,
    nodes: BTreeMap<u8, Node>,
    /// The data sheets that a person has chosen for single nodes.
    sheets: BTreeMap<u8, Arc<DataSheet>>,
    recording: Option<scope::Recording>,
    recorded: Option<Recorded>,
    live: Option<scope::Live>,
    known: tuning::Known,
    /// A person has stopped the drive, or no window is open any more, since a measurement began.
    is_ended: bool,
    emptied: u64,
    next_picture: Instant,
    next_batch: Instant,
    next_stranger: Instant,
}

impl<L: Line> Session<L> {
    /// A session of `master`, which is on the bus.
    pub fn new(
        master: Master<L>,
        desk: Arc<Desk>,
        tickets: Receiver<Ticket>,
        outlet: Outlet,
        setup: Setup,
    ) -> Self {
        let answer_time = master.answer_time();
        let line = PanelLine::new(master.into_line(), Arc::clone(&desk));
        let mut master = Master::on(line);
        master.set_answer_time(answer_time);
        let mut state = State::default();
        state.bus.title.clone_from(&setup.title);
        state.bus.is_virtual = setup.is_virtual;
        state.notice.clone_from(&setup.notice);
        Self {
            next_picture: master.now(),
            next_batch: master.now(),
            next_stranger: master.now(),
            master,
            desk,
            tickets,
            outlet,
            setup,
            traffic: Traffic::new(),
            state,
            chosen: None,
            nodes: BTreeMap::new(),
            sheets: BTreeMap::new(),
            recording: None,
            recorded: None,
            live: None,
            known: tuning::Known::default(),
            is_ended: false,
            emptied: 0,
        }
    }

    /// Runs until a person stops it.
    ///
    /// # Errors
    /// Why the bus cannot be used any more.
    pub fn run(&mut self) -> Result<(), LineDown> {
        loop {
            match self.pass() {
                Ok(true) => {}
                Ok(false) => return Ok(()),
                Err(down) if down == LineDown::stopped() => return Ok(()),
                Err(down) => return Err(down),
            }
        }
    }

    /// What is urgent, then one order, or a look at the drive. Returns false when nobody can order anything any more.
    ///
    /// # Errors
    /// [`LineDown`] when the bus cannot be used any more, or a person stops the program.
    pub fn pass(&mut self) -> Result<bool, LineDown> {
        self.attend();
        match self.tickets.try_recv() {
            Ok(ticket) => self.serve(ticket),
            Err(TryRecvError::Empty) => self.look(),
            Err(TryRecvError::Disconnected) => return Ok(false),
        }
        if let Some(down) = self.master.line_mut().down() {
            return Err(down.clone());
        }
        self.publish();
        Ok(true)
    }

    /// How everything is.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The master, for the bus that it is on.
    pub fn master_mut(&mut self) -> &mut Master<PanelLine<L>> {
        &mut self.master
    }

    /// Stops and releases, and windows that have been closed.
    fn attend(&mut self) {
        let urgent = self.master.line_mut().take_urgent();
        if urgent.stop {
            self.is_ended = true;
            self.stop();
        } else if urgent.release {
            self.end_jog();
        }
        // Another window may be open again.
        let emptied = self.desk.emptied();
        if std::mem::replace(&mut self.emptied, emptied) != emptied {
            self.is_ended = true;
            self.leave_drive();
        }
    }

    fn serve(&mut self, ticket: Ticket) {
        let may_write = self.desk.writer() == Some(ticket.window);
        let outcome = if self.setup.read_only && !ticket.order.only_reads() {
            Outcome::Error("the panel was started with --read-only: nothing is written".to_owned())
        } else if !may_write && !ticket.order.is_for_watchers() {
            Outcome::Error("another window has control: take it first".to_owned())
        } else if self.state.tuning.is_some() && !ticket.order.is_for_watchers() {
            Outcome::Error("the motor is being measured: stop it first".to_owned())
        } else if ticket.order.moves() && self.desk.counts().stops != ticket.counts.stops {
            // Stops do not wait in the queue that it has waited in.
            Outcome::Error("a stop came behind it: it was not begun".to_owned())
        } else {
            match self.perform(&ticket.order, ticket.counts.releases) {
                Ok(answer) => Outcome::Done(answer),
                Err(Problem::Stopped) => Outcome::Error("the panel ends".to_owned()),
                Err(problem) => Outcome::Error(problem.line().unwrap_or_default()),
            }
        };
        self.state.busy = None;
        (ticket.reply)(outcome);
    }

    fn perform(&mut self, order: &Order, releases: u64) -> Result<Answer, Problem> {
        match order {
            Order::Scan => self.scan(),
            Order::Number { first, store } => self.number(*first, *store),
            Order::Renumber { node, to, store } => self.renumber(*node, *to, *store),
            Order::Choose { node } => self.choose(*node),
            Order::Nmt { command, node } => self.nmt((*command).into(), *node),
            Order::Save { node } => self.save(*node),
            Order::Find => self.find(),
            Order::BitRate { kbit, store } => self.switch_bit_rate(*kbit, *store),
            Order::StoreLss => self.store_lss(),
            Order::Restore { node } => self.restore(*node),
            Order::Dump { node } => self.dump(*node),
            Order::Load { node, name, text } => self.load(*node, name, text),
            Order::Compare { node, name, text } => self.compare(*node, name, text),
            Order::Sheet { node, name, text } => self.use_sheet(*node, name, text),
            Order::Pdos { node } => self.pdos(*node),
            Order::PlanPdos {
                node,
                pdos,
                sync_period,
            } => self.plan_pdos(*node, pdos, *sync_period),
            Order::SetPdos { node, pdos } => self.set_pdos(*node, pdos),
            Order::Channels => self.channels(),
            Order::Recordable => self.recordable(),
            Order::Record(wish) => self.record(wish),
            Order::StopRecorder => self.stop_recorder(),
            Order::Recording => self.last_recording(),
            Order::Tune(wish) => self.tune(*wish),
            Order::WriteTuning => self.write_tuning(),
            Order::Tuned => self.tuned(),
            Order::SetHoming {
                method,
                fast,
                slow,
                acceleration,
            } => self.set_homing(*method, [*fast, *slow, *acceleration]),
            Order::Transition { transition } => self.transition(*transition),
            Order::Enable => self.enable(),
            Order::Mode { mode } => self.set_mode(*mode),
            Order::Move {
                target,
                relative,
                velocity,
                acceleration,
                deceleration,
            } => self.go(
                *target,
                *relative,
                [*velocity, *acceleration, *deceleration],
            ),
            Order::SetPoint { value } => self.set_point(*value),
            Order::Jog { velocity } => self.jog(*velocity, releases),
            Order::Home => self.home(),
            Order::Dictionary { node } => self.dictionary(*node),
            Order::Read { node, object } => self.read(*node, object),
            Order::Write {
                node,
                object,
                value,
            } => self.write(*node, object, value),
            // These do not wait in a queue: the server has put them on the desk.
            Order::Stop
            | Order::Release
            | Order::Beat
            | Order::Take
            | Order::Frames { .. }
            | Order::Live { .. } => Ok(Answer::Text(String::new())),
        }
    }

    /// Looks at the drive if it is time, and listens until something is to be done.
    fn look(&mut self) {
        if self.is_poll_due() {
            self.poll();
            self.mind_recorder();
        } else {
            let now = self.master.now();
            // What breaks it off is attended to next.
            let _ = self.master.line_mut().step(now + TURN);
        }
        self.meet_stranger();
        // All of it was noted when it came.
        self.master.take_received();
    }

    /// Tells windows what is new, if it is time.
    fn publish(&mut self) {
        let now = self.master.now();
        if now >= self.next_batch {
            self.next_batch = now + BATCH;
            self.follow_traffic();
        }
        if now < self.next_picture {
            return;
        }
        self.next_picture = now + PICTURE;
        let passed = self.master.line_mut().passed_so_far();
        let (frames, bits) = self.traffic.rate(now, passed);
        self.state.bus.rate = u32::try_from(frames).unwrap_or(u32::MAX);
        self.state.bus.kbit = self.setup.bit_rate.map(|rate| rate / 1_000);
        self.state.bus.errors = self.traffic.emergencies();
        let load = |rate: u32| u32::try_from(bits * 100 / u64::from(rate.max(1)));
        self.state.bus.load = self.setup.bit_rate.and_then(|rate| load(rate).ok());
        self.state.nodes = self.traffic.nodes(now);
        self.state.drive = self.chosen.as_ref().map(Chosen::told);
        let text = json(&Event::State(Box::new(self.state.clone())));
        self.outlet.states.send_if_modified(|last| {
            let is_new = *last != text;
            *last = text;
            is_new
        });
    }

    fn follow_traffic(&mut self) {
        let (passed, dropped) = self.master.line_mut().take_passed();
        self.tell_live(&passed, dropped);
        let in_words = self.outlet.frames.receiver_count() > 0;
        let frames: Vec<_> = (passed.iter())
            .filter_map(|passed| self.traffic.follow(passed, in_words))
            .collect();
        if in_words && !frames.is_empty() {
            // Whoever has listened may just have gone.
            let _ = (self.outlet.frames).send(json(&Event::Frames { frames, dropped }));
        }
        self.mind_boot();
    }
}
