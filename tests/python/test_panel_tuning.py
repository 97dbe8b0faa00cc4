"""The page Tuning of the panel in a real browser, in front of a virtual drive with a servo: measured, written when a person says so, stopped.

What is found is judged on virtual time, in the tests of the crates `panel`, `master` and `servo`; here it is seen what a person sees.
"""

import pathlib

import pytest
from playwright.sync_api import expect

from conftest import ROOT
from panel_window import FAINT, browser, difference, enable, open_page, panel  # noqa: F401

pytestmark = pytest.mark.only("virtual")

#: A picture in docs may be so far from the one of this run.
LIKENESS = 0.02


@pytest.fixture
def servo(start, panel):  # noqa: F811
    """A panel in front of a servo, and its window at the page."""
    bus = start(arguments=["--node-id", "4", "--axis", "servo_100w"])

    def open_panel(*arguments, **options):
        one = panel("--slcan", f"127.0.0.1:{bus.port}", *arguments)
        window = one.open(**options)
        window.click("text=Open drive")
        expect(window.locator("#state")).to_have_text("Switch on disabled")
        open_page(window, "tuning", "Tuning")
        expect(window.locator("#tuning-rows tr")).to_have_count(9)
        return one, window

    return open_panel


def test_a_servo_is_measured_written_and_drawn_as_the_picture_in_docs(servo, browser, pytestconfig):  # noqa: F811
    folder = pytestconfig.getoption("--pictures")
    one, window = servo(color_scheme="light", viewport={"width": 1280, "height": 1420})
    said, gain = window.locator("#tuning-said"), window.locator("#tuning-rows tr", has_text="Gain of the velocity")
    expect(said).to_have_text("Nothing was measured yet.")
    expect(window.locator("#tuning-write")).to_be_hidden()
    window.fill("#tuning-bandwidth", "500")
    # With the keyboard.
    window.focus("#tune-motor")
    window.keyboard.press("Enter")
    expect(window.locator("#tuning-at")).to_be_visible()
    expect(window.locator("#tune-step")).to_be_disabled()
    expect(said).to_have_text("Nothing of it is written yet.")
    expect(window.locator("#tuning-encoder")).to_contain_text("4 pole pairs, counts as the motor turns")
    expect(gain.locator("td")).to_have_text(["500", "as built", "60F9h:01"])
    window.click("#tuning-write")
    expect(said).to_have_text("The drive goes by what was measured.")
    expect(gain.locator("td").nth(1)).to_have_text("500")
    expect(window.locator("#tuning-write")).to_be_hidden()
    window.click("#tune-response")
    expect(window.locator("#tuning-response .curve")).to_have_count(2)
    window.click("#tune-step")
    expect(window.locator("#tuning-step .curve")).to_have_count(1)
    expect(window.locator("#tuning-at")).to_be_hidden()
    window.evaluate("document.getElementById('toasts').replaceChildren()")
    window.evaluate("document.activeElement.blur()")
    picture = window.screenshot()
    # Another window has it too, narrow and dark.
    for scheme, width in [("light", 1280), ("dark", 1280), ("dark", 360)]:
        other = one.open("#tuning", color_scheme=scheme, viewport={"width": width, "height": 860})
        expect(other.locator("#tuning-response .curve")).to_have_count(2)
        expect(other.locator("#tune-motor")).to_be_disabled()
        assert other.evaluate("document.documentElement.scrollWidth") <= width
        assert other.evaluate(FAINT) == [], (scheme, width)
        other.context.close()
    if folder:
        pathlib.Path(folder, "panel-tuning.png").write_bytes(picture)
    assert difference(browser, (ROOT / "docs" / "panel-tuning.png").read_bytes(), picture) <= LIKENESS


def test_a_measurement_is_stopped_by_the_space_bar_and_by_a_window_that_watches(servo):
    one, window = servo()
    for stopper in (window, one.open("#tuning")):
        window.click("#tune-motor")
        expect(stopper.locator("#tuning-at")).to_be_visible()
        stopper.keyboard.press("Space")
        expect(window.locator(".toast.error").last).to_have_text("the measurement was stopped, and everything is as it was")
        expect(window.locator("#tuning-at")).to_be_hidden()
        expect(window.locator("#tuning-said")).to_have_text("Nothing was measured yet.")
        window.evaluate("document.getElementById('toasts').replaceChildren()")
    # A motor that has power already is not measured: somebody may be moving it.
    open_page(window, "drive", "Axis402 CiA 402 drive · node 4")
    expect(window.locator("#state")).to_have_text("Ready to switch on")
    enable(window)
    open_page(window, "tuning", "Tuning")
    expect(window.locator("#tuning-power")).to_be_visible()
    expect(window.locator("#tune-motor")).to_be_disabled()


def test_a_panel_that_only_reads_shows_what_is_set_and_measures_nothing(servo):
    _, window = servo("--read-only")
    for button in ("#tune-motor", "#tune-response", "#tune-step"):
        expect(window.locator(button)).to_be_disabled()
    expect(window.locator("#tuning-rows tr", has_text="Resistance").locator("td").nth(1)).to_have_text("as built")
