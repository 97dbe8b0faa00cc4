//! 6040h of the data sheet is an UNSIGNED32: the firmware does not take it.

mod dictionary {
    include!("dictionaries/wide_controlword.rs");
}

fn main() {
    let _ = dictionary::Dictionary::new();
}
