"""A chip with a stage and a motor on its pins, and a master that knows the data sheet of a servo: what the tests of the servo boards begin with."""

import configparser
import functools
import io

import canopen
from canopen.profiles.p402 import BaseNode402
from conftest import NODE_ID, ROOT, Starts, once
from drive import ENABLE, OPERATION_ENABLED, SHUTDOWN, SWITCH_ON, Drive
from measure import level
from stm32f405.engine import FLASH
from stm32f405.interrupts import IRQ
from unicorn import UC_HOOK_BLOCK

PROFILE_TORQUE, PROFILE_POSITION = 4, 1
#: Clocks of a period of the modulation.
PERIOD = 8_400


@functools.cache
def data_sheet():
    """That of the drive with a servo, as `eds/servo.toml` has it."""
    sheet = configparser.RawConfigParser(strict=False)
    sheet.optionxform = str
    parts = [ROOT / "eds" / "parts" / f"{part}.eds" for part in ("torque", "tuning")]
    sheet.read([ROOT / "eds" / "axis402.eds", *parts], encoding="utf-8")
    text = io.StringIO()
    sheet.write(text)
    text.seek(0)
    text.name = "servo.eds"
    return canopen.import_od(text, NODE_ID)


def commanded(bench):
    """A master's drive on it."""
    node = BaseNode402(NODE_ID, data_sheet())
    bench.network.add_node(node)
    return Drive(bench, node)


def enable(drive, mode):
    drive[0x6060] = mode
    for word in (SHUTDOWN, SWITCH_ON, ENABLE):
        drive[0x6040] = word
        drive.bench.milliseconds(5)
    drive.until(lambda: drive.state() == OPERATION_ENABLED, "enabled")
    return drive


def hold(servo, share):
    """A torque in thousandths, on a rotor that is held."""
    servo.chip.motor.is_held = True
    servo[0x6087] = 10_000
    servo[0x6071] = share
    servo.bench.milliseconds(100)


def move(servo, way):
    """A profile position from where it is; gives the target."""
    servo[0x6060] = PROFILE_POSITION
    servo.bench.milliseconds(5)
    target = servo[0x6064] + way
    servo[0x607A] = target
    servo[0x6040] = ENABLE
    servo[0x6040] = ENABLE | 0x10
    return target


def on_the_way(servo, speed, way):
    """In the middle of a profile position move."""
    servo[0x6081], servo[0x6083], servo[0x6084] = speed, 20 * speed, 20 * speed
    move(servo, way)
    servo.bench.milliseconds(80)
    assert abs(servo[0x607A] - servo[0x6064]) > abs(way) / 2


#: Clocks of a period of the loops above the current, 4 kHz.
CONTROL = 42_000
#: Clocks that the interrupts of a period may take, by the model of cost: the one of the currents in each of the modulation, the other in each of the loops. What they take
#: on each board, and in which motion, is in docs/servo.md.
CURRENT, LOOPS = 1_100, 6_500
#: For so long the loops keep back the current interrupt.
MASKED = 400


#: 20C1h:1, and what 20C1h:3 to :11 tell, in which unit.
FIELD, DONE = 3, 6
FOUND = {
    3: ("resistance", 1e-6), 4: ("inductance_along", 1e-9), 5: ("inductance_across", 1e-9), 6: ("flux", 1e-9), 7: ("pole_pairs", 1), 8: ("direction", 1),
    10: ("inertia", 1e-9), 11: ("friction", 1e-6),
}  # fmt: skip


def measure(servo):
    """20C0h:1 = 1. What was found, and the clocks that the longest current interrupt takes around each change of the part, by the model of cost: on a copy of the chip."""
    bench = servo.bench
    servo[0x6060] = PROFILE_POSITION
    bench.milliseconds(20)
    servo.sdo[0x20C0][1].raw = 1
    before, state, longest = bench.copy(), 0, []
    while state < DONE:
        bench.milliseconds(25)
        now = servo.sdo[0x20C1][1].raw
        if now != state and now >= FIELD:
            copy = before.chip
            copy.core.count_cost()
            copy.run(bench.chip.time - copy.time)
            longest.append(copy.core.cost.runs[16 + IRQ["ADC"]])
        before.chip.leave()
        before, state = bench.copy(), now
    before.chip.leave()
    assert state == DONE, servo.sdo[0x20C1][2].raw
    print("clocks of the longest current interrupt around the ends of the parts:", longest)
    return {name: servo.sdo[0x20C1][sub].raw * unit for sub, (name, unit) in FOUND.items()}, longest


def end_of_current_interrupt(chip):
    """Runs until the next one of the currents has ended."""
    core, number = chip.core, 16 + IRQ["ADC"]
    served = core.counts[number]
    assert chip.run(2 * PERIOD, lambda: core.counts[number] > served and number not in (n for n, _, _ in core.active))


def interrupts_are_short(chip, periods, more=0, modulation=PERIOD):
    """The clocks that the interrupts of the currents and of the loops take, by the model of cost, in so many periods of the loops. `more`: how often the converters end in a
    period of the modulation for nothing."""
    chip.core.count_cost()
    end_of_current_interrupt(chip)
    # From between two of them on, so that none is at an edge of what is counted.
    chip.run(modulation // 4)
    chip.core.cost.forget()
    served = {name: chip.core.counts[16 + IRQ[name]] for name in ("ADC", "TIM7")}
    taken, current, loops = chip.core.shares.clocks, [], []
    for _ in range(periods):
        above = taken[level(6)]
        for _ in range(CONTROL // modulation):
            before = taken[level(7)]
            chip.run(modulation)
            current.append(taken[level(7)] - before)
        loops.append(taken[level(6)] - above)
    for name, times in (("ADC", CONTROL // modulation * (1 + more)), ("TIM7", 1)):
        assert chip.core.counts[16 + IRQ[name]] - served[name] == periods * times, name
    masked = chip.core.cost.longest[level(7)]
    for name, clocks in (("currents", current), ("loops", loops)):
        print(f"{name}: {sum(clocks) / len(clocks):.0f} clocks in the mean, {max(clocks)} at most")
    print(f"currents masked for {masked} clocks at most")
    # Widths are written in their half of a period, also where the loops come before.
    assert max(current) + masked < modulation / 2
    assert max(current) < CURRENT and max(loops) < LOOPS and masked < MASKED


def current_interrupts(chip, periods, more=0):
    """The clocks that the interrupt of the converters takes in each of these periods, by the model of cost. `more`: how often it comes in a period beside the one."""
    core, number, clocks = chip.core, 16 + IRQ["ADC"], []
    core.count_cost()
    # So none is in two periods.
    end_of_current_interrupt(chip)
    begin, served = chip.time, core.counts[number]
    for period in range(1, periods + 1):
        before = core.shares.clocks[level(7)]
        chip.run(begin + period * PERIOD - chip.time)
        clocks.append(core.shares.clocks[level(7)] - before)
    assert core.counts[number] - served == periods * (1 + more)
    print(f"{sum(clocks) / periods:.0f} clocks in the mean, {max(clocks)} at most")
    return clocks


def in_flash(chip, periods):
    """The functions in flash that the interrupt of the converters has run in each of these periods."""
    core, functions, seen = chip.core, [], set()

    def on_block(_uc, address, _size, _):
        if core.active and core.active[-1][0] == 16 + IRQ["ADC"] and address >= FLASH:
            seen.add(chip.image.function(address))

    core.uc.hook_add(UC_HOOK_BLOCK, on_block)
    core.uc.ctl_flush_tb()
    served = core.counts[16 + IRQ["ADC"]]
    for _ in range(periods):
        seen.clear()
        chip.run(PERIOD)
        functions.append(set(seen))
    assert core.counts[16 + IRQ["ADC"]] - served >= periods
    return functions


class Kind:
    """A servo board: `begin` is a chip from power-on with what hangs on it, `rated` 6075h and 6076h."""

    def __init__(self, image, begin, rated):
        self.image, self.begin, self.rated = image, begin, rated

    def numbered(self):
        """The parameter sectors of one that has stored its node-ID."""

        def number(start):
            bench = self.begin(start)
            bench.milliseconds(150)
            bench.give_node_id(NODE_ID, store=True)
            bench.chip.cycle_power()
            bench.chip.leave()
            return bench.chip.parameters

        return once(self.image, number)

    def booted(self):
        """The bench of one with the stage ready, from which tests begin."""
        flash = self.numbered()

        def boot(start):
            bench = self.begin(start, flash=flash)
            bench.chip.run(20_000_000, lambda: bench.frames)
            bench.milliseconds(60)
            drive = commanded(bench)
            assert (drive[0x6075], drive[0x6076]) == self.rated
            return bench

        return once(self.image, boot)

    def found(self, booted):
        """The same behind its first enable, in which the magnet is found."""

        def find(start):
            bench = start.like(booted)
            drive = commanded(bench)
            enable(drive, PROFILE_TORQUE)
            bench.milliseconds(1_050)
            assert drive.state() == OPERATION_ENABLED
            return bench

        return once(self.image, find)


def starting(image, monkeypatch):
    """For a fixture: starts chips with this image."""
    starts = Starts(image, monkeypatch)
    yield starts
    for bench in starts.benches:
        bench.chip.leave()
