"""Robots from MJCF files, read by MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from gcm_learn.arms.robots import tree
from gcm_learn.arms.robots.tree import Drive, Hull, Inertial, Robot, RobotJoint, RobotLink, Tie
from gcm_learn.errors import MissingExtraError, RobotError


def read_mjcf(path: Path, visual: bool = False) -> Robot:
    """Read a robot from an MJCF file; bodies become links.

    Geometry counts if it can touch anything: `contype` or `conaffinity` is not 0, or a `pair` has
    it. With `visual` the geometry of other bodies counts, too. Planes, height fields and bodies
    that float alone are left out.

    Raises
    ------
    RobotError
        One line that names the body, joint or geometry.
    MissingExtraError
        If MuJoCo is not installed.
    """
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError("reading MJCF", "mujoco", "sim") from error
    try:
        mujoco.set_mju_user_warning(lambda message: None)  # what is wrong is raised here
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise RobotError(f"is no MJCF that can be read ({str(error).splitlines()[0]})") from None
    finally:
        mujoco.set_mju_user_warning(None)
    links: dict[str, RobotLink] = {}
    joints: list[RobotJoint] = []
    names = [model.body(b).name or f"body {b}" for b in range(model.nbody)]
    notes: list[str] = []
    for b, name in enumerate(names):
        looks, touching = _geometry(model, b, name, notes, mujoco)
        geoms = looks if visual and not touching else touching
        hulls = [h for g in geoms for h in _hulls(model, g, mujoco)]
        pose = _pose(model.body_ipos[b], model.body_iquat[b])
        made = Inertial(float(model.body_mass[b]), np.zeros(3), np.diag(model.body_inertia[b]))
        links[name] = RobotLink(name, tuple(hulls), made.moved(pose), bool(looks))
        if b:
            _join(model, b, names, links, joints, mujoco)
    for joint in joints:
        if not np.isfinite(joint.origin).all():
            raise RobotError(f"joint {joint.name!r}: its place or direction is not finite")
    for name, link in links.items():
        if not all(np.isfinite(hull.centres).all() for hull in link.hulls):
            raise RobotError(f"body {name!r}: the place of its geometry is not finite")
    joints, ties = _followed(model, joints, names, mujoco)
    return Robot(Path(path).stem, links, joints, tuple(notes), ties)


def _followed(
    model: Any, joints: list[RobotJoint], names: list[str], mujoco: Any
) -> tuple[list[RobotJoint], tuple[Tie, ...]]:
    """Return the joints with their leaders by equalities, and the equalities that are no line."""
    known, ties, types = {joint.name: joint for joint in joints}, [], mujoco.mjtEq
    for e in np.flatnonzero(model.eq_active0).tolist():
        kind, ends = int(model.eq_type[e]), (int(model.eq_obj1id[e]), int(model.eq_obj2id[e]))
        called = f"equality {model.equality(e).name or e!r}"
        if kind == types.mjEQ_JOINT:
            first, second = (_joint_name(model, j) for j in ends)
            tie = _lead(model, e, called, known, first, second)
            ties += [] if tie is None else [tie]
        elif kind in (types.mjEQ_CONNECT, types.mjEQ_WELD):
            if model.eq_objtype[e] == mujoco.mjtObj.mjOBJ_SITE:
                ends = (int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]]))
            if all(model.body_mocapid[b] < 0 for b in ends):
                links = tuple(names[b] for b in ends)
                what = f"{called} ties {links[0]!r} to {links[1]!r}: no chain closes a loop"
                ties.append(Tie(what, links=links))
        elif kind == types.mjEQ_TENDON:
            held = tuple(n for t in ends if t >= 0 for n in _held(model, t, mujoco))
            what = f"{called} couples tendons, of joints {', '.join(held)}: only joints can follow"
            ties.append(Tie(what, joints=held))
    return list(known.values()), tuple(ties)


def _joint_name(model: Any, j: int) -> str:
    return (model.joint(j).name or f"joint {j}") if j >= 0 else ""


def _held(model: Any, t: int, mujoco: Any) -> list[str]:
    """Return the joints of a fixed tendon, or the joints that move a spatial tendon's sites."""
    first, found = int(model.tendon_adr[t]), []
    for w in range(first, first + int(model.tendon_num[t])):
        j, kind = int(model.wrap_objid[w]), int(model.wrap_type[w])
        if kind == mujoco.mjtWrap.mjWRAP_JOINT:
            found.append(_joint_name(model, j))
        elif kind == mujoco.mjtWrap.mjWRAP_SITE:
            body = int(model.site_bodyid[j])
            while body:
                count, start = int(model.body_jntnum[body]), int(model.body_jntadr[body])
                found += [_joint_name(model, i) for i in range(start, start + count)]
                body = int(model.body_parentid[body])
    return found


def _lead(
    model: Any, e: int, called: str, known: dict[str, RobotJoint], first: str, second: str
) -> Tie | None:
    """Let one joint of an equality follow the other; return a Tie if neither can follow."""
    rest = [float(model.qpos0[model.jnt_qposadr[j]]) if j >= 0 else 0.0
            for j in (int(model.eq_obj1id[e]), int(model.eq_obj2id[e]))]  # fmt: skip
    shift, factor, *curved = (float(number) for number in model.eq_data[e, :5])
    joints = (first, second) if second else (first,)
    if second and any(curved):
        return Tie(
            f"joint {first!r}: follows {second!r} by a curve ({called}), not a line", (), joints
        )
    factor = factor if second else 0.0
    offset = rest[0] + shift - factor * rest[1]
    if _free(known, first, second):
        known[first] = known[first]._replace(follows=(second, factor, offset))
    elif factor and _free(known, second, first):
        known[second] = known[second]._replace(follows=(first, 1.0 / factor, -offset / factor))
    else:
        return Tie(f"joint {first!r}: {called} binds it twice", (), joints)
    return None


def _free(known: dict[str, RobotJoint], follower: str, leader: str) -> bool:
    """Return whether a joint may begin to follow another, without following itself."""
    while leader and leader != follower:
        leader = (known[leader].follows or ("",))[0]
    return known[follower].follows is None and not leader


def _geometry(
    model: Any, b: int, name: str, notes: list[str], mujoco: Any
) -> tuple[list[int], list[int]]:
    """Return the indices of a body's visual and colliding geometries; add notes on omissions."""
    root = model.body_rootid[b]
    joints = model.jnt_type[np.isin(model.jnt_bodyid, np.flatnonzero(model.body_rootid == root))]
    if joints.tolist() == [mujoco.mjtJoint.mjJNT_FREE]:
        notes.append(f"{name}: floats alone and is left out; give it as a body")
        return [], []
    flat = {mujoco.mjtGeom.mjGEOM_PLANE: "plane", mujoco.mjtGeom.mjGEOM_HFIELD: "height field"}
    paired = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}
    sorted_out: tuple[list[int], list[int]] = [], []
    for g in np.flatnonzero(model.geom_bodyid == b).tolist():
        touches = bool(model.geom_contype[g] or model.geom_conaffinity[g] or g in paired)
        kind = flat.get(mujoco.mjtGeom(model.geom_type[g]))
        if kind is None:
            sorted_out[touches].append(g)
        elif touches:
            which = model.geom(g).name or f"geometry of {name}"
            notes.append(f"{which}: a {kind} is left out; give it as an obstacle")
    return sorted_out


def _drive(model: Any, j: int, mujoco: Any) -> Drive:
    """Return the motor of a joint; the strongest of several."""
    d, turns = int(model.jnt_dofadr[j]), model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT
    own = np.flatnonzero(turns & (model.actuator_trnid[:, 0] == j)).tolist()
    forces = [force for a in own if (force := _strongest(model, a)) is not None]
    if model.jnt_actfrclimited[j]:
        forces = [float(np.abs(model.jnt_actfrcrange[j]).max())]
    most = max(forces, default=None)
    return Drive(most, float(model.dof_armature[d]), float(model.dof_damping.ravel()[d]))


def _strongest(model: Any, a: int) -> float | None:
    """Return the largest torque of an actuator, from its limit of force or of its command."""
    gear = abs(float(model.actuator_gear[a, 0]))
    if model.actuator_forcelimited[a]:
        return gear * float(np.abs(model.actuator_forcerange[a]).max())
    if model.actuator_ctrllimited[a] and not np.any(model.actuator_biasprm[a]):
        gain = abs(float(model.actuator_gainprm[a, 0]))
        return gear * gain * float(np.abs(model.actuator_ctrlrange[a]).max())
    return None


def _join(
    model: Any, b: int, names: list[str], links: dict[str, RobotLink],
    joints: list[RobotJoint], mujoco: Any,
) -> None:  # fmt: skip
    """Append the joints of a body: each MuJoCo joint about its anchor, then one fixed joint."""
    parent = names[model.body_parentid[b]]
    pose = _pose(model.body_pos[b], model.body_quat[b])
    first, count = int(model.body_jntadr[b]), int(model.body_jntnum[b])
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    types = {int(hinge): "revolute", int(slide): "prismatic"}
    for j in range(first, first + count):
        name = model.joint(j).name or f"joint {j}"
        kind = types.get(int(model.jnt_type[j]), "free or ball")
        axis, anchor = model.jnt_axis[j], _pose(model.jnt_pos[j], (1.0, 0.0, 0.0, 0.0))
        at = float(model.qpos0[model.jnt_qposadr[j]]) if int(model.jnt_type[j]) in types else 0.0
        low, high = map(float, model.jnt_range[j])
        bounds = (low, high) if model.jnt_limited[j] else None
        if kind == "revolute" and bounds is None:
            kind = "continuous"
        between = f"{names[b]} at {name}"
        links[between] = RobotLink(between, ())
        origin = pose @ anchor @ tree.motion(kind, axis, -at)
        x, y, z = map(float, axis)
        drive = _drive(model, j, mujoco)
        moves = RobotJoint(name, kind, parent, between, origin, (x, y, z), bounds, drive=drive)
        joints.append(moves)
        parent, pose = between, np.linalg.inv(anchor)
    joints.append(RobotJoint(f"{names[b]} (fixed)", "fixed", parent, names[b], pose))


def _pose(place: Any, quaternion: Any) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
    pose[:3, 3] = place
    return pose


def _hulls(model: Any, g: int, mujoco: Any) -> list[Hull]:
    """Return the convex parts of a geometry in the frame of its body."""
    types, size = mujoco.mjtGeom, model.geom_size[g]
    kind = int(model.geom_type[g])
    if kind == types.mjGEOM_SPHERE:
        made = [tree.ball(size[0])]
    elif kind == types.mjGEOM_CAPSULE:
        made = [tree.capsule(size[0], size[1])]
    elif kind == types.mjGEOM_CYLINDER:
        made = [tree.cylinder(size[0], size[1])]
    elif kind == types.mjGEOM_BOX:
        made = [tree.box(2.0 * size)]
    elif kind == types.mjGEOM_ELLIPSOID:
        made = [tree.ellipsoid(size)]
    elif kind in (types.mjGEOM_MESH, types.mjGEOM_SDF):
        m = int(model.geom_dataid[g])
        v, f = int(model.mesh_vertadr[m]), int(model.mesh_faceadr[m])
        vertices = model.mesh_vert[v : v + int(model.mesh_vertnum[m])].astype(float)
        made = tree.mesh(vertices, model.mesh_face[f : f + int(model.mesh_facenum[m])])
    else:
        name = model.geom(g).name or f"geom {g}"
        raise RobotError(f"{name!r}: is no sphere, capsule, cylinder, ellipsoid, box or mesh")
    pose = _pose(model.geom_pos[g], model.geom_quat[g])
    return [hull.moved(pose) for hull in made]
