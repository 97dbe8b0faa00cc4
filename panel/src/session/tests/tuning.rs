//! The page Tuning: the motor is measured and written when a person says so, stopped at any moment, guarded as any other motion.

use sim::ServoDrive;
use sim::plant::{Axis, ServoAxisData};

use super::*;
use crate::desk::Counts;
use crate::message::{Tuned, TuningWish, Wish};

impl Bench {
    /// With a servo on a ready axis, that is chosen.
    fn servo(read_only: bool) -> (Self, Handle<ServoDrive>) {
        let data = ServoAxisData::named("servo_100w").unwrap().at_work();
        let mut setup = DriveSetup::with_node_id(1, NODE);
        setup.axis = Some(Axis::servo(&data));
        let (mut bench, drive) = Self::with_station(ServoDrive::new(setup), read_only);
        bench.done(Order::Choose { node: NODE });
        bench.run_for(300);
        (bench, drive)
    }

    fn tuned_of(&mut self, window: u64) -> Tuned {
        match self.order_of(window, Order::Tuned) {
            Outcome::Done(Answer::Tuned(tuned)) => *tuned,
            other => panic!("{other:?}"),
        }
    }

    fn tuned(&mut self) -> Tuned {
        self.tuned_of(self.window)
    }

    /// Orders something that is answered while other things happen.
    fn begin(&mut self, order: Order) -> Receiver<Outcome> {
        let (reply, outcome) = channel();
        let ticket = Ticket {
            window: self.window,
            order,
            counts: self.desk.counts(),
            reply: Box::new(move |outcome| reply.send(outcome).unwrap()),
        };
        self.tickets.try_send(ticket).unwrap();
        outcome
    }

    /// What it must leave as it was.
    fn kept(&mut self) -> Vec<String> {
        let objects = [
            "6060", "20C0:1", "20C0:2", "20C0:4", "20C2:1", "20C2:5", "60F9:1", "60FB:1", "6081",
            "6083", "607A", "20D0:4", "20D0:5", "20D1:1", "20D1:2", "20D1:3",
        ];
        objects.map(|object| self.done(read(object))).to_vec()
    }
}

const MOTOR: TuningWish = TuningWish {
    motor: true,
    response: false,
    step: false,
    current: None,
    bandwidth: None,
};

/// Frames by which a part of it is known: what the drive answers to 20C1h:1, and what the panel writes to 20C0h:1 and 6040h.
const WINDING: &[u8] = &[0x4F, 0xC1, 0x20, 1, 2];
const FIELD: &[u8] = &[0x4F, 0xC1, 0x20, 1, 3];
const STROKES: &[u8] = &[0x4F, 0xC1, 0x20, 1, 4];
const SINE: &[u8] = &[0x2F, 0xC0, 0x20, 1, 2];
const AT_ONCE: &[u8] = &[0x2B, 0x40, 0x60, 0, 0x3F, 0];

/// Something happens at the first of these frames.
fn at(bench: &mut Bench, frame: &'static [u8], act: impl FnOnce() + 'static) {
    let mut act = Some(act);
    bench.bus().interfere(move |logged| {
        if logged.frame.payload().starts_with(frame)
            && let Some(act) = act.take()
        {
            act();
        }
        Interference::None
    });
}

#[test]
fn a_servo_is_known_without_a_file_and_measures_its_motor() {
    let (mut bench, _) = Bench::servo(false);
    assert!(bench.drive().can_tune);
    let before = bench.kept();
    let nothing = bench.tuned();
    assert_eq!((nothing.node, nothing.encoder), (NODE, None));
    assert_eq!(nothing.parameters.len(), 9);
    assert!(nothing.parameters.iter().all(|one| one.found.is_none()));
    let said = bench.done(Order::Tune(TuningWish {
        response: true,
        step: true,
        current: Some(70),
        bandwidth: Some(500),
        ..MOTOR
    }));
    assert_eq!(said, "measured; nothing is written");
    assert_eq!(bench.kept(), before);
    assert_eq!(bench.session.state().tuning, None);
    assert_eq!(bench.drive_state(), Some(DriveState::ReadyToSwitchOn));
    assert_eq!(bench.drive().guard, Guard::On);
    let tuned = bench.tuned();
    let found = |tuned: &Tuned, name: &str| {
        let mut all = tuned.parameters.iter();
        let one = all.find(|one| one.name == name).unwrap();
        (
            one.found.clone(),
            one.set.clone(),
            one.unit,
            one.object.clone(),
        )
    };
    let (resistance, set, unit, object) = found(&tuned, "Resistance");
    let resistance: f64 = resistance.unwrap().parse().unwrap();
    assert!((resistance / 0.6 - 1.0).abs() < 0.03, "{resistance}");
    assert_eq!((set, unit, object.as_str()), (None, "Ω", "20C2h:01"));
    let gain = found(&tuned, "Gain of the velocity");
    assert_eq!(
        gain,
        (Some("500".to_owned()), None, "1/s", "60F9h:01".to_owned())
    );
    assert!(
        tuned
            .encoder
            .clone()
            .unwrap()
            .starts_with("4 pole pairs, counts as the motor turns, ")
    );
    assert_eq!(tuned.response.frequency.len(), 40);
    assert!(tuned.response.decibels.iter().all(|one| one.is_finite()));
    assert!(tuned.step.wanted.contains(&100) && tuned.step.was.len() == tuned.step.time.len());
    assert!(!tuned.is_written);
    // Only now is it written.
    bench.done(Order::WriteTuning);
    let written = bench.tuned();
    assert!(written.is_written);
    let (found, set, ..) = found(&written, "Inertia");
    assert_eq!(found, set);
    assert_eq!(bench.done(read("60F9:1")), "500");
}

#[test]
fn a_measurement_shows_the_drive_and_refuses_what_else_moves_it() {
    let (mut bench, _) = Bench::servo(false);
    let second = bench.desk.open();
    let refused = Outcome::Error("another window has control: take it first".to_owned());
    assert_eq!(bench.order_of(second, Order::Tune(MOTOR)), refused);
    let outcome = bench.begin(Order::Tune(MOTOR));
    let other = bench.begin(Order::Enable);
    let (asked, heard) = channel();
    let ticket = Ticket {
        window: second,
        order: read("6064"),
        counts: Counts::default(),
        reply: Box::new(move |outcome| asked.send(outcome).unwrap()),
    };
    bench.tickets.try_send(ticket).unwrap();
    let mut states = bench.session.outlet.states.subscribe();
    bench.run_for(100);
    // And a picture behind it.
    bench.run_for(100);
    assert!(states.has_changed().unwrap());
    assert!(states.borrow_and_update().contains(r#""tunings":1"#));
    assert!(matches!(outcome.try_recv().unwrap(), Outcome::Done(_)));
    assert_eq!(
        other.try_recv().unwrap(),
        Outcome::Error("the motor is being measured: stop it first".to_owned())
    );
    assert!(matches!(heard.try_recv().unwrap(), Outcome::Done(_)));
}

#[test]
fn a_stop_ends_a_measurement_at_any_part_and_all_is_as_it_was() {
    for part in [WINDING, FIELD, STROKES, SINE, AT_ONCE] {
        let (mut bench, _) = Bench::servo(false);
        let before = bench.kept();
        let desk = Arc::clone(&bench.desk);
        at(&mut bench, part, move || desk.stop());
        let why = bench.refused(Order::Tune(TuningWish {
            response: true,
            step: true,
            ..MOTOR
        }));
        assert_eq!(
            why, "the measurement was stopped, and everything is as it was",
            "{part:02X?}"
        );
        assert_eq!(bench.session.state().notice, None);
        assert!(!bench.drive_state().unwrap().has_power(), "{part:02X?}");
        assert_eq!(bench.drive().velocity, Some(0));
        assert_eq!(bench.kept(), before, "{part:02X?}");
        // It can be measured once more.
        bench.done(Order::Tune(MOTOR));
    }
}

#[test]
fn the_last_window_that_closes_ends_a_measurement() {
    let (mut bench, _) = Bench::servo(false);
    let (desk, window) = (Arc::clone(&bench.desk), bench.window);
    at(&mut bench, FIELD, move || desk.close(window));
    let why = bench.refused(Order::Tune(MOTOR));
    assert_eq!(
        why,
        "the measurement was stopped, and everything is as it was"
    );
    assert!(!bench.drive_state().unwrap().has_power());
    bench.window = bench.desk.open();
    bench.desk.take(bench.window);
    assert_eq!(bench.done(read("1016:1")), "0");
    assert_eq!(bench.drive().fault, None);
}

#[test]
fn a_panel_that_dies_in_a_measurement_leaves_a_motor_without_power() {
    let (mut bench, drive) = Bench::servo(false);
    // Nothing of the panel comes any more, the heartbeat that guards the drive neither.
    let mut is_dead = false;
    bench.bus().interfere(move |logged| {
        is_dead |= logged.frame.payload().starts_with(STROKES);
        if is_dead && logged.sender == PANEL {
            return Interference::Lose;
        }
        Interference::None
    });
    bench.order(Order::Tune(MOTOR));
    let bus = bench.bus();
    bus.run_for(milliseconds(1_000));
    let missed = bus.trace().iter().any(|logged| {
        logged.frame.standard_id() == Some(0x080 + u16::from(NODE))
            && logged.frame.payload()[..2] == 0x8130u16.to_le_bytes()
    });
    assert!(missed);
    bus.station_mut(drive).record_motion();
    bus.run_for(milliseconds(200));
    let samples = bus.station(drive).motion_samples();
    assert_eq!(
        samples.first().unwrap().position,
        samples.last().unwrap().position
    );
}

#[test]
fn a_servo_records_its_torque_beside_what_every_drive_does() {
    let (mut bench, _) = Bench::servo(false);
    let Outcome::Done(Answer::Recordable(all)) = bench.order(Order::Recordable) else {
        panic!("no channels");
    };
    let objects: Vec<&str> = all.iter().map(|one| one.object.as_str()).collect();
    for torque in ["6074h:00", "6077h:00", "6078h:00"] {
        assert!(objects.contains(&torque), "{objects:?}");
    }
    for some in all.chunks(8) {
        bench.done(Order::Record(Wish {
            channels: some.iter().map(|one| one.object.clone()).collect(),
            trigger: "now".to_owned(),
            divider: Some(1),
            samples: Some(10),
            before: None,
        }));
        bench.run_for(500);
    }
    assert_eq!(bench.session.state().recordings, 3);
    // While the recorder waits for something, it is not taken for a measurement.
    bench.done(Order::Record(Wish {
        channels: vec!["6077".to_owned()],
        trigger: "fault".to_owned(),
        divider: Some(1),
        samples: Some(10),
        before: Some(20),
    }));
    assert_eq!(
        bench.refused(Order::Tune(MOTOR)),
        "the recorder is at work: stop it first"
    );
}

#[test]
fn what_cannot_be_measured_is_told() {
    // A stepper.
    let mut bench = Bench::chosen();
    bench.run_for(100);
    assert!(!bench.drive().can_tune);
    let none = "the drive has no motor that it could measure (20C0h to 20C2h)";
    assert_eq!(bench.refused(Order::Tune(MOTOR)), none);
    assert_eq!(bench.refused(Order::Tuned), none);
    // Nothing is written by a panel that only reads, and what is set can be seen.
    let (mut bench, _) = Bench::servo(true);
    let refused = "the panel was started with --read-only: nothing is written";
    assert_eq!(bench.refused(Order::Tune(MOTOR)), refused);
    assert_eq!(bench.refused(Order::WriteTuning), refused);
    assert_eq!(bench.tuned().parameters.len(), 9);
    // A motor that has power, nothing to write, wishes that cannot be.
    let (mut bench, drive) = Bench::servo(false);
    assert_eq!(
        bench.refused(Order::WriteTuning),
        "nothing was measured yet"
    );
    let much = TuningWish {
        current: Some(101),
        ..MOTOR
    };
    assert_eq!(
        bench.refused(Order::Tune(much)),
        "the current is 1 to 100 per cent of the rated one"
    );
    bench.done(Order::Enable);
    assert_eq!(
        bench.refused(Order::Tune(MOTOR)),
        "the motor has power: take it away first"
    );
    bench.done(transition(Transition::Shutdown));
    // A cable that is out.
    let bus = bench.bus();
    let servo = bus.station_mut(drive).plant_mut().servo_mut().unwrap();
    servo.plant_mut().sensor_faults.encoder_is_cut = true;
    let why = bench.refused(Order::Tune(MOTOR));
    assert!(
        why.contains("the encoder does not see that the rotor turns"),
        "{why}"
    );
    assert!(!bench.drive_state().unwrap().has_power());
}
