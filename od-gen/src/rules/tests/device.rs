//! Data sheets for tests: a device without a flaw, and what is different in it.
//!
//! A difference is a line: `1017 U16 rw 1000` puts an object, `1016:1 U32 rw 0` a sub-index, `map` behind either sets PDOMapping, `=5`
//! ParameterValue, `<=5` HighLimit;
//! `-1017` takes an object away, `1018 ARRAY` changes a kind, `@Granularity=8` a key of DeviceInfo, `&Dummy0005=1` one of
//! DummyUsage. `drive` makes it a drive with the mode profile position, `node 5` a configured device.

use std::collections::BTreeMap;
use std::fmt::Write;

const PLAIN: &[&str] = &[
    "@VendorName=Nobody",
    "@VendorNumber=0x11",
    "@ProductName=Thing",
    "@ProductNumber=0x22",
    "@RevisionNumber=0x00010002",
    "@BaudRate_125=1",
    "@SimpleBootUpMaster=0",
    "@SimpleBootUpSlave=1",
    "@Granularity=8",
    "@DynamicChannelsSupported=0",
    "@CompactPDO=0",
    "@LSS_Supported=1",
    "1000 U32 const 0",
    "1001 U8 ro 0 map",
    "1017 U16 rw 1000",
    "1018:1 U32 ro 0x11",
    "1018:2 U32 ro 0x22",
    "1018:3 U32 ro 0x00010002",
    "1018:4 U32 ro 0",
];

const DRIVE: &[&str] = &[
    "1000 U32 const 0x00040192",
    "6040 U16 rww 0 map",
    "6041 U16 ro 0 map",
    "6060 I8 rww 1 map",
    "6061 I8 ro 1 map",
    "6064 I32 ro 0 map",
    "607A I32 rww 0 map",
    "6081 U32 rw 1000 map",
    "6083 U32 rw 1000 map",
    "6502 U32 ro 1",
];

/// Objects that are an ARRAY where nothing else is said; everything else with sub-indices is a RECORD.
const ARRAYS: &str =
    "1003 1010 1011 1016 1020 1028 1029 1F50 1F51 6046 607B 607D 608F 6091 6092 6099 60E3 60FE";

#[derive(Clone, Default)]
struct Object {
    kind: Option<String>,
    /// The rest of the line by sub-index; VAR has one with the number 0.
    values: BTreeMap<u8, String>,
    is_var: bool,
}

#[derive(Default)]
struct Device {
    info: BTreeMap<String, String>,
    dummies: String,
    node: Option<String>,
    objects: BTreeMap<String, Object>,
}

/// The text of a data sheet.
pub(super) fn data_sheet(differences: &[&str]) -> String {
    let mut device = Device::default();
    for line in PLAIN {
        device.change(line);
    }
    for line in differences {
        match *line {
            "drive" => DRIVE.iter().for_each(|line| device.change(line)),
            line => device.change(line),
        }
    }
    device.print()
}

impl Device {
    fn change(&mut self, line: &str) {
        let (first, rest) = line.split_at(1);
        match first {
            "@" => {
                let (key, value) = rest.split_once('=').unwrap();
                self.info.insert(key.into(), value.into());
            }
            "&" => self.dummies = format!("[DummyUsage]\n{rest}\n"),
            "-" => match rest.split_once(':') {
                Some((index, sub)) => {
                    let sub = u8::from_str_radix(sub, 16).unwrap();
                    let object = self.objects.get_mut(index).unwrap();
                    object.values.remove(&sub).unwrap();
                }
                None => _ = self.objects.remove(rest).unwrap(),
            },
            _ => {
                let (place, rest) = line.split_once(' ').unwrap();
                if place == "node" {
                    self.node = Some(rest.into());
                    return;
                }
                let (index, sub) = place.split_once(':').unwrap_or((place, ""));
                let object = self.objects.entry(index.into()).or_default();
                if matches!(rest, "ARRAY" | "RECORD" | "VAR") {
                    object.kind = Some(rest.into());
                    return;
                }
                object.is_var = sub.is_empty();
                let sub = u8::from_str_radix(sub, 16).unwrap_or(0);
                object.values.insert(sub, rest.into());
            }
        }
    }

    fn print(&self) -> String {
        let mut text = String::from("[FileInfo]\nFileName=test.eds\n");
        text += "\n[DeviceInfo]\n";
        for (key, value) in &self.info {
            writeln!(text, "{key}={value}").unwrap();
        }
        text += &self.dummies;
        if let Some(node) = &self.node {
            writeln!(text, "[DeviceComissioning]\nNodeID={node}\nBaudrate=125").unwrap();
        }
        for (list, is_in) in [
            (
                "MandatoryObjects",
                (|index| matches!(index, "1000" | "1001" | "1018")) as fn(&str) -> bool,
            ),
            ("OptionalObjects", |index| {
                !matches!(index, "1000" | "1001" | "1018") && !is_own(index)
            }),
            ("ManufacturerObjects", is_own),
        ] {
            let objects: Vec<_> = self.objects.keys().filter(|index| is_in(index)).collect();
            writeln!(text, "\n[{list}]\nSupportedObjects={}", objects.len()).unwrap();
            for (number, index) in (1..).zip(objects) {
                writeln!(text, "{number}=0x{index}").unwrap();
            }
        }
        for (index, object) in &self.objects {
            object.print(index, &mut text);
        }
        text
    }
}

fn is_own(index: &str) -> bool {
    matches!(index.as_bytes().first(), Some(b'2'..=b'5'))
}

impl Object {
    fn print(&self, index: &str, text: &mut String) {
        if self.is_var {
            writeln!(text, "\n[{index}]\nParameterName=Object {index}").unwrap();
            self.print_kind("VAR", text);
            print_value(&self.values[&0], text);
            return;
        }
        let mut values = self.values.clone();
        let highest = values.keys().last().copied().unwrap_or(0);
        values
            .entry(0)
            .or_insert_with(|| format!("U8 const {highest}"));
        writeln!(text, "\n[{index}]\nParameterName=Object {index}").unwrap();
        self.print_kind(
            if ARRAYS.contains(index) {
                "ARRAY"
            } else {
                "RECORD"
            },
            text,
        );
        writeln!(text, "SubNumber={}", values.len()).unwrap();
        for (sub, value) in &values {
            writeln!(text, "\n[{index}sub{sub:X}]\nParameterName=Value {sub}").unwrap();
            print_value(value, text);
        }
    }

    fn print_kind(&self, usual: &str, text: &mut String) {
        let code = match self.kind.as_deref().unwrap_or(usual) {
            "ARRAY" => 8,
            "RECORD" => 9,
            _ => 7,
        };
        writeln!(text, "ObjectType=0x{code}").unwrap();
    }
}

fn print_value(value: &str, text: &mut String) {
    let words: Vec<&str> = value.split(' ').collect();
    let code = match words[0] {
        "BOOL" => 0x01,
        "I8" => 0x02,
        "I16" => 0x03,
        "I32" => 0x04,
        "U8" => 0x05,
        "U16" => 0x06,
        "U32" => 0x07,
        "TEXT" => 0x09,
        "DOMAIN" => 0x0F,
        other => panic!("{other}"),
    };
    writeln!(text, "DataType=0x{code:04X}\nAccessType={}", words[1]).unwrap();
    let configured = words.iter().find_map(|word| word.strip_prefix('='));
    let high = words.iter().find_map(|word| word.strip_prefix("<="));
    if let Some(high) = high {
        writeln!(text, "HighLimit={high}").unwrap();
    }
    if let Some(configured) = configured {
        writeln!(text, "ParameterValue={configured}").unwrap();
    }
    if let Some(default) = words.get(2).filter(|word| **word != "map") {
        writeln!(text, "DefaultValue={default}").unwrap();
    }
    let is_mappable = u8::from(words.last() == Some(&"map"));
    writeln!(text, "PDOMapping={is_mappable}").unwrap();
}
