//! The configuration of a node as a file: out, in, compared (DCF, CiA 306). Store and restore (1010h, 1011h).

use std::sync::Arc;

use master::Failure;
use master::Line;
use master::axis402::{self, Description, Group, Node, Problem};
use master::data_sheet::{Address, DataSheet};
use od_gen::model::{Commissioning, DefaultValue, FileKind};
use od_gen::{Model, Report, dcf, transfer};

use super::Session;
use super::objects::shown;
use crate::fsa::{DriveState, Transition};
use crate::message::{Answer, Difference};

impl<L: Line> Session<L> {
    pub(super) fn save(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let state = self.be_still(id)?;
        self.state.busy = Some(format!("node {id} saves its parameters"));
        self.without_guard(id, |session| {
            let (result, words) = session
                .with_words(|master, console| axis402::save(master, &node, Group::All, console));
            match (result, state) {
                (Ok(()), _) => Ok(Answer::Text(words.said)),
                (Err(Problem::Failed(why)), Some(state)) if state.has_power() => Err(
                    Problem::Failed(format!("{why}; its motor has power: disable it first")),
                ),
                (Err(problem), _) => Err(problem),
            }
        })
    }

    /// The generic drive stores in no state in which it could get power at once. Ready to switch on, as *Disable* leaves it, is one, and the motor
    /// has none there: it goes back to switch on disabled.
    fn be_still(&mut self, id: u8) -> Result<Option<DriveState>, Problem> {
        if (self.chosen.as_ref()).is_none_or(|chosen| chosen.node.id != id) {
            return Ok(None);
        }
        let state = self.drive_state()?;
        if state == DriveState::ReadyToSwitchOn {
            self.transition(Transition::DisableVoltage)?;
        }
        Ok(Some(state))
    }

    pub(super) fn restore(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        node.download(&mut self.master, Address::new(0x1011, 1), b"load")
            .map_err(|failure| Problem::with_node(id, failure))?;
        Ok(Answer::Text(format!(
            "node {id} has the factory's parameters after its next reset"
        )))
    }

    /// Everything that belongs to a configuration.
    pub(super) fn dump(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let (result, _) =
            self.with_words(|master, console| axis402::dump(master, &node, false, console));
        let mut model = result?;
        if let Some((address, before)) = self.guarded_entry(id) {
            let objects = model.objects.iter_mut();
            let entries = objects
                .filter(|object| object.index == address.index)
                .flat_map(|object| &mut object.entries);
            for entry in entries.filter(|entry| entry.sub == address.sub) {
                entry.configured = Some(DefaultValue::number(before.into()));
            }
        }
        let name = format!("node-{id}.dcf");
        let kbit = self.setup.bit_rate.unwrap_or_default() / 1_000;
        let commissioning = Commissioning {
            node_id: id,
            bit_rate: u16::try_from(kbit).unwrap_or_default(),
            ..Commissioning::default()
        };
        dcf::commission(&mut model, commissioning, &name);
        let text = od_gen::print(&model);
        Ok(Answer::File { name, text })
    }

    pub(super) fn load(&mut self, id: u8, name: &str, text: &str) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let model = configuration(name, text)?;
        self.live = None;
        self.without_guard(id, |session| {
            let (result, words) = session.load_model(&node, &model);
            match result {
                Ok(()) => Ok(Answer::Text(words.said)),
                // Which value, and why, says more than how many.
                Err(Problem::Failed(why)) if !words.remarks.is_empty() => Err(Problem::Failed(
                    format!("{why}: {}", words.remarks.join("; ")),
                )),
                Err(problem) => Err(problem),
            }
        })
    }

    /// A data sheet for a node: what a person has chosen is used, also where it names another device.
    pub(super) fn use_sheet(&mut self, id: u8, name: &str, text: &str) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let report = Report::new(name, text);
        if report.model.objects.is_empty() {
            let text = format!("{name} is no data sheet: no objects in it");
            return Err(Problem::Usage(text));
        }
        let mut said = format!("node {id} is read by {name}");
        if report.has_errors() {
            said += "; it has mistakes, the rest is used";
        }
        let sheet: Arc<DataSheet> = Arc::new(report.model.into());
        let identity = Description::ask(&mut self.master, id)?.identity;
        if let [Some(vendor), Some(product), ..] = identity
            && !sheet.is_of(vendor, product)
        {
            said += "; by its vendor-ID and product code it is of another device";
        }
        self.traffic.learn_sheet(id, Arc::clone(&sheet));
        self.sheets.insert(id, Arc::clone(&sheet));
        let node = Node { sheet, ..node };
        self.nodes.insert(id, node.clone());
        if let Some(chosen) = self.chosen.as_mut().filter(|chosen| chosen.node.id == id) {
            chosen.learn(node);
            self.live = None;
        }
        Ok(Answer::Text(said))
    }

    /// Nothing is written.
    pub(super) fn compare(&mut self, id: u8, name: &str, text: &str) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let model = configuration(name, text)?;
        let guarded = self.guarded_entry(id);
        let mut differences = Vec::new();
        for (object, entry) in model.entries() {
            let Some(wanted) = &entry.configured else {
                continue;
            };
            let address = Address::new(object.index, entry.sub);
            let wanted = transfer::bytes(wanted, entry.data_type, id);
            let shown = |bytes: &[u8]| shown(address, bytes, Some(entry.data_type));
            let here = match node.upload(&mut self.master, address) {
                Ok(bytes) if bytes == wanted => continue,
                // The panel's own is no part of the configuration: what it puts back counts.
                Ok(_) if guarded.is_some_and(|(entry, _)| entry == address) => {
                    let before = guarded.map_or(0, |(_, before)| before).to_le_bytes();
                    if before.as_slice() == wanted {
                        continue;
                    }
                    shown(&before)
                }
                Ok(bytes) => shown(&bytes),
                Err(failure @ Failure::Abort { .. }) => {
                    Problem::with_node(id, failure).line().unwrap_or_default()
                }
                Err(failure) => return Err(Problem::with_node(id, failure)),
            };
            differences.push(Difference {
                address: address.to_string(),
                name: node
                    .sheet
                    .name(address)
                    .unwrap_or_else(|| object.name.clone()),
                here,
                file: shown(&wanted),
            });
        }
        Ok(Answer::Differences(differences))
    }
}

/// What a DCF configures.
fn configuration(name: &str, text: &str) -> Result<Model, Problem> {
    let model = Report::new(name, text).model;
    if model.kind != FileKind::Dcf {
        return Err(Problem::Usage(format!(
            "{name} is no DCF: it configures nothing"
        )));
    }
    Ok(model)
}
