"""Faults that the firmware survives: what becomes of the motor, how it is told, and that the drive works on."""

import pytest
from conftest import NODE_ID
from drive import FAULT_RESET
from stm32f405 import HZ, MS, US
from stm32f405.bxcan import Frame
from stm32f405.interrupts import IRQ
from stm32f405.system import SYSTICK_EXCEPTION

EMERGENCY = 0x80 + NODE_ID


def codes(drive, since):
    """The codes of the emergency messages behind a moment."""
    return [int.from_bytes(f.data[:2], "little") for f in drive.bench.sent_since(since, EMERGENCY)]


def recovers(drive):
    """The fault is reset, and the motor turns again."""
    # Some control ticks in which the cause is gone.
    drive.bench.milliseconds(5)
    drive[0x60FF] = 0
    drive[0x6040] = 0
    drive[0x6040] = FAULT_RESET
    drive.bench.milliseconds(5)
    assert not drive[0x6041] & 8
    drive[0x6040] = 0
    drive.turn(5_000)


def behind_a_tick(chip, microseconds):
    """So long behind the next control tick: what looks only there would see a fault the later, the earlier it comes."""
    ticks = chip.core.counts[SYSTICK_EXCEPTION]
    assert chip.run(2 * MS, lambda: chip.core.counts[SYSTICK_EXCEPTION] > ticks)
    chip.run(microseconds * US)


#: Where in the time between two control ticks a fault comes, in microseconds.
MOMENTS = [1, 40, 150, 600, 950]


@pytest.mark.parametrize("moment", MOMENTS)
def test_the_break_input_ends_the_pulses_at_once(drive, moment):
    drive.turn(100_000)
    chip = drive.chip
    behind_a_tick(chip, moment)
    since = chip.time
    chip.pins.drive("PB12", 0)
    chip.run(400 * US)
    assert drive.is_safe()
    assert chip.tim1.last_pulse <= since
    chip.run(5 * MS)
    assert codes(drive, since) == [0x9000]
    assert drive[0x6064] - drive.settle() in range(-1, 2)
    chip.pins.drive("PB12", 1)
    recovers(drive)


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize(("pin", "code"), [("PC0", 0x3220), ("PA3", 0x5400)], ids=["supply", "driver"])
def test_a_stage_without_supply_or_with_a_fault_gets_no_current(drive, pin, code, moment):
    drive.turn(20_000)
    chip = drive.chip
    behind_a_tick(chip, moment)
    since = chip.time
    chip.pins.drive(pin, 0)
    # The refill looks at it four times in a millisecond, and the control tick is asked for then.
    chip.run(400 * US)
    assert drive.is_safe()
    assert chip.tim1.last_pulse - since < 400 * US
    chip.run(5 * MS)
    assert codes(drive, since) == [code]
    chip.pins.drive(pin, 1)
    recovers(drive)


def slows_down(chip, since, cruise):
    """When the first pulse behind a moment began that took longer than those of a cruise."""
    return next(run.begin for run in chip.tim1.log if run.begin > since and run.period > HZ // cruise)


def test_bus_off_is_a_quick_stop_and_the_controller_returns(drive):
    drive[0x6085] = 1_000_000
    drive.turn(20_000)
    chip, since = drive.chip, drive.chip.time
    chip.can.go_bus_off()
    chip.run(60 * MS)
    drive.settle()
    assert slows_down(chip, since, 20_000) - since < MS
    # 20,000 steps/s at 1,000,000 steps/s² is 20 ms.
    assert chip.tim1.last_pulse - since < 30 * MS
    assert not drive.has_power()
    # The device has it start again a tenth of a second later; 128 × 11 bits of 1 µs are to pass then.
    chip.run(60 * MS)
    assert codes(drive, since) == [0x8140, 0]
    assert drive.bench.sent_since(since)[0].time - since > 100 * MS + 1_408 * US
    recovers(drive)


def run_over(chip):
    """Nobody takes a dozen frames for 2 ms."""
    for _ in range(12):
        chip.can.to_send.append(Frame(0x123, False, False, bytes(8)))
    handlers = {IRQ[name] for name in ("CAN1_TX", "CAN1_RX0", "CAN1_SCE")}
    chip.core.system.enabled -= handlers
    chip.run(2 * MS)
    chip.core.system.enabled |= handlers
    assert chip.can.stats["overruns"] > 0


def test_a_fifo_that_runs_over_is_a_fault_with_current_in_the_motor(drive):
    drive[0x6085] = 1_000_000
    drive.turn(20_000)
    chip, since = drive.chip, drive.chip.time
    run_over(chip)
    seen = chip.time
    chip.run(100 * MS)
    # The interrupt that sees it asks for a control tick, and two segments of pulses are committed ahead.
    assert slows_down(chip, since, 20_000) - seen < MS
    assert codes(drive, since) == [0x8110]
    assert not drive.has_power()
    recovers(drive)


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize(
    ("what", "option", "value"),
    [(lambda chip: chip.can.go_bus_off(), 0x6007, 2), (lambda chip: chip.can.go_bus_off(), 0x605E, 0), (run_over, 0x605E, 0)],
    ids=["bus-off, no voltage", "bus-off, a fault without a ramp", "overrun, a fault without a ramp"],
)
def test_a_drive_that_is_not_to_stop_on_a_ramp_is_safe_within_a_millisecond(drive, what, option, value, moment):
    """How a motor ends when its master is lost is what the options say; these say: at once."""
    if what is not run_over:
        drive[0x6007] = 2 if option == 0x6007 else 1
    drive[option] = value
    drive.turn(20_000)
    chip = drive.chip
    behind_a_tick(chip, moment)
    what(chip)
    seen = chip.time
    chip.run(MS)
    assert drive.is_safe()
    assert chip.tim1.last_pulse - seen < MS


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_dma_stream_that_fails_is_a_fault_and_no_pulse_is_wild(drive, moment):
    drive.turn(20_000)
    chip = drive.chip
    behind_a_tick(chip, moment)
    since = chip.time
    chip.dma2.fail()
    chip.run(MS)
    assert drive.is_safe()
    assert chip.tim1.last_pulse - since < MS
    chip.run(5 * MS)
    assert codes(drive, since) == [0x5200]
    assert drive[0x6064] == drive.settle()
    recovers(drive)


def test_after_a_reset_of_the_node_the_boot_up_is_its_first_frame(drive):
    chip = drive.chip
    # Nobody acknowledges, so the mailboxes keep what they have.
    drive[0x1017] = 5
    chip.can.acknowledged = False
    chip.can.to_send.append(Frame(0x600 + NODE_ID, False, False, bytes.fromhex("40 00 10 00 00 00 00 00")))
    chip.run(20 * MS)
    assert any(chip.can[f"T{i}IR"] & 1 for i in range(3))
    since = chip.time
    chip.can.to_send.append(Frame(0, False, False, bytes([129, NODE_ID])))
    chip.run(5 * MS)
    chip.can.acknowledged = True
    chip.run(100 * MS)
    sent = drive.bench.sent_since(since)
    boot_up = [(frame.id, frame.data) for frame in sent].index((0x700 + NODE_ID, b"\x00"))
    # That the controller was error passive may be told before, as its identifier is lower; of the life before there is nothing.
    assert {frame.id for frame in sent[:boot_up]} <= {EMERGENCY}
    assert {frame.id for frame in sent[boot_up + 1 :]} <= {EMERGENCY}


def test_after_a_change_of_the_bit_rate_nothing_of_before_is_sent(drive):
    chip = drive.chip
    # To configuration state, and 500 kbit/s.
    for command in ("04 01", "13 00 02"):
        chip.can.to_send.append(Frame(0x7E5, False, False, bytes.fromhex(command).ljust(8, b"\0")))
    chip.run(2 * MS)
    # Nobody acknowledges from here on, so an SDO answer waits. Then the change, 20 ms later.
    chip.can.acknowledged = False
    for identifier, data in ((0x600 + NODE_ID, "40 00 10"), (0x7E5, "15 14 00")):
        chip.can.to_send.append(Frame(identifier, False, False, bytes.fromhex(data).ljust(8, b"\0")))
    chip.run(5 * MS)
    waiting = {chip.can[f"T{i}IR"] >> 21 for i in range(3) if chip.can[f"T{i}IR"] & 1}
    assert waiting == {0x580 + NODE_ID}
    assert chip.run(100 * MS, lambda: chip.can.bit() == HZ // 500_000)
    since, chip.can.acknowledged = chip.time, True
    chip.run(100 * MS)
    assert {frame.id for frame in drive.bench.sent_since(since)} <= {EMERGENCY}
    assert drive[0x1000] == 0x40192
