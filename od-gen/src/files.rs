//! Files, for all command lines: what is read has an end, and what is written is whole or was never there.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;

/// The longest file that is read, in bytes. The longest data sheets on the market have a few.
pub const LIMIT: u64 = 64 << 20;

/// Where the shell puts what is piped in: somebody is at the other end.
const PIPED: [&str; 3] = ["/dev/fd", "/dev/stdin", "/proc/self/fd"];

/// The bytes of a file, or of what is piped in. Any other pipe may never begin, and a device never end.
///
/// # Errors
/// It cannot be read, has more than [`LIMIT`] bytes, or is no file.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let kind = fs::metadata(path)?.file_type();
    let is_piped = PIPED.iter().any(|place| path.starts_with(place));
    if !kind.is_file() && !kind.is_dir() && !is_piped {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no file"));
    }
    File::open(path)?.take(LIMIT + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LIMIT {
        let text = format!("longer than {} MB, the limit", LIMIT >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, text));
    }
    Ok(bytes)
}

/// The text of a file.
///
/// # Errors
/// As [`read`], and if it is no text.
pub fn read_text(path: &Path) -> io::Result<String> {
    let text = String::from_utf8(read(path)?);
    text.map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not a text in UTF-8"))
}

/// Puts bytes in the place of a file. They are written beside it first, so that nobody ever reads half of them, and a full disk
/// leaves what was there. What is no file, such as a pipe, is written to.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let before = match fs::metadata(path) {
        Ok(before) if before.is_file() => before,
        Ok(_) => return fs::write(path, bytes),
        // Half of a new file is of no use to anybody.
        Err(_) => {
            return fs::write(path, bytes)
                .inspect_err(|_| fs::remove_file(path).unwrap_or_default());
        }
    };
    // A link stays one: the file that it leads to is replaced.
    let file = fs::canonicalize(path)?;
    let mut name = OsString::from(".");
    name.push(file.file_name().unwrap_or_default());
    name.push(format!(".{}", std::process::id()));
    let beside = file.with_file_name(name);
    let mut options = OpenOptions::new();
    let mut new = match options.write(true).create_new(true).open(&beside) {
        Ok(new) => new,
        // A folder that takes no new file may have one that can be written.
        Err(_) => return fs::write(&file, bytes),
    };
    let written = new
        .write_all(bytes)
        .and_then(|()| new.set_permissions(before.permissions()))
        .and_then(|()| new.sync_all())
        .and_then(|()| fs::rename(&beside, &file));
    if written.is_err() {
        // What went wrong is the thing to say.
        let _ = fs::remove_file(&beside);
    }
    written
}

/// A file that reaches the limit for files (`ulimit -f`) is an error of the write from now on, as a full disk is, and not the end of the
/// program.
#[cfg(feature = "process")]
pub fn outlive_limit() {
    #[cfg(unix)]
    {
        use signal_hook::consts::SIGXFSZ;
        // Without it, such a write ends the program.
        let _ = signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_never_ends_is_refused() {
        let error = read(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(error.to_string(), "it is no file");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("long");
        File::create(&file).unwrap().set_len(LIMIT + 1).unwrap();
        let error = read(&file).unwrap_err();
        assert_eq!(error.to_string(), "longer than 64 MB, the limit");
    }
}
