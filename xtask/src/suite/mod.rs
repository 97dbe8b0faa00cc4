//! `cargo xtask test`: everything that can be tested without a board.
//!
//! What is missing is installed first, so that nothing is refused after minutes of work. The tests of running devices go on beside what cargo does. Every step
//! shows its output as it comes, theirs with its name before each line. The end is a summary by step with the names of what failed, and `N passed, N failed` alone on
//! the last line.

mod count;
pub mod programs;
mod side_by_side;
mod steps;

use std::process::ExitCode;

use anyhow::Result;

use count::Count;
use side_by_side::Outcome;
pub use steps::panel_pictures;
use steps::{Ready, Step};

use crate::words::say;

/// Which steps to run.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Run only these steps
    #[arg(long, value_delimiter = ',', value_name = "STEP")]
    only: Vec<Step>,

    /// Leave these steps out
    #[arg(long, value_delimiter = ',', value_name = "STEP")]
    skip: Vec<Step>,

    /// Check formatting, lints and documentation as well, as .ci/run does
    #[arg(long)]
    with_lints: bool,
}

impl Arguments {
    /// The step on the board's model, and nothing else.
    pub fn board() -> Self {
        Self {
            only: vec![Step::Board],
            skip: Vec::new(),
            with_lints: false,
        }
    }

    fn selected(&self) -> impl Iterator<Item = Step> + '_ {
        let wanted = |step: &Step| match self.only.as_slice() {
            [] => self.with_lints || !step.is_lint(),
            only => only.contains(step) || (self.with_lints && step.is_lint()),
        };
        Step::ALL
            .into_iter()
            .filter(wanted)
            .filter(|step| !self.skip.contains(step))
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let steps: Vec<_> = arguments.selected().collect();
    let ready = Ready::install(&steps)?;
    conclude(&side_by_side::run(&steps, &ready)?)
}

/// Prints the summary and the closing line.
fn conclude(outcomes: &[Outcome]) -> Result<ExitCode> {
    say!("\n=== summary ===")?;
    let mut sum = Count::default();
    for Outcome {
        step,
        count,
        again,
        skipped,
        time,
    } in outcomes
    {
        sum += count.clone();
        let name = step.to_string();
        match skipped {
            Some(why) => say!("{name:<10} skipped: {why}")?,
            None => say!("{name:<10} {count}, {:.0} s", time.as_secs_f32())?,
        }
        for test in again.iter().filter(|test| !count.names.contains(test)) {
            say!("           only when the PC did nothing else: {test}")?;
        }
        for test in &count.names {
            say!("           FAILED: {test}")?;
        }
    }
    say!("\n{} passed, {} failed", sum.passed, sum.failed)?;
    Ok(if sum.failed == 0 && sum.passed > 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn selected(line: &[&str]) -> Vec<Step> {
        Line::try_parse_from([&["test"], line].concat())
            .unwrap()
            .arguments
            .selected()
            .collect()
    }

    #[test]
    fn without_arguments_everything_but_the_lints_runs() {
        use Step::*;
        assert_eq!(
            selected(&[]),
            [Host, Book, Fuzz, Firmware, Python, Board, Qemu, Socketcan]
        );
        assert_eq!(selected(&["--with-lints"]), Step::ALL);
    }

    #[test]
    fn steps_are_chosen_and_left_out() {
        use Step::*;
        assert_eq!(selected(&["--only", "qemu,host"]), [Host, Qemu]);
        assert_eq!(
            selected(&["--skip", "qemu", "--skip", "socketcan"]),
            [Host, Book, Fuzz, Firmware, Python, Board]
        );
        assert_eq!(selected(&["--only", "lint"]), [Lint]);
    }

    #[test]
    fn an_unknown_step_is_refused() {
        assert!(Line::try_parse_from(["test", "--only", "hardware"]).is_err());
    }
}
