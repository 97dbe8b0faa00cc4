//! A constant has no setter.

mod dictionary {
    include!("dictionaries/types.rs");
}

fn main() {
    dictionary::Dictionary::new().set_constant_24(1);
}
