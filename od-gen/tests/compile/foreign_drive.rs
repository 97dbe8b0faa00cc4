//! The dictionary of another maker, with objects and units of its own, commands the same drive.
#![deny(warnings)]
#![forbid(unsafe_code)]

mod dictionary {
    include!("dictionaries/foreign.rs");
}

use canopen::{BitRate, Duration, Frame, Instant, NodeId, Settings};
use cia402::{Actuals, Commands, Device, Exchange};
use dictionary::Dictionary;

struct Station {
    device: Device<Dictionary>,
    exchange: Exchange,
    now: Instant,
}

impl Station {
    fn request(&mut self, data: &[u8; 8]) -> Vec<u8> {
        self.now += Duration::from_ticks(1000);
        let frame = Frame::data_frame(0x604, data);
        self.device.receive(&frame, self.now, &mut self.exchange);
        self.device.poll(self.now, &mut self.exchange);
        let mut answer = Vec::new();
        while let Some(frame) = self.device.transmit() {
            if frame.standard_id() == Some(0x584) {
                answer = frame.payload().to_vec();
            }
        }
        answer
    }

    /// What the next control tick would take.
    fn commands(&mut self) -> Commands {
        let mut commands = Commands::NONE;
        self.exchange.take(&mut commands);
        commands
    }

    /// Writes so many bytes of a number.
    fn write(&mut self, index: u16, size: u8, number: i32) -> Vec<u8> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = number.to_le_bytes();
        self.request(&[0x23 | (4 - size) << 2, low, high, 0, a, b, c, d])
    }

    /// The lowest four bytes of what is read.
    fn read(&mut self, index: u16) -> i32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.request(&[0x40, low, high, 0, 0, 0, 0, 0]);
        i32::from_le_bytes(answer[4..8].try_into().unwrap())
    }
}

const OK: u8 = 0x60;

fn main() {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        bit_rate: BitRate::Kbit1000,
    };
    let mut station = Station {
        device: Device::new(Dictionary::new(), settings, 1),
        exchange: Exchange::new(),
        now: Instant::from_ticks(0),
    };
    station.device.power_on(station.now, &mut station.exchange);

    // At power-on: 500 tenths are 5000 steps/s; 6083h and its shadow 2007h (in thousands) agree.
    let commands = station.commands();
    assert_eq!((commands.profile_velocity.whole(), commands.mode), (5000, 0));
    assert_eq!((commands.profile_acceleration, commands.profile_deceleration), (1000, 1000));
    assert_eq!(station.read(0x2007), 1);

    // What is written means steps to the drive: 1.6 in a micrometre.
    assert_eq!(station.write(0x2003, 4, 1000)[0], OK);
    assert_eq!(station.commands().target_position, 1600);
    assert_eq!(station.write(0x2006, 2, 123)[0], OK);
    assert_eq!(station.commands().profile_velocity.whole(), 1230);
    assert_eq!(station.write(0x2012, 1, 1)[0], OK);
    assert_eq!(station.commands().profile_deceleration, 20_000);

    // A mode by its number there; one that has none, and one that 2002h does not offer.
    assert_eq!(station.write(0x2000, 1, 7)[0], OK);
    assert_eq!(station.commands().mode, 1);
    assert_eq!(station.write(0x2000, 1, 1)[4..], [0x30, 0, 0x09, 0x06]);
    // 1000 micrometres too many.
    assert_eq!(station.write(0x2003, 4, i32::MAX)[4..], [0x31, 0, 0x09, 0x06]);
    assert_eq!(station.read(0x2003), 1000);

    // Two objects for one parameter: each follows the other, within the limits of the one that the drive reads.
    assert_eq!(station.write(0x2007, 2, 20)[0], OK);
    assert_eq!(station.read(0x6083), 20_000);
    assert_eq!(station.commands().profile_acceleration, 20_000);
    assert_eq!(station.write(0x6083, 4, 7_600)[0], OK);
    assert_eq!(station.read(0x2007), 8);
    assert_eq!(station.commands().profile_acceleration, 7_600);
    assert_eq!(station.write(0x2007, 2, 1001)[4..], [0x31, 0, 0x09, 0x06]);
    assert_eq!(station.write(0x2007, 2, 0)[4..], [0x32, 0, 0x09, 0x06]);

    // What the drive shows: 24 bits of micrometres, moved by 1000, and codes.
    station.exchange.publish(&Actuals {
        statusword: 0x1237,
        mode_display: 1,
        position_actual: -160,
        ..station.exchange.actuals_at(station.now)
    });
    assert_eq!(station.read(0x2004), 0x00FF_FF9C, "-100");
    assert_eq!(station.read(0x2001), 7);
    assert_eq!(station.read(0x2008), 0x1237);
    assert_eq!(station.device.node().dictionary().position_once_more(), 840);

    // Plain storage does nothing.
    assert_eq!(station.write(0x2011, 4, 77)[0], OK);
    assert_eq!(station.read(0x2011), 77);
}
