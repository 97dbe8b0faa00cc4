//! The PDOs of a node: what the data sheet says, and what the description changes.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::{Spanned, Value};

use super::node::Node;
use super::objects::Mapped;
use super::{Network, file};
use crate::rules::network as rule;

/// The PDO is switched off (CiA 301, tables 68 and 71).
const INVALID: u32 = 1 << 31;
/// Flags of a COB-ID: switched off, no RTR, 29 bits.
const FLAGS: u32 = 7 << 29;
/// The first identifier that `auto` gives beyond the predefined connection set, and the end of them.
const AUTOMATIC: Range<u32> = 0x680..0x6E0;

/// A PDO.
#[derive(Clone, Debug)]
pub(super) struct Pdo<'a> {
    /// Counted from 1.
    pub(super) number: u16,
    pub(super) is_tpdo: bool,
    pub(super) cob_id: u32,
    pub(super) transmission: u8,
    /// 100 microseconds.
    pub(super) inhibit_time: u16,
    /// Milliseconds; of a receive PDO that of the master.
    pub(super) event_timer: u16,
    /// Milliseconds, of a receive PDO.
    pub(super) deadline: u16,
    pub(super) sync_start: u8,
    pub(super) mapping: Vec<Mapped>,
    /// What the description says.
    pub(super) own: Option<&'a file::Pdo>,
    /// Where it says so; the node where it says nothing.
    pub(super) place: Range<usize>,
    /// Who sends a receive PDO, where the description says so: a node and its transmit PDO, counted from 0.
    pub(super) from: Option<(usize, usize)>,
}

impl<'a> Pdo<'a> {
    /// The PDOs of a node in one direction.
    pub(super) fn of(
        node: &Node<'_>,
        described: &'a BTreeMap<Spanned<String>, Spanned<file::Pdo>>,
        is_tpdo: bool,
        network: &mut Network<'_>,
    ) -> Vec<Self> {
        let first = if is_tpdo { 0x1800 } else { 0x1400 };
        let objects = node.model.objects_in(first..=first + 0x1FF).iter();
        let mut pdos: Vec<Self> = objects
            .map(|object| Self::of_sheet(node, object.index - first + 1, is_tpdo))
            .collect();
        let kind = if is_tpdo { "TPDO" } else { "RPDO" };
        for (key, table) in described {
            let number = key.get_ref().parse().ok();
            let pdo = pdos.iter_mut().find(|pdo| Some(pdo.number) == number);
            let Some(pdo) = pdo else {
                let message = format!("the data sheet has no {kind} {}", key.get_ref());
                network.report(&rule::PDO, key.span(), message);
                continue;
            };
            // The table begins at its name.
            let place = key.span();
            pdo.describe(node, table.get_ref(), place, network);
        }
        pdos
    }

    fn of_sheet(node: &Node<'_>, number: u16, is_tpdo: bool) -> Self {
        let index = Self::index_of(number, is_tpdo);
        let small = |sub| node.number(index, sub).unwrap_or_default();
        let short = |sub| u16::try_from(small(sub)).unwrap_or_default();
        let byte = |sub| u8::try_from(small(sub)).unwrap_or_default();
        let count = node.number(index + 0x200, 0).unwrap_or_default().min(0x40);
        let mapped = (1..=count).filter_map(|sub| {
            let value = node.number(index + 0x200, u8::try_from(sub).ok()?)?;
            Mapped::of_value(&node.model, value).filter(|_| value != 0)
        });
        Self {
            number,
            is_tpdo,
            cob_id: node.number(index, 1).unwrap_or(INVALID),
            transmission: byte(2),
            inhibit_time: if is_tpdo { short(3) } else { 0 },
            event_timer: if is_tpdo { short(5) } else { 0 },
            deadline: if is_tpdo { 0 } else { short(5) },
            sync_start: if is_tpdo { byte(6) } else { 0 },
            mapping: mapped.collect(),
            own: None,
            place: node.own.name.span(),
            from: None,
        }
    }

    fn index_of(number: u16, is_tpdo: bool) -> u16 {
        (if is_tpdo { 0x1800 } else { 0x1400 }) + number - 1
    }

    /// The communication parameter; the mapping parameter is 200h above it.
    pub(super) fn index(&self) -> u16 {
        Self::index_of(self.number, self.is_tpdo)
    }

    /// `TPDO 1`.
    pub(super) fn name(&self) -> String {
        let kind = if self.is_tpdo { "TPDO" } else { "RPDO" };
        format!("{kind} {}", self.number)
    }

    /// Whether it takes part.
    pub(super) fn is_on(&self) -> bool {
        self.cob_id & INVALID == 0 && self.cob_id & !FLAGS != 0 && !self.mapping.is_empty()
    }

    /// The identifier, as it is told from others: with the flag of 29 bits.
    pub(super) fn identifier(&self) -> u32 {
        self.cob_id & 0x3FFF_FFFF
    }

    /// Bytes of its frame.
    pub(super) fn length(&self) -> u32 {
        let bits: u32 = self
            .mapping
            .iter()
            .map(|mapped| u32::from(mapped.bits))
            .sum();
        bits.div_ceil(8)
    }

    fn describe(
        &mut self,
        node: &Node<'_>,
        own: &'a file::Pdo,
        place: Range<usize>,
        network: &mut Network<'_>,
    ) {
        self.own = Some(own);
        self.place = place.clone();
        self.transmission = own.transmission.unwrap_or(self.transmission);
        self.inhibit_time = own.inhibit_time.unwrap_or(self.inhibit_time);
        self.event_timer = own.event_timer.unwrap_or(self.event_timer);
        self.deadline = own.deadline.unwrap_or(self.deadline);
        self.sync_start = own.sync_start.unwrap_or(self.sync_start);
        let wrong = match self.is_tpdo {
            true if own.from.is_some() => Some("`from` is for a receive PDO"),
            true if own.deadline.is_some() => Some("`deadline` is for a receive PDO"),
            false if own.sync_start.is_some() => Some("`sync_start` is for a transmit PDO"),
            _ => None,
        };
        if let Some(wrong) = wrong {
            network.report(&rule::PDO, place, wrong);
        }
        if let Some(names) = &own.map {
            self.mapping = self.map(node, names, network);
        }
    }

    fn map(
        &self,
        node: &Node<'_>,
        names: &[Spanned<String>],
        network: &mut Network<'_>,
    ) -> Vec<Mapped> {
        let mut mapping: Vec<Mapped> = Vec::new();
        for name in names {
            let text = name.get_ref();
            let mapped = match Mapped::find(&node.model, text) {
                Ok(mapped) => mapped,
                Err((message, help)) => {
                    network.report(&rule::MAPPING, name.span(), message).help = help;
                    continue;
                }
            };
            let entry = node.model.entry(mapped.index, mapped.sub);
            let is_mappable = match entry {
                _ if mapped.is_gap() => !self.is_tpdo,
                Some(entry) if self.is_tpdo => entry.is_tpdo_mappable(),
                Some(entry) => entry.is_rpdo_mappable(),
                None => false,
            };
            if !is_mappable {
                let kind = if self.is_tpdo { "transmit" } else { "receive" };
                let message = format!("{text} cannot be mapped into a {kind} PDO");
                network.report(&rule::MAPPING, name.span(), message);
            }
            mapping.push(mapped);
            let bits: u32 = mapping.iter().map(|mapped| u32::from(mapped.bits)).sum();
            if bits > 64 {
                let message = format!("with {text} the PDO has {bits} bits: 64 fit in a frame");
                network.report(&rule::MAPPING, name.span(), message);
                break;
            }
        }
        mapping
    }

    /// Puts it into the configuration: switched off, its parameters, its mapping, switched on.
    pub(super) fn configure(&self, node: &mut Node<'_>, network: &mut Network<'_>) {
        let Some(own) = self.own else { return };
        let index = self.index();
        let place = self.place.clone();
        if node.number(index, 1) != Some(self.cob_id | INVALID) {
            node.write((index, 1), self.cob_id | INVALID);
        }
        if self.cob_id & INVALID != 0 {
            let span = network.span(place);
            if node.number(index, 1) != Some(self.cob_id) {
                node.put((index, 1), &self.cob_id.to_string(), span, network);
            }
            return;
        }
        let mut parameters: Vec<(u8, Option<u16>)> = vec![(2, own.transmission.map(u16::from))];
        if self.is_tpdo {
            parameters.push((3, own.inhibit_time));
            parameters.push((5, own.event_timer));
            parameters.push((6, own.sync_start.map(u16::from)));
        } else {
            parameters.push((5, own.deadline));
        }
        for (sub, value) in parameters {
            let Some(value) = value else { continue };
            if node.number(index, sub).unwrap_or(0) != u32::from(value) {
                node.set((index, sub), &value.to_string(), place.clone(), network);
            }
        }
        if own.map.is_some() {
            let index = index + 0x200;
            let had = node.number(index, 0).unwrap_or_default();
            if self.mapping.is_empty() {
                if had > 0 {
                    node.set((index, 0), "0", place.clone(), network);
                }
            } else {
                node.write((index, 0), 0);
                for (sub, mapped) in (1..).zip(&self.mapping) {
                    let value = format!("0x{:08X}", mapped.value());
                    node.set((index, sub), &value, place.clone(), network);
                }
                let count = self.mapping.len().to_string();
                node.set((index, 0), &count, place.clone(), network);
            }
        }
        let cob_id = format!("0x{:X}", self.cob_id);
        node.set((index, 1), &cob_id, place, network);
    }
}

/// Gives each PDO of the description its identifier, but for those that hear another node.
pub(super) fn choose_identifiers(nodes: &mut [Node<'_>], network: &mut Network<'_>) {
    let mut automatic = AUTOMATIC;
    for node in nodes {
        let node_id = u32::from(node.node_id);
        for pdo in node.rpdos.iter_mut().chain(&mut node.tpdos) {
            let Some(own) = pdo.own else { continue };
            let base = if pdo.is_tpdo { 0x80 } else { 0x100 };
            let predefined = (1..=4).contains(&pdo.number);
            let predefined = predefined.then(|| u32::from(pdo.number) * 0x100 + base + node_id);
            let sheet = pdo.cob_id;
            let asked = own.cob_id.as_ref();
            let place = asked.map_or(pdo.place.clone(), Spanned::span);
            let chosen = match asked.map(Spanned::get_ref) {
                Some(Value::Integer(id)) => u32::try_from(*id).ok().filter(|id| *id != 0),
                Some(Value::String(word)) if word == "auto" => {
                    predefined.or_else(|| automatic.next())
                }
                Some(_) => None,
                None if sheet & !FLAGS != 0 => Some(sheet & !INVALID),
                None if own.from.is_some() => Some(sheet & !INVALID),
                None => predefined,
            };
            pdo.cob_id = match chosen {
                Some(id) if own.enabled => id,
                _ if !own.enabled => sheet | INVALID,
                Some(id) => id,
                None => {
                    let message = match asked {
                        Some(_) => "a COB-ID is a number above 0, or \"auto\"".to_owned(),
                        None => format!("{} has no COB-ID", pdo.name()),
                    };
                    let finding = network.report(&rule::PDO, place, message);
                    finding.help("`cob_id = \"auto\"` chooses one, or a number such as 0x201");
                    sheet | INVALID
                }
            };
        }
    }
}

/// Lets receive PDOs hear the transmit PDOs that they name.
pub(super) fn connect(nodes: &mut [Node<'_>], network: &mut Network<'_>) {
    let mut sent: Vec<(String, (usize, usize))> = Vec::new();
    for (at, node) in nodes.iter().enumerate() {
        for (number, pdo) in node.tpdos.iter().enumerate() {
            let names = [Some(format!("{}.tpdo{}", node.name, pdo.number)), {
                let name = pdo.own.and_then(|own| own.name.as_ref());
                name.map(|name| name.get_ref().clone())
            }];
            for name in names.into_iter().flatten() {
                if sent.iter().any(|(known, _)| *known == name) {
                    let message = format!("there is a PDO `{name}` already");
                    network.report(&rule::FROM, pdo.place.clone(), message);
                }
                sent.push((name, (at, number)));
            }
        }
    }
    for at in 0..nodes.len() {
        let count = nodes.get(at).map_or(0, |node| node.rpdos.len());
        for number in 0..count {
            let rpdo = nodes.get(at).and_then(|node| node.rpdos.get(number));
            let own = rpdo.and_then(|pdo| pdo.own).filter(|own| own.enabled);
            let Some(from) = own.and_then(|own| own.from.as_ref()) else {
                continue;
            };
            let name = from.get_ref();
            let found = sent.iter().find(|(known, _)| known == name);
            let Some((_, place)) = found else {
                let near = crate::spelling::nearest(name, sent.iter().map(|(known, _)| &**known));
                let help = near.map(|near| format!("did you mean `{near}`?"));
                let message = format!("no node has a TPDO `{name}`");
                network.report(&rule::FROM, from.span(), message).help = help;
                continue;
            };
            let producer = nodes.get(place.0).and_then(|node| node.tpdos.get(place.1));
            let Some(producer) = producer.cloned() else {
                continue;
            };
            if place.0 == at {
                network.report(&rule::FROM, from.span(), "a node does not hear itself");
                continue;
            }
            if !producer.is_on() {
                let message = format!("{name} is switched off");
                network.report(&rule::FROM, from.span(), message);
                continue;
            }
            let consumer = nodes
                .get_mut(at)
                .and_then(|node| node.rpdos.get_mut(number));
            let Some(consumer) = consumer else { continue };
            consumer.from = Some(*place);
            consumer.cob_id = producer.identifier();
            if consumer.length() > producer.length() {
                let (own, sent) = (consumer.length(), producer.length());
                let message = format!("this maps {own} bytes, and {name} has {sent}");
                network.report(&rule::PDO_LENGTH, from.span(), message);
            }
        }
    }
}
