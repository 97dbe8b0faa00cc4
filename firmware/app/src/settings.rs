//! What the build fixes of node-ID and bit rate: what the environment variables `AXIS402_NODE_ID` (1 to 127) and `AXIS402_BIT_RATE` (in
//! kbit/s, or `auto`) say while it runs.

use canopen::settings::Wish;

/// What the build fixes.
pub const BUILD: Wish = match Wish::of_build(
    option_env!("AXIS402_NODE_ID"),
    option_env!("AXIS402_BIT_RATE"),
) {
    Some(wish) => wish,
    None => panic!(
        "AXIS402_NODE_ID is 1 to 127, AXIS402_BIT_RATE a bit rate of CiA 301 in kbit/s or auto"
    ),
};
