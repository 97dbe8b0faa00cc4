use proptest::prelude::*;

use super::*;

fn value(text: &str) -> i128 {
    Number::parse(text).unwrap().value
}

#[test]
fn each_notation_is_read() {
    assert_eq!(value("0"), 0);
    assert_eq!(value("10"), 10);
    assert_eq!(value("-10"), -10);
    assert_eq!(value("+10"), 10);
    assert_eq!(value("+0x10"), 16);
    assert_eq!(value("010"), 8);
    assert_eq!(value("0x10"), 16);
    assert_eq!(value("0XfF"), 255);
    assert_eq!(value("-0x10"), -16);
    assert_eq!(value("18446744073709551615"), i128::from(u64::MAX));
}

#[test]
fn spelling_mistakes_are_refused() {
    for text in [
        "", "-", "0x", "08", "0x1G", "1.5", "++1", "+-1", "0x-1", "--1", "1 2", "10h", "٣",
    ] {
        assert!(Number::parse(text).is_err(), "{text}");
    }
    assert!(
        Number::parse("0x10000000000000000")
            .unwrap_err()
            .message
            .contains("64 bits")
    );
}

#[test]
fn what_may_be_two_numbers_is_put_right_by_nobody() {
    assert_eq!(nearest("1F"), Some("0x1F".into()));
    assert_eq!(nearest("1e3"), None);
    assert_eq!(nearest("1E3"), None);
}

#[test]
fn the_node_id_may_stand_on_either_side() {
    for text in ["$NODEID+0x180", "0x180+$NODEID", " $nodeid + 0x180 "] {
        let default = DefaultNumber::parse(text).unwrap();
        assert!(
            default.adds_node_id && default.number.value == 0x180,
            "{text}"
        );
    }
    assert_eq!(DefaultNumber::parse("$NODEID").unwrap().number.value, 0);
    assert!(!DefaultNumber::parse("5").unwrap().adds_node_id);
    for text in [
        "$NODEID+$NODEID",
        "$NODEID-1",
        "1+2",
        "$NODE+1",
        "$NODEID+",
        "$NODEID+1+1",
        "$NODEID++1",
    ] {
        assert!(DefaultNumber::parse(text).is_err(), "{text}");
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read(number in any::<u64>(), negative in any::<bool>(), with_id in any::<bool>()) {
        let sign = if negative { "-" } else { "" };
        let expected = if negative { -i128::from(number) } else { i128::from(number) };
        let octal = if number == 0 { "0".to_string() } else { format!("0{number:o}") };
        for text in [format!("{sign}{number}"), format!("{sign}0x{number:X}"), format!("{sign}0x{number:x}"), format!("{sign}{octal}")] {
            prop_assert_eq!(value(&text), expected);
            let written = if with_id { format!("$NODEID+{text}") } else { text };
            let default = DefaultNumber::parse(&written).unwrap();
            prop_assert_eq!((default.number.value, default.adds_node_id), (expected, with_id));
        }
    }

    #[test]
    fn any_text_gets_an_answer(text in ".*") {
        let _ = DefaultNumber::parse(&text);
    }
}

#[test]
fn what_was_meant_is_proposed() {
    let proposed = |text: &str| {
        let mistake = DefaultNumber::parse(text).unwrap_err();
        mistake.help.unwrap_or_default()
    };
    for (text, near) in [
        ("08", "8"),
        ("10h", "0x10"),
        ("1F", "0x1F"),
        ("0x10u", "0x10"),
        ("\"5\"", "5"),
        ("1.0", "1"),
        ("0x0A;ten", "0x0A"),
        ("True", "1"),
        ("NODEID+0x600", "$NODEID+0x600"),
        ("0x600+nodeid", "0x600+$nodeid"),
    ] {
        assert_eq!(proposed(text), format!("write `{near}`"), "{text}");
    }
    for text in [
        "",
        "0x",
        "abc",
        "1.5",
        "1 2",
        "$NODEID-1",
        "$NODEID+$NODEID",
    ] {
        assert_eq!(proposed(text), "", "{text}");
    }
}
