"""The panel in a real browser, in front of the firmware in the emulator."""

import pytest
from playwright.sync_api import expect

from panel_window import browser, enable, give_node_id, panel  # noqa: F401

pytestmark = pytest.mark.only("firmware")


def test_the_mouse_moves_the_firmware(start, panel):  # noqa: F811
    window = panel("--slcan", f"127.0.0.1:{start().port}").open()
    give_node_id(window)
    enable(window)
    window.fill("#target", "5000")
    window.click("#move-to")
    expect(window.locator("#position")).to_have_text("5\u202f000")
    expect(window.locator("#statusword")).to_contain_text("target reached")
