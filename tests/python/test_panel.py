"""The panel in a real browser, with the mouse and the keyboard, in front of a virtual drive.

`--pictures FOLDER` keeps a picture of each page: `docs/panel.png` is the one of the drive.
"""

import os
import pathlib
import re
import shutil
import subprocess
import time

import can
import pytest
from playwright.sync_api import expect, sync_playwright

from conftest import EDS, NODE_ID
from server import Server

pytestmark = pytest.mark.only("virtual")

#: The browser asks nobody outside for anything.
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"
    " --disable-component-update --disable-sync"
).split()

#: How long anything may take on a busy PC, in milliseconds.
PATIENCE = 60_000

#: A halt is on the bus so soon after the page has seen the release, in seconds. The best attempt counts: the PC may be busy with other things.
DEAD_MAN, ATTEMPTS = 0.2, 8

#: The page notes when it sees a release.
NOTE_RELEASE = "for (const end of ['pointerup', 'visibilitychange']) addEventListener(end, () => { window.releasedAt = Date.now(); }, true)"


@pytest.fixture(scope="module")
def browser():
    """Debian's chromium."""
    program = shutil.which("chromium")
    assert program, "chromium is missing: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


class Panel:
    """A panel that runs, and the windows that look at it."""

    def __init__(self, program, arguments, browser):
        self.server = Server([program, "--listen", "127.0.0.1:0", *arguments])
        self.browser = browser
        self.complaints = []
        greeting = []
        while (line := self.server.lines.get(timeout=120)) != "ready":
            assert line is not None, self.server.words()
            greeting.append(line)
        self.address = greeting[-1].removeprefix("panel on ")
        self.slcan = greeting[0].rpartition(" ")[2] if len(greeting) > 1 else None
        self.contexts = []

    def open(self, page="", **options):
        context = self.browser.new_context(**{"viewport": {"width": 1280, "height": 860}, **options})
        self.contexts.append(context)
        window = context.new_page()
        window.set_default_timeout(PATIENCE)
        expect.set_options(timeout=PATIENCE)
        window.on("console", lambda said: self.complaints.append(said.text) if said.type in ("error", "warning") else None)
        window.on("pageerror", lambda error: self.complaints.append(str(error)))
        window.on("request", lambda asked: self.complaints.append(asked.url) if not asked.url.startswith(self.address) else None)
        window.goto(self.address + page)
        return window

    def close(self):
        for context in self.contexts:
            context.close()


@pytest.fixture
def panel(pytestconfig, browser):
    """Starts panels; all of them end with the test, without a complaint of any window."""
    panels = []

    def start(*arguments):
        panels.append(Panel(pytestconfig.getoption("--panel"), arguments, browser))
        return panels[-1]

    yield start
    for one in panels:
        one.close()
        if not one.server.was_killed:
            assert one.server.stop() == 0, one.server.words()
            assert one.complaints == []


def give_node_id(window):
    """From a drive without a node-ID to its page, with the mouse."""
    window.click("#number")
    window.click("text=Open drive")
    expect(window.locator("#state")).to_have_text("Switch on disabled")


def enable(window):
    window.click("#enable")
    expect(window.locator("#state")).to_have_text("Operation enabled")
    expect(window.locator("#guard")).to_have_text("The drive watches the panel's heartbeat (1016h).")


def position(window):
    return int(re.sub(r"\s", "", window.inner_text("#position")))


def velocity(window):
    return window.locator("#velocity-now")


def test_from_a_drive_without_a_node_id_to_a_finished_move_with_the_mouse_alone(panel, pytestconfig):
    folder = pytestconfig.getoption("--pictures")
    window = (one := panel("--virtual")).open(color_scheme="light")

    def picture(window, name):
        if folder:
            window.evaluate("document.getElementById('toasts').replaceChildren()")
            window.screenshot(path=pathlib.Path(folder) / f"{name}.png")

    give_node_id(window)
    enable(window)
    window.click("#move-to")
    expect(window.locator("#position")).to_have_text("5\u202f000")
    window.click("#move-by")
    expect(window.locator("#position")).to_have_text("6\u202f000")
    expect(window.locator("#statusword")).to_contain_text("target reached")
    picture(window, "panel")

    # Every page, wide and narrow, light and dark: none is wider than the window, none complains.
    for scheme, width in [("light", 1280), ("dark", 1280), ("dark", 360)]:
        other = one.open(color_scheme=scheme, viewport={"width": width, "height": 860})
        for page, title in [("bus", "Bus"), ("drive", "Axis402 CiA 402 drive · node 4"), ("objects", "Objects"), ("log", "Log")]:
            other.click(f"nav a[href='#{page}']")
            expect(other.locator("h1")).to_have_text(title)
            if page == "objects":
                expect(other.locator(".object").first).to_be_visible()
            if page == "log":
                expect(other.locator("#frames tr").first).to_be_visible()
            assert other.evaluate("document.documentElement.scrollWidth") <= width, (page, width)
            picture(other, f"{page}-{scheme}-{width}")

    # Found by its name, written within its limits.
    window.click("nav a[href='#objects']")
    window.fill("#search", "abort connection")
    expect(window.locator("#count")).to_have_text("1 found")
    window.click("text=Change")
    window.fill(".editor input", "4")
    window.click("text=Write")
    expect(window.locator(".toast.error")).to_have_text("6007h:00 Abort connection option code: 4 is above 3")


def hold(window, button, shown, watcher=None):
    """Holds a jog button until it moves. On a PC that is too busy for the beats of the button, the jog has ended: once more."""
    for _ in range(ATTEMPTS):
        window.hover(button)
        window.mouse.down()
        try:
            return expect(velocity(watcher or window)).to_have_text(shown, timeout=5_000)
        except AssertionError:
            window.mouse.up()
    raise AssertionError("it does not move")


def halted(bus):
    """When the panel wrote the halt to the controlword."""
    while (frame := bus.recv(timeout=PATIENCE / 1000)) is not None:
        if frame.arbitration_id == 0x600 + 4 and bytes(frame.data[:6]) == bytes([0x2B, 0x40, 0x60, 0x00, 0x0F, 0x01]):
            return time.time()
    raise AssertionError("no halt")


def test_a_jog_ends_when_the_button_is_released_the_page_hidden_or_the_window_closed(panel):
    window = (one := panel("--virtual")).open()
    give_node_id(window)
    enable(window)
    window.evaluate(NOTE_RELEASE)
    # However long it takes, no limit switch is reached.
    window.fill("#jog", "100")
    bus = can.Bus(interface="slcan", channel=f"socket://{one.slcan}", bitrate=1_000_000, sleep_after_open=0.05)
    hide = "Object.defineProperty(document, 'hidden', {value: true, configurable: true}); document.dispatchEvent(new Event('visibilitychange')); delete document.hidden"
    try:
        for end in (lambda: window.mouse.up(), lambda: window.evaluate(hide)):
            took = []
            while not took or min(took) > DEAD_MAN and len(took) < ATTEMPTS:
                hold(window, "#jog-positive", "100")
                while bus.recv(timeout=0) is not None:
                    pass
                end()
                at = halted(bus)
                took.append(at - window.evaluate("window.releasedAt") / 1000)
                window.mouse.up()
                expect(velocity(window)).to_have_text("0")
            assert min(took) <= DEAD_MAN, took
        watcher = one.open("#drive")
        hold(window, "#jog-negative", "-100", watcher)
        while bus.recv(timeout=0) is not None:
            pass
        window.close()
        halted(bus)
        expect(velocity(watcher)).to_have_text("0")
    finally:
        bus.shutdown()


def test_one_window_writes_the_other_watches_and_may_stop(panel):
    first = (one := panel("--virtual")).open()
    give_node_id(first)
    enable(first)
    second = one.open("#drive")
    expect(second.locator("#banner")).to_contain_text("Another window has control")
    expect(second.locator("#move-to")).to_be_disabled()
    first.fill("#target", "20000")
    first.fill("#velocity", "200")
    first.click("#move-to")
    expect(velocity(second)).not_to_have_text("0")
    # The space bar, though a button has the focus.
    second.focus("nav a[href='#drive']")
    second.keyboard.press("Space")
    expect(first.locator("#state")).to_have_text("Switch on disabled")
    expect(velocity(first)).to_have_text("0")
    second.click("text=Take control")
    expect(second.locator("#enable")).to_be_enabled()
    expect(first.locator("#enable")).to_be_disabled()
    enable(second)


def test_a_panel_that_only_reads_moves_nothing(network, panel):
    """The drive has a node-ID from another master, and this panel sends nothing that changes it."""
    from conftest import give_node_id as number

    number(network)
    window = panel("--slcan", network.bus.serialPortOrig.port.removeprefix("socket://"), "--read-only").open()
    window.click("text=Open drive")
    expect(window.locator("#banner")).to_contain_text("Read-only")
    expect(window.locator("#state")).to_have_text("Switch on disabled")
    for button in ("#enable", "#move-to", "#jog-positive"):
        expect(window.locator(button)).to_be_disabled()


def test_a_panel_that_is_killed_in_motion_leaves_a_drive_that_stands(start, connect, panel):
    bus = start(arguments=["--node-id", str(NODE_ID)])
    network = connect(bus)
    drive = network.add_node(NODE_ID, str(EDS))
    one = panel("--slcan", f"127.0.0.1:{bus.port}")
    window = one.open()
    window.click("text=Open drive")
    enable(window)
    window.fill("#target", "1000000")
    window.fill("#velocity", "5000")
    window.click("#move-to")
    expect(velocity(window)).to_have_text("5\u202f000")
    one.server.kill()
    # It misses the heartbeat (8130h), and its 6007h stops it.
    assert drive.emcy.wait(0x8130, timeout=PATIENCE / 1000).code == 0x8130
    end = time.monotonic() + PATIENCE / 1000
    while drive.sdo["Velocity actual value"].raw != 0:
        assert time.monotonic() < end
    expect(window.locator("#status")).to_have_text("not connected")


def test_the_program_is_reached_by_axis402(programs):
    """`axis402 panel` runs the program that lies beside it, but inside of `cargo run`, which builds it."""
    env = {name: value for name, value in os.environ.items() if name != "CARGO"}
    run = subprocess.run([programs.axis402, "panel", "--listen", "127.0.0.1:0"], capture_output=True, text=True, timeout=60, env=env)
    assert run.returncode == 2
    assert run.stderr.startswith("axis402 panel: a bus is missing"), run.stderr
