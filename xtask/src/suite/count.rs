//! How many tests passed and failed, as the test runners say it.

use std::fmt;
use std::ops::AddAssign;
use std::process::ExitStatus;

/// Tests that ran. Those that were left out by their runner are in neither number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Tests that passed.
    pub passed: u32,
    /// Tests that failed, errors in their set-up included.
    pub failed: u32,
}

impl Count {
    /// So many of each.
    pub fn of(passed: usize, failed: usize) -> Self {
        let number = |count| u32::try_from(count).unwrap_or(u32::MAX);
        Self {
            passed: number(passed),
            failed: number(failed),
        }
    }

    /// A check that is one test: it passes with the exit code 0.
    pub fn check(status: ExitStatus) -> Self {
        if status.success() {
            Self {
                passed: 1,
                failed: 0,
            }
        } else {
            Self {
                passed: 0,
                failed: 1,
            }
        }
    }

    /// Takes the summary out of a line of a runner's output, if it is one.
    pub fn watch(&mut self, line: &str) {
        *self += libtest(line).or_else(|| pytest(line)).unwrap_or_default();
    }

    /// Holds the count against the runner's exit status: a runner that failed has at least one failure, be it that
    /// it could not be built, and one that ran nothing has not passed.
    pub fn close(mut self, succeeded: bool) -> Self {
        if (!succeeded && self.failed == 0) || self == Self::default() {
            self.failed += 1;
        }
        self
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed", self.passed, self.failed)
    }
}

/// `test result: ok. 12 passed; 0 failed; 0 ignored; ...`, once for each test binary.
fn libtest(line: &str) -> Option<Count> {
    let (_, parts) = line.strip_prefix("test result: ")?.split_once(". ")?;
    Some(sum(parts.split(';')))
}

/// `=== 1 failed, 12 passed, 2 skipped in 3.20s ===`, at the end.
fn pytest(line: &str) -> Option<Count> {
    let words = line
        .strip_prefix('=')?
        .strip_suffix('=')?
        .trim_matches('=')
        .trim();
    let (parts, time) = words.rsplit_once(" in ")?;
    time.starts_with(|c: char| c.is_ascii_digit())
        .then(|| sum(parts.split(',')))
}

fn sum<'a>(parts: impl Iterator<Item = &'a str>) -> Count {
    let mut count = Count::default();
    for part in parts {
        let Some((number, what)) = part.trim().split_once(' ') else {
            continue;
        };
        let number = number.parse().unwrap_or(0);
        match what {
            "passed" => count.passed += number,
            "failed" | "error" | "errors" => count.failed += number,
            _ => {}
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched(lines: &[&str]) -> (u32, u32) {
        let mut count = Count::default();
        for line in lines {
            count.watch(line);
        }
        (count.passed, count.failed)
    }

    #[test]
    fn the_summaries_of_cargo_test_are_added_up() {
        let ok = "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 3 filtered out; finished in 0.01s";
        let failed = "test result: FAILED. 4 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s";
        assert_eq!(
            watched(&["running 12 tests", ok, "test a_case ... ok", failed]),
            (16, 2)
        );
    }

    #[test]
    fn the_summary_of_pytest_is_read() {
        assert_eq!(
            watched(&["=== 1 failed, 12 passed, 3 skipped, 2 errors in 3.20s ==="]),
            (12, 3)
        );
        assert_eq!(
            watched(&["============== 24 passed in 75.31s (0:01:15) =============="]),
            (24, 0)
        );
        assert_eq!(
            watched(&["=== FAILURES ===", "= test session starts =", "12 passed"]),
            (0, 0)
        );
    }

    #[test]
    fn a_runner_that_failed_or_ran_nothing_has_a_failure() {
        assert_eq!(
            Count {
                passed: 3,
                failed: 0
            }
            .close(true),
            Count {
                passed: 3,
                failed: 0
            }
        );
        assert_eq!(
            Count {
                passed: 3,
                failed: 0
            }
            .close(false),
            Count {
                passed: 3,
                failed: 1
            }
        );
        assert_eq!(
            Count {
                passed: 3,
                failed: 2
            }
            .close(false),
            Count {
                passed: 3,
                failed: 2
            }
        );
        assert_eq!(
            Count::default().close(true),
            Count {
                passed: 0,
                failed: 1
            }
        );
    }
}
