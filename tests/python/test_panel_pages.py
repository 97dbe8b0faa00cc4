"""What the pages of the panel show, in a real browser: pictures, recordings, PDOs, files, homing, velocities.

`--pictures FOLDER` keeps a picture of each page; those in `docs` are made so (`cargo xtask book --pictures`), and compared here.
"""

import pathlib
import re

import pytest
from playwright.sync_api import expect

from conftest import ROOT
from panel_window import (  # noqa: F401
    PAGES,
    browser,
    difference,
    enable,
    move_with_the_mouse,
    open_drive,
    open_page,
    panel,
    show_page,
    velocity,
)

pytestmark = pytest.mark.only("virtual")

#: A picture in docs may be so far from the one of this run: numbers and a curve that moves, no more.
LIKENESS = 0.02


def record_a_move(window):
    """A recording of a move, with the mouse."""
    open_page(window, "scope", "Scope")
    window.click("#record")
    expect(window.locator("#record")).to_contain_text("Armed")
    open_page(window, "drive", PAGES[1][1])
    window.fill("#distance", "500")
    window.click("#move-by")
    open_page(window, "scope", "Scope")
    expect(window.locator("#scope-words")).to_contain_text("Recording 1 of node 4")
    expect(window.locator(".curve")).to_have_count(4)


def test_a_picture_of_each_page_is_the_one_in_docs(panel, browser, pytestconfig):  # noqa: F811
    folder = pytestconfig.getoption("--pictures")
    window = panel("--virtual").open(color_scheme="light", viewport={"width": 1280, "height": 860})
    move_with_the_mouse(window)
    window.select_option("#homing-method", "24")
    window.evaluate("document.getElementById('toasts').replaceChildren()")
    drive = window.screenshot()
    record_a_move(window)
    made = {"panel": drive}
    for page, title in PAGES:
        # The one was taken before, that of a drive with something to tune is in `test_panel_tuning.py`.
        if page in ("drive", "tuning"):
            continue
        show_page(window, page, title)
        if page == "objects":
            window.fill("#search", "profile")
            window.click("#read-shown")
            expect(window.locator(".object .value").last).not_to_be_empty()
        if page == "log":
            expect(window.locator("#frames tr").nth(30)).to_be_attached()
        window.evaluate("document.getElementById('toasts').replaceChildren()")
        made[f"panel-{page}"] = window.screenshot()
    for name, picture in made.items():
        if folder:
            pathlib.Path(folder, f"{name}.png").write_bytes(picture)
        assert difference(browser, (ROOT / "docs" / f"{name}.png").read_bytes(), picture) <= LIKENESS, name


def test_a_recording_is_shown_measured_and_kept(start, panel):
    _, window = open_drive(start, panel)
    enable(window)
    record_a_move(window)
    curve = window.locator(".curve .u-over").first
    curve.click(position={"x": 100, "y": 40})
    curve.click(position={"x": 300, "y": 40}, modifiers=["Shift"])
    time_between = window.locator("#cursors tr").first.locator("td").last
    expect(time_between).to_have_text(re.compile(r"^[1-9][0-9.]* ms$"))
    # The same with the keyboard: a step is a hundredth of what is seen.
    before = time_between.inner_text()
    window.focus("#curves")
    window.keyboard.press("Shift+ArrowRight")
    expect(time_between).not_to_have_text(before)
    with window.expect_download() as download:
        window.click("#csv")
    lines = pathlib.Path(download.value.path()).read_text().splitlines()
    assert lines[0].startswith("time_s,") and len(lines) > 500 and lines[0].count(",") == lines[1].count(",") == 4
    # A trigger of one's own.
    window.select_option("#scope-trigger", "own")
    window.select_option("#scope-object", "6041h:00")
    window.select_option("#scope-edge", "#1")
    window.fill("#scope-level", "10")
    window.fill("#scope-samples", "200")
    window.click("#record")
    expect(window.locator("#record")).to_contain_text("Armed")
    open_page(window, "drive", PAGES[1][1])
    window.click("#move-by")
    open_page(window, "scope", "Scope")
    expect(window.locator("#scope-words")).to_contain_text("Recording 2 of node 4: 200 samples")
    with window.expect_download() as download:
        window.click("#png")
    assert pathlib.Path(download.value.path()).read_bytes().startswith(b"\x89PNG")


def test_the_log_is_filtered_by_node_and_words_and_kept_as_a_file(start, panel):
    _, window = open_drive(start, panel)
    enable(window)
    open_page(window, "log", "Log")
    rows, nodes = window.locator("#frames tr"), window.locator("#log-node")
    identifiers = window.locator("#frames td:nth-child(2)")
    # The panel sends heartbeats now that it guards the drive; both are heard.
    expect(nodes.locator("option")).to_have_text(["All nodes", "Node 4", "Node 127"])
    window.click("text=Pause")
    nodes.select_option("127")
    expect(rows.first).to_contain_text("77F")
    assert set(identifiers.all_inner_texts()) == {"77F"}
    nodes.select_option("4")
    # The services that are hidden are frames of that node too.
    window.click(".chip >> text=SDO")
    expect(rows.first).to_be_visible()
    assert all(int(identifier, 16) & 0x7F == 4 for identifier in identifiers.all_inner_texts())
    window.fill("#log-search", "read 6041h")
    expect(window.locator("#frames .meaning").first).to_contain_text("6041h")
    assert all("read 6041h" in words for words in window.locator("#frames .meaning").all_inner_texts())
    # What is kept is what is shown, the oldest first, and all of it.
    with window.expect_download() as download:
        window.click("#save-log")
    assert download.value.suggested_filename == "log.txt"
    lines = pathlib.Path(download.value.path()).read_text().splitlines()
    shown = window.evaluate("[...document.querySelectorAll('#frames tr')].map((row) => [...row.cells].map((cell) => cell.textContent))")[::-1]
    assert shown and len(lines) >= len(shown)
    for line, (at, identifier, data, _, meaning) in zip(lines[-len(shown) :], shown):
        assert line == f"{at}  {identifier}  {data:23}  {meaning}"
    nodes.select_option("127")
    expect(rows).to_have_count(0)
    nodes.select_option("")
    expect(rows.first).to_be_visible()


def test_pdos_are_edited_applied_and_seen_live(start, panel):
    _, window = open_drive(start, panel)
    enable(window)
    open_page(window, "pdos", "PDOs")
    fourth = window.locator("tr[data-pdo='TPDO 4']")
    expect(fourth).to_be_visible()
    while fourth.locator(".take").count():
        fourth.locator(".take").first.click()
    fourth.locator("select.add").select_option("6064h:00")
    fourth.locator("select.add").select_option("606Ch:00")
    fourth.locator("select.add").select_option("6062h:00")
    expect(window.locator("#problems")).to_contain_text("TPDO 4: 96 bits are mapped, a frame has 64")
    expect(window.locator("#apply")).to_be_disabled()
    fourth.locator(".take").last.click()
    expect(window.locator("#problems")).to_be_empty()
    fourth.locator("input[type=checkbox]").check()
    fourth.get_by_label("Transmission type").fill("241")
    expect(window.locator("#problems")).to_have_text("TPDO 4: transmission type 241 is reserved")
    fourth.get_by_label("Transmission type").fill("255")
    expect(fourth).to_contain_text("on change, or by timer")
    fourth.get_by_label("Identifier").fill("four")
    expect(window.locator("#apply")).to_be_disabled()
    fourth.get_by_label("Identifier").fill("484")
    fourth.get_by_label("Event timer").fill("2")
    expect(window.locator("#load")).to_contain_text("% of the bus")
    window.click("#apply")
    expect(window.locator(".toast.good").last).to_contain_text("1 PDO is set up")
    open_page(window, "scope", "Scope")
    window.click("#live")
    expect(window.locator("#scope-words")).to_contain_text("Live:")
    expect(window.locator(".curve").first).to_be_visible()


#: Eight channels at 1 kHz, for so many minutes of the page; one picture after each, and the last one is seen.
HOUR = """async ([from, to]) => {
  const scope = await import('/scope.js');
  const picture = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const at = new Float64Array(16);
  const values = Array.from({ length: 8 }, (_, channel) => ({ channel, at, values: Array.from(at, (_, place) => 1000 * channel + place) }));
  for (let minute = from; minute < to; minute += 1) {
    for (let batch = 0; batch < 3750; batch += 1) {
      for (let place = 0; place < 16; place += 1) at[place] = 60 * minute + batch * 0.016 + place / 1000;
      scope.values({ dropped: 0, values });
    }
    await picture();
  }
}"""

#: What an hour may leave behind in the memory of the page, in bytes. It brings 28.8 million values.
LEFT_BEHIND = 1 << 20


def test_an_hour_of_eight_channels_at_1_khz_takes_no_more_memory_than_two_minutes(start, panel):
    _, window = open_drive(start, panel)
    enable(window)
    open_page(window, "pdos", "PDOs")
    objects = iter(["6064h:00", "606Ch:00", "6062h:00", "60F4h:00", "60FDh:00", "603Fh:00", "6061h:00", "6041h:00"])
    for number in range(1, 5):
        row = window.locator(f"tr[data-pdo='TPDO {number}']")
        expect(row).to_be_visible()
        while row.locator(".take").count():
            row.locator(".take").first.click()
        for _ in range(2):
            row.locator("select.add").select_option(next(objects))
        row.locator("input[type=checkbox]").check()
        row.get_by_label("Transmission type").fill("255")
        row.get_by_label("Event timer").fill("1")
    window.click("#apply")
    expect(window.locator(".toast.good").last).to_contain_text("PDOs are set up")
    open_page(window, "scope", "Scope")
    window.click("#live")
    expect(window.locator("#scope-words")).to_contain_text("Live: 8 channels of 4 PDOs")
    expect(window.locator(".curve")).to_have_count(8)
    # How many there are is told, and what was missed.
    expect(window.locator("#scope-words")).to_contain_text(re.compile(r", [1-9][0-9]* pictures/s"))
    # From here on by the clock of what comes: the panel is asked for no more.
    window.evaluate("import('/connection.js').then((connection) => connection.order('live', { on: false }))")
    browser_tools = window.context.new_cdp_session(window)

    def used():
        browser_tools.send("HeapProfiler.collectGarbage")
        told = browser_tools.send("Runtime.getHeapUsage")
        return told["usedSize"] + told.get("backingStorageSize", 0)

    window.evaluate(HOUR, [100, 102])
    before = used()
    window.evaluate(HOUR, [102, 162])
    after = used()
    assert after - before < LEFT_BEHIND, (before, after)
    # A picture shows the least and the greatest of each few; a file, and a picture that stands, have each value.
    window.select_option("#live-span", "60")
    window.evaluate(HOUR, [162, 164])
    with window.expect_download() as download:
        window.click("#csv")
    lines = pathlib.Path(download.value.path()).read_text().splitlines()
    assert len(lines) == 60_001 and lines[-1].count(",") == 15, (len(lines), lines[-1])
    window.click("text=Pause")
    window.focus("#curves")
    # Cursor A is at the middle, the value one of those that came there: 1000 times the channel and its place in the batch.
    window.keyboard.press("ArrowRight")
    for channel, row in enumerate(window.locator("#cursors tr").all()[1:]):
        value = int(row.locator("td").first.inner_text().replace("\u202f", ""))
        assert 1000 * channel <= value < 1000 * channel + 16, (channel, value)


def test_a_configuration_is_saved_compared_and_loaded(start, panel, tmp_path):
    _, window = open_drive(start, panel)
    open_page(window, "objects", "Objects")
    with window.expect_download() as download:
        window.click("#dump")
    file = tmp_path / download.value.suggested_filename
    download.value.save_as(file)

    def choose(button):
        with window.expect_file_chooser() as chooser:
            window.click(button)
        chooser.value.set_files(file)

    choose("#compare")
    expect(window.locator("#differ")).to_have_text("Node 4 is as node-4.dcf says.")
    window.fill("#search", "6083")
    window.click(".object >> text=Change")
    window.fill(".editor input", "77777")
    window.click("text=Write")
    expect(window.locator(".object[data-changed]")).to_have_count(1)
    choose("#compare")
    expect(window.locator("#differ")).to_have_text("1 value is not as node-4.dcf says:")
    choose("#load")
    expect(window.locator("#differ")).to_have_text("Node 4 is as node-4.dcf says.")
    # The same device with another number.
    open_page(window, "bus", "Bus")
    window.click("text=NMT, node-ID")
    window.get_by_label("New node-ID of node 4").fill("7")
    window.click(".renumber-button")
    expect(window.locator(".toast.good").last).to_have_text("node 4 is node 7 now")
    expect(window.locator(".node-number")).to_have_text(["7"])


def test_homing_is_drawn_and_set_up(start, panel):
    _, window = open_drive(start, panel)
    window.select_option("#homing-method", "24")
    expect(window.locator(".homing")).to_have_attribute("aria-label", "Homing method 24: Home switch from the left, behind its left edge")
    window.fill("#homing-fast", "1500")
    window.click("#set-homing")
    expect(window.locator(".toast.good").last).to_have_text("Homing is set up")
    # Home homes as it is drawn, set up or not: here where it stands.
    enable(window)
    window.fill("#target", "1000")
    window.click("#move-to")
    expect(window.locator("#position")).to_have_text("1\u202f000")
    window.select_option("#homing-method", "37")
    window.click("#home")
    expect(window.locator("#position")).to_have_text("0")
    open_page(window, "objects", "Objects")
    for address, value in (("6099h:01", "1500"), ("6098h", "37")):
        window.fill("#search", address)
        window.click(".object >> text=Read")
        expect(window.locator(".object .value")).to_have_text(value)


def test_a_velocity_is_given_in_its_mode(start, panel):
    _, window = open_drive(start, panel)
    enable(window)
    window.select_option("#modes", "3")
    expect(window.locator("#set-point-name")).to_have_text("Target velocity (60FFh)")
    window.fill("#set_point", "100")
    window.click("#set")
    expect(velocity(window)).to_have_text("100")
    window.click("#zero")
    expect(velocity(window)).to_have_text("0")
