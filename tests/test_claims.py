"""Numbers in documents are those of the results' own files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.claims import Claim, Text, agrees, claimed, numbers_of, tables_of, uncovered

ROOT = Path(__file__).parents[1]
README, FINDINGS = ROOT / "README.md", ROOT / "experiments" / "FINDINGS.md"
PAGES = sorted((ROOT / "experiments").glob("[0-9]*/README.md"))
CARDS = sorted((ROOT / "models").glob("*/card.md"))


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("page", claimed(), ids=name_of)
def test_numbers_are_those_of_the_files_that_they_are_said_to_come_from(page):
    for text in claimed()[page]:
        claims = list(text.claims())
        assert numbers_of(text.block()) == [claim.told for claim in claims], text.begins
        wrong = [claim for claim in claims if claim.is_result and not agrees(claim)]
        assert wrong == []


RESULTS = """
| method | stratum | caught | gap |
|---|---|---|---|
| `one` | W | **85.4** (83–88) | -4.6 (-9…+1) |
| `one` | Q | 30.5 (28–33) | |

| method | caught |
|---|---|
| one | 1,204 |

Of 2000 situations 12 were open.
"""


@pytest.mark.parametrize(
    ("text", "said", "good"),
    [
        ("85, 30.5", "r.md: 85 table 1 | one | W | caught; 30.5 one | Q | caught", True),
        ("86 %", "r.md: 86 one | W | caught", False),
        ("85.0 %", "r.md: 85.0 one | W | caught", False),
        ("83 to 88", "r.md: 83 one | W | caught [2]; 88 one | W | caught [3]", True),
        ("4.6 less", "r.md: 4.6 one | W | gap", True),
        ("+4.6", "r.md: +4.6 one | W | gap", False),
        ("-9 to +1", "r.md: -9 one | W | gap [2]; +1 one | W | gap [3]", True),
        ("1,204", "r.md: 1,204 table 2 | one | caught", True),
        ("55 points", "r.md: 55 one | W | caught minus one | Q | caught", True),
        ("2,000 `7` [8](9.md)", 'r.md: 2,000 "2000 situations"; 8 -', True),
        ("12", 'r.md: 12 "13 were open"', False),
        ("97.1 and 2", "r.json: 97.1 a | 1 over b\nr.md: 2 -", True),
        ("31 %", "r.json: 31 share", True),
        ("32 %", "r.json: 32 share", False),
        ("1 and 31", "r.json: 31 share", False),
        ("31 and 1", "r.json: 31 share", False),
    ],
)  # fmt: skip
def test_a_number_that_is_not_that_of_its_file_is_found(text, said, good, tmp_path):
    (tmp_path / "r.md").write_text(RESULTS)
    (tmp_path / "r.json").write_text(json.dumps({"a": [0, 1018], "b": 1048, "share": 0.308}))
    page = tmp_path / "page.md"
    page.write_text(f"# Title 3\n\nIn 5.\n\n- {text}\n- and 6\n")
    one = Text(page, f"- {text}"[:8], said)
    claims = list(one.claims())
    told = numbers_of(one.block()) == [claim.told for claim in claims]
    assert good == (told and all(agrees(claim) for claim in claims if claim.is_result))
    assert uncovered(page, [one]) == ["3", "5", "6"]


def test_a_place_that_is_not_one_place_is_refused(tmp_path):
    (tmp_path / "r.md").write_text(RESULTS)
    for source in ("one | caught", "two | W | caught", "one | W | lost"):
        with pytest.raises(LookupError, match="cells are"):
            agrees(Claim("85", tmp_path / "r.md", source))


@pytest.mark.parametrize("begins", ["- and", "- an"])
def test_a_text_that_is_not_one_text_is_refused(begins, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("- and 6\n- and 7\n" if begins == "- and" else "- no\n")
    with pytest.raises(LookupError, match="texts begin with"):
        Text(page, begins, "").block()


def test_every_number_of_the_findings_comes_from_somewhere():
    assert uncovered(FINDINGS, claimed()[FINDINGS]) == []
    results = [c for text in claimed()[FINDINGS] for c in text.claims() if c.source != "-"]
    assert len(results) > 50 and all(claim.is_result for claim in results)


def test_every_row_of_results_has_its_sources():
    rows = README.read_text("utf-8").split("## Results\n\n")[1].split("\n\n")[0].splitlines()[2:]
    covered = {text.block() for text in claimed()[README]}
    assert len(rows) == 10 and set(rows) <= covered


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_the_headline_of_an_experiment_comes_from_its_results(page):
    """Beside the page, and not from the page itself."""
    claims = [c for text in claimed()[page] for c in text.claims() if c.is_result]
    assert any(claim.file.resolve().parent == page.parent for claim in claims)
    assert all(claim.file.name != "README.md" for claim in claims)


def test_tables_that_are_shown_are_those_of_the_results():
    shown = 0
    for page in PAGES:
        told = tables_of(page)
        for file in page.parent.glob("*.md"):
            results = {} if file == page else tables_of(file)
            for head in told.keys() & results.keys():
                assert [row for row in told[head] if row not in results[head]] == [], page
                shown += 1
    assert shown >= 5


def scores_of(folder: Path) -> dict[str, float]:
    """What a model's own file says of it, by group."""
    for file, key in (("metrics.json", "validation"), ("state.json", "scores")):
        if (folder / file).exists():
            return json.loads((folder / file).read_text("utf-8"))[key]
    return {}


@pytest.mark.parametrize("card", CARDS, ids=name_of)
def test_cards_tell_the_scores_that_were_measured(card):
    scores, text = scores_of(card.parent), card.read_text("utf-8")
    if not scores:
        assert claimed()[card], "a card without a file of scores says where they are from"
    told = re.findall(r"^\| ([^|]+) \|(?: \d+ \|)? ([\d.]+)%(?:[^|]*\| ([\d.]+)%)?", text, re.M)
    for group, caught, touched in told:
        whole = " all" if group == "all" else f" {group}"
        of = {f"caught{whole}": caught, f"touched{whole}": touched} if touched else {group: caught}
        for name, share in of.items():
            score = 100.0 * scores[name.removesuffix(" all")]
            assert abs(float(share) - score) < 0.056, name  # both are rounded
    assert len(told) == sum(not name.startswith("touched") for name in scores)
