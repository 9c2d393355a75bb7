"""The write-up is made of its text."""

from __future__ import annotations

from experiments.write_up import TEXT, as_html, write_pdf


def test_the_write_up_has_at_most_four_pages_without_the_places_of_its_numbers(tmp_path):
    html = as_html(TEXT.read_text("utf-8"))
    assert "<!--" not in html and "table.md" not in html and len(html) > 5000
    file = tmp_path / "write-up.pdf"
    assert 1 < write_pdf(html, file) <= 4
    first = file.read_bytes()
    write_pdf(html, file)
    assert file.read_bytes() == first
