//! Homing through the debounce time 2033h: an edge is noticed when the motor may be elsewhere, or on its way back already. Home is the edge
//! that the method names, or homing fails.

use canopen::Duration;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use sim::drive::Setup;
use sim::plant::{Axis, Index, Switch, Track};
use tests::DriveBench;
use tests::drive::{SWITCH_ON_DISABLED, TARGET_REACHED};

/// Statusword bit 12 in homing.
const ATTAINED: u16 = 1 << 12;
/// Statusword bit 13 in homing.
const ERROR: u16 = 1 << 13;

const NEGATIVE_LIMIT: i64 = -16_000;
const POSITIVE_LIMIT: i64 = 16_000;
const HOME: i64 = 2_000;

/// What a homing is tried with.
#[derive(Clone, Copy, Debug)]
struct Trial {
    method: i8,
    start: i64,
    /// From edge to edge of a home switch in the middle.
    width: i64,
    hysteresis: u32,
    /// From one index pulse to the next.
    index: u32,
    /// 2033h in milliseconds.
    debounce: u8,
    /// How long contacts bounce, in percent of it.
    bounce: u8,
    /// 6099h.
    search: u32,
    zero: u32,
    /// 609Ah.
    acceleration: u32,
    seed: u64,
}

/// The home switch looked for is in the middle, so that the motor may pass it unseen.
fn is_window(method: i8) -> bool {
    matches!(method, 7..=14 | 23..=30)
}

impl Trial {
    fn axis(&self) -> Axis {
        let fit = |switch: Switch| {
            let bounce = u64::from(self.debounce) * u64::from(self.bounce) * 10;
            switch
                .with_hysteresis(self.hysteresis)
                .bouncing(Duration::from_ticks(bounce))
        };
        let home = match self.method {
            3 | 4 | 19 | 20 => Switch::from(HOME),
            5 | 6 | 21 | 22 => Switch::up_to(HOME),
            _ => Switch::within(HOME..=HOME + self.width),
        };
        Axis {
            track: Track {
                negative_limit: Some(fit(Switch::up_to(NEGATIVE_LIMIT))),
                positive_limit: Some(fit(Switch::from(POSITIVE_LIMIT))),
                home: Some(fit(home)),
                index: Some(Index::new(40, self.index)),
                ..Track::default()
            },
            start: self.start,
            seed: self.seed,
            ..Axis::default()
        }
    }

    /// Where home is.
    fn home(&self) -> i64 {
        let hysteresis = i64::from(self.hysteresis);
        let right = HOME + self.width;
        let edge_of = |method: i8| match method {
            17 => (NEGATIVE_LIMIT, 1),
            18 => (POSITIVE_LIMIT, -1),
            20 | 21 | 24 | 29 => (HOME, 1),
            19 | 22 | 23 | 30 => (HOME, -1),
            25 | 28 => (right, -1),
            _ => (right, 1),
        };
        let has_index = self.method < 15;
        let (edge, direction) = edge_of(if has_index {
            self.method + 16
        } else {
            self.method
        });
        let edge = edge + direction * hysteresis;
        if !has_index {
            return edge;
        }
        // The first index pulse behind it.
        let (index, first) = (i64::from(self.index), 40);
        if direction > 0 {
            edge + index - (edge - first).rem_euclid(index)
        } else {
            edge - index + (first - edge).rem_euclid(index)
        }
    }

    /// The switch is seen at any speed, and wide enough to stop within at zero speed.
    fn is_seen(&self) -> bool {
        // The time for which a bouncing contact is open again counts back.
        let bouncing = u32::from(self.debounce) * u32::from(self.bounce) / 50;
        let noticed = u32::from(self.debounce) + bouncing + 4;
        let search = i64::from(self.search) * i64::from(noticed) / 1_000;
        let zero = i64::from(self.zero) * i64::from(self.zero) / i64::from(self.acceleration);
        !is_window(self.method) || self.width > 2 * i64::from(self.hysteresis) + search + zero
    }

    /// Homes; where home was found, or 2034h:2.
    fn run(&self) -> Result<i64, u8> {
        let mut drive = DriveBench::with(
            Setup {
                axis: Some(self.axis()),
                ..Setup::with_node_id(1, 4)
            },
            4,
        );
        drive.start();
        drive.reaches(SWITCH_ON_DISABLED, 20);
        drive.write_u8(0x2033, 0, self.debounce);
        // The switches of the start are seen.
        drive.run_millis(200);
        drive.write_u8(0x6060, 0, 6);
        drive.write_u8(0x6098, 0, self.method.cast_unsigned());
        drive.write_u32(0x6099, 1, self.search);
        drive.write_u32(0x6099, 2, self.zero);
        drive.write_u32(0x609A, 0, self.acceleration);
        drive.enable();
        drive.run_millis(5);
        drive.command(0x1F);
        drive.run_millis(4);
        for _ in 0..12_000 {
            match drive.statusword() & (ERROR | ATTAINED | TARGET_REACHED) {
                bits if bits & TARGET_REACHED == 0 => drive.run_millis(10),
                bits if bits & ERROR != 0 => return Err(drive.read_u8(0x2034, 2)),
                _ => {
                    let shown = drive.read_i32(0x6064, 0);
                    return Ok(drive.axis().plant().rotor() - i64::from(shown));
                }
            }
        }
        panic!("{self:?} goes on for ever, at {}", drive.position());
    }
}

#[test]
fn d25_an_edge_noticed_on_the_way_back_is_where_and_how_it_was_passed() {
    // 40 steps to stop from 9,000 steps/s; the edge is noticed 450 steps later. From there, on the way back, the switch is entered again.
    for (method, start, width) in [
        (24, 0, 460),
        (23, 0, 460),
        (25, 9_000, 460),
        (26, 9_000, 460),
        (28, 9_000, 460),
        (27, 9_000, 460),
        (30, 9_000, 460),
        (10, 9_000, 460),
        (7, 0, 460),
    ] {
        let trial = Trial {
            method,
            start,
            width,
            hysteresis: 0,
            index: 3_200,
            debounce: 50,
            bounce: 0,
            search: 9_000,
            zero: 1_000,
            acceleration: 1_000_000,
            seed: 0,
        };
        match trial.run() {
            Ok(home) => assert_eq!(home, trial.home(), "{trial:?}"),
            Err(failure) => assert_eq!(failure, 6, "{trial:?}"),
        }
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(60)))]

    #[test]
    fn d25_whatever_the_debounce_home_is_the_right_edge_or_an_error(
        (which, start, width, hysteresis) in (0i8..28, -16_500i64..16_500, 5u64..300, 0u32..20),
        (index, debounce, bounce) in (200u32..3_200, 0u8..=100, 0u8..=50),
        (search, zero) in (1_000u32..60_000).prop_flat_map(|search| (Just(search), 200..=search.min(8_000))),
        acceleration in 20_000u32..5_000_000,
        seed: u64,
    ) {
        let method = if which < 14 { which + 1 } else { which + 3 };
        // In percent of the distance from an edge to where the motor comes to rest behind it.
        let (v, a) = (u64::from(search), u64::from(acceleration));
        let rests = v * u64::from(debounce) / 1_000 + v * v / (2 * a);
        let width = i64::from(2 * hysteresis + 2).max((rests * width / 100).min(8_000) as i64);
        let trial = Trial { method, start, width, hysteresis, index, debounce, bounce, search, zero, acceleration, seed };
        match trial.run() {
            Ok(home) => prop_assert_eq!(home, trial.home(), "{:?}", trial),
            Err(failure) => prop_assert!(failure == 6 && !trial.is_seen(), "{} in {:?}", failure, trial),
        }
    }
}
