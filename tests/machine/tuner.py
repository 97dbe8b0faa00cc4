"""`axis402 tune` at the line of a serial CAN adapter, in the time of the chip (`master/examples/stepped_tune.rs`)."""

import json
import subprocess

from adapter import Adapter
from stm32f405 import US


def tune(bench, program, node_id, *options):
    """What it has found, or the words in which it says why not. Meanwhile the adapter is the master of the bench."""
    adapter = Adapter(bench.chip)
    adapter.command("O")
    chip, line = adapter.chip, adapter.serial
    process = subprocess.Popen([str(program), str(node_id), *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    begin, said = chip.time, None
    for text in process.stdout:
        text = text.strip()
        if text[0] in "=!":
            said = text
        elif text[0] != "@":
            assert adapter.command(text) == b"\r", text
        else:
            chip.run(begin + int(text[1:]) * US - chip.time, lambda: line.in_waiting)
            for frame in line.read(line.in_waiting).decode().split():
                print(frame, file=process.stdin)
            print(f"@{(chip.time - begin) // US}", file=process.stdin, flush=True)
    chip.can.on_frame = bench.on_frame
    process.stdin.close()
    process.stdout.close()
    assert process.wait(30) == 0
    return json.loads(said[2:]) if said[0] == "=" else said[2:]


def is_within_bounds(found, motor, rated):
    """What was found of a motor, with a rated torque in N·m, by the bounds of docs/servo.md."""
    for name, known, bound in [
        ("resistance", motor.resistance, 0.04), ("inductance_along", motor.inductance, 0.1), ("inductance_across", motor.inductance, 0.1),
        ("flux", motor.flux, 0.04), ("inertia", motor.inertia, 0.2), ("friction", motor.friction, 0.15 + 0.03 * rated / motor.friction),
    ]:  # fmt: skip
        assert abs(found[name] / known - 1) < bound, (name, found[name])
    assert (found["pole_pairs"], found["direction"]) == (motor.pole_pairs, 1)
