"""The panel in a real browser, with the mouse and the keyboard, in front of a virtual drive.

How soon a drive stands is measured on virtual time, in the tests of the crate `panel`; here it is seen what is sent, and in which order.
"""

import os
import re
import subprocess
import time

import can
import pytest
from playwright.sync_api import expect

from conftest import EDS, NODE_ID, ROOT
from panel_window import (  # noqa: F401
    ATTEMPTS,
    FAINT,
    PAGES,
    PATIENCE,
    browser,
    enable,
    give_node_id,
    move_with_the_mouse,
    open_drive,
    open_page,
    panel,
    show_page,
    velocity,
)

pytestmark = pytest.mark.only("virtual")

#: What a window sends, and when the button comes up: in their order, with the end of the task in which the window hears of it.
ORDER = """
window.heard = [];
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) { window.heard.push(JSON.parse(text).do); send.call(this, text); };
const note = (name) => () => { window.heard.push(name); setTimeout(() => window.heard.push('task over'), 0); };
addEventListener('pointerup', note('up'), true);
document.addEventListener('visibilitychange', note('hidden'), true);
"""

HIDE = (
    "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
    "document.dispatchEvent(new Event('visibilitychange')); delete document.hidden"
)


def test_from_a_drive_without_a_node_id_to_a_finished_move_with_the_mouse_alone(panel):
    window = (one := panel("--virtual")).open(color_scheme="light")
    move_with_the_mouse(window)
    # Every page, wide and narrow, light and dark: none is wider than the window, none complains.
    for scheme, width in [("light", 1280), ("dark", 1280), ("dark", 360)]:
        other = one.open(color_scheme=scheme, viewport={"width": width, "height": 860})
        for page, title in PAGES:
            show_page(other, page, title)
            assert other.evaluate("document.documentElement.scrollWidth") <= width, (page, width)
            assert other.evaluate(FAINT) == [], (page, scheme)

    # Found by its name, written within its limits.
    open_page(window, "objects", "Objects")
    window.fill("#search", "abort connection")
    expect(window.locator("#count")).to_have_text("1 found")
    window.click("text=Change >> nth=-1")
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


def expect_halt(bus):
    """The panel writes the halt to the controlword."""
    while (frame := bus.recv(timeout=PATIENCE / 1000)) is not None:
        if frame.arbitration_id == 0x600 + 4 and bytes(frame.data[:6]) == bytes([0x2B, 0x40, 0x60, 0x00, 0x0F, 0x01]):
            return
    raise AssertionError("no halt")


def test_a_jog_ends_when_the_button_is_released_the_page_hidden_or_the_window_closed(start, panel):
    one, window = open_drive(start, panel, before=ORDER)
    enable(window)
    # However long it takes, no limit switch is reached.
    window.fill("#jog", "100")
    bus = can.Bus(interface="slcan", channel=f"socket://{one.slcan}", bitrate=1_000_000, sleep_after_open=0.05)
    try:
        for end, name in ((lambda: window.mouse.up(), "up"), (lambda: window.evaluate(HIDE), "hidden")):
            hold(window, "#jog-positive", "100")
            while bus.recv(timeout=0) is not None:
                pass
            window.evaluate("window.heard.length = 0")
            end()
            expect_halt(bus)
            expect(velocity(window)).to_have_text("0")
            # In the very task in which the window hears of it the release is sent, and no beat comes behind it.
            heard = window.evaluate("new Promise((done) => setTimeout(() => done(window.heard), 0))")
            at = heard.index(name)
            assert heard[at + 1 : heard.index("task over")] == ["release"], heard
            assert "beat" not in heard[at:], heard
            window.mouse.up()
        watcher = one.open("#drive")
        hold(window, "#jog-negative", "-100", watcher)
        while bus.recv(timeout=0) is not None:
            pass
        window.close()
        expect_halt(bus)
        expect(velocity(watcher)).to_have_text("0")
    finally:
        bus.shutdown()


def test_a_held_button_says_so_each_40_ms_of_the_page(start, panel):
    """By the clock of the page, which stands and is moved by hand."""
    _, window = open_drive(start, panel, before=ORDER, clock=True)
    enable(window)
    window.fill("#jog", "100")
    window.hover("#jog-positive")
    window.clock.pause_at(window.evaluate("Date.now()") + 60_000)
    window.evaluate("window.heard.length = 0")
    window.mouse.down()
    window.clock.run_for(1_000)
    assert window.evaluate("window.heard").count("beat") == 25
    window.mouse.up()
    assert window.evaluate("window.heard[window.heard.length - 1]") == "release"


def test_the_keyboard_alone_does_it(panel):
    window = panel("--virtual").open()
    expect(window.locator("#number")).to_be_enabled()

    def press(selector, key="Enter"):
        """Goes there with the tabulator, as a person does, and presses a key."""
        expect(window.locator(selector).first).to_be_enabled()
        for _ in range(200):
            if window.evaluate("(wanted) => document.activeElement.matches(wanted)", selector):
                return window.keyboard.press(key)
            window.keyboard.press("Tab")
        raise AssertionError(f"the tabulator does not come to {selector}")

    press("#number")
    press("[data-node='4']")
    expect(window.locator("#state")).to_have_text("Switch on disabled")
    # A state that a command leads to is a button of the drawing.
    press(".state[data-go]")
    expect(window.locator("#state")).to_have_text("Ready to switch on")
    press("#enable")
    expect(window.locator("#state")).to_have_text("Operation enabled")
    press("#move-to")
    expect(window.locator("#position")).to_have_text("5\u202f000")
    # A search writes its spaces; a check box is switched by the enter key, and the space bar stops.
    press("nav a[href='#objects']")
    press("#search", "Space")
    window.keyboard.type("profile")
    expect(window.locator("#search")).to_have_value(" profile")
    press("nav a[href='#bus']")
    press("#rate-store")
    expect(window.locator("#rate-store")).not_to_be_checked()
    press("#rate-store", "Space")
    expect(window.locator(".node")).to_contain_text("operational")
    open_page(window, "drive", PAGES[1][1])
    expect(window.locator("#state")).to_have_text("Switch on disabled")
    # Numbers are written without spaces: there too it stops.
    press("#enable")
    expect(window.locator("#state")).to_have_text("Operation enabled")
    press("nav a[href='#scope']")
    press("#scope-samples", "Space")
    press("nav a[href='#drive']")
    expect(window.locator("#state")).to_have_text("Switch on disabled")


def expect_end(one):
    """Its adapter has gone with the device: one line, exit code 2."""
    assert one.server.process.wait(PATIENCE / 1000) == 2
    assert len(one.server.words().strip().splitlines()) == 1, one.server.words()
    one.server.was_killed = True


def test_a_device_that_is_no_drive_has_its_objects(panel, pytestconfig):
    from server import Slcan, free_port

    port = free_port()
    device = Slcan([pytestconfig.getoption("--io-device"), f"127.0.0.1:{port}"], port)
    device.server.wait_until_ready()
    window = (one := panel("--slcan", f"127.0.0.1:{port}")).open()
    expect(window.locator(".node")).to_contain_text("I/O device (CiA 401)")
    expect(window.locator("text=Open drive")).to_be_hidden()
    window.click(".node >> text=Objects")
    window.fill("#search", "1008")
    window.click(".object >> text=Read")
    expect(window.locator(".object .value")).not_to_be_empty()
    open_page(window, "drive", "Drive")
    expect(window.locator("#page")).to_contain_text("No drive is open")
    device.server.kill()
    expect(window.locator("#status")).to_have_text("not connected")
    expect_end(one)


class Together:
    """One bus made of two: what passes on either of them goes to the other, until it is cut."""

    def __init__(self, *ports):
        self.buses = buses = [can.Bus(interface="slcan", channel=f"socket://127.0.0.1:{port}", bitrate=1_000_000, sleep_after_open=0.05) for port in ports]
        self.notifiers = [can.Notifier(here, [there.send], timeout=0.02) for here, there in (buses, buses[::-1])]

    def cut(self):
        while self.notifiers:
            self.notifiers.pop().stop()
        while self.buses:
            self.buses.pop().shutdown()


@pytest.fixture
def together():
    made = []
    yield lambda *ports: made.append(Together(*ports)) or made[-1]
    for one in made:
        one.cut()


def test_two_drives_of_different_make_are_shown_side_by_side(start, panel, together):
    ours = start(arguments=["--node-id", "4"])
    theirs = start(arguments=["--product", "lmd", "--node-id", "5"])
    cable = together(ours.port, theirs.port)
    window = panel("--slcan", f"127.0.0.1:{ours.port}", "--eds", ROOT / "products" / "lmd" / "lmd.eds").open()
    expect(window.locator(".node")).to_have_count(2)
    for node, sheet in ((5, "lmd.eds"), (4, "axis402.eds")):
        open_page(window, "bus", "Bus")
        window.click(f"[data-node='{node}']")
        expect(window.locator("h1")).to_contain_text(f"node {node}")
        window.click("#enable")
        expect(window.locator("#state")).to_have_text("Operation enabled")
        # What was typed for another machine moves this one nowhere.
        expect(window.locator("#target")).to_have_value("")
        window.fill("#target", "700")
        window.click("#move-to")
        expect(window.locator("#position")).to_have_text("700")
        open_page(window, "scope", "Scope")
        expect(window.locator("#record")).to_be_visible(visible=sheet == "axis402.eds")
        window.evaluate(f"location.hash = '#objects/{node}'")
        expect(window.locator("#source")).to_contain_text(re.compile(f"[0-9]+ entries of .*{re.escape(sheet)}"))
    # One that vanishes is told, and what was read of it before is not shown as if it were now.
    window.evaluate("location.hash = '#objects/5'")
    expect(window.locator("#source")).to_contain_text("lmd.eds")
    window.fill("#search", "1017h:00")
    window.click(".object >> text=Change")
    window.fill(".editor input", "100")
    window.click("text=Write")
    open_page(window, "bus", "Bus")
    theirs_row = window.locator(".node", has=window.locator("[data-node='5']"))
    expect(theirs_row).to_contain_text(re.compile("heartbeat 0[.][0-9] s ago"))
    window.click("[data-node='5']")
    expect(window.locator("#state")).to_have_text("Switch on disabled")
    cable.cut()
    expect(window.locator("#state")).to_have_text("No answer")
    expect(window.locator("#position")).to_have_text("–")
    open_page(window, "bus", "Bus")
    expect(theirs_row).to_contain_text("silent")


def test_a_data_sheet_with_mistakes_is_used_with_a_note(start, panel, tmp_path):
    bus = start(arguments=["--node-id", str(NODE_ID)])
    sheet = tmp_path / "drive.eds"
    sheet.write_text(EDS.read_text().replace("[6081]\n", "[6081]\nObjectType=nonsense\n", 1))
    window = panel("--slcan", f"127.0.0.1:{bus.port}", "--eds", sheet).open()
    expect(window.locator("#banner")).to_contain_text("drive.eds has mistakes")
    window.click("text=Open drive")
    expect(window.locator("#state")).to_have_text("Switch on disabled")


def test_a_drive_that_is_killed_in_motion_ends_the_bus_with_one_line(start, panel):
    bus = start(arguments=["--node-id", str(NODE_ID)])
    one = panel("--slcan", f"127.0.0.1:{bus.port}")
    window = one.open()
    window.click("text=Open drive")
    enable(window)
    window.fill("#target", "1000000")
    window.click("#move-to")
    expect(velocity(window)).not_to_have_text("0")
    bus.server.kill()
    expect(window.locator("#banner")).to_contain_text("No connection with the panel")
    expect_end(one)


def test_one_window_writes_the_other_watches_and_may_stop(start, panel):
    one, first = open_drive(start, panel)
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


def test_beyond_this_computer_a_window_needs_the_address_with_the_token(panel, browser):  # noqa: F811
    one = panel("--virtual", "--listen", "0.0.0.0:0")
    expect(one.open().locator("#number")).to_be_enabled()
    stranger = browser.new_page()
    stranger.goto(one.address.partition("?")[0])
    expect(stranger.locator("#banner")).to_contain_text("This address has no token")
    # What it does not know it does not show.
    expect(stranger.locator("#number")).to_be_hidden()
    stranger.close()


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
