//! When a transmit PDO is sent, under random changes, SYNCs and times: as the transmission type says, with the newest values, never
//! within the inhibit time, and never later than the event timer.

use crate::device::Device;
use canopen::Duration;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// The object that TPDO 1 maps first, 32 bits.
const VALUE: u16 = 0x2005;

/// Parameters of TPDO 1.
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    transmission_type: u8,
    /// In multiples of 100 µs.
    inhibit_time: u16,
    /// In milliseconds, 0 for none.
    event_timer: u16,
    sync_start: u8,
    /// 1019h, 0 for SYNCs without a counter.
    overflow: u8,
}

/// A device in Operational, and what it has sent: when, in microseconds, and which value.
struct Rig {
    device: Device,
    value: u32,
    sent: Vec<(u64, u32)>,
}

impl Rig {
    fn new(times: Times) -> Self {
        let mut device = Device::new();
        let write = |device: &mut Device, what: String| {
            let answer = device.ask(&what);
            assert!(answer[0].starts_with("584: 60"), "{what}: {answer:?}");
        };
        write(
            &mut device,
            format!("604: 2F 19 10 00 {:02X} 00 00 00", times.overflow),
        );
        write(&mut device, "604: 23 00 18 01 84 01 00 80".into());
        write(
            &mut device,
            format!("604: 2F 00 18 02 {:02X} 00 00 00", times.transmission_type),
        );
        for (sub, time) in [(3, times.inhibit_time), (5, times.event_timer)] {
            let [low, high] = time.to_le_bytes();
            write(
                &mut device,
                format!("604: 2B 00 18 {sub:02X} {low:02X} {high:02X} 00 00"),
            );
        }
        write(
            &mut device,
            format!("604: 2F 00 18 06 {:02X} 00 00 00", times.sync_start),
        );
        write(&mut device, "604: 23 00 18 01 84 01 00 00".into());
        let mut rig = Self {
            device,
            value: 0,
            sent: Vec::new(),
        };
        rig.device.send("000 [2] 01 04");
        rig.take();
        rig
    }

    /// What the device sends now; what has left may start a time.
    fn take(&mut self) {
        let now = self.device.now.ticks();
        for frame in self.device.sent() {
            let frame = crate::device::frame(&frame);
            assert_eq!(frame.standard_id(), Some(0x184), "only the PDO is sent");
            let value = u32::from_le_bytes(frame.payload()[..4].try_into().unwrap());
            assert_eq!(value, self.value, "the newest value");
            self.sent.push((now, value));
        }
    }

    /// Lets time pass; the device is called at each of its deadlines, and not in between.
    fn pass(&mut self, microseconds: u64) {
        let end = self.device.now + Duration::from_ticks(microseconds);
        loop {
            self.device.poll();
            self.take();
            let deadline = self.device.poll();
            if deadline > end {
                self.device.now = end;
                return;
            }
            self.device.now = deadline;
        }
    }

    fn change(&mut self, value: u32) {
        self.value = value;
        self.device.set_value(VALUE, 0, &value.to_le_bytes());
        self.device.poll();
        self.take();
    }

    fn sync(&mut self, counter: Option<u8>) {
        match counter {
            Some(counter) => self.device.put(&format!("080 [1] {counter:02X}")),
            None => self.device.put("080 [0]"),
        }
        self.take();
        self.device.poll();
    }

    fn now(&self) -> u64 {
        self.device.now.ticks()
    }
}

/// What happens on the bus and in the device.
#[derive(Clone, Copy, Debug)]
enum Step {
    Change(u32),
    Pass(u64),
    Sync,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        (0..4_u32).prop_map(Step::Change),
        (0..30_000_u64).prop_map(Step::Pass),
        Just(Step::Sync),
    ];
    prop::collection::vec(step, 1..60)
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 128, ..ProptestConfig::default() }))]

    #[test]
    fn p31_p32_events_keep_the_inhibit_time_and_the_event_timer(
        transmission_type in 254..=255_u8,
        inhibit_time in prop_oneof![Just(0_u16), 1..200_u16],
        event_timer in prop_oneof![Just(0_u16), 1..50_u16],
        steps in steps(),
    ) {
        let mut rig = Rig::new(Times { transmission_type, inhibit_time, event_timer, ..Times::default() });
        let inhibit = u64::from(inhibit_time) * 100;
        let longest = (u64::from(event_timer) * 1000).max(inhibit);
        let start = rig.now();
        let mut changes = 0;
        for step in steps {
            let before = (rig.sent.len(), rig.value);
            match step {
                Step::Change(value) => {
                    rig.change(value);
                    if value != before.1 {
                        changes += 1;
                        // Without an inhibit time it is sent at once.
                        prop_assert!(inhibit != 0 || rig.sent.len() == before.0 + 1);
                    }
                }
                Step::Pass(time) => rig.pass(time),
                Step::Sync => {
                    rig.sync(None);
                    prop_assert_eq!(rig.sent.len(), before.0, "SYNC is nothing to it");
                }
            }
        }
        rig.pass(inhibit);
        rig.device.poll();
        rig.take();
        prop_assert_eq!(rig.sent[0], (start, 0), "once when Operational is entered");
        prop_assert_eq!(rig.sent.last().unwrap().1, rig.value, "no change is left out");
        for pair in rig.sent.windows(2) {
            let gap = pair[1].0 - pair[0].0;
            prop_assert!(gap >= inhibit, "{gap} µs within the inhibit time {inhibit} µs");
            prop_assert!(event_timer == 0 || gap <= longest, "{gap} µs, event timer {event_timer} ms");
            prop_assert!(event_timer != 0 || inhibit != 0 || pair[0].1 != pair[1].1);
        }
        let silence = rig.now() - rig.sent.last().unwrap().0;
        prop_assert!(event_timer == 0 || silence < longest.max(1));
        prop_assert!(event_timer != 0 || rig.sent.len() <= 1 + changes, "only changes are events");
    }

    /// However long each frame waits for the bus, and whatever has changed since.
    #[test]
    fn p31_the_inhibit_time_begins_when_a_frame_leaves(
        inhibit_time in 1..200_u16,
        event_timer in prop_oneof![Just(0_u16), 1..50_u16],
        waits in prop::collection::vec(0..40_000_u64, 1..30),
    ) {
        let mut rig = Rig::new(Times { transmission_type: 255, inhibit_time, event_timer, ..Times::default() });
        let mut left_at = rig.now();
        for (value, wait) in (1..).zip(waits) {
            rig.value = value;
            rig.device.set_value(VALUE, 0, &value.to_le_bytes());
            let free_at = left_at + u64::from(inhibit_time) * 100;
            // Called at each of its deadlines, the device has something to send when its time has come, and not before.
            while rig.device.node.pending().is_none() {
                rig.device.now = rig.device.poll().min(rig.device.now + Duration::millis(100));
                prop_assert!(rig.device.now.ticks() <= free_at.max(left_at + 1));
                rig.device.poll();
            }
            prop_assert!(rig.now() >= free_at, "{} µs early", free_at - rig.now());
            // The bus is busy, while the device is called.
            for _ in 0..4 {
                rig.device.now += Duration::from_ticks(wait / 4);
                rig.device.poll();
            }
            rig.take();
            rig.device.poll();
            left_at = rig.now();
        }
    }

    #[test]
    fn p25_p27_p28_synchronous_pdos_are_sent_at_the_sync_that_is_theirs(
        transmission_type in prop_oneof![Just(0_u8), 1..=6_u8, Just(240_u8)],
        sync_start in prop_oneof![Just(0_u8), 1..=10_u8],
        overflow in prop_oneof![Just(0_u8), Just(10_u8)],
        steps in steps(),
        syncs in 1..5_usize,
    ) {
        let every = transmission_type;
        let mut rig = Rig::new(Times { transmission_type, sync_start, overflow, ..Times::default() });
        let mut counter = 0;
        let mut count = 0;
        let mut awaits_start = sync_start != 0 && overflow != 0 && every != 0;
        // Of type 0: what was last sampled, and whether there was another value since, or Operational was entered.
        let (mut content, mut is_due) = (0, true);
        let mut expected = Vec::new();
        for step in steps {
            match step {
                Step::Change(value) => {
                    rig.change(value);
                    is_due |= value != content;
                }
                Step::Pass(time) => rig.pass(time),
                // More of them, so that many PDOs are sent.
                Step::Sync => for _ in 0..syncs {
                    counter = counter % 10 + 1;
                    count += 1;
                    let is_sent = if every == 0 {
                        is_due
                    } else if awaits_start {
                        awaits_start = counter != sync_start;
                        !awaits_start
                    } else {
                        count >= u32::from(every)
                    };
                    if is_sent || awaits_start {
                        count = 0;
                    }
                    if is_sent {
                        expected.push((rig.now(), rig.value));
                        (content, is_due) = (rig.value, false);
                    }
                    rig.sync((overflow != 0).then_some(counter));
                },
            }
        }
        rig.pass(1_000_000);
        prop_assert_eq!(rig.sent, expected);
    }
}
