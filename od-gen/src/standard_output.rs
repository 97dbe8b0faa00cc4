//! Standard output, for all command lines: one that was closed before the program began (`>&-`) takes nothing.
//!
//! When a program of Rust begins, the null device is opened in the place of a closed standard stream, so that no other file takes its
//! number. From then on all that is written goes nowhere, and nobody is told. So it is looked at before that.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Standard output was closed when the program began.
static WAS_CLOSED: AtomicBool = AtomicBool::new(false);

#[cfg(unix)]
#[ctor::ctor]
fn look() {
    let flags = rustix::io::fcntl_getfd(rustix::stdio::stdout());
    WAS_CLOSED.store(flags.is_err(), Ordering::Relaxed);
}

/// Standard output, locked. Where it was closed every write is an error.
pub fn lock() -> impl Write {
    Output {
        open: (!WAS_CLOSED.load(Ordering::Relaxed)).then(|| io::stdout().lock()),
    }
}

/// Prints the help or the version that clap has in place of a command line.
///
/// # Errors
/// Nobody takes it. A reader that has gone away (`head`) has seen enough.
pub fn help(help: &clap::Error) -> io::Result<()> {
    lock().flush()?;
    let printed = help.print().and_then(|()| io::stdout().flush());
    printed.or_else(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Ok(()),
        _ => Err(error),
    })
}

struct Output {
    open: Option<io::StdoutLock<'static>>,
}

impl Output {
    fn open(&mut self) -> io::Result<&mut io::StdoutLock<'static>> {
        let closed = || io::Error::other("standard output is closed");
        self.open.as_mut().ok_or_else(closed)
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.open()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.open()?.flush()
    }
}
