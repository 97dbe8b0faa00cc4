"""A panel that runs, and the windows of a real browser in front of it."""

import base64
import shutil

import pytest
from playwright.sync_api import expect, sync_playwright

from conftest import ROOT
from server import Server

#: What the drive moves, as that of `demo --panel` does.
BELT = ROOT / "sim" / "plants" / "with_motor" / "belt.toml"

#: The browser asks nobody outside for anything.
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"
    " --disable-component-update --disable-sync"
).split()

#: How long anything may take on a busy PC, in milliseconds.
PATIENCE = 60_000

#: A busy PC may end a jog before it has begun, or be late with an answer of the drive.
ATTEMPTS = 8


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
        listen = [] if "--listen" in arguments else ["--listen", "127.0.0.1:0"]
        self.server = Server([program, *listen, *arguments])
        self.browser = browser
        self.complaints = []
        greeting = []
        while (line := self.server.lines.get(timeout=120)) != "ready":
            assert line is not None, self.server.words()
            greeting.append(line)
        self.address = greeting[-1].removeprefix("panel on ").replace("0.0.0.0", "127.0.0.1")
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
        window.on("request", lambda asked: self.complaints.append(asked.url) if not asked.url.startswith((self.address.partition("?")[0], "blob:")) else None)
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


def open_drive(start, panel, **options):
    """The page of a drive that has a node-ID, and a motor that moves a belt."""
    bus = start(arguments=["--node-id", "4", "--plant", BELT])
    one = panel("--slcan", f"127.0.0.1:{bus.port}")
    one.slcan = f"127.0.0.1:{bus.port}"
    window = one.open(**options)
    window.click("text=Open drive")
    expect(window.locator("#state")).to_have_text("Switch on disabled")
    return one, window


def enable(window):
    """Enables the drive. On a PC that is too busy for the panel's patience with a drive this is told as an error: once more."""
    state, told = window.locator("#state"), []
    for _ in range(ATTEMPTS):
        if state.inner_text() == "Operation enabled":
            break
        window.click("#enable")
        try:
            expect(state).to_have_text("Operation enabled", timeout=10_000)
        except AssertionError:
            told += window.locator(".toast").all_inner_texts()
    expect(state, str(told)).to_have_text("Operation enabled")
    expect(window.locator("#guard")).to_have_text("The drive watches the panel's heartbeat (1016h).")


def velocity(window):
    return window.locator("#velocity-now")


def open_page(window, page, title):
    """Goes to a page with the mouse."""
    window.click(f"nav a[href='#{page}']")
    expect(window.locator("h1")).to_have_text(title)


#: The pages, with their titles once a drive is open.
PAGES = [
    ("bus", "Bus"),
    ("drive", "Axis402 CiA 402 drive · node 4"),
    ("scope", "Scope"),
    ("tuning", "Tuning"),
    ("objects", "Objects"),
    ("pdos", "PDOs"),
    ("log", "Log"),
]

def move_with_the_mouse(window):
    """From a drive without a node-ID to a finished move."""
    give_node_id(window)
    enable(window)
    window.click("#move-to")
    expect(window.locator("#position")).to_have_text("5\u202f000")
    window.click("#move-by")
    expect(window.locator("#position")).to_have_text("6\u202f000")
    expect(window.locator("#statusword")).to_contain_text("target reached")


def show_page(window, page, title):
    """A page with something on it."""
    open_page(window, page, title)
    if page == "objects":
        expect(window.locator(".object").first).to_be_visible()
    if page == "log":
        expect(window.locator("#frames tr").first).to_be_visible()
    if page == "pdos":
        expect(window.locator("tr[data-pdo]")).to_have_count(8)
    if page == "tuning":
        expect(window.locator("#cannot-tune")).to_contain_text("This drive has nothing to tune")


#: Words that are hard to read: whose contrast with what is behind them is below 4.5 (WCAG 2, AA). What is switched off may be faint.
FAINT = """() => {
  const read = (text) => {
    const found = text.match(/[\\d.]+/g).map(Number);
    const [red, green, blue] = text.startsWith('color(') ? found.slice(0, 3).map((part) => part * 255) : found;
    return { channels: [red, green, blue], alpha: found[3] ?? 1 };
  };
  const over = (front, back) => back.map((value, place) => front.channels[place] * front.alpha + value * (1 - front.alpha));
  // Most words stand on the same cards.
  const known = new Map();
  const behind = (element) => {
    if (!element) return [255, 255, 255];
    if (!known.has(element)) known.set(element, colourBehind(element));
    return known.get(element);
  };
  const colourBehind = (element) => {
    const style = getComputedStyle(element);
    const box = element.matches('svg .state') && element.querySelector('rect');
    return over(read(box ? getComputedStyle(box).fill : style.backgroundColor), behind(element.parentElement));
  };
  const light = (channels) => {
    const [red, green, blue] = channels.map((value) => (value <= 10 ? value / 3294 : ((value / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  };
  const contrast = (one, other) => {
    const [high, low] = [light(one), light(other)].sort((a, b) => b - a);
    return (high + 0.05) / (low + 0.05);
  };
  const words = [...document.body.querySelectorAll('*')].filter((element) =>
    [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())
    && element.getClientRects().length && !element.closest('[disabled], option, script, noscript, #toasts'));
  const shown = words.map((element) => {
    const style = getComputedStyle(element);
    const back = behind(element);
    const ink = read(element.closest('svg') ? style.fill : style.color);
    ink.alpha *= Number(style.opacity);
    return [element.textContent.trim().slice(0, 40), Math.round(contrast(over(ink, back), back) * 10) / 10];
  });
  return shown.filter(([, contrast]) => contrast < 4.5);
}"""

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
