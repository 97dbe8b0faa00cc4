//! `cargo xtask size`: flash and RAM of the board's image by crate.
//!
//! The compiler puts functions into each other, across crates, until hardly a function of the core is left on its own.
//! So code is counted by what the debug information says of each instruction: it belongs to the crate of the function that it was
//! written in; what comes out of Rust's own library belongs to the crate that used it. Constants and variables
//! belong to the crate that their name begins with. The sum is exact: it is the size of the sections.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, SymbolKind, elf};

use crate::firmware::Image;
use crate::words::say;
use crate::{budget, product, setup};

/// The row of what belongs to no crate by name.
const UNNAMED: &str = "(constants without a name, padding)";

/// The row of names that are not Rust's: interrupt vectors, the compiler's run-time library.
const NO_CRATE: &str = "(vectors, run time)";

/// Bytes in flash and in RAM. Variables with an initial value cost both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Code, constants and initial values, in bytes.
    pub flash: u64,
    /// Variables, in bytes; the stack is not counted.
    pub ram: u64,
}

/// The size of an image by crate, and in all.
#[derive(Debug)]
pub struct Sizes {
    /// Each crate with what it takes, the largest in flash first.
    pub crates: Vec<(String, Size)>,
    /// The sections of the image.
    pub total: Size,
    /// How much of one function each crate has written, at most.
    functions: BTreeMap<String, u64>,
}

impl Sizes {
    /// Flash that a crate takes.
    pub fn flash_of(&self, wanted: &str) -> u64 {
        let mut crates = self.crates.iter();
        crates
            .find(|(name, _)| name == wanted)
            .map_or(0, |(_, size)| size.flash)
    }

    /// The largest function of a crate: of what the compiler has made one of, the bytes that this crate has written.
    pub fn largest_function_of(&self, wanted: &str) -> u64 {
        self.functions.get(wanted).copied().unwrap_or_default()
    }
}

/// What is measured.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The image of each product too, for least size, beside that of the generic drive
    #[arg(long)]
    products: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let sizes = of(Image::Whole)?;
    say!("{:<36} {:>8} {:>8}", "crate", "flash", "RAM")?;
    for (name, size) in &sizes.crates {
        say!("{name:<36} {:>8} {:>8}", size.flash, size.ram)?;
    }
    let Size { flash, ram } = sizes.total;
    say!("{:<36} {flash:>8} {ram:>8}", "total")?;
    for (name, figure) in budget::figures(&sizes)? {
        say!("{name:<36} {figure:>8}")?;
    }
    if arguments.products {
        product::sizes()?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Builds an image and measures it.
///
/// # Errors
/// When it does not build.
pub fn of(image: Image) -> Result<Sizes> {
    setup::rust_target()?;
    measure(&image.build()?)
}

/// Measures an ELF file.
///
/// # Errors
/// When the file cannot be read or is no ELF file.
pub fn measure(image: &Path) -> Result<Sizes> {
    let bytes = fs::read(image).with_context(|| format!("reading {}", image.display()))?;
    let file = object::File::parse(&*bytes)
        .with_context(|| format!("{} is no ELF file", image.display()))?;

    let names = Names::of(&file);
    let debug = addr2line::Loader::new(image)
        .map_err(|error| anyhow!("debug information of {}: {error}", image.display()))?;

    let mut total = Size::default();
    let mut crates: BTreeMap<String, Size> = BTreeMap::new();
    let mut functions: BTreeMap<(&str, String), u64> = BTreeMap::new();
    for section in file.sections() {
        let Some(place) = Place::of(section.flags(), section.kind()) else {
            continue;
        };
        place.add(&mut total, section.size());
        let mut add = |name: &str, bytes| match crates.get_mut(name) {
            Some(size) => place.add(size, bytes),
            None => place.add(crates.entry(name.to_owned()).or_default(), bytes),
        };
        let end = section.address() + section.size();
        let mut address = section.address();
        while address < end {
            // A Thumb instruction is a half-word or two.
            let (owner, next) = match names.at(address) {
                Some((name, next)) if section.kind() != SectionKind::Text => (crate_of(name), next),
                Some((name, _)) => {
                    let owner = author(&debug, address).unwrap_or_else(|| crate_of(name));
                    *functions.entry((name, owner.clone())).or_default() += 2;
                    (owner, address + 2)
                }
                None => (UNNAMED.to_owned(), names.after(address)),
            };
            let next = next.clamp(address + 1, end);
            add(&owner, next - address);
            address = next;
        }
    }

    let mut crates: Vec<_> = crates.into_iter().collect();
    crates.sort_by_key(|(_, size)| std::cmp::Reverse((size.flash, size.ram)));
    let mut largest: BTreeMap<String, u64> = BTreeMap::new();
    for ((_, owner), bytes) in functions {
        let most = largest.entry(owner).or_default();
        *most = bytes.max(*most);
    }
    Ok(Sizes {
        crates,
        total,
        functions: largest,
    })
}

/// The functions and variables of an image by address.
struct Names<'a>(BTreeMap<u64, (u64, &'a str)>);

impl<'a> Names<'a> {
    fn of(file: &object::File<'a>) -> Self {
        let symbols = file.symbols().filter(|symbol| {
            matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data) && symbol.size() > 0
        });
        // The address of a Thumb function has its lowest bit set; a variable may lie on an odd address.
        let even = |symbol: &object::Symbol<'_, '_>| {
            symbol.address() & !u64::from(symbol.kind() == SymbolKind::Text)
        };
        let entry = |symbol: object::Symbol<'a, '_>| {
            let start = even(&symbol);
            (
                start,
                (start + symbol.size(), symbol.name().unwrap_or_default()),
            )
        };
        Self(symbols.map(entry).collect())
    }

    /// The name of what lies at the address, and the address after it.
    fn at(&self, address: u64) -> Option<(&'a str, u64)> {
        let (_, &(end, name)) = self.0.range(..=address).next_back()?;
        (address < end).then_some((name, end.min(self.after(address))))
    }

    /// The next address after this one at which something begins.
    fn after(&self, address: u64) -> u64 {
        self.0
            .range(address + 1..)
            .next()
            .map_or(u64::MAX, |(start, _)| *start)
    }
}

/// The crate in whose source the instruction was written, Rust's own library left aside where another crate used it.
fn author(debug: &addr2line::Loader, address: u64) -> Option<String> {
    let mut frames = debug.find_frames(address).ok()?;
    let mut owner = None;
    while let Ok(Some(frame)) = frames.next() {
        let function = frame.function.as_ref();
        let name = function.and_then(|function| function.raw_name().ok());
        let name = name.and_then(|name| crate_of_path(&name));
        // Interrupt handlers have the hardware's names.
        let file = frame.location.and_then(|location| location.file);
        let Some(name) = name.or_else(|| crate_of_file(file?)) else {
            continue;
        };
        let of_rust = ["core", "alloc", "std"].contains(&name.as_str());
        owner = Some(name);
        if !of_rust {
            break;
        }
    }
    owner
}

/// Where a section lies.
#[derive(Clone, Copy, Debug)]
enum Place {
    Flash,
    Ram,
    Both,
}

impl Place {
    /// None for what is not loaded: debug information, logging strings.
    fn of(flags: SectionFlags, kind: SectionKind) -> Option<Self> {
        let SectionFlags::Elf { sh_flags, .. } = flags else {
            return None;
        };
        if sh_flags & elf::SHF_ALLOC != elf::SHF_ALLOC {
            return None;
        }
        Some(match kind {
            SectionKind::UninitializedData => Self::Ram,
            SectionKind::Data => Self::Both,
            _ => Self::Flash,
        })
    }

    fn add(self, size: &mut Size, bytes: u64) {
        if matches!(self, Self::Flash | Self::Both) {
            size.flash += bytes;
        }
        if matches!(self, Self::Ram | Self::Both) {
            size.ram += bytes;
        }
    }
}

/// The crate, or the row, that a symbol belongs to.
fn crate_of(symbol: &str) -> String {
    if symbol.starts_with('.') {
        return UNNAMED.to_owned();
    }
    crate_of_path(symbol).unwrap_or_else(|| NO_CRATE.to_owned())
}

/// The first name in a symbol's path, `<canopen::Node as core::fmt::Debug>::fmt` included. None if it is not Rust's.
fn crate_of_path(symbol: &str) -> Option<String> {
    let path = rustc_demangle::try_demangle(symbol).ok()?.to_string();
    let path = path.trim_start_matches(['<', '&', '*', '[', '(']);
    let path = path.strip_prefix("mut ").unwrap_or(path);
    let path = path.strip_prefix("dyn ").unwrap_or(path);
    let name: String = path
        .chars()
        .take_while(|c| c.is_ascii_alphanumeric() || *c == '_')
        .collect();
    // Otherwise it is an implementation for a primitive type.
    let is_path = path
        .get(name.len()..)
        .is_some_and(|rest| rest.starts_with(['[', ':']));
    Some(if is_path { name } else { "core".to_owned() })
}

/// The crate of a source file: the folder above `src`, without its version.
fn crate_of_file(file: &str) -> Option<String> {
    let (folder, _) = file.rsplit_once("/src/")?;
    let folder = folder.rsplit('/').next()?;
    let name = match folder.rsplit_once('-') {
        Some((name, version)) if version.starts_with(|c: char| c.is_ascii_digit()) => name,
        _ => folder,
    };
    Some(name.replace('-', "_"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_belong_to_the_first_crate_of_their_path() {
        assert_eq!(
            crate_of("_ZN7canopen4node4Node4poll17h0123456789abcdefE"),
            "canopen"
        );
        assert_eq!(
            crate_of(
                "_ZN59_$LT$core..fmt..Arguments$u20$as$u20$core..fmt..Display$GT$3fmt17h0123456789abcdefE"
            ),
            "core"
        );
        assert_eq!(crate_of("_RNvCskwGfYPst2Cb_6motion4plan"), "motion");
        assert_eq!(crate_of("memcpy"), NO_CRATE);
        assert_eq!(crate_of(".Lanon.0123456789abcdef.7"), UNNAMED);
    }

    #[test]
    fn files_belong_to_the_folder_above_their_sources() {
        let name = |file| crate_of_file(file).unwrap_or_default();
        assert_eq!(name("firmware/app/src/board/qemu.rs"), "app");
        assert_eq!(
            name("/cargo/src/cortex-m-rt-0.7.7/src/lib.rs"),
            "cortex_m_rt"
        );
        assert_eq!(name("/rustc/0123/library/core/src/ops/mod.rs"), "core");
        assert_eq!(name("main.rs"), "");
    }

    #[test]
    fn every_byte_of_this_program_is_counted_once() {
        let sizes = measure(&std::env::current_exe().unwrap()).unwrap();
        let flash: u64 = sizes.crates.iter().map(|(_, size)| size.flash).sum();
        let ram: u64 = sizes.crates.iter().map(|(_, size)| size.ram).sum();
        assert_eq!((flash, ram), (sizes.total.flash, sizes.total.ram));
        assert!(
            sizes
                .crates
                .iter()
                .any(|(name, size)| name == "xtask" && size.flash > 0)
        );
    }

    #[test]
    fn what_is_no_elf_file_is_an_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), "not an image").unwrap();
        assert!(measure(file.path()).is_err());
    }
}
