"""Files of clouds and meshes, which the package and the referee read alike."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from gcm_learn import referee
from gcm_learn.checks import positive, quote, text
from gcm_learn.errors import SituationError
from gcm_learn.situation.surfaces import Cloud, Mesh


def read_mesh(path: str | Path, scale: float = 1.0) -> Mesh:
    """Read all objects of a file as one mesh; polygons are cut into fans.

    Parameters
    ----------
    path : str or Path
        A file of stl, obj, ply or off, text or binary.
    scale : float
        Factor of all coordinates, above zero.

    Raises
    ------
    SituationError
        In one line.
    """
    vertices, triangles = _read(referee.read_mesh, Path(path), "")
    return Mesh(vertices * positive(scale, "scale"), triangles)


def with_files(members: dict[str, Any], path: str, folder: Path) -> dict[str, Any]:
    """Return the members of a cloud or mesh with numbers in place of the names of files.

    Parameters
    ----------
    members : dict
        Of the JSON object of a shape.
    path : str
        Path of the shape in the situation, for messages.
    folder : Path
        Folder to which paths are relative.
    """
    if members["kind"] == Cloud.kind and isinstance(members.get("points"), str):
        points = _read(referee.read_points, folder / members["points"], f"{path}.points")
        return members | {"points": points}
    if members["kind"] != Mesh.kind or "file" not in members:
        return members
    for name in ("vertices", "triangles"):
        if name in members:
            raise SituationError(f"{path}.file", f"is given beside {name}")
    result = dict(members)
    try:
        text(result.pop("file"), "file")
        scale = positive(result.pop("scale", 1.0), "scale")
    except SituationError as error:
        raise SituationError(f"{path}.{error.field}", error.reason) from None
    vertices, triangles = _read(referee.read_mesh, folder / members["file"], f"{path}.file")
    return result | {"vertices": vertices * scale, "triangles": triangles}


def _read(read: Callable[[Path], Any], path: Path, field: str) -> Any:
    try:
        return read(path)
    except referee.Unreadable as error:
        raise SituationError(field, f"{quote(path.name)} {error}") from None
