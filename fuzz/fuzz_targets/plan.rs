//! Plans to any goal, within any limits, with any ramps, from any state.
#![no_main]

use fuzz::plan;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| plan::check(bytes));
