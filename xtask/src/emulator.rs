//! QEMU's machine `mps2-an386` with the firmware in it.
//!
//! The clock of the machine is the count of its instructions (`-icount`), so that steps and control ticks are exact in
//! virtual time; `align=on` keeps virtual time beside real time, which a CANopen master on the PC needs. CAN frames
//! travel as SLCAN over UART0, which QEMU serves on TCP. `nodelay` and `mux` make that link quick: without them an
//! answer takes 44 ms, and a byte 50 µs instead of 15.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use anyhow::{Context, Result};

use crate::words::tell;
use crate::{place, process};

/// A running emulator. It ends when this value is dropped.
pub struct Emulator {
    child: Child,
}

impl Emulator {
    /// Runs an image in real time, its CAN bus served as SLCAN on TCP at `address`. The parameter store of the image is
    /// a file in the folder `store`.
    ///
    /// # Errors
    /// When QEMU cannot be started.
    pub fn serve(qemu: &Path, image: &Path, address: SocketAddr, store: &Path) -> Result<Self> {
        let mut command = machine(qemu, image);
        command.args(["-icount", "shift=4,align=on"]);
        command.arg("-chardev").arg(format!(
            "socket,id=slcan,host={},port={},server=on,wait=off,nodelay=on,mux=on",
            address.ip(),
            address.port()
        ));
        command.args(["-serial", "chardev:slcan"]);
        command.current_dir(store);
        let mut child = command
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("starting {}", qemu.display()))?;
        if let Some(output) = child.stdout.take() {
            std::thread::spawn(move || process::each_line(output, pass_on));
        }
        Ok(Self { child })
    }

    /// The exit status, once QEMU has ended by itself.
    ///
    /// # Errors
    /// When the operating system does not tell.
    pub fn ended(&mut self) -> Result<Option<ExitStatus>> {
        self.child.try_wait().context("waiting for QEMU")
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both fail only when it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The command that runs an image which needs nothing from outside, 256 ns of virtual time per instruction, as
/// fast as the PC can: the same counts on every run.
pub fn counting(qemu: &Path, image: &Path) -> Command {
    let mut command = machine(qemu, image);
    command.args(["-icount", "shift=8", "-serial", "null"]);
    command
}

/// The machine, with the image loaded and semihosting, by which the image reaches files in the emulator's folder.
fn machine(qemu: &Path, image: &Path) -> Command {
    let mut command = dying_with_parent(qemu);
    command.args([
        "-machine",
        "mps2-an386",
        "-nographic",
        "-monitor",
        "none",
        "-no-reboot",
    ]);
    command.args(["-semihosting-config", "enable=on,target=native"]);
    command.arg("-kernel").arg(image).stdin(Stdio::null());
    command
}

/// No emulator stays behind when this program is killed without a chance to end it; `setpriv` is part of every Debian.
fn dying_with_parent(qemu: &Path) -> Command {
    match place::program("setpriv") {
        Some(setpriv) => {
            let mut command = Command::new(setpriv);
            command
                .args(["--pdeathsig", "KILL"])
                .arg(PathBuf::from(qemu));
            command
        }
        None => Command::new(qemu),
    }
}

/// Shows a line that QEMU or the firmware wrote. The words about a machine that is a little late are left out: they are
/// normal on a busy PC, and there are many of them.
fn pass_on(line: &str) {
    if !line.starts_with("Warning: The guest is ") && !line.is_empty() {
        tell!("{line}");
    }
}
