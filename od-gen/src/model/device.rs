//! What a data sheet says about itself and about the device as a whole (CiA 306, 4.5).

use super::places::KeyPlaces;

/// What a file describes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileKind {
    /// All devices of a kind: an electronic data sheet.
    #[default]
    Eds,
    /// One configured device: a device configuration file.
    Dcf,
    /// All devices of a kind, in XML (CiA 311).
    Xdd,
}

/// The section FileInfo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileInfo {
    /// FileName.
    pub file_name: String,
    /// FileVersion.
    pub file_version: u8,
    /// FileRevision.
    pub file_revision: u8,
    /// EDSVersion: that of CiA 306 which the file follows.
    pub eds_version: String,
    /// Description.
    pub description: String,
    /// CreationTime, `hh:mm(AM|PM)`.
    pub creation_time: String,
    /// CreationDate, `mm-dd-yyyy`.
    pub creation_date: String,
    /// CreatedBy.
    pub created_by: String,
    /// ModificationTime.
    pub modification_time: String,
    /// ModificationDate.
    pub modification_date: String,
    /// ModifiedBy.
    pub modified_by: String,
    /// LastEDS: the data sheet that a DCF was made from.
    pub last_eds: String,
}

/// The section DeviceInfo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceInfo {
    /// VendorName.
    pub vendor_name: String,
    /// VendorNumber.
    pub vendor_number: Option<u32>,
    /// ProductName.
    pub product_name: String,
    /// ProductNumber.
    pub product_number: Option<u32>,
    /// RevisionNumber.
    pub revision_number: Option<u32>,
    /// OrderCode.
    pub order_code: String,
    /// Bit rates in kbit/s.
    pub bit_rates: Vec<u16>,
    /// SimpleBootUpMaster.
    pub simple_boot_up_master: bool,
    /// SimpleBootUpSlave.
    pub simple_boot_up_slave: bool,
    /// Granularity: what a mapped length is a multiple of, in bits; 0 where mappings are fixed.
    pub granularity: u8,
    /// DynamicChannelsSupported.
    pub dynamic_channels: u8,
    /// CompactPDO: which sub-indices of PDO records that are not described exist, as bits.
    pub compact_pdo: u8,
    /// GroupMessaging: whether it has multiplexed PDOs.
    pub group_messaging: bool,
    /// NrOfRXPDO, where it is stated.
    pub rpdos: Option<u16>,
    /// NrOfTXPDO, where it is stated.
    pub tpdos: Option<u16>,
    /// LSS_Supported: whether LSS can configure it.
    pub lss: bool,
    /// Where its keys stand.
    pub places: KeyPlaces,
}

/// The section DeviceComissioning of a DCF, which CiA 306 spells like this.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Commissioning {
    /// NodeID, 1 to 127.
    pub node_id: u8,
    /// NodeName.
    pub node_name: String,
    /// Baudrate in kbit/s.
    pub bit_rate: u16,
    /// NetNumber.
    pub net_number: u32,
    /// NetworkName.
    pub network_name: String,
    /// CANopenManager: whether the node manages the network.
    pub is_manager: bool,
    /// LSS_SerialNumber.
    pub serial_number: Option<u32>,
}
