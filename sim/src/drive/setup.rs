//! What a virtual drive is made of.

use canopen::settings::Wish;
use canopen::{BitRate, Configuration, NodeId, Settings};

use crate::flash::{Flash, ParameterStore};
use crate::plant::Axis;

/// What a drive is made of.
#[derive(Debug)]
pub struct Setup {
    /// 1018h:4.
    pub serial_number: u32,
    /// Settings for the first power-on, in place of what is stored, and for later ones as long as nothing is. `None` takes
    /// what is stored; if nothing is, the drive is as it left the factory: unconfigured at 1 Mbit/s, if its product does not say otherwise.
    pub settings: Option<Configuration>,
    /// What the build of the firmware fixes, before all other sources of node-ID and bit rate.
    pub build: Wish,
    /// What the switches of the board ask for at each power-on, before what is stored.
    pub switches: Wish,
    /// Where LSS stores settings, and 1010h parameters.
    pub store: ParameterStore,
    /// What the motor drives; `None` has nothing along it.
    pub axis: Option<Axis>,
}

impl Setup {
    /// A drive fresh from the factory: no node-ID, 1 Mbit/s, an empty store that lasts as long as the drive.
    pub fn unconfigured(serial_number: u32) -> Self {
        Self {
            serial_number,
            settings: None,
            build: Wish::NOTHING,
            switches: Wish::NOTHING,
            store: Flash::in_memory().into_store(),
            axis: None,
        }
    }

    /// A drive with a node-ID (1 to 127, or 255 for none) at 1 Mbit/s and an empty store.
    ///
    /// # Panics
    /// If there is no such node-ID.
    pub fn with_node_id(serial_number: u32, node_id: u8) -> Self {
        let settings = Settings {
            node_id: NodeId::new(node_id).expect("a node-ID is 1 to 127, or 255"),
            bit_rate: BitRate::Kbit1000,
        };
        Self {
            settings: Some(settings.into()),
            ..Self::unconfigured(serial_number)
        }
    }
}
