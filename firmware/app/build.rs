//! Puts the memory layout where the linker looks for it, and makes the object dictionaries from their data sheets.

use std::env;
use std::fs;
use std::path::PathBuf;

use od_gen::Options;

const MEMORY: &str = "../../memory.x";

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy(MEMORY, out.join("memory.x")).expect("memory.x lies in the root of the workspace");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed={MEMORY}");
    println!("cargo:rerun-if-changed=build.rs");

    // The drive, and the device of the benchmarks.
    od_gen::build("../../eds/axis402.eds", "dictionary.rs", Options::DRIVE);
    od_gen::build(
        "../../tests/eds/test-device.eds",
        "test_device.rs",
        Options::DEVICE,
    );
    // The device whose flash is measured.
    od_gen::build(
        "../../tests/eds/basic-device.eds",
        "basic_device.rs",
        Options {
            no_block_transfer: true,
            ..Options::DEVICE
        },
    );
}
