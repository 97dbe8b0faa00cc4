"""A panel that runs, and the windows of a real browser in front of it."""

import base64
import re
import shutil

import pytest
from playwright.sync_api import expect, sync_playwright

from server import Server

#: The browser asks nobody outside for anything.
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"
    " --disable-component-update --disable-sync"
).split()

#: How long anything may take on a busy PC, in milliseconds.
PATIENCE = 60_000


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

    def open(self, page="", before=None, clock=False, **options):
        """A window of its own; `before` runs in it before the page does, and with `clock` its time can be moved by hand."""
        context = self.browser.new_context(**{"viewport": {"width": 1280, "height": 860}, **options})
        self.contexts.append(context)
        window = context.new_page()
        window.set_default_timeout(PATIENCE)
        if before:
            window.add_init_script(before)
        if clock:
            window.clock.install()
        expect.set_options(timeout=PATIENCE)
        window.on("console", lambda said: self.complaints.append(said.text) if said.type in ("error", "warning") else None)
        window.on("pageerror", lambda error: self.complaints.append(str(error)))
        window.on("request", lambda asked: self.complaints.append(asked.url) if not asked.url.startswith((self.address, "blob:")) else None)
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
    expect(window.locator(".toast.good").first).to_contain_text("has a node-ID now")
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


def open_page(window, page, title):
    """Goes to a page with the mouse."""
    window.click(f"nav a[href='#{page}']")
    expect(window.locator("h1")).to_have_text(title)


#: How far two pictures are apart: the mean difference of their colours, 0 to 1, each drawn on few points.
DIFFERENCE = """async ([one, other]) => {
  const points = async (data) => {
    const picture = new Image();
    picture.src = 'data:image/png;base64,' + data;
    await picture.decode();
    const canvas = Object.assign(document.createElement('canvas'), { width: 160, height: 108 });
    const paint = canvas.getContext('2d');
    paint.imageSmoothingQuality = 'high';
    paint.drawImage(picture, 0, 0, 160, 108);
    return [picture.width, picture.height, paint.getImageData(0, 0, 160, 108).data];
  };
  const [width, height, first] = await points(one);
  const [otherWidth, otherHeight, second] = await points(other);
  if (width !== otherWidth || height !== otherHeight) return 1;
  return first.reduce((sum, value, place) => sum + Math.abs(value - second[place]), 0) / first.length / 255;
}"""


def difference(browser, one, other):
    """How far two pictures are apart, 0 to 1."""
    page = browser.new_page()
    try:
        return page.evaluate(DIFFERENCE, [base64.b64encode(picture).decode() for picture in (one, other)])
    finally:
        page.close()
