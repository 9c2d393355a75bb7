"""Build a wheel that carries the trained models, suites and examples beside the code.

They stay where they are in the repository, and are copied when the wheel is built. Everything else
about the package is in pyproject.toml.
"""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
SHIPPED = (
    *(
        f"models/{name}"
        for name in (
            *("clone", "encoder", "encoder-map", "encoder-map-panda"),
            *("ppo", "ppo-clone", "ppo-guide", "ppo-space"),
            *("recall", "recall-panda", "recall-space", "sac"),
        )
    ),
    "models/bodies",
    "data/suites/demo.jsonl",
    "data/benchmark",
    "data/sample",
    "data/specs",
    "data/README.md",
    "docs/notebooks",
)
CONFIGURATIONS = "experiments/04_policies"
NEEDED = {
    *(".gz", ".json", ".jsonl", ".md", ".npy", ".npz", ".parquet", ".py", ".safetensors", ".toml")
}
"""Suffixes of files that are shipped."""
TRAINING = {"state.json", "normalisation.npz", "buffer.npz"}
"""Names of files with which training goes on; they are not shipped."""
TARGET = Path("gcm_learn", "_shipped")


def shipped() -> list[Path]:
    """The files, relative to the repository."""
    found = []
    for name in SHIPPED:
        place = ROOT / name
        files = [place] if place.is_file() else place.rglob("*")
        found += [path.relative_to(ROOT) for path in files if path.suffix in NEEDED]
    found += [path.relative_to(ROOT) for path in (ROOT / CONFIGURATIONS).glob("*.yml")]
    return sorted(path for path in found if path.name not in TRAINING)


class WithModels(build_py):
    """Builds the package as always, then copies what is shipped; an editable one needs no copy."""

    def run(self) -> None:
        """Build."""
        super().run()
        if self.editable_mode:
            return
        for path in shipped():
            target = Path(self.build_lib, TARGET, path)
            self.mkpath(str(target.parent))
            self.copy_file(str(ROOT / path), str(target))


setup(cmdclass={"build_py": WithModels})
