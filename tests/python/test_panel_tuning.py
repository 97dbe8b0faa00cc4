"""The page Tuning of the panel in a real browser, in front of a virtual drive with a servo: measured, written when a person says so, stopped.

What is found is judged on virtual time, in the tests of the crates `panel`, `master` and `servo`; here it is seen what a person sees.
"""

import pathlib
import re

import pytest
from playwright.sync_api import TimeoutError, expect

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


#: A busy PC may let a measurement end before somebody has stopped it.
ATTEMPTS = 8

#: What the page has told in toasts, which go away by themselves.
TOLD = """
window.told = [];
new MutationObserver((records) => records.forEach((record) => record.addedNodes.forEach((node) => {
  if (node.classList?.contains('toast')) window.told.push(node.textContent);
}))).observe(document, { childList: true, subtree: true });
"""

def stop_a_measurement(window, stop):
    """A measurement begins, and is stopped while it goes on."""
    for _ in range(ATTEMPTS):
        window.evaluate("window.told.length = 0")
        window.click("#tune-motor")
        stop()
        window.wait_for_function("() => window.told.some((text) => text !== 'Stop was sent')")
        if window.evaluate("window.told.some((text) => text.includes('stop'))"):
            return expect(window.locator("#tuning-at")).to_be_hidden()
    raise AssertionError("it cannot be stopped")


def test_a_measurement_is_stopped_by_the_space_bar_and_by_a_window_that_watches(servo):
    one, window = servo(before=TOLD)
    watcher = one.open("#tuning")

    def stop_by_hand():
        window.keyboard.press("Space")

    def stop_by_the_other():
        expect(watcher.locator("#tuning-at, #tuning-said:text('written')").first).to_be_visible()
        watcher.click("#stop")

    stop_a_measurement(window, stop_by_hand)
    stop_a_measurement(window, stop_by_the_other)
    # A motor that has power already is not measured: somebody may be moving it.
    open_page(window, "drive", "Axis402 servo drive · node 4")
    expect(window.locator("#state")).to_have_text(re.compile("Ready to switch on|Switch on disabled"))
    enable(window)
    open_page(window, "tuning", "Tuning")
    expect(window.locator("#tuning-power")).to_be_visible()
    expect(window.locator("#tune-motor")).to_be_disabled()


#: Buttons of the page of the drive that could be pressed while the motor was measured and had power; nothing before that.
PRESSABLE = """() => {
  const is = (id, text) => document.getElementById(id).textContent.includes(text);
  if (!is('banner', 'The motor is being measured') || !is('state', 'Operation enabled')) return null;
  return { ids: [...document.querySelectorAll('[data-writes], [data-powered]')].filter((one) => !one.disabled).map((one) => one.id) };
}"""


def test_nothing_else_is_ordered_while_the_motor_is_measured(servo):
    _, window = servo()
    open_page(window, "drive", "Axis402 servo drive · node 4")
    for _ in range(ATTEMPTS):
        window.evaluate("import('/connection.js').then((panel) => { panel.order('tune', { motor: true }).catch(() => {}); })")
        try:
            seen = window.wait_for_function(PRESSABLE, timeout=10_000)
        except TimeoutError:
            expect(window.locator("#banner")).to_be_hidden()
            continue
        assert seen.json_value() == {"ids": []}
        window.click("#stop")
        expect(window.locator("#banner")).to_be_hidden()
        return expect(window.locator("#enable")).to_be_enabled()
    raise AssertionError("it is not seen")


def test_a_panel_that_only_reads_shows_what_is_set_and_measures_nothing(servo):
    _, window = servo("--read-only")
    for button in ("#tune-motor", "#tune-response", "#tune-step"):
        expect(window.locator(button)).to_be_disabled()
    expect(window.locator("#tuning-rows tr", has_text="Resistance").locator("td").nth(1)).to_have_text("as built")
