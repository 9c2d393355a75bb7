"""Files of points and of triangles, read in plain numpy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.referee.rotations import Array
from gcm_learn.referee.tolerances import Unreadable

Faces = list[list[int]]
PLY = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
"""Types of numbers in PLY files."""


def _once(read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Return a reader that caches its latest results, as long as the files do not change."""
    again = lru_cache(maxsize=32)(lambda path, stamp: read(path))

    @wraps(read)
    def reader(path: Path) -> Any:
        try:
            about = path.stat()
        except (OSError, ValueError):
            return read(path)
        return again(path, (about.st_mtime_ns, about.st_size))

    return reader


def inlined(situation: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return a situation with numbers in place of the files of its clouds and meshes.

    Raises
    ------
    Unreadable
        If a file cannot be read.
    """
    bodies = situation.get("bodies")
    if not isinstance(bodies, list):
        return situation
    return {**situation, "bodies": [_body(body, folder) for body in bodies]}


def _body(body: Any, folder: Path) -> Any:
    shape = body.get("shape") if isinstance(body, Mapping) else None
    if not isinstance(shape, Mapping):
        return body
    points, file = shape.get("points"), shape.get("file")
    if shape.get("kind") == "cloud" and isinstance(points, str):
        return {**body, "shape": {**shape, "points": read_points(folder / points).tolist()}}
    if shape.get("kind") != "mesh" or not isinstance(file, str):
        return body
    scale = shape.get("scale", 1.0)
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not 0 < scale < np.inf:
        raise Unreadable(f"scale: {str(scale)[:60]} is not allowed")
    vertices, triangles = read_mesh(folder / file)
    rest = {name: value for name, value in shape.items() if name not in ("file", "scale")}
    made = {"vertices": (scale * vertices).tolist(), "triangles": triangles.tolist()}
    if set(made) & set(rest):
        raise Unreadable("shape: has vertices beside a file")
    return {**body, "shape": {**rest, **made}}


@_once
def read_points(path: Path) -> Array:
    """Return the points (n, 3) of a ``.npy`` file of float32 or float64.

    Raises
    ------
    Unreadable
        If it is no such file.
    """
    if path.suffix.lower() != ".npy":
        raise Unreadable("is no .npy file")
    try:
        made = np.load(path, allow_pickle=False)
    except Exception as error:  # a broken header raises errors of many kinds
        raise _unreadable(error) from error
    if not isinstance(made, np.ndarray) or made.dtype.str[1:] not in ("f4", "f8"):
        raise Unreadable("does not hold float32 or float64")
    if made.ndim != 2 or made.shape[1] != 3 or not len(made) or not np.isfinite(made).all():
        raise Unreadable(f"does not hold n x 3 finite numbers (it has {made.shape})")
    return made.astype(float)


@_once
def read_mesh(path: Path) -> tuple[Array, Array]:
    """Return vertices (v, 3) and triangles (t, 3) of all objects of a file.

    Raises
    ------
    Unreadable
        If it is of another kind, or is broken, or lacks triangles.
    """
    vertices, triangles = read_surface(path)
    if not len(triangles):
        raise Unreadable("has no triangles")
    if not np.isfinite(vertices).all():
        raise Unreadable("has vertices that are no numbers")
    return vertices, triangles


def read_surface(path: Path) -> tuple[Array, Array]:
    """Return vertices (v, 3), as they are, and triangles (t, 3), if any, of a file.

    Raises
    ------
    Unreadable
        If it is no file of `MESHES`.
    """
    read = MESHES.get(path.suffix.lower())
    if read is None:
        raise Unreadable(f"is no mesh of {', '.join(kind[1:] for kind in MESHES)}")
    try:
        vertices, faces = read(path.read_bytes())
        vertices = np.array(vertices, dtype=float).reshape(-1, 3)
    except Exception as error:  # of as many kinds as there are ways to be broken
        raise _unreadable(error) from error
    fans = [[face[0], *face[k : k + 2]] for face in faces for k in range(1, len(face) - 1)]
    triangles = np.array(fans, dtype=np.int64).reshape(-1, 3)
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
        raise Unreadable("names a vertex it lacks")
    return vertices, triangles


def _unreadable(error: Exception) -> Unreadable:
    reason = getattr(error, "strerror", None) or str(error).partition("\n")[0]
    return Unreadable(f"cannot be read ({reason or type(error).__name__})")


def _stl(content: bytes) -> tuple[Any, Faces]:
    count = int.from_bytes(content[80:84], "little")
    if len(content) == 84 + 50 * count:
        rows = np.frombuffer(content[84:], dtype=[("n", "<f4", 3), ("v", "<f4", 9), ("a", "<u2")])
        corners = rows["v"].reshape(-1, 3)
    else:
        words = (line.split() for line in content.decode().splitlines())
        corners = np.array([w[1:4] for w in words if w and w[0].lower() == "vertex"], dtype=float)
    return corners, np.arange(len(corners)).reshape(-1, 3).tolist()


def _obj(content: bytes) -> tuple[Any, Faces]:
    vertices: list[list[float]] = []
    faces: Faces = []
    for line in content.decode().replace("\\\n", " ").splitlines():
        words = line.partition("#")[0].split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            given = [int(word.partition("/")[0]) for word in words[1:]]
            faces.append([i - 1 if i > 0 else len(vertices) + i for i in given])
    return vertices, faces


def _off(content: bytes) -> tuple[Any, Faces]:
    lines = [line.partition("#")[0].split() for line in content.decode().splitlines()]
    words = [line for line in lines if line]
    if words[0][0] != "OFF":
        raise ValueError("does not begin with OFF")
    words[0] = words[0][1:]
    head, *rest = [line for line in words if line]
    count, sides = int(head[0]), int(head[1])
    faces = [[int(i) for i in line[1 : 1 + int(line[0])]] for line in rest[count : count + sides]]
    return [[float(x) for x in line[:3]] for line in rest[:count]], faces


def _ply(content: bytes) -> tuple[Any, Faces]:
    head, _, rest = content.partition(b"end_header")
    lines = [line.split() for line in head.decode("ascii", "replace").splitlines()]
    form = next(words[1] for words in lines if words[:1] == ["format"])
    source: _Words | _Numbers = _Words(rest.split())
    if form != "ascii":
        source = _Numbers(rest.partition(b"\n")[2], "<" if "little" in form else ">")
    found: dict[str, Any] = {}
    for k, words in enumerate(lines):
        if words[:1] == ["element"]:
            after = lines[k + 1 :]
            last = next((i for i, w in enumerate(after) if w[:1] == ["element"]), len(after))
            properties = [w[1:] for w in after[:last] if w[:1] == ["property"]]
            found[words[1]] = _rows(source, properties, int(words[2]))
    vertices = np.column_stack([found["vertex"][name] for name in "xyz"])
    names = (n for n in ("vertex_indices", "vertex_index") if n in found.get("face", {}))
    return vertices, found["face"][next(names)] if "face" in found else []


def _rows(source: _Words | _Numbers, properties: list[list[str]], count: int) -> dict[str, Any]:
    """Return columns by the names of properties; a property of lists has a list for each row."""
    if all(len(given) == 2 for given in properties):
        return source.table([(name, PLY[kind]) for kind, name in properties], count)
    made: dict[str, Any] = {given[-1]: [] for given in properties}
    for _ in range(count):
        for given in properties:
            if given[0] == "list":
                (number,) = source.take(PLY[given[1]], 1)
                made[given[3]].append(source.take(PLY[given[2]], int(number)))
            else:
                made[given[1]] += source.take(PLY[given[0]], 1)
    return made


class _Words:
    """Numbers of a text, taken in order."""

    def __init__(self, words: list[bytes]) -> None:
        self.words, self.place = words, 0

    def take(self, kind: str, count: int) -> list[Any]:
        self.place += count
        given = self.words[self.place - count : self.place]
        if len(given) < count:
            raise ValueError("it ends too early")
        return [(float if kind[0] == "f" else int)(word) for word in given]

    def table(self, columns: list[tuple[str, str]], count: int) -> dict[str, Any]:
        rows = np.array(self.take("f8", count * len(columns))).reshape(count, -1)
        return {name: rows[:, k] for k, (name, _) in enumerate(columns)}


class _Numbers:
    """Numbers of bytes, taken in order."""

    def __init__(self, content: bytes, order: str) -> None:
        self.content, self.order, self.place = content, order, 0

    def take(self, kind: str, count: int) -> list[Any]:
        made = np.frombuffer(self.content, self.order + kind, count, self.place)
        self.place += made.nbytes
        return made.tolist()

    def table(self, columns: list[tuple[str, str]], count: int) -> dict[str, Any]:
        row = np.dtype([(name, self.order + kind) for name, kind in columns])
        rows = np.frombuffer(self.content, row, count, self.place)
        self.place += rows.nbytes
        return {name: rows[name] for name, _ in columns}


MESHES: dict[str, Callable[[bytes], tuple[Any, Faces]]] = {
    ".stl": _stl, ".obj": _obj, ".off": _off, ".ply": _ply,
}  # fmt: skip
"""Readers by the ends of names."""
