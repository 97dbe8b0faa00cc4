//! How many tests passed and failed, and which failed, as the test runners say it.

use std::fmt;
use std::ops::AddAssign;
use std::process::ExitStatus;

/// Tests that ran. Those that were left out by their runner are in neither number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Tests that passed.
    pub passed: u32,
    /// Tests that failed, errors in their set-up included.
    pub failed: u32,
    /// Their names, as far as the runner says them: a runner that could not be built says none.
    pub names: Vec<String>,
}

impl Count {
    /// So many of each.
    pub fn of(passed: usize, failed: usize) -> Self {
        let number = |count| u32::try_from(count).unwrap_or(u32::MAX);
        Self {
            passed: number(passed),
            failed: number(failed),
            names: Vec::new(),
        }
    }

    /// A check that is one test: it passes with the exit code 0.
    pub fn check(status: ExitStatus) -> Self {
        if status.success() {
            Self::of(1, 0)
        } else {
            Self::of(0, 1)
        }
    }

    /// Takes the summary out of a line of a runner's output, or the name of a test that failed, if it is one.
    pub fn watch(&mut self, line: &str) {
        *self += libtest(line).or_else(|| pytest(line)).unwrap_or_default();
        if let Some(name) = failed(line) {
            self.names.push(name.to_owned());
        }
    }

    /// What is left when the tests that failed were played again, with this count. What was not played again has failed.
    pub fn after(self, again: Self) -> Self {
        let passed = again.passed.min(self.failed);
        let all_are_named = again.names.len() == again.failed as usize;
        Self {
            passed: self.passed + passed,
            failed: self.failed - passed,
            names: if all_are_named {
                again.names
            } else {
                self.names
            },
        }
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
        self.names.extend(other.names);
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

/// `test plan::tests::a_case ... FAILED` of cargo test, `FAILED tests/test_case.py::test_it[id] - why` of pytest.
fn failed(line: &str) -> Option<&str> {
    let libtest = || line.strip_prefix("test ")?.strip_suffix(" ... FAILED");
    let pytest = || {
        let rest = line
            .strip_prefix("FAILED ")
            .or_else(|| line.strip_prefix("ERROR "))?;
        let name = rest.split(" - ").next()?;
        name.contains("::").then_some(name)
    };
    libtest().or_else(pytest)
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
    fn the_names_of_tests_that_failed_are_kept() {
        let mut count = Count::default();
        for line in [
            "test plan::tests::a_case ... ok",
            "test plan::tests::another ... FAILED",
            "FAILED tests/python/test_sdo.py::test_it[firmware-a b] - assert 1 == 2 - no",
            "ERROR tests/python/test_sdo.py::test_set_up",
            "ERROR: no bus",
        ] {
            count.watch(line);
        }
        assert_eq!(
            count.names,
            [
                "plan::tests::another",
                "tests/python/test_sdo.py::test_it[firmware-a b]",
                "tests/python/test_sdo.py::test_set_up",
            ]
        );
    }

    #[test]
    fn what_fails_again_has_failed() {
        let first = Count::of(70, 3);
        assert_eq!(first.clone().after(Count::of(3, 0)), Count::of(73, 0));
        assert_eq!(first.clone().after(Count::of(2, 1)), Count::of(72, 1));
        assert_eq!(first.clone().after(Count::of(0, 3)), Count::of(70, 3));
        // A runner that could not begin has one failure, and has played none of them.
        assert_eq!(first.after(Count::of(0, 1)), Count::of(70, 3));
    }

    #[test]
    fn a_runner_that_failed_or_ran_nothing_has_a_failure() {
        assert_eq!(Count::of(3, 0).close(true), Count::of(3, 0));
        assert_eq!(Count::of(3, 0).close(false), Count::of(3, 1));
        assert_eq!(Count::of(3, 2).close(false), Count::of(3, 2));
        assert_eq!(Count::default().close(true), Count::of(0, 1));
    }
}
