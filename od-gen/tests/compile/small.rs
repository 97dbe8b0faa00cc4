//! A dictionary with few objects of each kind: no warning, whatever is in it.
#![deny(warnings)]
#![forbid(unsafe_code)]

mod dictionary {
    include!("dictionaries/small.rs");
}

struct Nothing;

impl dictionary::Hooks for Nothing {}

fn main() {
    let mut dictionary = dictionary::Dictionary::default();
    let mut application = dictionary::Hooked(Nothing);
    let entry = canopen::od::find::<dictionary::Dictionary>(0x2000, 0).unwrap();
    let checked = canopen::Application::validate(&mut application, &dictionary, entry, &[0]);
    assert_eq!(checked, Ok(()));
    canopen::Application::written(&mut application, &mut dictionary, entry);
}
