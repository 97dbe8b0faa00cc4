//! A hook with another type than its object.

mod dictionary {
    include!("dictionaries/small.rs");
}

use canopen::cia301::sdo::AbortCode;
use dictionary::{Dictionary, Hooks};

struct Application;

impl Hooks for Application {
    fn check_type_2000(&mut self, _: &Dictionary, value: u8) -> Result<(), AbortCode> {
        let _ = value;
        Ok(())
    }
}

fn main() {}
