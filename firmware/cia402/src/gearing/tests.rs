use super::*;

const RAMPS: Ramps = Ramps {
    couple: 100_000,
    decouple: 50_000,
};

/// A master that turns, and a motor that does what it is told two ticks later.
struct Pair {
    follower: Follower,
    /// Counts and increments with a millionth behind the point.
    master: i64,
    motor: i64,
    waiting: [i64; 2],
}

impl Pair {
    fn new(increments: i64, counts: i64) -> Self {
        let mut follower = Follower::new();
        follower.set_ratio(Ratio::new(increments, counts).unwrap());
        Self {
            follower,
            master: 0,
            motor: 0,
            waiting: [0; 2],
        }
    }

    fn position(&self) -> i64 {
        self.motor.div_euclid(SECOND)
    }

    /// So many milliseconds with so many counts/s. Returns the last velocity, increments/s.
    fn run(&mut self, milliseconds: u32, counts: i64) -> i64 {
        for _ in 0..milliseconds {
            self.master += counts * 1_000;
            let counter = self.master.div_euclid(SECOND) as i32;
            let position = self.position() as i32;
            let speed = self.follower.tick(counter, position, 1_000, &RAMPS);
            self.motor += self.waiting[0] * 1_000;
            self.waiting = [self.waiting[1], speed.bits() >> 32];
        }
        self.waiting[1]
    }
}

#[test]
fn a_ratio_is_in_lowest_terms_and_needs_counts() {
    assert_eq!(Ratio::new(65_536, 1_024), Ratio::new(64, 1));
    assert_eq!(Ratio::new(3, -6), Ratio::new(-1, 2));
    assert_eq!(Ratio::new(1, 0), None);
    assert_eq!(Ratio::new(1 << 40, 3), None);
    assert_eq!(Ratio::new(0, 5), Ratio::new(0, 1));
}

#[test]
fn a_motor_ends_where_its_master_says_however_long_it_was() {
    for (increments, counts) in [(64, 1), (-3, 7), (1, 1_000), (355, 113)] {
        let mut pair = Pair::new(increments, counts);
        pair.run(10, 0);
        pair.follower.couple(Scheme::CatchUp(0), 0);
        for speed in [1_013, -2_000, 3_777, 0] {
            pair.run(20_000, speed);
        }
        let master = pair.master / SECOND;
        let expected = master * increments / counts;
        assert!(
            pair.position().abs_diff(expected) <= 1,
            "{increments}/{counts}"
        );
    }
}

#[test]
fn the_counter_may_pass_its_end() {
    let mut pair = Pair::new(1, 1);
    let start = i64::from(i32::MAX) - 500;
    pair.master = start * SECOND;
    pair.run(200, 0);
    pair.follower.couple(Scheme::CatchUp(0), 0);
    pair.run(1_000, 2_000);
    pair.run(1_000, 0);
    assert!(pair.position().abs_diff(2_000) <= 1, "{}", pair.position());
}

#[test]
fn a_ramp_takes_its_time_and_counts_from_there() {
    let mut pair = Pair::new(10, 1);
    pair.run(200, 5_000);
    pair.follower.couple(Scheme::Ramp, 0);
    let half = pair.run(250, 5_000);
    assert!(half.abs_diff(25_000) < 300, "{half}");
    assert!(!pair.follower.is_synchronised());
    pair.run(300, 5_000);
    assert!(pair.follower.is_synchronised());
    let (from, master) = (pair.position(), pair.master / SECOND);
    pair.run(2_000, 5_000);
    let way = pair.position() - from;
    assert!(way.abs_diff((pair.master / SECOND - master) * 10) < 100);
    pair.follower.decouple();
    let half = pair.run(500, 5_000);
    assert!(half.abs_diff(25_000) < 300, "{half}");
    assert_eq!(pair.run(600, 5_000), 0);
    assert!(!pair.follower.is_at_work());
}

#[test]
fn what_was_missed_is_caught_up_with_and_an_offset_added() {
    let mut pair = Pair::new(10, 1);
    pair.run(200, 5_000);
    let begin = pair.master / SECOND;
    pair.follower.couple(Scheme::CatchUp(3_000), 0);
    pair.run(3_000, 5_000);
    assert!(pair.follower.is_synchronised());
    let expected = (pair.master / SECOND - begin) * 10 + 3_000;
    // Two ticks behind, and the counts of one.
    assert!(pair.position().abs_diff(expected) < 60);
}

#[test]
fn over_a_travel_half_of_it_is_gone() {
    let mut pair = Pair::new(10, 1);
    pair.run(200, 5_000);
    let begin = pair.master / SECOND;
    pair.follower.couple(Scheme::Travel(2_500), 0);
    let half = pair.run(250, 5_000);
    assert!(half.abs_diff(25_000) < 1_000, "{half}");
    assert!(!pair.follower.is_synchronised());
    pair.run(300, 5_000);
    assert!(pair.follower.is_synchronised());
    pair.run(2_000, 0);
    let expected = (pair.master / SECOND - begin) * 10 - 12_500;
    assert!(pair.position().abs_diff(expected) <= 1);
}

#[test]
fn another_ratio_makes_no_jump() {
    let mut pair = Pair::new(10, 1);
    pair.run(200, 5_000);
    pair.follower.couple(Scheme::Ramp, 0);
    pair.run(1_000, 5_000);
    pair.follower.set_ratio(Ratio::new(20, 1).unwrap());
    let half = pair.run(250, 5_000);
    assert!(half.abs_diff(75_000) < 300, "{half}");
    let whole = pair.run(1_000, 5_000);
    assert!(whole.abs_diff(100_000) < 100, "{whole}");
}
