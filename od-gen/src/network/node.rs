//! A node: its configuration, and what the master writes into it for that.

use std::ops::Range;

use toml::{Spanned, Value};

use super::concise::{self, Write};
use super::file;
use super::objects::{self, number};
use super::pdo::Pdo;
use super::{Made, Network};
use crate::data_type::DataType;
use crate::dcf::{self, Assignment};
use crate::model::{Commissioning, Model};
use crate::rules::network as rule;
use crate::transfer;

/// How many heartbeats a consumer waits for one where the description does not say.
const HEARTBEATS: f64 = 3.0;

/// A node.
pub(super) struct Node<'a> {
    pub(super) own: &'a file::Node,
    pub(super) name: &'a str,
    pub(super) node_id: u8,
    pub(super) model: Model,
    pub(super) sheet: String,
    pub(super) rpdos: Vec<Pdo<'a>>,
    pub(super) tpdos: Vec<Pdo<'a>>,
    /// Milliseconds.
    pub(super) heartbeat: u16,
    /// What the master writes, in its order.
    writes: Vec<Write>,
}

impl<'a> Node<'a> {
    pub(super) fn new(
        own: &'a file::Node,
        sheet: &Model,
        commissioning: Commissioning,
        network: &mut Network<'_>,
    ) -> Self {
        let name = own.name.get_ref().as_str();
        let mut model = sheet.clone();
        dcf::commission(&mut model, commissioning, &format!("{name}.dcf"));
        let node_id = *own.node_id.get_ref();
        let heartbeat = number(&model, 0x1017, 0, node_id).unwrap_or_default();
        let mut node = Self {
            own,
            name,
            node_id,
            sheet: sheet.file.clone(),
            rpdos: Vec::new(),
            tpdos: Vec::new(),
            heartbeat: u16::try_from(heartbeat).unwrap_or_default(),
            model,
            writes: Vec::new(),
        };
        node.rpdos = Pdo::of(&node, &own.rpdo, false, network);
        node.tpdos = Pdo::of(&node, &own.tpdo, true, network);
        node
    }

    /// What a number is set to.
    pub(super) fn number(&self, index: u16, sub: u8) -> Option<u32> {
        number(&self.model, index, sub, self.node_id)
    }

    /// Configures a value; a description says so at this place.
    pub(super) fn set(
        &mut self,
        (index, sub): (u16, u8),
        text: &str,
        place: Range<usize>,
        network: &mut Network<'_>,
    ) {
        let span = network.span(place);
        if self.put((index, sub), text, span, network) {
            let entry = self.model.entry(index, sub);
            let value = entry.and_then(|entry| Some((entry.configured.as_ref()?, entry)));
            if let Some((value, entry)) = value {
                let bytes = transfer::bytes(value, entry.data_type, self.node_id);
                self.writes.push(Write { index, sub, bytes });
            }
        }
    }

    /// Configures a value that the master need not write: it is so then.
    pub(super) fn put(
        &mut self,
        (index, sub): (u16, u8),
        text: &str,
        span: crate::source::Span,
        network: &mut Network<'_>,
    ) -> bool {
        let assignment = Assignment {
            index,
            sub,
            place: span,
            text,
            span,
        };
        dcf::put(&mut self.model, &assignment, network.findings)
    }

    /// Writes a value that does not stay.
    pub(super) fn write(&mut self, (index, sub): (u16, u8), value: u32) {
        let entry = self.model.entry(index, sub);
        let size = entry.and_then(|entry| entry.data_type.size()).unwrap_or(1);
        let bytes = value.to_le_bytes().into_iter().take(size.into());
        let bytes = bytes.collect();
        self.writes.push(Write { index, sub, bytes });
    }

    /// Configures everything that the description asks for but for who guards whom.
    pub(super) fn configure(&mut self, network: &mut Network<'_>) {
        if let Some(heartbeat) = &self.own.heartbeat {
            let place = heartbeat.span();
            let heartbeat = *heartbeat.get_ref();
            self.set_if_other(0x1017, heartbeat.into(), place, network);
            self.heartbeat = heartbeat;
        }
        self.answer_questions(network);
        self.synchronize(network);
        for pdo in self.rpdos.clone().iter().chain(&self.tpdos.clone()) {
            pdo.configure(self, network);
        }
        let mut values: Vec<_> = self.own.values.iter().collect();
        values.sort_by_key(|(name, _)| name.span().start);
        for (name, value) in values {
            self.value(name, value, network);
        }
    }

    /// Node guarding (CiA 301): guard time and life time factor.
    fn answer_questions(&mut self, network: &mut Network<'_>) {
        let own = self.own;
        if self.guard_time() != 0
            && self.heartbeat != 0
            && let Some(time) = &own.guard_time
        {
            let message = format!(
                "`{}` is asked for its state, and sends heartbeats every {} ms",
                self.name, self.heartbeat
            );
            let finding = network.report(&rule::GUARD, time.span(), message);
            finding.help("a node does one of both: write heartbeat = 0");
        }
        if let Some(time) = &own.guard_time {
            self.set_if_other(0x100C, (*time.get_ref()).into(), time.span(), network);
        }
        if let Some(factor) = &own.life_time_factor {
            self.set_if_other(0x100D, (*factor.get_ref()).into(), factor.span(), network);
        }
    }

    /// How often the master asks for its state, in ms; 0 for never.
    pub(super) fn guard_time(&self) -> u16 {
        (self.own.guard_time.as_ref()).map_or(0, |time| *time.get_ref())
    }

    fn set_if_other(
        &mut self,
        index: u16,
        value: u32,
        place: Range<usize>,
        network: &mut Network<'_>,
    ) {
        if self.number(index, 0) != Some(value) {
            self.set((index, 0), &value.to_string(), place, network);
        }
    }

    /// SYNC of this node, as producer and as consumer.
    fn synchronize(&mut self, network: &mut Network<'_>) {
        let Some(sync) = &network.file.sync else {
            return;
        };
        let place = sync.span();
        let sync = sync.get_ref();
        let is_producer = (sync.producer.as_ref()).is_some_and(|name| name.get_ref() == self.name);
        let cob_id = sync.cob_id.as_ref().map_or(0x80, |id| *id.get_ref());
        let produces = if is_producer { 1 << 30 } else { 0 };
        let wanted = u32::from(cob_id) | produces;
        let own = self.number(0x1005, 0);
        if is_producer {
            let period = [
                (0x1006, sync.period),
                (0x1007, sync.window),
                (0x1019, sync.overflow.into()),
            ];
            for (index, value) in period {
                if self.number(index, 0).unwrap_or(0) != value {
                    self.set((index, 0), &value.to_string(), place.clone(), network);
                }
            }
        } else if sync.overflow != 0
            && let Some(overflow) = self.number(0x1019, 0)
            && overflow != u32::from(sync.overflow)
        {
            self.set(
                (0x1019, 0),
                &sync.overflow.to_string(),
                place.clone(),
                network,
            );
        }
        if is_producer || own.is_some_and(|own| own != wanted) {
            self.set((0x1005, 0), &wanted.to_string(), place, network);
        }
    }

    /// One of the values.
    fn value(&mut self, name: &Spanned<String>, value: &Spanned<Value>, network: &mut Network<'_>) {
        let Some(place) = objects::find(&self.model, name.get_ref()) else {
            let message = format!("the data sheet has no `{}`", name.get_ref());
            network.report(&rule::MAPPING, name.span(), message);
            return;
        };
        let entry = self.model.entry(place.0, place.1);
        if entry.is_some_and(|entry| entry.data_type == DataType::Domain) {
            let message = format!("{} is a DOMAIN: it has no value here", name.get_ref());
            network.report(&rule::MAPPING, value.span(), message);
            return;
        }
        let text = match value.get_ref() {
            Value::String(text) => text.clone(),
            Value::Integer(number) => number.to_string(),
            Value::Float(number) => format!("{number:?}"),
            Value::Boolean(is_set) => u8::from(*is_set).to_string(),
            other => {
                let message = format!("a value is a number or a text, not {}", other.type_str());
                network.report(&rule::MAPPING, value.span(), message);
                return;
            }
        };
        let place_of_name = if entry.is_none() {
            name.span()
        } else {
            value.span()
        };
        self.set(place, &text, place_of_name, network);
    }

    /// Its DCF, and its concise DCF where the master writes something.
    pub(super) fn files(&self) -> Vec<Made> {
        let made = |ending: &str, bytes| Made {
            name: format!("{}.{ending}", self.name),
            bytes,
            sheet: Some(self.sheet.clone()),
        };
        let mut files = vec![made("dcf", crate::print(&self.model).into_bytes())];
        if !self.writes.is_empty() {
            files.push(made("bin", concise::bytes(&self.writes)));
        }
        files
    }

    /// Whether the master writes something into it.
    pub(super) fn is_written(&self) -> bool {
        !self.writes.is_empty()
    }

    /// The element of 1016h for the heartbeats of a producer: the one that it has, or one that is free.
    fn consumer(&self, producer: u8, others: &[u8]) -> Option<u8> {
        let object = self.model.object(0x1016)?;
        let elements = object.entries.iter().filter(|entry| entry.sub != 0);
        let subs: Vec<u8> = elements.map(|entry| entry.sub).collect();
        let of = |sub: &u8| self.number(0x1016, *sub).unwrap_or_default();
        let node_id = |sub: &u8| (of(sub) >> 16) as u8;
        let is_free = |sub: &u8| of(sub) & 0xFFFF == 0 || !(1..=127).contains(&node_id(sub));
        let own = subs.iter().find(|sub| node_id(sub) == producer);
        let free = subs
            .iter()
            .find(|sub| is_free(sub) && !others.contains(sub));
        own.or(free).copied()
    }
}

/// Who guards whose heartbeats: the elements of 1016h. A master that no longer sends some is no longer guarded.
pub(super) fn guard(nodes: &mut [Node<'_>], network: &mut Network<'_>) {
    let file = network.file;
    let mut asked: Vec<(u8, u16, &Spanned<String>)> = Vec::new();
    let master = file.master.as_ref().map(Spanned::get_ref);
    if let Some(master) = master {
        let own = (*master.node_id.get_ref(), master.heartbeat);
        let guards = master.guarded_by.iter();
        asked.extend(guards.map(|guard| (own.0, own.1, guard)));
    }
    for node in nodes.iter() {
        let guards = node.own.guarded_by.iter().flatten();
        asked.extend(guards.map(|guard| (node.node_id, node.heartbeat, guard)));
    }
    let mut firsts: Vec<Vec<Write>> = nodes.iter().map(|_| Vec::new()).collect();
    let mut taken: Vec<Vec<u8>> = nodes.iter().map(|_| Vec::new()).collect();
    for (producer, heartbeat, guard) in asked {
        let name = guard.get_ref();
        if heartbeat == 0 {
            let message =
                format!("`{name}` waits for heartbeats of node {producer}, which has none");
            let finding = network.report(&rule::GUARD, guard.span(), message);
            finding.help("`heartbeat` is the producer's time in ms");
            continue;
        }
        let time = consumer_time(file, heartbeat);
        if time.is_none() {
            let message = "the consumer's time is above 65,535 ms";
            network.report(&rule::GUARD, guard.span(), message);
        }
        if name == "master" && master.is_some() {
            continue;
        }
        let Some(at) = nodes.iter().position(|node| node.name == name) else {
            let message = format!("there is no node `{name}`");
            network.report(&rule::GUARD, guard.span(), message);
            continue;
        };
        let (Some(node), Some(taken), Some(first)) =
            (nodes.get_mut(at), taken.get_mut(at), firsts.get_mut(at))
        else {
            continue;
        };
        if node.node_id == producer {
            let message = format!("`{name}` cannot guard itself");
            network.report(&rule::GUARD, guard.span(), message);
            continue;
        }
        let Some(sub) = node.consumer(producer, taken) else {
            let message = format!("`{name}` has no free element of 1016h");
            network.report(&rule::GUARD, guard.span(), message);
            continue;
        };
        taken.push(sub);
        let value = u32::from(producer) << 16 | u32::from(time.unwrap_or_default());
        let before = node.writes.len();
        node.set((0x1016, sub), &value.to_string(), guard.span(), network);
        first.extend(node.writes.drain(before..));
    }
    for (node, mut first) in nodes.iter_mut().zip(firsts) {
        if let Some(master) = master
            && !(master.guarded_by.iter()).any(|guard| guard.get_ref() == node.name)
        {
            node.forget(*master.node_id.get_ref(), &mut first, network);
        }
        first.append(&mut node.writes);
        node.writes = first;
    }
}

impl Node<'_> {
    /// Takes the heartbeats of a node out of 1016h that the data sheet waits for, and nobody asked for.
    fn forget(&mut self, producer: u8, first: &mut Vec<Write>, network: &mut Network<'_>) {
        let subs: Vec<u8> = match self.model.object(0x1016) {
            Some(object) => object.entries.iter().map(|entry| entry.sub).collect(),
            None => return,
        };
        for sub in subs.into_iter().filter(|sub| *sub != 0) {
            let value = self.number(0x1016, sub).unwrap_or_default();
            if value & 0xFFFF != 0 && value >> 16 & 0xFF == u32::from(producer) {
                let before = self.writes.len();
                let place = self.own.name.span();
                let value = u32::from(producer) << 16;
                self.set((0x1016, sub), &value.to_string(), place, network);
                first.splice(0..0, self.writes.drain(before..));
            }
        }
    }
}

/// How long a consumer waits for a heartbeat, in ms; `None` where 1016h has no room for it.
pub(super) fn consumer_time(file: &file::File, heartbeat: u16) -> Option<u16> {
    let factor = &file.network.heartbeat_multiplier;
    let factor = factor.as_ref().map_or(HEARTBEATS, |own| *own.get_ref());
    let time = f64::from(heartbeat) * factor;
    // At most 65,535 * 100.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the factor has been checked, and a fraction of a millisecond does not count"
    )]
    u16::try_from(time as u64).ok()
}
