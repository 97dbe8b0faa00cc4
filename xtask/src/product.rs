//! The drives of other makers that an image can be: the folders of `products/`.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::str::FromStr;

use anyhow::Result;

use crate::firmware::{self, Image};
use crate::words::say;
use crate::{place, process, setup, size};

/// Where the build of the firmware is told its data sheet, from the root of the workspace.
const DATA_SHEET: &str = "AXIS402_EDS";

/// A product by the name of its folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Product(String);

impl FromStr for Product {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let all = Self::all();
        let found = all.iter().find(|product| product.0 == name).cloned();
        found.ok_or_else(|| {
            let names: Vec<_> = all.into_iter().map(|product| product.0).collect();
            format!("there are {}", names.join(", "))
        })
    }
}

impl Product {
    /// Every folder that holds a data sheet of its name, in the order of the names.
    pub fn all() -> Vec<Self> {
        let folder = place::root().join("products");
        let folders = fs::read_dir(&folder).into_iter().flatten();
        let mut names: Vec<_> = folders
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| folder.join(name).join(format!("{name}.eds")).exists())
            .map(Self)
            .collect();
        names.sort_by(|one, other| one.0.cmp(&other.0));
        names
    }

    /// The name of its folder.
    pub fn name(&self) -> &str {
        &self.0
    }

    /// Its behaviour that is no data, if it has any.
    pub fn module(&self) -> PathBuf {
        let name = &self.0;
        place::root().join(format!("products/{name}/{name}.rs"))
    }

    /// Has the command build the firmware with this product's data sheet.
    pub fn choose(&self, command: &mut Command) {
        command.env(DATA_SHEET, format!("products/{0}/{0}.eds", self.0));
    }
}

/// What is flashed.
#[derive(Debug, clap::Args)]
pub struct Board {
    /// Be the drive of another maker: a folder of products/
    #[arg(long, value_name = "NAME")]
    product: Option<Product>,

    /// More for `cargo run`
    #[arg(value_name = "ARGUMENTS", last = true)]
    more: Vec<String>,
}

/// `cargo xtask board`: builds the image of the board, flashes it and shows its logs until it is stopped.
///
/// # Errors
/// When cargo cannot be started.
pub fn board(arguments: &Board) -> Result<ExitCode> {
    let mut command = board_command(arguments);
    setup::rust_target()?;
    // Cargo and the probe's program have told what went wrong.
    Ok(if process::run(&mut command)?.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn board_command(arguments: &Board) -> Command {
    let mut command = place::cargo();
    command.args(["run", "--profile", firmware::PROFILE, "--package", "app"]);
    command.args(["--bin", "app", "--target", firmware::TARGET]);
    command.args(&arguments.more);
    if let Some(product) = &arguments.product {
        product.choose(&mut command);
    }
    command
}

/// Builds the images of the servo boards that the tests on the chip model run, and names them.
///
/// # Errors
/// When one does not build.
pub fn chips(command: &mut Command) -> Result<()> {
    // Each is kept before the next one is built: they have the same name.
    for (flag, image, name) in [
        ("--lmd-image", Image::Stepper, "lmd"),
        ("--s200-image", Image::Odrive, "s200"),
        ("--stepper-image", Image::Stepper, ""),
        ("--servo-image", Image::Odrive, ""),
        ("--servo-40khz-image", Image::Odrive40khz, ""),
    ] {
        let product: Option<Product> = name.parse().ok();
        command.arg(flag).arg(image.build_as(product.as_ref())?);
    }
    Ok(())
}

/// The servo boards that products go with, and these without a product, so that their images are kept.
const SERVOS: [(Image, &str); 6] = [
    (Image::Stepper, "lmd"),
    (Image::Stepper, "nanotec"),
    (Image::Stepper, ""),
    (Image::Odrive, "s200"),
    (Image::Odrive, "tc1"),
    (Image::Odrive, ""),
];

/// The compact image of each product beside that of the generic drive, and the whole images of the servo boards.
///
/// # Errors
/// When one does not build.
pub fn sizes() -> Result<()> {
    setup::rust_target()?;
    say!("\n{:<36} {:>8} {:>8}", "least size", "flash", "RAM")?;
    let row = |name: &str, product: Option<&Product>| {
        let sizes = size::measure(&Image::Least.build_as(product)?)?;
        let size::Size { flash, ram } = sizes.total;
        say!("{name:<36} {flash:>8} {ram:>8}")
    };
    row("axis402", None)?;
    for product in Product::all() {
        row(product.name(), Some(&product))?;
    }
    say!("\n{:<36} {:>8} {:>8}", "on a servo board", "flash", "RAM")?;
    for (image, name) in SERVOS {
        let product: Option<Product> = name.parse().ok();
        let sizes = size::measure(&image.build_as(product.as_ref())?)?;
        let size::Size { flash, ram } = sizes.total;
        let name = product.as_ref().map_or("axis402", Product::name);
        let row = format!("{name}, {}", image.board());
        say!("{row:<36} {flash:>8} {ram:>8}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_is_a_folder_with_a_data_sheet_and_another_name_is_refused_with_those_that_there_are()
     {
        let names: Vec<_> = Product::all().into_iter().map(|own| own.0).collect();
        assert!(names.contains(&"lmd".to_owned()), "{names:?}");
        assert_eq!("lmd".parse::<Product>().unwrap().name(), "lmd");
        let refusal = "acme".parse::<Product>().unwrap_err();
        assert_eq!(refusal, format!("there are {}", names.join(", ")));
    }

    #[test]
    fn the_board_is_flashed_with_the_data_sheet_of_the_product() {
        let more = vec!["--no-default-features".to_owned()];
        let product = Some("lmd".parse().unwrap());
        let command = board_command(&Board { product, more });
        let line = process::line(&command);
        assert!(line.ends_with(" --no-default-features"), "{line}");
        let mut chosen = command.get_envs().filter_map(|(_, value)| value);
        let chosen = chosen.find(|value| *value == "products/lmd/lmd.eds");
        assert!(chosen.is_some());
    }
}
