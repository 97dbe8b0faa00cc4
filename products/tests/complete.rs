//! Nothing that a manual lists is missing in the data sheet that was made of it.

use std::fs::File;
use std::path::Path;

use canopen::od::{Dictionary, Table};

/// A number as the tables write it.
fn number(text: &str) -> u16 {
    match text.strip_prefix("0x") {
        Some(digits) => u16::from_str_radix(digits, 16).unwrap(),
        None => text.parse().unwrap(),
    }
}

/// Every row of the table, but dummies and what the manual gives no access to, is an entry of the dictionary.
fn is_complete(name: &str, table: &Table, least: usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("{name}/objects.csv"));
    let mut rows = csv::Reader::from_reader(File::open(path).unwrap());
    let mut count = 0;
    for row in rows.records() {
        let row = row.unwrap();
        let (index, sub) = (number(&row[0]), number(&row[1]) as u8);
        if index < 0x1000 || &row[5] == "none" {
            continue;
        }
        let entry = table.find(index, sub);
        assert!(entry.is_ok(), "{name}: {index:04X}h:{sub} is missing");
        count += 1;
    }
    assert!(count >= least, "{name}: only {count} rows");
}

#[test]
fn lmd_is_complete() {
    is_complete("lmd", products::lmd::Dictionary::TABLE, 320);
}

#[test]
fn nanotec_is_complete() {
    is_complete("nanotec", products::nanotec::Dictionary::TABLE, 310);
}

#[test]
fn s200_is_complete() {
    is_complete("s200", products::s200::Dictionary::TABLE, 2090);
}

#[test]
fn tc1_is_complete() {
    is_complete("tc1", products::tc1::Dictionary::TABLE, 130);
}

/// The names of the S200's text interface are those of its parameters, and that of ICMDVLIM, which has no object in the manual.
#[test]
fn names_of_the_s200_are_those_of_its_table() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("s200");
    let mut rows = csv::Reader::from_reader(File::open(folder.join("objects.csv")).unwrap());
    let rows = rows.records().map(Result::unwrap);
    let told = rows.filter(|row| (0x3500..0x3CD0).contains(&number(&row[0])) && &row[1] == "1");
    let told = told.map(|row| format!("{} {}\n", &row[0][2..], row[2].split(':').next().unwrap()));
    let names = std::fs::read_to_string(folder.join("names.txt")).unwrap();
    assert_eq!(names, told.collect::<String>() + "510C ICMDVLIM\n");
}
