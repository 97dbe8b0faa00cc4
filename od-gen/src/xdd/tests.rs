//! An XDD means what the EDS beside it means.

mod structure;

use crate::data_type::DataType;
use crate::model::{DefaultValue, FileKind, Model};
use crate::print;
use crate::report::Report;

const XDD: &str = include_str!("../../tests/data/sensor.xdd");
const EDS: &str = include_str!("../../tests/data/sensor.eds");

fn model(text: &str) -> Model {
    let report = Report::new("sensor", text);
    assert!(!report.has_errors(), "{:#?}", report.findings);
    report.model
}

fn findings(old: &str, new: &str) -> Vec<String> {
    assert_eq!(XDD.matches(old).count(), 1, "{old}");
    let report = Report::new("sensor.xdd", &XDD.replace(old, new));
    report.findings.iter().map(ToString::to_string).collect()
}

#[test]
fn an_xdd_is_read_into_the_same_model_as_its_eds() {
    let xdd = model(XDD);
    assert_eq!(xdd.kind, FileKind::Xdd);
    let as_eds = Model {
        kind: FileKind::Eds,
        ..xdd.clone()
    };
    assert_eq!(as_eds, model(EDS));
    assert_eq!(Report::new("sensor", &print(&xdd)).model, as_eds);
    assert_eq!(xdd.entry(0x2000, 0).unwrap().unit(), Some("Hz"));
}

#[test]
fn findings_point_at_attributes() {
    assert_eq!(
        findings(
            "lowLimit=\"-5\" highLimit=\"-1\"/>",
            "lowLimit=\"-5\" highLimit=\"-99999\"/>"
        ),
        [
            "sensor.xdd:43:131: error[limit-type]: highLimit -99999 does not fit INTEGER16 (-32768 to 32767)"
        ]
    );
    assert_eq!(
        findings("<minValue value=\"10\"/>", "<minValue value=\"x\"/>"),
        [
            "sensor.xdd:19:52: error[not-a-number]: minValue: `x` is not a number (decimal, 0x hexadecimal or leading-zero octal)"
        ]
    );
    let gone = findings("index=\"1000\"", "index=\"1x00\"");
    assert!(
        gone[0].ends_with("the mandatory object 1000h is missing"),
        "{gone:?}"
    );
    assert!(
        gone[1].ends_with("the section [1x00] is not known"),
        "{gone:?}"
    );
}

#[test]
fn what_is_no_xdd_is_one_finding() {
    for (old, new, expected) in [
        (
            "</ISO15745ProfileContainer>",
            "",
            "sensor.xdd:LAST:1: error[not-xml]: the root node was opened but never closed",
        ),
        (
            "<CANopenObjectList>",
            "<CANopenObjectList></CANopenObjectList><x>",
            "sensor.xdd:",
        ),
    ] {
        let found = findings(old, new);
        let expected = expected.replace("LAST", &XDD.lines().count().to_string());
        assert!(
            found[0].starts_with(&expected) && found[0].contains("[not-xml]"),
            "{found:?}"
        );
        assert_eq!(found.len(), 1);
    }
    assert_eq!(Report::new("x.xdd", "<a/>").findings.len(), 1);
}

/// The device with a document type definition, and something else for its name.
fn defined(definition: &str, name: &str) -> String {
    let root = XDD.find("<ISO15745ProfileContainer").unwrap();
    let (head, rest) = XDD.split_at(root);
    let rest = rest.replace("<productName>Sensor<", &format!("<productName>{name}<"));
    format!("{head}<!DOCTYPE ISO15745ProfileContainer {definition}>\n{rest}")
}

#[test]
fn a_document_type_definition_changes_nothing() {
    for (definition, name) in [
        ("SYSTEM \"CANopen.dtd\"", "Sensor"),
        (
            "PUBLIC \"-//CiA//DTD XDD//EN\" 'http://example.com/xdd.dtd'",
            "Sensor",
        ),
        (
            "[<!ELEMENT a (b|c)*> <!-- -- >--> <!ATTLIST a x CDATA \"1\">]",
            "Sensor",
        ),
        (
            "[<!ENTITY maker \"Sen\"> <!ENTITY what 'sor'>]",
            "&maker;&what;",
        ),
        ("[<!ENTITY a \"S &amp; &#228;\">]", "Sensor"),
    ] {
        let definition = definition.replace(" -- >", "");
        assert_eq!(
            model(&defined(&definition, name)),
            model(XDD),
            "{definition}"
        );
    }
    assert_eq!(
        model(&defined("[<!ENTITY a \"x &lt; y\">]", "&a;"))
            .device
            .product_name,
        "x < y"
    );
}

#[test]
fn entities_that_blow_up_are_refused_at_once() {
    let mut laughs = String::from("[<!ENTITY lol0 \"lol\">");
    for level in 1..=9 {
        let below = format!("&lol{};", level - 1).repeat(10);
        laughs += &format!("<!ENTITY lol{level} \"{below}\">");
    }
    laughs += "]";
    let hidden = laughs.replace('&', "&#38;");
    let long = format!("[<!ENTITY a \"{}\">]", "x".repeat(100_000));
    for (definition, name, expected) in [
        (
            laughs.as_str(),
            "&lol9;".to_owned(),
            "the entity `lol1` stands for other entities",
        ),
        (
            &hidden,
            "&lol9;".to_owned(),
            "the entity `lol1` stands for other entities",
        ),
        (
            &long,
            "&a;".repeat(1000),
            "the entities of this file make it too large",
        ),
        (
            "[<!ENTITY a \"&a;\">]",
            "&a;".to_owned(),
            "the entity `a` stands for other entities",
        ),
        (
            "[<!ENTITY a SYSTEM \"file:///etc/hostname\">]",
            "&a;".to_owned(),
            "unknown entity",
        ),
        ("[<!ENTITY a \"", String::new(), ""),
    ] {
        let report = Report::new("bomb.xdd", &defined(definition, &name));
        let [finding] = report.findings.as_slice() else {
            panic!("{:?}", report.findings)
        };
        assert_eq!(finding.rule.name, "not-xml");
        assert!(finding.message.contains(expected), "{}", finding.message);
    }
}

#[test]
fn a_device_with_a_node_id_is_a_configured_one() {
    let text = XDD.replace("nodeID=\"0\"", "nodeID=\"5\"").replace(
        "<defaultValue value=\"100\"/>",
        "<defaultValue value=\"100\"/><actualValue value=\"50\"/>",
    );
    let model = model(&text);
    assert_eq!(model.commissioning.as_ref().unwrap().node_id, 5);
    assert_eq!(model.commissioning.as_ref().unwrap().bit_rate, 125);
    let rate = model.entry(0x2000, 0).unwrap();
    assert_eq!(rate.configured, Some(DefaultValue::number(50)));
    assert_eq!(rate.default, Some(DefaultValue::number(100)));
}

#[test]
fn what_is_configured_for_no_node_yet_is_kept() {
    let text = XDD
        .replace("actualBaudRate=\"125\"", "actualBaudRate=\"1000000\"")
        .replace("CANopenManager=\"false\"", "CANopenManager=\"TRUE\"")
        .replace(
            "highLimit=\"-1\"/>",
            "highLimit=\"-1\" actualValue=\"-3\"/>",
        );
    let configured = model(&text);
    let node = configured.commissioning.as_ref().unwrap();
    assert_eq!(
        (node.node_id, node.bit_rate, node.is_manager),
        (0, 1000, true)
    );
    let second = configured.entry(0x2001, 2).unwrap();
    assert_eq!(second.configured, Some(DefaultValue::number(-3)));
    // It goes into a DCF and comes back, still for no node.
    let dcf =
        crate::convert::convert(&configured, crate::convert::Format::Dcf, "sensor.dcf").unwrap();
    assert_eq!(dcf.lost, [] as [String; 0]);
    let back =
        crate::convert::convert(&dcf.report.model, crate::convert::Format::Xdc, "sensor.xdc")
            .unwrap();
    assert_eq!(back.lost, [] as [String; 0]);
    assert_eq!(back.report.model.commissioning, configured.commissioning);
}

#[test]
fn the_file_is_described_where_a_tool_has_put_it() {
    let first = "fileName=\"sensor.eds\" fileCreator=\"Nobody\" fileCreationDate=\"2026-11-21\" fileVersion=\"1\"";
    assert!(XDD.contains(first));
    let empty = "fileName=\"\" fileCreator=\"\" fileCreationDate=\"\" fileVersion=\"\"";
    let text = XDD
        .replace(first, empty)
        .replace(
            "CommunicationNetwork_CANopen\" fileName=\"sensor.eds\"",
            "CommunicationNetwork_CANopen\" fileName=\"second.xdd\" fileVersion=\"2.7\"",
        )
        .replace(
            "<productID>18</productID>",
            "<productID>18</productID><productText><description lang=\"en\">It\n senses.</description></productText>",
        );
    let info = model(&text).file_info;
    assert_eq!(
        (&*info.file_name, &*info.description),
        ("second.xdd", "It senses.")
    );
    assert_eq!((info.file_version, info.file_revision), (2, 7));
}

#[test]
fn a_text_of_several_lines_stays_one_line() {
    let text = XDD
        .replace(
            "<productName>Sensor</productName>",
            "<productName>\n  Sensor\n  pub fn evil() {}\n</productName>",
        )
        .replace(
            "name=\"Rate\"",
            "name=\"Rate&#10;}} pub fn evil() {} &#x202E;mod x {{//\"",
        )
        .replace(">Hz<", ">H&#13;z<")
        .replace("A made-up sensor;", "A made-up\n[2000]\nsensor;");
    assert!(text.contains("evil() {} &#x202E;mod"));
    let model = model(&text);
    assert_eq!(model.device.product_name, "Sensor pub fn evil() {}");
    let rate = model.entry(0x2000, 0).unwrap();
    assert_eq!(rate.name, "Rate }} pub fn evil() {} mod x {{//");
    assert_eq!(rate.unit(), Some("H z"));
    let as_eds = Model {
        kind: FileKind::Eds,
        ..model.clone()
    };
    assert_eq!(Report::new("sensor", &print(&model)).model, as_eds);
    let code = crate::generate(&model, crate::Options::DEVICE);
    for line in code.lines().filter(|line| line.contains("pub fn evil")) {
        assert!(
            line.trim_start().starts_with("//") || line.contains('"'),
            "{line}"
        );
    }
}

#[test]
fn an_object_that_is_there_twice_is_found() {
    let object = "<CANopenObject index=\"2000\" name=\"Other\" objectType=\"7\" dataType=\"0007\" accessType=\"rw\"/>";
    let end = "</CANopenObjectList>";
    let found = findings(end, &format!("{object}{end}"));
    assert!(
        found.iter().any(|found| found
            .contains("error[repeated-section]: CANopenObject 2000 is already on line")),
        "{found:?}"
    );
}

#[test]
fn a_parameter_says_the_type_of_an_object_that_does_not() {
    let own = " dataType=\"0006\" PDOmapping";
    assert_eq!(XDD.matches(own).count(), 1);
    let without = XDD.replace(own, " PDOmapping");
    assert_eq!(model(&without), model(XDD));
    for (name, data_type) in [
        ("BOOL", DataType::Boolean),
        ("SINT", DataType::Integer8),
        ("INT", DataType::Integer16),
        ("DINT", DataType::Integer32),
        ("LINT", DataType::Integer64),
        ("BYTE", DataType::Unsigned8),
        ("WORD", DataType::Unsigned16),
        ("UDINT", DataType::Unsigned32),
        ("LWORD", DataType::Unsigned64),
        ("REAL", DataType::Real32),
        ("LREAL", DataType::Real64),
    ] {
        let text = without.replacen("<UINT/>", &format!("<{name}/>"), 1);
        let model = Report::new("sensor.xdd", &text).model;
        let known = model.entry(0x2000, 0).map(|entry| entry.data_type);
        // The limits of the parameter do not fit the small types, which leaves no value.
        assert!(
            known == Some(data_type) || data_type.size() == Some(1),
            "{name}: {known:?}"
        );
    }
    // What the object says itself is what counts.
    let other = XDD.replacen("<UINT/>", "<UDINT/>", 1);
    assert_eq!(model(&other), model(XDD));
}

#[test]
fn indices_may_say_that_they_are_hexadecimal() {
    let text = XDD
        .replace("index=\"2000\"", "index=\"0x2000\"")
        .replace("subIndex=\"0", "subIndex=\"0x0");
    assert_eq!(model(&text), model(XDD));
}

#[test]
fn what_an_object_allows_stays_allowed_when_it_is_printed() {
    let report = Report::for_code("sensor.xdd", XDD);
    let model = Report::new("sensor.xdd", XDD).model;
    let printed = Report::for_code("sensor.eds", &print(&model));
    let silenced = |report: &Report| {
        let silenced = report.silenced.iter();
        let pairs = silenced.map(|(finding, reason)| (finding.rule.name, reason.clone()));
        // A printed file has a sub-index 0.
        pairs
            .filter(|(rule, _)| *rule != "no-sub-0")
            .collect::<Vec<_>>()
    };
    assert_eq!(silenced(&report).len(), 2);
    assert_eq!(silenced(&printed), silenced(&report));
    assert!(printed.findings.is_empty(), "{:?}", printed.findings);
}

/// What a file means, whatever its kind, and without what XML has no words for.
fn without_words_of_an_eds(mut model: Model) -> Model {
    model.kind = FileKind::Eds;
    model.file.clear();
    model.comments.clear();
    model.remarks.0.clear();
    model.device.compact_pdo = 0;
    model.device.revision_number = None;
    let info = &mut model.file_info;
    info.eds_version.clear();
    info.last_eds.clear();
    if let Some(node) = &mut model.commissioning {
        node.serial_number = None;
    }
    for object in &mut model.objects {
        for entry in &mut object.entries {
            (entry.upload_file, entry.download_file) = (None, None);
            // The unit comes from elsewhere.
            entry.notes.sort_by(|a, b| a.name.cmp(&b.name));
        }
    }
    model
}

#[test]
fn every_data_sheet_becomes_an_xdd_and_comes_back() {
    for (name, text) in [
        ("small.eds", include_str!("../../tests/data/small.eds")),
        ("types.eds", include_str!("../../tests/data/types.eds")),
        ("drive.eds", include_str!("../../tests/data/drive.eds")),
        ("vendor.eds", include_str!("../../tests/data/vendor.eds")),
        ("sensor.eds", EDS),
        ("sensor.xdd", XDD),
        ("axis402.eds", include_str!("../../../eds/axis402.eds")),
        ("lmd.eds", include_str!("../../../products/lmd/lmd.eds")),
        (
            "nanotec.eds",
            include_str!("../../../products/nanotec/nanotec.eds"),
        ),
        ("s200.eds", include_str!("../../../products/s200/s200.eds")),
        ("tc1.eds", include_str!("../../../products/tc1/tc1.eds")),
        ("every.dcf", include_str!("../../tests/data/every.dcf")),
    ] {
        let first = Report::new(name, text).model;
        let written = super::write(&first);
        let read = Report::new("written.xdd", &written);
        let (first, second) = (
            without_words_of_an_eds(first),
            without_words_of_an_eds(read.model),
        );
        let differences = crate::diff::diff(&first, &second);
        assert!(differences.is_empty(), "{name}: {differences:#?}");
        assert_eq!(first.objects, second.objects, "{name}");
        assert_eq!(super::write(&second), super::write(&first), "{name}");
    }
}

proptest::proptest! {
    #[test]
    fn a_made_up_dictionary_becomes_an_xdd_and_comes_back(
        made_up in print::tests::made_up(),
        name in "[A-Za-z0-9]([ -~äß€]{0,20}[!-~])?",
    ) {
        let mut made_up = made_up;
        made_up.device.product_name = name;
        made_up.file_info.creation_date = "11-21-2026".into();
        made_up.file_info.modification_time = "01:07PM".into();
        if made_up.commissioning.is_some() {
            for object in &mut made_up.objects {
                object.denotation = object.object_type.has_subs().then(|| "<&\"'>".into());
                for entry in &mut object.entries {
                    entry.configured = entry.default.clone();
                    entry.denotation = Some("here".into());
                }
            }
        }
        let written = super::write(&made_up);
        let read = print::tests::without_notes(Report::new("x.xdd", &written).model);
        let (first, second) = (without_words_of_an_eds(made_up), without_words_of_an_eds(read));
        proptest::prop_assert_eq!(first, second, "{}", written);
    }
}

#[test]
fn what_a_format_cannot_say_is_told() {
    use crate::convert::{Format, convert};
    let every = Report::new("every.dcf", include_str!("../../tests/data/every.dcf")).model;
    let none = convert(&every, Format::Dcf, "again.dcf").unwrap();
    assert_eq!(none.lost, [""; 0]);
    let xdc = convert(&every, Format::Xdc, "every.xdc").unwrap();
    let back = convert(&xdc.report.model, Format::Dcf, "back.dcf").unwrap();
    assert_eq!(back.lost, [""; 0]);
    let eds = convert(&every, Format::Eds, "every.eds").unwrap();
    insta::assert_snapshot!(format!(
        "XDC\n{}\n\nEDS\n{}",
        xdc.lost.join("\n"),
        eds.lost.join("\n")
    ));
    assert!(convert(&eds.report.model, Format::Xdc, "no.xdc").is_none());
}

#[test]
fn what_a_parameter_leaves_out_is_what_the_schema_says() {
    let text = XDD.replace("<UINT/><", "<BITSTRING/><").replace(
        "<parameter uniqueID=\"UID_RATE\" access=\"readWrite\">",
        "<parameter uniqueID=\"UID_RATE\">",
    );
    assert_ne!(text, XDD);
    let rate = Report::new("sensor.xdd", &text).model;
    assert_eq!(
        rate.entry(0x2000, 0).unwrap().access,
        crate::model::Access::ReadOnly
    );
    for (element, data_type) in [
        ("<BITSTRING/>", DataType::Domain),
        (
            "<BITSTRING/><defaultValue value=\"00 A5\"/>",
            DataType::OctetString,
        ),
        ("<CHAR/>", DataType::Integer8),
    ] {
        let object =
            "<CANopenObject index=\"2002\" name=\"Raw\" objectType=\"7\" uniqueIDRef=\"UID_RAW\"/>";
        let parameter = format!("<parameter uniqueID=\"UID_RAW\">{element}</parameter>");
        let text = XDD
            .replace("</parameterList>", &format!("{parameter}</parameterList>"))
            .replace(
                "</CANopenObjectList>",
                &format!("{object}</CANopenObjectList>"),
            );
        let read = Report::new("sensor.xdd", &text).model;
        assert_eq!(
            read.entry(0x2002, 0).map(|entry| entry.data_type),
            Some(data_type)
        );
    }
}
