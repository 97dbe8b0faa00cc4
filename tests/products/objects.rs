//! Every object of every manual's table on the running drive: that it is there, its default, its access, its limits, whether a PDO may carry it,
//! and the abort codes of what it refuses.
//!
//! The table is `products/NAME/objects.csv` with what `chosen.csv` adds. What a running drive shows in an object, and what it
//! refuses for a reason of its own, is in [`SHOWN`] and [`REFUSED`].

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::bench::Bench;

const NODE: u8 = 4;

const OK: u32 = 0;
const READ_ONLY: u32 = 0x0601_0002;
const WRITE_ONLY: u32 = 0x0601_0001;
const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUB: u32 = 0x0609_0011;
const NOT_MAPPABLE: u32 = 0x0604_0041;
const TOO_HIGH: u32 = 0x0609_0031;
const TOO_LOW: u32 = 0x0609_0032;
const INVALID: u32 = 0x0609_0030;
const TYPE_LENGTH: [u32; 3] = [0x0607_0010, 0x0607_0012, 0x0607_0013];

/// One row of the table.
struct Row {
    index: u16,
    sub: u8,
    size: u8,
    is_signed: bool,
    is_string: bool,
    access: String,
    mappable: String,
    default: Option<i64>,
    low: Option<i64>,
    high: Option<i64>,
}

/// A number as the tables write it, with the node-ID where it says so.
fn number(text: &str) -> Option<i64> {
    let adds = text.contains("NODEID") || text.to_lowercase().contains("node");
    let rest: String = text
        .replace("$NODEID", "")
        .replace("node-ID", "")
        .replace("node ID", "")
        .chars()
        .filter(|letter| !letter.is_whitespace() && *letter != '+')
        .collect();
    let parse = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    };
    let value = parse(&rest)?;
    Some(value + if adds { i64::from(NODE) } else { 0 })
}

fn rows(product: &str) -> Vec<Row> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../products/{product}"));
    let mut table: BTreeMap<(u16, u8), Vec<String>> = BTreeMap::new();
    for file in ["objects.csv", "chosen.csv"] {
        let path = folder.join(file);
        if !fs::exists(&path).unwrap() {
            continue;
        }
        for row in csv::Reader::from_path(path).unwrap().records() {
            let row: Vec<String> = row.unwrap().iter().map(str::to_owned).collect();
            let key = (
                number(&row[0]).unwrap() as u16,
                number(&row[1]).unwrap() as u8,
            );
            let own = table.entry(key).or_insert_with(|| row.clone());
            for (own, cell) in own.iter_mut().zip(&row) {
                if !cell.is_empty() {
                    own.clone_from(cell);
                }
            }
        }
    }
    let row = |((index, sub), row): ((u16, u8), Vec<String>)| {
        let (size, is_signed) = match row[4].as_str() {
            "INTEGER8" => (1, true),
            "INTEGER16" => (2, true),
            "INTEGER32" => (4, true),
            "UNSIGNED16" => (2, false),
            "UNSIGNED32" => (4, false),
            _ => (1, false),
        };
        Row {
            index,
            sub,
            size,
            is_signed,
            is_string: matches!(
                row[4].as_str(),
                "VISIBLE_STRING" | "OCTET_STRING" | "DOMAIN"
            ),
            access: row[5].clone(),
            mappable: row[6].clone(),
            default: number(&row[7]),
            low: number(&row[8]),
            high: number(&row[9]),
        }
    };
    table.into_iter().map(row).collect()
}

impl Row {
    fn name(&self) -> String {
        format!("{:04X}h:{}", self.index, self.sub)
    }

    /// The numbers that its type has.
    fn range(&self) -> (i64, i64) {
        let bits = 8 * u32::from(self.size);
        match self.is_signed {
            true => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
            false => (0, (1 << bits) - 1),
        }
    }

    /// Its bytes as the number that they mean; a default may be a pattern of bits.
    fn meant(&self, bytes: u32) -> i64 {
        let above = 32 - 8 * u32::from(self.size);
        match self.is_signed {
            true => i64::from((bytes << above).cast_signed() >> above),
            false => i64::from(bytes << above >> above),
        }
    }
}

/// What the drive answers to an upload: the number, or the abort code.
fn upload(bench: &mut Bench, row: &Row) -> Result<Option<i64>, u32> {
    let [low, high] = row.index.to_le_bytes();
    let answer = bench.sdo(NODE, [0x40, low, high, row.sub, 0, 0, 0, 0]);
    let word = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]);
    match answer[0] {
        0x80 => Err(word),
        0x41 => {
            // A long string: it is not looked at further.
            let abort = [0x80, low, high, row.sub, 0, 0, 0, 8];
            bench.send(&canopen::Frame::full(0x600 + u16::from(NODE), abort));
            Ok(None)
        }
        command => {
            let size = 4 - (command >> 2 & 3);
            assert!(
                row.is_string || size == row.size,
                "{}: {size} bytes",
                row.name()
            );
            Ok(Some(row.meant(word)).filter(|_| !row.is_string))
        }
    }
}

/// The abort code of a download of so many bytes; 0 if it is taken.
fn download(bench: &mut Bench, (index, sub): (u16, u8), size: u8, value: i64) -> u32 {
    let [low, high] = index.to_le_bytes();
    let mut request = [0x23 | ((4 - size) << 2), low, high, sub, 0, 0, 0, 0];
    for (place, byte) in request[4..].iter_mut().zip(value.to_le_bytes()) {
        *place = byte;
    }
    for byte in &mut request[4 + usize::from(size)..] {
        *byte = 0;
    }
    match bench.sdo(NODE, request) {
        [0x60, ..] => OK,
        [0x80, _, _, _, a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        other => panic!("{index:04X}h:{sub}: {other:02X?}"),
    }
}

/// Objects in which a running drive shows something else than the default of the table, and why.
const SHOWN: &[(&str, u16, &str)] = &[
    ("lmd", 0x2402, "the manual counts 8, 4 and 3 of three words"),
    ("nanotec", 0x2009, "the node-ID that is stored"),
    ("s200", 0x6041, "the drive has booted and has its supply"),
    ("tc1", 0x1013, "a clock that counts"),
    ("s200", 0x608D, "ACCUNIT is what the manual recommends"),
    ("s200", 0x608E, "ACCUNIT is what the manual recommends"),
    ("s200", 0x6098, "NREF says it too, and was written before"),
];

/// Objects that refuse to be written with what they hold, and why.
const REFUSED: &[(&str, u16, &str)] = &[
    ("", 0x1800, "CiA 301 has no sub-index 4"),
    ("", 0x1801, "CiA 301 has no sub-index 4"),
    ("", 0x1802, "CiA 301 has no sub-index 4"),
    ("", 0x1803, "CiA 301 has no sub-index 4"),
    ("", 0x60C2, "a period of 0 is none"),
    (
        "s200",
        0x100E,
        "the identifier of the error control is that of the node",
    ),
    ("s200", 0x2083, "its signature is needed"),
    ("s200", 0x358D, "homing needs a motor that is on"),
    ("s200", 0x3591, "jog needs a motor that is on"),
    ("s200", 0x35F0, "a reference needs a motor that is on"),
    ("s200", 0x3642, "a motion task needs a motor that is on"),
    ("s200", 0x4000, "it is busy with the command before"),
    ("s200", 0x6090, "0 revolutions are no ratio"),
    (
        "s200",
        0x6096,
        "the manual tells rw, and shows what the units make of it",
    ),
];

fn is_listed(list: &[(&str, u16, &str)], product: &str, index: u16) -> bool {
    let is_own = |own: &(&str, u16, &str)| (own.0.is_empty() || own.0 == product) && own.1 == index;
    list.iter().any(is_own)
}

/// What is wrong with the objects of a product.
fn look(product: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut bench = Bench::node(product, NODE);
    let (mut defaults, mut accesses, mut limits) = (0, 0, 0);
    for row in rows(product) {
        let mut say = |what: String| wrong.push(format!("{}: {what}", row.name()));
        let came = upload(&mut bench, &row);
        if row.index < 0x1000 || row.access == "none" {
            if !matches!(came, Err(NO_OBJECT | NO_SUB)) {
                say(format!("is there: {came:08X?}"));
            }
            continue;
        }
        let value = match (row.access.as_str(), came) {
            ("wo", Err(WRITE_ONLY)) => 0,
            ("wo", other) => {
                say(format!("write only, and {other:08X?} is read"));
                continue;
            }
            // The history has no more errors than have been.
            (_, Err(0x0800_0024)) if row.index == 0x1003 => continue,
            (_, Err(code)) => {
                say(format!("{code:08X} when read"));
                continue;
            }
            (_, Ok(None)) => continue,
            (_, Ok(Some(value))) => value,
        };
        accesses += 1;
        let is_command = matches!(row.index, 0x1010 | 0x1011);
        if let Some(default) = row.default
            && row.access != "wo"
            && !is_listed(SHOWN, product, row.index)
        {
            defaults += 1;
            let default = row.meant(default as u32);
            if default != value {
                say(format!("{value}, and not {default}"));
            }
        }
        // A mapping is written while its PDO is not in use: below.
        if matches!(row.index >> 8, 0x16 | 0x1A) && row.access != "ro" {
            continue;
        }
        let answer = download(&mut bench, (row.index, row.sub), row.size, value);
        if matches!(row.access.as_str(), "ro" | "const") {
            if answer != READ_ONLY {
                say(format!("{answer:08X} when written, though it is only read"));
            }
            continue;
        }
        if is_command {
            continue;
        }
        if answer != OK {
            if !is_listed(REFUSED, product, row.index) {
                say(format!("{answer:08X} when {value} is written"));
            }
            continue;
        }
        // Another length.
        // A Nanotec takes one as its own size.
        if row.size > 1 && product != "nanotec" {
            let answer = download(&mut bench, (row.index, row.sub), row.size - 1, value);
            if !TYPE_LENGTH.contains(&answer) {
                say(format!("{answer:08X} for a number that is too short"));
            }
        }
        let (least, most) = row.range();
        for (limit, outside, code) in [
            (row.low, row.low.map(|low| low - 1), TOO_LOW),
            (row.high, row.high.map(|high| high + 1), TOO_HIGH),
        ] {
            let Some((limit, outside)) = limit.zip(outside) else {
                continue;
            };
            // A limit that the default breaks is none.
            if !(least..=most).contains(&outside) || row.default.is_some_and(|own| own == outside) {
                continue;
            }
            limits += 1;
            let answer = download(&mut bench, (row.index, row.sub), row.size, outside);
            if answer != code && answer != INVALID {
                say(format!("{answer:08X} for {outside}, outside {limit}"));
            }
        }
    }
    println!("{product}: {accesses} accesses, {defaults} defaults, {limits} limits");
    wrong
}

/// Whether a PDO may carry each object.
fn map(product: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut bench = Bench::node(product, NODE);
    // Neither is in use, and nothing is mapped.
    for (index, cob_id) in [(0x1403, 0x8000_0504_u32), (0x1803, 0xC000_0484)] {
        bench.write(NODE, index, 1, &cob_id.to_le_bytes());
        bench.write(NODE, index + 0x200, 0, &[0]);
    }
    let mut count = 0;
    for row in rows(product) {
        let has = |index: u16| {
            let told = row.mappable.as_str();
            match told {
                "no" => Some(false),
                "rx" => Some(index == 0x1603),
                "tx" => Some(index == 0x1A03),
                _ => None,
            }
        };
        for index in [0x1603, 0x1A03] {
            let Some(is_mappable) = has(index) else {
                continue;
            };
            // The drive has no dummy of 32 bits that is a REAL.
            if row.index == 8 || row.is_string || row.access == "none" && row.index >= 0x1000 {
                continue;
            }
            let bits = match row.index {
                1 => 1,
                _ => u32::from(row.size) * 8,
            };
            let entry = u32::from(row.index) << 16 | u32::from(row.sub) << 8 | bits;
            let answer = download(&mut bench, (index, 1), 4, entry.into());
            count += 1;
            let is_right = match is_mappable {
                true => answer == OK,
                false => answer == NOT_MAPPABLE || row.index < 0x1000 && answer == NO_OBJECT,
            };
            // The generic drive maps what can be mapped both ways; a manual that tells one of them has the other by silence.
            if !(is_right || answer == OK && row.mappable != "no") {
                wrong.push(format!(
                    "{}: {answer:08X} in {index:04X}h, told {}",
                    row.name(),
                    row.mappable
                ));
            }
        }
    }
    println!("{product}: {count} mappings");
    wrong
}

/// Each channel of the S200 has its limits, its default, its format and its attributes, and they are those of its number.
#[test]
fn the_channels_of_the_s200_describe_their_numbers() {
    let mut bench = Bench::node("s200", NODE);
    let mut channels = 0;
    let mut last = 0;
    for row in rows("s200") {
        // Of what the manual only names there is the value alone.
        let is_chosen =
            (0x36F5..0x3755).contains(&row.index) && !(0x3723..0x3725).contains(&row.index);
        if row.sub != 1 || !(0x3500..0x3CD0).contains(&row.index) || is_chosen {
            continue;
        }
        let name = row.name();
        let [low, high, default, format, attributes] =
            [2, 3, 4, 5, 6].map(|sub| bench.read(NODE, row.index, sub));
        assert_eq!(format, if row.is_signed { 5 } else { 4 }, "{name}");
        let (least, most) = row.range();
        let limits = (row.low.unwrap_or(least), row.high.unwrap_or(most));
        assert_eq!((low, high), (limits.0 as u32, limits.1 as u32), "{name}");
        let own = row.default.unwrap_or(0.clamp(limits.0, limits.1));
        assert_eq!(default, own as u32, "{name}");
        assert_eq!(attributes & 0x08 != 0, row.access == "ro", "{name}");
        assert_eq!(attributes & 0x40 != 0, row.access == "wo", "{name}");
        (channels, last) = (channels + 1, row.index);
    }
    assert_eq!(channels, 232);
    let reach = bench.read(NODE, 0x3500, 1);
    assert_eq!(reach, 0x3CCF - 0x3500);
    assert!(u32::from(last) <= 0x3500 + reach);
}

macro_rules! objects {
    ($($product:ident)*) => {$(
        mod $product {
            #[test]
            fn its_objects_are_those_of_its_manual() {
                let wrong = super::look(stringify!($product));
                assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
            }

            #[test]
            fn its_pdos_carry_what_its_manual_tells() {
                let wrong = super::map(stringify!($product));
                assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
            }
        }
    )*};
}

objects! { lmd nanotec s200 tc1 }
