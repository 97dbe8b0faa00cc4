//! A master, devices, and what a person would read.

use canopen::{BitRate, Duration};
use master::axis402::{Console, Node, Problem};
use master::bus::Station;
use master::bus::simulated::{Bus, Handle};
use master::{Master, Simulated};
use sim::Axis402;
use sim::drive::Setup;

/// The command's master; what its commands have written.
pub struct Bench {
    pub master: Master,
    pub output: String,
    pub progress: String,
    is_terminal: bool,
}

impl Bench {
    /// A master alone.
    pub fn new() -> Self {
        Self::on(Bus::new(BitRate::Kbit1000))
    }

    /// A master on a bus that others are on already.
    pub fn on(bus: Bus) -> Self {
        let mut master = Master::new(bus);
        master.set_answer_time(Duration::from_ticks(1_000_000));
        Self {
            master,
            output: String::new(),
            progress: String::new(),
            is_terminal: false,
        }
    }

    /// Progress goes to a terminal.
    pub fn on_terminal(mut self) -> Self {
        self.is_terminal = true;
        self
    }

    /// With generic drives of these node-IDs, which have booted; 255 has none. Serial numbers count from 1.
    pub fn with_drives(node_ids: &[u8]) -> (Self, Vec<Handle<Axis402>>) {
        let mut bench = Self::new();
        let drives = (1..).zip(node_ids).map(|(serial_number, node_id)| {
            let setup = Setup::with_node_id(serial_number, *node_id);
            bench.attach(Axis402::new(setup))
        });
        let drives = drives.collect();
        bench.master.run_for(Duration::from_ticks(10_000));
        (bench, drives)
    }

    /// Puts a device on the bus.
    pub fn attach<S: Station>(&mut self, station: S) -> Handle<S> {
        self.master.bus_mut().attach(station)
    }

    /// Runs a command; what it wrote is in `output` and `progress`.
    pub fn run<T>(
        &mut self,
        command: impl FnOnce(&mut Master<Simulated>, &mut Console<'_>) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let (mut output, mut progress) = (Vec::new(), Vec::new());
        let mut console = Console::new(&mut output, &mut progress, self.is_terminal);
        let result = command(&mut self.master, &mut console);
        drop(console);
        self.output = String::from_utf8(output).unwrap();
        self.progress = String::from_utf8(progress).unwrap();
        result
    }

    /// Runs a command that is to succeed; returns its output.
    pub fn told<T>(
        &mut self,
        command: impl FnOnce(&mut Master<Simulated>, &mut Console<'_>) -> Result<T, Problem>,
    ) -> String {
        if let Err(problem) = self.run(command) {
            panic!("{problem:?} after\n{}{}", self.output, self.progress);
        }
        self.output.clone()
    }

    /// A node that is asked who it is.
    pub fn meet(&mut self, id: u8) -> Node {
        Node::meet(&mut self.master, id, None).unwrap()
    }
}

/// The line of a command that was refused, and its exit code.
pub fn refusal<T: std::fmt::Debug>(result: Result<T, Problem>) -> (String, u8) {
    let problem = result.unwrap_err();
    (problem.line().unwrap_or_default(), problem.code())
}
