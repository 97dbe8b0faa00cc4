//! Units of the user, and the divisions behind them.

use cia402::units::{Factors, Range, Ratio, Rotation, SiUnit, Units};
use motion::{div_rem, quotient, SignedSpeed};

use super::{any, any_u64, look};

fn any_i64() -> i64 {
    any_u64().cast_signed()
}

fn any_i32() -> i32 {
    any().cast_signed()
}

fn any_pair() -> (u32, u32) {
    (any(), any())
}

fn look_at(number: i64) {
    look(number as u32 ^ (number >> 32) as u32);
}

pub fn units() {
    if let Some(ratio) = Ratio::of([any(), any(), any()], [any(), any(), any()]) {
        look_at(ratio.to_increments(any_i64()));
        look_at(ratio.to_units(any_i64()));
    }
    let factors = Factors {
        position_encoder: (any() == 0).then(any_pair),
        velocity_encoder: any_pair(),
        gear: any_pair(),
        feed: any_pair(),
        velocity: any_pair(),
        acceleration: any_pair(),
        polarity: any() as u8,
        range: (any_i32(), any_i32()),
    };
    let Some(units) = Units::new(factors) else {
        return;
    };
    look_at(units.position(any_i64()));
    look_at(units.position_in_units(any_i64()));
    look_at(units.distance(any_i32()));
    look_at(units.distance_in_units(any_i32()).into());
    look_at(units.velocity(any_i32()).bits());
    look_at(
        units
            .velocity_in_units(SignedSpeed::from_bits(any_i64()))
            .into(),
    );
    look(units.window(any()));
    look_at(units.speed(any()).bits().cast_signed());
    look_at(units.speed_window(any()).bits().cast_signed());
    look_at(units.motor_speed(any()).bits().cast_signed());
    look(units.acceleration(any()));
    look(units.jerk(any()));
    let range: Range = units.range();
    look_at(range.shown(any_i64()).into());
    look_at(range.turn(any_i64()));
    let (least, most) = range.within_reach(any_i64());
    look_at(least ^ most);
    look_at(range.nearest(any_i64(), any_i64()));
    look_at(range.target(any_i64(), any_i64(), Rotation::of(any() as u16)));
    look(SiUnit::Velocity.is_named_by(any()).into());
    let (whole, rest) = div_rem(any_u64(), any());
    look_at(whole.cast_signed() ^ i64::from(rest));
    let wide = (u128::from(any_u64()) << 64) | u128::from(any_u64());
    look(quotient(wide, any() & 3, wide >> 32) as u32);
}
