"""What a wheel carries: the code, the models and the smallest suite, and nothing else."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from gcm_learn import artifacts, compiled
from gcm_learn.cli.demo import PLACES
from gcm_learn.evaluation import FROZEN, SHIPPED

ROOT = Path(__file__).parents[1]
LARGEST = 31e6  # bytes
SOURCES = (
    *("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE", "models", "data"),
    *("docs/notebooks", "experiments/04_policies"),
)
ACTORS = ("clone", "ppo", "ppo-clone", "ppo-guide", "sac")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel of this checkout, built from a copy of it."""
    copy = tmp_path_factory.mktemp("copy")
    shutil.copytree(
        ROOT / "gcm_learn", copy / "gcm_learn", ignore=shutil.ignore_patterns("__pycache__")
    )
    for name in SOURCES:
        if (ROOT / name).is_dir():
            big = shutil.ignore_patterns("train", "cache", "tensorboard", "*.zip", "buffer.npz")
            shutil.copytree(ROOT / name, copy / name, ignore=big, dirs_exist_ok=True)
        else:
            shutil.copy(ROOT / name, copy / name)
    for name in ("model.zip", "normalisation.npz"):
        (copy / "models" / "clone" / name).write_bytes(b"what training needs to go on")
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--quiet"]
    subprocess.run([*command, "--wheel-dir", copy / "wheel", copy], check=True)
    return next((copy / "wheel").glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The wheel, laid out as it is when it is installed."""
    site = tmp_path_factory.mktemp("site")
    zipfile.ZipFile(wheel).extractall(site)
    return site


def test_it_is_small_and_has_what_is_asked_for_by_name(wheel):
    assert wheel.stat().st_size < LARGEST
    names = zipfile.ZipFile(wheel).namelist()
    carried = {Path(name).relative_to("gcm_learn/_shipped") for name in names if "_shipped" in name}
    wanted = {Path("models", name, "actor.npz") for name in ACTORS}
    wanted.add(Path("models/ppo-space/actor3d.npz"))
    wanted |= {Path("models/recall/manifest.json"), Path("models/encoder/encoder.safetensors")}
    wanted |= {Path("models", f"encoder-map{one}", "keys.npz") for one in ("", "-panda")}
    wanted |= {Path("models", f"recall-{name}", "manifest.json") for name in ("space", "panda")}
    wanted |= {Path("data", suite.file) for suite in SHIPPED.values()}
    assert wanted | {Path("data/suites/demo.jsonl")} <= carried
    assert all((ROOT / path).is_file() for path in carried)
    assert "gcm_learn/play/pages/index.html" in names
    assert ".zip" not in {path.suffix for path in carried}
    examples = {path for pattern in PLACES.values() for path in ROOT.glob(pattern)}
    files = {inner for path in examples for inner in (path.rglob("*") if path.is_dir() else [path])}
    assert {path.relative_to(ROOT) for path in files if path.is_file()} <= carried
    assert "normalisation.npz" not in {path.name for path in carried}
    code = {path.relative_to(ROOT).as_posix() for path in (ROOT / "gcm_learn").rglob("*.py")}
    notebooks = {path.as_posix() for path in carried if path.suffix == ".py"}
    assert code == {name for name in names if name.endswith(".py")} - {
        f"gcm_learn/_shipped/{name}" for name in notebooks
    }


def test_it_is_carried_unchanged(installed):
    for kind in ("models", "data"):
        folder = installed / "gcm_learn" / artifacts.IN_WHEEL / kind
        for path in (path for path in folder.rglob("*") if path.is_file()):
            assert path.read_bytes() == (ROOT / kind / path.relative_to(folder)).read_bytes()


def test_an_installed_package_finds_it_and_writes_elsewhere(installed, tmp_path):
    code = f"""
import gcm_learn
from gcm_learn import artifacts
from gcm_learn.evaluation import cases
from gcm_learn.policies.actor import actor_names, shipped_actor
from gcm_learn.recall import shipped_memory
assert gcm_learn.__file__.startswith({str(installed)!r})
assert artifacts.kept("data").is_relative_to({str(tmp_path)!r}), artifacts.kept("data")
assert len(shipped_memory("recall")) > 1000
assert actor_names() == {list(ACTORS)}
assert all(shipped_actor(name).layers for name in actor_names())
assert len(cases("demo", count={max(FROZEN["demo"])})) == {max(FROZEN["demo"])}
"""
    before = sorted(path for path in installed.rglob("*") if path.is_file())
    env = {name: text for name, text in os.environ.items() if not name.startswith("GCM_LEARN")}
    env |= {"PYTHONPATH": str(installed), "PYTHONDONTWRITEBYTECODE": "1"}
    env["NUMBA_CACHE_DIR"] = str(compiled.folder())  # the same sources, so the same kernels
    env |= dict.fromkeys(("XDG_DATA_HOME", "LOCALAPPDATA", "HOME"), str(tmp_path))
    subprocess.run([sys.executable, "-c", code], check=True, env=env, cwd=tmp_path)
    assert sorted(path for path in installed.rglob("*") if path.is_file()) == before
