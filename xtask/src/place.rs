//! Where things are: the repository, its build folder, the programs in `PATH`.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The root of the repository.
pub fn root() -> PathBuf {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest).to_path_buf()
}

/// The build folder: the one in which cargo put this very program (it marks the folder with `CACHEDIR.TAG`), so that
/// every way to move it away from `target` is respected.
pub fn target() -> PathBuf {
    env::current_exe()
        .ok()
        .and_then(|exe| {
            let marked = |folder: &&Path| folder.join("CACHEDIR.TAG").is_file();
            exe.ancestors().find(marked).map(Path::to_path_buf)
        })
        .unwrap_or_else(|| root().join("target"))
}

/// A program of the host that cargo built in the dev profile, beside this one.
pub fn built(name: &str) -> PathBuf {
    let folder = env::current_exe()
        .ok()
        .and_then(|exe| exe.parent().map(Path::to_path_buf));
    folder.unwrap_or_else(|| target().join("debug")).join(name)
}

/// A copy of such a program, which stays as it is while cargo builds it anew. All lie in one folder, as some look for others beside them.
pub fn kept(name: &str) -> PathBuf {
    let name = Path::new(name).file_name().unwrap_or_default();
    target().join("xtask").join("programs").join(name)
}

/// Cargo, in the root of the repository: the one that started this program.
pub fn cargo() -> Command {
    let program = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// The first file of this name in `PATH`, or in the folders that Debian leaves out of a user's `PATH`.
pub fn program(name: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path)
        .chain(["/usr/sbin", "/sbin"].map(PathBuf::from))
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}
