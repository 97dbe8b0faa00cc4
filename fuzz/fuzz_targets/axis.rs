//! An axis under any orders, refills and sizes of its sink.
#![no_main]

use fuzz::axis;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| axis::check(bytes));
