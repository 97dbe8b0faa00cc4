//! What the manuals promise (`products/NAME/capabilities.csv`): for each the test that shows it, or the reason why none does.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use sim::products::Product;

/// All that the four manuals promise.
const PROMISED: usize = 861;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The names of all functions in the Rust and Python files below.
fn functions(folder: &Path, found: &mut HashSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            functions(&path, found);
        } else if name.ends_with(".rs") || name.ends_with(".py") {
            let text = fs::read_to_string(&path).unwrap();
            for mark in ["fn ", "def "] {
                for rest in text.split(mark).skip(1) {
                    let is_name = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
                    found.insert(rest.chars().take_while(|letter| is_name(*letter)).collect());
                }
            }
        }
    }
}

/// Each row has a test that is there, or a reason; and how many have a test.
#[test]
fn every_capability_has_its_test_or_its_reason() {
    let mut known = HashSet::new();
    for folder in ["tests", "products", "firmware", "sim", "master"] {
        functions(&root().join(folder), &mut known);
    }
    let (mut all, mut shown) = (0, 0);
    for product in Product::names() {
        let path = root().join(format!("products/{product}/capabilities.csv"));
        let mut rows = csv::Reader::from_path(&path).unwrap();
        let (mut own, mut here) = (0, 0);
        for row in rows.records() {
            let row = row.unwrap();
            let (number, test, reason) = (&row[0], &row[3], &row[4]);
            let is_there = known.contains(test) || root().join(test).is_file();
            assert!(
                test.is_empty() != reason.is_empty(),
                "{product} {number}: a test or a reason"
            );
            assert!(test.is_empty() || is_there, "{product} {number}: no {test}");
            own += 1;
            here += usize::from(!test.is_empty());
        }
        println!("{product}: {here} of {own} capabilities are shown");
        (all, shown) = (all + own, shown + here);
    }
    println!("{shown} of {all}");
    assert_eq!(all, PROMISED);
}
