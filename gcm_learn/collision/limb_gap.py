"""How near the limb is to a segment in its plane."""

from __future__ import annotations

from gcm_learn.collision.distance import segment_point2, segments_cross
from gcm_learn.compiled import njit
from gcm_learn.scene.limb import elbow_of


@njit
def _gap2(ax, ay, bx, by, cx, cy, dx, dy):
    """Squared distance of the plane segments a-b and c-d."""
    if segments_cross(ax, ay, bx, by, cx, cy, dx, dy):
        return 0.0
    first = min(segment_point2(ax, ay, cx, cy, dx, dy), segment_point2(bx, by, cx, cy, dx, dy))
    second = min(segment_point2(cx, cy, ax, ay, bx, by), segment_point2(dx, dy, ax, ay, bx, by))
    return min(first, second)


@njit
def limb_gap2(hx, hy, rho, side, ax, ay, bx, by):
    """Squared distance of the limb with its hand at h to the plane segment a-b."""
    ex, ey = elbow_of(hx, hy, rho, side)
    upper = _gap2(0.0, 0.0, ex, ey, ax, ay, bx, by)
    return min(upper, _gap2(ex, ey, hx, hy, ax, ay, bx, by))
