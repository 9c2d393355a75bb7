"""Record of a front, the same for all engines, with waits or without."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from gcm_learn.charts import Chart


@dataclass(frozen=True)
class Front:
    """States that a front reached: nodes of a chart in one safe interval each.

    A front that cannot wait knows of every node the first arrival only. Its states are all nodes in
    their order, so that it is a front of one sheet; those where it was refused have an arrival too.
    """

    chart: Chart
    waits: bool
    """True if the hand may wait."""
    nodes: np.ndarray
    """(m,) int: node of every state; in order of arrival where the front may wait."""
    via: np.ndarray | None
    """(m,) int: state from which the hand comes straight, -1 for the hand's start; None where its
    map is to be descended instead."""
    arrival: np.ndarray
    """(m,) float: earliest arrival [s]; negative where the front never came."""
    end: np.ndarray
    """(m,) float: when the safe interval ends, the horizon at most [s]."""
    refused: np.ndarray
    """(...) bool in the chart's shape: where an obstacle was when a front came."""
    met: np.ndarray
    """(...) bool: where a target was met."""
    met_state: int
    """State of the first contact, -1 without one."""
    met_body: int
    """Index of that target, -1 if none."""
    met_time: float
    """Time of the meeting [s]; the horizon without one."""
    steps: int
    """Euler steps (wave) or accepted nodes that it took."""
    joints: np.ndarray | None = None
    """(nodes, dof) float: postures that the front found; None where the chart has them."""

    @cached_property
    def cells(self) -> np.ndarray:
        """Index (m, d) of every state's node in the chart's shape: iy, ix on a lattice."""
        return np.stack(np.unravel_index(self.nodes, self.chart.shape), axis=-1)

    @property
    def first(self) -> np.ndarray:
        """First arrival (...) at every node [s], negative where the front never came."""
        if not self.waits:
            return self.arrival.reshape(self.chart.shape)
        out = np.full(self.refused.size, np.inf)
        np.minimum.at(out, self.nodes, self.arrival)
        return np.where(np.isfinite(out), out, -1.0).reshape(self.chart.shape)

    def sheets(self) -> tuple[np.ndarray, np.ndarray]:
        """Arrivals (s, ...) in the first, second, ... interval of every reached node [s].

        The second array (s, ...) marks nodes without an arrival, and refusals of a front that
        cannot wait.
        """
        if not self.waits:
            first = self.first
            return first[None], (self.refused | (first < 0.0))[None]
        order, sheet = self._intervals()
        out = np.full((sheet.max(initial=0) + 1, self.refused.size), -1.0)
        out[sheet, self.nodes[order]] = self.arrival[order]
        out = out.reshape(-1, *self.chart.shape)
        return out, out < 0.0

    def chain(self) -> list[int]:
        """Return the states on the path from the hand to the first contact."""
        assert self.via is not None, "its map is to be descended instead"
        chain, state = [], self.met_state
        while state >= 0:
            chain.append(state)
            state = int(self.via[state])
        return chain[::-1]

    def _intervals(self) -> tuple[np.ndarray, np.ndarray]:
        """Count the safe intervals of every node.

        A front may come to a node twice in one interval, over a neighbour and from where it
        waited; the earlier one counts.

        Returns
        -------
        order : (k,) ndarray
            First states of their intervals, node by node in order of arrival.
        sheet : (k,) ndarray
            Number of intervals of their node before theirs.
        """
        node, arrival = self.nodes, self.arrival
        order = np.lexsort((arrival, node))
        another = np.ones(len(order), dtype=bool)
        same = node[order][1:] == node[order][:-1]
        another[1:] = ~same | (arrival[order][1:] > self.end[order][:-1])
        order = order[another]
        return order, np.arange(len(order)) - np.searchsorted(node[order], node[order])


def first_arrivals(
    chart: Chart,
    arrival: np.ndarray,
    refused: np.ndarray,
    contacts: np.ndarray,
    met: tuple[int, int, float],
    *,
    horizon: float,
    steps: int,
    via: np.ndarray | None = None,
    joints: np.ndarray | None = None,
) -> Front:
    """Make the front of a hand that cannot wait: one sheet of first arrivals.

    Parameters
    ----------
    chart : Chart
        Of m nodes.
    arrival : (m,) ndarray
        Negative where the front never came [s].
    refused, contacts : (m,) ndarray of bool
        Where an obstacle was when the front came, and where a target was met.
    met : (int, int, float)
        Node and body (-1 if none) and time [s] of the first contact.

    Other Parameters
    ----------------
    horizon : float
        [s]
    steps : int
        Euler steps, or accepted nodes.
    via : (m,) ndarray of int, optional
        Node from which the hand comes straight.
    joints : (m, dof) ndarray, optional
        Postures that the front found.
    """
    node, body, time = met
    return Front(
        chart=chart,
        waits=False,
        nodes=_all_nodes(arrival.size),
        via=via,
        arrival=arrival,
        end=np.broadcast_to(horizon, arrival.shape),
        refused=refused.reshape(chart.shape),
        met=contacts.reshape(chart.shape),
        met_state=node,
        met_body=body,
        met_time=time if node >= 0 else horizon,
        steps=steps,
        joints=joints,
    )


def all_arrivals(
    chart: Chart,
    nodes: np.ndarray,
    via: np.ndarray,
    arrival: np.ndarray,
    end: np.ndarray,
    refused: np.ndarray,
    met: tuple[int, int, float],
) -> Front:
    """Make the front of a hand that may wait, of m states.

    Parameters
    ----------
    nodes, via, arrival, end : (m,) ndarray
        As in `Front`.
    refused : (nodes,) ndarray of bool
        Nodes in which an obstacle was when a front came.
    met : (int, int, float)
        State and body (-1 if none) and time [s] of the first contact.
    """
    state, body, time = met
    contacts = np.zeros(refused.size, dtype=np.bool_)
    if state >= 0:
        contacts[nodes[state]] = True
    return Front(
        chart=chart,
        waits=True,
        nodes=nodes,
        via=via,
        arrival=arrival,
        end=end,
        refused=refused.reshape(chart.shape),
        met=contacts.reshape(chart.shape),
        met_state=state,
        met_body=body,
        met_time=time,
        steps=len(nodes),
    )


@lru_cache(maxsize=16)
def _all_nodes(count: int) -> np.ndarray:
    """Indices (count,) of all nodes; shared, read-only."""
    nodes = np.arange(count)
    nodes.setflags(write=False)
    return nodes
