//! The port of the servo axis, in place of pulses; and the objects of the servo in the dictionary.

use cia402::{Behaves, Behaviour, RatedMotor, ServoOrder, ServoPort, ServoReport};
use motion::{PulseSink, Record, Ticks};
use runtime::servo::{self, Link, Port, ServoSettings};

use super::DATA;
use crate::board::{chip, Pulses, ServoObjects};

/// Records that are nothing but time, and orders.
pub struct Orders(pub Port);

impl PulseSink for Orders {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.0.push(record)
    }

    fn pending(&self) -> Ticks {
        self.0.pending()
    }

    fn free(&self) -> usize {
        self.0.free()
    }
}

impl Pulses for Orders {
    fn service(&mut self) {
        self.0.pass(chip::ticks());
    }

    fn position(&mut self) -> i64 {
        self.0.position()
    }

    fn position_at(&self, count: u32) -> i32 {
        self.0.position_at(count as u16) as i32
    }

    fn drop_all(&mut self) {
        self.0.forget();
    }

    // The stage tells it.
    fn fault(&self) -> Option<u16> {
        None
    }

    fn mend(&mut self) {}

    fn motor(&self) -> RatedMotor {
        self.0.motor()
    }

    fn order(&mut self, order: &ServoOrder) {
        self.0.order(order);
    }

    fn report(&self) -> ServoReport {
        self.0.report()
    }

    fn forget(&mut self) {
        self.0.forget();
    }
}

/// The objects of the servo at their end of the link.
pub struct LinkedServoObjects {
    pub link: &'static Link,
    pub objects: servo::ServoObjects,
    pub motor: RatedMotor,
}

impl ServoObjects for LinkedServoObjects {
    fn attend<D: Behaves>(
        &mut self,
        dictionary: &mut D,
        product: &mut D::Behaviour,
        has_ticked: bool,
    ) {
        if D::Behaviour::IS_THERE {
            // It counts ticks.
            if has_ticked {
                let mut settings = ServoSettings::NONE;
                let told = self.link.loop_report(&DATA);
                let request = product.loops(dictionary, &told, &mut settings);
                self.link.set_up(settings, request);
            }
            return;
        }
        let (settings, request) = self.objects.read(dictionary);
        self.link.set_up(settings, request);
        self.objects.show(dictionary, &self.link.found());
        servo::ServoObjects::show_lead(dictionary, self.link.lead());
        servo::ServoObjects::show_rated(dictionary, self.motor);
    }
}
