"""Answers per second of `gcm-learn play` while something is dragged in a browser, and their parts.

python -m experiments benchmarks/play --seconds 4      so long each thing is dragged

It needs Chromium and the library playwright. The server is a process of its own.
"""

from __future__ import annotations

import argparse
import math
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from typing import Any

import numpy as np
from playwright.sync_api import Page, Response, sync_playwright

from tests.conftest import FLAGS

DRAWN = (("gate", 2), ("crossing-swarm", 1), ("spinning", 1), ("random-planar", 3))
REACH = 40  # half the width of the way of the pointer [pixels]
MOVE = 20  # [ms] between moves of the pointer
SETTLED = 1500  # [ms]


def body(index: int) -> str:
    """Return the selector of a body in the workspace; the hand is -1."""
    return f'#workspace [data-index="{index}"][tabindex]'


def dragged(page: Page, selector: str, seconds: float) -> tuple[list[float], list[dict[str, Any]]]:
    """Drag something along an eight; return when answers came [s], and the answers."""
    came: list[tuple[float, Response]] = []

    def keep(response: Response) -> None:
        if response.url.endswith("/answer"):
            came.append((time.perf_counter(), response))

    box = page.locator(selector).bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.on("response", keep)
    began = time.perf_counter()
    while (now := time.perf_counter() - began) < seconds:
        page.mouse.move(x + REACH * math.sin(1.5 * now), y + REACH * math.sin(3.0 * now))
        page.wait_for_timeout(MOVE)
    page.remove_listener("response", keep)
    answers = [response.json() for _, response in came]
    page.mouse.up()
    page.wait_for_timeout(SETTLED)
    return [at for at, _ in came], answers


def line(name: str, came: list[float], answers: list[dict[str, Any]], seconds: float) -> str:
    """One row: answers a second, time between them, and the medians of their parts [ms]."""
    parts = defaultdict(list)
    for answer in answers:
        for part, ms in answer.get("parts_ms", {}).items():
            parts[part].append(ms)
    gaps = 1e3 * np.diff(came)
    told = ", ".join(f"{part} {np.median(ms):.1f}" for part, ms in parts.items())
    median, late = np.percentile(gaps, (50, 90))
    return f"{name:24s} {len(came) / seconds:6.1f}  {median:6.0f} {late:6.0f}   {told}"


def measure(page: Page, seconds: float) -> None:
    """Drag bodies of the example and of drawn situations, and print a row for each."""
    for name, index in (("example: target", 0), ("example: obstacle", 1), ("example: hand", -1)):
        print(line(name, *dragged(page, body(index), seconds), seconds), flush=True)
    for name, index in DRAWN:
        page.select_option("#family", name)
        page.fill("#index", str(index))
        page.press("#index", "Enter")
        page.wait_for_timeout(2 * SETTLED)
        print(line(f"{name} {index}", *dragged(page, body(1), seconds), seconds), flush=True)


def main() -> None:
    """Serve the page, open it, and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=4.0)
    seconds = parser.parse_args().seconds
    command = [sys.executable, "-m", "gcm_learn", "play", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as served:
        assert served.stdout is not None
        address = served.stdout.readline().split()[1]
        with sync_playwright() as playwright:
            chromium = playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=list(FLAGS)
            )
            page = chromium.new_page(
                viewport={"width": 1280, "height": 800}, reduced_motion="reduce"
            )
            page.goto(address)
            page.wait_for_selector(".result.caught", timeout=300_000)
            page.wait_for_timeout(SETTLED)
            print("dragged                  a second  gap: median 90 %   parts, median [ms]")
            measure(page, seconds)
            chromium.close()
        served.terminate()


if __name__ == "__main__":
    main()
