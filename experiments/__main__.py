"""Run an experiment from the repository's root.

python -m experiments                            list the experiments and their questions
python -m experiments 05_recall [options]        05_recall/run.py
python -m experiments 05_recall/arms --help      another script of the folder
python -m experiments recompute                  all tables that outcomes of situations give
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

from experiments.recompute import answered
from gcm_learn.errors import GcmError, not_among

HERE = Path(__file__).resolve().parent
STARTS = '__name__ == "__main__"'


def scripts() -> dict[str, Path]:
    """Return the scripts that can be run, by name: a folder's `run.py` by that of its folder."""
    found = sorted([*HERE.glob("[!_]*.py"), *HERE.glob("*/*.py")])
    return {name_of(path): path for path in found if STARTS in path.read_text("utf-8")}


def name_of(script: Path) -> str:
    """Return the name by which a script is run."""
    name = script.relative_to(HERE).with_suffix("")
    return (name.parent if name.stem == "run" else name).as_posix()


def question(folder: Path) -> str:
    """Return the title of a folder's README."""
    return (folder / "README.md").read_text("utf-8").split("\n", 1)[0].removeprefix("# ")


def listed() -> str:
    """Return a line for each script, a folder's with its question, and each answered experiment."""
    names = scripts()
    wide = max(map(len, names))
    lines = [
        f"{n:{wide}}  {question(p.parent) if p.stem == 'run' else ''}" for n, p in names.items()
    ]
    return "\n".join([*(line.rstrip() for line in sorted(lines)), *answered().values()])


def main(words: list[str]) -> None:
    """Run a script with the words that follow its name."""
    if not words or words[0] in ("-h", "--help"):
        print(f"{__doc__}\n{listed()}" if words else listed())
        return
    known, archived = scripts(), answered()
    if words[0] in archived:
        sys.exit(archived[words[0]])
    if words[0] not in known:
        sys.exit(not_among(words[0], known))
    script = known[words[0]]
    sys.path.insert(0, str(script.parent))  # its neighbours, which it imports by name
    sys.argv = [str(script), *words[1:]]
    try:
        runpy.run_path(str(script), run_name="__main__")
    except GcmError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main(sys.argv[1:])
