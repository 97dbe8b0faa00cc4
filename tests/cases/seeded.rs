//! Numbers that look random and are the same in every run.

use proptest::test_runner::{RngAlgorithm, TestRng};

/// The generator with this seed.
pub fn generator(seed: u8) -> TestRng {
    TestRng::from_seed(RngAlgorithm::XorShift, &[seed; 16])
}
