"""``gcm-learn demo``: the paper's results as a web page, single figures, files to begin with."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from gcm_learn.cli.failures import CommandFailure, say, why
from gcm_learn.cli.files import FORMATS, made_folder, require_suffix, staged
from gcm_learn.cli.options import Number, given
from gcm_learn.cli.warm_up import side_by_side
from gcm_learn.errors import UnknownNameError

PLACES = {
    "configurations of train policy": "experiments/04_policies/*.yml",
    "specifications of generate": "data/specs/*.toml",
    "what fields and columns mean": "data/README.md",
    "a dataset of 500 planar records": "data/sample",
    "situations": "data/suites/demo.jsonl",
    "notebooks, as scripts that jupytext opens": "docs/notebooks/*.py",
}

COMPILED = (
    ("search", ("crossing-swarm-space", 3, 5)),
    *((name, ("crossing-swarm", 3, 5)) for name in ("gcm", "marching", "search", "straight")),
)
"""Planners and examples that run what the page runs."""
FIGURES = (*(f"fig{k}" for k in range(1, 9)), "fig5-space", "fig8-space", "fig8-body")


@dataclass(frozen=True)
class Demo:
    """Solve the paper's scenes and random ones; write figures, films and a page that shows them.

    Or draw one figure of the paper, or copy a file that comes with the package.
    """

    figure: Annotated[str | None, given("NAME", "the page")] = None
    """draw only this figure, such as fig4 or fig8-space"""

    copy: Annotated[str | None, given("NAME", "the page")] = None
    """copy only this file or folder to begin with, such as train.toml; with or without its
    suffix"""

    list: bool = False
    """list the figures, and the files that can be copied"""

    out: Annotated[Path | None, given("PATH", "demo/, NAME.png, or the copy's name")] = None
    """folder for the page index.html and its pictures; of a figure a .png, .pdf or .svg file; of a
    copy its place"""

    seed: Number = 0
    """root of the random situations"""

    random: Number = 200
    """number of random situations"""

    def run(self) -> int:
        """List names, draw a figure, copy a file or build the page, as the options ask."""
        if self.list:
            names = {"figures of the paper": [*FIGURES]}
            names |= {title: [path.name for path in paths] for title, paths in _examples().items()}
            print("\n".join([f"{title}: {' '.join(found)}" for title, found in names.items()]))
        elif self.figure is not None:
            print(_drawn(self.figure, self.out))
        elif self.copy is not None:
            print(_copied(self.copy, self.out))
        else:
            folder = made_folder(self.out or Path("demo"), option="--out")
            from gcm_learn.compiled import on_first_compiling
            from gcm_learn.plots import build_demo

            on_first_compiling(_compile)
            page = build_demo(folder, self.seed, self.random, say)
            print(f"Open {page.resolve().as_uri()} in a browser.")
        return 0


def _compile() -> None:
    """Compile, in several processes, the kernels that the page needs."""
    say("compiling once for the arms of the page: one or two minutes on two cores")
    side_by_side(COMPILED)


def _drawn(name: str, out: Path | None) -> Path:
    """Draw a figure of the paper into a file and return the file's path."""
    if name not in FIGURES:
        raise UnknownNameError.among("figure", name, FIGURES)
    target = out or Path(f"{name}.png")
    require_suffix(target, FORMATS)
    from gcm_learn.plots import draw_figure

    with staged(target) as place:
        draw_figure(name).savefig(place)
    return target


def _copied(name: str, out: Path | None) -> Path:
    """Copy a file or folder that comes with the package; return the copy."""
    known = {path.name: path for paths in _examples().values() for path in paths}
    chosen = known.get(name) or {path.stem: path for path in known.values()}.get(name)
    if chosen is None:
        raise UnknownNameError.among("example", name, known)
    target = out or Path(chosen.name)
    if chosen.is_file():
        with staged(target) as place:
            shutil.copyfile(chosen, place)
        return target
    try:
        shutil.copytree(chosen, target, dirs_exist_ok=True)
    except OSError as error:
        raise CommandFailure(f"--out {target}: {why(error)}") from None
    return target


def _examples() -> dict[str, list[Path]]:
    """Return the files and folders that can be copied, by their headings."""
    from gcm_learn.artifacts import source

    return {title: sorted(source().glob(place)) for title, place in PLACES.items()}
