//! Networks from their description to bytes.

use super::*;

pub(super) const MACHINE: &str = include_str!("../../tests/data/network/machine.toml");
const SMALL: &str = include_str!("../../tests/data/network/small.toml");
const DEVICE: &str = include_str!("../../../tests/eds/basic-device.eds");
const DRIVE: &str = include_str!("../../../eds/axis402.eds");

pub(super) fn sheet(name: &str) -> io::Result<Report> {
    match name.rsplit('/').next() {
        Some("basic-device.eds" | "io.eds") => Ok(Report::new("basic-device.eds", DEVICE)),
        Some("axis402.eds") => Ok(Report::new("axis402.eds", DRIVE)),
        Some("empty.eds") => Ok(Report::new("empty.eds", "")),
        _ => Err(io::ErrorKind::NotFound.into()),
    }
}

pub(super) fn network(text: &str) -> NetworkReport {
    NetworkReport::new("net.toml", text, sheet)
}

/// The small network with a piece of it changed.
fn changed(old: &str, new: &str) -> NetworkReport {
    assert_eq!(SMALL.matches(old).count(), 1, "{old}");
    network(&SMALL.replace(old, new))
}

pub(super) fn lines(report: &NetworkReport) -> Vec<String> {
    report.findings.iter().map(ToString::to_string).collect()
}

fn made<'a>(report: &'a NetworkReport, name: &str) -> &'a [u8] {
    let found = report.files.iter().find(|made| made.name == name);
    &found
        .unwrap_or_else(|| panic!("{name}: {:?}", lines(report)))
        .bytes
}

/// What a DCF of a network configures a number to.
fn value(report: &NetworkReport, file: &str, index: u16, sub: u8) -> Option<u32> {
    let text = std::str::from_utf8(made(report, file)).unwrap();
    let read = Report::new(file, text);
    assert!(!read.has_errors(), "{}", read.render(Colour::Never));
    let node_id = read.model.commissioning.as_ref().unwrap().node_id;
    objects::number(&read.model, index, sub, node_id)
}

#[test]
fn the_concise_dcf_is_that_of_lely() {
    let report = network(MACHINE);
    assert_eq!(lines(&report), [""; 0]);
    // What dcfgen 2.4.2 makes of machine.yml; tests/python/test_network.py makes it anew.
    for (name, bytes) in [
        (
            "axis_x",
            include_bytes!("../../tests/data/network/axis_x.bin").as_slice(),
        ),
        (
            "axis_y",
            include_bytes!("../../tests/data/network/axis_y.bin"),
        ),
        ("io", include_bytes!("../../tests/data/network/io.bin")),
    ] {
        assert_eq!(made(&report, &format!("{name}.bin")), bytes, "{name}");
    }
}

#[test]
fn the_dcf_of_a_node_says_what_the_concise_one_ends_with() {
    let report = network(MACHINE);
    for node in ["axis_x", "axis_y", "io"] {
        let file = format!("{node}.dcf");
        let concise = made(&report, &format!("{node}.bin"));
        let mut last = std::collections::BTreeMap::new();
        let mut rest = concise.get(4..).unwrap();
        while let [low, high, sub, size, 0, 0, 0, more @ ..] = rest {
            let (bytes, behind) = more.split_at((*size).into());
            let value = bytes
                .iter()
                .rev()
                .fold(0, |sum, byte| sum << 8 | u32::from(*byte));
            last.insert((u16::from_le_bytes([*low, *high]), *sub), value);
            rest = behind;
        }
        assert!(rest.is_empty() && !last.is_empty());
        let text = std::str::from_utf8(made(&report, &file)).unwrap();
        let read = Report::new(&file, text);
        assert!(!read.has_errors(), "{}", read.render(Colour::Never));
        let node_id = read.model.commissioning.as_ref().unwrap().node_id;
        for ((index, sub), value) in last {
            let own = objects::number(&read.model, index, sub, node_id);
            assert_eq!(own, Some(value), "{file} {index:04X}h:{sub:X}");
        }
    }
}

#[test]
fn the_master_knows_its_nodes() {
    let report = network(MACHINE);
    for (index, sub, expected) in [
        (0x1005, 0, Some(0x4000_0080)),
        (0x1006, 0, Some(4000)),
        (0x1016, 1, Some(0x0002_0258)),
        (0x1016, 3, Some(0x000A_0096)),
        (0x1400, 1, Some(0x182)),
        (0x1800, 1, Some(0x202)),
        // It is sent every 500 ms, as the description says of axis_y.
        (0x1802, 5, Some(500)),
        // What io hears from axis_x the master does not send.
        (0x1803, 1, None),
        (0x1F80, 0, Some(1)),
        (0x1F81, 2, Some(0x30D)),
        (0x1F81, 3, Some(0x515)),
        (0x1F84, 2, Some(0x0004_0192)),
        (0x1F88, 2, Some(0x1234)),
        // TPDO 2 of node 2.
        (0x5801, 0, Some(0x202)),
        (0x5A01, 2, Some(0x603F_0010)),
    ] {
        let own = value(&report, "master.dcf", index, sub);
        assert_eq!(own, expected, "{index:04X}h:{sub:X}");
    }
    let master = std::str::from_utf8(made(&report, "master.dcf")).unwrap();
    assert!(master.contains("UploadFile=axis_y.bin"));
    assert!(!master.contains("[1F20]"));
    let report = changed("node_id = 1\n", "node_id = 1\nstore_dcf = true\n");
    let master = std::str::from_utf8(made(&report, "master.dcf")).unwrap();
    assert!(master.contains("UploadFile=left.dcf"));
}

/// All that CiA 302-2 and 302-3 have of nodes where it says something, and nothing of others that use these indices.
#[test]
fn the_objects_of_the_master_are_those_of_cia_302() {
    let text = "[network]\nbit_rate = 500\n[master]\nnode_id = 1\nstore_dcf = true\n[[node]]\nname = \"axis\"\n\
                sheet = \"axis402.eds\"\nnode_id = 4\nheartbeat = 0\nguard_time = 200\nserial_number = 7\nrestore_configuration = 1\n";
    let report = network(text);
    let master = std::str::from_utf8(made(&report, "master.dcf")).unwrap();
    let master = Report::new("master.dcf", master).model;
    let found = master.objects.iter().map(|object| object.index);
    let found: Vec<u16> = found
        .filter(|index| (0x1F00..0x2000).contains(index))
        .collect();
    // The vendor-ID of the drive is 0, so that none is expected in 1F85h.
    let expected = [0x1F20, 0x1F22].into_iter().chain(0x1F80..=0x1F8A);
    let expected = expected.filter(|index| *index != 0x1F85);
    assert_eq!(found, expected.collect::<Vec<_>>());
}

#[test]
fn every_mistake_is_told_with_its_line() {
    let mut said = String::new();
    for (old, new) in [
        ("[sync]", "[sink]"),
        ("node_id = 5", "node_id = 300"),
        ("node_id = 5", "node_id = 4"),
        ("node_id = 5", "node_id = 128"),
        ("\"right\"\nsheet", "\"left\"\nsheet"),
        ("\"right\"\nsheet", "\"a/b\"\nsheet"),
        ("bit_rate = 125", "bit_rate = 126"),
        ("sheet = \"other/", "sheet = \"other/no-"),
        ("other/basic-device", "empty"),
        ("period = 10000", "period = 10000\nproducer = \"middle\""),
        (
            "[node.rpdo.3]\nenabled = false\n\n[node.tpdo.1]\ncob_id",
            "[node.tpdo.9]\ncob_id",
        ),
        ("cob_id = 0x185", "cob_id = \"any\""),
        ("cob_id = 0x185", "from = \"x\""),
        ("cob_id = 0x185", "deadline = 5"),
        ("from = \"left.tpdo1\"", "sync_start = 5"),
        ("cob_id = 0x185", "cob_id = 0x184"),
        ("cob_id = 0x185", "cob_id = 0x704"),
        ("cob_id = 0x185", "cob_id = 0x80"),
        ("[\"sent_number_1\"", "[\"sent_numbr_1\""),
        ("[\"sent_number_1\"", "[\"9999h\""),
        ("[\"sent_number_1\"", "[\"received_number_1\""),
        ("[\"sent_number_1\"", "[\"UNSIGNED8\""),
        ("[\"sent_number_1\"", "[\"long_text\""),
        ("[\"sent_number_1\"", "[\"wide_number\", \"sent_number_1\""),
        ("\"left.tpdo1\"", "\"left.tpdo7\""),
        ("\"left.tpdo1\"", "\"left.tpdo3\""),
        ("\"left.tpdo1\"", "\"right.tpdo1\""),
        ("\"left.tpdo1\"", "\"left.tpdo2\""),
        ("cob_id = 0x185", "name = \"left.tpdo1\""),
        ("guarded_by = [\"right\"]", "guarded_by = [\"wright\"]"),
        ("guarded_by = [\"right\"]", "guarded_by = [\"left\"]"),
        ("heartbeat = 1000", "heartbeat = 40000"),
        ("heartbeat = 1000", "heartbeat = 0"),
        ("heartbeat_multiplier = 2", "heartbeat_multiplier = 0.5"),
        ("number = 7", "number = 4294967296"),
        ("number = 7", "numbre = 7"),
        ("number = 7", "\"1F00h\" = 7"),
        ("number = 7", "\"1000h\" = 7"),
        ("number = 7", "number = [7]"),
        ("[node.rpdo.3]\nenabled = false\n", ""),
        ("period = 10000", "period = 500"),
        ("inhibit_time = 100", "inhibit_time = 1"),
    ] {
        assert!(SMALL.contains(old), "{old}");
        let report = network(&SMALL.replacen(old, new, 1));
        assert!(!report.findings.is_empty(), "{new}");
        assert_eq!(report.has_errors(), report.files.is_empty(), "{new}");
        said += &format!("{new:?}\n{}\n\n", lines(&report).join("\n"));
    }
    for rule in rule::RULES {
        assert!(said.contains(rule.name), "{}", rule.name);
    }
    insta::assert_snapshot!(said);
}

#[test]
fn nodes_guard_each_other() {
    let report = network(SMALL);
    assert_eq!(lines(&report), [""; 0]);
    // Twice the producer's time: the right one waits for the left one, and the master for the right one.
    assert_eq!(value(&report, "right.dcf", 0x1016, 1), Some(0x0004_07D0));
    assert_eq!(value(&report, "left.dcf", 0x1016, 1), Some(0));
    assert_eq!(value(&report, "master.dcf", 0x1016, 1), Some(0x0005_00C8));
    assert_eq!(value(&report, "master.dcf", 0x1016, 2), None);
    assert_eq!(
        made(&report, "right.bin").get(4..7),
        Some(&[0x16, 0x10, 1][..])
    );
}

#[test]
fn a_node_hears_another_past_a_gap() {
    let report = network(SMALL);
    assert_eq!(value(&report, "right.dcf", 0x1400, 1), Some(0x184));
    assert_eq!(value(&report, "right.dcf", 0x1600, 1), Some(0x0007_0020));
    assert_eq!(value(&report, "right.dcf", 0x1600, 2), Some(0x2003_0020));
}

#[test]
fn a_node_can_make_the_rhythm() {
    let report = changed(
        "period = 10000",
        "period = 10000\nproducer = \"left\"\noverflow = 20",
    );
    assert_eq!(lines(&report), [""; 0]);
    assert_eq!(value(&report, "left.dcf", 0x1005, 0), Some(0x4000_0080));
    assert_eq!(value(&report, "left.dcf", 0x1006, 0), Some(10_000));
    for node in ["left.dcf", "right.dcf"] {
        assert_eq!(value(&report, node, 0x1019, 0), Some(20), "{node}");
    }
    assert_eq!(value(&report, "master.dcf", 0x1005, 0), Some(0x80));
    assert!(
        report
            .load
            .contains("080h      SYNC                                65")
    );
}

#[test]
fn without_a_master_every_receive_pdo_needs_a_node_that_sends() {
    let (_, nodes) = SMALL.split_once("[[node]]").unwrap();
    let text = format!("[network]\nbit_rate = 125\n[[node]]{nodes}");
    let report = network(
        &text
            .replace("\"master\"", "\"left\"")
            .replace("number = 7", "number = 8"),
    );
    assert!(report.files.iter().all(|made| made.name != "master.dcf"));
    let found = lines(&report);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].contains("warning[rpdo-without-producer]: nobody sends 204h, RPDO 1 of `left`")
    );
    let silent = format!("# od-gen: allow rpdo-without-producer because a PLC sends it\n\n{text}");
    let silent = network(&silent.replace("\"master\"", "\"left\""));
    assert_eq!((silent.findings.len(), silent.silenced.len()), (0, 1));
}

#[test]
fn the_load_of_the_bus() {
    insta::assert_snapshot!(network(SMALL).load);
}

#[test]
fn the_example_of_the_readme_is_right() {
    let readme = include_str!("../../README.md");
    let block = |kind: &str| {
        let (_, rest) = readme.split_once(&format!("```{kind}\n[network]")).unwrap();
        format!("[network]{}", rest.split("```").next().unwrap())
    };
    let report = network(&block("toml"));
    let (_, yaml) = readme.split_once("```yaml\n").unwrap();
    let yaml = yaml.split("```").next().unwrap();
    let yaml = NetworkReport::new("net.yaml", yaml, sheet);
    assert!(!yaml.has_errors(), "{:?}", lines(&yaml));
    let warnings = report.findings.iter().map(|finding| finding.rule.name);
    // What is left out there has data sheets that switch more on.
    assert!(warnings.clone().all(|rule| rule == "rpdo-without-producer"));
    let (_, table) = readme.split_once("```text\n").unwrap();
    let table = table.split("```").next().unwrap();
    assert_eq!(report.load, table);
}

/// Node guarding in place of heartbeats (CiA 301, 7.2.8.2.2.1; CiA 302-2, 1F81h and 1F83h).
#[test]
fn a_node_is_guarded_where_it_has_no_heartbeat() {
    let guarded = |more: &str| {
        let text = format!(
            "[network]\nbit_rate = 500\n[master]\nnode_id = 1\n[[node]]\nname = \"axis\"\nsheet = \"axis402.eds\"\nnode_id = 4\n{more}"
        );
        network(&text)
    };
    let report = guarded("heartbeat = 0\nguard_time = 200\nlife_time_factor = 3\n");
    assert!(!report.has_errors(), "{:?}", lines(&report));
    assert_eq!(value(&report, "axis.dcf", 0x1017, 0), Some(0));
    assert_eq!(value(&report, "axis.dcf", 0x100C, 0), Some(200));
    assert_eq!(value(&report, "axis.dcf", 0x100D, 0), Some(3));
    // Guard time, retry factor, slave.
    assert_eq!(
        value(&report, "master.dcf", 0x1F81, 4),
        Some(200 << 16 | 3 << 8 | 0x05)
    );
    assert_eq!(value(&report, "master.dcf", 0x1F83, 4), Some(0));
    for row in ["axis is asked ", "axis answers "] {
        assert!(report.load.contains(row), "{}", report.load);
    }
    let both = guarded("heartbeat = 100\nguard_time = 200\n");
    let told = lines(&both).join("\n");
    assert!(
        told.contains("`axis` is asked for its state, and sends heartbeats every 100 ms"),
        "{told:?}"
    );
    let without = guarded("heartbeat = 0\n");
    assert_eq!(value(&without, "master.dcf", 0x1F83, 4), None);
}
