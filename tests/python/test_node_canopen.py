"""node-canopen (npm) and an unconfigured virtual drive: LSS, transfers of every length and kind, NMT."""

import os
import pathlib
import subprocess

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[1] / "node" / "drive.js"


@pytest.mark.only("virtual")
def test_node_canopen_takes_the_drive_into_service(start, pytestconfig):
    modules = pytestconfig.getoption("--node-modules")
    assert modules is not None, "`cargo xtask test` installs the packages and names their folder"
    bus = start()
    run = subprocess.run(
        ["node", str(SCRIPT), str(bus.port)],
        env={**os.environ, "NODE_PATH": str(modules)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert (run.returncode, run.stdout) == (0, "done\n"), run.stderr
