//! The DCF of the master: whom it starts and how, what it writes into them, and PDOs for what they send and receive.

use std::collections::HashMap;

use super::Made;
use super::file::{self, File};
use super::identifiers::is_tpdo;
use super::node::{Node, consumer_time};
use super::pdo::Pdo;
use crate::data_type::DataType;
use crate::model::{
    Access, Commissioning, DefaultValue, DeviceInfo, Entry, FileInfo, FileKind, Model, Object,
    ObjectType,
};

/// Node-IDs and what stands there.
type Elements = Vec<(u8, u32)>;

/// The DCF of the master, where there is one.
pub(super) fn file(file: &File, nodes: &[Node<'_>]) -> Option<Made> {
    let master = file.master.as_ref()?.get_ref();
    let mut writer = Writer::default();
    writer.communication(file, master, nodes);
    writer.pdos(file, nodes);
    writer.start_up(master, nodes);
    let mut objects = writer.objects;
    objects.sort_by_key(|object| object.index);
    let in_range = |first: u16| {
        let range = first..=first + 0x1FF;
        let count = objects
            .iter()
            .filter(|object| range.contains(&object.index));
        u16::try_from(count.count()).ok()
    };
    let stated = |number: u32| Some(number);
    let model = Model {
        file: "master.dcf".into(),
        kind: FileKind::Dcf,
        file_info: FileInfo {
            file_name: "master.dcf".into(),
            file_version: 1,
            eds_version: "4.0".into(),
            description: "The master of a network".into(),
            ..FileInfo::default()
        },
        device: DeviceInfo {
            vendor_number: stated(master.vendor_id),
            product_number: stated(master.product_code),
            revision_number: stated(master.revision_number),
            bit_rates: super::BIT_RATES.to_vec(),
            simple_boot_up_master: true,
            granularity: 1,
            rpdos: in_range(0x1400),
            tpdos: in_range(0x1800),
            lss: true,
            ..DeviceInfo::default()
        },
        commissioning: Some(Commissioning {
            node_id: *master.node_id.get_ref(),
            node_name: "master".into(),
            bit_rate: *file.network.bit_rate.get_ref(),
            net_number: file.network.number,
            network_name: file.network.name.clone(),
            is_manager: true,
            serial_number: Some(master.serial_number),
        }),
        dummies: (1..=7).collect(),
        objects,
        ..Model::default()
    };
    Some(Made {
        name: "master.dcf".into(),
        bytes: crate::print(&model).into_bytes(),
        sheet: None,
    })
}

#[derive(Default)]
struct Writer {
    objects: Vec<Object>,
}

/// A number with its access.
fn entry(sub: u8, name: &str, data_type: DataType, access: Access, value: u32) -> Entry {
    Entry {
        access,
        default: Some(DefaultValue::number(value.into())),
        ..Entry::new(sub, name, data_type)
    }
}

const U8: DataType = DataType::Unsigned8;
const U16: DataType = DataType::Unsigned16;
const U32: DataType = DataType::Unsigned32;
const RW: Access = Access::ReadWrite;
const RO: Access = Access::ReadOnly;

impl Writer {
    fn object(&mut self, index: u16, name: &str, object_type: ObjectType, entries: Vec<Entry>) {
        let element = entries.get(1).map(|entry| entry.data_type.code());
        self.objects.push(Object {
            index,
            name: name.into(),
            data_type: element.filter(|_| object_type == ObjectType::Array),
            object_type,
            entries,
            ..Object::default()
        });
    }

    fn var(&mut self, index: u16, name: &str, data_type: DataType, access: Access, value: u32) {
        let entry = entry(0, name, data_type, access, value);
        self.object(index, name, ObjectType::Var, vec![entry]);
    }

    /// A record or an array, with sub-index 0 in front of its elements.
    fn list(&mut self, index: u16, name: &str, object_type: ObjectType, elements: Vec<Entry>) {
        let highest = elements.iter().map(|entry| entry.sub).max().unwrap_or(0);
        let count = entry(
            0,
            "Highest sub-index supported",
            U8,
            Access::Constant,
            highest.into(),
        );
        let entries = std::iter::once(count).chain(elements).collect();
        self.object(index, name, object_type, entries);
    }

    /// An array with an element for each node-ID up to the highest; nothing where there is none.
    fn array(&mut self, index: u16, name: &str, data_type: DataType, elements: &Elements) {
        let highest = elements.iter().map(|(sub, _)| *sub).max().unwrap_or(0);
        if highest == 0 {
            return;
        }
        let all = (1..=highest).map(|sub| {
            let found = elements.iter().find(|(own, _)| *own == sub);
            let value = found.map_or(0, |(_, value)| *value);
            entry(sub, &format!("{name} {sub}"), data_type, RW, value)
        });
        self.list(index, name, ObjectType::Array, all.collect());
    }

    /// A DOMAIN for each node-ID, which comes from a file where there is one.
    fn files(&mut self, index: u16, name: &str, files: &[(u8, String)]) {
        let highest = files.iter().map(|(sub, _)| *sub).max().unwrap_or(0);
        if highest == 0 {
            return;
        }
        let all = (1..=highest).map(|sub| {
            let found = files.iter().find(|(own, _)| *own == sub);
            Entry {
                access: RO,
                upload_file: found.map(|(_, file)| file.clone()),
                ..Entry::new(sub, format!("{name} {sub}"), DataType::Domain)
            }
        });
        self.list(index, name, ObjectType::Array, all.collect());
    }

    fn communication(&mut self, file: &File, master: &file::Master, nodes: &[Node<'_>]) {
        self.var(0x1000, "Device type", U32, RO, 0);
        self.var(0x1001, "Error register", U8, RO, 0);
        let sync = file.sync.as_ref().map(|sync| sync.get_ref());
        let id = sync.and_then(|sync| sync.cob_id.as_ref());
        let id = id.map_or(0x80, |id| u32::from(*id.get_ref()));
        let produced = sync.filter(|sync| {
            let producer = sync.producer.as_ref();
            producer.is_none_or(|name| name.get_ref() == "master")
        });
        let flag = if produced.is_some() { 1 << 30 } else { 0 };
        let (period, window) = produced.map_or((0, 0), |sync| (sync.period, sync.window));
        let overflow = produced.map_or(0, |sync| sync.overflow.into());
        self.var(0x1005, "COB-ID SYNC message", U32, RW, id | flag);
        self.var(0x1006, "Communication cycle period", U32, RW, period);
        self.var(0x1007, "Synchronous window length", U32, RW, window);
        let node_id = u32::from(*master.node_id.get_ref());
        self.var(0x1014, "COB-ID EMCY", U32, RW, 0x80 + node_id);
        let guarded: Elements = nodes
            .iter()
            .filter(|node| node.heartbeat != 0 && node.is_guarded_by_master())
            .zip(1..)
            .map(|(node, sub)| {
                let time = consumer_time(file, node.heartbeat).unwrap_or(u16::MAX);
                (sub, u32::from(node.node_id) << 16 | u32::from(time))
            })
            .collect();
        self.array(0x1016, "Consumer heartbeat time", U32, &guarded);
        let heartbeat = master.heartbeat.into();
        self.var(0x1017, "Producer heartbeat time", U16, RW, heartbeat);
        let identity = [
            ("Vendor-ID", master.vendor_id),
            ("Product code", master.product_code),
            ("Revision number", master.revision_number),
            ("Serial number", master.serial_number),
        ];
        let identity = (1..).zip(identity);
        let identity = identity.map(|(sub, (name, value))| entry(sub, name, U32, RO, value));
        let identity = identity.collect();
        self.list(0x1018, "Identity object", ObjectType::Record, identity);
        self.var(
            0x1019,
            "Synchronous counter overflow value",
            U8,
            RW,
            overflow,
        );
        let emergencies = nodes.iter().filter_map(|node| {
            let id = node.number(0x1014, 0)?;
            (id & 1 << 31 == 0).then_some((node.node_id, id))
        });
        let mut emergencies: Elements = emergencies.collect();
        let highest = emergencies.iter().map(|(sub, _)| *sub).max().unwrap_or(0);
        for sub in 1..highest {
            if !emergencies.iter().any(|(own, _)| *own == sub) {
                emergencies.push((sub, 1 << 31));
            }
        }
        self.array(0x1028, "Emergency consumer object", U32, &emergencies);
        self.array(0x1029, "Error behavior object", U8, &vec![(1, 0)]);
    }

    /// A receive PDO for each transmit PDO of a node, and the other way round.
    fn pdos(&mut self, file: &File, nodes: &[Node<'_>]) {
        let (mut received, mut sent) = (0, 0);
        let mut of_master: Vec<u32> = Vec::new();
        for node in nodes {
            let mut known = HashMap::new();
            for pdo in node.tpdos.iter().filter(|pdo| pdo.is_on()) {
                if received < 0x200 {
                    self.pdo(node, pdo, received, &mut known);
                    received += 1;
                }
            }
            let mut known = HashMap::new();
            for pdo in node.rpdos.iter().filter(|pdo| pdo.is_on()) {
                let id = pdo.identifier();
                let is_new = !of_master.contains(&id) && !is_tpdo(nodes, id);
                if is_new && pdo.own.is_some() && file.master.is_some() && sent < 0x200 {
                    of_master.push(id);
                    self.pdo(node, pdo, sent, &mut known);
                    sent += 1;
                }
            }
        }
    }

    /// The PDO of the master for one of a node: its parameters, its objects, and, for lely, which one of which node it is.
    fn pdo(
        &mut self,
        node: &Node<'_>,
        pdo: &Pdo<'_>,
        number: u16,
        known: &mut HashMap<(u16, u8), u32>,
    ) {
        let is_sent = !pdo.is_tpdo;
        let kind = if is_sent { "TPDO" } else { "RPDO" };
        let (communication, objects, remote) = match is_sent {
            true => (0x1800, 0x2200, 0x5C00),
            false => (0x1400, 0x2000, 0x5800),
        };
        let index = communication + number;
        let mut parameters = vec![
            entry(1, "COB-ID", U32, RW, pdo.cob_id),
            entry(2, "Transmission type", U8, RW, pdo.transmission.into()),
        ];
        if is_sent {
            let inhibit = pdo.inhibit_time.into();
            parameters.push(entry(3, "Inhibit time", U16, RW, inhibit));
            parameters.push(entry(5, "Event timer", U16, RW, pdo.event_timer.into()));
            parameters.push(entry(6, "SYNC start value", U8, RW, 0));
        } else {
            let deadline = pdo.own.and_then(|own| own.deadline).unwrap_or(0);
            parameters.push(entry(5, "Event timer", U16, RW, deadline.into()));
        }
        let name = format!("{kind} communication parameter");
        self.list(index, &name, ObjectType::Record, parameters);

        let own = objects + number;
        let mut values = Vec::new();
        let mapping = (1..).zip(&pdo.mapping).map(|(sub, mapped)| {
            let value = match known.get(&(mapped.index, mapped.sub)) {
                _ if mapped.is_gap() => mapped.value(),
                Some(value) => *value,
                None => {
                    let at = u8::try_from(values.len() + 1).unwrap_or(u8::MAX);
                    values.push(Entry {
                        access: match is_sent {
                            true => Access::ReadWriteInput,
                            false => Access::ReadWriteOutput,
                        },
                        pdo_mapping: true,
                        ..Entry::new(
                            at,
                            format!("{}: {}", node.name, mapped.name),
                            mapped.data_type,
                        )
                    });
                    let own = u32::from(own) << 16 | u32::from(at) << 8 | u32::from(mapped.bits);
                    known.insert((mapped.index, mapped.sub), own);
                    own
                }
            };
            entry(sub, &format!("Mapped object {sub}"), U32, RW, value)
        });
        let mapping: Vec<Entry> = mapping.collect();
        let name = format!("{kind} mapping parameter");
        self.mapping(index + 0x200, &name, mapping);
        if !values.is_empty() {
            let name = format!("Mapped application objects for {kind} {}", number + 1);
            self.list(own, &name, ObjectType::Record, values);
        }

        let theirs = if is_sent { "RPDO" } else { "TPDO" };
        let who = u32::from(pdo.number) << 8 | u32::from(node.node_id);
        let name = format!("Remote {theirs} number and node-ID");
        self.var(remote + number, &name, U32, RW, who);
        let mapped = (1..).zip(&pdo.mapping).map(|(sub, mapped)| {
            let name = format!("Mapped object {sub}");
            entry(sub, &name, U32, RW, mapped.value())
        });
        let name = format!("Remote {theirs} mapping parameter");
        let mapped = mapped.collect();
        self.list(remote + 0x200 + number, &name, ObjectType::Array, mapped);
    }

    /// A mapping parameter, whose sub-index 0 can be written.
    fn mapping(&mut self, index: u16, name: &str, elements: Vec<Entry>) {
        self.list(index, name, ObjectType::Record, elements);
        let object = self.objects.last_mut();
        if let Some(count) = object.and_then(|object| object.entries.first_mut()) {
            count.access = RW;
            count.name = "Number of mapped objects".into();
        }
    }

    /// CiA 302-2 and 302-3: the nodes of the network, who they are, and what is written into them.
    fn start_up(&mut self, master: &file::Master, nodes: &[Node<'_>]) {
        let of = |value: &dyn Fn(&Node<'_>) -> u32| -> Elements {
            let elements = nodes.iter().map(|node| (node.node_id, value(node)));
            elements.filter(|(_, value)| *value != 0).collect()
        };
        let written = nodes.iter().filter(|node| node.is_written());
        let file =
            |node: &Node<'_>, ending: &str| (node.node_id, format!("{}.{ending}", node.name));
        if master.store_dcf {
            let files: Vec<_> = nodes.iter().map(|node| file(node, "dcf")).collect();
            self.files(0x1F20, "Store DCF", &files);
        }
        let concise: Vec<_> = written.map(|node| file(node, "bin")).collect();
        self.files(0x1F22, "Concise DCF", &concise);
        let flags = [
            (master.start_all_nodes, 0x02),
            (!master.start, 0x04),
            (!master.start_nodes, 0x08),
            (master.reset_all_nodes, 0x10),
            (master.stop_all_nodes, 0x40),
        ];
        let flags = flags.into_iter().filter(|(is_set, _)| *is_set);
        let startup = flags.fold(0x01, |value, (_, bit)| value | bit);
        self.var(0x1F80, "NMT startup", U32, RW, startup);
        let assignment = of(&|node| {
            let own = node.own;
            let flags = [
                (own.boot, 0x04),
                (own.mandatory, 0x08),
                (!own.reset_communication, 0x10),
                (own.restore_configuration != 0, 0x80),
            ];
            let flags = flags.into_iter().filter(|(is_set, _)| *is_set);
            let flags = flags.fold(0x01, |value, (_, bit)| value | bit);
            let guard_time = u32::from(node.guard_time());
            flags | u32::from(own.retry_factor) << 8 | guard_time << 16
        });
        self.array(0x1F81, "NMT slave assignment", U32, &assignment);
        let commands = nodes.iter().map(|node| (node.node_id, 0)).collect();
        self.array(0x1F82, "Request NMT", U8, &commands);
        let guarded = nodes.iter().filter(|node| node.guard_time() != 0);
        let requests = guarded.map(|node| (node.node_id, 0)).collect();
        self.array(0x1F83, "Request node guarding", U8, &requests);
        let device = of(&|node| node.number(0x1000, 0).unwrap_or(0));
        self.array(0x1F84, "Device type identification", U32, &device);
        let vendor = of(&|node| node.identity(1));
        self.array(0x1F85, "Vendor identification", U32, &vendor);
        let product = of(&|node| node.identity(2));
        self.array(0x1F86, "Product code", U32, &product);
        let revision = of(&|node| node.identity(3));
        self.array(0x1F87, "Revision number", U32, &revision);
        let serial = of(&|node| node.identity(4));
        self.array(0x1F88, "Serial number", U32, &serial);
        self.var(0x1F89, "Boot time", U32, RW, master.boot_time);
        let restored = of(&|node| node.own.restore_configuration.into());
        self.array(0x1F8A, "Restore configuration", U8, &restored);
    }
}

impl Node<'_> {
    /// Whether the master guards it: where nobody else is named, it does.
    fn is_guarded_by_master(&self) -> bool {
        let guards = self.own.guarded_by.as_ref();
        guards.is_none_or(|guards| guards.iter().any(|guard| guard.get_ref() == "master"))
    }

    /// An element of its identity, where the device has it: what the description says, then DeviceInfo, then 1018h. 0 for none.
    fn identity(&self, sub: u8) -> u32 {
        if self.model.entry(0x1018, sub).is_none() && sub != 1 {
            return 0;
        }
        let device = &self.model.device;
        let stated = match sub {
            1 => device.vendor_number,
            2 => device.product_number,
            3 => self.own.revision_number.or(device.revision_number),
            _ => self.own.serial_number,
        };
        let stated = stated.filter(|number| *number != 0);
        stated.or_else(|| self.number(0x1018, sub)).unwrap_or(0)
    }
}
