//! Makes the object dictionaries of the virtual drives from their data sheets.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for (sheet, dictionary) in [
        ("../eds/axis402.eds", "dictionary.rs"),
        ("../eds/servo.toml", "servo_dictionary.rs"),
    ] {
        od_gen::build(sheet, dictionary, od_gen::Options::DRIVE);
    }
}
