"""Where compiled kernels are kept."""

from __future__ import annotations

import os
import shutil
import textwrap
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numba
import pytest

from gcm_learn import compiled


def test_many_who_save_at_once_lose_nothing(tmp_path):
    """Threads stand for processes: each opens the lock and the files for itself."""
    keys = [f"signature {k}" for k in range(60)]

    def save(key):
        compiled._CacheFile(str(tmp_path), "kernel", "stamp").save(key, f"code of {key}")

    with ThreadPoolExecutor(6) as pool:
        list(pool.map(save, keys))
    cache = compiled._CacheFile(str(tmp_path), "kernel", "stamp")
    assert [cache.load(key) for key in keys] == [f"code of {key}" for key in keys]


def test_a_folder_that_cannot_be_is_said_by_saving_itself(tmp_path):
    (tmp_path / "file").touch()
    inside = compiled._CacheFile(str(tmp_path / "file"), "kernel", "stamp")
    with pytest.raises(OSError, match="kernel") as error:
        inside.save("signature", "code")
    assert compiled.LOCK not in str(error.value) and (tmp_path / "file").is_file()


@pytest.fixture
def ours(tmp_path, monkeypatch):
    """A function of the package, and the folder in which code is kept."""
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(doubled, "__module__", "gcm_learn.wave.doubled")
    return doubled, tmp_path


def test_who_listens_is_told_once_that_code_is_compiled(ours, monkeypatch):
    told, kept = [], []  # numba finds what belongs to a module that is none while it lives
    monkeypatch.setattr(compiled, "PATIENCE", 0.0)
    for x, expected in ((2, ["first"]), (3, ["first"]), (0.5, ["first", "third"])):
        monkeypatch.setattr(compiled, "on_compile", [])
        compiled.on_compile.append(lambda: told.append("first" if len(told) == 0 else "third"))
        kept.append(compiled.njit(doubled))
        assert kept[-1](x) == 2 * x and told == expected
        assert len(compiled.on_compile) == (0 if x != 3 else 1)  # the second finds the first's


def test_compiling_is_announced_when_it_takes_its_time(monkeypatch, capsys):
    monkeypatch.setattr(compiled, "on_compile", [compiled.say_compiling])
    monkeypatch.setattr(compiled, "_missed", [])
    compiled._tell_listeners()
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(compiled, "PATIENCE", 0.0)
    compiled._tell_listeners()
    compiled._tell_listeners()
    assert capsys.readouterr().err == f"{compiled.NOTICE}\n"


def doubled(x):
    return x + x


def test_what_calls_a_function_links_a_part_of_it(ours):
    """The part is no code for Python; both are kept, and found by another process's functions."""
    function, folder = ours
    for found in (False, True):
        inner = compiled.njit(function)

        @numba.njit
        def outer(x, inner=inner):
            return inner(x) + 1

        assert outer(2) == 5 and not inner.overloads
        assert bool(inner._part.stats.cache_hits) == found
    assert inner(2) == 4 and inner.signatures == inner._part.signatures
    assert sorted(path.name[:5] for path in folder.rglob("*.nbc")) == ["part-", "test_"]


def halved(x):
    if x < 0:
        raise ValueError("below zero", x)
    return x / 2


def test_errors_of_parts_name_their_numbers(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    for function in (halved, quartered):
        monkeypatch.setattr(function, "__module__", "gcm_learn.wave.halved")
    kept = []  # as above
    for _ in range(2):
        half = compiled.njit(halved)
        monkeypatch.setitem(globals(), "half", half)
        quarter = compiled.njit(quartered)
        kept.append((half, quarter))
        assert quarter(2) == 0.5
        with pytest.raises(ValueError, match="below zero") as error:
            quarter(-3)
        assert error.value.args == ("below zero", -3)


def quartered(x):
    return half(x) / 2  # noqa: F821 -- set by the test


def test_numba_itself_is_left_as_it_is():
    plain = numba.njit(cache=True)(lambda x: x)
    assert type(plain._cache) is numba.core.caching.FunctionCache


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Three modules: a imports b inside brackets, b a constant of c."""
    package = tmp_path / "gcm_learn"
    (package / "wave").mkdir(parents=True)
    for name, text in {
        "a": "from gcm_learn.wave import (\n    b as other,\n)",
        "b": "import math\nfrom gcm_learn.wave.c import ONE",
        "c": "ONE = 1",
        "d": "ALONE = 1",
    }.items():
        (package / "wave" / f"{name}.py").write_text(textwrap.dedent(text))
    monkeypatch.setattr(compiled, "PACKAGE", package)
    _forget()
    yield package
    _forget()


def _forget():
    hashes = (compiled.source_hash, compiled.is_edited)
    for function in (*hashes, compiled._sources_of, compiled._path_of, compiled._imports_of):
        function.cache_clear()


@pytest.mark.parametrize(
    ("changed", "renewed"), [("a", "a"), ("b", "ab"), ("c", "abc"), ("d", "d")]
)
def test_a_change_renews_what_depends_on_it_and_nothing_else(package, changed, renewed):
    before = {name: compiled.source_hash(f"gcm_learn.wave.{name}") for name in "abcd"}
    with open(package / "wave" / f"{changed}.py", "a") as stream:
        stream.write("\nMORE = 2\n")
    _forget()
    after = {name: compiled.source_hash(f"gcm_learn.wave.{name}") for name in "abcd"}
    assert "".join(name for name in "abcd" if before[name] != after[name]) == renewed


def test_code_is_kept_where_numba_is_told_to_keep_it(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    assert compiled.folder() == tmp_path
    monkeypatch.setattr(compiled.config, "CACHE_DIR", "")
    assert compiled.PACKAGE not in compiled.folder().parents


@pytest.mark.parametrize(("changed", "edited"), [("a", "a"), ("b", "ab"), ("c", "abc"), ("d", "d")])
def test_code_of_sources_that_change_meanwhile_is_not_kept(package, monkeypatch, changed, edited):
    """A process may hold the old text in memory, and the hash is that of the new one."""
    files = {name: package / "wave" / f"{name}.py" for name in "abcd"}
    monkeypatch.setattr(compiled, "STARTED", 1000.0)
    for name, file in files.items():
        os.utime(file, (2000.0, 2000.0) if name == changed else (500.0, 500.0))
    assert "".join(n for n in "abcd" if compiled.is_edited(f"gcm_learn.wave.{n}")) == edited


def test_edited_functions_are_compiled_and_leave_nothing(ours, monkeypatch):
    monkeypatch.setattr(compiled, "is_edited", lambda module: True)
    assert compiled.njit(doubled)(2) == 4 and not list(ours[1].iterdir())


class Theirs(NamedTuple):
    """A limb of a module outside of the package."""

    length: float


class Around(NamedTuple):
    """What holds it."""

    inner: tuple[int, Theirs]


class Ours(NamedTuple):
    length: float


Ours.__module__ = "gcm_learn.arms.ours"


def repeated(limb):
    return limb


@pytest.mark.parametrize(
    ("limb", "kept"),
    [
        (Ours(1.0), True),
        ((1, Ours(1.0)), True),
        (Theirs(1.0), False),
        (Around((1, Theirs(1.0))), False),
        ((1, (2, Theirs(1.0))), False),
    ],
)
def test_code_for_limbs_of_other_modules_is_not_kept(ours, limb, kept):
    function, folder = ours
    repeated.__module__ = function.__module__
    assert compiled.njit(repeated)(limb) == limb
    assert bool(list(folder.rglob("*.nbc"))) == kept


def test_code_of_other_modules_is_not_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    assert compiled.njit(lambda x: x + 1)(2) == 3 and not list(tmp_path.iterdir())


SEAM = "gcm_learn.arms.limbs"
BEHIND = ("arms/chain_limb.py", "arms/spatial_limb.py", "arms/tree_limb.py", "arms/curves.py")


def _kernels_at_the_seam():
    """Modules of the package that import the seam and compile something."""
    for path in sorted(compiled.PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if f"from {SEAM} import" in text and "@njit" in text:
            yield ".".join(("gcm_learn", *path.relative_to(compiled.PACKAGE).with_suffix("").parts))


@pytest.mark.parametrize("changed", BEHIND)
def test_a_change_behind_the_seam_renews_all_kernels_before_it(tmp_path, monkeypatch, changed):
    modules = list(_kernels_at_the_seam())
    assert "gcm_learn.collision.postures" in modules and len(modules) > 5
    before = {name: compiled.source_hash(name) for name in (*modules, "gcm_learn.seeding")}
    package = tmp_path / "gcm_learn"
    shutil.copytree(
        compiled.PACKAGE, package, ignore=shutil.ignore_patterns("*.json", "__pycache__")
    )
    with open(package / changed, "a") as stream:
        stream.write("\nMORE = 2\n")
    monkeypatch.setattr(compiled, "PACKAGE", package)
    _forget()
    same = [name for name, stamp in before.items() if compiled.source_hash(name) == stamp]
    _forget()
    assert same == ["gcm_learn.seeding"]
