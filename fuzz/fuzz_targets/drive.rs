//! The whole virtual drive: any frames, settings and time, then a stop.
#![no_main]

use fuzz::any_drive;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| any_drive::check(bytes));
