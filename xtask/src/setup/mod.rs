//! What the commands need beside Rust, installed where that is allowed. Where it is not, the refusal says exactly what
//! to type.

mod debian;
mod mdbook;
mod node;
mod python;
mod rust;

pub use mdbook::program as mdbook;
pub use node::packages as node_packages;
pub use python::environment as python_environment;
pub use rust::add_target as rust_target;

use std::path::PathBuf;

use anyhow::Result;

/// QEMU's emulator of ARM machines.
pub fn emulator() -> Result<PathBuf> {
    debian::program("qemu-system-arm", &["qemu-system-arm"])
}

/// The browser of the panel's tests.
pub fn browser() -> Result<PathBuf> {
    debian::program("chromium", &["chromium"])
}

/// A C++ compiler, for libFuzzer.
pub fn cxx_compiler() -> Result<PathBuf> {
    debian::program("c++", &["g++"])
}

/// User-mode Linux, with `ip` to set up the virtual CAN interface in it. The reason why it cannot be had is an answer
/// as well: the tests over SocketCAN are then skipped.
pub fn user_mode_linux() -> Result<PathBuf> {
    debian::program("ip", &["iproute2"])?;
    debian::program("linux.uml", &["user-mode-linux"])
}
