"""Folders are entered by their doors, no files go round in circles, imports change nothing."""

from __future__ import annotations

import ast
import graphlib
import importlib
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "gcm_learn"
FOLDERS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
MIXED = {
    "gcm_learn.families.chain.stage",
    "gcm_learn.arms.limbs",
    "gcm_learn.arms.planar_limb",
    "gcm_learn.execution.body.plant",
    "gcm_learn.execution.loop.joint_leading",
    "gcm_learn.charts.lattice",
    "gcm_learn.motion.rules",
    "gcm_learn.motion.timing",
    "gcm_learn.planners.baselines.potential",
    "gcm_learn.planners.baselines.st_rrt_star_moves",
    "gcm_learn.planners.joints.straight",
    "gcm_learn.planners.baselines.st_rrt_star_joints",
    "gcm_learn.recall.headings",
    "gcm_learn.recall.waypoints",
    "gcm_learn.recall.growth",
    "gcm_learn.scene.packing",
}
"""Files that pass a door although fewer than half of their functions are kernels."""
BOTH_WAYS = {
    "gcm_learn.families.chain",
    "gcm_learn.families.space",
    "gcm_learn.planners.joints",
    "gcm_learn.scene.shapes",
}
"""Sub-folders that import files of their parent and are imported by them."""
MOST_PARAMETERS, MANY_PARAMETERS = 12, 8  # of a compiled function: none over, few over


def name_of(path: Path) -> str:
    """Return a file's name as a module."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def tree_of(module: str) -> ast.Module:
    """Return a module's source, parsed; once."""
    return ast.parse(MODULES[module].read_text("utf-8"))


@cache
def imports_of(module: str) -> list[tuple[str, str]]:
    """Return what a module takes from the package, wherever it does: (module, name)."""
    tree = tree_of(module)
    typing = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    return [
        (node.module, alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and id(node) not in typing
        for alias in node.names
        if node.module is not None and node.module.split(".")[0] == "gcm_learn"
    ]


def folder_of(module: str) -> str:
    """Return the folder of a module; empty for those that lie in none."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in FOLDERS else ""


@cache
def is_compiled(module: str) -> bool:
    """Return whether a module has kernels."""
    text = MODULES[module].read_text("utf-8")
    return folder_of(module) != "" and ("@njit" in text or "@by_limb" in text)


@cache
def is_kernel_file(module: str) -> bool:
    """Return whether at least half of a module's functions are kernels."""
    functions = [node for node in ast.walk(tree_of(module)) if isinstance(node, ast.FunctionDef)]
    kernels = [f for f in functions if any("njit" in ast.unparse(d) for d in f.decorator_list)]
    return folder_of(module) != "" and 0 < len(functions) <= 2 * len(kernels)


def passes(module: str, source: str) -> bool:
    """Return whether a module may import past a door: kernels from kernels."""
    return all(is_kernel_file(m) or (m in MIXED and is_compiled(m)) for m in (module, source))


def offers(folder: str) -> set[str]:
    """Return the names that the door of a folder defines or imports as themselves."""
    nodes = [n for top in tree_of(f"gcm_learn.{folder}").body for n in (top, *_inner(top))]
    names = {n.name for n in nodes if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    targets = [t for n in nodes if isinstance(n, ast.Assign) for t in n.targets]
    names |= {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}
    names |= {ast.unparse(n.target) for n in nodes if isinstance(n, ast.AnnAssign)}
    imported = [a for n in nodes if isinstance(n, ast.ImportFrom) for a in n.names]
    names |= {alias.name for alias in imported if alias.asname == alias.name}
    return {name for name in names if not name.startswith("_")}


def _inner(node: ast.stmt) -> list[ast.stmt]:
    """Return what a condition on type checking guards."""
    return node.body if isinstance(node, ast.If) else []


def test_mixed_files_are_still_mixed():
    """A file that has become one of kernels, or has none any more, leaves the list."""
    assert [m for m in sorted(MIXED) if m not in MODULES or is_kernel_file(m)] == []
    assert [m for m in sorted(MIXED) if not is_compiled(m)] == []


def test_files_of_a_folder_and_of_its_sub_folder_import_in_one_direction():
    """A front door, and so `__init__.py`, looks at both."""
    ways: dict[str, set[str]] = {}
    for module in MODULES:
        for source, _ in imports_of(module):
            inside = source if source in MODULES else source.rpartition(".")[0]
            above, below = sorted((parent_of(module), parent_of(inside)), key=len)
            if above and below.rpartition(".")[0] == above:
                ways.setdefault(below, set()).add("down" if parent_of(module) == above else "up")
    assert {name for name, found in ways.items() if len(found) == 2} == BOTH_WAYS


def parent_of(module: str) -> str:
    """Return the folder that a module's file is in; none for a front door."""
    return "" if MODULES.get(module, ROOT).name == "__init__.py" else module.rpartition(".")[0]


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_is_entered_by_its_door(folder):
    """Kernels may import kernels: compiled code has no use for a shell."""
    past = []
    for module in MODULES:
        for source, name in imports_of(module):
            door, taken = f"gcm_learn.{folder}", f"{source}.{name}"
            if not f"{taken}.".startswith(f"{door}.") or folder_of(module) == folder:
                continue
            if taken == door or (source == door and name in offers(folder)):
                continue
            inside = taken if taken in MODULES else source
            if inside == door:
                past.append(f"{module} takes {name}, which the door does not list")
            elif not passes(module, inside):
                past.append(f"{module} takes {name} from {source}")
    assert past == []


def test_no_files_import_each_other_in_a_circle():
    """An import within a function counts as well."""
    graph: dict[str, set[str]] = {module: set() for module in MODULES}
    for module in MODULES:
        for source, name in imports_of(module):
            taken = f"{source}.{name}" if f"{source}.{name}" in MODULES else source
            graph[module] |= {taken} - {module}
    graphlib.TopologicalSorter(graph).prepare()  # raises CycleError with the circle


@pytest.mark.parametrize("folder", FOLDERS)
def test_what_a_door_lists_is_there(folder):
    door = importlib.import_module(f"gcm_learn.{folder}")
    assert offers(folder) and [name for name in offers(folder) if not hasattr(door, name)] == []
    assert not hasattr(door, "nothing_of_this_name")


def test_kernels_take_few_parameters():
    counts = {
        f"{module}.{node.name}": len(node.args.args)
        for module in MODULES
        if is_compiled(module)
        for node in ast.walk(tree_of(module))
        if isinstance(node, ast.FunctionDef)
        and any("njit" in ast.unparse(decorator) for decorator in node.decorator_list)
    }
    assert {name: n for name, n in counts.items() if n > MOST_PARAMETERS} == {}
    assert sum(n > MANY_PARAMETERS for n in counts.values()) <= 0.15 * len(counts)


def test_an_import_changes_nothing_but_who_waits_for_gymnasium():
    """ARCHITECTURE.md tells why there is one who waits."""
    code = """
import os, sys
import numba, numpy
from numba.core.caching import IndexDataCacheFile
before = (numba.config.CACHE_DIR, IndexDataCacheFile.save, list(sys.meta_path), dict(os.environ))
import gcm_learn.cli, gcm_learn.planners, gcm_learn.recall
gcm_learn.solve
assert numba.config.CACHE_DIR == before[0] and IndexDataCacheFile.save is before[1]
assert dict(os.environ) == before[3]
print(*(type(finder).__module__ for finder in sys.meta_path if finder not in before[2]))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout.split() == ["gcm_learn.registration"], done.stdout + done.stderr
