//! Nobody serves the streamed objects.

mod dictionary {
    include!("dictionaries/types.rs");
}

use dictionary::{Hooked, Hooks};

struct Application;

impl Hooks for Application {}

fn takes<A: canopen::Application<dictionary::Dictionary>>(_: A) {}

fn main() {
    takes(Hooked(Application));
}
