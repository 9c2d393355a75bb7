"""The write-up is made from files of results."""

from __future__ import annotations

import pytest

from experiments.write_up import TEXT, as_html, filled, write_pdf


def test_all_numbers_of_the_write_up_are_found_and_it_has_at_most_four_pages(tmp_path):
    text = filled(TEXT.read_text("utf-8"))
    assert "{{" not in text and len(text) > 5000
    file = tmp_path / "write-up.pdf"
    assert 1 < write_pdf(as_html(text), file) <= 4
    first = file.read_bytes()
    write_pdf(as_html(text), file)
    assert file.read_bytes() == first


def test_numbers_are_written_as_asked(tmp_path):
    (tmp_path / "t.md").write_text("| a | b [%] |\n|---|---|\n| x | 12.34 (10–14) |\n")
    (tmp_path / "r.json").write_text('{"share": 0.954}')
    places = ("{{t.md: x | b [%]}}", "{{t.md: x | b [%]; 1}}", "{{t.md: x | b [%] [3]}}")
    text = " ".join((*places, "{{r.json: share; %1}}"))
    assert filled(text, tmp_path) == "12 12.3 14 95.4"


@pytest.mark.parametrize("place", ["{{t.md}}", "{{ t.md: x }}"])
def test_what_is_no_place_is_refused(place):
    with pytest.raises(LookupError, match="is no place"):
        filled(place)
