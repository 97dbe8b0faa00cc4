"""What the image takes of the processor, on the model of the chip with its model of cost: `cargo xtask bench` runs it and compares.

    python tests/machine/measure.py --image target/xtask/axis402-stm32f405.elf

It prints a table: `# heading`, then a row per line, a name and its figure with a tab between them."""

import argparse
import pathlib
import sys
import types

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "python")]

import pytest  # noqa: E402
from conftest import EDS, NODE_ID  # noqa: E402
from drive import Drive  # noqa: E402
from judge import judge_pulses  # noqa: E402
from master import Bench  # noqa: E402
from stepped import VirtualTime  # noqa: E402
from stm32f405 import MS, Chip  # noqa: E402
from stm32f405.bxcan import Frame  # noqa: E402
from stm32f405.cost import ENTRY  # noqa: E402
from stm32f405.image import Image  # noqa: E402
from stm32f405.interrupts import IRQ  # noqa: E402

#: Nanoseconds of pulses and directions with which a million pulses a second are possible.
TIMES = (400, 400, 5_000, 5_000)

MEASURED = 100 * MS

#: Interrupts from the most urgent one on, with their priorities and exceptions. The first of these waits for the others.
LATENCIES = [
    ("frame", 5, [16 + IRQ["CAN1_RX0"], 16 + IRQ["CAN1_TX"]]), ("refill", 4, [16 + IRQ["TIM3"]]), ("control tick", 3, [15]),
]  # fmt: skip

#: What runs at each priority of the application, as `firmware/app/src/app.rs` has it.
TASKS = {6: "inputs, break", 5: "CAN", 4: "refill", 3: "control tick", 2: "node", 1: "lights"}


def level(priority):
    """What NVIC has for a priority of the application."""
    return 256 - 16 * priority


def loaded(image):
    """A drive that makes a million pulses a second on a bus full of the shortest frames, with the cost of its instructions."""
    patch = pytest.MonkeyPatch()
    time = VirtualTime(patch)
    time.drive = bench = Bench(Chip(image))
    bench.connect()
    bench.milliseconds(150)
    bench.give_node_id(NODE_ID)
    drive = Drive(bench, bench.add(NODE_ID, EDS))
    for sub, value in enumerate((255, *TIMES), start=1):
        drive.sdo[0x20B0][sub].raw = value
    bench.pulse_times = TIMES
    drive.turn(1_000_000, acceleration=20_000_000)
    # Process data of the drive: a command and an answer in each millisecond.
    drive.sdo[0x1402][2].raw = drive.sdo[0x1803][2].raw = 1
    bench.network.nmt.send_command(1)
    bench.milliseconds(5)
    bench.chip.core.count_cost()
    return types.SimpleNamespace(bench=bench, drive=drive, chip=bench.chip, core=bench.chip.core)


def run(rig):
    """The load, and what is measured under it."""
    chip, core = rig.chip, rig.core
    word, target = 0x0F, 0
    begin = chip.time
    for cycle in range(MEASURED // MS):
        if cycle == 10:
            core.shares.clocks.clear()
            core.cost.forget()
        if cycle % 2 == 0:
            chip.can.to_send.append(Frame(0x80, False, False, b""))
            chip.can.to_send.append(Frame(0x400 + NODE_ID, False, False, word.to_bytes(2, "little") + target.to_bytes(4, "little")))
        # 22 frames a millisecond; what there is of its own takes turns with them.
        while len(chip.can.to_send) < 24:
            chip.can.to_send.append(Frame(0x7FE, False, False, b""))
        chip.run(begin + (cycle + 1) * MS - chip.time)
    assert chip.can.stats["overruns"] == 0
    judge_pulses(chip, TIMES)


def rows(rig):
    """Name and figure of each."""
    core, cost = rig.core, rig.core.cost
    # The longest wait that is seen is chance, as few frames meet the longest of what they may have to wait for: that is added up.
    waits = ENTRY
    for name, priority, exceptions in LATENCIES:
        yield f"latency of a {name} at most, clocks", waits + cost.longest[level(priority)] + sum(cost.runs[n] for n in exceptions[1:])
        waits += sum(cost.runs[n] for n in exceptions)
    yield "longest time with every interrupt masked, clocks", cost.longest["all"]
    for priority in (5, 4, 3):
        yield f"longest time with priority {priority} masked by who is less urgent, clocks", cost.longest[level(priority)]
    for priority, what in TASKS.items():
        if cost.depth[level(priority)]:
            yield f"stack of priority {priority} ({what}), bytes", cost.depth[level(priority)]
    yield "deepest stack since power-on, the start included, bytes", rig.chip.image.symbols["_stack_start"] - core.lowest_stack
    for priority, what in TASKS.items():
        yield f"share of priority {priority} ({what}), hundredths of a percent", round(10_000 * core.shares.of(level(priority)))
    yield "share of all, hundredths of a percent", round(10_000 * (1 - core.shares.of(None)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--image", required=True)
    rig = loaded(Image(parser.parse_args().image))
    run(rig)
    print("# The board on its model")
    for name, figure in rows(rig):
        print(f"{name}\t{figure}")


if __name__ == "__main__":
    main()
