"""Scenes of MoveIt in the text that RViz exports (``.scene``)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from gcm_learn.checks import quote
from gcm_learn.errors import FileFormatError
from gcm_learn.outside.moveit import SIZES
from gcm_learn.outside.nodes import Node


def scene_node(name: str, text: str) -> Node:
    """Parse the text of a planning scene into a node with the members of the YAML form.

    Objects have poses of their own, or, as older versions of MoveIt write them, only their shapes.

    Raises
    ------
    FileFormatError
    """
    words, objects = _Words(name, text), []
    starts = (after for line, after in pairwise(words.lines[1:]) if line.startswith("*"))
    posed = len(next(starts, "").split()) > 1
    while (mark := words.word()) == "*":
        objects.append(_object(words, posed))
    if mark != ".":
        raise words.error(f"must be *, before an object, or . at the end (got {quote(mark)})")
    return Node(name, "", {"world": {"collision_objects": objects}})


def _object(words: _Words, posed: bool) -> dict[str, Any]:
    made: dict[str, Any] = {"id": " ".join(words.left)}
    words.left = []
    made |= {"pose": words.pose()} if posed else {}
    for _ in range(words.numbers(1, int)[0]):
        kind = words.word()
        many, one = ("meshes", "mesh") if kind == "mesh" else ("primitives", "primitive")
        made.setdefault(many, []).append(_shape(kind, words))
        made.setdefault(f"{one}_poses", []).append(words.pose())
        words.numbers(4)  # its colour
    for _ in range(words.numbers(1, int)[0] if posed else 0):
        words.word()  # the name of a frame on the object
        words.pose()
    return made


def _shape(kind: str, words: _Words) -> dict[str, Any]:
    if kind == "mesh":
        vertices, triangles = words.numbers(2, int)
        return {
            "vertices": [words.numbers(3) for _ in range(vertices)],
            "triangles": [{"vertex_indices": words.numbers(3, int)} for _ in range(triangles)],
        }
    if kind not in SIZES:
        raise words.error(f"{quote(kind)} is not understood")
    sizes = words.numbers(SIZES[kind])
    return {"type": kind, "dimensions": sizes[::-1] if kind == "cylinder" else sizes}


class _Words:
    """Reader of a text's words, in order from the second line on."""

    def __init__(self, file: str, text: str) -> None:
        self.file, self.lines = file, text.splitlines()
        self.line, self.left = 1, list[str]()

    def error(self, reason: str) -> FileFormatError:
        return FileFormatError(f"{self.file}:{self.line}: {reason}")

    def word(self) -> str:
        while not self.left:
            if self.line >= len(self.lines):
                raise self.error("ends too early")
            self.left = self.lines[self.line].split()
            self.line += 1
        return self.left.pop(0)

    def numbers(self, size: int, kind: type = float) -> list[Any]:
        words = [self.word() for _ in range(size)]
        try:
            return [kind(word) for word in words]
        except ValueError:
            what = "numbers" if kind is float else "whole numbers"
            raise self.error(f"must be {what} (got {quote(' '.join(words))})") from None

    def pose(self) -> dict[str, Any]:
        return {"position": self.numbers(3), "orientation": self.numbers(4)}
