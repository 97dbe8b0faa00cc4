//! The images of the firmware, built for the target.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use object::{Architecture, BinaryFormat, Object, ObjectKind, ObjectSegment};
use serde_json::Value;

use crate::product::Product;
use crate::refusal::refuse;
use crate::words::plain;
use crate::{place, process};

/// Cortex-M4F, hardware floating-point calling convention.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The profile of Cargo.toml that the firmware is built with.
pub const PROFILE: &str = "firmware";

/// That of the compact image.
const COMPACT: &str = "compact";

/// The drive on the STM32F405 board, without logs.
const WHOLE: &str = "stm32f405,sin-squared,block-transfer";

/// The servo on the board ODrive v3.6, without logs.
const ODRIVE: &str = "odrive36,sin-squared,block-transfer";

/// The same with its current loop at 40 kHz.
const ODRIVE_40KHZ: &str = "odrive36,sin-squared,block-transfer,pwm-40khz";
/// The same without what the compact image leaves out.
const ODRIVE_FOR_SIZE: &str = "odrive36";

/// The stepper in closed loop on the board with two full bridges, without logs.
const STEPPER: &str = "stepper405,sin-squared,block-transfer";

/// The drive on QEMU's machine.
const EMULATED: &str = "qemu,sin-squared,block-transfer";

/// What can be built from `firmware/app`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Image {
    /// The drive on the STM32F405 board.
    Board,
    /// The same without logs: what is measured.
    Whole,
    /// The servo on the board ODrive v3.6, without logs.
    Odrive,
    /// The same with its current loop at 40 kHz.
    Odrive40khz,
    /// The same for least size, as the compact image is built.
    OdriveForSize,
    /// The stepper in closed loop on the board with two full bridges, without logs.
    Stepper,
    /// The smallest drive that is still a good one (`eds/compact.eds`), without logs.
    Compact,
    /// The whole drive, or a product, as small as the compiler makes it.
    Least,
    /// The drive on QEMU's machine.
    Qemu,
    /// The benchmarks, on QEMU's machine.
    Bench,
    /// A device with what other stacks have by default, to measure its flash.
    BasicDevice,
    /// The same for least size, as the compact image is built.
    BasicDeviceForSize,
    /// The core alone, with a panic handler that does not link: proof that no panic path is left.
    NoPanic,
    /// The same with the axis and the data sheet of a servo.
    NoPanicServo,
}

impl Image {
    /// The name of the binary in `firmware/app`.
    fn binary(self) -> &'static str {
        match self {
            Self::Board
            | Self::Whole
            | Self::Odrive
            | Self::Odrive40khz
            | Self::OdriveForSize
            | Self::Stepper
            | Self::Compact
            | Self::Least
            | Self::Qemu => "app",
            Self::Bench => "bench",
            Self::BasicDevice | Self::BasicDeviceForSize => "basic-device",
            Self::NoPanic | Self::NoPanicServo => "no-panic",
        }
    }

    /// The profile of Cargo.toml.
    fn profile(self) -> &'static str {
        match self {
            Self::Compact | Self::Least | Self::OdriveForSize | Self::BasicDeviceForSize => COMPACT,
            _ => PROFILE,
        }
    }

    /// The features that choose the board, whether there are logs, and what no data sheet tells.
    fn features(self) -> &'static [&'static str] {
        match self {
            Self::Board | Self::BasicDevice => &[],
            Self::NoPanic | Self::Whole => &["--no-default-features", "--features", WHOLE],
            Self::Odrive | Self::NoPanicServo => &["--no-default-features", "--features", ODRIVE],
            Self::Odrive40khz => &["--no-default-features", "--features", ODRIVE_40KHZ],
            Self::OdriveForSize => &["--no-default-features", "--features", ODRIVE_FOR_SIZE],
            Self::Stepper => &["--no-default-features", "--features", STEPPER],
            Self::Compact | Self::Least | Self::BasicDeviceForSize => {
                &["--no-default-features", "--features", "stm32f405"]
            }
            Self::Qemu | Self::Bench => &["--no-default-features", "--features", EMULATED],
        }
    }

    /// Its board: the folder in `firmware/app/src/board`.
    pub fn board(self) -> &'static str {
        match self {
            Self::Odrive | Self::Odrive40khz | Self::OdriveForSize | Self::NoPanicServo => {
                "odrive36"
            }
            Self::Stepper => "stepper405",
            Self::Qemu | Self::Bench => "qemu",
            _ => "stm32f405",
        }
    }

    /// The cargo command that builds it.
    ///
    /// # Errors
    /// When cargo does not tell where the sources of the libraries are.
    pub fn build_command(self) -> Result<Command> {
        let mut command = place::cargo();
        let for_size = self.profile() == COMPACT;
        command.args([
            if for_size { "rustc" } else { "build" },
            "--profile",
            self.profile(),
            "--package",
            "app",
            "--bin",
            self.binary(),
            "--target",
            TARGET,
        ]);
        command.args(self.features());
        if self == Self::Compact {
            command.env("AXIS402_EDS", "eds/compact.eds");
        }
        command.arg("--config").arg(neutral_paths()?);
        if for_size {
            command.arg("--").args(options_for_size()?);
        }
        Ok(command)
    }

    /// Where [`Image::keep`] puts the ELF file. Several are built as `app`, so each gets a name of its own.
    pub fn path(self) -> PathBuf {
        let name = match self {
            Self::Board => "axis402-stm32f405.elf",
            Self::Whole => "axis402-without-logs.elf",
            Self::Odrive => "axis402-odrive36.elf",
            Self::Odrive40khz => "axis402-odrive36-40khz.elf",
            Self::OdriveForSize => "axis402-odrive36-for-size.elf",
            Self::Stepper => "axis402-stepper405.elf",
            Self::Compact => "axis402-compact.elf",
            Self::Least => "axis402-least.elf",
            Self::Qemu => "axis402-qemu.elf",
            Self::Bench => "bench.elf",
            Self::BasicDevice => "basic-device.elf",
            Self::BasicDeviceForSize => "basic-device-for-size.elf",
            Self::NoPanic => "no-panic.elf",
            Self::NoPanicServo => "no-panic-servo.elf",
        };
        place::target().join("xtask").join(name)
    }

    /// Copies what cargo built to [`Image::path`], in one step, so that no emulator ever loads half a file.
    pub fn keep(self) -> Result<PathBuf> {
        let kept = self.path();
        let built = place::target()
            .join(TARGET)
            .join(self.profile())
            .join(self.binary());
        replace(&built, &kept)
            .with_context(|| format!("copying {} to {}", built.display(), kept.display()))?;
        Ok(kept)
    }

    /// Builds the image (cargo's words go to the standard error) and gives its ELF file.
    pub fn build(self) -> Result<PathBuf> {
        self.build_as(None)
    }

    /// The same with the data sheet of a product.
    pub fn build_as(self, product: Option<&Product>) -> Result<PathBuf> {
        let mut command = self.build_command()?;
        if let Some(product) = product {
            product.choose(&mut command);
        }
        if !process::run(&mut command)?.success() {
            bail!("the firmware does not build: `{}`", process::line(&command));
        }
        let kept = self.keep()?;
        let Some(product) = product else {
            return Ok(kept);
        };
        let own = kept.with_extension(format!("{}.elf", product.name()));
        fs::rename(&kept, &own).with_context(|| format!("renaming {}", kept.display()))?;
        Ok(own)
    }
}

/// What `cargo compact` tells the compiler.
fn options_for_size() -> Result<Vec<String>> {
    let file = place::root().join(".cargo/config.toml");
    let text = fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
    let alias = text.lines().find(|line| line.starts_with("compact = "));
    let (_, options) = alias
        .and_then(|alias| alias.trim_end_matches('"').split_once(" -- "))
        .context("`cargo compact` has no options for the compiler")?;
    Ok(options.split(' ').map(str::to_owned).collect())
}

/// The setting for cargo that keeps the paths of whoever builds out of flash. Where a library may panic, its image holds
/// the path of its source, which lies in a folder of this user: the bytes and the sizes of the same sources would differ
/// from PC to PC. Debug information and error messages keep the real paths.
fn neutral_paths() -> Result<String> {
    let mut metadata = place::cargo();
    metadata.args([
        "metadata",
        "--format-version",
        "1",
        "--filter-platform",
        TARGET,
    ]);
    let output = metadata
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("starting `{}`", process::line(&metadata)))?;
    if !output.status.success() {
        bail!("`{}` failed", process::line(&metadata));
    }
    let metadata = serde_json::from_slice(&output.stdout)
        .context("reading what cargo says of its packages")?;
    // Cargo adds these to the options of .cargo/config.toml.
    let options = remap(&library_folders(&metadata));
    // An array of strings looks alike in JSON and in TOML.
    Ok(format!(
        "target.{TARGET}.rustflags={}",
        serde_json::json!(options)
    ))
}

/// The folders that hold the sources of libraries from elsewhere: the registry's, as a rule.
fn library_folders(metadata: &Value) -> BTreeSet<&str> {
    let packages = metadata["packages"].as_array().into_iter().flatten();
    packages
        .filter(|package| !package["source"].is_null())
        .filter_map(|package| {
            Path::new(package["manifest_path"].as_str()?)
                .ancestors()
                .nth(2)
        })
        .filter_map(Path::to_str)
        .collect()
}

/// The options for the compiler that write `/cargo` for each of these folders.
fn remap(folders: &BTreeSet<&str>) -> Vec<String> {
    let remaps = folders
        .iter()
        .map(|folder| format!("--remap-path-prefix={folder}=/cargo"));
    std::iter::once("--remap-path-scope=macro".to_owned())
        .chain(remaps)
        .collect()
}

/// The path of an image that is there already, seen from the root.
///
/// # Errors
/// When it is no program for a 32-bit Arm processor: QEMU would take any file and run its bytes.
pub fn given(path: &Path) -> Result<PathBuf> {
    let cannot = |why: &str| refuse(format!("cannot use the image {}: {why}", path.display()));
    let full = path
        .canonicalize()
        .map_err(|error| cannot(&plain(&error)))?;
    if !full.is_file() {
        return Err(cannot("not a file"));
    }
    let bytes = fs::read(&full).map_err(|error| cannot(&plain(&error)))?;
    if !is_arm_program(&bytes) {
        return Err(cannot("no ELF program for a 32-bit Arm"));
    }
    Ok(full)
}

fn is_arm_program(bytes: &[u8]) -> bool {
    object::File::parse(bytes).is_ok_and(|file| {
        file.format() == BinaryFormat::Elf
            && file.architecture() == Architecture::Arm
            && file.is_little_endian()
            && file.kind() == ObjectKind::Executable
            && file.segments().next().is_some()
            && file.segments().all(|segment| segment.data().is_ok())
    })
}

/// Copies a file in one step.
pub fn replace(from: &Path, to: &Path) -> std::io::Result<()> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder)?;
    }
    let beside = to.with_extension(format!("{}.part", std::process::id()));
    fs::copy(from, &beside)?;
    fs::rename(&beside, to)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The smallest program: a header, and one segment that holds 4 bytes.
    fn program() -> Vec<u8> {
        // Magic, 32 bits, little-endian, version 1.
        let mut bytes = b"\x7fELF\x01\x01\x01".to_vec();
        bytes.resize(16, 0);
        // An executable for Arm.
        bytes.extend([2, 0, 40, 0]);
        // Version, entry, program headers at 52, no sections, flags.
        for word in [1, 0x0800_0001, 52, 0, 0x0500_0000_u32] {
            bytes.extend(word.to_le_bytes());
        }
        // Sizes and numbers of the headers: this one, 1 of the program, 0 of sections.
        for half in [52, 32, 1, 40, 0, 0_u16] {
            bytes.extend(half.to_le_bytes());
        }
        // Loaded, 4 bytes at 84 of the file go to the address 0x0800_0000.
        for word in [1, 84, 0x0800_0000, 0x0800_0000, 4, 4, 5, 4_u32] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend([0xFE, 0xE7, 0xFE, 0xE7]);
        bytes
    }

    #[test]
    fn an_image_is_a_program_for_a_32_bit_arm() {
        assert!(is_arm_program(&program()));
        let changed = |at: usize, byte| {
            let mut bytes = program();
            bytes[at] = byte;
            bytes
        };
        // 64 bits; big-endian; a library; an x86-64; nothing to load.
        for (at, byte) in [(4, 2), (5, 2), (16, 1), (18, 62), (44, 0)] {
            assert!(!is_arm_program(&changed(at, byte)), "{at}");
        }
        // Half a file.
        assert!(!is_arm_program(&program()[..86]));
        assert!(!is_arm_program(b""));
    }

    #[test]
    fn an_image_for_size_is_built_as_cargo_compact_builds_it() {
        let command = Image::Compact.build_command().unwrap();
        let words: Vec<_> = command
            .get_args()
            .filter_map(|word| word.to_str())
            .collect();
        assert_eq!(words.first(), Some(&"rustc"));
        let options = options_for_size().unwrap();
        assert!(
            options.len() > 1 && options.len().is_multiple_of(2),
            "{options:?}"
        );
        assert!(words.ends_with(&options.iter().map(String::as_str).collect::<Vec<_>>()));
    }

    #[test]
    fn what_is_no_image_is_refused() {
        let refusal = |path: &Path| {
            let error = given(path).unwrap_err();
            assert!(error.is::<crate::refusal::Refusal>(), "{error:?}");
            error.to_string()
        };
        let folder = tempfile::tempdir().unwrap();
        let text = folder.path().join("README.md");
        fs::write(&text, "# Axis402").unwrap();
        assert!(refusal(&text).ends_with("README.md: no ELF program for a 32-bit Arm"));
        assert!(refusal(folder.path()).ends_with(": not a file"));
        assert!(refusal(&folder.path().join("app")).ends_with("app: no such file or directory"));
    }

    #[test]
    fn the_folders_of_libraries_are_hidden_and_those_of_the_workspace_are_not() {
        let package = |source: Option<&str>, manifest: &str| serde_json::json!({"source": source, "manifest_path": manifest});
        let registry = Some("registry+https://example.org/index");
        let metadata = serde_json::json!({"packages": [
            package(registry, "/cargo home/src/index-1/nb-1.1.0/Cargo.toml"),
            package(registry, "/cargo home/src/index-1/fugit-0.3.9/Cargo.toml"),
            package(None, "/src/axis402/firmware/app/Cargo.toml"),
        ]});
        assert_eq!(
            remap(&library_folders(&metadata)),
            [
                "--remap-path-scope=macro",
                "--remap-path-prefix=/cargo home/src/index-1=/cargo"
            ]
        );
    }
}
