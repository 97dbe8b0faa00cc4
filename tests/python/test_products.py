"""The scripts in the manner of each maker's manual (`examples/NAME.py`), on the product that they are for."""

import pathlib
import subprocess
import sys

import pytest

from conftest import ROOT
from server import Slcan, free_port

#: What each says at its end.
LAST = {
    "lmd": [f"at {turns * 51_200} microsteps" for turns in (1, -1, 0)] + ["runs at 1.0 turns/s", "off"],
    "nanotec": ["2000 from where it began", "0 from where it began", "off"],
    "s200": ["homed, at 0", "off"],
    "tc1": [f"at {target}, status register 01060637h" for target in (10_000, 0)] + ["stored"],
}


@pytest.mark.only("virtual", "firmware")
@pytest.mark.timeout(1_500)
@pytest.mark.parametrize("product", LAST)
def test_a_product_is_put_into_service_as_its_manual_does(programs, kind, product, monkeypatch):
    # Without an image one is built first.
    monkeypatch.setattr("server.START_TIME", 900)
    port = free_port()
    command = [programs.xtask, "qemu"] if kind == "firmware" else [programs.sim, "serve"]
    if kind == "firmware" and programs.image:
        # Beside the image of the generic drive lie those of the products.
        command += ["--image", pathlib.Path(programs.image).with_suffix(f".{product}.elf")]
    else:
        command += ["--product", product]
    command += ["--slcan", f"127.0.0.1:{port}"]
    bus = Slcan(command, port)
    try:
        bus.server.wait_until_ready()
        script = [sys.executable, ROOT / "examples" / f"{product}.py", "--interface", "slcan"]
        script += ["--channel", f"socket://127.0.0.1:{port}"]
        run = subprocess.run(script, capture_output=True, text=True, timeout=170, cwd=ROOT)
        assert run.returncode == 0, (run.stdout, run.stderr)
        assert run.stdout.splitlines()[-len(LAST[product]) :] == LAST[product], run.stdout
    finally:
        bus.server.stop()
