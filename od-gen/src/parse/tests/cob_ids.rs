//! Default COB-IDs that the device would refuse.

use super::{finds, finds_for_code, finds_nothing};

const RPDO: &str = "DefaultValue=$NODEID+0x200";
const TPDO: &str = "DefaultValue=0x40000180+$NODEID";
const SYNC: &str = "DefaultValue=128";

#[test]
fn a_default_cob_id_is_not_restricted() {
    let restricted = |what: &str, identifier: &str| {
        format!("{what}: the identifier {identifier}h is restricted (CiA 301, table 40)")
    };
    for (old, default, what, identifier) in [
        (RPDO, "0x180", "1400h:1 is 00000180h", "180"),
        (TPDO, "0x400006E0", "1800h:1 is 400006E0h", "6E0"),
        (SYNC, "0x601", "1005h is 00000601h", "601"),
    ] {
        let new = format!("DefaultValue={default}");
        finds(old, &new, old, &restricted(what, identifier));
    }
    // Without a default nobody knows it; a generated device would start with 0, that of NMT.
    let sync = "DataType=0x0007\nAccessType=rw\nDefaultValue=128\n";
    let without = "DataType=0x0007\nAccessType=rw\n";
    finds_nothing(sync, without);
    finds_for_code(sync, without, &stands_for_none("1005h is 00000000h"));
}

fn stands_for_none(what: &str) -> String {
    format!("{what}: 000h is NMT's, so it stands for no identifier")
}

#[test]
fn a_default_cob_id_that_is_0_or_lacks_the_node_id_is_left_open() {
    for (old, default, what) in [
        (RPDO, "0", "1400h:1 is 00000000h"),
        (TPDO, "0x40000000", "1800h:1 is 40000000h"),
        // Bit 31 of 1005h means nothing.
        (SYNC, "0x80000000", "1005h is 80000000h"),
    ] {
        finds(
            old,
            &format!("DefaultValue={default}"),
            old,
            &stands_for_none(what),
        );
    }
    // Who produces SYNC with 000h starts every node instead.
    let produces = super::findings(SYNC, "DefaultValue=0x40000000");
    let restricted = "1005h is 40000000h: the identifier 000h is restricted (CiA 301, table 40)";
    assert!(produces.ends_with(restricted), "{produces}");
    let base = "1800h:1 is 00000180h: that is the predefined identifier without the node-ID";
    finds(TPDO, "DefaultValue=0x180", TPDO, base);
}

#[test]
fn a_default_cob_id_is_not_restricted_whatever_the_node_id() {
    for (default, what, identifier) in [
        // Only node-ID 1, only 127, and some in the middle.
        ("$NODEID+0x17F", "00000180h with node-ID 1", "180"),
        ("$NODEID+0x582", "00000583h with node-ID 1", "583"),
        ("$NODEID+0x502", "00000581h with node-ID 127", "581"),
        ("$NODEID+0x6A1", "000006E0h with node-ID 63", "6E0"),
        ("0x5F0+$NODEID", "000005F1h with node-ID 1", "5F1"),
        ("$NODEID", "00000001h with node-ID 1", "001"),
    ] {
        let message = format!(
            "1400h:1 is {what}: the identifier {identifier}h is restricted (CiA 301, table 40)"
        );
        finds(RPDO, &format!("DefaultValue={default}"), RPDO, &message);
    }
    let beyond =
        "1400h:1 is 00000800h with node-ID 1: bits 11 to 29 must be 0, as identifiers have 11 bits";
    finds(
        RPDO,
        "DefaultValue=$NODEID+0x800007FF",
        RPDO,
        &beyond.replace("0000080", "8000080"),
    );
}

#[test]
fn a_pdo_that_is_switched_off_may_have_any_11_bit_identifier() {
    for default in ["0x80000000", "$NODEID+0x80000000"] {
        let new = format!("DefaultValue={default}");
        assert_eq!(super::findings(RPDO, &new), "");
        assert_eq!(super::findings(TPDO, &new), "");
    }
}

#[test]
fn a_default_cob_id_has_11_bits() {
    let bits = "bits 11 to 29 must be 0, as identifiers have 11 bits";
    for (old, default, what) in [
        (RPDO, "0x20000200", "1400h:1 is 20000200h"),
        (RPDO, "0xA0000200", "1400h:1 is A0000200h"),
        (RPDO, "$NODEID+0xA00", "1400h:1 is 00000A01h with node-ID 1"),
        (
            TPDO,
            "0x60000180+$NODEID",
            "1800h:1 is 60000181h with node-ID 1",
        ),
        (SYNC, "0x20000080", "1005h is 20000080h"),
    ] {
        let new = format!("DefaultValue={default}");
        finds(old, &new, old, &format!("{what}: {bits}"));
    }
}

#[test]
fn bit_30_is_refused_where_the_device_refuses_it() {
    let emergency = |default: &str| {
        let text = super::SMALL
            .replace("COB-ID SYNC message", "COB-ID EMCY")
            .replace("0x1005", "0x1014")
            .replace("[1005]", "[1014]")
            .replace(SYNC, &format!("DefaultValue={default}"));
        crate::report::Report::new("x.eds", &text)
            .findings
            .iter()
            .map(|finding| finding.message.clone())
            .collect::<Vec<_>>()
    };
    assert!(emergency("$NODEID+0x80").is_empty());
    assert!(emergency("0x80000000").is_empty());
    assert_eq!(
        emergency("$NODEID+0x40000080"),
        ["1014h is 40000081h with node-ID 1: bit 30 is reserved and must be 0"]
    );
    assert_eq!(
        emergency("$NODEID"),
        [
            "1014h is 00000001h with node-ID 1: the identifier 001h is restricted (CiA 301, table 40)"
        ]
    );
}
