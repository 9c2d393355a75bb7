"""Features of cognitive maps, from which encoders embed them; sizes of cells do not matter.

Fields come first: arrival, cells with one, effective obstacles, in the plane second arrivals. Then
the contact, and the way that runs down the map to it. Times count as ways of the hand at full
speed. Maps that are made here have no margin: a key need not keep clear.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.maps import CognitiveMap, build_map, chain_to, descend
from gcm_learn.situation import AnySituation, canonical
from gcm_learn.wave import MarchingParams

CELLS = 40  # along a side of maps that are built in the plane
DIRECTIONS, RINGS = 32, 10
COARSE, SIDE = 24, 8  # cells along a side in space, blocks along a side
PARTS = 12  # equal shares of the way to the contact
FRONT = 0.17  # speed of a free front, by which kappa is defined [cells / tau]
WAY = 3.0  # of the hand, for which a planar arrival is 1 [forearm lengths]


def planar_map(situation: AnySituation) -> CognitiveMap:
    """Return the map of a planar situation in its canonical form; the hand may wait."""
    return build_map(canonical(situation)[0], MarchingParams(n=CELLS, margin=0.0), wait=True)


def coarse_map(situation: AnySituation) -> CognitiveMap:
    """Return the map of a situation in space in its canonical form, with coarse cells."""
    return build_map(canonical(situation)[0], MarchingParams(n=COARSE, margin=0.0))


def planar_map_features(made: CognitiveMap) -> np.ndarray:
    """Return features (1345,) float32 of a map of the plane in any frame.

    Fields are sampled on a polar lattice that begins at the hand and runs to the elbow's left.
    """
    lattice, (x, y) = made.lattice, made.hand
    near, far = abs(lattice.upper_arm - 1.0), lattice.reach
    angle, side = np.arctan2(y, x), -1.0 if lattice.elbow == "left" else 1.0
    r = near + (np.arange(RINGS)[:, None] + 0.5) / RINGS * (far - near)
    a = angle + side * 2.0 * np.pi * np.arange(DIRECTIONS)[None] / DIRECTIONS
    where = [np.clip(((p + far) / lattice.spacing).astype(int), 0, lattice.n - 1)
             for p in (r * np.sin(a), r * np.cos(a))]  # fmt: skip
    second = np.zeros(made.chart.shape) if made.later is None else made.later[0].filled(0.0)
    fields = np.stack([*_fields(made), second * _speed(made)])[:, where[0], where[1]]
    fields[::3] /= WAY
    found = descend(made)
    if found is None or made.interception is None:
        return np.append(fields, np.zeros(5 * (PARTS + 1))).astype(np.float32)
    hands, arrival = found
    turns = side * np.unwrap(np.append(angle, np.arctan2(*hands[:, ::-1].T)))[1:] - side * angle
    rings = 2.0 * (np.hypot(*hands.T) - near) / (far - near) - 1.0
    steps = np.hypot(*np.diff(hands, axis=0).T)
    rows = np.column_stack([turns, rings, arrival * _speed(made) / WAY])
    turn, ring, when = _shares(rows, steps).T
    way = np.column_stack([np.cos(turn), np.sin(turn), turn / np.pi, ring, when])
    whole = [1.0, *way[-1, [0, 1, 3, 4]]]
    return np.concatenate([fields.ravel(), way.ravel(), whole]).astype(np.float32)


def joint_map_features(made: CognitiveMap) -> np.ndarray:
    """Return features float32 of a map of hand-space, for an arm that moves in its joints.

    Fields are means over SIDE blocks along a side: the first arrival in any posture, cells with an
    arrival, effective obstacles in any posture. The joints follow at equal shares of the way to the
    contact, and then their offsets from the straight line between the ends of the way.
    """
    n, reach = made.chart.n, made.chart.reach
    arrival, there, walls = (field.reshape(n, n, n, -1) for field in _fields(made))
    first = np.where(there > 0.0, arrival, np.inf).min(axis=-1) / reach
    cells = np.stack([first, there.max(axis=-1), walls.max(axis=-1)])
    cells[0, cells[1] == 0.0] = 0.0
    edges = -(-np.arange(SIDE + 1) * n // SIDE)
    for axis in (1, 2, 3):
        cells = np.add.reduceat(cells, edges[:-1], axis=axis)
    widths = np.diff(edges)
    cells /= widths[:, None, None] * widths[:, None] * widths
    dof = len(made.chart.arm.joints)  # type: ignore[attr-defined]
    ends = np.zeros(5 + PARTS * (2 * dof + 1))
    if made.interception is not None:
        nodes = np.array(chain_to(made, made.met))
        joints = made.postures(nodes)
        when = made.arrival.ravel()[nodes].filled(0.0) * _speed(made) / reach
        rows = np.column_stack([joints, when])
        way = _shares(rows, np.abs(np.diff(joints, axis=0)).max(axis=1, initial=0.0))
        line = joints[0] + np.arange(1, PARTS + 1)[:, None] / PARTS * (joints[-1] - joints[0])
        place = np.array(made.interception.position) / reach
        ends[:] = np.concatenate(
            [[1.0, *place, when[-1]], way.ravel(), (way[:, :dof] - line).ravel()]
        )
    return np.concatenate([cells.ravel(), ends]).astype(np.float32)


def _fields(made: CognitiveMap) -> np.ndarray:
    """Return arrival [lengths], reached nodes and effective obstacles (3, ...) of a map."""
    there = ~np.ma.getmaskarray(made.arrival)
    arrival = made.arrival.filled(0.0) * _speed(made)
    return np.stack([arrival, there, made.effective_obstacles], dtype=float)


def _speed(made: CognitiveMap) -> float:
    """Return the fastest speed of a map's front [lengths / s]."""
    return FRONT * made.chart.spacing / made.kappa


def _shares(rows: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return rows (PARTS, k) at equal shares of a way of rows (m, k) with steps (m - 1,)."""
    way = np.append(0.0, np.cumsum(steps + 1e-9))
    at = way[-1] * np.arange(1, PARTS + 1) / PARTS
    return np.stack([np.interp(at, way, column) for column in rows.T], axis=1)
