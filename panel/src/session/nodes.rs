//! Nodes of the bus: who is there, numbers for those that have none, NMT, store.

use std::io::{self, Write};
use std::sync::Arc;

use canopen::Duration;
use master::axis402::{self, Console, Description, Group, Node, Numbering, Problem};
use master::{Line, NmtCommand};

use super::{Outlet, Session, json};
use crate::message::{Answer, Event, State};

/// How long each step of a fastscan waits.
const SCAN_STEP: Duration = Duration::from_ticks(20_000);

impl<L: Line> Session<L> {
    /// Who is there? Only those that are asked; nobody is asked by LSS when nothing may be written.
    pub(super) fn scan(&mut self) -> Result<Answer, Problem> {
        self.nodes.clear();
        let found = self.with_console(axis402::present)?;
        self.follow_traffic();
        self.traffic.forget_nodes();
        let now = self.master.now();
        for (id, found) in &found {
            let known = self.traffic.node_mut(*id);
            known.state = found.state;
            known.last = Some(now);
            if found.answers {
                let description = Description::ask(&mut self.master, *id)?;
                describe(&mut self.traffic.node_mut(*id).told, &description);
            }
        }
        if !self.setup.read_only {
            let anyone = self.master.lss_is_anyone_unconfigured()?;
            self.state.bus.unnumbered = Some(anyone);
        }
        Ok(Answer::Text(match found.len() {
            0 => "no node answers".to_owned(),
            1 => "1 node".to_owned(),
            count => format!("{count} nodes"),
        }))
    }

    /// Numbers all devices that have no node-ID; then looks who is there.
    pub(super) fn number(&mut self, first: u8, store: bool) -> Result<Answer, Problem> {
        if !(1..=127).contains(&first) {
            return Err(Problem::Usage("a node-ID is 1 to 127".to_owned()));
        }
        let usual = self.master.set_scan_time(SCAN_STEP);
        let mut output = Vec::new();
        let numbering = Numbering { first, store };
        let result = self.with_output(&mut output, |master, console| {
            axis402::number(master, numbering, console)
        });
        self.master.set_scan_time(usual);
        result?;
        self.scan()?;
        let told = String::from_utf8_lossy(&output);
        Ok(Answer::Text(
            told.lines().last().unwrap_or_default().to_owned(),
        ))
    }

    pub(super) fn nmt(&mut self, command: NmtCommand, node: u8) -> Result<Answer, Problem> {
        if node > 127 {
            return Err(Problem::Usage(
                "a node-ID is 1 to 127, or 0 for all".to_owned(),
            ));
        }
        self.master.nmt(command, node);
        Ok(Answer::Text("sent".to_owned()))
    }

    pub(super) fn save(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let mut output = Vec::new();
        self.state.busy = Some(format!("node {id} saves its parameters"));
        self.with_output(&mut output, |master, console| {
            axis402::save(master, &node, Group::All, console)
        })?;
        Ok(Answer::Text(
            String::from_utf8_lossy(&output).trim_end().to_owned(),
        ))
    }

    /// A node with its data sheet: one that a person has given for its vendor and product, or what the master knows of it.
    pub(super) fn node(&mut self, id: u8) -> Result<Node, Problem> {
        if !(1..=127).contains(&id) {
            return Err(Problem::Usage("a node-ID is 1 to 127".to_owned()));
        }
        if let Some(node) = self.nodes.get(&id) {
            return Ok(node.clone());
        }
        let mut node = Node::meet(&mut self.master, id, None)?;
        if !self.setup.sheets.is_empty() {
            let Description { identity, .. } = Description::ask(&mut self.master, id)?;
            if let [Some(vendor), Some(product), ..] = identity {
                let mut sheets = self.setup.sheets.iter();
                if let Some(sheet) = sheets.find(|sheet| sheet.is_of(vendor, product)) {
                    node.sheet = Arc::clone(sheet);
                }
            }
        }
        self.traffic.learn_sheet(id, Arc::clone(&node.sheet));
        self.nodes.insert(id, node.clone());
        Ok(node)
    }

    /// Runs a command of the command line; windows see how far it is.
    pub(super) fn with_console<T>(
        &mut self,
        command: impl FnOnce(
            &mut super::Master<super::PanelLine<L>>,
            &mut Console<'_>,
        ) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        self.with_output(&mut Vec::new(), command)
    }

    /// The same; what it tells is in `output`.
    pub(super) fn with_output<T>(
        &mut self,
        output: &mut Vec<u8>,
        command: impl FnOnce(
            &mut super::Master<super::PanelLine<L>>,
            &mut Console<'_>,
        ) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let mut progress = Progress {
            state: &mut self.state,
            outlet: &self.outlet,
        };
        let mut console = Console::new(output, &mut progress, true);
        let result = command(&mut self.master, &mut console);
        drop(console);
        self.state.busy = None;
        result
    }
}

/// What a scan has told of a node.
pub(super) fn describe(told: &mut crate::message::NodeState, description: &Description) {
    told.name.clone_from(&description.name);
    told.is_drive = description
        .device_type
        .is_some_and(|kind| kind & 0xFFFF == 402);
    told.device = description.device_type.map(|kind| match kind & 0xFFFF {
        401 => "I/O device (CiA 401)".to_owned(),
        402 => "Drive (CiA 402)".to_owned(),
        405 => "PLC (CiA 405)".to_owned(),
        406 => "Encoder (CiA 406)".to_owned(),
        0 => "No device profile".to_owned(),
        profile => format!("CiA {profile}"),
    });
    let words = description.identity.iter().flatten();
    let words: Vec<String> = words.map(|word| format!("{word:08X}")).collect();
    told.identity = (!words.is_empty()).then(|| words.join(":"));
}

/// The line of progress that a terminal would show goes to the windows.
struct Progress<'a> {
    state: &'a mut State,
    outlet: &'a Outlet,
}

impl Write for Progress<'_> {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        let words = String::from_utf8_lossy(text);
        let words = words
            .trim_start_matches(['\r', '\u{1B}'])
            .trim_start_matches("[K")
            .trim();
        if !words.is_empty() {
            self.state.busy = Some(words.to_owned());
            let picture = json(&Event::State(Box::new(self.state.clone())));
            self.outlet.states.send_replace(picture);
        }
        Ok(text.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
