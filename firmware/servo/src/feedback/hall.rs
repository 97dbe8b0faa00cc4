//! Hall sensors: three, a third of an electrical turn apart, each high for half a turn.
//!
//! Sensor A, in bit 0, is high from −90° to 90° of the magnet. Six words tell a sixth of a turn each; two, all high and all low, tell that a wire is
//! broken.
//!
//! Beside an encoder they tell where the magnet is without a search: the middle of a sixth at first, and its very end at the first edge. From then on the
//! encoder must stay within 70° of what they tell.

use super::FeedbackFault;
use crate::Angle;

/// A sixth of a turn.
const SECTOR: u32 = 715_827_883;

/// How far the encoder may be from the middle of the sixth, in parts of 2³² of a turn: 70°. Until the first edge it is up to 60° away.
const APART: u32 = 835_132_530;

/// The words in the order in which the magnet passes them forward, from 0 on.
pub const ORDER: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];

/// The middle of the sixth in which the magnet is. It is at most 30° away.
///
/// # Errors
/// All say the same.
pub fn angle(word: u8) -> Result<Angle, FeedbackFault> {
    // The sensors that are high are those next to the magnet.
    let mut sixths = (0..).zip(ORDER);
    let sixth = sixths.find(|(_, known)| *known == word);
    let (sixth, _) = sixth.ok_or(FeedbackFault::Hall)?;
    Ok(Angle::from_bits(SECTOR.wrapping_mul(sixth)))
}

/// Hall sensors beside an encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hall {
    last: Option<Angle>,
    /// An edge was seen.
    is_exact: bool,
}

impl Hall {
    /// The sensors say this while the magnet is at `encoder` by the encoder. Returns where it is, if that is known better.
    ///
    /// # Errors
    /// They say what cannot be, or are not where the encoder is; the next look begins anew.
    pub fn look(&mut self, word: u8, encoder: Angle) -> Result<Option<Angle>, FeedbackFault> {
        let before = core::mem::take(self);
        let middle = angle(word)?;
        let Some(last) = before.last else {
            self.last = Some(middle);
            return Ok(Some(middle));
        };
        let turned = middle.minus(last).bits().cast_signed();
        let edge = last.plus(Angle::from_bits((turned / 2).cast_unsigned()));
        let is_edge = turned != 0 && !before.is_exact;
        let known = if is_edge { edge } else { encoder };
        let apart = |angle: Angle| middle.minus(angle).bits().cast_signed().unsigned_abs();
        if apart(encoder) > APART || apart(known) > APART {
            return Err(FeedbackFault::Hall);
        }
        (self.last, self.is_exact) = (Some(middle), before.is_exact || is_edge);
        Ok(is_edge.then_some(edge))
    }
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

    #[test]
    fn the_first_edge_tells_the_angle_and_the_encoder_is_held_against_it() {
        let turns = |angle: Angle| (angle.turns() * 360.0).round() as i32;
        let mut hall = Hall::default();
        // The middle of the sixth first, whatever the encoder says; then the edge to the next, on either side.
        let found = hall.look(0b011, Angle::HALF).unwrap();
        assert_eq!(found.map(turns), Some(60));
        let there = Angle::from_turns(1.0 / 6.0);
        assert_eq!(hall.look(0b011, there), Ok(None));
        let mut back = hall;
        assert_eq!(
            hall.look(0b010, there).map(|angle| angle.map(turns)),
            Ok(Some(90))
        );
        assert_eq!(
            back.look(0b001, there).map(|angle| angle.map(turns)),
            Ok(Some(30))
        );
        // From then on the encoder goes on, up to 70° from the middle.
        for (degrees, is_right) in [
            (120.0, true),
            (60.0, true),
            (189.0, true),
            (191.0, false),
            (49.0, false),
        ] {
            let told = hall.clone().look(0b010, Angle::from_turns(degrees / 360.0));
            assert_eq!(
                told,
                if is_right {
                    Ok(None)
                } else {
                    Err(FeedbackFault::Hall)
                }
            );
        }
        // No sixth is left out, and none says what cannot be; it begins anew.
        let at = Angle::from_turns(0.25);
        assert_eq!(back.look(0b100, at), Err(FeedbackFault::Hall));
        assert_eq!(hall.look(0b111, at), Err(FeedbackFault::Hall));
        assert_eq!(
            hall.look(0b100, at).map(|angle| angle.map(turns)),
            Ok(Some(-120))
        );
    }
}
