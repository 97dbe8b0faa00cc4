//! What the drive may weigh: flash, RAM with the stack, the largest function, the length of the sources.
//!
//! `cargo xtask size` prints these figures behind those of each crate, and docs/benchmarks.md holds them beside their goals.

mod instruction;
mod lines;
mod stack;

use anyhow::{Context, Result};

use crate::firmware::Image;
use crate::size::{self, Sizes};

/// A file has no more lines than this.
const LONGEST_FILE: usize = 500;

/// Names and figures, in the order of the table.
///
/// # Errors
/// When an image does not build, or its stack has no bound.
pub fn figures(whole: &Sizes) -> Result<Vec<(String, u64)>> {
    let mut rows = Vec::new();
    let mut row = |name: String, figure| rows.push((name, figure));
    row("whole drive, flash".to_owned(), whole.total.flash);
    let stack = stack_of(Image::Whole)?;
    row(
        "whole drive, RAM with the stack".to_owned(),
        whole.total.ram + stack.start.max(stack.tasks),
    );
    row("whole drive, stack at the start".to_owned(), stack.start);
    row("whole drive, stack of the tasks".to_owned(), stack.tasks);
    for name in ["motion", "cia402"] {
        row(format!("{name} in it, flash"), whole.flash_of(name));
    }
    row(
        "cia402: its largest function".to_owned(),
        whole.largest_function_of("cia402"),
    );
    let compact = size::of(Image::Compact)?;
    row("compact, flash".to_owned(), compact.total.flash);
    let stack = stack_of(Image::Compact)?;
    row(
        "compact, RAM with the stack".to_owned(),
        compact.total.ram + stack.start.max(stack.tasks),
    );
    let servo = size::of(Image::Odrive)?;
    row("odrive36, flash".to_owned(), servo.total.flash);
    row("servo in it, flash".to_owned(), servo.flash_of("servo"));
    let servo_for_size = size::of(Image::OdriveForSize)?;
    row(
        "servo in it for size, flash".to_owned(),
        servo_for_size.flash_of("servo"),
    );
    let stack = stack_of(Image::Odrive)?;
    row(
        "odrive36, RAM with the stack".to_owned(),
        servo.total.ram + stack.start.max(stack.tasks),
    );
    let stepper = size::of(Image::Stepper)?;
    row("stepper405, flash".to_owned(), stepper.total.flash);
    let stack = stack_of(Image::Stepper)?;
    row(
        "stepper405, RAM with the stack".to_owned(),
        stepper.total.ram + stack.start.max(stack.tasks),
    );
    for (name, folders) in [
        ("motion", &["motion"][..]),
        ("cia402", &["cia402", "cia402/parameters"]),
    ] {
        let mut count = 0;
        for folder in folders {
            count += lines::without_tests(&format!("firmware/{folder}"))?;
        }
        row(format!("{name}: lines without tests"), count);
    }
    let long = lines::files_above(LONGEST_FILE)?;
    row(
        format!("files above {LONGEST_FILE} lines"),
        long.len() as u64,
    );
    Ok(rows)
}

fn stack_of(image: Image) -> Result<stack::Depth> {
    let file = image.path();
    stack::worst_case(&file, image.board())
        .with_context(|| format!("the stack of {}", file.display()))
}
