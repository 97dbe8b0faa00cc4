//! Networks: from a description of all nodes to the DCF of each, to what the master writes into them, and to the master's own DCF.
//!
//! A description is TOML, or YAML with the same keys: the nodes with their data sheets, node-IDs, PDOs, heartbeats and who guards whom.
//! od-gen/README.md lists the keys.
//! The concise DCF of a node (CiA 302-3, 1F22h) is, byte by byte, what lely's `dcfgen` makes for the same node; a test in tests/python holds
//! it to that.
//!
//! ```toml
//! [network]
//! bit_rate = 500                  # kbit/s
//!
//! [sync]
//! period = 2000                   # µs
//!
//! [master]
//! node_id = 1
//!
//! [[node]]
//! name = "axis"
//! sheet = "axis402.eds"
//! node_id = 4
//! heartbeat = 100                 # ms
//!
//! [node.tpdo.1]
//! transmission = 1
//! map = ["statusword", "position_actual_value"]
//! ```

mod concise;
mod file;
mod identifiers;
mod load;
mod master;
mod node;
mod objects;
mod pdo;
mod yaml;

use std::io;
use std::ops::Range;
use std::path::Path;

use crate::diagnostic::{Allowances, Colour, Diagnostic, Findings, Severity, render};
use crate::model::{Commissioning, Remarks};
use crate::report::Report;
use crate::rules::network as rule;
use crate::source::{Source, Span};
use file::File;
use node::Node;

/// Bit rates of CiA 301 in kbit/s.
const BIT_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// A file that a description makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Made {
    /// Its name: that of the node with `.dcf` or `.bin`.
    pub name: String,
    /// What it holds.
    pub bytes: Vec<u8>,
    /// The data sheet that it was made from; none of the master.
    pub sheet: Option<String>,
}

/// A description of a network with everything that there is to say about it.
#[derive(Clone, Debug)]
pub struct NetworkReport {
    /// The text that the findings point into.
    pub source: Source,
    /// What is wrong, in the order of the file.
    pub findings: Vec<Diagnostic>,
    /// What is silenced by comments, with the reasons given there.
    pub silenced: Vec<(Diagnostic, String)>,
    /// The data sheets, each with what is wrong with it alone.
    pub sheets: Vec<Report>,
    /// DCF and concise DCF of each node, and the DCF of the master. Empty where there are errors.
    pub files: Vec<Made>,
    /// Who sends what, and what that takes of the bus: a table for people. Empty where there are errors.
    pub load: String,
}

impl NetworkReport {
    /// Reads a description, and the data sheets that it names.
    ///
    /// # Errors
    /// The description cannot be read from its disk. A data sheet that cannot is a finding.
    pub fn read(path: &Path) -> io::Result<Self> {
        let file = path.display().to_string();
        let bytes = crate::files::read(path)?;
        let mut findings = Findings::new(&file).for_code();
        let source = Source::decode(&file, &bytes, &mut findings).unwrap_or_default();
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(Self::of(source, findings, |sheet| {
            Report::read(&folder.join(sheet))
        }))
    }

    /// Checks a text that is at hand. `file` is its name, for the findings; `sheet` gives the data sheet of a name.
    pub fn new(file: &str, text: &str, sheet: impl FnMut(&str) -> io::Result<Report>) -> Self {
        let mut findings = Findings::new(file).for_code();
        let source = Source::new(file, text, &mut findings);
        Self::of(source, findings, sheet)
    }

    fn of(
        source: Source,
        mut findings: Findings,
        sheet: impl FnMut(&str) -> io::Result<Report>,
    ) -> Self {
        let comments = crate::bind::comments(&source);
        findings.allow(Allowances::beside(
            &Remarks::default(),
            &comments,
            &mut findings.same_file(),
        ));
        let mut report = Self {
            source,
            findings: Vec::new(),
            silenced: Vec::new(),
            sheets: Vec::new(),
            files: Vec::new(),
            load: String::new(),
        };
        match File::read(&report.source) {
            Ok(file) => report.make(&file, sheet, &mut findings),
            Err((place, message)) => {
                let place = place.map_or(Span::START, |range| report.source.span(range));
                findings.report(&rule::SYNTAX, place, message);
            }
        }
        report.silenced = findings.silence();
        report.findings = findings.into_sorted();
        report
    }

    /// Makes the files, if nothing is in the way.
    fn make(
        &mut self,
        file: &File,
        sheet: impl FnMut(&str) -> io::Result<Report>,
        findings: &mut Findings,
    ) {
        let mut network = Network {
            source: &self.source,
            file,
            findings,
        };
        network.check();
        let (mut nodes, sheets) = network.nodes(sheet);
        self.sheets = sheets;
        // Without the right nodes all that is between them would be wrong too.
        if network.findings.has_errors_of(&[&rule::NODE, &rule::SHEET]) {
            return;
        }
        pdo::choose_identifiers(&mut nodes, &mut network);
        pdo::connect(&mut nodes, &mut network);
        for node in &mut nodes {
            node.configure(&mut network);
        }
        node::guard(&mut nodes, &mut network);
        identifiers::check(&nodes, &mut network);
        let load = load::table(&nodes, &mut network);
        if network.findings.has_errors_after(0) {
            return;
        }
        for node in &nodes {
            self.files.extend(node.files());
        }
        self.files.extend(master::file(file, &nodes));
        self.load = load;
    }

    /// Whether something is wrong that leaves the description unusable.
    pub fn has_errors(&self) -> bool {
        let mut findings = self.findings.iter();
        findings.any(|finding| finding.severity == Severity::Error)
    }

    /// The findings with their lines, one after the other.
    pub fn render(&self, colour: Colour) -> String {
        let findings = self.findings.iter();
        let rendered = findings.map(|finding| render(finding, &self.source, colour) + "\n");
        rendered.collect::<Vec<_>>().join("\n")
    }
}

/// A description while it is worked through.
struct Network<'a> {
    source: &'a Source,
    file: &'a File,
    findings: &'a mut Findings,
}

impl<'a> Network<'a> {
    fn span(&self, range: Range<usize>) -> Span {
        self.source.span(range)
    }

    fn report(
        &mut self,
        rule: &'static crate::rules::Rule,
        range: Range<usize>,
        message: impl Into<String>,
    ) -> &mut Diagnostic {
        let span = self.source.span(range);
        self.findings.report(rule, span, message)
    }

    /// What is wrong with the names and numbers themselves.
    fn check(&mut self) {
        let file = self.file;
        let rate = &file.network.bit_rate;
        if !BIT_RATES.contains(rate.get_ref()) {
            let message = format!("{} kbit/s is no bit rate of CANopen", rate.get_ref());
            let finding = self.report(&rule::NODE, rate.span(), message);
            finding.help("10, 20, 50, 125, 250, 500, 800 or 1000");
        }
        if let Some(factor) = &file.network.heartbeat_multiplier
            && !(1.0..=100.0).contains(factor.get_ref())
        {
            let message = "heartbeat_multiplier is between 1 and 100";
            self.report(&rule::GUARD, factor.span(), message);
        }
        let mut names: Vec<&str> = vec!["master"];
        let mut node_ids: Vec<(u8, &str)> = Vec::new();
        let master = file.master.as_ref();
        let master = master.map(|master| ("master", &master.get_ref().node_id));
        let nodes = file.node.iter().map(|node| node.get_ref());
        for node in nodes.clone() {
            let name = node.name.get_ref().as_str();
            let is_right = |letter: char| letter.is_ascii_alphanumeric() || "_-".contains(letter);
            if name.is_empty() || !name.chars().all(is_right) {
                let message = format!("`{name}` is no name of a node");
                let finding = self.report(&rule::NODE, node.name.span(), message);
                finding.help("files are called by it: letters, digits, `_` and `-`");
            } else if names.iter().any(|known| known.eq_ignore_ascii_case(name)) {
                let message = format!("there is a node `{name}` already");
                self.report(&rule::NODE, node.name.span(), message);
            }
            names.push(name);
        }
        let all = nodes.map(|node| (node.name.get_ref().as_str(), &node.node_id));
        for (name, place) in master.into_iter().chain(all) {
            let node_id = *place.get_ref();
            if !(1..=127).contains(&node_id) {
                let message = format!("{node_id} is no node-ID: they are 1 to 127");
                self.report(&rule::NODE, place.span(), message);
            } else if let Some((_, other)) = node_ids.iter().find(|(own, _)| *own == node_id) {
                let message = format!("node-ID {node_id} is that of `{other}` already");
                self.report(&rule::NODE, place.span(), message);
            }
            node_ids.push((node_id, name));
        }
    }

    /// The nodes with their data sheets, and all data sheets.
    fn nodes(
        &mut self,
        mut read: impl FnMut(&str) -> io::Result<Report>,
    ) -> (Vec<Node<'a>>, Vec<Report>) {
        let (mut nodes, mut sheets): (Vec<Node<'a>>, Vec<Report>) = Default::default();
        let mut names: Vec<(&str, usize)> = Vec::new();
        for node in &self.file.node {
            let own = node.get_ref();
            let name = own.sheet.get_ref().as_str();
            let known = names.iter().find(|(known, _)| *known == name);
            let at = match known {
                Some((_, at)) => *at,
                None => match read(name) {
                    Ok(report) => {
                        sheets.push(report);
                        names.push((name, sheets.len() - 1));
                        sheets.len() - 1
                    }
                    Err(error) => {
                        let error = error.to_string();
                        let reason = error.split(" (os error").next().unwrap_or_default();
                        let message = format!("{name}: {reason}");
                        self.report(&rule::SHEET, own.sheet.span(), message);
                        continue;
                    }
                },
            };
            let Some(sheet) = sheets.get(at) else {
                continue;
            };
            if sheet.model.objects.is_empty() {
                let message = format!("{name} has no objects: `od-gen check` tells why");
                self.report(&rule::SHEET, own.sheet.span(), message);
                continue;
            }
            let commissioning = Commissioning {
                node_id: *own.node_id.get_ref(),
                node_name: own.name.get_ref().clone(),
                bit_rate: *self.file.network.bit_rate.get_ref(),
                net_number: self.file.network.number,
                network_name: self.file.network.name.clone(),
                is_manager: false,
                serial_number: own.serial_number,
            };
            nodes.push(Node::new(own, &sheet.model, commissioning, self));
        }
        (nodes, sheets)
    }
}

#[cfg(test)]
mod tests;
