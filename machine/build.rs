//! Makes the object dictionary of the drive on the board's model from its data sheet.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    od_gen::build(
        "../eds/axis402.eds",
        "dictionary.rs",
        od_gen::Options::DRIVE,
    );
}
