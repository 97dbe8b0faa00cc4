//! Who sends what with which identifier.

use std::collections::HashMap;
use std::ops::Range;

use super::Network;
use super::node::Node;
use crate::rules::network as rule;

const INVALID: u32 = 1 << 31;

/// Reports what two nodes send with one identifier, and what nobody sends.
pub(super) fn check(nodes: &[Node<'_>], network: &mut Network<'_>) {
    let mut senders = Senders::default();
    let file = network.file;
    let sync = file.sync.as_ref().map(|sync| sync.get_ref());
    let sync_id = sync.and_then(|sync| sync.cob_id.as_ref());
    let sync_id = sync_id.map_or(0x80, |id| u32::from(*id.get_ref()));
    let producer = sync.and_then(|sync| sync.producer.as_ref());
    let producer = producer.map(|name| (name.get_ref().as_str(), name.span()));
    if let Some((name, place)) = &producer
        && *name != "master"
        && !nodes.iter().any(|node| node.name == *name)
    {
        let message = format!("there is no node `{name}`");
        network.report(&rule::NODE, place.clone(), message);
    }
    for (id, what) in [(0, "NMT"), (0x7E4, "LSS"), (0x7E5, "LSS")] {
        senders.add(id, "CANopen", what.into(), None, network);
    }
    if let Some(master) = &file.master {
        let place = Some(master.span());
        let node_id = u32::from(*master.get_ref().node_id.get_ref());
        if sync.is_some() && producer.as_ref().is_none_or(|(name, _)| *name == "master") {
            senders.add(sync_id, "master", "SYNC".into(), place.clone(), network);
        }
        senders.add(
            0x80 + node_id,
            "master",
            "EMCY".into(),
            place.clone(),
            network,
        );
        senders.add(
            0x700 + node_id,
            "master",
            "heartbeats".into(),
            place,
            network,
        );
    } else if let (Some(sync), None) = (&file.sync, &producer) {
        let message = "nobody sends SYNC: there is no [master]";
        let finding = network.report(&rule::NODE, sync.span(), message);
        finding.help("`producer` names the node that does");
    }
    for node in nodes {
        let node_id = u32::from(node.node_id);
        let place = Some(node.own.name.span());
        let mut add = |id: u32, what: &str| {
            senders.add(id, node.name, what.into(), place.clone(), network);
        };
        add(0x580 + node_id, "SDO answers");
        add(0x600 + node_id, "SDO requests");
        add(0x700 + node_id, "heartbeats");
        let on = |value: &u32| value & INVALID == 0;
        if let Some(id) = node.number(0x1014, 0).filter(on) {
            add(id & 0x3FFF_FFFF, "EMCY");
        }
        for (index, what) in [(0x1005, "SYNC"), (0x1012, "TIME")] {
            let sends = node.number(index, 0).filter(|value| value & 1 << 30 != 0);
            if let Some(id) = sends {
                add(id & 0x2FFF_FFFF, what);
            }
        }
        for server in node.model.objects_in(0x1201..=0x127F) {
            if let Some(id) = node.number(server.index, 2).filter(on) {
                add(id & 0x3FFF_FFFF, "SDO answers");
            }
        }
        for client in node.model.objects_in(0x1280..=0x12FF) {
            if let Some(id) = node.number(client.index, 1).filter(on)
                && !(0x601..=0x67F).contains(&id)
                && id != 0
            {
                add(id & 0x3FFF_FFFF, "SDO requests");
            }
        }
        for pdo in node.tpdos.iter().filter(|pdo| pdo.is_on()) {
            let place = Some(pdo.place.clone());
            senders.add(pdo.identifier(), node.name, pdo.name(), place, network);
        }
    }
    receivers(nodes, senders, network);
}

/// The receive PDOs: those without `from` are the master's to send, and all have a sender.
fn receivers(nodes: &[Node<'_>], mut senders: Senders, network: &mut Network<'_>) {
    let has_master = network.file.master.is_some();
    let mut of_master: HashMap<u32, ()> = HashMap::new();
    for node in nodes {
        for pdo in node.rpdos.iter().filter(|pdo| pdo.is_on()) {
            let id = pdo.identifier();
            let is_sent = pdo.from.is_some() || is_tpdo(nodes, id);
            if is_sent || of_master.contains_key(&id) {
                continue;
            }
            let place = Some(pdo.place.clone());
            if has_master && pdo.own.is_some() {
                of_master.insert(id, ());
                let what = format!("{} of {}", pdo.name(), node.name);
                senders.add(id, "master", what, place, network);
            } else {
                let name = pdo.name();
                let message = format!("nobody sends {id:03X}h, {name} of `{}`", node.name);
                let finding = network.report(&rule::WITHOUT_PRODUCER, pdo.place.clone(), message);
                let number = pdo.number;
                finding.help(match has_master {
                    true => {
                        format!("[node.rpdo.{number}] has the master send it, or switches it off")
                    }
                    false => format!("`from` in [node.rpdo.{number}] names a TPDO"),
                });
            }
        }
    }
}

/// Whether a node sends this identifier as a PDO.
pub(super) fn is_tpdo(nodes: &[Node<'_>], id: u32) -> bool {
    let mut tpdos = nodes.iter().flat_map(|node| &node.tpdos);
    tpdos.any(|pdo| pdo.is_on() && pdo.identifier() == id)
}

/// Who sends with which identifier, and what.
#[derive(Default)]
struct Senders(HashMap<u32, (String, String)>);

impl Senders {
    fn add(
        &mut self,
        id: u32,
        who: &str,
        what: String,
        place: Option<Range<usize>>,
        network: &mut Network<'_>,
    ) {
        let known = self.0.get(&id);
        if let (Some((other, taken)), Some(place)) = (known, place) {
            // What one node does with an identifier twice, the rules of its data sheet tell.
            if other != who {
                let message = format!("{id:03X}h: `{who}` sends {what}, and `{other}` {taken}");
                network.report(&rule::COB_ID_CLASH, place, message);
            }
            return;
        }
        self.0.insert(id, (who.into(), what));
    }
}
