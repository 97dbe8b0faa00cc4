//! Makes the object dictionaries of the virtual drives from their data sheets.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for (sheet, dictionary) in [
        ("../eds/axis402.eds", "dictionary.rs"),
        ("../eds/servo.toml", "servo_dictionary.rs"),
    ] {
        od_gen::build(sheet, dictionary, od_gen::Options::DRIVE);
    }
    // As a data sheet of its own, for the master in this program.
    let servo = od_gen::read(Path::new("../eds/servo.toml")).expect("it was built");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::write(out.join("servo.eds"), od_gen::print(&servo)).expect("OUT_DIR can be written");
}
