"""What the current interrupt of the servo boards takes of the processor, on the model of the chip with its model of cost: `cargo xtask bench` runs it
and compares.

    python tests/machine/measure_servo.py --odrive36 target/xtask/axis402-odrive36.elf --stepper405 target/xtask/axis402-stepper405.elf

It prints a table as `measure.py` does: of each row the share of the time in hundredths of a percent, the clocks of a period in the mean and at most,
and of one with nothing beside the current."""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "python")]

import pytest  # noqa: E402
import test_servo  # noqa: E402
import test_stepper  # noqa: E402
from conftest import Starts  # noqa: E402
from servo_bench import PERIOD, Kind, commanded, current_interrupts, hold, on_the_way  # noqa: E402
from stm32f405.image import Image  # noqa: E402

PERIODS = 500


def figures(kind, more, speed, way):
    """By what the drive does meanwhile, the clocks in each period."""
    found = kind.found(kind.booted())
    with pytest.MonkeyPatch.context() as patch:
        starts = Starts(kind.image, patch)
        servo = commanded(starts.like(found))
        hold(servo, 500)
        yield "half of the rated torque held", current_interrupts(servo.chip, PERIODS, more)
        servo = commanded(starts.like(found))
        on_the_way(servo, speed, way)
        yield "in a move", current_interrupts(servo.chip, PERIODS, more)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--odrive36", required=True)
    parser.add_argument("--stepper405", required=True)
    images = parser.parse_args()
    boards = {
        "odrive36": figures(Kind(Image(images.odrive36), test_servo.begin, test_servo.RATINGS), 0, 100_000, 100_000),
        # Its converters end at the bottom too, for nothing.
        "stepper405": figures(Kind(Image(images.stepper405), test_stepper.begin, test_stepper.RATINGS), 1, 20_000, 40_960),
    }
    print("# The current interrupt")
    for board, rows in boards.items():
        for what, clocks in rows:
            mean = sum(clocks) / len(clocks)
            print(board + ", " + what, round(10_000 * mean / PERIOD), round(mean), max(clocks), min(clocks), sep="\t")


if __name__ == "__main__":
    main()
