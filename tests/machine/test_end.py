"""The end of a run, whatever brings it: current, brake and step pin are safe within a millisecond, and the watchdog starts the board anew."""

import pytest
from stm32f405 import HZ, MS
from stm32f405.interrupts import IRQ
from stm32f405.system import HARD_FAULT
from unicorn.arm_const import UC_ARM_REG_R0, UC_ARM_REG_SP

#: The watchdog's period at its nominal clock, and what an end may take on top: the time from the last control tick that fed it.
PERIOD = 1_000 * MS
LATEST = PERIOD + 10 * MS


def hard_fault(chip):
    chip.core.enter(HARD_FAULT)


def panic(chip):
    # What it would tell lies where there is nothing, which is one fault more.
    chip.core.uc.reg_write(UC_ARM_REG_R0, 0xFFFF_FF00)
    chip.core.pc, chip.core.sleeping = chip.image.find("rust_begin_unwind") | 1, False


def foreign_interrupt(chip):
    chip.core.system.enabled.add(IRQ["EXTI0"])
    chip.core.pend(16 + IRQ["EXTI0"])


def crystal_dies(chip):
    chip.rcc.fail_crystal()


def supply_of_the_chip_falls(chip):
    chip.exti.internal(16, 1)


def stack_overflows(chip):
    # The next interrupt finds no room.
    chip.core.uc.reg_write(UC_ARM_REG_SP, chip.image.symbols["_stack_end"] + 8)


ENDS = [hard_fault, panic, foreign_interrupt, crystal_dies, supply_of_the_chip_falls, stack_overflows]


@pytest.mark.parametrize("end", ENDS, ids=lambda end: end.__name__)
def test_the_motor_is_safe_within_a_millisecond(drive, end):
    drive.turn(20_000)
    chip = drive.chip
    assert drive.has_power() and drive.brake_is_open()
    since = chip.time
    end(chip)
    chip.run(MS)
    assert drive.is_safe()
    pulses = chip.tim1.pulses
    # Nothing but the watchdog, which has last been fed before, changes that.
    chip.run(PERIOD + 300 * MS, lambda: chip.resets)
    assert [reset.why for reset in chip.resets] == ["watchdog"]
    assert since < chip.resets[0].time - PERIOD + 10 * MS
    assert chip.resets[0].time - since < LATEST
    assert pulses == chip.tim1.pulses or chip.tim1.pulses == 0
    assert {level for _, level in chip.pins.changes("PA2", since)} <= {1, None}
    assert {level for _, level in chip.pins.changes("PC2", since)} <= {0, None}


def test_a_core_that_stands_still_makes_no_pulse_after_a_millisecond(drive):
    drive.turn(20_000)
    chip = drive.chip
    since = chip.time
    chip.core.is_stopped = True
    chip.run(20 * MS)
    assert chip.tim1.last_pulse - since < MS
    assert not chip.tim1.step_level()
    chip.run(LATEST, lambda: chip.resets)
    assert chip.resets[0].time - since < LATEST
    assert not drive.has_power()


def test_a_node_task_that_hangs_stops_the_motor_within_50_ms(drive):
    drive[0x6085] = 10_000_000
    drive.turn(20_000)
    chip = drive.chip
    since = chip.time
    # The dispatcher of its priority, 2 of 16, is served no more.
    priority = chip.core.system.priority
    (dispatcher,) = [n for n in (IRQ["SPI1"], IRQ["SPI2"], IRQ["SPI3"]) if priority[16 + n] == 0xE0]
    chip.core.system.enabled.discard(dispatcher)
    chip.run(50 * MS)
    drive.settle()
    assert chip.tim1.last_pulse - since < 50 * MS
    (off, _) = chip.pins.changes("PA2", since)[0]
    assert off - since < 50 * MS
    # Until then the watchdog was fed, so that no stop is cut short.
    chip.run(LATEST, lambda: chip.resets)
    assert 0 <= PERIOD - (chip.resets[0].time - off) < 2 * MS


@pytest.mark.parametrize(("oscillator", "period"), [(17_000, 1_883), (47_000, 681)])
def test_a_watchdog_is_as_fast_as_its_oscillator(drive, oscillator, period):
    """The bound of all that the processor cannot end itself: a core that stands still holds current and brake for so long."""
    drive.turn(20_000)
    chip = drive.chip
    chip.iwdg.lsi = oscillator
    drive.bench.milliseconds(2)
    since = chip.time
    chip.core.is_stopped = True
    chip.run(2 * HZ, lambda: chip.resets)
    assert 0 <= period * MS - (chip.resets[0].time - since) < 3 * MS
    assert not drive.has_power() and not drive.brake_is_open()


def test_a_crystal_that_does_not_start_means_another_try_every_second(start):
    bench = start(crystal=False)
    bench.chip.run(3 * HZ, lambda: len(bench.chip.resets) == 2)
    first, second = bench.chip.resets
    assert {first.why, second.why} == {"watchdog"}
    assert PERIOD <= first.time < LATEST
    assert PERIOD <= second.time - first.time < LATEST
    assert not any(level == 0 for _, level in bench.chip.pins.changes("PA2"))


def test_a_probe_that_leaves_rtt_in_its_blocking_mode_stops_nothing(drive):
    # The channel is full and nobody reads: its write position is just behind its read position.
    chip = drive.chip
    channel = chip.image.symbols["_SEGGER_RTT"] + 24
    memory = chip.core.uc
    word = lambda offset: int.from_bytes(memory.mem_read(channel + offset, 4), "little")
    size, written = word(8), word(12)
    memory.mem_write(channel + 16, ((written + 1) % size).to_bytes(4, "little"))
    memory.mem_write(channel + 20, (2).to_bytes(4, "little"))
    ticks = chip.core.counts[15]
    # It is told in the log.
    chip.can.go_bus_off()
    chip.run(100 * MS)
    assert chip.core.counts[15] - ticks in range(99, 102)
    assert chip.resets == []


def test_whoever_ran_before_may_have_left_clocks_and_vectors_anywhere(start, numbered):
    bench = start(flash=numbered)
    chip = bench.chip
    # A boot loader on the crystal and the PLL, with its own table of vectors and its own stack.
    chip.flash["ACR"] = 5
    chip.rcc["CR"] = 0x0303_0083
    chip.rcc["PLLCFGR"] = 0x2740_5408
    chip.rcc["CFGR"] = 0x940A
    chip.core.system.stored[0xED08] = 0x1FFF_0000
    chip.core.uc.reg_write(UC_ARM_REG_SP, 0x2001_0000)
    chip.run(HZ // 4, lambda: bench.frames)
    assert bench.frames[0].data == b"\x00"
    assert chip.resets == []
