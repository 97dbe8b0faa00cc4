//! Where the motor is at each SYNC, to the step: at any speed, in any units, on rotary axes, with SYNC that jitters and a frame that is lost.

use canopen::{Duration, Frame};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::DriveBench;
use tests::drive::OPERATION_ENABLED;

use crate::cyclic_master::{FOLLOWS, latency};

/// Cycles at rest, in which the drive gets in step with SYNC.
const SETTLING: usize = 100;

/// How the drive follows its set-points.
#[derive(Clone, Copy, Debug)]
struct Following {
    /// 7 or 8.
    mode: i8,
    is_cubic: bool,
    /// In microseconds.
    cycle: u64,
}

/// Units, as their objects have them.
#[derive(Clone, Copy, Debug)]
struct Units {
    /// 608Fh, 6091h and 6092h.
    factors: [(u32, u32); 3],
    /// 607Eh bit 7.
    is_reversed: bool,
    /// 607Bh.
    range: Option<(i32, i32)>,
}

impl Units {
    const STEPS: Self = Self {
        factors: [(3_200, 1), (1, 1), (3_200, 1)],
        is_reversed: false,
        range: None,
    };

    /// Steps of so many units.
    fn ratio(self) -> (i128, i128) {
        let [(encoder, of), (motor, shaft), (feed, turns)] = self
            .factors
            .map(|(first, second)| (i128::from(first), i128::from(second)));
        (encoder * motor * turns, of * shaft * feed)
    }

    fn sign(self) -> i128 {
        if self.is_reversed { -1 } else { 1 }
    }

    /// A position on a count that does not wrap, in steps.
    fn steps(self, user: i64) -> i64 {
        let (steps, units) = self.ratio();
        rounded(self.sign() * i128::from(user) * steps, units)
    }

    /// The nearest position to so many steps.
    fn user(self, at: i64) -> i64 {
        let (steps, units) = self.ratio();
        rounded(self.sign() * i128::from(at) * units, steps)
    }

    /// As objects have it.
    fn shown(self, user: i64) -> i32 {
        let Some((low, high)) = self.range else {
            return i32::try_from(user).unwrap();
        };
        let (low, high) = (i64::from(low), i64::from(high));
        i32::try_from((user - low).rem_euclid(high - low + 1) + low).unwrap()
    }
}

/// To the nearest, halves away from zero.
fn rounded(numerator: i128, denominator: i128) -> i64 {
    let half = denominator / 2 * numerator.signum();
    let odd = denominator % 2;
    // (n ± d/2) / d, in halves where the denominator is odd.
    let quotient = if odd == 0 {
        (numerator + half) / denominator
    } else {
        (2 * numerator + denominator * numerator.signum()) / (2 * denominator)
    };
    i64::try_from(quotient).unwrap()
}

/// What gets lost once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Loss {
    SetPoint,
    Sync,
}

struct Bench {
    drive: DriveBench,
    following: Following,
    units: Units,
    next: u64,
    random: u64,
    /// What each cycle has commanded, on a count that does not wrap.
    commanded: Vec<i64>,
    /// 6064h and 6063h of each cycle, where a SYNC came.
    shown: Vec<Option<(i32, i32)>>,
}

impl Bench {
    /// A drive that is Operational, in switch on disabled, is set up.
    fn of(mut drive: DriveBench, following: Following, units: Units, random: u64) -> Self {
        drive.write_u8(0x6060, 0, following.mode.cast_unsigned());
        drive.write_i16(0x60C0, 0, -i16::from(following.is_cubic));
        drive.write_u8(0x60C2, 1, u8::try_from(following.cycle / 1_000).unwrap());
        drive.write_u8(0x60C2, 2, i8::cast_unsigned(-3));
        for (index, (first, second)) in [0x608F, 0x6091, 0x6092].into_iter().zip(units.factors) {
            drive.write_u32(index, 1, first);
            drive.write_u32(index, 2, second);
        }
        drive.write_u8(0x607E, 0, u8::from(units.is_reversed) << 7);
        if let Some((low, high)) = units.range {
            drive.write_i32(0x607B, 1, low);
            drive.write_i32(0x607B, 2, high);
        }
        // No limit but that of the pulses.
        for index in [0x607F, 0x6080, 0x60C5, 0x60C6] {
            drive.write_u32(index, 0, u32::MAX);
        }
        let set_point = if following.mode == 7 {
            0x60C1_0120
        } else {
            0x607A_0020
        };
        remap(&mut drive, 0x1402, 0x4000_0404, [0x6040_0010, set_point]);
        remap(&mut drive, 0x1803, 0x4000_0484, [0x6064_0020, 0x6063_0020]);
        drive.enable();
        drive.drain(5);
        let next = drive.now().ticks() + following.cycle;
        Self {
            drive,
            following,
            units,
            next,
            random,
            commanded: Vec::new(),
            shown: Vec::new(),
        }
    }

    /// −120 ..= 120 µs.
    fn jitter(&mut self) -> i64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        i64::try_from((self.random >> 33) % 241).unwrap() - 120
    }

    fn cycle(&mut self, target: i64, loss: Option<Loss>) {
        self.commanded.push(target);
        if loss != Some(Loss::SetPoint) {
            let controlword = if self.following.mode == 7 { 0x1F } else { 0x0F };
            let mut data = [controlword, 0, 0, 0, 0, 0];
            data[2..].copy_from_slice(&self.units.shown(target).to_le_bytes());
            self.drive.send_frame(Frame::data_frame(0x404, &data));
        }
        let at = self.next.wrapping_add_signed(self.jitter());
        self.next += self.following.cycle;
        self.drive.run_micros(at - self.drive.now().ticks());
        self.drive.drain(0);
        if loss == Some(Loss::Sync) {
            return self.shown.push(None);
        }
        self.drive.send("080 [0]");
        self.drive.run_micros(300);
        let mut shown = None;
        while let Some(frame) = self.drive.next(Duration::micros(0)) {
            if frame.standard_id() == Some(0x484) {
                let (position, steps) = frame.payload().split_at(4);
                let number = |bytes: &[u8]| i32::from_le_bytes(bytes.try_into().unwrap());
                shown = Some((number(position), number(steps)));
            }
        }
        assert!(shown.is_some(), "no TPDO for this SYNC");
        self.shown.push(shown);
    }

    /// A motion from rest to rest, of which a frame may get lost.
    fn play(&mut self, fastest: i64, percents: &[i64], lost: Option<(usize, Loss)>) {
        for _ in 0..SETTLING {
            self.cycle(0, None);
        }
        let set_points = trajectory(self.following, self.units, fastest, percents);
        let end = set_points.last().copied().unwrap_or(0);
        for (k, target) in set_points.into_iter().enumerate() {
            let loss = lost.filter(|(cycle, _)| *cycle == k).map(|(_, loss)| loss);
            self.cycle(target, loss);
        }
        for _ in 0..20 {
            self.cycle(end, None);
        }
    }

    /// After how many cycles the motor is at a set-point.
    fn behind(&self) -> usize {
        latency(self.following.cycle) + usize::from(self.following.is_cubic)
    }

    /// At each SYNC the motor was where a set-point is; at that of a cycle that was `lost`, where the two before it lead.
    fn is_exact(&mut self, lost: Option<usize>) -> Result<(), TestCaseError> {
        let units = self.units;
        let mut passed = 0;
        for k in SETTLING..self.commanded.len() - self.behind() {
            let Some((shown, steps)) = self.shown[k + self.behind()] else {
                continue;
            };
            let [before, last] = [k - 2, k - 1].map(|k| units.steps(self.commanded[k]));
            let target = self.commanded[k];
            let at = if lost == Some(k) {
                2 * last - before
            } else {
                units.steps(target)
            };
            prop_assert_eq!(
                i64::from(steps),
                at,
                "6063h, cycle {} of {:?}",
                k,
                self.following
            );
            // Of units smaller than a step, several are there. None is where larger ones are bridged.
            let near = units.user(at);
            let is_there = |name: &i64| units.steps(*name) == at && units.shown(*name) == shown;
            let is_shown = (near - 50..=near + 50).any(|name| is_there(&name));
            prop_assert!(
                is_shown || units.shown(near) == shown,
                "6064h, cycle {k}: {shown} at {at}"
            );
            passed += usize::from(at != last);
        }
        prop_assert!(passed > 0, "it has not moved");
        let statusword = self.drive.statusword();
        prop_assert!(
            statusword & FOLLOWS != 0 && statusword & 1 << 11 == 0,
            "{statusword:04X}h"
        );
        prop_assert!(OPERATION_ENABLED.is_shown_by(statusword));
        Ok(())
    }
}

/// Gives a synchronous PDO another mapping of two objects.
fn remap(drive: &mut DriveBench, pdo: u16, cob_id: u32, objects: [u32; 2]) {
    drive.write_u32(pdo, 1, cob_id | 1 << 31);
    drive.write_u8(pdo, 2, 1);
    drive.write_u8(pdo + 0x200, 0, 0);
    for (sub, object) in (1..).zip(objects) {
        drive.write_u32(pdo + 0x200, sub, object);
    }
    drive.write_u8(pdo + 0x200, 0, 2);
    drive.write_u32(pdo, 1, cob_id);
}

/// Set-points of a motion with its velocity given every 20 cycles, in percent of `fastest`, in steps/s; straight in between.
fn trajectory(following: Following, units: Units, fastest: i64, percents: &[i64]) -> Vec<i64> {
    let (steps, per) = units.ratio();
    let cycle = i64::try_from(following.cycle).unwrap();
    let mut at = 0_i64;
    let mut before = 0;
    let mut set_points = Vec::new();
    for &percent in percents.iter().chain([&0]) {
        for part in 1..=20 {
            let now = before * (20 - part) + percent * part;
            // Microsteps of 1/2000000000 of a step.
            at += now * fastest / 2_000 * cycle / 1_000_000;
            set_points.push(i64::try_from(i128::from(at) * per / steps).unwrap());
        }
        before = percent;
    }
    set_points
}

fn following() -> impl Strategy<Value = Following> {
    let mode = prop::sample::select(vec![7_i8, 8]);
    let cycle = prop::sample::select(vec![1_000_u64, 2_000, 4_000, 10_000]);
    (mode, any::<bool>(), cycle).prop_map(|(mode, is_cubic, cycle)| Following {
        mode,
        is_cubic,
        cycle,
    })
}

/// Units of 1/50 to 50 steps, by all three factors.
fn units() -> impl Strategy<Value = Units> {
    let encoder = (1..=51_200_u32, 1..=10_u32);
    let gear = (1..=20_u32, 1..=50_u32);
    let size = (1..=50_u32, 1..=50_u32);
    (encoder, gear, 1..=10_u32, size, any::<bool>()).prop_map(
        |(encoder, gear, turns, (steps, of), is_reversed)| {
            let wanted = u64::from(encoder.0 * gear.0) * u64::from(turns * of);
            let feed = wanted.div_ceil(u64::from(encoder.1 * gear.1 * steps));
            Units {
                factors: [encoder, gear, (u32::try_from(feed).unwrap(), turns)],
                is_reversed,
                range: None,
            }
        },
    )
}

/// Percents of the velocity; it begins with at least half of it.
fn percents() -> impl Strategy<Value = Vec<i64>> {
    let later = prop::collection::vec(-100_i64..=100, 2..7);
    (50_i64..=100, any::<bool>(), later).prop_map(|(first, is_back, later)| {
        let first = if is_back { -first } else { first };
        std::iter::once(first).chain(later).collect()
    })
}

/// Plays a motion; returns what there is to look at.
fn play(
    following: Following,
    units: Units,
    fastest: i64,
    percents: &[i64],
    lost: Option<(usize, Loss)>,
    random: u64,
) -> Bench {
    let mut bench = Bench::of(DriveBench::started(4), following, units, random);
    bench.play(fastest, percents, lost);
    bench
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 16, ..ProptestConfig::default() }))]

    /// As it comes, the driver takes a step every 2 µs. A period that jitter has made shorter by half a percent has to do.
    #[test]
    fn m63_at_any_speed_and_in_any_units_the_motor_is_at_a_set_point_at_each_sync(
        following in following(),
        units in units(),
        fastest in 10_000_i64..=440_000,
        percents in percents(),
        random: u64,
    ) {
        let mut bench = play(following, units, fastest, &percents, None, random);
        bench.is_exact(None)?;
    }

    /// Set-points begin anew where the axis does, at both ends of 607Bh and however often.
    #[test]
    fn m59_and_m63_on_a_rotary_axis_each_set_point_is_met_across_its_ends(
        following in following(),
        units in units(),
        share in 0_i64..=100,
        size in 11_i64..=40,
        fastest in 10_000_i64..=440_000,
        percents in percents(),
        random: u64,
    ) {
        // Half a turn is more than the motor is behind the set-points of the master.
        let cycle = i64::try_from(following.cycle).unwrap();
        let (steps, per) = units.ratio();
        let distance = i64::try_from(i128::from(fastest * cycle / 1_000_000) * per / steps).unwrap() + 2;
        let size = distance * size;
        let low = -size * share / 100;
        let ends = [low, low + size].map(|end| i32::try_from(end).unwrap());
        let units = Units { range: Some(ends.into()), ..units };
        let mut bench = play(following, units, fastest, &percents, None, random);
        bench.is_exact(None)?;
    }

    /// A set-point or a SYNC that gets lost is bridged: the motor goes on as in the cycle before, and is at the next set-point.
    #[test]
    fn m63_and_m64_a_frame_that_is_lost_is_bridged_and_all_others_are_met(
        following in following(),
        units in units(),
        fastest in 10_000_i64..=380_000,
        percents in percents(),
        lost in 3_usize..50,
        loss in prop::sample::select(vec![Loss::SetPoint, Loss::Sync]),
        random: u64,
    ) {
        let mut bench = play(following, units, fastest, &percents, Some((lost, loss)), random);
        bench.is_exact(Some(SETTLING + lost))?;
    }
}

/// The most that the driver takes as it comes, and not a step off.
#[test]
fn m63_at_490_000_steps_per_second_the_motor_is_at_a_set_point_at_each_sync() {
    for mode in [7, 8] {
        for is_cubic in [false, true] {
            for cycle in [1_000, 2_000, 4_000, 10_000] {
                let following = Following {
                    mode,
                    is_cubic,
                    cycle,
                };
                let percents = [100, 100, 50, -100, -100];
                let mut bench = play(following, Units::STEPS, 490_000, &percents, None, 1);
                bench.is_exact(None).unwrap();
            }
        }
    }
}

/// Faster than a step in 2 µs the motor is exactly at its set-points as well, but the control tick that looks comes on a whole microsecond: half of
/// one early or late.
#[test]
fn m63_faster_than_500_000_steps_per_second_it_is_off_by_what_half_a_microsecond_is_and_no_more() {
    // LV8729, and 100 ns for each half of a pulse.
    for (driver, fastest) in [(5, 980_000), (255, 4_000_000)] {
        for cycle in [1_000, 2_000, 4_000, 10_000] {
            let following = Following {
                mode: 8,
                is_cubic: false,
                cycle,
            };
            let mut drive = DriveBench::started(4);
            for (sub, nanoseconds) in (2..).zip([100, 100, 100, 100]) {
                drive.write_u32(0x20B0, sub, nanoseconds);
            }
            drive.write_u8(0x20B0, 1, driver);
            let mut bench = Bench::of(drive, following, Units::STEPS, 1);
            bench.play(fastest, &[100, 100, -100, -100], None);
            let behind = bench.behind();
            let off = (SETTLING..bench.commanded.len() - behind).map(|k| {
                let (_, steps) = bench.shown[k + behind].unwrap();
                (i64::from(steps) - bench.commanded[k]).abs()
            });
            let most = fastest / 2_000_000 + 1;
            let off = off.max().unwrap();
            assert!(off <= most, "{fastest} steps/s, {cycle} us: {off} steps");
        }
    }
}
