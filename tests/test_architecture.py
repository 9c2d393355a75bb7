"""The rules of the house that a program can check."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import gcm_learn

ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "gcm_learn").rglob("*.py"))
LAYERS = """
    cli plots evaluation policies envs execution recall dataset families planners maps wave
    charts motion collision scene situation
""".split()

LONGEST_MODULE = 400
LONGEST_FUNCTION = 80


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run import-linter on the package in `folder`, with the contracts of pyproject.toml."""
    code = "import sys; from importlinter.cli import lint_imports_command; lint_imports_command()"
    command = [sys.executable, "-c", code, "--no-cache", "--config", str(ROOT / "pyproject.toml")]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_imports_go_one_way():
    done = lint_imports(ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def skeleton(tmp_path):
    """Return a package with all of our folders and nothing in them."""
    package = tmp_path / "gcm_learn"
    for layer in LAYERS:
        (package / layer).mkdir(parents=True)
        (package / layer / "__init__.py").touch()
    for module in (
        "__init__",
        "errors",
        "seeding",
        "compiled",
        "processes",
    ):
        (package / f"{module}.py").touch()
    return package


def test_contracts_accept_what_is_allowed(skeleton):
    (skeleton / "plots" / "maps.py").write_text("import matplotlib\nfrom gcm_learn import maps\n")
    (skeleton / "envs" / "viewer.py").write_text("import matplotlib.pyplot\nimport gymnasium\n")
    (skeleton / "recall" / "network.py").write_text("import torch.nn\n")
    done = lint_imports(skeleton.parent)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("wave/lattice.py", "from gcm_learn import maps"),
        ("situation/shapes.py", "import gcm_learn.planners.registry"),
        ("maps/cognitive_map.py", "def late():\n    import gcm_learn.planners"),
        ("scene/limb.py", "import matplotlib.pyplot"),
        ("cli/solve.py", "def late():\n    import matplotlib"),
        ("maps/path.py", "import torch"),
        ("evaluation/rollout.py", "import stable_baselines3"),
        ("planners/gcm.py", "import gymnasium"),
        ("errors.py", "from gcm_learn import seeding"),
        ("shelf/__init__.py", ""),
    ],
)
def test_contracts_refuse_what_is_not(skeleton, module, line):
    (skeleton / "planners" / "registry.py").touch()
    (skeleton / module).parent.mkdir(exist_ok=True)
    (skeleton / module).write_text(line + "\n")
    done = lint_imports(skeleton.parent)
    assert done.returncode == 1 and "BROKEN" in done.stdout, done.stdout + done.stderr


EXTRAS = {
    "gcm_learn": "torch gymnasium matplotlib stable_baselines3 pyarrow dask",
    "gcm_learn.plots": "torch gymnasium stable_baselines3 pyarrow dask faiss",
    "gcm_learn.recall": "torch safetensors pyarrow dask faiss gymnasium matplotlib",
    "gcm_learn.execution, gcm_learn.cli": "mujoco",
}
"""Libraries that imports do not load."""


@pytest.mark.parametrize("names", EXTRAS)
def test_imports_load_no_heavy_library(names):
    loaded = f"print(*sorted({set(EXTRAS[names].split())} & set(sys.modules)))"
    code = [sys.executable, "-c", f"import sys, {names}; {loaded}"]
    done = subprocess.run(code, cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("name", getattr(gcm_learn, "__all__", []))
def test_public_name_has_a_docstring(name):
    thing = getattr(gcm_learn, name)
    if inspect.isclass(thing) or inspect.isroutine(thing) or inspect.ismodule(thing):
        assert thing.__doc__ and not thing.__doc__.startswith(f"{name}("), "no docstring of its own"


def test_public_names_are_listed():
    assert 5 <= len(gcm_learn.__all__) <= 25
    assert len(set(gcm_learn.__all__)) == len(gcm_learn.__all__)


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT)))
def test_module_and_functions_are_short(path):
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    assert ast.get_docstring(tree) or not text.strip(), "a module begins by saying what it is for"
    lines = text.count("\n")
    assert lines <= LONGEST_MODULE
    lengths = {f.name: body_length(f) for f in functions(tree)}
    assert {name: n for name, n in lengths.items() if n > LONGEST_FUNCTION} == {}


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT)))
def test_what_numba_does_not_compile_is_annotated(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    compiled = [f for f in functions(tree) if is_compiled(f)]
    inside = {inner for f in compiled for inner in functions(f)}
    assert [f.name for f in functions(tree) if f not in inside and not is_annotated(f)] == []


def functions(tree: ast.AST) -> list[ast.FunctionDef]:
    """Return all functions and methods in `tree`, itself included."""
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def is_compiled(function: ast.FunctionDef) -> bool:
    """Return whether numba compiles the function: ``@njit``, ``@njit(...)``, ``@by_limb``."""
    names = [ast.unparse(decorator) for decorator in function.decorator_list]
    return any("jit" in name or "by_limb" in name for name in names)


def is_annotated(function: ast.FunctionDef) -> bool:
    """Return whether all arguments but self and cls, and the result, have a type."""
    a = function.args
    arguments = [*a.posonlyargs, *a.args, *a.kwonlyargs, a.vararg, a.kwarg]
    named = [x for x in arguments if x is not None and x.arg not in ("self", "cls")]
    return function.returns is not None and all(x.annotation is not None for x in named)


def body_length(function: ast.FunctionDef) -> int:
    """Return the number of lines of a function, without its docstring."""
    first = function.body[0]
    documented = ast.get_docstring(function) is not None
    docstring = (first.end_lineno or 0) - first.lineno + 1 if documented else 0
    return (function.end_lineno or 0) - function.lineno + 1 - docstring


def test_the_rulers_measure():
    source = '''
@njit(cache=True)
def f(a, b):
    """One.

    Two.
    """
    x = a
    return x

def g(a: int, *rest) -> int: ...
def h(self, a: int, *rest: int) -> int: ...
'''
    f, g, h = functions(ast.parse(source))
    assert body_length(f) == 3
    assert [is_compiled(x) for x in (f, g, h)] == [True, False, False]
    assert [is_annotated(x) for x in (f, g, h)] == [False, False, True]
