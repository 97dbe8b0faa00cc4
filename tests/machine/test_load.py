"""Loads that are meant to take the processor away from pulses and commands."""

import struct

import pytest
from conftest import EDS, NODE_ID
from drive import Drive
from stm32f405 import HZ, MS, US
from stm32f405.bxcan import Frame
from stm32f405.interrupts import IRQ
from test_motion import intervals

SYSTICK = 15


def control_ticks(drive, milliseconds):
    """How many came in so many milliseconds, and the longest that one waited, in microseconds."""
    core = drive.chip.core
    before = core.counts[SYSTICK]
    core.latency[SYSTICK] = 0
    drive.bench.milliseconds(milliseconds)
    return core.counts[SYSTICK] - before, core.latency[SYSTICK] / US


def test_an_input_that_rattles_a_million_times_a_second_takes_no_tick_and_no_pulse(drive):
    chip = drive.chip
    drive.turn(100_000)
    ticks, pulses, edges = chip.core.counts[SYSTICK], chip.tim1.pulses, 0
    since = chip.time
    while chip.time < since + 5 * MS:
        edges += 1
        chip.pins.drive("PA4", edges & 1)
        chip.run(HZ // 1_000_000)
    assert chip.core.counts[SYSTICK] - ticks in range(4, 7)
    drive.settle()
    # What is left of the pulses is at least what one tick is late.
    assert chip.tim1.pulses - pulses >= 400
    assert chip.core.counts[16 + 10] <= 3 * 66
    assert chip.exti["IMR"] & 0x3F0 == 0
    # Once it is quiet, edges are interrupts again.
    chip.pins.drive("PA4", 0)
    drive.bench.milliseconds(15)
    assert chip.exti["IMR"] & 0x3F0 == 0x3F0
    served = chip.core.counts[16 + 10]
    chip.pins.drive("PA4", 1)
    drive.bench.milliseconds(1)
    assert chip.core.counts[16 + 10] == served + 1
    assert drive[0x606C] == 100_000


def sends_changes(node, number, index, subindex=0):
    """This transmit PDO has one object and is sent when it changes."""
    pdo = node.tpdo[number]
    pdo.clear()
    pdo.add_variable(index, subindex)
    pdo.trans_type, pdo.enabled = 255, True
    pdo.save()


def is_sending(can, identifier):
    """Whether this frame of the chip is on the bus."""
    kind, mailbox = can.on_bus or (None, None)
    return kind == "sent" and can[f"T{mailbox}IR"] >> 21 == identifier


def waits(can, identifier):
    """Whether this frame of the chip is in a mailbox."""
    return any(can[f"T{mailbox}IR"] & 1 and can[f"T{mailbox}IR"] >> 21 == identifier for mailbox in range(3))


def test_at_10_kbit_s_nothing_waits_for_a_frame_that_makes_way_and_none_is_lost(bench):
    chip, lss = bench.chip, bench.network.lss
    node = bench.add(NODE_ID, EDS)
    node.tpdo.read()
    sends_changes(node, 3, 0x2064, 1)
    sends_changes(node, 4, 0x60FD)
    bench.network.nmt.send_command(1)
    lss.RESPONSE_TIMEOUT = 5
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    lss.configure_bit_timing(8)
    lss.activate_bit_timing(20)
    lss.send_switch_state_global(lss.WAITING_STATE)
    bench.milliseconds(200)
    assert chip.can.bit() == HZ // 10_000
    drive = Drive(bench, node)
    # An SDO answer is on the bus, the mailboxes beside it get PDO 4 and PDO 3, and PDO 1 is more urgent than all of them.
    bench.network.send_message(0x600 + NODE_ID, bytes.fromhex("40 00 10 00 00 00 00 00"))
    assert chip.run(50 * MS, lambda: is_sending(chip.can, 0x580 + NODE_ID))
    since = chip.time
    core = chip.core
    before, core.latency[SYSTICK] = core.counts[SYSTICK], 0
    chip.pins.drive("PA4", 1)
    bench.milliseconds(2)
    chip.adc.levels[14] = 3_000
    # The analogue input is not looked at in every tick.
    assert chip.run(8 * MS, lambda: waits(chip.can, 0x380 + NODE_ID))
    assert waits(chip.can, 0x480 + NODE_ID)
    chip.pins.drive("PC0", 0)
    bench.milliseconds(95)
    assert chip.can.stats["aborts of the frame on the bus"] == 1
    assert abs(core.counts[SYSTICK] - before - (chip.time - since) / MS) < 2
    assert core.latency[SYSTICK] < 100 * US
    sent = [frame.id - NODE_ID for frame in bench.sent_since(since)]
    assert sent[:1] == [0x580]
    assert sorted(sent[1:]) == sent[1:]
    assert {0x180, 0x380, 0x480} <= set(sent)
    assert drive[0x1000] == 0x40192


def test_a_full_bus_loses_no_frame_and_no_tick(drive):
    drive.turn(100_000)
    chip = drive.chip
    chip.can.to_send.extend(Frame(0x123, False, False, b"") for _ in range(1_000))
    chip.core.latency.clear()
    ticks, longest = control_ticks(drive, 50)
    assert ticks in range(49, 52)
    assert chip.can.stats["received"] > 900 and chip.can.stats["overruns"] == 0
    assert longest < 100
    assert drive[0x603F] == 0
    assert struct.pack("<I", drive[0x6041])[0] & 0x6F == 0x27


@pytest.mark.parametrize(("rate", "width"), [(1_000_000, 400), (4_900_000, 100)])
def test_a_full_bus_and_the_fastest_pulses_leave_most_of_the_processor(drive, rate, width):
    times = (width, width, 5_000, 5_000)
    for sub, value in enumerate((255, *times), start=1):
        drive.sdo[0x20B0][sub].raw = value
    drive.bench.pulse_times = times
    drive[0x6080] = drive[0x607F] = rate
    drive.turn(rate, acceleration=20 * rate)
    chip, core = drive.chip, drive.chip.core
    chip.can.to_send.extend(Frame(0x123, False, False, b"") for _ in range(2_000))
    core.latency.clear()
    since, before = chip.time, core.instructions
    begin = drive.settle()
    control_ticks(drive, 50)
    assert abs(drive.settle() - begin - rate * (chip.time - since) / HZ) <= 1
    assert intervals(chip.tim1, since) <= {HZ // rate, -(-HZ // rate)}
    share = (core.instructions - before) / (chip.time - since)
    waited = {name: core.latency[16 + irq] / US for name, irq in (("frame", IRQ["CAN1_RX0"]), ("refill", IRQ["TIM3"]))}
    stack = chip.image.symbols["_stack_start"] - core.lowest_stack
    print(f"share {share:.3f}, tick {core.latency[SYSTICK] / US:.1f} µs, {waited}, stack {stack}")
    assert chip.can.stats["overruns"] == 0
    assert share < 0.5
    # Three frames are in the FIFO after 141 µs.
    assert waited["frame"] < 40
    # A refill that is as late as this finds pulses for as long again.
    assert waited["refill"] < 120
    # Half of what there is.
    assert stack < 24 * 1024
