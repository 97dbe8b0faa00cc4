//! Dictionaries that nobody thought of: any type, access, kind, name, limit and default.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use od_gen::{DataType, parse};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// A value before it has a place.
#[derive(Clone, Debug)]
struct Value {
    name: &'static str,
    data_type: DataType,
    access: &'static str,
    is_mappable: bool,
    default: u64,
    has_limits: bool,
}

/// Names that are hard to make names of Rust of.
const NAMES: [&str; 12] = [
    "Speed",
    "Type",
    "self",
    "set speed",
    "Speed",
    "2nd \"axis\"",
    "check speed",
    "Größe [mm]",
    "fn",
    "A very long name that somebody has found for an object, with all that there is to say about it",
    "match",
    "power on",
];

fn value() -> impl Strategy<Value = Value> {
    let access = prop::sample::select(vec!["ro", "wo", "rw", "rwr", "rww", "const"]);
    (
        prop::sample::select(NAMES.to_vec()),
        prop::sample::select(DataType::ALL.to_vec()),
        access,
        any::<bool>(),
        any::<u64>(),
        any::<bool>(),
    )
        .prop_map(
            |(name, data_type, access, is_mappable, default, has_limits)| Value {
                name,
                data_type,
                access,
                is_mappable,
                default,
                has_limits,
            },
        )
}

fn section(out: &mut String, name: &str, value: &Value) {
    let data_type = value.data_type;
    let _ = writeln!(
        out,
        "[{name}]\nParameterName={}\nDataType={:#06X}",
        value.name,
        data_type.code()
    );
    if data_type == DataType::Domain {
        let access = if value.access == "const" {
            "ro"
        } else {
            value.access
        };
        let _ = writeln!(out, "ObjectType=2\nAccessType={access}\n");
        return;
    }
    let _ = writeln!(out, "AccessType={}", value.access);
    if let Some((low, high)) = data_type.range() {
        let is_time = matches!(data_type, DataType::TimeOfDay | DataType::TimeDifference);
        let default = low + i128::from(value.default) % (high - low + 1);
        let _ = writeln!(out, "DefaultValue={default}");
        if value.has_limits && !is_time && default < i128::from(i64::MAX) {
            let _ = writeln!(out, "LowLimit={low}\nHighLimit={default}");
        }
        let _ = writeln!(
            out,
            "PDOMapping={}",
            u8::from(value.is_mappable && !is_time)
        );
    } else if data_type.is_real() {
        let _ = writeln!(out, "DefaultValue={}.5", value.default % 1000);
    } else if data_type == DataType::VisibleString {
        let _ = writeln!(out, "DefaultValue=quoted \"\\ {}", value.default);
    }
    out.push('\n');
}

/// The data sheet of a device with these objects: variables and records.
fn data_sheet(objects: &[Vec<Value>]) -> String {
    let mut out = include_str!("../data/types.eds")
        .split_once("[2000]")
        .map(|(head, _)| head.to_owned())
        .unwrap();
    for (index, values) in (0x2000..).zip(objects) {
        match values.as_slice() {
            [value] => section(&mut out, &format!("{index:04X}"), value),
            _ => {
                let values = values
                    .iter()
                    .filter(|value| value.data_type != DataType::Domain);
                let values: Vec<&Value> = values.collect();
                let count = values.len();
                let _ = writeln!(
                    out,
                    "[{index:04X}]\nParameterName=Record\nObjectType=9\nSubNumber={}",
                    count + 1
                );
                let _ = writeln!(
                    out,
                    "[{index:04X}sub0]\nParameterName=Highest\nDataType=5\nAccessType=const\nDefaultValue={count}"
                );
                for (sub, value) in (1..).zip(values) {
                    section(&mut out, &format!("{index:04X}sub{sub:X}"), value);
                }
            }
        }
    }
    let _ = writeln!(
        out,
        "[ManufacturerObjects]\nSupportedObjects={}",
        objects.len()
    );
    for (number, index) in (0..objects.len()).map(|at| (at + 1, at + 0x2000)) {
        let _ = writeln!(out, "{number}={index:#06X}");
    }
    out
}

/// Writes some of them, with a program each that walks through the table.
pub(crate) fn write(folder: &Path) {
    let mut runner = TestRunner::deterministic();
    let objects = vec(
        prop_oneof![3 => vec(value(), 1), 1 => vec(value(), 2..6)],
        30..60,
    );
    for number in 0..3 {
        let tree = objects.new_tree(&mut runner).unwrap();
        let text = data_sheet(&tree.current());
        let model = parse("random.eds", &text).unwrap_or_else(|findings| {
            let findings: Vec<String> = findings.iter().map(ToString::to_string).collect();
            panic!("{}\n{text}", findings.join("\n"))
        });
        super::write(folder, &format!("random_{number}"), &model, None);
        let program = PROGRAM.replace("NUMBER", &number.to_string());
        fs::write(folder.join(format!("random_{number}.rs")), program).unwrap();
    }
}

const PROGRAM: &str = r#"//! Every value is where its descriptor says, and loads as its default.
#![deny(warnings)]
#![forbid(unsafe_code)]

mod dictionary {
    include!("dictionaries/random_NUMBER.rs");
}

use canopen::od::{self, Dictionary as _, Location};
use dictionary::Dictionary;

fn main() {
    let mut dictionary = Dictionary::new();
    let before = dictionary.ram().to_vec();
    od::load_defaults(&mut dictionary, 1, 0..=u16::MAX);
    assert_eq!(dictionary.ram(), before, "no $NODEID here");
    let table = Dictionary::TABLE;
    assert!(table.entries.is_sorted_by_key(|entry| entry.key()));
    for entry in table.entries {
        let value = od::value(&dictionary, entry).to_vec();
        match entry.location() {
            Location::Application => assert!(value.is_empty()),
            _ if entry.is_variable() => assert!(value.len() <= usize::from(entry.size())),
            _ => assert_eq!(value.len(), usize::from(entry.size())),
        }
        if entry.location() != Location::Application {
            assert_eq!(od::check(table, entry, &value), Ok(()), "{entry:?}");
        }
        if entry.storage_group().is_some() {
            let Location::Ram(offset) = entry.location() else { panic!("{entry:?}") };
            let range = table.stored(entry.storage_group().unwrap());
            assert!(range.contains(&usize::from(offset)), "{entry:?}");
        }
    }
}
"#;
