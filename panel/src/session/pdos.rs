//! PDOs as a table: read, reckoned, and written all of them or none (CiA 301, 7.5.2.33 to 7.5.2.38).

use std::collections::BTreeSet;

use master::Failure;
use master::Line;
use master::axis402::{self, Node, Problem};
use master::data_sheet::{Address, DataSheet};
use od_gen::Model;
use od_gen::model::{DefaultValue, Entry};

use super::Session;
use super::poll::number;
use crate::message::{Answer, Mappable, Mapped, Pdo, PdoPlan, PdoTable};

/// Records of communication and of mapping, for PDOs that are received and sent.
const RECEIVE: (u16, u16) = (0x1400, 0x1600);
const TRANSMIT: (u16, u16) = (0x1800, 0x1A00);

/// Bits of a COB-ID (CiA 301, table 69).
const INVALID: u32 = 1 << 31;
const NO_RTR: u32 = 1 << 30;
const EXTENDED: u32 = 1 << 29;

/// Bits of the data of a PDO.
const MOST_BITS: u32 = 64;

/// Where a node has no 1006h, SYNC is taken to come so often, in microseconds.
const USUAL_SYNC: u32 = 10_000;

fn records(pdo: &Pdo) -> (u16, u16) {
    let (communication, mapping) = if pdo.receive { RECEIVE } else { TRANSMIT };
    let place = pdo.number.saturating_sub(1);
    (communication + place, mapping + place)
}

fn title(pdo: &Pdo) -> String {
    let kind = if pdo.receive { "RPDO" } else { "TPDO" };
    format!("{kind} {}", pdo.number)
}

impl<L: Line> Session<L> {
    pub(super) fn pdos(&mut self, id: u8) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let pdos = self.read_pdos(&node)?;
        let sync = self.optional(&node, 0x1006)?.unwrap_or_default();
        Ok(Answer::Pdos(PdoTable {
            pdos,
            mappable: mappable(&node.sheet),
            sync_period: u32::try_from(sync).ok().filter(|period| *period != 0),
        }))
    }

    /// All PDOs that the data sheet has and the node too.
    pub(super) fn read_pdos(&mut self, node: &Node) -> Result<Vec<Pdo>, Problem> {
        let model = node.sheet.model();
        let mut pdos = Vec::new();
        for (receive, (first, _)) in [(true, RECEIVE), (false, TRANSMIT)] {
            for object in model.objects_in(first..=first + 511) {
                let number = object.index - first + 1;
                if let Some(pdo) = self.read_pdo(node, receive, number)? {
                    pdos.push(pdo);
                }
            }
        }
        Ok(pdos)
    }

    fn read_pdo(&mut self, node: &Node, receive: bool, place: u16) -> Result<Option<Pdo>, Problem> {
        let mut pdo = Pdo {
            receive,
            number: place,
            ..Pdo::default()
        };
        let (communication, mapping) = records(&pdo);
        let Some(cob_id) = self.entry(node, communication, 1)? else {
            return Ok(None);
        };
        let cob_id = cob_id as u32;
        pdo.enabled = cob_id & INVALID == 0;
        pdo.rtr = cob_id & NO_RTR == 0;
        pdo.cob_id = cob_id
            & if cob_id & EXTENDED == 0 {
                0x7FF
            } else {
                0x1FFF_FFFF
            };
        pdo.kind = self.entry(node, communication, 2)?.unwrap_or_default() as u8;
        if !receive {
            pdo.inhibit_time = self.entry(node, communication, 3)?.map(|time| time as u16);
            pdo.sync_start = self.entry(node, communication, 6)?.map(|start| start as u8);
        }
        pdo.event_timer = self.entry(node, communication, 5)?.map(|time| time as u16);
        let count = self.entry(node, mapping, 0)?.unwrap_or_default().min(64);
        for sub in 1..=count as u8 {
            let entry = self.entry(node, mapping, sub)?.unwrap_or_default() as u32;
            let address = Address::new((entry >> 16) as u16, (entry >> 8) as u8);
            pdo.mapped.push(Mapped {
                object: address.to_string(),
                bits: entry as u8,
            });
        }
        Ok(Some(pdo))
    }

    /// An entry that the data sheet has; `None` where it or the node has none.
    fn entry(&mut self, node: &Node, index: u16, sub: u8) -> Result<Option<i64>, Problem> {
        if node.sheet.entry(index, sub).is_none() {
            return Ok(None);
        }
        match node.upload(&mut self.master, Address::new(index, sub)) {
            Ok(bytes) => Ok(Some(number(&bytes, false))),
            Err(Failure::Abort { .. }) => Ok(None),
            Err(failure) => Err(Problem::with_node(node.id, failure)),
        }
    }

    pub(super) fn plan_pdos(&mut self, id: u8, pdos: &[Pdo], sync: u32) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let bit_rate = self.setup.bit_rate;
        Ok(Answer::Plan(plan(&node.sheet, pdos, sync, bit_rate)))
    }

    /// Checked as a whole first, then written in the order that the standard asks for. When the node refuses anything, it gets what it
    /// had before.
    pub(super) fn set_pdos(&mut self, id: u8, pdos: &[Pdo]) -> Result<Answer, Problem> {
        let node = self.node(id)?;
        let planned = plan(&node.sheet, pdos, USUAL_SYNC, None);
        if let Some(problem) = planned.problems.first() {
            return Err(Problem::Usage(problem.clone()));
        }
        let before = self.read_pdos(&node)?;
        let wanted = configuration(&node, pdos).map_err(Problem::Usage)?;
        let (result, words) = self.load_model(&node, &wanted);
        let Err(problem) = result else {
            self.live = None;
            return Ok(Answer::Text(words.said));
        };
        let why = words.remarks.into_iter().next();
        let why = why.or_else(|| problem.line()).unwrap_or_default();
        let before: Vec<Pdo> = (before.into_iter())
            .filter(|old| {
                pdos.iter()
                    .any(|new| (new.receive, new.number) == (old.receive, old.number))
            })
            .collect();
        let old = configuration(&node, &before).map_err(Problem::Failed)?;
        let (result, _) = self.load_model(&node, &old);
        Err(Problem::Failed(match result {
            Ok(()) => format!("{why}; all PDOs are as they were"),
            Err(_) => format!("{why}; and not all PDOs could be put back"),
        }))
    }

    /// Writes a configuration; what `axis402 od load` would say, and its result.
    pub(super) fn load_model(
        &mut self,
        node: &Node,
        model: &Model,
    ) -> (Result<(), Problem>, Words) {
        self.with_words(|master, console| axis402::load(master, node, model, console))
    }
}

/// What a command of the command line has told.
#[derive(Debug, Default)]
pub(super) struct Words {
    /// Its last line.
    pub said: String,
    /// Its remarks.
    pub remarks: Vec<String>,
}

/// What can be mapped, by the data sheet.
fn mappable(sheet: &DataSheet) -> Vec<Mappable> {
    let mut all = Vec::new();
    for (object, entry) in sheet.model().entries() {
        let (receive, transmit) = (entry.is_rpdo_mappable(), entry.is_tpdo_mappable());
        let Some(bits) = bits(entry).filter(|_| receive || transmit) else {
            continue;
        };
        let address = Address::new(object.index, entry.sub);
        all.push(Mappable {
            object: address.to_string(),
            name: sheet.name(address).unwrap_or_default(),
            bits,
            receive,
            transmit,
        });
    }
    all
}

/// How long a value is in a PDO.
fn bits(entry: &Entry) -> Option<u8> {
    let bits = match entry.data_type {
        od_gen::DataType::Boolean => 1,
        _ => 8 * entry.size,
    };
    u8::try_from(bits)
        .ok()
        .filter(|bits| (1..=64).contains(bits))
}

/// What a table means, and what is wrong with it.
fn plan(sheet: &DataSheet, pdos: &[Pdo], sync: u32, bit_rate: Option<u32>) -> PdoPlan {
    let mut plan = PdoPlan::default();
    let mut sent = BTreeSet::new();
    let mut bits_per_second = 0;
    let sync = if sync == 0 { USUAL_SYNC } else { sync };
    for pdo in pdos {
        let name = title(pdo);
        let mut wrong = |what: String| plan.problems.push(format!("{name}: {what}"));
        let length = check(sheet, pdo, &mut wrong);
        if pdo.enabled && !pdo.receive && !sent.insert(pdo.cob_id) {
            wrong(format!(
                "{:03X}h is sent by another TPDO already",
                pdo.cob_id
            ));
        }
        let rate = rate(pdo, sync).filter(|_| pdo.enabled);
        if pdo.enabled && !pdo.receive && rate.is_none() && matches!(pdo.kind, 0xFE | 0xFF) {
            plan.unbounded += 1;
        }
        plan.kinds.push(kind(pdo));
        bits_per_second += u64::from(rate.unwrap_or(0)) * u64::from(longest(length));
        plan.rates.push(rate);
    }
    let of = |rate: u32| u32::try_from(bits_per_second * 1_000 / u64::from(rate.max(1))).ok();
    plan.load = bit_rate.and_then(of);
    plan
}

/// What is wrong with a PDO; gives the bytes that it has.
fn check(sheet: &DataSheet, pdo: &Pdo, wrong: &mut impl FnMut(String)) -> u32 {
    let (communication, mapping) = records(pdo);
    if sheet.entry(communication, 1).is_none() {
        wrong("the data sheet has no such PDO".to_owned());
    }
    if pdo.enabled && is_restricted(pdo.cob_id) {
        wrong(format!(
            "{:03X}h is kept for other services (CiA 301, table 36)",
            pdo.cob_id
        ));
    }
    let reserved = if pdo.receive { 241..=253 } else { 241..=251 };
    if reserved.contains(&pdo.kind) {
        wrong(format!("transmission type {} is reserved", pdo.kind));
    }
    let room = sheet
        .object(mapping)
        .map_or(0, |object| object.entries.len().saturating_sub(1));
    if pdo.mapped.len() > room {
        wrong(format!(
            "{} objects are mapped, {room} can be",
            pdo.mapped.len()
        ));
    }
    let mut sum = 0;
    for mapped in &pdo.mapped {
        sum += u32::from(mapped.bits);
        let entry = sheet.find(&mapped.object).ok();
        let Some(address) = entry else {
            wrong(format!("{} is not in the dictionary", mapped.object));
            continue;
        };
        // A dummy entry fills a place of a receive PDO.
        if pdo.receive && address.index < 0x20 {
            continue;
        }
        let entry = sheet.entry(address.index, address.sub);
        let fits = |entry: &&Entry| match pdo.receive {
            true => entry.is_rpdo_mappable(),
            false => entry.is_tpdo_mappable(),
        };
        match entry.filter(fits).map(bits) {
            None => wrong(format!("{address} cannot be mapped here")),
            Some(known) if known != Some(mapped.bits) => {
                wrong(format!("{address} has not {} bits", mapped.bits));
            }
            Some(_) => {}
        }
    }
    if sum > MOST_BITS {
        wrong(format!("{sum} bits are mapped, a frame has {MOST_BITS}"));
    }
    sum.div_ceil(8).min(8)
}

/// What a transmission type means (CiA 301, 7.5.2.33 and 7.5.2.35).
fn kind(pdo: &Pdo) -> String {
    let words = match (pdo.receive, pdo.kind) {
        (true, 0..=240) => "with the next SYNC",
        (true, 254 | 255) => "at once",
        (false, 0) => "with SYNC, if changed",
        (false, 1) => "with each SYNC",
        (false, every @ 2..=240) => {
            let ending = match (every % 10, every % 100) {
                (_, 11..=13) => "th",
                (1, _) => "st",
                (2, _) => "nd",
                (3, _) => "rd",
                _ => "th",
            };
            return format!("with every {every}{ending} SYNC");
        }
        (false, 252) => "on request, of the last SYNC",
        (false, 253) => "on request",
        (false, 254) => "on events of the maker",
        (false, 255) => "on change, or by timer",
        _ => "reserved",
    };
    words.to_owned()
}

/// Frames in a second at most (CiA 301, transmission types).
fn rate(pdo: &Pdo, sync: u32) -> Option<u32> {
    match (
        pdo.kind,
        pdo.inhibit_time.unwrap_or(0),
        pdo.event_timer.unwrap_or(0),
    ) {
        (0 | 1, ..) => Some(1_000_000u32.div_ceil(sync)),
        (every @ 2..=240, ..) => Some(1_000_000u32.div_ceil(sync.saturating_mul(every.into()))),
        // Only when it is asked for, or by whoever sends it.
        (252 | 253, ..) => None,
        _ if pdo.receive => None,
        (_, 0, 0) => None,
        // An event may come at any time; an inhibit time bounds them.
        (_, 0, timer) => Some(1_000u32.div_ceil(timer.into())),
        (_, inhibit, _) => Some(10_000u32.div_ceil(inhibit.into())),
    }
}

/// The bits of a data frame with so many bytes at most, stuff bits and intermission included.
fn longest(bytes: u32) -> u32 {
    let data = 8 * bytes;
    data + 47 + (34 + data - 1) / 4
}

/// Identifiers that a PDO may not have (CiA 301, restricted CAN-IDs).
fn is_restricted(cob_id: u32) -> bool {
    matches!(
        cob_id,
        0 | 0x001..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..=0x77F | 0x780..=0x7FF
    )
}

/// The table as a configuration of the node.
fn configuration(node: &Node, pdos: &[Pdo]) -> Result<Model, String> {
    let mut model = node.sheet.model().clone();
    for object in &mut model.objects {
        for entry in &mut object.entries {
            entry.configured = None;
        }
    }
    let mut set = |index: u16, sub: u8, value: Option<i128>| {
        let entry = model
            .objects
            .iter_mut()
            .find(|object| object.index == index);
        let entry =
            entry.and_then(|object| object.entries.iter_mut().find(|entry| entry.sub == sub));
        if let (Some(entry), Some(value)) = (entry, value) {
            entry.configured = Some(DefaultValue::number(value));
        }
    };
    for pdo in pdos {
        let (communication, mapping) = records(pdo);
        let mut cob_id = pdo.cob_id;
        for (flag, is_set) in [
            (INVALID, !pdo.enabled),
            (NO_RTR, !pdo.rtr && !pdo.receive),
            (EXTENDED, pdo.cob_id > 0x7FF),
        ] {
            cob_id |= if is_set { flag } else { 0 };
        }
        set(communication, 1, Some(cob_id.into()));
        set(communication, 2, Some(pdo.kind.into()));
        set(communication, 3, pdo.inhibit_time.map(i128::from));
        set(communication, 5, pdo.event_timer.map(i128::from));
        set(communication, 6, pdo.sync_start.map(i128::from));
        set(mapping, 0, Some(pdo.mapped.len() as i128));
        for (sub, mapped) in (1..).zip(&pdo.mapped) {
            let address = node.sheet.find(&mapped.object)?;
            let entry = u32::from(address.index) << 16 | u32::from(address.sub) << 8;
            set(mapping, sub, Some((entry | u32::from(mapped.bits)).into()));
        }
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tpdo(number: u16, kind: u8, objects: &[(&str, u8)]) -> Pdo {
        Pdo {
            number,
            enabled: true,
            cob_id: 0x184 + 0x100 * u32::from(number - 1),
            kind,
            mapped: (objects.iter())
                .map(|&(object, bits)| Mapped {
                    object: object.to_owned(),
                    bits,
                })
                .collect(),
            ..Pdo::default()
        }
    }

    #[test]
    fn the_load_is_what_the_types_bound() {
        let sheet = DataSheet::axis402();
        let six = [("6041h:00", 16), ("6064h:00", 32)];
        let mut timed = tpdo(2, 255, &six);
        timed.event_timer = Some(10);
        let changing = tpdo(3, 255, &six);
        let made = plan(
            &sheet,
            &[tpdo(1, 2, &six), timed, changing],
            1_000,
            Some(1_000_000),
        );
        assert_eq!(made.problems, [""; 0]);
        assert_eq!(made.rates, [Some(500), Some(100), None]);
        assert_eq!(
            made.kinds,
            [
                "with every 2nd SYNC",
                "on change, or by timer",
                "on change, or by timer"
            ]
        );
        assert_eq!(made.unbounded, 1);
        // 48 bits of data: 47 more, and 20 stuff bits at most; 600 frames.
        assert_eq!(longest(6), 115);
        assert_eq!(made.load, Some(69));
        assert_eq!(longest(8), 135);
    }

    #[test]
    fn a_table_that_cannot_be_is_told() {
        let sheet = DataSheet::axis402();
        let mut restricted = tpdo(
            1,
            250,
            &[("6041h:00", 8), ("606Ch:00", 32), ("6064h:00", 32)],
        );
        restricted.cob_id = 0x601;
        let mut twin = tpdo(2, 1, &[("1018h:01", 32)]);
        twin.cob_id = 0x601;
        let problems = plan(&sheet, &[restricted, twin], 0, None).problems;
        for expected in [
            "TPDO 1: 601h is kept for other services (CiA 301, table 36)",
            "TPDO 1: transmission type 250 is reserved",
            "TPDO 1: 6041h:00 has not 8 bits",
            "TPDO 1: 72 bits are mapped, a frame has 64",
            "TPDO 2: 601h is sent by another TPDO already",
            "TPDO 2: 1018h:01 cannot be mapped here",
        ] {
            assert!(
                problems.iter().any(|problem| problem == expected),
                "{expected}: {problems:?}"
            );
        }
    }
}
