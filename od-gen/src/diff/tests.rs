use super::*;
use crate::report::parse;

const SMALL: &str = include_str!("../../tests/data/small.eds");

fn model(text: &str) -> Model {
    parse("x.eds", text).unwrap()
}

/// The differences after each `old` (which is there once) has become `new`.
fn differences(changes: &[(&str, &str)]) -> Vec<String> {
    let mut text = SMALL.to_owned();
    for (old, new) in changes {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text = text.replacen(old, new, 1);
    }
    let differences = diff(&model(SMALL), &model(&text));
    differences.iter().map(ToString::to_string).collect()
}

#[test]
fn a_file_is_like_itself() {
    assert!(differences(&[]).is_empty());
}

#[test]
fn spelling_order_and_comments_make_no_difference() {
    let spelled = [
        ("FileVersion=1", "FileVersion=2"),
        (
            "DefaultValue=0x00040192",
            "; a comment\nDefaultValue=262546",
        ),
        (
            "ParameterName=Device type\n",
            "\n\nparametername = Device type\n",
        ),
        ("[1018sub1]", "[1018SUB01]"),
    ];
    assert_eq!(differences(&spelled), [""; 0]);
}

#[test]
fn what_is_changed_is_named_with_both_values() {
    assert_eq!(
        differences(&[
            ("ProductNumber=18", "ProductNumber=19"),
            ("DefaultValue=022", "DefaultValue=023")
        ]),
        [
            "~ [DeviceInfo] ProductNumber: 0x00000012 -> 0x00000013  !",
            "~ 1018h:2 DefaultValue: 18 -> 19"
        ]
    );
    // No default is no default: 0 is another thing.
    assert_eq!(
        differences(&[(
            "[1001]\nParameterName=Error register\n",
            "[1001]\nParameterName=Error register\nDefaultValue=0\n"
        )]),
        ["~ 1001h DefaultValue: (none) -> 0"]
    );
    assert_eq!(
        differences(&[(
            "ParameterName=Pattern\nDataType=0x0003",
            "ParameterName=Template\nDataType=0x0003"
        )]),
        ["~ 2003h ParameterName: Pattern -> Template"]
    );
    assert_eq!(
        differences(&[("BaudRate_125=1", "BaudRate_125=0")]),
        ["~ [DeviceInfo] BaudRate: 125, 1000 -> 1000  !"]
    );
}

#[test]
fn narrower_limits_break_a_master_and_wider_ones_do_not() {
    let limit = "LowLimit=-5\nHighLimit=200";
    assert_eq!(
        differences(&[(limit, "LowLimit=-4\nHighLimit=200")]),
        ["~ 200Ah:1 LowLimit: -5 -> -4  !"]
    );
    assert_eq!(
        differences(&[(limit, "LowLimit=-5\nHighLimit=201")]),
        ["~ 200Ah:1 HighLimit: 200 -> 201"]
    );
    assert_eq!(
        differences(&[(limit, "LowLimit=-5")]),
        ["~ 200Ah:1 HighLimit: 200 -> (none)"]
    );
}

#[test]
fn what_is_added_and_what_is_gone() {
    let without = SMALL
        .replace("[200B]\n", "[200C]\n")
        .replace("=0x200B", "=0x200C");
    let found = diff(&model(SMALL), &model(&without));
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(
        found,
        [
            "- 200Bh Flag: VAR BOOLEAN const = 1  !",
            "+ 200Ch Flag: VAR BOOLEAN const = 1"
        ]
    );
}

#[test]
fn the_reverse_difference_swaps_both_sides() {
    let other = model(
        &SMALL
            .replace("DefaultValue=022", "DefaultValue=023")
            .replace("ProductNumber=18", "ProductNumber=19"),
    );
    let small = model(SMALL);
    let swapped: Vec<Change> = diff(&other, &small)
        .into_iter()
        .map(|difference| match difference.change {
            Change::Changed { key, before, after } => Change::Changed {
                key,
                before: after,
                after: before,
            },
            Change::Added(what) => Change::Removed(what),
            Change::Removed(what) => Change::Added(what),
        })
        .collect();
    let straight: Vec<Change> = diff(&small, &other).into_iter().map(|d| d.change).collect();
    assert_eq!(swapped, straight);
}

#[test]
fn two_drives() {
    let drive = model(include_str!("../../tests/data/drive.eds"));
    let found: Vec<String> = diff(&model(SMALL), &drive)
        .iter()
        .map(ToString::to_string)
        .collect();
    insta::assert_snapshot!(found.join("\n"));
}

#[test]
fn printing_makes_no_difference() {
    for (file, text) in [
        ("small.eds", SMALL),
        ("axis402.eds", include_str!("../../../eds/axis402.eds")),
        ("lmd.eds", include_str!("../../../products/lmd/lmd.eds")),
        ("every.dcf", include_str!("../../tests/data/every.dcf")),
    ] {
        let model = parse(file, text).unwrap();
        let printed = crate::report::Report::new(file, &crate::print::print(&model)).model;
        assert_eq!(diff(&model, &printed), [], "{file}");
    }
}

#[test]
fn what_a_module_adds_is_part_of_the_device() {
    const COUPLER: &str = include_str!("../../tests/data/coupler.eds");
    let before = model(COUPLER);
    let after = model(&COUPLER.replace("\nCount=1\n", "\nCount=3\n"));
    let differences = diff(&before, &after);
    assert_eq!(differences.len(), 1, "{differences:?}");
    assert!(differences[0].to_string().contains("other content"));
    assert!(diff(&before, &model(COUPLER)).is_empty());
}

#[test]
fn flags_of_an_object_with_sub_indices_are_compared() {
    let flagged = [(
        "ParameterName=Identity object\n",
        "ParameterName=Identity object\nObjFlags=3\n",
    )];
    assert_eq!(differences(&flagged), ["~ 1018h ObjFlags: 0x0 -> 0x3"]);
}

#[test]
fn who_has_a_value_is_a_difference() {
    let given = ("[2006]\n", "[2006]\n;Memory=application\n");
    let found = differences(&[given]);
    assert!(
        found.contains(&"~ 2006h Memory: dictionary -> application".into()),
        "{found:?}"
    );
}
