//! How soon a stop is felt: from the last bit of its frame to the end of the first step that is slower, timed on the pulses.

use sim::plant::STEP_CLOCK_HZ;
use tests::DriveBench;

/// The velocity that is left, in steps/s.
const VELOCITY: i32 = 100_000;

/// Steps/s² of the stop, and of the ramp to the velocity.
const STEEP: u32 = 5_000_000;

/// Steps/s³ of the moving average: half of [`STEEP`] within 2 ms.
const JERK: u32 = 2_500_000_000;

/// Ticks of the step clock in a microsecond.
const MICROSECOND: u64 = STEP_CLOCK_HZ as u64 / 1_000_000;

/// Orders come so many microseconds apart in relation to the control tick, and so to the refills.
const APART: usize = 37;

/// A drive that cruises in profile velocity, with ramps of this profile (6086h), the one of quick stop too.
fn cruising(profile: i16) -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 3);
    drive.write_u32(0x6080, 0, 100_000);
    drive.write_u32(0x607F, 0, 5_000_000);
    for ramp in [0x6083, 0x6084, 0x6085] {
        drive.write_u32(ramp, 0, STEEP);
    }
    drive.write_u32(0x60A4, 1, JERK);
    drive.write_u8(0x20A0, 0, u8::from(profile != 0));
    drive.write_i16(0x6086, 0, profile);
    drive.write_i32(0x60FF, 0, VELOCITY);
    drive.enable();
    drive.run_millis(100);
    drive
}

/// Microseconds from the end of the frame with this controlword to the end of the first step that takes longer than those before.
fn felt_after(drive: &mut DriveBench, controlword: u16) -> u64 {
    drive.axis().plant_mut().pulses_mut().record();
    drive.run_millis(1);
    drive.command(controlword);
    let frame = drive.now().ticks() * MICROSECOND;
    drive.run_millis(40);
    let times = drive.axis().plant().pulses().recorded();
    let steps = || times.windows(2).map(|pair| (pair[1], pair[1] - pair[0]));
    let usual = steps().take_while(|(end, _)| *end <= frame);
    let usual = usual.map(|(_, step)| step).max().expect("a cruise");
    let slower = steps().find(|(_, step)| *step > usual);
    let (end, _) = slower.expect("a slower step");
    (end - frame).div_ceil(MICROSECOND)
}

/// Wherever in the millisecond of a control tick the frame ends. What is committed is played all the same, so it is never felt at once.
#[test]
fn m07_a_stop_is_felt_within_a_millisecond_of_its_frame() {
    for (profile, order) in [
        (0, 0x010F),
        (0, 0x0B),
        (0, 0x07),
        (1, 0x010F),
        (1, 0x0B),
        (3, 0x0B),
        (3, 0x07),
    ] {
        let mut drive = cruising(profile);
        for moment in (0..1_000).step_by(APART) {
            let tick = drive.axis().actuals().at.ticks();
            let behind = drive.now().ticks() - tick;
            drive.run_micros((1_000 + moment - behind) % 1_000);
            let felt = felt_after(&mut drive, order);
            let case =
                format!("6086h = {profile}, {order:X}h {moment} us behind a tick: {felt} us");
            assert!(felt <= 1_000, "{case}");
            assert!(felt > 250, "{case}");
            for controlword in [0x06, 0x07, 0x0F] {
                drive.command(controlword);
                drive.run_millis(5);
            }
            drive.run_millis(50);
        }
    }
}
