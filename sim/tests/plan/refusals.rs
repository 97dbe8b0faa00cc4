//! What a move may not be, and how its numbers are read.

use super::*;

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let limits = "--velocity 1000 --acceleration 1000";
    assert_refused(
        "--distance 5 --velocity 0 --acceleration 5",
        "velocity limit is zero",
    );
    assert_refused(
        "--distance 5 --velocity 5 --acceleration 0",
        "acceleration limit is zero",
    );
    assert_refused(
        "--distance 5 --velocity 5 --acceleration 5 --deceleration 0",
        "deceleration limit is zero",
    );
    assert_refused(
        &format!("--distance 4294967296 {limits}"),
        "4294967295 is the most",
    );
    assert_refused(
        &format!("--distance -4294967296 {limits}"),
        "4294967295 is the most",
    );
    assert_refused(
        &format!("--distance 9223372036854775807 {limits}"),
        "is the most",
    );
    assert_refused(&format!("--distance many {limits}"), "many");
    // What no option takes names the option, too.
    for (option, value) in [
        ("--distance", "1.5"),
        ("--distance", "9223372036854775808"),
        ("--velocity", "abc"),
        ("--velocity", "-5"),
        ("--velocity", "1e3"),
        ("--acceleration", "-1"),
        ("--acceleration", "0.5"),
        ("--deceleration", "4294967296"),
        ("--jerk", "-1"),
        ("--profile", "-1"),
        ("--initial-velocity", "fast"),
        ("--end-velocity", "-1"),
        ("--clock", "-1"),
        ("--clock", "168MHz"),
        ("--clock", "4294967296"),
    ] {
        let given = ["--distance 5", "--velocity 5", "--acceleration 5"];
        let others = given.iter().filter(|given| !given.starts_with(option));
        let others = others.copied().collect::<Vec<_>>().join(" ");
        assert_refused(&format!("{others} {option} {value}"), option);
        assert_refused(&format!("{others} {option}"), option);
    }
    for missing in ["--distance 5", "--velocity 5", "--acceleration 5"] {
        let all = "--distance 5 --velocity 5 --acceleration 5";
        let option = missing.trim_end_matches(" 5");
        assert_refused(&all.replace(missing, ""), option);
        assert_refused(&format!("{all} {missing}"), option);
    }
    assert_refused(&format!("--distance 5 {limits} --json=3"), "--json");
    assert_refused(&format!("--distance 5 {limits} --speed 3"), "--speed");
    assert_refused(&format!("--distance 5 {limits} 3"), "'3'");
    assert_refused("", "--distance <STEPS> --velocity");
    assert_refused("--velocity 5 --acceleration 5", "--distance");
    assert_refused(
        &format!("--distance 5 {limits} --profile average --jerk 0"),
        "jerk is zero",
    );
    assert_refused(
        &format!("--distance 5 {limits} --profile jerk"),
        "needs --jerk",
    );
    assert_refused(
        &format!("--distance 5 {limits} --profile sin2 --jerk 5"),
        "for the profiles `jerk` and `average` alone",
    );
    assert_refused(&format!("--distance 5 {limits} --profile cubic"), "cubic");
    assert_refused(
        &format!("--distance 5 {limits} --clock 999999"),
        "999999 Hz",
    );
    assert_refused(
        "--distance 5 --velocity 6000000 --acceleration 5",
        "velocity of 6000000 steps/s is too high",
    );
    assert_refused(
        &format!("--distance 5 {limits} --initial-velocity -2147483648"),
        "initial velocity of 2147483648",
    );
    assert_refused(
        &format!("--distance 10 {limits} --end-velocity 999"),
        "the way is too short to come to the end velocity",
    );
    assert_refused(
        &format!("--distance 10000 {limits} --end-velocity 1001"),
        "the end velocity is above the profile velocity",
    );
    assert_refused(
        "--distance 5 --velocity 5 --acceleration 1 --initial-velocity 1000000",
        "out of range",
    );
    assert_refused(
        &format!("--distance 5 {limits} --pulses /no/such/folder/pulses.csv"),
        "cannot write /no/such/folder/pulses.csv: no such file or directory",
    );
    assert_refused(
        &format!("--distance 5 {limits} --plot /no/such/folder/plan.svg"),
        "cannot write /no/such/folder/plan.svg: no such file or directory",
    );
}

#[test]
fn velocities_are_decimals() {
    // One step in 1,000 seconds, and three of them.
    let slow = report("--distance 3 --velocity 0.001 --acceleration 1");
    assert_eq!(slow["pulses"], 3);
    assert_eq!(slow["final_position"], 3);
    assert!(
        (number(&slow, "duration_s") - 3_000.001).abs() < 1e-3,
        "{slow}"
    );
    assert!((number(&slow, "peak_velocity") - 0.001).abs() < 1e-9);
    assert!(number(&slow, "max_step_time_error_s") < 1e-6);
    // An hour a step.
    let hour = report("--distance 1 --velocity 0.000277777778 --acceleration 1");
    assert!(
        (number(&hour, "duration_s") / 3_600.0 - 1.0).abs() < 1e-6,
        "{hour}"
    );
    let passing = report(
        "--distance 10 --velocity 2.5 --acceleration 1 --initial-velocity 0.75 --end-velocity 1.5",
    );
    let phases = passing["phases"].as_array().unwrap();
    let first = phases[0]["velocity"].as_f64().unwrap();
    assert!((first - 0.75).abs() < 1e-9, "{passing}");
    let whole = report("--distance 10 --velocity 2 --acceleration 1");
    assert_eq!(
        whole,
        report("--distance 10 --velocity 2.000 --acceleration 1")
    );
}

#[test]
fn what_is_no_decimal_velocity_is_refused() {
    assert_refused("--distance 1 --velocity 1e3 --acceleration 1", "1e3");
    assert_refused("--distance 1 --velocity 0.0 --acceleration 1", "zero");
    for amount in [
        "--velocity -5",
        "--velocity 5 --end-velocity -4",
        "--velocity -0.5",
    ] {
        assert_refused(
            &format!("--distance -1 {amount} --acceleration 1"),
            "give an amount: the direction is that of the distance",
        );
    }
    assert_refused("--distance 1 --velocity 5 --acceleration -1", "-1 is not");
    assert_refused(
        "--distance 4000000000 --velocity 0.001 --acceleration 1",
        "years",
    );
}
