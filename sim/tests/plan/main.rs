//! `sim plan` as a person or a script meets it: durations, pulses, errors, files.

use std::process::{Command, Output};

use serde_json::Value;

mod refusals;

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sim"));
    command.arg("plan").args(arguments).output().unwrap()
}

/// The report of a move in JSON.
fn report(arguments: &str) -> Value {
    let arguments: Vec<_> = arguments.split_whitespace().chain(["--json"]).collect();
    let output = run(&arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap()
}

/// One line on standard error that holds `part`, nothing else, and exit code 2.
fn assert_refused(arguments: &str, part: &str) {
    let output = run(&arguments.split_whitespace().collect::<Vec<_>>());
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments}: {error}");
    assert_eq!(error.lines().count(), 1, "{arguments}: {error}");
    assert!(error.contains(part), "{arguments}: {error}");
    assert!(output.stdout.is_empty(), "{arguments}");
}

/// A decimal of the vectors, which are written as text.
fn decimal(vector: &Value, key: &str) -> f64 {
    match &vector[key] {
        Value::String(text) => text.parse().unwrap(),
        value => value.as_f64().unwrap(),
    }
}

/// The reference vectors of trapezoids, at the default clock. Those over the full span of positions (T09, T10) are left
/// to the tests of the planner.
#[test]
fn the_reference_moves_take_their_time_and_land() {
    let vectors = include_str!("../../../firmware/motion/tests/motion-vectors.json");
    let vectors: Value = serde_json::from_str(vectors).unwrap();
    let mut checked = 0;
    for vector in vectors["trapezoid"].as_array().unwrap() {
        let distance = decimal(vector, "S");
        if distance > 1e9 {
            continue;
        }
        let report = report(&format!(
            "--distance {distance} --velocity {} --acceleration {} --deceleration {} --initial-velocity {}",
            decimal(vector, "vmax"),
            decimal(vector, "a"),
            decimal(vector, "d"),
            decimal(vector, "v0"),
        ));
        let name = &vector["name"];
        let late = number(&report, "duration_s") - decimal(vector, "T");
        // A tick of 6 ns; the start velocity is rounded.
        assert!(
            (-1e-9..1e-8 + 1e-9 * decimal(vector, "T")).contains(&late),
            "{name}: {late} s late"
        );
        assert_eq!(report["final_position"], distance as i64, "{name}");
        let seconds = number(&report, "duration_ticks") / 168e6;
        assert!(
            (seconds - number(&report, "duration_s")).abs() < 1e-12,
            "{name}"
        );
        let (low, high) = (decimal(vector, "xmin"), decimal(vector, "xmax"));
        let way = (high - low) + (high - low - distance.abs());
        let pulses = number(&report, "pulses");
        assert!(
            (pulses - way).abs() <= 2.0,
            "{name}: {pulses} pulses for {way}"
        );
        let fastest = decimal(vector, "vpeak")
            .abs()
            .max(decimal(vector, "v0").abs());
        let peak = number(&report, "peak_velocity");
        assert!((peak / fastest - 1.0).abs() < 1e-5, "{name}: {peak}");
        // The ramp of T20 is over within a time slice.
        let most = if decimal(vector, "a") > 5e6 { 0.5 } else { 0.1 };
        let error = number(&report, "max_position_error_steps");
        assert!(0.0 < error && error <= most, "{name}: {error}");
        checked += 1;
    }
    assert_eq!(checked, 20);
}

#[cfg(not(feature = "limited-jerk"))]
#[test]
fn limited_jerk_has_to_be_built_in() {
    let arguments = "--distance 1000 --velocity 1000 --acceleration 5000 --jerk 10000";
    assert_refused(arguments, "limited jerk is not built in");
}

/// The jerk-limited reference vectors: the fastest move there is.
#[cfg(feature = "limited-jerk")]
#[test]
fn jerk_limited_moves_take_the_least_time() {
    let vectors = include_str!("../../../firmware/motion/tests/motion-vectors.json");
    let vectors: Value = serde_json::from_str(vectors).unwrap();
    let vectors = vectors["jerk"].as_array().unwrap();
    for vector in vectors {
        let distance = decimal(vector, "S");
        let report = report(&format!(
            "--distance {distance} --velocity {} --acceleration {} --jerk {}",
            decimal(vector, "v"),
            decimal(vector, "a"),
            decimal(vector, "j"),
        ));
        let name = &vector["name"];
        let late = number(&report, "duration_s") - decimal(vector, "T_opt");
        assert!((-1e-9..2e-8).contains(&late), "{name}: {late} s late");
        assert_eq!(report["final_position"], distance as i64, "{name}");
        assert_eq!(report["pulses"], distance as i64, "{name}");
        assert!(number(&report, "max_position_error_steps") <= 0.1, "{name}");
    }
    assert_eq!(vectors.len(), 6);
}

#[test]
fn sin2_takes_as_long_as_the_trapezoid() {
    let move_by = "--distance 30000 --velocity 100000 --acceleration 500000 --deceleration 250000";
    let trapezoid = report(move_by);
    let sine = report(&format!("{move_by} --profile sin2"));
    assert_eq!(sine["duration_ticks"], trapezoid["duration_ticks"]);
    assert_eq!(sine["pulses"], 30_000);
    assert_eq!(sine["final_position"], 30_000);
    let peaks = number(&sine, "peak_velocity") - number(&trapezoid, "peak_velocity");
    assert!(peaks.abs() < 1.0, "{peaks}");
    assert!(number(&sine, "max_position_error_steps") <= 0.1);
}

#[test]
fn the_average_comes_to_rest_a_window_behind_the_trapezoid() {
    // 100 ms where there is a cruise as long as that, 200 ms where one ramp follows the other.
    for (distance, window) in [(100_000, 0.1), (-30_000, 0.2)] {
        let move_by = format!("--distance {distance} --velocity 200000 --acceleration 500000");
        let trapezoid = report(&move_by);
        let average = report(&format!("{move_by} --profile average --jerk 5000000"));
        let late = number(&average, "duration_s") - number(&trapezoid, "duration_s") - window;
        assert!((-1e-6..4e-4).contains(&late), "{late} s");
        assert_eq!(average["final_position"], distance);
        assert_eq!(average["pulses"], i64::from(distance).abs());
        assert!(number(&average, "max_position_error_steps") <= 0.1);
        let phases = average["phases"].as_array().unwrap();
        assert!((5..=9).contains(&phases.len()), "{phases:#?}");
        let all: f64 = phases.iter().map(|phase| number(phase, "duration_s")).sum();
        assert!((all - number(&average, "duration_s")).abs() < 1e-9);
    }
    let refused = "--distance 5 --velocity 9 --acceleration 9 --profile average";
    assert_refused(refused, "needs --jerk");
    assert_refused(
        &format!("{refused} --jerk 9 --end-velocity 3"),
        "ends at rest",
    );
}

/// Kind, velocity at the end, acceleration at the start and at the end, and the greatest one, of each phase.
fn phases(report: &Value) -> Vec<(&str, [f64; 4])> {
    let phases = report["phases"].as_array().unwrap().iter();
    let keys = [
        "end_velocity",
        "acceleration",
        "end_acceleration",
        "peak_acceleration",
    ];
    phases
        .map(|phase| {
            let kind = phase["kind"].as_str().unwrap();
            (kind, keys.map(|key| number(phase, key)))
        })
        .collect()
}

fn assert_phases(report: &Value, expected: &[(&str, [f64; 4])]) {
    let phases = phases(report);
    let kinds = |phases: &[(&str, _)]| phases.iter().map(|phase| phase.0.to_owned()).collect();
    let (is, should): (Vec<_>, Vec<_>) = (kinds(&phases), kinds(expected));
    assert_eq!(is, should);
    for ((kind, is), (_, should)) in phases.iter().zip(expected) {
        // A sin² ramp is made of cubic pieces, the greatest acceleration of which is a little less.
        let near = if *kind == "sin2" { 1e-3 } else { 0.0 };
        for (is, should) in is.iter().zip(should) {
            let off = (is - should).abs();
            assert!(
                off <= 1.0 + near * should.abs(),
                "{kind}: {is} is not {should}"
            );
        }
    }
}

#[test]
fn phases_tell_what_smooth_ramps_do() {
    let (top, pull) = (100_000.0, 500_000.0);
    let cruise = ("cruise", [top, 0.0, 0.0, 0.0]);
    let move_by = "--distance 100000 --velocity 100000 --acceleration 500000";
    let ramp = |to, pull| ("acceleration", [to, pull, pull, pull]);
    assert_phases(
        &report(move_by),
        &[ramp(top, pull), cruise, ramp(0.0, -pull)],
    );
    // The acceleration of a sin² ramp begins and ends with 0, and is π/2 of the mean in the middle.
    let peak = pull * std::f64::consts::FRAC_PI_2;
    let ramp = |to, peak| ("sin2", [to, 0.0, 0.0, peak]);
    assert_phases(
        &report(&format!("{move_by} --profile sin2")),
        &[ramp(top, peak), cruise, ramp(0.0, -peak)],
    );
    #[cfg(feature = "limited-jerk")]
    {
        let growing = |to, pull| ("jerk", [to, 0.0, pull, pull]);
        let kept = |to, pull| ("acceleration", [to, pull, pull, pull]);
        let falling = |to, pull| ("jerk", [to, pull, 0.0, pull]);
        assert_phases(
            &report(&format!("{move_by} --jerk 5000000")),
            &[
                growing(25_000.0, pull),
                kept(75_000.0, pull),
                falling(top, pull),
                cruise,
                growing(75_000.0, -pull),
                kept(25_000.0, -pull),
                falling(0.0, -pull),
            ],
        );
    }
    // The mean changes its acceleration with each time slice of 250 µs, a 400th part.
    let average = report(&format!("{move_by} --jerk 5000000 --profile average"));
    let kinds: Vec<_> = (phases(&average).iter())
        .map(|phase| phase.0.to_owned())
        .collect();
    let expected = [
        "jerk",
        "acceleration",
        "jerk",
        "cruise",
        "jerk",
        "acceleration",
        "jerk",
    ];
    assert_eq!(kinds, expected);
    assert!((phases(&average)[3].1[0] - top).abs() < 1e-3);
}

#[test]
fn text_tells_the_phases_that_can_be_seen() {
    let move_by = "--distance -100000 --velocity 100000 --acceleration 500000";
    let text = |arguments: &str| {
        let output = run(&arguments.split_whitespace().collect::<Vec<_>>());
        String::from_utf8(output.stdout).unwrap()
    };
    let sine = text(&format!("{move_by} --profile sin2"));
    let ramp = "0.000000000 to -100000.000000000 steps/s, sin², -785082.0 steps/s² at most\n";
    assert!(sine.contains(ramp), "{sine}");
    assert!(
        sine.contains("-100000.000000000 steps/s, cruise\n"),
        "{sine}"
    );
    #[cfg(feature = "limited-jerk")]
    {
        let jerk = text(&format!("{move_by} --jerk 5000000"));
        assert!(jerk.contains(" 0.0 to -500000.0 steps/s²\n"), "{jerk}");
    }
    // A triangle whose top falls between two ticks has a phase of one tick there.
    let triangle = "--distance 20000 --velocity 100000 --acceleration 500000";
    let phases = report(triangle)["phases"].as_array().unwrap().len();
    let shown = text(triangle)
        .lines()
        .filter(|line| line.starts_with("from"))
        .count();
    assert_eq!((phases, shown), (3, 2));
}

#[test]
fn pulses_stay_close_to_the_plan_at_high_rates() {
    let half = report("--distance 500000 --velocity 500000 --acceleration 2000000");
    assert!(number(&half, "max_position_error_steps") <= 0.1);
    let full = report("--distance 500000 --velocity 1000000 --acceleration 5000000");
    assert!(number(&full, "max_position_error_steps") <= 0.5);
    assert!(number(&full, "max_step_time_error_s") <= 25e-6);
}

/// Every pulse of the file against the trapezoid in closed form: none is further from it than the report says.
#[test]
fn the_greatest_error_is_that_of_the_worst_pulse() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pulses.csv");
    let (distance, top, ramp) = (300_000.0, 1e6, 5e6);
    let report = report(&format!(
        "--distance 300000 --velocity 1000000 --acceleration 5000000 --pulses {}",
        path.to_str().unwrap()
    ));
    let end = number(&report, "duration_s");
    let travelled = |t: f64| match t {
        _ if t < top / ramp => ramp * t * t / 2.0,
        _ if end - t < top / ramp => distance - ramp * (end - t) * (end - t) / 2.0,
        _ => top * top / ramp / 2.0 + (t - top / ramp) * top,
    };
    let text = std::fs::read_to_string(&path).unwrap();
    let mut worst = 0.0f64;
    for line in text.lines().skip(1) {
        let (tick, position) = line.split_once(',').unwrap();
        let (tick, position): (f64, f64) = (tick.parse().unwrap(), position.parse().unwrap());
        worst = worst.max((travelled(tick / 168e6) - (position - 0.5)).abs());
    }
    let told = number(&report, "max_position_error_steps");
    assert!((told - worst).abs() < 1e-4, "{told} is not {worst}");
    assert!(worst > 0.1, "{worst}");
}

/// The pulses of 63 years are not played, and nobody has to wait to learn it.
#[test]
fn a_move_too_long_to_play_is_refused() {
    assert_refused(
        "--distance 2000000000 --velocity 1 --acceleration 1",
        "takes 23148 days",
    );
}

#[test]
fn longer_time_slices_than_the_drives_are_told() {
    let arguments = "--distance 2600 --velocity 1 --acceleration 1";
    let output = run(&arguments.split_whitespace().collect::<Vec<_>>());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("time slices of 0.000260 s"), "{text}");
    let time_slice = number(&report(arguments), "segment_s");
    assert!((time_slice - 2_601.0 / 10e6).abs() < 1e-8, "{time_slice}");
}

#[test]
fn the_pulses_of_the_file_are_those_of_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pulses.csv");
    let file = path.to_str().unwrap();
    let report = report(&format!(
        "--distance -300 --velocity 10000 --acceleration 100000 --pulses {file}"
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("tick,position"));
    let pulses: Vec<(u64, i64)> = lines
        .map(|line| {
            let (tick, position) = line.split_once(',').unwrap();
            (tick.parse().unwrap(), position.parse().unwrap())
        })
        .collect();
    assert_eq!(pulses.len(), 300);
    assert_eq!(report["pulses"], 300);
    assert!(
        pulses
            .windows(2)
            .all(|pair| pair[0].0 < pair[1].0 && pair[0].1 - 1 == pair[1].1)
    );
    assert_eq!(pulses.last().unwrap().1, -300);
    assert!(pulses.last().unwrap().0 < report["duration_ticks"].as_u64().unwrap());
    // The first step comes when half of it is done: ½ = ½·a·t².
    let first = pulses[0].0 as f64 / 168e6;
    assert!(
        (first - (1.0f64 / 100_000.0).sqrt()).abs() < 25e-6,
        "{first}"
    );
}

#[test]
fn a_move_may_end_with_a_velocity() {
    let report =
        report("--distance 10000 --velocity 20000 --acceleration 100000 --end-velocity 5000");
    // Up to 20,000 steps/s in 2,000 steps, down to 5,000 in 1,875.
    let duration = 0.2 + 6_125.0 / 20_000.0 + 0.15;
    assert!((number(&report, "duration_s") - duration).abs() < 1e-6);
    assert_eq!(report["final_position"], 10_000);
    assert_eq!(report["pulses"], 10_000);
    assert_eq!(report["phases"].as_array().unwrap().len(), 3);
}

#[test]
fn the_clock_changes_the_ticks_and_not_the_time() {
    let report = report("--distance 1000 --velocity 1000 --acceleration 10000 --clock 1000000");
    assert!((number(&report, "duration_s") - 1.1).abs() < 2e-6);
    assert_eq!(report["duration_ticks"], 1_100_000);
}

#[test]
fn the_picture_shows_position_velocity_and_acceleration() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.svg");
    let file = path.to_str().unwrap();
    report(&format!(
        "--distance 1000 --velocity 1000 --acceleration 10000 --plot {file}"
    ));
    let picture = std::fs::read_to_string(&path).unwrap();
    assert!(picture.starts_with("<svg"));
    for name in ["Position", "Velocity", "Acceleration"] {
        assert!(picture.contains(name), "{name}");
    }
}

#[test]
fn without_json_there_is_text() {
    let output = run(&[
        "--distance",
        "100000",
        "--velocity",
        "100000",
        "--acceleration",
        "500000",
    ]);
    let text = String::from_utf8(output.stdout).unwrap();
    for part in [
        "1.200000000 s",
        "201600000 ticks",
        "100000, to step 100000",
        "500000.0 steps/s²",
    ] {
        assert!(text.contains(part), "{text}");
    }
}
