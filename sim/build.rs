//! Makes the object dictionary of the virtual drive from its data sheet, and the names of its objects for traces.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

const DATA_SHEET: &str = "../eds/axis402.eds";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    od_gen::build(DATA_SHEET, "dictionary.rs", od_gen::Options::DRIVE);
    let model = od_gen::read(Path::new(DATA_SHEET)).expect("the data sheet was read a moment ago");
    let mut names = String::from("&[\n");
    for object in &model.objects {
        for entry in &object.entries {
            let name = if object.entries.len() > 1 {
                &entry.name
            } else {
                &object.name
            };
            let name = in_a_sentence(name);
            let signed = entry.data_type.is_signed();
            writeln!(
                names,
                "    ({:#06X}, {}, {name:?}, {signed}),",
                object.index, entry.sub
            )
            .expect("writing to a string");
        }
    }
    names += "]\n";
    let folder = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    fs::write(Path::new(&folder).join("names.rs"), names).expect("OUT_DIR can be written");
}

/// A name as it stands inside a sentence: "Profile velocity" with a small letter, "COB-ID used by SYNC" as it is.
fn in_a_sentence(name: &str) -> String {
    let mut letters = name.chars();
    match (letters.next(), letters.next()) {
        (Some(first), Some(second)) if second.is_lowercase() => {
            first.to_lowercase().chain(name.chars().skip(1)).collect()
        }
        _ => name.to_owned(),
    }
}
