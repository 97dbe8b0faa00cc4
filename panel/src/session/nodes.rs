//! Nodes of the bus: who is there, numbers for those that have none, NMT, store.

use std::io::{self, Write};
use std::sync::Arc;

use canopen::{BitRate, Duration, NodeId};
use master::axis402::{
    self, BitRateSwitch, Console, Description, Node, Numbering, Problem, Setting,
};
use master::data_sheet::{Address, DataSheet};
use master::{Failure, Identity, Line, NmtCommand};

use super::pdos::Words;
use super::{Outlet, Session, json};
use crate::message::{Answer, Event, State};

/// How long each step of a fastscan waits; longer where a device is left over.
const SCAN_STEPS: [Duration; 3] = [
    Duration::from_ticks(20_000),
    Duration::from_ticks(100_000),
    Duration::from_ticks(400_000),
];

/// From a node that is asked who it is to the next, how long it may take to answer, and how often one is asked.
const STRANGERS: Duration = Duration::from_ticks(500_000);
const STRANGER_TIME: Duration = Duration::from_ticks(250_000);
const ASKED: u8 = 3;

/// The silence before and after a switch of the bit rate.
const SWITCH_DELAY: Duration = Duration::from_ticks(500_000);

/// How long a device may take to boot.
const BOOT_TIME: Duration = Duration::from_ticks(500_000);

/// Remarks of a command that are told.
const REMARKS: usize = 8;

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

    /// A node that was heard but not found, one that has come later or was slow to answer, is asked who it is.
    pub(super) fn meet_stranger(&mut self) {
        let now = self.master.now();
        if now < self.next_stranger {
            return;
        }
        self.next_stranger = now + STRANGERS;
        let Some(id) = self.traffic.stranger(self.setup.own_node, ASKED) else {
            return;
        };
        let usual = self
            .master
            .set_answer_time(STRANGER_TIME.min(self.master.answer_time()));
        // One that is silent is not asked for all the rest.
        let answers = self.master.read::<Vec<u8>>(id, 0x1000, 0);
        let description = match answers {
            Ok(_) | Err(Failure::Abort { .. }) => Description::ask(&mut self.master, id),
            Err(failure) => Err(failure.into()),
        };
        self.master.set_answer_time(usual);
        let known = self.traffic.node_mut(id);
        known.asked += 1;
        if let Ok(description) = description {
            describe(&mut known.told, &description);
        }
    }

    /// Numbers all devices that have no node-ID; then looks who is there.
    pub(super) fn number(&mut self, first: u8, store: bool) -> Result<Answer, Problem> {
        if !(1..=127).contains(&first) {
            return Err(Problem::Usage("a node-ID is 1 to 127".to_owned()));
        }
        let numbering = Numbering { first, store };
        let mut output = Vec::new();
        for step in SCAN_STEPS {
            output.clear();
            let usual = self.master.set_scan_time(step);
            let result = self.with_output(&mut output, |master, console| {
                axis402::number(master, numbering, console)
            });
            self.master.set_scan_time(usual);
            // Somebody wants to stop the drive: what was broken off is not begun again.
            let is_last = Some(&step) == SCAN_STEPS.last() || self.master.line_mut().urgent().any();
            if result.is_err() && !is_last {
                continue;
            }
            result?;
            self.scan()?;
            // One that is slow to answer is missed by a quick scan, and not by a patient question.
            if is_last || self.state.bus.unnumbered != Some(true) {
                break;
            }
        }
        let told = String::from_utf8_lossy(&output);
        Ok(Answer::Text(
            told.lines().last().unwrap_or_default().to_owned(),
        ))
    }

    /// Another node-ID for a device that has one: LSS finds it by its identity, and its communication is reset.
    pub(super) fn renumber(&mut self, id: u8, to: u8, store: bool) -> Result<Answer, Problem> {
        // 255 would take its node-ID away.
        let node_id = NodeId::new(to).filter(|_| to <= 127);
        let node_id = node_id.ok_or_else(|| Problem::Usage("a node-ID is 1 to 127".to_owned()))?;
        if to == self.setup.own_node || self.traffic.node(to).is_some() {
            return Err(Problem::Usage(format!("node-ID {to} is taken")));
        }
        let identity = Description::ask(&mut self.master, id)?.identity;
        let [Some(vendor), Some(product), Some(revision), Some(serial)] = identity else {
            let text = format!("node {id} does not tell its whole identity (1018h)");
            return Err(Problem::Failed(text));
        };
        if self
            .chosen
            .as_ref()
            .is_some_and(|chosen| chosen.node.id == id)
        {
            self.leave_drive();
            (self.chosen, self.live) = (None, None);
        }
        let setting = Setting {
            device: Some(Identity::from([vendor, product, revision, serial])),
            node_id: Some(node_id),
            bit_rate: None,
            store,
        };
        self.with_console(|master, console| axis402::set(master, setting, console))?;
        self.master.nmt(NmtCommand::ResetCommunication, id);
        self.master.wait(BOOT_TIME)?;
        if let Some(sheet) = self.sheets.remove(&id) {
            self.sheets.insert(to, sheet);
        }
        self.scan()?;
        match self.traffic.node(to) {
            Some(_) => Ok(Answer::Text(format!("node {id} is node {to} now"))),
            None => Err(Problem::Failed(format!("node {to} was not heard"))),
        }
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

    /// Those without a node-ID; they are left as they are.
    pub(super) fn find(&mut self) -> Result<Answer, Problem> {
        let usual = self.master.set_scan_time(SCAN_STEPS[1]);
        let mut output = Vec::new();
        let result = self.with_output(&mut output, axis402::find);
        self.master.set_scan_time(usual);
        result?;
        Ok(Answer::Text(
            String::from_utf8_lossy(&output).trim_end().to_owned(),
        ))
    }

    /// The whole bus goes to another bit rate. Nobody stores it before all are there again; until then power-off brings the old one back.
    pub(super) fn switch_bit_rate(&mut self, kbit: u32, store: bool) -> Result<Answer, Problem> {
        let named = |kbit| {
            let mut all = BitRate::ALL.into_iter();
            all.find(|rate: &BitRate| rate.kbit_per_second() == kbit)
        };
        let to = named(kbit)
            .ok_or_else(|| Problem::Usage(format!("CiA 305 has no bit rate of {kbit} kbit/s")))?;
        // Guarded or not, a drive with power is not left alone on a bus that changes.
        self.leave_drive();
        let switch = BitRateSwitch {
            to,
            from: self.setup.bit_rate.and_then(|rate| named(rate / 1_000)),
            store,
            delay: SWITCH_DELAY,
        };
        let (result, words) =
            self.with_words(|master, console| axis402::switch_bit_rate(master, switch, console));
        if result.is_ok() {
            self.setup.bit_rate = Some(kbit * 1_000);
        }
        result.map(|()| Answer::Text(words.said))
    }

    pub(super) fn store_lss(&mut self) -> Result<Answer, Problem> {
        let (result, words) = self.with_words(axis402::store_settings);
        result.map(|()| Answer::Text(words.said))
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
        if let Some(sheet) = self.sheets.get(&id) {
            node.sheet = Arc::clone(sheet);
        } else if !self.setup.sheets.is_empty() {
            let Description { identity, .. } = Description::ask(&mut self.master, id)?;
            if let [Some(vendor), Some(product), ..] = identity {
                let mut sheets = self.setup.sheets.iter();
                if let Some(sheet) = sheets.find(|sheet| sheet.is_of(vendor, product)) {
                    node.sheet = Arc::clone(sheet);
                }
            }
        }
        if Arc::ptr_eq(&node.sheet, &DataSheet::standard())
            && let Some(sheet) = self.stored_sheet(&node)?
        {
            node.sheet = sheet;
        }
        self.traffic.learn_sheet(id, Arc::clone(&node.sheet));
        self.nodes.insert(id, node.clone());
        Ok(node)
    }

    /// The data sheet that a device holds itself (1021h, CiA 301), where it is stored as plain text (1022h).
    fn stored_sheet(&mut self, node: &Node) -> Result<Option<Arc<DataSheet>>, Problem> {
        if self
            .optional(node, 0x1022)?
            .is_some_and(|format| format != 0)
        {
            return Ok(None);
        }
        self.state.busy = Some(format!("node {} is asked for its data sheet", node.id));
        let stored = node.upload(&mut self.master, Address::new(0x1021, 0));
        let text = match stored {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(Failure::Abort { .. }) => return Ok(None),
            Err(failure) => return Err(Problem::with_node(node.id, failure)),
        };
        let name = format!("1021h of node {}", node.id);
        let sheet = DataSheet::parse(&name, &text);
        Ok((!sheet.model().objects.is_empty()).then(|| Arc::new(sheet)))
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

    /// The same; its last line and its remarks are told.
    pub(super) fn with_words<T>(
        &mut self,
        command: impl FnOnce(
            &mut super::Master<super::PanelLine<L>>,
            &mut Console<'_>,
        ) -> Result<T, Problem>,
    ) -> (Result<T, Problem>, Words) {
        let mut output = Vec::new();
        let (result, remarks) = self.run_command(&mut output, command);
        let said = String::from_utf8_lossy(&output);
        let said = said.lines().last().unwrap_or_default().to_owned();
        (result, Words { said, remarks })
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
        self.run_command(output, command).0
    }

    fn run_command<T>(
        &mut self,
        output: &mut Vec<u8>,
        command: impl FnOnce(
            &mut super::Master<super::PanelLine<L>>,
            &mut Console<'_>,
        ) -> Result<T, Problem>,
    ) -> (Result<T, Problem>, Vec<String>) {
        let mut progress = Progress {
            state: &mut self.state,
            outlet: &self.outlet,
            pending: String::new(),
            remarks: Vec::new(),
        };
        let mut console = Console::new(output, &mut progress, true);
        let result = command(&mut self.master, &mut console);
        drop(console);
        let remarks = progress.remarks;
        self.state.busy = None;
        (result, remarks)
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
    /// What is written at, and the remarks so far.
    pending: String,
    remarks: Vec<String>,
}

impl Write for Progress<'_> {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        let text_now = String::from_utf8_lossy(text);
        // A line of progress begins where the one before did; a remark has an end.
        if text_now.starts_with('\r') {
            self.pending.clear();
        }
        let words = text_now.trim_start_matches(['\r', '\u{1B}']);
        self.pending += words.trim_start_matches("[K");
        if self.pending.ends_with('\n') {
            let remark = std::mem::take(&mut self.pending).trim().to_owned();
            if !remark.is_empty() && self.remarks.len() < REMARKS {
                self.remarks.push(remark);
            }
        } else if !self.pending.is_empty() {
            self.state.busy = Some(self.pending.trim().to_owned());
            let picture = json(&Event::State(Box::new(self.state.clone())));
            self.outlet.states.send_replace(picture);
        }
        Ok(text.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
