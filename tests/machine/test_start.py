"""Power-on: what the pins do, LSS, and what is kept without power."""

from conftest import EDS, NODE_ID
from frames import Frames
from stm32f405 import MS

#: Pins of the power stage and what a stage takes as off.
OFF = {"PA2": 1, "PC2": 0, "PB5": 0, "PB6": 0, "PB7": 0, "PB10": 0}


def test_no_pin_of_the_stage_is_ever_on_at_a_start(unconfigured):
    for pin, off in OFF.items():
        levels = [level for _, level in unconfigured.chip.pins.changes(pin)]
        assert levels == [off], pin
    assert unconfigured.chip.tim1.pulses == 0
    assert unconfigured.frames == []


def test_an_unconfigured_chip_is_found_numbered_and_keeps_its_number(unconfigured):
    lss = unconfigured.network.lss
    lss.RESPONSE_TIMEOUT = 0.02
    found, words = lss.fast_scan()
    assert found and words[:3] == [0, 0x402, 0x10000]
    boot_up = Frames(unconfigured.network, 0x700 + NODE_ID)
    lss.RESPONSE_TIMEOUT = 2
    lss.configure_node_id(NODE_ID)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    assert boot_up.next() == b"\x00"
    unconfigured.chip.cycle_power()
    assert boot_up.next() == b"\x00"
    node = unconfigured.add(NODE_ID, EDS)
    assert node.sdo[0x1018][4].raw == words[3]
    assert unconfigured.chip.resets == []


def test_the_chip_boots_within_a_tenth_of_a_second(bench):
    assert bench.frames[0].id == 0x700 + NODE_ID
    assert bench.frames[0].time < 100 * MS


def test_a_bus_that_somebody_holds_stops_nothing_but_frames(start, numbered):
    """The controller does not come out of its initialisation, and nobody waits for it."""
    bench = start(flash=numbered)
    chip = bench.chip
    chip.can.hold(True)
    bench.milliseconds(200)
    ticks = chip.core.counts[15]
    bench.milliseconds(100)
    assert chip.core.counts[15] - ticks in range(99, 102)
    assert chip.can["MSR"] & 1 and not chip.can["MCR"] & 1
    assert (bench.frames, chip.resets) == ([], [])
    chip.can.hold(False)
    bench.milliseconds(5)
    assert bench.frames[0].id == 0x700 + NODE_ID
