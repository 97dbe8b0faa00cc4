//! A drive whose motor is moved by its current: torque modes, torque limits, the other modes on a loop, and what makes it stop.

mod absolute;
mod cyclic;
mod faults;
mod feedback;
mod figures;
mod limits;
mod loops;
mod modes;
mod objects;
mod software_limit;
mod stepper;
mod torque;
mod tuning;
mod weakening;

use tests::drive::ServoBench;

/// In operation enabled, in this mode.
fn enabled(name: &str, mode: u8) -> ServoBench {
    enable(ServoBench::on_axis(name), mode)
}

/// The same of a drive that is there.
fn enable(mut drive: ServoBench, mode: u8) -> ServoBench {
    drive.write_u8(0x6060, 0, mode);
    drive.enable();
    drive.run_millis(20);
    assert_eq!(drive.read_i8(0x6061, 0), mode as i8);
    drive
}

/// 6077h, in thousandths of the rated torque.
fn torque(drive: &mut ServoBench) -> i16 {
    drive.read_i16(0x6077, 0)
}

/// The rotor is held by something outside, so that a torque makes no motion.
fn hold(drive: &mut ServoBench) {
    drive.plant().load_brake = 20.0;
}
