"""Record the page of `gcm-learn play` as docs/images/play.gif: ``python -m docs.record_play``.

An obstacle is dragged, then the tip of an arrow, and the film is played. It needs Chromium and the
library playwright.
"""

from __future__ import annotations

import io
import math
import shutil
import threading
from pathlib import Path

from PIL import Image, ImageDraw
from playwright.sync_api import Page, sync_playwright

from gcm_learn.play import KINDS, Newest, Server, example, respond
from gcm_learn.plots.figures.film import write_film
from tests.play.conftest import FLAGS

TARGET = Path(__file__).parent / "images" / "play.gif"
SIZE = {"width": 1180, "height": 800}
WIDTH = 700  # of the film [pixels]
HORIZON = example()["horizon"]  # [s]
PAUSE = 160  # [ms] after a move, until the answer is drawn
POINTER = ((0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12))


class Film:
    """Frames of a part of the page, with a pointer."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.frames: list[Image.Image] = []
        panels = page.locator(".panels").bounding_box()
        bar = page.locator(".time").bounding_box()
        assert panels is not None and bar is not None
        bottom = bar["y"] + bar["height"]
        self.clip = {
            **panels, "x": panels["x"] - 6, "y": panels["y"] - 6, "width": panels["width"] + 12,
            "height": bottom - panels["y"] + 12,
        }  # fmt: skip
        self.at = (0.0, 0.0)

    def shoot(self, count: int = 1) -> None:
        """Keep the page as it is for some frames."""
        picture = Image.open(io.BytesIO(self.page.screenshot(clip=self.clip))).convert("RGB")
        share = WIDTH / picture.width
        picture = picture.resize((WIDTH, round(share * picture.height)), Image.Resampling.LANCZOS)
        x, y = ((a - self.clip[name]) * share for a, name in zip(self.at, "xy", strict=True))
        shape = [(x + dx, y + dy) for dx, dy in POINTER]
        ImageDraw.Draw(picture).polygon(shape, fill="black", outline="white")
        self.frames += [picture] * count

    def go(self, x: float, y: float) -> None:
        """Move the pointer, and keep a frame."""
        self.page.mouse.move(x, y)
        self.at = (x, y)
        self.page.wait_for_timeout(PAUSE)
        self.shoot()

    def drag(self, selector: str, way: list[tuple[float, float]]) -> None:
        """Drag something along offsets [pixels]."""
        box = self.page.locator(selector).bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        (a, b), steps = self.at, 5
        for k in range(1, steps + 1):
            self.go(a + (x - a) * k / steps, b + (y - b) * k / steps)
        self.page.mouse.down()
        for dx, dy in way:
            self.go(x + dx, y + dy)
        self.page.mouse.up()
        self.page.wait_for_timeout(6 * PAUSE)
        self.shoot(4)

    def play(self, count: int) -> None:
        """Move the slider from the start to the catch."""
        last = self.page.locator("#ticks span").get_attribute("title") or ""
        end = float(last.split()[-2])
        for k in range(count + 1):
            self.page.evaluate(
                """(value) => { const slider = document.getElementById("time");
                slider.value = value; slider.dispatchEvent(new Event("input")); }""",
                1000 * end * k / count / HORIZON,
            )
            self.page.wait_for_timeout(PAUSE // 2)
            self.shoot()


def record() -> None:
    """Serve the page, act on it, and write the film."""
    server = Server(Newest(respond), KINDS, example())
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(FLAGS)
        )
        page = browser.new_page(viewport=SIZE, reduced_motion="reduce")
        page.goto(server.address)
        page.wait_for_selector(".result.caught", timeout=300_000)
        page.wait_for_timeout(3000)
        film = Film(page)
        film.at = (film.clip["x"] + 330, film.clip["y"] + 470)
        film.shoot(8)
        turns = [math.tau * k / 22 for k in range(23)]
        film.drag(
            '#workspace [data-index="1"][tabindex]',
            [(-45 * (1 - math.cos(a)), 60 * math.sin(a)) for a in turns],
        )
        film.drag(
            '#workspace [data-act="speed"][data-index="0"]',
            [(0.75 * k, -1.25 * k) for k in range(9)],
        )
        film.play(18)
        browser.close()
    write_film(film.frames, TARGET)
    print(f"{TARGET}: {len(film.frames)} frames, {TARGET.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    record()
