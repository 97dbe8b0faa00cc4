//! A master like CODESYS SoftMotion: it gives the drive all its PDOs at start-up, four each way and all synchronous, and sends and hears each
//! of them in every cycle, right behind SYNC. In virtual time.
//!
//! The bus has room for it: at 1 Mbit/s SYNC and the eight PDOs of a cycle take up to 897 us here, with their stuff bits and the gaps between
//! frames; so at 1 ms nine tenths of the bus are used, and an SDO answer comes within three cycles. A second such axis needs a cycle of 2 ms.

use canopen::{BitRate, Duration, Frame};
use master::bus::timing::{INTERMISSION_BITS, bit_time, frame_bits};
use sim::drive::Setup;
use sim::plant::{Axis, Switch, Track};
use tests::DriveBench;
use tests::drive::{
    INTERNAL_LIMIT, OPERATION_ENABLED, READY_TO_SWITCH_ON, SWITCH_ON_DISABLED, SWITCHED_ON, State,
};

use crate::cyclic_master::{FOLLOWS, latency};

/// What RPDOs 1 to 4 carry, as in 1600h to 1603h.
const RPDOS: [&[u32]; 4] = [
    &[0x6040_0010, 0x607A_0020],
    &[0x60FF_0020, 0x60B1_0020],
    &[0x6060_0008, 0x60B8_0010],
    &[0x60B0_0020, 0x60FE_0120],
];
/// What TPDOs 1 to 4 carry, as in 1A00h to 1A03h.
const TPDOS: [&[u32]; 4] = [
    &[0x6041_0010, 0x6064_0020],
    &[0x606C_0020],
    &[0x60B9_0010, 0x60BA_0020],
    &[0x6061_0008, 0x603F_0010, 0x60FD_0020],
];
/// Of what the bus has in a cycle of 1 ms, no more is used, in microseconds.
const MOST_BUS_TIME: u64 = 900;
/// Where the home switch is active.
const HOME: std::ops::RangeInclusive<i64> = 1_000..=3_000;
/// Where the first edge of the touch probe is.
const PROBE: i64 = 1_234;
/// 60B8h: probe 1 keeps the first positive edge.
const PROBE_ON: u16 = 0x11;
/// The home switch in 60FDh.
const HOME_SWITCH: u32 = 1 << 2;

/// What the master sends behind the next SYNC.
#[derive(Clone, Copy, Debug, Default)]
struct Outputs {
    controlword: u16,
    target: i32,
    velocity: i32,
    velocity_offset: i32,
    mode: i8,
    probe: u16,
    position_offset: i32,
    outputs: u32,
}

impl Outputs {
    fn rpdos(&self) -> [Vec<u8>; 4] {
        [
            [
                &self.controlword.to_le_bytes()[..],
                &self.target.to_le_bytes(),
            ]
            .concat(),
            [
                self.velocity.to_le_bytes(),
                self.velocity_offset.to_le_bytes(),
            ]
            .concat(),
            [&self.mode.to_le_bytes()[..], &self.probe.to_le_bytes()].concat(),
            [
                &self.position_offset.to_le_bytes()[..],
                &self.outputs.to_le_bytes(),
            ]
            .concat(),
        ]
    }
}

/// What the drive has sent for one SYNC.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Inputs([Vec<u8>; 4]);

impl Inputs {
    /// The bytes of an object in a TPDO.
    fn of(&self, wanted: u32) -> &[u8] {
        for (mapping, data) in TPDOS.iter().zip(&self.0) {
            let mut at = 0;
            for entry in *mapping {
                let end = at + bytes(*entry);
                if entry >> 8 == wanted >> 8 {
                    return &data[at..end];
                }
                at = end;
            }
        }
        panic!("{wanted:08X}h is not mapped");
    }

    fn number(&self, wanted: u32) -> i64 {
        match *self.of(wanted) {
            [a] => i8::from_le_bytes([a]).into(),
            [a, b] => u16::from_le_bytes([a, b]).into(),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]).into(),
            _ => panic!("no number"),
        }
    }

    fn statusword(&self) -> u16 {
        u16::try_from(self.number(0x6041_0000)).unwrap()
    }

    fn position(&self) -> i64 {
        self.number(0x6064_0000)
    }
}

/// The length of a mapped object.
fn bytes(entry: u32) -> usize {
    (entry & 0xFF) as usize / 8
}

/// The master and its drive.
struct SoftMotion {
    drive: DriveBench,
    /// In microseconds.
    cycle: u64,
    next: u64,
    outputs: Outputs,
    /// An SDO request that goes out behind the PDOs, and its answer.
    request: Option<[u8; 8]>,
    answer: Option<[u8; 8]>,
    /// What was commanded behind each SYNC, and what came for it.
    commanded: Vec<Outputs>,
    shown: Vec<Inputs>,
    /// The most bus time of a cycle in which nothing but SYNC and PDOs was sent.
    busiest: Duration,
}

impl SoftMotion {
    /// A drive on an axis with switches that has got its PDOs, its period and its mode, and is Operational.
    fn started(cycle: u64) -> Self {
        let axis = Axis {
            track: Track {
                home: Some(Switch::within(HOME)),
                probes: [Some(Switch::from(PROBE)), None],
                ..Track::default()
            },
            ..Axis::default()
        };
        let setup = Setup {
            axis: Some(axis),
            ..Setup::with_node_id(1, 4)
        };
        let mut drive = DriveBench::with(setup, 4);
        assert_eq!(drive.read_u32(0x1000, 0) & 0xFFFF, 402);
        drive.write_u32(0x1006, 0, u32::try_from(cycle).unwrap());
        for number in 0..4 {
            drive.map_pdo(0x1400 + number, RPDOS[usize::from(number)], 1);
            drive.map_pdo(0x1800 + number, TPDOS[usize::from(number)], 1);
        }
        drive.write_u8(0x60C2, 1, u8::try_from(cycle / 1_000).unwrap());
        drive.write_u8(0x60C2, 2, i8::cast_unsigned(-3));
        drive.write_u32(0x60FE, 2, 0x0003_0000);
        drive.write_u8(0x6060, 0, 8);
        drive.start();
        let next = drive.now().ticks() + cycle;
        Self {
            drive,
            cycle,
            next,
            outputs: Outputs {
                mode: 8,
                ..Outputs::default()
            },
            request: None,
            answer: None,
            commanded: Vec::new(),
            shown: Vec::new(),
            busiest: Duration::micros(0),
        }
    }

    /// SYNC and the four RPDOs; of the drive the four TPDOs, each once, before the next SYNC is due.
    fn cycle(&mut self) {
        let start = self.next;
        self.next += self.cycle;
        self.drive.run_micros(start - self.drive.now().ticks());
        let asked = self.request.take();
        let rpdos = self.outputs.rpdos();
        let pdo = |(number, data): (u16, &Vec<u8>)| {
            Frame::data_frame(0x204 + 0x100 * number, data.as_slice())
        };
        let mut frames = vec![Frame::data_frame(0x080, &[])];
        frames.extend((0..).zip(&rpdos).map(pdo));
        frames.extend(asked.map(|request| Frame::data_frame(0x604, &request)));
        for frame in &frames {
            self.drive.queue_frame(*frame);
        }
        let mut heard: [Option<Vec<u8>>; 4] = Default::default();
        let mut answered = false;
        while let Some(left) = self.next.checked_sub(self.drive.now().ticks())
            && let Some(frame) = self.drive.next(Duration::micros(left))
        {
            frames.push(frame);
            match frame.standard_id() {
                Some(id @ (0x184 | 0x284 | 0x384 | 0x484)) => {
                    let slot = &mut heard[usize::from(id - 0x184) / 0x100];
                    assert_eq!(*slot, None, "twice for one SYNC: {id:03X}h");
                    *slot = Some(frame.payload().to_vec());
                }
                Some(0x584) => {
                    self.answer = Some(*frame.bytes());
                    answered = true;
                }
                _ => panic!("nobody asked for {frame:?}"),
            }
        }
        let inputs = heard.map(|data| data.expect("each TPDO came before the next SYNC"));
        for (data, mapping) in inputs.iter().zip(TPDOS) {
            assert_eq!(
                data.len(),
                mapping.iter().map(|entry| bytes(*entry)).sum::<usize>()
            );
        }
        self.commanded.push(self.outputs);
        self.shown.push(Inputs(inputs));
        if asked.is_none() && !answered {
            let bits = frames
                .iter()
                .map(|frame| frame_bits(frame) + INTERMISSION_BITS);
            let busy = bit_time(bits.sum(), BitRate::Kbit1000);
            self.busiest = self.busiest.max(busy);
        }
    }

    fn cycles(&mut self, count: usize) {
        for _ in 0..count {
            self.cycle();
        }
    }

    fn last(&self) -> &Inputs {
        self.shown.last().unwrap()
    }

    /// Commands a state; it is seen within 10 ms and the cycle in which the controlword is on its way.
    fn reach(&mut self, controlword: u16, state: State) {
        self.outputs.controlword = controlword;
        // As SoftMotion does while the axis has no power: the set-point is the position.
        self.outputs.target = i32::try_from(self.last().position()).unwrap();
        for _ in 0..2 + 10_000 / self.cycle {
            self.cycle();
            if state.is_shown_by(self.last().statusword()) {
                return;
            }
        }
        panic!("{} us: {:04X}h", self.cycle, self.last().statusword());
    }

    /// Changes the mode by RPDO 3; 6061h in TPDO 4 shows it within 10 ms.
    fn change_mode(&mut self, mode: i8) {
        self.outputs.mode = mode;
        for _ in 0..2 + 10_000 / self.cycle {
            self.cycle();
            if self.last().number(0x6061_0000) == i64::from(mode) {
                return;
            }
        }
        panic!("{} us: mode {mode}", self.cycle);
    }

    /// Reads an object by SDO while PDOs go on.
    fn read(&mut self, entry: u32) -> Vec<u8> {
        let [sub, low, high] = [entry >> 8, entry >> 16, entry >> 24].map(|part| part as u8);
        self.request = Some([0x40, low, high, sub, 0, 0, 0, 0]);
        self.answer = None;
        for _ in 0..3 {
            self.cycle();
            if let Some(answer) = self.answer {
                assert_eq!(answer[1..4], [low, high, sub]);
                return answer[4..4 + bytes(entry)].to_vec();
            }
        }
        panic!("no answer for {entry:08X}h");
    }

    /// What is mapped is, in every PDO, what SDO says. At rest, as an answer takes its time.
    fn pdos_are_what_sdo_says(&mut self) {
        for entry in TPDOS.concat() {
            let by_sdo = self.read(entry);
            assert_eq!(self.last().of(entry), by_sdo, "{entry:08X}h");
        }
        for (mapping, data) in RPDOS.iter().zip(self.outputs.rpdos()) {
            let by_sdo: Vec<u8> = mapping.iter().flat_map(|entry| self.read(*entry)).collect();
            assert_eq!(by_sdo, data, "{mapping:08X?}");
        }
    }

    /// From cycle `first` on the motor was exactly at each set-point, so many SYNCs after the one that it was for.
    fn is_exact(&self, first: usize) {
        // What is sent behind a SYNC holds at the next one.
        let behind = 1 + latency(self.cycle);
        let shown = self.shown[first + behind..].iter().map(Inputs::position);
        let commanded = self.commanded[first..]
            .iter()
            .map(|outputs| i64::from(outputs.target) + i64::from(outputs.position_offset));
        assert!(shown.len() > 400);
        for (k, (shown, commanded)) in shown.zip(commanded).enumerate() {
            assert_eq!(shown, commanded, "{} us, cycle {}", self.cycle, first + k);
        }
    }
}

#[test]
fn soft_motion_starts_at_1_2_and_4_ms_with_four_pdos_each_way() {
    for cycle in [1_000, 2_000, 4_000] {
        let mut master = SoftMotion::started(cycle);
        master.cycles(100);
        assert!(SWITCH_ON_DISABLED.is_shown_by(master.last().statusword()));
        master.reach(0x06, READY_TO_SWITCH_ON);
        master.reach(0x07, SWITCHED_ON);
        master.reach(0x0F, OPERATION_ENABLED);
        master.outputs.probe = PROBE_ON;
        master.cycles(100);
        let first = master.shown.len();
        moves_with_an_offset(&mut master);
        // Until the motor is at the last set-point.
        master.cycles(10);
        master.is_exact(first);
        switches_are_seen_where_they_are(&master);
        assert_eq!(master.last().number(0x60BA_0000), PROBE, "60BAh");
        assert_eq!(master.last().number(0x60B9_0000), 0x03, "60B9h");
        // What is kept for where the loop is closed changes nothing, and nor does 60FFh here.
        let stands = master.last().position();
        master.outputs.velocity = 12_345;
        master.outputs.velocity_offset = -6_789;
        master.cycles(20);
        assert_eq!(master.last().position(), stands);
        master.pdos_are_what_sdo_says();
        master.outputs.velocity = 0;
        master.outputs.velocity_offset = 0;
        master.cycles(2);
        a_velocity_with_an_offset(&mut master);
        master.reach(0x07, SWITCHED_ON);
        master.reach(0x06, READY_TO_SWITCH_ON);
        master.cycles(10);
        master.pdos_are_what_sdo_says();
        let busiest = master.busiest.to_micros();
        assert!(busiest <= MOST_BUS_TIME, "{busiest} us of {cycle}");
    }
}

/// To and fro with 607Ah, and 60B0h grows meanwhile; an output blinks.
fn moves_with_an_offset(master: &mut SoftMotion) {
    let most = i32::try_from(master.cycle / 50).unwrap();
    for k in 0..600_i32 {
        let distance = match k % 300 {
            up @ 0..50 => most * up / 50,
            50..100 => most,
            down @ 100..200 => most - most * (down - 100) / 50,
            200..250 => -most,
            back => -most + most * (back - 250) / 50,
        };
        master.outputs.target += distance;
        master.outputs.position_offset = (k - 100).clamp(0, 200);
        let lit = k / 20 % 2 == 1;
        master.outputs.outputs = if lit { 0x0001_0000 } else { 0x0002_0000 };
        // Now and then SDO takes what is left of the bus, and SYNC waits for the end of a frame.
        master.request = (k % 8 == 0).then_some([0x40, 0x64, 0x60, 0, 0, 0, 0, 0]);
        master.cycle();
        // Ten cycles later it was taken over long ago, at a SYNC and in the control tick behind it.
        if k % 20 == 10 {
            let levels = master.drive.axis().plant().outputs();
            assert_eq!(levels, if lit { 0b01 } else { 0b10 }, "cycle {k}");
        }
        let cruises = (80..100).contains(&(k % 300)) && k > 300;
        if cruises {
            let speed = i64::from(distance) * 1_000_000 / i64::try_from(master.cycle).unwrap();
            let off = (master.last().number(0x606C_0000) - speed).abs();
            // A SYNC that had to wait is off its moment, and so is the speed (docs/decisions.md, ripple).
            assert!(off * 1_000 <= speed, "606Ch is {off} off");
        }
        let statusword = master.last().statusword();
        assert_eq!(statusword & INTERNAL_LIMIT, 0, "cycle {k}");
        assert_eq!(statusword & FOLLOWS, FOLLOWS, "cycle {k}");
        assert_eq!(master.last().number(0x603F_0000), 0);
    }
}

/// 60FDh was active where the home switch is, but for the time of its filter.
fn switches_are_seen_where_they_are(master: &SoftMotion) {
    let mut seen = [0; 2];
    for pair in master.shown.windows(8) {
        let inside = pair.iter().all(|inputs| HOME.contains(&inputs.position()));
        let outside = pair.iter().all(|inputs| !HOME.contains(&inputs.position()));
        let active = pair[7].number(0x60FD_0000) & i64::from(HOME_SWITCH) != 0;
        if inside || outside {
            assert_eq!(active, inside, "at {}", pair[7].position());
            seen[usize::from(inside)] += 1;
        }
    }
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
}

/// Cyclic synchronous velocity by RPDO 3: 60FFh and 60B1h of RPDO 2 are added.
fn a_velocity_with_an_offset(master: &mut SoftMotion) {
    master.change_mode(9);
    master.cycles(20);
    for k in 1..=100 {
        master.outputs.velocity = 50 * k;
        master.outputs.velocity_offset = 10 * k;
        master.cycle();
    }
    master.cycles(10);
    assert_eq!(master.last().number(0x606C_0000), 6_000);
    let begin = master.last().position();
    master.cycles(50);
    let distance = i64::try_from(50 * master.cycle).unwrap() * 6_000 / 1_000_000;
    assert_eq!(master.last().position() - begin, distance);
    for k in (0..100).rev() {
        master.outputs.velocity = 50 * k;
        master.outputs.velocity_offset = 10 * k;
        master.cycle();
    }
    master.cycles(20);
    assert_eq!(master.last().number(0x606C_0000), 0);
    // Back at rest: the set-point is the position.
    master.outputs.position_offset = 0;
    master.outputs.target = i32::try_from(master.last().position()).unwrap();
    master.change_mode(8);
    master.cycles(20);
    let statusword = master.last().statusword();
    assert_eq!(statusword & (FOLLOWS | INTERNAL_LIMIT), FOLLOWS);
    assert_eq!(master.last().position(), i64::from(master.outputs.target));
}
