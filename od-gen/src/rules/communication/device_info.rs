//! Rules: what DeviceInfo repeats is what the dictionary says (CiA 306, 4.5.2).

use crate::diagnostic::Findings;
use crate::model::DeviceInfo;
use crate::rules::setting::Setting;
use crate::rules::{Class, Rule, Subject};
use crate::source::Span;

pub(crate) const RULES: &[&Rule] = &[
    &IDENTITY_MISMATCH,
    &NO_VENDOR_ID,
    &PDO_COUNT,
    &LSS_WITHOUT_IDENTITY,
    &NO_BIT_RATE,
    &BOOT_UP,
    &MODULAR_DEVICE,
    &COMPACT_PDO,
];

static IDENTITY_MISMATCH: Rule = Rule::masters(
    "identity-mismatch",
    "VendorNumber, ProductNumber and RevisionNumber are the defaults of 1018h.",
    "Masters find the data sheet of a device by these numbers, and refuse a device that reports others.",
).strict();

static NO_VENDOR_ID: Rule = Rule::warning(
    "no-vendor-id",
    "1018h:1 is a vendor-ID.",
    "CAN in Automation assigns vendor-IDs to makers of devices; 0 is none.",
);

static PDO_COUNT: Rule = Rule::masters(
    "pdo-count",
    "NrOfRXPDO and NrOfTXPDO are how many PDOs are described.",
    "Tools make room by these numbers. When this is silenced, what is described counts.",
)
.strict();

static LSS_WITHOUT_IDENTITY: Rule = Rule::masters(
    "lss-without-identity",
    "A device with LSS has 1018h with all four sub-indices.",
    "The LSS address is vendor-ID, product code, revision number and serial number (CiA 305): without one of them a master \
     cannot select the device.",
).strict();

static NO_BIT_RATE: Rule = Rule::masters(
    "no-bit-rate",
    "DeviceInfo names a bit rate.",
    "Write BaudRate_125=1 and its like for each that the device has.",
);

static BOOT_UP: Rule = Rule::warning(
    "boot-up-role",
    "A device boots as slave, as master, or can do both.",
    "With SimpleBootUpMaster=0 and SimpleBootUpSlave=0 it could not be started at all.",
);

static MODULAR_DEVICE: Rule = Rule::warning(
    "modular-device",
    "The device has no channels that come and go.",
    "The generated dictionary is static: DynamicChannelsSupported should be 0. What it adds to the dictionary of a modular device \
     while it runs is not there.",
).of(Class::Firmware);

static COMPACT_PDO: Rule = Rule::masters(
    "compact-pdo",
    "CompactPDO goes with the number of PDOs and has a bit for their COB-ID.",
    "CompactPDO stands for the PDOs up to NrOfRXPDO and NrOfTXPDO that no section describes. Its bits say which sub-indices of the \
     communication parameters there are: 1 for the COB-ID, 2 for the transmission type, 4 for the inhibit time, 16 for the event \
     timer.",
);

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    let device = &model.device;
    // A section that is missing has been reported.
    if device.places.section == Span::default() {
        return;
    }
    check_identity(model, findings);
    check_pdo_counts(model, findings);
    if device.lss {
        for sub in 1..=4_u8 {
            if !model.lacks_object(0x1018) && model.lacks(0x1018, sub) {
                let message = format!("LSS_Supported is 1, but 1018h:{sub:X} is not there");
                findings.report(
                    &LSS_WITHOUT_IDENTITY,
                    device.places.of("LSS_Supported"),
                    message,
                );
            }
        }
    }
    if device.bit_rates.is_empty() {
        let message = "no BaudRate_ is 1";
        findings.report(&NO_BIT_RATE, device.places.section, message);
    }
    let is_stated = |key| device.places.of(key) != device.places.section;
    if is_stated("SimpleBootUpMaster")
        && is_stated("SimpleBootUpSlave")
        && !device.simple_boot_up_master
        && !device.simple_boot_up_slave
    {
        let message = "SimpleBootUpMaster and SimpleBootUpSlave are both 0";
        let finding = findings.report(&BOOT_UP, device.places.of("SimpleBootUpSlave"), message);
        finding.help("write `SimpleBootUpSlave=1`");
    }
    if device.dynamic_channels != 0 {
        let key = "DynamicChannelsSupported";
        let channels = device.dynamic_channels;
        let message = format!("{key} is {channels}: the generated dictionary is static");
        findings.report(&MODULAR_DEVICE, device.places.of(key), message);
    }
    check_compact_pdo(device, findings);
}

fn check_compact_pdo(device: &DeviceInfo, findings: &mut Findings) {
    let pdos = [device.rpdos, device.tpdos];
    let has_none = pdos.iter().all(|count| count.unwrap_or_default() == 0);
    let message = match device.compact_pdo {
        0 => return,
        _ if has_none => "CompactPDO describes no PDO: NrOfRXPDO and NrOfTXPDO are 0".into(),
        bits if bits & 3 != 3 => {
            format!("CompactPDO is {bits}: PDOs have a COB-ID and a transmission type")
        }
        bits if bits >> 6 != 0 => format!("CompactPDO is {bits}: PDOs have no sub-index above 6"),
        _ => return,
    };
    findings.report(&COMPACT_PDO, device.places.of("CompactPDO"), message);
}

fn check_identity(model: &Subject<'_>, findings: &mut Findings) {
    let device = &model.device;
    for (key, stated, sub) in [
        ("VendorNumber", device.vendor_number, 1_u8),
        ("ProductNumber", device.product_number, 2),
        ("RevisionNumber", device.revision_number, 3),
    ] {
        let setting = Setting::at(model, 0x1018, sub);
        if let (Some(stated), Some(setting)) = (stated, setting)
            && i128::from(stated) != setting.value
        {
            let default = setting.value;
            let message = format!("{key} is 0x{stated:08X}, but 1018h:{sub:X} is 0x{default:08X}");
            let finding = findings.report(&IDENTITY_MISMATCH, device.places.of(key), message);
            finding.also(setting.span, "what the device says");
            finding.help("one of the two is wrong: a master compares with what the device says");
        }
    }
    if let Some(vendor) = Setting::at(model, 0x1018, 1).filter(|vendor| vendor.value == 0) {
        let message = "the vendor-ID is 0";
        findings.report(&NO_VENDOR_ID, vendor.span, message);
    }
}

fn check_pdo_counts(model: &Subject<'_>, findings: &mut Findings) {
    let device = &model.device;
    for (key, stated, first) in [
        ("NrOfRXPDO", device.rpdos, 0x1400_u16),
        ("NrOfTXPDO", device.tpdos, 0x1800),
    ] {
        let described = model.objects_in(first..=first + 0x1FF);
        let count = described.len();
        if let Some(stated) = stated.filter(|stated| usize::from(*stated) != count) {
            let message =
                format!("{key} is {stated}, but {count} are described from {first:04X}h on");
            let finding = findings.report(&PDO_COUNT, device.places.of(key), message);
            if let Some(first) = described.first() {
                finding.also(first.places.section, "the first of them");
            }
        }
    }
}
