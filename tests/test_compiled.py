"""Where compiled kernels are kept."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import NamedTuple

import numba
import pytest
from numba.core.registry import cpu_target

from gcm_learn import compiled
from gcm_learn.compiled import cache, notice, sources
from gcm_learn.seeding import rng

CODEGEN = cpu_target.target_context.codegen()


def test_many_who_save_at_once_lose_nothing(ours):
    """Threads stand for processes: each opens the files for itself. All save everything."""
    function, folder = ours
    keys = [f"type {k}" for k in range(20)]
    place = cache.Place(folder, CODEGEN.magic_tuple())

    def save(key):
        kept, library = cache.Cache(function), SimpleNamespace(has_dynamic_globals=False)
        made = SimpleNamespace(library=library, codegen=CODEGEN, _reduce=lambda: f"code of {key}")
        kept.save_overload((key,), made)
        return cache._read(kept._file(place, (key,)))

    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(save, 3 * keys))
    assert found == 3 * [f"code of {key}" for key in keys]
    kept = cache.Cache(function)
    assert [cache._read(kept._file(place, (key,))) for key in keys] == found[:20]
    kept.flush()
    assert not kept_files(ours)


@pytest.fixture
def ours(tmp_path, monkeypatch):
    """A function of the package, and the folder in which code is kept."""
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(doubled, "__module__", "gcm_learn.wave.doubled")
    return doubled, tmp_path


def test_who_listens_is_told_once_that_code_is_compiled(ours, monkeypatch):
    told, kept = [], []  # numba finds what belongs to a module that is none while it lives
    monkeypatch.setattr(notice, "PATIENCE", 0.0)
    for x, expected in ((2, ["first"]), (3, ["first"]), (0.5, ["first", "third"])):
        monkeypatch.setattr(notice, "on_compile", [])
        notice.on_compile.append(lambda: told.append("first" if len(told) == 0 else "third"))
        kept.append(compiled.njit(doubled))
        assert kept[-1](x) == 2 * x and told == expected
        assert len(notice.on_compile) == (0 if x != 3 else 1)  # the second finds the first's


def test_compiling_is_announced_when_it_takes_its_time(monkeypatch, capsys):
    monkeypatch.setattr(notice, "on_compile", [notice.say_compiling])
    monkeypatch.setattr(notice, "_missed", [])
    notice.tell_listeners()
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(notice, "PATIENCE", 0.0)
    notice.tell_listeners()
    notice.tell_listeners()
    assert capsys.readouterr().err == f"{notice.NOTICE}\n"


def test_the_notice_is_no_promise_for_other_arms():
    for words in ("this kind of arm and planner", "minute", "another", "again"):
        assert words in notice.NOTICE
    assert "later runs" not in notice.NOTICE


def test_a_place_that_cannot_be_written_to_is_named_with_the_way_out(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(tmp_path / "kernels"))
    notice.say_compiling()
    assert capsys.readouterr().err == f"{notice.NOTICE}\n"
    (tmp_path / "file").touch()
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(tmp_path / "file"))
    notice.say_compiling()
    said, unkept = capsys.readouterr().err.splitlines()
    assert said == notice.NOTICE
    assert f"cannot be kept in {tmp_path / 'file'} (" in unkept and "every run" in unkept
    assert "NUMBA_CACHE_DIR" in unkept


def doubled(x):
    return x + x


def answers(ours, x):
    """Call the function as a new process would; return what was compiled."""
    made = compiled.njit(ours[0])
    assert made(x) == 2 * x
    KEPT.append(made)  # numba finds what belongs to a module that is none while it lives
    return sum(made.stats.cache_misses.values())


KEPT: list[object] = []


def kept_files(ours):
    return sorted(ours[1].rglob("*.nb*"))


def emptied(path):
    path.write_bytes(b"")


def cut(path):
    path.write_bytes(path.read_bytes()[:-7])


def flipped(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def garbage(path):
    path.write_bytes(b"junk" * 100)


def unknown(path):
    """Code that names a module which is not there."""
    code = b"cgcm_learn.arms.newer_limb\nNewer\n."
    path.write_bytes(cache._checksum(path, code) + code)


def in_the_way(path):
    path.unlink()
    path.mkdir()


def gone(path):
    shutil.rmtree(path.parent, ignore_errors=True)


@pytest.mark.parametrize(
    "damage", [emptied, cut, flipped, garbage, unknown, in_the_way, gone], ids=lambda f: f.__name__
)
def test_damaged_code_is_compiled_and_kept_anew(ours, damage):
    assert answers(ours, 2) == 1 and answers(ours, 2) == 0
    for path in kept_files(ours):
        damage(path)
    assert answers(ours, 2) == 1
    assert answers(ours, 2) == (damage is in_the_way)


def test_code_in_the_file_of_other_code_is_compiled_anew(ours):
    assert answers(ours, 2) == 1 and answers(ours, 0.5) == 1
    one, other = kept_files(ours)
    swapped = other.read_bytes(), one.read_bytes()
    one.write_bytes(swapped[0])
    other.write_bytes(swapped[1])
    assert answers(ours, 2) == 1 and answers(ours, 0.5) == 1


@pytest.mark.parametrize("times", [8, pytest.param(200, marks=pytest.mark.slow)])
def test_caches_damaged_at_random_do_not_stop(ours, times):
    """Some bytes of a file change, or its end goes, or all of it."""
    draws = rng(42)
    for _ in range(times):
        answers(ours, 2)
        for path in kept_files(ours):
            data = bytearray(path.read_bytes())
            for place in draws.integers(len(data), size=int(draws.integers(4))):
                data[place] ^= int(draws.integers(1, 256))
            path.write_bytes(data[: int(draws.choice([len(data), draws.integers(len(data))]))])
        answers(ours, 2)


def full(*_, **__):
    raise OSError(errno.ENOSPC, "No space left on device")


def denied(*_, **__):
    raise PermissionError(errno.EACCES, "Permission denied")


@pytest.mark.parametrize("failure", [full, denied])
@pytest.mark.parametrize("step", ["mkdir", "read_bytes", "write_bytes"])
def test_a_folder_without_rights_or_room_does_not_stop(ours, monkeypatch, step, failure):
    assert answers(ours, 2) == 1
    with monkeypatch.context() as broken:
        broken.setattr(type(ours[1]), step, failure)
        assert answers(ours, 2) == (step == "read_bytes")
        assert answers(ours, 0.5) == 1
        assert answers(ours, 0.5) == 1  # again
    assert answers(ours, 2) == 0


def test_a_file_in_place_of_the_folder_does_not_stop(ours, monkeypatch):
    (ours[1] / "file").touch()
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(ours[1] / "file"))
    assert answers(ours, 2) == 1 and answers(ours, 2) == 1


CHECKOUT = """
from types import SimpleNamespace
from typing import NamedTuple
from gcm_learn.compiled import njit
from gcm_learn.arms import kernel
class Limb(NamedTuple):
    length: float
    width: float
def use():
    print(kernel.length(Limb(3.0, 4.0)), *kernel.length.stats.cache_hits.values())
"""
KERNEL = """
from gcm_learn.compiled import njit
@njit
def length(limb):
    return limb.length
"""


def test_checkouts_share_code_and_do_not_stop_each_other(tmp_path):
    """The second has no module of the first's limb, the third another order of its fields."""
    limbs = {"newer": ("one", CHECKOUT), "older": ("two", CHECKOUT), "same": ("two", CHECKOUT)}
    limbs["other"] = (
        "two",
        CHECKOUT.replace("length: float\n    width", "width: float\n    length"),
    )
    files = ("storage", "errors", "checks", "late")
    said = {}
    for name, (module, text) in limbs.items():
        package = tmp_path / name / "gcm_learn"
        (package / "arms").mkdir(parents=True)
        for file in files:
            shutil.copy(sources.PACKAGE / f"{file}.py", package)
        shutil.copytree(sources.PACKAGE / "compiled", package / "compiled")
        (package / "__init__.py").touch()
        (package / "arms" / "__init__.py").touch()
        (package / "arms" / "kernel.py").write_text(KERNEL)
        (package / "arms" / f"{module}.py").write_text(text)
        for path in package.rglob("*.py"):
            os.utime(path, (1000.0, 1000.0))
        where = {"PYTHONPATH": str(tmp_path / name), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        done = subprocess.run(
            [sys.executable, "-c", f"from gcm_learn.arms import {module}; {module}.use()"],
            cwd=tmp_path, env=os.environ | where, capture_output=True, text=True, check=True,
        )  # fmt: skip
        said[name] = done.stdout.split()
    assert said == {"newer": ["3.0"], "older": ["3.0"], "same": ["3.0", "1"], "other": ["4.0"]}


@pytest.fixture
def shipped(ours, tmp_path, monkeypatch):
    """The function's code as an installed package has it, and the user's folder empty."""
    assert answers(ours, 2) == 1
    package = tmp_path / "site" / cache.KERNELS
    shutil.copytree(ours[1], package / "kernels", ignore=shutil.ignore_patterns("site"))
    (package / "__init__.py").touch()
    (package / "kernels" / cache.MADE_FOR).write_text(json.dumps(MACHINE))
    monkeypatch.syspath_prepend(package.parent)
    empty = tmp_path / "empty"
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(empty))
    cache.ahead.cache_clear()
    yield package / "kernels" / cache.MADE_FOR, empty
    cache.ahead.cache_clear()


MACHINE = CODEGEN.magic_tuple()


def test_code_that_was_compiled_ahead_is_found_and_nothing_is_written(ours, shipped):
    assert answers(ours, 2) == 0 and not shipped[1].exists()
    assert answers(ours, 0.5) == 1 and shipped[1].exists()


def test_code_that_was_compiled_ahead_stands_in_for_damaged_code(ours, shipped):
    shutil.copytree(shipped[0].parent, shipped[1])
    for path in shipped[1].rglob("*.nbc"):
        cut(path)
    assert answers(ours, 2) == 0


@pytest.mark.parametrize(
    "told", ["", "[]", json.dumps([*MACHINE[:2], "+none"]), json.dumps(["none", *MACHINE[1:]])]
)
def test_code_for_other_processors_is_left_alone(ours, shipped, told):
    shipped[0].write_text(told)
    assert answers(ours, 2) == 1


def test_code_for_this_processor_alone_can_be_asked_for(ours, shipped, monkeypatch):
    monkeypatch.setenv("GCM_LEARN_NATIVE", "1")
    assert answers(ours, 2) == 1


@pytest.mark.skipif(not compiled.INSIDE, reason="there are no parts")
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
    assert sorted(path.name[:5] for path in folder.rglob("*.nbc")) == ["doubl", "part-"]


def halved(x):
    if x < 0:
        raise ValueError("below zero", x)
    return x / 2


def test_errors_of_parts_name_their_numbers(monkeypatch, tmp_path):
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(tmp_path))
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
    monkeypatch.setattr(sources, "PACKAGE", package)
    _forget()
    yield package
    _forget()


def _forget():
    hashes = (sources.source_hash, sources.is_edited)
    for function in (*hashes, sources._sources_of, sources._path_of, sources._imports_of):
        function.cache_clear()


@pytest.mark.parametrize(
    ("changed", "renewed"), [("a", "a"), ("b", "ab"), ("c", "abc"), ("d", "d")]
)
def test_a_change_renews_what_depends_on_it_and_nothing_else(package, changed, renewed):
    before = {name: sources.source_hash(f"gcm_learn.wave.{name}") for name in "abcd"}
    with open(package / "wave" / f"{changed}.py", "a") as stream:
        stream.write("\nMORE = 2\n")
    _forget()
    after = {name: sources.source_hash(f"gcm_learn.wave.{name}") for name in "abcd"}
    assert "".join(name for name in "abcd" if before[name] != after[name]) == renewed


def test_code_is_kept_where_numba_is_told_to_keep_it(tmp_path, monkeypatch):
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(tmp_path))
    assert notice.folder() == tmp_path
    monkeypatch.setattr(notice.config, "CACHE_DIR", "")
    assert sources.PACKAGE not in notice.folder().parents


@pytest.mark.parametrize(("changed", "edited"), [("a", "a"), ("b", "ab"), ("c", "abc"), ("d", "d")])
def test_code_of_sources_that_change_meanwhile_is_not_kept(package, monkeypatch, changed, edited):
    """A process may hold the old text in memory, and the hash is that of the new one."""
    files = {name: package / "wave" / f"{name}.py" for name in "abcd"}
    monkeypatch.setattr(sources, "STARTED", 1000.0)
    for name, file in files.items():
        os.utime(file, (2000.0, 2000.0) if name == changed else (500.0, 500.0))
    assert "".join(n for n in "abcd" if sources.is_edited(f"gcm_learn.wave.{n}")) == edited


def test_edited_functions_are_compiled_and_leave_nothing(ours, monkeypatch):
    monkeypatch.setattr(cache, "is_edited", lambda module: True)
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
    monkeypatch.setattr(notice.config, "CACHE_DIR", str(tmp_path))
    assert compiled.njit(lambda x: x + 1)(2) == 3 and not list(tmp_path.iterdir())


AT_THE_SEAM = re.compile(r"^from gcm_learn\.arms(\.limbs import| import .*\blimbs\b)", re.M)
BEHIND = ("arms/chain_limb.py", "arms/spatial_limb.py", "arms/curves.py")


def _kernels_at_the_seam():
    """Modules of the package that call limbs and compile something."""
    for path in sorted(sources.PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if AT_THE_SEAM.search(text) and "@njit" in text:
            yield ".".join(("gcm_learn", *path.relative_to(sources.PACKAGE).with_suffix("").parts))


@pytest.mark.parametrize("changed", BEHIND)
def test_a_change_behind_the_seam_renews_all_kernels_before_it(tmp_path, monkeypatch, changed):
    modules = list(_kernels_at_the_seam())
    assert "gcm_learn.collision.postures" in modules and len(modules) > 5
    before = {name: sources.source_hash(name) for name in (*modules, "gcm_learn.seeding")}
    package = tmp_path / "gcm_learn"
    shutil.copytree(
        sources.PACKAGE, package, ignore=shutil.ignore_patterns("*.json", "__pycache__")
    )
    with open(package / changed, "a") as stream:
        stream.write("\nMORE = 2\n")
    monkeypatch.setattr(sources, "PACKAGE", package)
    _forget()
    same = [name for name, stamp in before.items() if sources.source_hash(name) == stamp]
    _forget()
    assert same == ["gcm_learn.seeding"]
