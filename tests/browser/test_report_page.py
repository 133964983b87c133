# SPDX-License-Identifier: GPL-2.0-or-later
"""The report in a real browser: quiet, offline, moved by pointer and keyboard, no empty picture."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, expect

pytestmark = pytest.mark.browser

READY = "document.getElementById('player')?.dataset.frame !== undefined"
# Share of the canvas that is not transparent, and the number of its colours.
DRAWN = """() => {
  const canvas = document.querySelector('.map canvas');
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const colours = new Set(); let shown = 0;
  for (let k = 0; k < data.length; k += 4) {
    if (data[k + 3]) { shown += 1; colours.add(data[k] << 16 | data[k + 1] << 8 | data[k + 2]); }
  }
  return [shown / (data.length / 4), colours.size];
}"""
EMPTY = """async () => {
  const empty = [];
  for (const image of document.images) {
    await image.decode().catch(() => empty.push(image.alt));
    if (!image.naturalWidth || !image.clientWidth) empty.push(image.alt);
  }
  return empty;
}"""


class Opened:
    """A page, and what it said and asked for that it should not."""

    def __init__(self, browser: Browser, path: Path, **settings: object) -> None:
        self.page: Page = browser.new_page(**settings)  # type: ignore[arg-type]
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri())
        self.page.wait_for_function(READY)

    def _hear(self, message: ConsoleMessage) -> None:
        # Chromium advises against reading a canvas often, as these tests do.
        if "willReadFrequently" not in message.text:
            self.said.append(message.text)

    @property
    def fetched(self) -> list[str]:
        """What it loaded beside itself and what it holds."""
        return [url for url in self.asked[1:] if not url.startswith(("data:", "blob:"))]

    @property
    def state(self) -> tuple[str, int]:
        """Field and frame that the map shows."""
        player = self.page.locator("#player")
        return (
            str(player.get_attribute("data-field")),
            int(player.get_attribute("data-frame") or -1),
        )


@pytest.fixture
def opened(browser: Browser, report: Path) -> Iterator[Opened]:
    found = Opened(browser, report, viewport={"width": 1400, "height": 900})
    yield found
    assert not found.said and not found.fetched
    found.page.close()


def test_the_slider_goes_through_all_windows(opened: Opened):
    slider, output = opened.page.get_by_label("Time"), opened.page.locator(".time output")
    assert opened.state == ("thickness", 3)
    last = output.text_content()
    slider.focus()
    opened.page.keyboard.press("Home")
    assert opened.state == ("thickness", 0)
    opened.page.keyboard.press("ArrowRight")
    assert opened.state == ("thickness", 1)
    assert output.text_content() == slider.get_attribute("aria-valuetext") != last
    slider.fill("2")
    assert opened.state == ("thickness", 2)


def test_every_field_is_drawn_with_its_scale(opened: Opened):
    tabs = opened.page.get_by_role("tab")
    names = [
        str(name).removeprefix("tab-") for name in tabs.evaluate_all("all => all.map(t => t.id)")
    ]
    assert {"thickness", "concentration", "drift"} <= set(names)
    for place, name in enumerate(names):
        tabs.nth(place).click()
        opened.page.wait_for_function(
            f"document.getElementById('player').dataset.field === '{name}'"
        )
        assert tabs.nth(place).get_attribute("aria-selected") == "true"
        share, colours = opened.page.evaluate(DRAWN)
        # The synthetic run has the same snow everywhere.
        assert share > 0.1 and (colours > 1 or name == "snow"), name
        assert opened.page.locator(".scale .high").text_content()
        assert "grid.nc" in str(opened.page.locator(".about").text_content())
    assert opened.page.locator(".arrows path").count() == 0
    opened.page.locator("#tab-drift").click()
    expect(opened.page.locator(".arrows path")).to_have_count(1)


def test_tabs_answer_to_arrow_keys(opened: Opened):
    opened.page.locator("#tab-thickness").focus()
    opened.page.keyboard.press("ArrowRight")
    expect(opened.page.locator("#tab-concentration")).to_be_focused()
    opened.page.wait_for_function(
        "document.getElementById('player').dataset.field === 'concentration'"
    )
    opened.page.keyboard.press("ArrowLeft")
    expect(opened.page.locator("#tab-thickness")).to_be_focused()
    # One stop of the Tab key for all fields, then the button and the slider.
    for label in ("Play", "Time"):
        opened.page.keyboard.press("Tab")
        focused = opened.page.locator(":focus")
        assert label in (focused.get_attribute("aria-label"), focused.text_content())


def test_play_runs_to_the_end_and_stops(opened: Opened):
    opened.page.clock.install()
    play = opened.page.locator(".play")
    play.click()
    assert opened.state[1] == 0 and play.text_content() == "Pause"
    opened.page.clock.run_for(10_000)
    assert opened.state[1] == 3 and play.text_content() == "Play"


def test_the_pointer_reads_values(opened: Opened):
    box = opened.page.locator(".map").bounding_box()
    assert box is not None
    opened.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    assert str(opened.page.locator(".readout").text_content()).endswith(" m")
    opened.page.mouse.move(box["x"] - 30, box["y"] - 30)
    assert opened.page.locator(".readout").text_content() == ""


@pytest.mark.parametrize(
    ("width", "height", "scheme"), [(1400, 900, "light"), (1400, 900, "dark"), (400, 860, "light")]
)
def test_no_picture_is_empty_and_nothing_sticks_out(
    browser: Browser, report: Path, screenshots: Path, width: int, height: int, scheme: str
):
    size = {"width": width, "height": height}
    found = Opened(browser, report, viewport=size, color_scheme=scheme)
    page = found.page
    assert page.evaluate(EMPTY) == []
    assert page.evaluate(DRAWN)[0] > 0.1
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.screenshot(path=screenshots / f"first_{width}_{scheme}.png")
    page.screenshot(path=screenshots / f"report_{width}_{scheme}.png", full_page=True)
    assert not found.said and not found.fetched
    page.close()


def test_the_map_and_the_numbers_stand_on_the_first_screen(opened: Opened):
    for name in (".map", ".time", ".cards", "nav"):
        box = opened.page.locator(name).first.bounding_box()
        assert box is not None and box["y"] < 450, name


def test_without_a_program_the_rest_is_there(browser: Browser, report: Path):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(report.as_uri())
    assert page.locator("noscript").count() == 1
    assert page.get_by_role("heading", name="Budgets with residuals").is_visible()
    assert page.locator("figure img").count() > 15
    context.close()


def test_prints_its_map(browser: Browser, report: Path, tmp_path: Path):
    found = Opened(browser, report)
    found.page.emulate_media(media="print")
    assert found.page.locator(".map").is_visible() and not found.page.locator("nav").is_visible()
    pages = found.page.pdf(path=tmp_path / "report.pdf")
    assert pages.startswith(b"%PDF")
    found.page.close()
