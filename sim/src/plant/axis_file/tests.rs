use super::*;

fn refused(text: &str) -> (Option<usize>, String) {
    Axis::from_toml(text).unwrap_err()
}

#[test]
fn an_empty_file_is_an_axis_with_nothing_along_it() {
    assert_eq!(Axis::from_toml(""), Ok(Axis::default()));
}

#[test]
fn every_key_is_understood() {
    let axis = Axis::from_toml(
        "start = -5\nseed = 7\nencoder = true\nturn = 100\n\
         [stops]\nlow = -10\nhigh = 20\n\
         [negative_limit]\nat = -8\nhysteresis = 2\nbounce_us = 300\nnormally_closed = true\n\
         [positive_limit]\nat = 18\n\
         [home]\nfrom = 3\nto = 6\nhysteresis = 1\n\
         [index]\nfirst = 4\ndistance = 50\n\
         [probe_1]\nfrom = 7\nto = 8\n\
         [probe_2]\nto = 9\n",
    );
    let expected = Axis {
        start: -5,
        seed: 7,
        encoder: true,
        track: Track {
            negative_limit: Some(
                Switch::up_to(-8)
                    .with_hysteresis(2)
                    .bouncing(Duration::from_ticks(300))
                    .normally_closed(),
            ),
            positive_limit: Some(Switch::from(18)),
            home: Some(Switch::within(3..=6).with_hysteresis(1)),
            index: Some(Index {
                first: 4,
                distance: 50,
            }),
            probes: [Some(Switch::within(7..=8)), Some(Switch::up_to(9))],
            stops: Some(-10..=20),
            turn: Some(100),
        },
    };
    assert_eq!(axis, Ok(expected));
}

#[test]
fn a_home_switch_may_reach_to_an_end_of_the_axis() {
    let home = |text: &str| Axis::from_toml(text).unwrap().track.home.unwrap().range;
    assert_eq!(home("[home]\nfrom = 3"), Switch::from(3).range);
    assert_eq!(home("[home]\nto = 3"), Switch::up_to(3).range);
}

#[test]
fn mistakes_are_told_with_their_line() {
    for (text, line, part) in [
        ("start = 1\nspeed = 5\n", Some(2), "speed"),
        ("\n[home]\nfrom = \"three\"\n", Some(3), "three"),
        ("[index]\nfirst = 1\n", Some(1), "distance"),
        ("start = 5000000000\n", Some(1), "5000000000"),
        ("[home\n", Some(1), ""),
    ] {
        let (found, what) = refused(text);
        assert_eq!(found, line, "{text}: {what}");
        assert!(what.contains(part), "{text}: {what}");
        assert!(!what.contains('\n'), "{text}: {what}");
    }
    for (text, part) in [
        ("start = 5\n[stops]\nlow = 6\nhigh = 9\n", "start = 5"),
        ("[home]\nfrom = 6\nto = 5\n", "from = 6"),
        ("[index]\nfirst = 6\ndistance = 0\n", "distance = 0"),
        ("turn = 0\n", "turn = 0"),
    ] {
        let (line, what) = refused(text);
        assert_eq!(line, None, "{text}");
        assert!(what.contains(part), "{text}: {what}");
    }
}

#[test]
fn the_ready_axes_can_be_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("plants");
    let mut count = 0;
    for file in fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        assert!(Axis::read(&path).is_ok(), "{}", path.display());
        count += 1;
    }
    assert!(count >= 3);
}
