//! Puts the memory layout where the linker looks for it, and makes the object dictionaries from their data sheets.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use od_gen::{BindingReport, Options};

/// The root of the workspace.
const ROOT: &str = "../..";

/// The data sheet of the drive, from the root of the workspace, if it is to be another one than that of its kind.
const CHOICE: &str = "AXIS402_EDS";

/// Those of a step driver, and of a servo.
const STEPPER: &str = "eds/axis402.eds";
const SERVO: &str = "eds/servo.toml";

/// Positions in a turn of a product, whose objects are not set to the encoder of a board.
fn positions(data_sheet: &Path) -> Option<u32> {
    let model = od_gen::read(data_sheet).ok()?;
    let bindings = BindingReport::beside(data_sheet, &model).ok()??.bindings;
    let of = |name| bindings.initial(&model, name);
    let turns = of("position_encoder_revolutions").unwrap_or(1).max(1);
    u32::try_from(of("position_encoder_increments")? / turns).ok()
}

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let has = |feature: &str| env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    // The names of the interrupts, where no peripheral access crate brings them along.
    let (chip, scripts): (_, &[_]) = if has("STM32F4") {
        ("chip", &["memory.x"])
    } else {
        ("qemu", &["memory.x", "device.x"])
    };
    for script in scripts {
        let from = format!("src/board/{chip}/{script}");
        fs::copy(&from, out.join(script)).expect("each chip has its memory layout");
        println!("cargo:rerun-if-changed={from}");
    }
    println!("cargo:rustc-link-search={}", out.display());
    // Functions that come out alike are one.
    println!("cargo:rustc-link-arg=--icf=all");
    println!("cargo:rerun-if-changed=build.rs");
    if !has("RTT") {
        // Nobody would read them.
        println!("cargo:rustc-env=DEFMT_LOG=off");
    }

    // The drive, and the device of the benchmarks.
    println!("cargo:rerun-if-env-changed={CHOICE}");
    let own = if has("ODRIVE36") || has("STEPPER405") {
        SERVO
    } else {
        STEPPER
    };
    let data_sheet = env::var_os(CHOICE).unwrap_or_else(|| own.into());
    let data_sheet = Path::new(ROOT).join(data_sheet);
    let positions = format!("{:?}", positions(&data_sheet));
    fs::write(out.join("positions.rs"), positions).expect("OUT_DIR can be written");
    od_gen::build(
        data_sheet,
        "dictionary.rs",
        Options {
            no_block_transfer: !has("BLOCK_TRANSFER"),
            ..Options::DRIVE
        },
    );
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
