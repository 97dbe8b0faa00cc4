//! Makes the data sheet of the generic drive with a servo of its recipe.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // The recipe, and what it is made of.
    println!("cargo::rerun-if-changed=../eds");
    let servo = od_gen::read(Path::new("../eds/servo.toml")).expect("it builds the virtual drive");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::write(out.join("servo.eds"), od_gen::print(&servo)).expect("OUT_DIR can be written");
}
