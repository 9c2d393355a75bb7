"""Clouds in PCD files of the Point Cloud Library."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.checks import quote
from gcm_learn.errors import FileFormatError

UNMOVED = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
"""Place and turn of the sensor by which points are where they are written."""


def read_pcd(path: Path) -> np.ndarray:
    """Return the points (n, 3) of a file, of which some may not be finite.

    Raises
    ------
    FileFormatError
    """
    try:
        return _points(path.read_bytes())
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise FileFormatError(f"{path}: {error}") from None


def _points(content: bytes) -> np.ndarray:
    head, data = _header(content)
    form, points = " ".join(head["DATA"]), " ".join(head.get("POINTS", []))
    if form not in ("ascii", "binary", "binary_compressed"):
        raise ValueError(f"DATA: must be ascii, binary or binary_compressed (got {quote(form)})")
    if not points.isdecimal() or int(points) == 0:
        raise ValueError(f"POINTS: must be a number above 0 (got {quote(points)})")
    if list(map(float, head.get("VIEWPOINT", UNMOVED))) != UNMOVED:
        given = quote(" ".join(head["VIEWPOINT"]))
        raise ValueError(f"VIEWPOINT: must be 0 0 0 1 0 0 0, a pose is given apart (got {given})")
    count, packed = int(points), form == "binary_compressed"
    axes, words, width = _layout(head, packed)
    if form == "ascii":
        lines = [line for line in data.decode("ascii", "replace").splitlines() if line.strip()]
        if len(lines) != count or {len(line.split()) for line in lines} != {words}:
            raise ValueError(f"DATA: must be {count} lines, each of {words} numbers")
        return np.loadtxt(lines, usecols=[word for word, *_ in axes], ndmin=2, comments=None)
    data, columns = _unpacked(data) if packed else data, []
    if len(data) < count * width:
        raise ValueError(f"DATA: ends after {len(data)} of {count * width} bytes")
    for _, byte, size in axes:
        start, step = (byte * count, size) if packed else (byte, width)
        columns.append(np.ndarray((count,), f"<f{size}", data, start, (step,)))
    return np.stack(columns, axis=1).astype(float)


def _header(content: bytes) -> tuple[dict[str, list[str]], bytes]:
    """Return each header line's words by its first word, and the data after the header."""
    head: dict[str, list[str]] = {}
    while "DATA" not in head:
        line, end, content = content.partition(b"\n")
        if not end:
            raise ValueError("has no line DATA, as PCD files have")
        name, *words = line.decode("ascii", "replace").split() or ["#"]
        head[name] = words
    return head, content


def _layout(head: dict[str, list[str]], packed: bool) -> tuple[list[Any], int, int]:
    """Return word, byte and size of x, y and z in a row, and the row's words and bytes."""
    names, found, words, width = head.get("FIELDS", []), {}, 0, 0
    counts = head.get("COUNT", ["1"] * len(names))
    try:
        rows = list(zip(names, head["SIZE"], head["TYPE"], counts, strict=True))
        sizes = [(int(size), int(count)) for _, size, _, count in rows]
        if min(map(min, sizes), default=0) < 0:
            raise ValueError
    except (KeyError, ValueError):
        raise ValueError("FIELDS: must fit SIZE, TYPE and COUNT") from None
    for row, (size, count) in zip(rows, sizes, strict=True):
        if row[0] in {*"xyz"} and row[1:] not in (("4", "F", "1"), ("8", "F", "1")):
            raise ValueError(f"FIELDS: {row[0]} must be of type F with 4 or 8 bytes")
        if not packed or row[0] != "_":  # padding, which packed data leave out
            found[row[0]] = words, width, size
            words, width = words + count, width + size * count
    if not found.keys() >= {*"xyz"}:
        raise ValueError("FIELDS: must have x, y and z")
    return [found[name] for name in "xyz"], words, width


def _unpacked(data: bytes) -> bytes:
    """Unpack bytes packed by LZF: plain bytes, and repetitions of earlier bytes."""
    packed, size = np.frombuffer(data, "<u4", 2).tolist()
    data, made, at = data[8 : 8 + packed], bytearray(), 0
    try:
        while at < packed:
            code, at = data[at], at + 1
            if code < 32:
                made += data[at : at + code + 1]
                at += code + 1
                continue
            length = (code >> 5) + 2
            if length == 9:
                length, at = length + data[at], at + 1
            start, at = len(made) - ((code & 31) << 8) - data[at] - 1, at + 1
            part = made[start : start + length] if start >= 0 else b""
            made += (part * (1 + length // len(part)))[:length]
    except (IndexError, ZeroDivisionError):
        made.clear()
    if len(made) != size:
        raise ValueError(f"DATA: does not unpack to {size} bytes by LZF")
    return bytes(made)
