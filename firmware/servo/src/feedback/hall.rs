//! Hall sensors: three, a third of an electrical turn apart, each high for half a turn.
//!
//! Sensor A, in bit 0, is high from −90° to 90° of the magnet. Six words tell a sixth of a turn each; two, all high and all low, tell that a wire is
//! broken.

use super::FeedbackFault;
use crate::Angle;

/// A sixth of a turn.
const SECTOR: u32 = 715_827_883;

/// The middle of the sixth in which the magnet is. It is at most 30° away.
///
/// # Errors
/// All say the same.
pub fn angle(word: u8) -> Result<Angle, FeedbackFault> {
    // The sensors that are high are those next to the magnet.
    let sixths = match word {
        0b001 => 0,
        0b011 => 1,
        0b010 => 2,
        0b110 => 3,
        0b100 => 4,
        0b101 => 5,
        _ => return Err(FeedbackFault::Hall),
    };
    Ok(Angle::from_bits(SECTOR.wrapping_mul(sixths)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use servo_plant::Plant;
    use servo_plant::axes::SERVO_100W;

    #[test]
    fn the_magnet_is_within_30_degrees() {
        for step in 0..360 {
            let degrees = f64::from(step) + 0.5;
            let plant = Plant::new(SERVO_100W, 1).turning((degrees / 4.0).to_radians(), 0.0);
            let found = angle(plant.clone().measure().hall).unwrap();
            let away = found.minus(Angle::from_turns(degrees as f32 / 360.0));
            assert!(away.turns().abs() < 30.1 / 360.0, "at {degrees}");
        }
        assert_eq!(angle(0b000), Err(FeedbackFault::Hall));
        assert_eq!(angle(0b111), Err(FeedbackFault::Hall));
    }
}
