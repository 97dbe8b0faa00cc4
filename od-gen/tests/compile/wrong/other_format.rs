//! A dictionary of another version of od-gen.

canopen::generated_by!(format 0);

fn main() {}
