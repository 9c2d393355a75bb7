"""What the documents say is so: examples run, links lead somewhere, lists are complete."""

from __future__ import annotations

import ast
import importlib
import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from experiments.bound import BOUND, rows
from gcm_learn import planner_names, solve
from gcm_learn.cli import main
from gcm_learn.cli.arguments import COMMANDS, OLD
from gcm_learn.families import family_names
from gcm_learn.planners import plan_to_json
from gcm_learn.situation import situation_from_json

ROOT = Path(__file__).parents[1]
README, ARCHITECTURE = (ROOT / "README.md", ROOT / "ARCHITECTURE.md")
QUICKSTART, COMMAND_LINE, PLANNERS = (
    ROOT / "docs" / f"{name}.md" for name in ("quickstart", "command-line", "planners")
)
MADE = ("changelog", "datasets", "memories", "results", "schemas")  # by make docs
DOCUMENTS = [
    *sorted(ROOT.glob("*.md")),
    *(path for path in sorted((ROOT / "docs").glob("*.md")) if path.stem not in MADE),
]
BESIDE = sorted(
    path for top in ("data", "experiments", "models") for path in (ROOT / top).rglob("*.md")
)
"""Documents that lie beside what they are about."""
FOREIGN = {"FetchInitCPM", "RecordVideo"}
"""Words of other projects that look like classes of ours."""
IMAGES_AT_MOST = 2_900_000  # [bytes] of which the page of `play` has half a million


def blocks(path: Path, language: str) -> list[str]:
    """Return the fenced code blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text("utf-8"), re.M | re.S)


def first_column(path: Path, heading: str) -> list[str]:
    """Return what is set as code in the first cells of the table under a heading."""
    section = path.read_text("utf-8").split(f"## {heading}\n")[1].split("\n## ")[0]
    return re.findall(r"^\| `([^`]+)`", section, re.M)


def numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", text)]


def headings(text: str) -> set[str]:
    """Return the anchors of a document's headings."""
    heads = re.findall(r"^#+ (.+)$", text, re.M)
    return {re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("path", [*DOCUMENTS, *BESIDE], ids=lambda p: str(p.relative_to(ROOT)))
def test_local_links_and_pictures_exist(path):
    text = path.read_text("utf-8")
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'src="([^"]+)"', text)
    for target in targets:
        if not re.match(r"https?://", target):
            file, _, anchor = target.partition("#")
            other = path.parent / file if file else path
            assert other.exists(), target
            assert not anchor or anchor in headings(other.read_text("utf-8")), target


@pytest.fixture(scope="module")
def words():
    """Words of all sources."""
    folders = ("gcm_learn", "experiments", "tests", "docs")
    texts = (path.read_text("utf-8") for name in folders for path in (ROOT / name).rglob("*.py"))
    return {word for text in texts for word in re.findall(r"\w+", text)}


@pytest.mark.parametrize("path", [*DOCUMENTS, *BESIDE], ids=lambda p: str(p.relative_to(ROOT)))
def test_classes_that_are_named_exist(path, words):
    if path.stem == "CHANGELOG":
        return  # it tells of what is gone
    text = re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.M | re.S)
    codes = re.findall(r"`([^`\n]+)`", text)
    named = {w for code in codes for w in re.findall(r"\b[A-Z][a-z]+(?:[A-Z][a-z]+)+\w*", code)}
    assert named - FOREIGN <= words


@pytest.mark.parametrize(
    "path",
    [p for p in [*DOCUMENTS, *BESIDE] if blocks(p, "python")],
    ids=lambda p: str(p.relative_to(ROOT)),
)
def test_what_examples_import_exists(path):
    for example in blocks(path, "python"):
        for node in ast.walk(ast.parse(example)):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("gcm_learn"):
                module = importlib.import_module(str(node.module))
                assert [one.name for one in node.names if not hasattr(module, one.name)] == []


def test_every_picture_is_shown_and_they_are_light():
    images = sorted((ROOT / "docs" / "images").iterdir())
    text = "".join(path.read_text("utf-8") for path in DOCUMENTS)
    assert [image.name for image in images if image.name not in text] == []
    assert sum(image.stat().st_size for image in images) < IMAGES_AT_MOST


def test_the_readme_is_short_and_says_all_that_it_says():
    text = README.read_text("utf-8")
    assert len(text.splitlines()) <= 170 and "<!--" not in BOUND.sub("", text)


EXAMPLES = [
    (README, 0, "map.png"), (README, 1, None), (README, 2, None), (README, 3, None),
    (QUICKSTART, 0, "map.png"), (QUICKSTART, 1, None), (QUICKSTART, 2, None), (QUICKSTART, 3, None),
]  # fmt: skip
NEEDS = {(README, 3): "gymnasium", (QUICKSTART, 3): "mujoco"}


@pytest.mark.parametrize(
    ("page", "which", "drawn"), EXAMPLES, ids=lambda given: getattr(given, "stem", str(given))
)
def test_examples_run_and_print_what_the_page_says(
    page, which, drawn, tmp_path, monkeypatch, capsys
):
    pytest.importorskip(NEEDS.get((page, which), "numpy"))
    example = blocks(page, "python")[which]
    promised = page.read_text("utf-8").split(example)[1].split("```")[2]
    monkeypatch.chdir(tmp_path)
    exec(compile(example, page.name, "exec"), {"__name__": "example"})
    printed = capsys.readouterr().out
    words = re.compile(r"[a-z]+")
    assert words.findall(printed) == words.findall(promised)
    np.testing.assert_allclose(numbers(printed), numbers(promised), rtol=0.03, atol=0.011)
    assert drawn is None or (tmp_path / drawn).stat().st_size > 1000


@pytest.mark.parametrize("which", ["planner", "policy", "model"])
def test_how_tos_run(which, tmp_path, monkeypatch, capsys):
    if which == "model":
        pytest.importorskip("stable_baselines3")
    path = ROOT / "docs" / "your-own.md"
    example = blocks(path, "python")[["planner", "policy", "model"].index(which)]
    monkeypatch.chdir(tmp_path)
    exec(compile(example, str(path), "exec"), {"__name__": "example"})
    printed = capsys.readouterr().out
    if which == "planner":
        assert printed == blocks(path, "text")[0]
    else:
        name = "model.zip" if which == "model" else "Forward"
        assert "error" not in printed and f"\n{name} [" in printed


def test_the_how_to_of_data_runs(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pyarrow")
    path = ROOT / "docs" / "own-data.md"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "crossings.toml").write_text(blocks(path, "toml")[0], "utf-8")
    examples = zip(blocks(path, "bash"), blocks(path, "python"), blocks(path, "text"), strict=True)
    for commands, example, promised in examples:
        for command in commands.splitlines():
            setting, _, asked = command.partition("gcm-learn ")
            with monkeypatch.context() as set_for_this:
                if setting:
                    set_for_this.setenv(*setting.strip().split("="))
                assert main(asked.split()) == 0
        capsys.readouterr()
        exec(compile(example, str(path), "exec"), {"__name__": "example"})
        assert capsys.readouterr().out == promised
    answers = (tmp_path / "caught.jsonl").read_text("utf-8").splitlines()
    assert {json.loads(line)["planner"] for line in answers} == {"recall"}


def test_the_situation_has_the_solution_that_is_shown(tmp_path, capsys):
    situation, solution = blocks(COMMAND_LINE, "json")
    scene = tmp_path / "scene.jsonl"
    scene.write_text(situation, "utf-8")
    assert main(["solve", str(scene)]) == 0
    shown, given = json.loads(solution), json.loads(capsys.readouterr().out)
    assert list(shown) == list(given)
    for name in ("format", "name", "planner", "status", "catch_body"):
        assert shown[name] == given[name]
    for name in ("catch_time", "clearance"):
        assert shown[name] == pytest.approx(given[name], rel=0.03)
    for name, samples in shown["trajectory"].items():
        np.testing.assert_allclose(samples, given["trajectory"][name][: len(samples)], atol=0.02)


def test_exchange_example_is_a_situation_and_its_fields_are_the_solutions():
    examples = [json.loads(text) for text in blocks(ROOT / "docs" / "exchange.md", "json")]
    situation, spatial, chain, pick = map(situation_from_json, examples)
    assert (situation.name, spatial.name, chain.name) == ("ball-and-post", "nao-1", "reach")
    assert pick.end == "rest" and pick.targets[0].place.within == 0.02
    assert spatial.is_spatial and not situation.is_spatial
    caught = solve(situation, "layered")
    first_arrival = [solve(situation, name) for name in ("gcm", "marching")]
    assert caught.caught and not any(plan.caught for plan in first_arrival), "as the limits say"
    text = (ROOT / "docs" / "exchange.md").read_text("utf-8").split("## Solution")[1]
    listed = set(re.findall(r"`([a-z_]+)`", text))
    assert set(plan_to_json(caught, situation)) - {"format"} <= listed


def test_planners_and_commands_are_listed():
    assert sorted(first_column(PLANNERS, "Planners")) == sorted(planner_names())
    for row, name in zip(first_column(COMMAND_LINE, "Commands"), COMMANDS, strict=True):
        assert f"{row} ".startswith(f"gcm-learn {name} ")
    text = COMMAND_LINE.read_text("utf-8")
    assert dict(re.findall(r"^\| `(\S+)` \| `([^`]+)` \|$", text, re.M)) == OLD


def test_families_are_told_and_their_example_runs():
    path = ROOT / "docs" / "families.md"
    section = path.read_text("utf-8").split("## Families\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (`.*`) \|", section, re.M)
    told = [name for row in rows for name in re.findall(r"`([^`]+)`", row)]
    assert sorted(told) == sorted(family_names())
    (example,) = blocks(path, "python")
    *lines, last = example.splitlines()
    scope: dict = {}
    exec(compile("\n".join(lines), str(path), "exec"), scope)
    assert eval(last, scope) is True and scope["situation"].name == "gate-0000042"


@pytest.mark.parametrize(
    ("kind", "file"),
    [("planar", "table.md"), ("spatial", "table-space.md"), ("chain", "table-chain.md")],
)
def test_measured_families_are_those_of_the_experiment(kind, file):
    made_by, table = (
        (ROOT / "experiments" / "answered" / "03_families" / file)
        .read_text("utf-8")
        .split("\n\n", 1)
    )
    assert made_by.startswith("Measured by the code of commit")
    assert table in (ROOT / "docs" / "families.md").read_text("utf-8")
    named = re.findall(r"^\| ([a-z]+-[a-z-]+|[a-z]+) \| \d", table, re.M)
    assert named and set(named) <= set(family_names(kind))


def test_tables_that_an_experiment_s_page_shows_are_those_of_its_results():
    for page in (ROOT / "experiments").glob("[0-9]*/README.md"):
        told = [(head, cells[:-1]) for head, cells in rows(page.read_text("utf-8"))]
        for file in {*page.parent.glob("*.md")} - {page}:
            kept = [(head, cells[:-1]) for head, cells in rows(file.read_text("utf-8"))]
            heads = [head for head, _ in kept]
            assert [row for row in told if row[0] in heads and row not in kept] == [], page


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: str(p.relative_to(ROOT)))
def test_make_targets_exist(path):
    known = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.M)
    named = re.findall(r"^make ([a-z-]+)|`make ([a-z-]+)`", path.read_text("utf-8"), re.M)
    assert {a or b for a, b in named} <= set(known)


def test_architecture_names_every_folder_and_calls_only_missing_ones_planned():
    rows = re.findall(
        r"^\| `gcm_learn/([a-z]+)/`( \(planned\))?", ARCHITECTURE.read_text("utf-8"), re.M
    )
    named = {folder: bool(planned) for folder, planned in rows}
    there = {p.parent.name for p in (ROOT / "gcm_learn").glob("*/__init__.py")}
    assert {folder for folder, planned in named.items() if not planned} == there


def test_architecture_and_contributing_tell_the_enforced_order():
    config = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    (direction,) = [
        contract
        for contract in config["tool"]["importlinter"]["contracts"]
        if contract["id"] == "direction"
    ]
    enforced = [re.findall(r"[a-z]+", layer) for layer in direction["layers"]]
    for path in (ARCHITECTURE, ROOT / "CONTRIBUTING.md"):
        (told,) = re.findall(r"cli\s+>[\sa-z>,]+seeding", path.read_text("utf-8"))
        assert [re.findall(r"[a-z]+", layer) for layer in told.split(">")] == enforced, path


def test_cited_errata_are_listed():
    listed = re.findall(r"^(\d+)\. ", (ROOT / "docs" / "errata.md").read_text("utf-8"), re.M)
    assert listed == [str(k) for k in range(1, len(listed) + 1)]
    sources = (p for p in (ROOT / "gcm_learn").rglob("*.py"))
    cited = {
        number
        for p in sources
        for number in re.findall(r"errat(?:um|a) (\d+)", p.read_text("utf-8"))
    }
    assert cited and cited <= set(listed)
