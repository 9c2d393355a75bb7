"""Obstacles from files, put into situations: scenes of MoveIt, meshes and clouds of points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import referee, situation
from gcm_learn.arms import kind_of, rotation_of
from gcm_learn.checks import normalised, positive, vector
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.outside.converted import REST, UNTURNED, Converted, is_blocked
from gcm_learn.outside.moveit import Pose, bodies_of
from gcm_learn.outside.nodes import texts, yaml_node
from gcm_learn.outside.pcd import read_pcd
from gcm_learn.outside.scene_text import scene_node
from gcm_learn.situation import SURFACES, Body, Cloud, Margin, Mesh, SolidQuadratic

SCENES = {".scene": scene_node, ".yaml": yaml_node, ".yml": yaml_node}
CLOUDS = {".pcd": read_pcd, ".npy": referee.read_points}
"""Readers by the ends of names, beside the readers of meshes in `referee.MESHES`."""


@dataclass(frozen=True)
class World:
    """Files as obstacles at rest in given situations, by options of ``gcm-learn convert``."""

    into: Path
    radius: float | None = None
    simplify: float | None = None
    scale: float = 1.0
    at: tuple[float, float, float] = REST
    turn: tuple[float, float, float, float] = UNTURNED

    def convert(self, sources: Sequence[Path]) -> Converted:
        """Return the given situations, each with all obstacles of the sources."""
        result = Converted()
        bodies = [body for source in sources for body in self._bodies(source, result)]
        situations: list[Any] = [*situation.read_situations(self.into)]
        for given in situations:
            newest = kind_of(given).formats[-1]
            version = newest if any(body.newer for body in bodies) else given.format
            try:
                made = replace(given, bodies=(*given.bodies, *bodies), format=version)
            except SituationError as error:
                raise FileFormatError(f"{self.into}: {given.name}: {error}") from None
            result.count("the start is blocked", is_blocked(made))
            result.situations.append(made)
        return result

    def _bodies(self, source: Path, result: Converted) -> Iterator[Body]:
        place: Any = vector(self.at, "at", 3)
        turn: Any = normalised(self.turn, "turn", 4)
        read = SCENES.get(source.suffix.lower())
        if read:
            if self.scale != 1.0:
                raise SituationError("scale", f"is for clouds and meshes ({source} is in metres)")
            ((name, text),) = texts(source, ".*")
            bodies = bodies_of(read(name, text), Pose(np.array(place), rotation_of(turn)))
        else:
            motion = SolidQuadratic(place, REST, REST, turn)
            bodies = (Body("obstacle", source.stem, self._shape(source, result), motion),)
        yield from (self._simpler(body, result) for body in bodies)

    def _shape(self, source: Path, result: Converted) -> Cloud | Mesh:
        read = CLOUDS.get(source.suffix.lower())
        try:
            none = np.zeros((0, 3), dtype=int)
            points, triangles = (read(source), none) if read else referee.read_surface(source)
        except referee.Unreadable as error:
            raise FileFormatError(f"{source}: {error}") from None
        scale = positive(self.scale, "scale")
        if len(triangles):
            try:
                return Mesh(points * scale, triangles)
            except SituationError as error:
                raise FileFormatError(f"{source}: {error}") from None
        measured = np.isfinite(points).all(axis=1)
        if not measured.any():
            raise FileFormatError(f"{source}: has no points")
        if not measured.all():
            told = f"points of {source} are not finite and are left out"
            result.counts[told], result.asked[told] = int((~measured).sum()), len(points)
        if self.radius is None:
            raise SituationError("radius", f"is missing: {source} is a cloud of points")
        return Cloud(points[measured] * scale, self.radius)

    def _simpler(self, body: Body, result: Converted) -> Body:
        """Return a simplified obstacle that still covers the original, if need be by a margin."""
        if self.simplify is None or not isinstance(body.shape, SURFACES):
            return body
        shape, bound = body.shape.simplified(positive(self.simplify, "simplify"))
        is_mesh = isinstance(shape, Mesh)
        parts, cost = ("triangles", "margin") if is_mesh else ("points", "radius larger by")
        told = f"{parts} of {body.name} are left, {cost} {bound:.6g}"
        result.counts[told] = len(getattr(shape, parts))
        result.asked[told] = len(getattr(body.shape, parts))
        return replace(body, shape=shape, margin=Margin(bound, 0.0) if is_mesh else None)
