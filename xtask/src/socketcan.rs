//! A real SocketCAN for the tests.
//!
//! Where the kernel has an interface `vcan0`, that one is used. Elsewhere (most containers, most build machines) the
//! tests run in user-mode Linux: a Linux kernel as an ordinary program, which boots in two seconds, needs no rights, and sees the
//! files of the PC as its own. This program itself is its first process there, see [`init`].

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};

use crate::words::{one_line, say};
use crate::{place, process, setup};

/// The interface on which the tests run.
const INTERFACE: &str = "vcan0";

/// Where the tests can run.
#[derive(Debug)]
pub enum Socketcan {
    /// In this kernel.
    Here,
    /// In user-mode Linux.
    UserMode(PathBuf),
}

impl Socketcan {
    /// Finds a SocketCAN.
    ///
    /// # Errors
    /// When there is none, and user-mode Linux cannot be installed.
    pub fn find() -> Result<Self> {
        if Path::new("/sys/class/net").join(INTERFACE).exists() {
            return Ok(Self::Here);
        }
        if !cfg!(target_os = "linux") {
            anyhow::bail!("SocketCAN is Linux's");
        }
        setup::user_mode_linux()
            .map(Self::UserMode)
            .context("this kernel has no interface vcan0")
    }
}

/// Names the folder of the job to the first process inside: its file `command` says what to run, one word a line, and
/// its file `status` gets the exit code. Arguments would not do: the kernel adds its own words to them.
const JOB: &str = "AXIS402_SOCKETCAN_JOB";

/// Runs `command` where [`INTERFACE`] is up, and gives each line of its output to `take`, which shows it. True when it succeeded.
///
/// # Errors
/// When user-mode Linux cannot be started.
pub fn run(
    socketcan: &Socketcan,
    command: &mut Command,
    take: impl FnMut(&str) -> Result<()>,
) -> Result<bool> {
    match socketcan {
        Socketcan::Here => Ok(process::stream(command, take)?.success()),
        Socketcan::UserMode(kernel) => run_inside(kernel, command, take),
    }
}

fn run_inside(
    kernel: &Path,
    command: &Command,
    take: impl FnMut(&str) -> Result<()>,
) -> Result<bool> {
    let job =
        tempfile::tempdir_in(place::target()).context("making a folder for user-mode Linux")?;
    // In a file, because a kernel's command line is short and knows no quotes.
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    fs::write(job.path().join("command"), words.join("\n"))
        .context("writing the command for user-mode Linux")?;

    // Not the file that is running: building the tests may have put a newer one in its place.
    let own = place::kept("xtask");
    let mut machine = Command::new(kernel);
    machine.args([
        "mem=1G",
        "root=/dev/root",
        "rootfstype=hostfs",
        "rootflags=/",
        "rw",
    ]);
    machine.args(["con=null", "con0=null,fd:1", "quiet", "loglevel=1"]);
    // What the kernel does not know becomes the environment and the arguments of its first process.
    machine.arg(format!("init={}", own.display()));
    machine
        .arg(format!("{JOB}={}", job.path().display()))
        .arg("socketcan-init");
    // The memory of the machine is a sparse file in TMPDIR; /dev/shm is too small for it in many containers. HOME gets its
    // control socket.
    machine
        .env("TMPDIR", job.path())
        .env("HOME", job.path())
        .stdin(std::process::Stdio::null());
    process::stream(&mut machine, take)?;
    // Its exit status is 0 whatever happened inside.
    Ok(fs::read_to_string(job.path().join("status")).is_ok_and(|code| code == "0"))
}

/// The first process inside user-mode Linux: brings the interface up, runs the command, leaves its exit code in a file, and
/// switches the machine off.
///
/// # Errors
/// When something cannot be set up. The machine is switched off all the same.
#[cfg(target_os = "linux")]
pub fn init() -> Result<ExitCode> {
    let result = inside::run();
    if let Err(error) = &result {
        // The machine is switched off whatever becomes of the words.
        let _ = say!("user-mode Linux: {}", one_line(error));
    }
    inside::switch_off()?;
    result
}

/// There is no user-mode Linux elsewhere.
#[cfg(not(target_os = "linux"))]
pub fn init() -> Result<ExitCode> {
    anyhow::bail!("SocketCAN is Linux's")
}

#[cfg(target_os = "linux")]
mod inside {
    use std::fs::{self, File};
    use std::path::{Path, PathBuf};
    use std::process::{Command, ExitCode};

    use anyhow::{Context, Result, ensure};
    use rustix::mount::{MountFlags, mount};
    use rustix::system::{RebootCommand, finit_module, reboot};

    use super::{INTERFACE, JOB};
    use crate::{place, process};

    /// The modules of the kernel that SocketCAN needs, in the order of their dependence.
    const MODULES: [&str; 4] = [
        "drivers/net/can/dev/can-dev.ko",
        "net/can/can.ko",
        "net/can/can-raw.ko",
        "drivers/net/can/vcan.ko",
    ];

    pub fn run() -> Result<ExitCode> {
        for (kind, at) in [("proc", "/proc"), ("sysfs", "/sys"), ("tmpfs", "/run")] {
            mount(kind, at, kind, MountFlags::empty(), None)
                .with_context(|| format!("mounting {at}"))?;
        }
        let release = fs::read_to_string("/proc/sys/kernel/osrelease")
            .context("asking for the kernel's release")?;
        let modules = Path::new("/usr/lib/uml/modules")
            .join(release.trim())
            .join("kernel");
        for module in MODULES {
            let path = modules.join(module);
            let file = File::open(&path).with_context(|| format!("opening {}", path.display()))?;
            finit_module(file, c"", 0).with_context(|| format!("loading {}", path.display()))?;
        }
        ip(&["link", "set", "lo", "up"])?;
        ip(&["link", "add", "dev", INTERFACE, "type", "vcan"])?;
        ip(&["link", "set", INTERFACE, "up"])?;

        let job = std::env::var_os(JOB).map(PathBuf::from).context("no job")?;
        let words = fs::read_to_string(job.join("command")).context("reading the command")?;
        let mut words = words.lines();
        let mut command = Command::new(words.next().context("no command")?);
        command
            .args(words)
            .current_dir(place::root())
            .env("PATH", PATH);
        let status = process::run(&mut command)?;
        let code = status.code().unwrap_or(1);
        fs::write(job.join("status"), code.to_string()).context("writing the exit code")?;
        Ok(if status.success() {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        })
    }

    /// A first process gets no search path from its kernel.
    const PATH: &str = "/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin";

    fn ip(words: &[&str]) -> Result<()> {
        let mut command = Command::new("ip");
        command.args(words).env("PATH", PATH);
        ensure!(
            process::run(&mut command)?.success(),
            "`{}` failed",
            process::line(&command)
        );
        Ok(())
    }

    pub fn switch_off() -> Result<()> {
        reboot(RebootCommand::PowerOff).context("switching off")
    }
}
