"""Numbers in documents are those of the files of results."""

import re

import pytest

from experiments.bound import BOUND, PAGES, renewed

RESULTS = {"README.md": r"\n(?=\| .*\]\(experi)", "FINDINGS.md": r"\n(?=- \*)"}
TABLE = "| a | gap |\n|---|---|\n| `x` | **-4.55** (-9…+1) |\n| y | 1,204 |\n\nOf 20\ncases 9.\n"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.parent.name}/{page.name}")
def test_numbers_are_those_of_their_files_and_every_result_is_bound(page):
    assert renewed(page) == (text := page.read_text("utf-8")), "python -m experiments recompute"
    assert all(BOUND.search(part) for part in re.split(RESULTS.get(page.name, "$^"), text)[1:])


@pytest.mark.parametrize(("told", "now"), [
    ("5<!--r.md: minus x > gap--> (-1<!--x > gap [2]--> to +1<!--[3]-->)", "5 -9 +1"),
    ("9<!--r.md: table 1 > y > gap--> 7,000.0<!--y > gap minus x > gap-->", "1204 1,208.6"),
    ('1<!--r.md: "Of # cases"--> 1<!--r.json: a > 0 %--> 1.0<!--a > 0 over b-->', "20 31 15.4"),
])  # fmt: skip
def test_a_number_is_renewed_as_it_was_written(told, now, tmp_path):
    (tmp_path / "r.md").write_text(TABLE)
    (tmp_path / "r.json").write_text('{"a": [0.308], "b": 2}')
    (page := tmp_path / "page.md").write_text(told)
    assert [found[0] for found in BOUND.findall(renewed(page))] == now.split()
    for place in ("x > gap", "z > gap", "gap"):  # a loss is no gain; no such row; several rows
        page.write_text(f"5<!--r.md: {place}-->")
        with pytest.raises(LookupError):
            renewed(page)
