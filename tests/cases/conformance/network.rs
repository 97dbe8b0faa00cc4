//! NMT, heartbeats and guarding.

use master::bus::Station;
use od_gen::model::Model;
use tests::line::Line;

use super::NODE;

const STOPPED: u8 = 0x04;
const OPERATIONAL: u8 = 0x05;
const PRE_OPERATIONAL: u8 = 0x7F;

/// The identifier of error control, of the server's answers, of EMCY.
const ERROR_CONTROL: u16 = 0x700 + NODE as u16;
const EMERGENCY: u16 = 0x080 + NODE as u16;

/// Gives a command of NMT.
fn command<S: Station>(line: &mut Line<S>, specifier: u8) {
    line.send(&format!("000 [2] {specifier:02X} {NODE:02X}"));
}

/// Each state by its command, then each command in it: the state that follows, the boot-up message of a reset, and who is served.
pub fn states_follow_commands<S: Station>(line: &mut Line<S>) {
    let enter = [
        (0x01, OPERATIONAL),
        (0x02, STOPPED),
        (0x80, PRE_OPERATIONAL),
    ];
    let reset = [(0x81, PRE_OPERATIONAL), (0x82, PRE_OPERATIONAL)];
    for (enters, from) in enter {
        for (specifier, to) in enter.into_iter().chain(reset) {
            let what = format!("command {specifier:02X}h in state {from:02X}h");
            line.write_u16(0x1017, 0, 20);
            command(line, enters);
            line.drain(25);
            line.drain_until(&format!("{ERROR_CONTROL:03X} [1] {from:02X}"), 25);
            command(line, specifier);
            if specifier >= 0x81 {
                line.drain_until(&format!("{ERROR_CONTROL:03X} [1] 00"), 500);
                assert_eq!(line.read_u16(0x1017, 0), 0, "{what}");
                line.write_u16(0x1017, 0, 20);
            }
            line.drain(25);
            let beat = line.drain_until(&format!("{ERROR_CONTROL:03X} [1] xx"), 25);
            assert_eq!(beat.payload(), [to], "{what}");
            // SDO is served in all states but Stopped.
            line.drain(1);
            line.send(&format!("{:03X}: 40 00 10 00", 0x600 + u16::from(NODE)));
            let answered = (0..20).any(|_| {
                line.next(canopen::Duration::millis(1))
                    .and_then(|frame| frame.standard_id())
                    == Some(0x580 + u16::from(NODE))
            });
            assert_eq!(answered, to != STOPPED, "{what}");
            command(line, 0x80);
            line.drain(5);
            line.write_u16(0x1017, 0, 0);
        }
    }
}

/// By heartbeats, and where the data sheet lists guarding, by answers with a toggle bit.
pub fn state_is_told<S: Station>(sheet: &Model, line: &mut Line<S>) {
    let is_guarded = sheet.object(0x100C).is_some() || sheet.object(0x100D).is_some();
    for (specifier, state) in [
        (0x80, PRE_OPERATIONAL),
        (0x01, OPERATIONAL),
        (0x02, STOPPED),
    ] {
        command(line, 0x80);
        line.drain(5);
        line.write_u16(0x1017, 0, 50);
        command(line, specifier);
        line.drain(55);
        let told = format!("{ERROR_CONTROL:03X} [1] {state:02X}");
        for _ in 0..3 {
            let before = line.now();
            line.drain_until(&told, 51);
            let passed = (line.now() - before).to_millis();
            assert!(passed <= 50, "{passed} ms between heartbeats");
            line.drain(40);
        }
        // A guarding master is not answered while there are heartbeats.
        line.drain_until(&told, 20);
        line.send(&format!("{ERROR_CONTROL:03X} [1] rtr"));
        line.drain_until(&told, 51);

        command(line, 0x80);
        line.drain(5);
        line.write_u16(0x1017, 0, 0);
        // Guarding begins anew, with the toggle bit 0, at a boot.
        command(line, 0x82);
        line.drain_until(&format!("{ERROR_CONTROL:03X} [1] 00"), 500);
        command(line, specifier);
        line.drain(5);
        for toggle in [0, 0x80, 0] {
            line.send(&format!("{ERROR_CONTROL:03X} [1] rtr"));
            let answer = (0..20).find_map(|_| {
                line.next(canopen::Duration::millis(1))
                    .filter(|frame| frame.standard_id() == Some(ERROR_CONTROL))
            });
            let expected = is_guarded.then_some(state | toggle);
            assert_eq!(answer.map(|frame| frame.payload()[0]), expected);
        }
    }
}

/// A node in 1016h whose heartbeats stay away is an error, on the bus and in 1001h and 1003h, until it is back.
pub fn lost_nodes_are_told<S: Station>(sheet: &Model, line: &mut Line<S>) {
    if sheet.object(0x1016).is_none() {
        assert_eq!(line.try_read(0x1016, 1), Err(0x0602_0000));
        return;
    }
    line.write_u32(0x1016, 1, 0x0009_0064);
    assert_eq!(line.read_u8(0x1001, 0), 0);
    line.send("709 [1] 05");
    line.run_millis(90);
    assert_eq!(line.read_u8(0x1001, 0), 0);
    line.drain_until(&format!("{EMERGENCY:03X}: 30 81 11 .."), 15);
    assert_eq!(line.read_u8(0x1001, 0), 0x11);
    assert_eq!(line.read_u8(0x1003, 0), 1);
    assert_eq!(line.read_u32(0x1003, 1) & 0xFFFF, 0x8130);
    line.send("709 [1] 05");
    line.drain_until(&format!("{EMERGENCY:03X}: 00 00 00 .."), 5);
    assert_eq!(line.read_u8(0x1001, 0), 0);
}
