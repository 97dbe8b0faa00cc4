//! A value of another type.

mod dictionary {
    include!("dictionaries/types.rs");
}

fn main() {
    dictionary::Dictionary::new().set_real32(1_i32);
}
