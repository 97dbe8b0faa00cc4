//! What SDO reads and what a PDO shows of one control tick.

use canopen::{Duration, Frame};
use tests::DriveBench;

/// TPDO 3 with 6041h and 6064h, TPDO 4 with 606Ch, both by SYNC.
fn with_actual_values() -> DriveBench {
    let mut drive = DriveBench::enabled(4);
    drive.write_u8(0x1802, 2, 1);
    drive.write_u32(0x1803, 1, 0x8000_0484);
    drive.write_u8(0x1A03, 0, 0);
    drive.write_u32(0x1A03, 1, 0x606C_0020);
    drive.write_u8(0x1A03, 0, 1);
    drive.write_u8(0x1803, 2, 1);
    drive.write_u32(0x1803, 1, 0x484);
    drive
}

/// A number at the front of these bytes.
fn number(bytes: &[u8]) -> i32 {
    match *bytes {
        [a, b, c, d, ..] => i32::from_le_bytes([a, b, c, d]),
        [a, b] => u16::from_le_bytes([a, b]).into(),
        _ => panic!("{bytes:?}"),
    }
}

#[test]
fn m72_what_sdo_reads_is_what_the_pdo_of_the_same_tick_shows() {
    let mut drive = with_actual_values();
    // Slow ramps: for half a second each tick has another velocity.
    drive.write_u32(0x6083, 0, 20_000);
    drive.begin_move(100_000);
    drive.drain(1);
    let mut compared = [0; 3];
    let mut velocities = Vec::new();
    for round in 0..300_u64 {
        drive.drain(1);
        drive.run_micros(round * 37 % 1_000);
        let tick = drive.axis().actuals().at;
        drive.send("080 [0]");
        let which = usize::try_from(round % 3).unwrap();
        let [low, high] = [0x6041_u16, 0x6064, 0x606C][which].to_le_bytes();
        drive.send_frame(Frame::data_frame(0x604, &[0x40, low, high, 0, 0, 0, 0, 0]));
        let mut shown = [None; 3];
        let mut read = None;
        while read.is_none() {
            let frame = drive.next(Duration::millis(5)).unwrap();
            let bytes = frame.bytes();
            match frame.standard_id() {
                Some(0x384) => {
                    shown[0] = Some(number(&bytes[..2]));
                    shown[1] = Some(number(&bytes[2..]));
                }
                Some(0x484) => shown[2] = Some(number(bytes)),
                Some(0x584) => {
                    assert_eq!(bytes[1..4], [low, high, 0]);
                    let size = if which == 0 { 2 } else { 4 };
                    read = Some(number(&bytes[4..4 + size]));
                }
                _ => {}
            }
        }
        if drive.axis().actuals().at != tick {
            // There was a tick in between.
            continue;
        }
        assert!(
            shown[which].is_some(),
            "the PDO was there before the answer"
        );
        assert_eq!(read, shown[which], "round {round}, object {low:02X}h");
        compared[which] += 1;
        velocities.extend(shown[2]);
    }
    assert!(compared.iter().all(|&count| count > 20), "{compared:?}");
    velocities.dedup();
    assert!(velocities.len() > 60, "they are not all the same");
}
