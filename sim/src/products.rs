//! The drives that this program can be: the generic one, and those of the crate [`products`], chosen by name.
//!
//! A virtual drive is generic over the dictionary of its firmware. Who does not care which one it is has a [`Drive`].

use std::sync::Arc;

use canopen::od;
use canopen::{Configuration, Event, NodeId};
use cia402::{Behaves, ServoAxis, StepAxis};
use master::bus::Station;
use master::data_sheet::DataSheet;

use crate::drive::{MotionSample, Moving, Setup, VirtualDrive};
use crate::flash::Flash;
use crate::plant::{Plant, ServoAxisData};
use crate::{Axis402, ServoDrive};

/// A virtual drive, whatever its dictionary is.
pub trait Drive: Station {
    /// The node-ID in force.
    fn node_id(&self) -> NodeId;

    /// The oldest event of the node that nobody has taken yet. The drive has done its part already.
    fn take_event(&mut self) -> Option<Event>;

    /// The bytes of an object, as the dictionary has them; `None` if there is no such object.
    fn object(&self, index: u16, sub: u8) -> Option<Vec<u8>>;

    /// Keeps a sample of the motor from each control tick on from now.
    fn record_motion(&mut self);

    /// The samples kept so far.
    fn motion_samples(&self) -> &[MotionSample];

    /// The motor.
    fn plant_mut(&mut self) -> &mut Plant;

    /// The flash behind the parameter store, to break it.
    fn with_flash(&mut self, change: &mut dyn FnMut(&mut Flash));

    /// Takes the power away and gives it back at once.
    fn power_cycle(&mut self);
}

impl<D, A> Drive for VirtualDrive<D, A>
where
    A: Moving,
    D: Behaves + Default + std::fmt::Debug + 'static,
{
    fn node_id(&self) -> NodeId {
        self.device().node().settings().node_id
    }

    fn take_event(&mut self) -> Option<Event> {
        Self::take_event(self)
    }

    fn object(&self, index: u16, sub: u8) -> Option<Vec<u8>> {
        let entry = od::find::<D>(index, sub).ok()?;
        Some(od::value(self.device().node().dictionary(), entry).to_vec())
    }

    fn record_motion(&mut self) {
        Self::record_motion(self);
    }

    fn motion_samples(&self) -> &[MotionSample] {
        Self::motion_samples(self)
    }

    fn plant_mut(&mut self) -> &mut Plant {
        Self::plant_mut(self)
    }

    fn with_flash(&mut self, change: &mut dyn FnMut(&mut Flash)) {
        Self::with_flash(self, change);
    }

    fn power_cycle(&mut self) {
        Self::power_cycle(self);
    }
}

/// A drive of another maker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Product(&'static products::Product);

impl Product {
    /// The product of this name.
    pub fn named(name: &str) -> Option<Self> {
        let mut all = products::ALL.iter();
        all.find(|product| product.name == name).map(Self)
    }

    /// The names of all.
    pub fn names() -> impl Iterator<Item = &'static str> {
        products::ALL.iter().map(|product| product.name)
    }

    /// What its data sheet calls it.
    pub fn title(self) -> &'static str {
        self.0.title
    }

    /// Its data sheet.
    pub fn data_sheet(self) -> Arc<DataSheet> {
        let file = format!("{}.eds", self.0.name);
        let model = od_gen::parse(&file, self.0.data_sheet);
        Arc::new(model.expect("it has built the product").into())
    }

    /// The ready axis that its binding names, with the machine behind its motor; without one it is moved by pulses.
    pub fn axis(self) -> Option<ServoAxisData> {
        let named = |name| ServoAxisData::named(name).expect("the tests hold it against the axes");
        self.0.axis.map(named).map(ServoAxisData::at_work)
    }

    /// Node-ID and bit rate that it leaves the factory with.
    pub fn factory(self) -> Configuration {
        self.visit(Factory)
    }

    /// A drive of this kind, without power; with a servo if its axis has one, else on pulses.
    pub fn drive(self, setup: Setup) -> Box<dyn Drive> {
        self.visit(Make(setup))
    }

    pub(crate) fn visit<V: products::Visitor>(self, visitor: V) -> V::Output {
        products::with(self.0.name, visitor).expect("a product of the list")
    }
}

struct Factory;

impl products::Visitor for Factory {
    type Output = Configuration;

    fn visit<D>(self) -> Configuration
    where
        D: Behaves + Default + std::fmt::Debug + 'static,
    {
        D::HABITS.factory
    }
}

struct Make(Setup);

impl products::Visitor for Make {
    type Output = Box<dyn Drive>;

    fn visit<D>(self) -> Box<dyn Drive>
    where
        D: Behaves + Default + std::fmt::Debug + 'static,
    {
        let mut setup = self.0;
        match setup.axis.as_mut().and_then(|axis| axis.servo.as_mut()) {
            None => Box::new(VirtualDrive::<D, StepAxis>::new(setup)),
            Some(servo) => {
                fit::<D>(servo);
                Box::new(VirtualDrive::<D, ServoAxis>::new(setup))
            }
        }
    }
}

/// Gives the motor an encoder with as many counts in a turn as the product has it.
pub(crate) fn fit<D: Behaves + Default>(servo: &mut ServoAxisData) {
    let dictionary = D::default();
    let turns = dictionary.position_encoder_revolutions().max(1);
    match dictionary.position_encoder_increments() / turns {
        0 => {}
        counts => servo.plant.sensors.counts = counts,
    }
}

/// A drive of this product, or the generic one, without power; that for the servo of the axis, if it has one.
pub fn drive(product: Option<Product>, setup: Setup) -> Box<dyn Drive> {
    let is_servo = setup.axis.as_ref().is_some_and(|axis| axis.servo.is_some());
    match product {
        Some(product) => product.drive(setup),
        None if is_servo => Box::new(ServoDrive::new(setup)),
        None => Box::new(Axis402::new(setup)),
    }
}
