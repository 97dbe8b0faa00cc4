//! What the bus is loaded with.

use std::fmt::Write;

use super::Network;
use super::identifiers::is_tpdo;
use super::node::Node;
use super::pdo::Pdo;
use crate::rules::network as rule;

/// How often a frame is sent, in thousandths of a hertz.
type MilliHertz = u64;

/// A frame that is sent again and again.
struct Row {
    id: u32,
    what: String,
    bits: u64,
    /// In any case.
    least: MilliHertz,
    /// `None` where nothing bounds it.
    most: Option<MilliHertz>,
}

/// Bits of a frame with this many bytes, with all stuff bits that it can have, and with the three bits between frames.
fn bits(id: u32, bytes: u32) -> u64 {
    let data = 8 * u64::from(bytes);
    // What can be stuffed: from the start bit to the end of the checksum. The rest is of fixed form.
    let stuffed = if id & 1 << 29 == 0 { 34 } else { 54 };
    stuffed + data + (stuffed + data - 1) / 4 + 13
}

fn rate(microseconds: u64) -> MilliHertz {
    1_000_000_000_u64.checked_div(microseconds).unwrap_or(0)
}

/// Reckons what is sent, reports what does not fit, and tells it as a table.
pub(super) fn table(nodes: &[Node<'_>], network: &mut Network<'_>) -> String {
    let file = network.file;
    let sync = file.sync.as_ref().map(|sync| sync.get_ref());
    let sync_rate = rate(sync.map_or(0, |sync| u64::from(sync.period)));
    let mut rows = Vec::new();
    if let Some(sync) = sync {
        let id = sync.cob_id.as_ref().map_or(0x80, |id| *id.get_ref()).into();
        let bytes = u32::from(sync.overflow != 0);
        rows.push(Row::steady(id, "SYNC".into(), bytes, sync_rate));
    }
    let mut of_master: Vec<u32> = Vec::new();
    for node in nodes {
        for pdo in node.tpdos.iter().filter(|pdo| pdo.is_on()) {
            rows.push(Row::of_pdo(node, pdo, sync_rate));
        }
        for pdo in node.rpdos.iter().filter(|pdo| pdo.is_on()) {
            let id = pdo.identifier();
            let is_of_master = file.master.is_some() && pdo.own.is_some();
            if is_of_master && !is_tpdo(nodes, id) && !of_master.contains(&id) {
                of_master.push(id);
                rows.push(Row::of_pdo(node, pdo, sync_rate));
            }
        }
    }
    let master = file.master.as_ref().map(|master| master.get_ref());
    let master = master.map(|own| ("master", *own.node_id.get_ref(), own.heartbeat));
    let others = nodes
        .iter()
        .map(|node| (node.name, node.node_id, node.heartbeat));
    for (name, node_id, heartbeat) in master.into_iter().chain(others) {
        if heartbeat != 0 {
            let id = 0x700 + u32::from(node_id);
            let rate = rate(u64::from(heartbeat) * 1000);
            rows.push(Row::steady(id, format!("{name} heartbeat"), 1, rate));
        }
    }
    for node in nodes.iter().filter(|node| node.guard_time() != 0) {
        let id = 0x700 + u32::from(node.node_id);
        let rate = rate(u64::from(node.guard_time()) * 1000);
        rows.push(Row::steady(id, format!("{} is asked", node.name), 0, rate));
        rows.push(Row::steady(id, format!("{} answers", node.name), 1, rate));
    }
    rows.sort_by_key(|row| row.id);
    let per_second = |row: &Row, rate: u64| row.bits * rate / 1000;
    let least: u64 = rows.iter().map(|row| per_second(row, row.least)).sum();
    let most = |row: &Row| per_second(row, row.most.unwrap_or(row.least));
    let most: u64 = rows.iter().map(most).sum();
    let bit_rate = u64::from(*file.network.bit_rate.get_ref()) * 1000;
    let place = file.network.bit_rate.span();
    let percent = |bits: u64| {
        let tenths = bits * 1000 / bit_rate.max(1);
        format!("{}.{} %", tenths / 10, tenths % 10)
    };
    if least > bit_rate {
        let message = format!("what is sent in any case takes {}", percent(least));
        network.report(&rule::BUS_OVERLOAD, place, message);
    } else if most > bit_rate {
        let message = format!("what may be sent takes up to {}", percent(most));
        network.report(&rule::BUS_LOAD, place, message);
    }

    let mut table = format!(
        "{:9} {:32} {:>5} {:>12} {:>12}\n",
        "COB-ID", "frame", "bits", "least bit/s", "most bit/s"
    );
    for row in &rows {
        let most = match row.most {
            Some(rate) => per_second(row, rate).to_string(),
            None => "-".into(),
        };
        let id = format!("{:03X}h", row.id & 0x1FFF_FFFF);
        let (what, bits, least) = (&row.what, row.bits, per_second(row, row.least));
        // Writing to a text cannot fail.
        let _ = writeln!(table, "{id:9} {what:32} {bits:>5} {least:>12} {most:>12}");
    }
    let (least, most) = (percent(least), percent(most));
    let kbits = bit_rate / 1000;
    let _ = writeln!(table, "at {kbits} kbit/s: {least} at least, {most} at most");
    let unbounded = rows.iter().filter(|row| row.most.is_none());
    let unbounded: Vec<&str> = unbounded.map(|row| row.what.as_str()).collect();
    if !unbounded.is_empty() {
        let names = unbounded.join(", ");
        let _ = writeln!(table, "not bounded, without an inhibit time: {names}");
    }
    table
}

impl Row {
    fn steady(id: u32, what: String, bytes: u32, rate: MilliHertz) -> Self {
        Self {
            id,
            what,
            bits: bits(id, bytes),
            least: rate,
            most: Some(rate),
        }
    }

    /// A PDO that a node sends, or that the master sends to it.
    fn of_pdo(node: &Node<'_>, pdo: &Pdo<'_>, sync: MilliHertz) -> Self {
        let id = pdo.identifier();
        let inhibit = u64::from(pdo.inhibit_time) * 100;
        let event = rate(u64::from(pdo.event_timer) * 1000);
        let (least, most) = match pdo.transmission {
            // When something has changed, at most with each SYNC.
            0 => (0, Some(sync)),
            count @ 1..=240 => (sync / u64::from(count), Some(sync / u64::from(count))),
            // When somebody asks.
            241..=253 => (0, Some(0)),
            _ if inhibit != 0 => (event, Some(rate(inhibit).max(event))),
            _ => (event, None),
        };
        Self {
            id,
            what: format!("{} {}", node.name, pdo.name()),
            bits: bits(id, pdo.length()),
            least,
            most,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::bits;

    #[test]
    fn a_frame_has_as_many_bits_as_the_textbooks_say() {
        // With the three bits between frames: 55 without data, 135 and 160 with eight bytes.
        assert_eq!(bits(0x181, 0), 55);
        assert_eq!(bits(0x181, 8), 135);
        assert_eq!(bits(1 << 29 | 0x181, 8), 160);
    }
}
