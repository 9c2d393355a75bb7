"""The page of a film in a real browser: its start, its camera and its keyboard."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from gcm_learn.plots import style, write_film_page
from tests.plots.cases import FAR
from tests.rendering.test_rendering import near


def seen(page):
    """Return the picture on the page, from 0 to 1."""
    shot = page.locator(".card > #scene").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=float) / 255


@pytest.mark.parametrize(
    ("name", "width"),
    [
        ("chain", 400),
        pytest.param("chain", 1200, marks=pytest.mark.slow),
        pytest.param("spatial", 400, marks=pytest.mark.slow),
        pytest.param("spatial", 1200, marks=pytest.mark.slow),
    ],
)
def test_the_page_begins_at_the_start_and_shows_all(name, width, tmp_path, browser):
    pytest.importorskip("plotly")
    path = write_film_page(*FAR[name](), tmp_path / "page.html")
    page = browser.new_page(viewport={"width": width, "height": 800})
    page.goto(path.as_uri())
    slider = page.locator("#time")
    assert slider.input_value() == "0" and page.inner_text("#now") == "t = 0.00 s"
    last = int(slider.get_attribute("max"))
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert slider.input_value() == "1"
    for k in (0, last // 2, last):
        slider.fill(str(k))
        page.wait_for_timeout(300)
        picture = seen(page)
        for colour in (style.ARM, style.TARGET):
            assert near(picture, colour) > 5 / picture[..., 0].size, (k, colour)
        rim = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])[None]
        assert near(rim, style.ARM) == 0.0
    assert page.inner_text("#now").endswith("s: caught")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.close()
