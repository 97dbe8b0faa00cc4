"""Faults at random: what goes wrong, when and for how long is drawn from a seed, and what becomes of the motor is judged.

    python tests/machine/random_faults.py --image ELF --runs 1000 --seed 1

A drive is brought where a run begins once; each run is a copy of that process (`os.fork`), in which a fault comes at a random moment. What follows
is one of three reactions, and which of them a fault may have is in `ALLOWED`:

- *works on*: no fault is told, and the drive does what it was doing;
- *fault*: an emergency message with a code that says what it is, current off, brake closed, no pulses, within a millisecond of a fault of the stage or
  the DMA;
- *end*: current off, brake closed and no pulse within a millisecond; the watchdog does the rest (`test_end.py`).

Whatever it is, no pulse is wild: widths, gaps and turns are those of the driver, no run is faster than was asked for, pulses at the pin, counter and
6064h are one number, and behind the end of the current there is no pulse."""

import argparse
import collections
import os
import pathlib
import pickle
import random
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "python")]

import pytest  # noqa: E402
from conftest import EDS, NODE_ID  # noqa: E402
from drive import ENABLE, PROFILE_POSITION, Drive  # noqa: E402
from judge import judge_pulses  # noqa: E402
from master import Bench  # noqa: E402
from stepped import VirtualTime  # noqa: E402
from stm32f405 import HZ, MS, NEVER, US, Chip  # noqa: E402
from stm32f405.bxcan import BOFF  # noqa: E402
from stm32f405.image import Image  # noqa: E402
from test_flash import SAVE  # noqa: E402
from unicorn import UC_HOOK_MEM_WRITE  # noqa: E402

#: The fastest pulses of a run, per second.
RATE = 50_000
#: Clocks between two pulses of it, which may be early by a fiftieth where a ramp ends.
FASTEST = HZ // RATE * 49 // 50

WORKS_ON, FAULT, END = "works on", "fault", "end"


#: Statusword: a limit holds the motor back. The switches: behind the motor, which goes forwards,
#: and before it.
INTERNAL_LIMIT, LIMITS = 0x0800, ("PA4", "PA5")


class Fault:
    """Something that goes wrong on a chip. `begin` is its moment; `text` tells what was drawn."""

    def __init__(self, chance):
        self.chance, self.text, self.pin = chance, "", None

    def between(self, least, most):
        """A time, each order of magnitude as likely as another."""
        return round(least * (most / least) ** self.chance.random())


class LateAccess(Fault):
    """Accesses to registers are answered late: the bus holds the core."""

    def begin(self, drive):
        chip, left = drive.chip, [self.chance.randint(1, 20)]
        each = self.between(1, 500 * US)
        self.text = f"{left[0]} accesses take {each} clocks"
        load = chip.load

        def late(offset, size):
            if left[0]:
                left[0] -= 1
                chip.core.stall += each
            return load(offset, size)

        chip.load = late


class FailingFlash(Fault):
    """Words that are programmed keep some of their ones. The controller tells it, or does not."""

    def begin(self, drive):
        chip, chance = drive.chip, self.chance
        flash, uc = chip.flash, chip.core.uc
        first, number, is_told = chance.randint(1, 400), chance.randint(1, 5), chance.random() < 0.5
        self.text = f"{number} words from the {first}th on, {'told' if is_told else 'silently'}"
        pending = []

        def fails(memory, _access, address, size, value, _):
            count = flash.programmed
            if first <= count < first + number:
                pending.append((address, size, value | chance.getrandbits(8 * size)))
                if is_told:
                    # PGPERR.
                    flash["SR"] |= 1 << 6

        def read_status():
            # The store is over by now.
            while pending:
                address, size, value = pending.pop()
                uc.mem_write(address, (value & (1 << 8 * size) - 1).to_bytes(size, "little"))
            return flash["SR"]

        uc.hook_add(UC_HOOK_MEM_WRITE, fails, None, 0x0800_0000, 0x080F_FFFF)
        flash.readers[0x0C] = read_status


class DeafConverter(Fault):
    """The ADC does not end its conversion."""

    def begin(self, drive):
        drive.chip.adc.next_event = lambda: NEVER


class FailingStream(Fault):
    """The DMA has an error on the bus and switches its stream off."""

    def begin(self, drive):
        drive.chip.dma2.fail()


class DeadCrystal(Fault):
    def begin(self, drive):
        drive.chip.rcc.fail_crystal()


class StuckLine(Fault):
    """A line of an input, of a capture channel or of the driver sticks, or rattles and then sticks."""

    def begin(self, drive):
        chance = self.chance
        self.pin = pin = chance.choice((*LIMITS, "PA6", "PA7", "PB11", "PC0", "PA3", "PB12"))
        level, edges = chance.randint(0, 1), chance.choice((0, 0, 3, 200))
        self.text = f"{pin} is {level} behind {edges} edges"
        for i in range(edges):
            drive.chip.pins.drive(pin, i & 1)
            drive.chip.run(chance.randint(1, 20) * US)
        drive.chip.pins.drive(pin, level)


class NoisyBus(Fault):
    """Errors on the bus, up to bus-off."""

    def begin(self, drive):
        can = drive.chip.can
        errors = self.chance.choice((10, 100, 130, 260))
        self.text = f"{errors} transmit errors"
        for _ in range(errors):
            can.count_errors(1, 0, 3)


#: Codes of emergency messages (`firmware/cia402/src/faults.rs`) that say what has happened.
SUPPLY, DRIVER, PULSES, LATE, BREAK, BUS_OFF, PASSIVE = 0x3220, 0x5400, 0x5200, 0x6100, 0x9000, 0x8140, 0x8120

#: What each fault may lead to, and by which codes it may be told.
ALLOWED = {
    # Ten milliseconds in all at most: longer than pulses are committed ahead, and a timer that is
    # looked at so late may seem to stand.
    LateAccess: ({WORKS_ON, FAULT}, {LATE, PULSES}),
    FailingFlash: ({WORKS_ON}, set()),
    DeafConverter: ({WORKS_ON}, set()),
    FailingStream: ({FAULT}, {PULSES}),
    DeadCrystal: ({END}, set()),
    StuckLine: ({WORKS_ON, FAULT}, {SUPPLY, DRIVER, BREAK, PULSES}),
    NoisyBus: ({WORKS_ON, FAULT}, {BUS_OFF, PASSIVE}),
}

#: Pulses a second that go on while nothing is told.
SPEED = {"turning": 20_000, "moving": RATE, "standing": 0}

#: Where a fault makes sense, if not wherever the motor has current.
SITUATIONS = {FailingFlash: ("storing",), FailingStream: ("turning", "moving")}


class Run:
    """One run, in a process of its own."""

    def __init__(self, name, drive, kind, seed):
        self.name, self.drive = name, drive
        self.chance = random.Random(f"{kind.__name__} {seed}")
        self.fault = kind(self.chance)

    def carry_out(self):
        drive, chip = self.drive, self.drive.chip
        # The master waits by the clock of this one.
        drive.bench.clock.drive = drive.bench
        chip.run(self.chance.randint(0, 3 * MS))
        began = chip.time
        self.had_power = drive.has_power()
        self.fault.begin(drive)
        chip.run(MS)
        was_safe = drive.is_safe()
        chip.run(60 * MS)
        drive.settle()
        if chip.can["ESR"] & BOFF:
            # Until it is on the bus again it tells nothing.
            chip.run(150 * MS)
            drive.settle()
        try:
            return (*self.judge(began, was_safe), self.fault.text)
        except AssertionError as error:
            raise AssertionError(f"{self.fault.text}: {error}") from None

    def judge(self, began, was_safe):
        drive, chip = self.drive, self.drive.chip
        judge_pulses(chip, drive.bench.pulse_times)
        last = None
        for run in chip.tim1.log:
            assert run.repeat == 1 or run.period >= FASTEST, f"wild: {run}"
            assert last is None or run.begin - last >= FASTEST, f"wild: {run} behind {last}"
            last = run.begin + run.period * (run.repeat - 1)
        cut = [time for time, level in chip.pins.changes("PA2", began) if level == 1]
        if cut and chip.tim1.last_pulse is not None:
            assert chip.tim1.last_pulse <= cut[0], "a pulse without current"
        codes = [int.from_bytes(f.data[:2], "little") for f in drive.bench.frames if f.time > began and f.id == 0x80 + NODE_ID]
        codes = [code for code in codes if code]
        before, ticks = drive.settle(), chip.core.counts[15]
        chip.run(5 * MS)
        moved = drive.settle() - before
        assert not chip.resets
        if chip.core.counts[15] == ticks:
            # The loop from which only the watchdog leads.
            assert was_safe, "the end is not safe within a millisecond"
            return END, codes
        # 6064h is what the last control tick has seen, a millisecond ago at most.
        actual, now = drive[0x6064], drive.settle()
        least, most = sorted((before, now))
        assert least - 1 <= actual <= most + 1, f"6064h is {actual}, the pulses {least} to {most}"
        if not drive.has_power() and self.had_power:
            assert codes, "the current is off without a word"
            assert was_safe or not isinstance(self.fault, (FailingStream, StuckLine)), "the fault is not safe within a millisecond"
            assert drive.is_safe() and not moved
            return FAULT, codes
        assert drive.has_power() == self.had_power
        if drive[0x6041] & INTERNAL_LIMIT:
            # A limit switch is how it is told.
            assert self.fault.pin in LIMITS, f"a limit, by {self.fault.text}"
        if drive[0x6041] & INTERNAL_LIMIT and self.fault.pin == LIMITS[1]:
            assert not moved, f"{moved} pulses into a limit switch"
        elif not codes and self.name in SPEED:
            # Away from a limit switch the way is free.
            assert abs(moved - SPEED[self.name] // 200) <= 3, f"{moved} pulses in 5 ms, and not a word"
        return WORKS_ON, codes


def in_a_copy(work):
    """What `work` gives in a copy of this process: a pipe's end and the process."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid:
        os.close(writer)
        return reader, pid
    try:
        os.close(reader)
        try:
            result = True, work()
        except BaseException as error:  # noqa: BLE001: it is told by the parent
            result = False, f"{type(error).__name__}: {error}"
        with os.fdopen(writer, "wb") as pipe:
            pickle.dump(result, pipe)
    finally:
        os._exit(0)


def collect(reader, pid):
    with os.fdopen(reader, "rb") as pipe:
        data = pipe.read()
    os.waitpid(pid, 0)
    return pickle.loads(data) if data else (False, "the process has died")


def carry_out(situations, kinds, seeds, processes=2):
    """Each seed in one of the situations, each kind of fault in turn. Gives what became of each: kind, seed, situation, text, reaction, codes;
    the reaction of a run that was not as it should be is None, and its codes are what was wrong."""
    waiting, results = collections.deque(), []

    def settle(kind, seed, name, text, copy):
        ok, what = collect(*copy)
        reaction, codes, text = what if ok else (None, what, text)
        if ok:
            allowed, told = ALLOWED[kind]
            if reaction not in allowed or not set(codes) <= told:
                reaction, codes = None, f"{reaction}, {[hex(code) for code in codes]}: not what this fault may lead to"
        if reaction is None:
            print(kind.__name__, seed, name, text, codes, sep="\t", flush=True)
        results.append((kind.__name__, seed, name, text, reaction, codes))

    for seed in seeds:
        kind = kinds[seed % len(kinds)]
        names = SITUATIONS.get(kind, ("turning", "moving", "standing"))
        name = names[seed // len(kinds) % len(names)]
        run = Run(name, situations[name], kind, seed)
        waiting.append((kind, seed, name, "", in_a_copy(run.carry_out)))
        if len(waiting) >= processes:
            settle(*waiting.popleft())
    while waiting:
        settle(*waiting.popleft())
    return results


KINDS = list(ALLOWED)


class Drives:
    """Drives of one image, one after the other on the same clock of the master."""

    def __init__(self, image):
        self.image, self.time = image, VirtualTime(pytest.MonkeyPatch())
        self.parameters = None

    def new(self):
        self.time.drive = bench = Bench(Chip(self.image, flash=self.parameters))
        bench.clock = self.time
        bench.connect()
        bench.milliseconds(150)
        if self.parameters is None:
            bench.give_node_id(NODE_ID, store=True)
            bench.chip.cycle_power()
            self.parameters = bench.chip.parameters
            return self.new()
        return Drive(bench, bench.add(NODE_ID, EDS))


def situations(new_drive):
    """Where a run begins, by name. `new_drive` gives a drive that is on, as the fixture does."""

    def turning():
        return new_drive().turn(20_000)

    def moving():
        drive = new_drive()
        drive[0x6081], drive[0x6083], drive[0x6084] = RATE, 1_000_000, 1_000_000
        drive.enable(PROFILE_POSITION)
        drive[0x607A] = 1_000_000
        drive[0x6040] = ENABLE | 0x30
        drive.bench.milliseconds(20)
        return drive

    def standing():
        return new_drive().enable(PROFILE_POSITION)

    def storing():
        drive = new_drive()
        drive[0x6081] = 4_321
        drive.bench.network.send_message(0x600 + NODE_ID, SAVE)
        return drive

    return {make.__name__: make() for make in (turning, moving, standing, storing)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--image", required=True)
    parser.add_argument("--runs", type=int, default=1_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    drives = Drives(Image(arguments.image))
    results = carry_out(situations(drives.new), KINDS, range(arguments.seed, arguments.seed + arguments.runs))
    became = collections.Counter((kind, reaction or "WRONG") for kind, _, _, _, reaction, _ in results)
    for (kind, reaction), number in sorted(became.items()):
        print(f"{kind}\t{reaction}\t{number}")
    wrong = sum(reaction is None for _, _, _, _, reaction, _ in results)
    print(f"{len(results)} runs, {wrong} wrong")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
