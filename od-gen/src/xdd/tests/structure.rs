//! What is written has the structure of CiA 311, as far as it is known here.

use crate::report::Report;

/// The children of each element that is written, in the order that CiA 311 gives them. The schema itself is not at hand.
const CHILDREN: [(&str, &[&str]); 13] = [
    (
        "ISO15745ProfileContainer",
        &["ISO15745Profile", "ISO15745Profile"],
    ),
    ("ISO15745Profile", &["ProfileHeader", "ProfileBody"]),
    (
        "ProfileHeader",
        &[
            "ProfileIdentification",
            "ProfileRevision",
            "ProfileName",
            "ProfileSource",
            "ProfileClassID",
            "ISO15745Reference",
        ],
    ),
    (
        "ISO15745Reference",
        &["ISO15745Part", "ISO15745Edition", "ProfileTechnology"],
    ),
    (
        "ProfileBody",
        &[
            "DeviceIdentity",
            "ApplicationProcess",
            "ApplicationLayers",
            "TransportLayers",
            "NetworkManagement",
        ],
    ),
    (
        "DeviceIdentity",
        &[
            "vendorName",
            "vendorID",
            "deviceFamily",
            "productFamily",
            "productName",
            "productID",
            "productText",
            "orderNumber",
            "version",
            "specificationRevision",
        ],
    ),
    ("productText", &["description"]),
    ("ApplicationProcess", &["parameterList"]),
    ("ApplicationLayers", &["CANopenObjectList", "dummyUsage"]),
    ("TransportLayers", &["PhysicalLayer"]),
    ("PhysicalLayer", &["baudRate"]),
    (
        "NetworkManagement",
        &[
            "CANopenGeneralFeatures",
            "CANopenMasterFeatures",
            "deviceCommissioning",
        ],
    ),
    ("unit", &["label"]),
];

/// What an attribute may hold.
fn is_allowed(name: &str, value: &str) -> bool {
    let is_hex = |digits: usize| {
        value.len() == digits && value.bytes().all(|digit| digit.is_ascii_hexdigit())
    };
    match name {
        "index" | "dataType" => is_hex(4),
        "subIndex" => is_hex(2),
        "objFlags" => is_hex(4),
        "objectType" => matches!(value, "0" | "2" | "5" | "6" | "7" | "8" | "9"),
        "accessType" => matches!(value, "const" | "ro" | "wo" | "rw"),
        "PDOmapping" => matches!(value, "no" | "default" | "optional" | "TPDO" | "RPDO"),
        "subNumber" | "nodeID" | "networkNumber" => value.parse::<u32>().is_ok(),
        // A version and, where there is one, a revision.
        "fileVersion" => value.split('.').all(|number| number.parse::<u8>().is_ok()),
        "CANopenManager" | "bootUpMaster" => matches!(value, "true" | "false"),
        _ => true,
    }
}

#[test]
fn what_is_written_has_the_structure_of_cia_311() {
    for text in [
        include_str!("../../../../eds/axis402.eds"),
        include_str!("../../../tests/data/small.eds"),
        include_str!("../../../tests/data/types.eds"),
        include_str!("../../../tests/data/every.dcf"),
        include_str!("../../../tests/data/coupler.eds"),
    ] {
        let written = crate::xdd::write(&Report::new("x.eds", text).model);
        let document = roxmltree::Document::parse(&written).unwrap();
        let elements = || document.descendants().filter(|node| node.is_element());
        let ids: Vec<&str> = elements()
            .filter_map(|node| node.attribute("uniqueID"))
            .collect();
        for node in elements() {
            let name = node.tag_name().name();
            let children: Vec<&str> = node
                .children()
                .filter(|child| child.is_element())
                .map(|child| child.tag_name().name())
                .collect();
            if let Some((_, order)) = CHILDREN.iter().find(|(own, _)| *own == name) {
                let mut rest = order.iter();
                for child in &children {
                    assert!(
                        rest.any(|next| next == child),
                        "{name}: {children:?} is not in the order of {order:?}"
                    );
                }
            }
            for attribute in node.attributes() {
                let (key, value) = (attribute.name(), attribute.value());
                assert!(is_allowed(key, value), "{name}: {key}=\"{value}\"");
            }
            if let Some(id) = node.attribute("uniqueIDRef") {
                assert!(ids.contains(&id), "nothing has the uniqueID {id}");
            }
            if let Some(count) = node.attribute("subNumber") {
                assert_eq!(count, children.len().to_string(), "{name}");
            }
            let is_profile = name == "ProfileBody";
            for needed in ["formatName", "formatVersion", "fileName", "fileVersion"] {
                assert!(!is_profile || node.has_attribute(needed), "{needed}");
            }
        }
    }
}
