//! What data sheets cost: the device that has their dictionary, and the PC that reads them.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, SectionKind};
use od_gen::Figures;

use super::table::{Row, Table};
use crate::firmware::{PROFILE, TARGET};
use crate::place;

/// Flash and RAM of the dictionary of each data sheet in `eds/` and of each product.
pub fn dictionaries() -> Result<Table> {
    let mut folders = vec![place::root().join("eds")];
    for entry in fs::read_dir(place::root().join("products")).context("reading products")? {
        let path = entry?.path();
        if path.is_dir() {
            folders.push(path);
        }
    }
    let mut paths = Vec::new();
    for folder in folders {
        let files =
            fs::read_dir(&folder).with_context(|| format!("reading {}", folder.display()))?;
        for file in files {
            let path = file?.path();
            if path.extension().is_some_and(|extension| extension == "eds") {
                paths.push(path);
            }
        }
    }
    paths.sort_by_key(|path| path.file_name().map(ToOwned::to_owned));
    let mut rows = Vec::new();
    for path in paths {
        let model = od_gen::read(&path)?;
        let Figures {
            entries,
            descriptors,
            limits,
            values,
            ram,
        } = Figures::of(&model);
        let figures = [entries, descriptors, limits, values, ram].map(|figure| figure as u64);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        rows.push(Row::new(&name, &figures));
    }
    Ok(Table {
        heading: "Dictionaries".to_owned(),
        rows,
        slack: super::SLACK,
    })
}

/// Flash of a device whose application has no hooks, and with hooks that are all left out: they are to cost nothing.
pub fn hooks() -> Result<Table> {
    let flash = |name: &str, feature: &[&str]| -> Result<Row> {
        let mut build = place::cargo();
        build.args([
            "rustc",
            "--quiet",
            "--profile",
            PROFILE,
            "-p",
            "products",
            "--lib",
        ]);
        build.args(["--target", TARGET]).args(feature);
        // Machine code of this one crate, which holds all that is generic in its application.
        build.env("CARGO_PROFILE_FIRMWARE_LTO", "off");
        build.env("CARGO_PROFILE_FIRMWARE_DEBUG", "0");
        let folder = tempfile::tempdir().context("making a folder")?;
        let file = folder.path().join("device.o");
        let emit = format!("--emit=obj={}", file.display());
        build.args(["--", &emit, "-C", "codegen-units=1"]);
        let status = build.status().context("starting cargo")?;
        ensure!(status.success(), "the device does not build");
        let bytes = fs::read(&file).with_context(|| format!("reading {}", file.display()))?;
        let object = object::File::parse(&*bytes).context("reading machine code")?;
        let code = object
            .sections()
            .filter(|part| part.kind() == SectionKind::Text);
        Ok(Row::new(name, &[code.map(|part| part.size()).sum()]))
    };
    let without = flash("without hooks", &[])?;
    let with = flash("hooks, all left out", &["--features", "hooks"])?;
    let most = without.figures.iter().map(|size| size + size / 50);
    ensure!(
        with.figures <= most.collect(),
        "hooks that are left out cost more than 2 % of flash"
    );
    Ok(Table {
        heading: "Hooks".to_owned(),
        rows: vec![without, with],
        slack: super::SLACK,
    })
}

/// Time and memory to check a large data sheet and to write its code, and those of one half as large.
pub fn generator() -> Result<Table> {
    let folder = tempfile::tempdir().context("making a folder")?;
    let mut build = Command::new("cargo");
    build.args(["build", "--quiet", "--release", "-p", "od-gen"]);
    let status = build
        .current_dir(place::root())
        .status()
        .context("starting cargo")?;
    ensure!(status.success(), "od-gen does not build");
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| place::root().join("target"), Into::into);
    let program = target.join("release/od-gen");
    let mut rows = Vec::new();
    for entries in [10_000, 20_000] {
        let file = folder.path().join(format!("synthetic_{entries}.eds"));
        fs::write(&file, synthetic(entries)?).context("writing a data sheet")?;
        // The first run warms the file cache.
        let runs = (0..8).map(|_| measure(&program, &file));
        let runs = runs.collect::<Result<Vec<_>>>()?;
        let time = runs
            .iter()
            .skip(1)
            .map(|(time, _)| *time)
            .min()
            .unwrap_or_default();
        let memory = runs
            .iter()
            .map(|(_, memory)| *memory)
            .max()
            .unwrap_or_default();
        let time = u64::try_from(time.as_millis()).unwrap_or(u64::MAX);
        rows.push(Row::new(&format!("{entries} entries"), &[time, memory]));
    }
    if let [half, whole] = rows.as_slice() {
        let growth = |at: usize| whole.figures[at] * 100 / half.figures[at].max(1);
        rows.push(Row::new("growth, in hundredths", &[growth(0), growth(1)]));
    }
    Ok(Table {
        heading: "The generator".to_owned(),
        rows,
        // Times differ between PCs: shown, never compared.
        slack: u64::MAX,
    })
}

/// Time, and the most memory in MiB.
fn measure(program: &Path, file: &Path) -> Result<(Duration, u64)> {
    let start = Instant::now();
    let mut child = Command::new(program)
        .arg("rust")
        .arg(file)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .context("starting od-gen")?;
    let mut memory = 0;
    let status = loop {
        if let Some(status) = child.try_wait().context("waiting for od-gen")? {
            break status;
        }
        // The file is gone when the process has ended in between.
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        memory = memory.max(peak(&status).unwrap_or_default());
        std::thread::sleep(Duration::from_millis(1));
    };
    ensure!(
        status.success(),
        "od-gen does not take the synthetic data sheet"
    );
    Ok((start.elapsed(), memory.div_ceil(1024)))
}

/// The most memory that a process has had, in KiB.
fn peak(status: &str) -> Option<u64> {
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse().ok()
}

/// A data sheet with so many values: records of a hundred numbers of 8 bits, with limits.
fn synthetic(entries: usize) -> Result<String> {
    let mut text = String::from(
        "[FileInfo]\nFileName=synthetic.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n\n[DeviceInfo]\nVendorName=Nobody\n\
         VendorNumber=0\nProductName=Synthetic\nProductNumber=0\nRevisionNumber=0\nBaudRate_1000=1\nGranularity=8\nNrOfRXPDO=0\n\
         NrOfTXPDO=0\n\n[MandatoryObjects]\nSupportedObjects=3\n1=0x1000\n2=0x1001\n3=0x1018\n\n[1000]\n\
         ParameterName=Device type\nDataType=7\nAccessType=const\nDefaultValue=0\n\n[1001]\nParameterName=Error register\n\
         DataType=5\nAccessType=ro\n\n[1018]\nParameterName=Identity object\nObjectType=9\nSubNumber=2\n\n[1018sub0]\n\
         ParameterName=Highest sub-index supported\nDataType=5\nAccessType=const\nDefaultValue=1\n\n[1018sub1]\n\
         ParameterName=Vendor-ID\nDataType=7\nAccessType=ro\nDefaultValue=0\n\n",
    );
    let records = entries / 100;
    writeln!(text, "[ManufacturerObjects]\nSupportedObjects={records}")?;
    for record in 0..records {
        writeln!(text, "{}={:#06X}", record + 1, 0x2000 + record)?;
    }
    for index in 0x2000..0x2000 + records {
        writeln!(
            text,
            "\n[{index:04X}]\nParameterName=Record {index:04X}\nObjectType=9\nSubNumber=100\n\n[{index:04X}sub0]\n\
             ParameterName=Highest sub-index supported\nDataType=5\nAccessType=const\nDefaultValue=99"
        )?;
        for sub in 1..100 {
            writeln!(
                text,
                "\n[{index:04X}sub{sub:X}]\nParameterName=Value {sub}\nDataType=5\nAccessType=rw\nLowLimit={}\n\
                 HighLimit={}\nDefaultValue={sub}",
                sub / 2,
                sub + 100
            )?;
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_synthetic_data_sheet_is_right_and_has_as_many_entries_as_it_says() {
        let model = od_gen::parse("synthetic.eds", &synthetic(20_000).unwrap()).unwrap();
        // Beside those of the mandatory objects.
        assert_eq!(Figures::of(&model).entries, 20_004);
    }

    #[test]
    fn the_peak_of_a_process_is_read() {
        assert_eq!(peak("VmPeak:\t 9 kB\nVmHWM:\t    5196 kB\n"), Some(5196));
        assert_eq!(peak(""), None);
    }
}
