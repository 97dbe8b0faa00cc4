//! Makes a dictionary of every data sheet but that of the generic drive, with the bindings beside it.

use od_gen::Options;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    for name in ["compact", "lmd", "nanotec", "s200", "tc1"] {
        od_gen::build(
            format!("../../eds/{name}.eds"),
            &format!("{name}.rs"),
            Options::DRIVE,
        );
    }
}
