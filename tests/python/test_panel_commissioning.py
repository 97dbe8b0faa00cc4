"""An engineer commissions a drive with the panel alone: a number, a bit rate, homing, a move, PDOs, all of it stored, and a file of it.

What was stored is there after a power cycle, and is what the file says.
"""

import pytest
from playwright.sync_api import expect

from panel_window import PAGES, browser, enable, open_page, panel  # noqa: F401

pytestmark = pytest.mark.only("virtual")


def said(window, text):
    expect(window.locator(".toast.good").last).to_contain_text(text)


def test_a_drive_is_commissioned_with_the_panel_alone(start, panel, tmp_path):  # noqa: F811
    store = tmp_path / "drive"
    store.mkdir()
    bus = start(store=store)
    window = (one := panel("--slcan", f"127.0.0.1:{bus.port}")).open()

    # From a drive without a node-ID at 1 Mbit/s to node 6 at 500 kbit/s.
    window.fill("#first", "6")
    window.click("#number")
    said(window, "has a node-ID now")
    window.select_option("#rate", "500")
    window.click("#switch-rate")
    expect(window.locator("#page")).to_contain_text("at 500 kbit/s")
    window.click("text=Open drive")
    expect(window.locator("#state")).to_have_text("Switch on disabled")

    # Home where it stands, with speeds of its own, and a move.
    window.select_option("#homing-method", "37")
    window.fill("#homing-fast", "1500")
    window.click("#set-homing")
    said(window, "Homing is set up")
    enable(window)
    window.click("#home")
    expect(window.locator("#page")).to_contain_text("homing attained")
    window.fill("#target", "2500")
    window.fill("#velocity", "8000")
    window.click("#move-to")
    expect(window.locator("#position")).to_have_text("2\u202f500")
    window.click("#disable")
    expect(window.locator("#state")).to_have_text("Ready to switch on")

    # Position and velocity each 10 ms in the fourth transmit PDO.
    open_page(window, "pdos", "PDOs")
    fourth = window.locator("tr[data-pdo='TPDO 4']")
    expect(fourth).to_be_visible()
    while fourth.locator(".take").count():
        fourth.locator(".take").first.click()
    for entry in ("6064h:00", "606Ch:00"):
        fourth.locator("select.add").select_option(entry)
    fourth.locator("input[type=checkbox]").check()
    fourth.get_by_label("Transmission type").fill("255")
    fourth.get_by_label("Event timer").fill("10")
    window.click("#apply")
    said(window, "1 PDO is set up")

    # Stored, and kept as a file.
    open_page(window, "objects", "Objects")
    window.click("#store")
    said(window, "node 6 has saved its parameters")
    with window.expect_download() as download:
        window.click("#dump")
    file = tmp_path / download.value.suggested_filename
    download.value.save_as(file)
    text = file.read_text()
    for line in ("NodeID=6", "Baudrate=500"):
        assert line in text, text[:2_000]

    # Power off, power on; without its bus the panel would end with exit code 2.
    one.close()
    assert one.server.stop() == 0
    assert bus.server.stop() == 0
    bus = start(store=store)
    window = panel("--slcan", f"127.0.0.1:{bus.port}", "--bitrate", "500").open()
    expect(window.locator(".node-number")).to_have_text(["6"])
    window.click(".node >> text=Objects")
    with window.expect_file_chooser() as chooser:
        window.click("#compare")
    chooser.value.set_files(file)
    expect(window.locator("#differ")).to_have_text("Node 6 is as node-6.dcf says.")
