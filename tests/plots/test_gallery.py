"""The README's pictures can be drawn again."""

from __future__ import annotations

from PIL import Image

from gcm_learn.plots.reports.documents import write_gallery


def test_gallery_writes_readable_pictures(tmp_path):
    files = write_gallery(tmp_path / "images")
    assert [f.name for f in files] == [
        "situation.png",
        "hand-space.png",
        "wave.png",
        "map.png",
        "catch.gif",
        "waiting.png",
        "families.png",
    ]
    for file in files:
        with Image.open(file) as picture:
            assert min(picture.size) >= 280
        assert file.stat().st_size < 400_000
