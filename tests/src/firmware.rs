//! What a plain device has around its node: an application of its own objects.

use canopen::Application;

use crate::test_device::Dictionary;

/// The application of the test device.
#[derive(Clone, Debug, Default)]
pub struct Firmware {}

impl Application<Dictionary> for Firmware {}
