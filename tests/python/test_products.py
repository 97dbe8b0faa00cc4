"""The scripts in the manner of each maker's manual (`examples/NAME.py`), on the product that they are for."""

import subprocess
import sys

import pytest

from conftest import ROOT
from server import Slcan, free_port

#: What each says last but one, and last.
LAST = {
    "lmd": ["runs at 51200 microsteps/s", "off"],
    "nanotec": ["0 from where it began", "off"],
    "s200": ["homed, at 0", "off"],
    "tc1": ["at 0, status register 01060637h", "stored"],
}


@pytest.mark.only("virtual", "firmware")
@pytest.mark.timeout(1_500)
@pytest.mark.parametrize("product", LAST)
def test_a_product_is_put_into_service_as_its_manual_does(programs, kind, product, monkeypatch):
    if kind == "firmware" and programs.image:
        pytest.skip("the image that is given is the generic drive")
    # The image is built first.
    monkeypatch.setattr("server.START_TIME", 900)
    port = free_port()
    slcan = ["--product", product, "--slcan", f"127.0.0.1:{port}"]
    command = [programs.xtask, "qemu", *slcan] if kind == "firmware" else [programs.sim, "serve", *slcan]
    bus = Slcan(command, port)
    try:
        bus.server.wait_until_ready()
        script = [sys.executable, ROOT / "examples" / f"{product}.py", "--interface", "slcan"]
        script += ["--channel", f"socket://127.0.0.1:{port}"]
        run = subprocess.run(script, capture_output=True, text=True, timeout=170, cwd=ROOT)
        assert run.returncode == 0, (run.stdout, run.stderr)
        assert run.stdout.splitlines()[-2:] == LAST[product], run.stdout
    finally:
        bus.server.stop()
