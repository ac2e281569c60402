"""MJCF as a URDF: MuJoCo reads and compiles it, and what it holds then is written down body by body.

Rotors are the actuators that push at a site, as in MuJoCo's own models: force and torque for 1 of control
stand in `gear`. A mesh is drawn as the box around it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np

from skylimb.apps.robot_import.mapping import MappedRotor
from skylimb.apps.robot_import.tree import add_joint, origin, rpy_of_z, write_inertia
from skylimb.base.config import from_mapping
from skylimb.base.errors import DescriptionError
from skylimb.base.rotations import rotation_from_quaternion

_KINDS = {int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic", int(mujoco.mjtJoint.mjJNT_HINGE): "revolute"}
_LAGS = {int(mujoco.mjtDyn.mjDYN_FILTER), int(mujoco.mjtDyn.mjDYN_FILTEREXACT)}
_BALL, _CAPSULE, _CYLINDER = (
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{kind}")) for kind in ("SPHERE", "CAPSULE", "CYLINDER")
)


def read_mjcf(path: Path) -> tuple[bytes, tuple[MappedRotor, ...]]:
    """The robot of an MJCF file as a URDF, and its rotors.

    Raises:
        DescriptionError: MuJoCo refuses the file, or it is no tree of joints that turn or slide.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        model = spec.compile()
    except Exception as error:  # the reader lets several kinds through
        raise DescriptionError(f"MuJoCo cannot read '{path.name}': {' '.join(str(error).split())}") from None
    return _Written(model, spec.modelname, path.name).parts()


class _Written:
    """One compiled model, written as links and joints."""

    def __init__(self, model: Any, name: str, where: str) -> None:
        self._model, self._where = model, where
        self._robot = Element("robot", {"name": name})
        self._bodies = [model.body(k).name or f"body{k}" for k in range(model.nbody)]

    def parts(self) -> tuple[bytes, tuple[MappedRotor, ...]]:
        """The URDF and the rotors."""
        model, mimics = self._model, self._mimics()
        base = self._base()
        inside = [k for k in range(1, model.nbody) if model.body_rootid[k] == base]
        for k in inside:
            self._link(k)
            if k != base:
                self._joints(k, mimics)
        rotors = tuple(filter(None, (self._rotor(k) for k in range(model.nactuator))))
        return ElementTree.tostring(self._robot), rotors

    def _base(self) -> int:
        """The body that flies: the only one that stands in the world, or the only one that is free there."""
        model = self._model
        tops = [k for k in range(1, model.nbody) if model.body_parentid[k] == 0]
        free = [k for k in tops if model.body_dofnum[k] == 6]
        found = free or tops
        if len(found) != 1:
            names = ", ".join(self._bodies[k] for k in found) or "none"
            raise DescriptionError(f"'{self._where}' needs one body that flies; found: {names}")
        return found[0]

    def _mimics(self) -> dict[int, float]:
        """Joints that others move, and where they are while the others are at rest."""
        model, found = self._model, dict[int, float]()
        for k in range(model.neq):
            if model.eq_type[k] != mujoco.mjtEq.mjEQ_JOINT:
                what = model.equality(k).name or f"number {k}"
                raise DescriptionError(
                    f"constraint '{what}' of '{self._where}' closes a loop; trees are read"
                )
            found[int(model.eq_obj1id[k])] = float(model.eq_data[k][0])
        return found

    def _link(self, k: int) -> None:
        model = self._model
        link = SubElement(self._robot, "link", {"name": self._bodies[k]})
        if model.body_mass[k] > 0.0:
            inertial = SubElement(link, "inertial")
            R = rotation_from_quaternion(model.body_iquat[k])
            inertial.append(origin(model.body_ipos[k], np.eye(3)))
            SubElement(inertial, "mass", {"value": repr(float(model.body_mass[k]))})
            write_inertia(SubElement(inertial, "inertia"), R @ np.diag(model.body_inertia[k]) @ R.T)
        for geom in np.flatnonzero(model.geom_bodyid == k).tolist():
            touches = model.geom_contype[geom] or model.geom_conaffinity[geom]
            for tag in ("visual", *(["collision"] if touches else [])):
                shown = SubElement(link, tag)
                xyz, R = model.geom_pos[geom], rotation_from_quaternion(model.geom_quat[geom])
                kind, said, middle = _shape(model, geom)
                shown.append(origin(xyz + R @ middle, R))
                SubElement(SubElement(shown, "geometry"), kind, said)

    def _joints(self, k: int, mimics: dict[int, float]) -> None:
        """The joints of a body, one after another from its parent's link: each turns about its own anchor."""
        model, child = self._model, self._bodies[k]
        at, xyz = self._bodies[model.body_parentid[k]], model.body_pos[k]
        R = rotation_from_quaternion(model.body_quat[k])
        first, count = int(model.body_jntadr[k]), int(model.body_jntnum[k])
        anchor = np.zeros(3)
        for j in range(first, first + count):
            name = model.joint(j).name or f"{child}_joint{j - first + 1}"
            kind = _KINDS.get(int(model.jnt_type[j]))
            if kind is None:
                raise DescriptionError(
                    f"joint '{name}' of '{self._where}' neither turns about one axis nor slides"
                )
            here = model.jnt_pos[j]
            last = j == first + count - 1 and not here.any()
            onto = child if last else f"{child}_{name}"
            if not last:
                SubElement(self._robot, "link", {"name": onto})
            limited = bool(model.jnt_limited[j])
            joint = add_joint(
                self._robot,
                name,
                kind if limited or kind == "prismatic" else "continuous",
                at,
                onto,
                xyz + R @ (here - anchor),
                R,
            )
            SubElement(joint, "axis", {"xyz": _text(model.jnt_axis[j])})
            SubElement(joint, "limit", dict(self._limit(j, limited)))
            if j in mimics:
                SubElement(joint, "mimic", {"joint": name, "offset": repr(mimics[j])})
            dof = int(model.jnt_dofadr[j])
            damping, friction = float(model.dof_damping[dof]), float(model.dof_frictionloss[dof])
            SubElement(joint, "dynamics", {"damping": repr(damping), "friction": repr(friction)})
            at, xyz, R, anchor = onto, np.zeros(3), np.eye(3), here
        if at != child:
            add_joint(self._robot, f"{child}_fixed", "fixed", at, child, xyz - R @ anchor, R)

    def _limit(self, j: int, limited: bool) -> Iterator[tuple[str, str]]:
        """Travel beside the angle at which the file shows the joint, and the torque of all that drives it.

        What nobody commands is friction, no drive.
        """
        model = self._model
        if limited:
            travel = model.jnt_range[j] - model.qpos0[model.jnt_qposadr[j]]
            yield from zip(("lower", "upper"), (repr(float(end)) for end in travel), strict=True)
        drives = (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT) & (model.actuator_trnid[:, 0] == j)
        drives &= model.actuator_ctrlnum > 0
        ends = list[float]()
        if drives.any() and model.actuator_forcelimited[drives].all():
            gear = np.abs(model.actuator_gear[model.actuator_outadr, 0])
            ends.append(float((model.actuator_forcerange[:, 1] * gear)[drives].sum()))
        if model.jnt_actfrclimited[j]:
            ends.append(float(model.jnt_actfrcrange[j, 1]))
        if ends:
            yield "effort", repr(min(ends))

    def _rotor(self, u: int) -> MappedRotor | None:
        """The rotor that an actuator is, with a link of its own at the actuator's site; None for others."""
        model = self._model
        at_site = model.actuator_trntype[u] == mujoco.mjtTrn.mjTRN_SITE
        if not at_site or model.actuator_ctrlnum[u] != 1 or model.actuator_outnum[u] != 1:
            return None
        control = int(model.actuator_ctrladr[u])
        force, torque = np.split(model.actuator_gear[model.actuator_outadr[u]], 2)
        size = float(np.linalg.norm(force))
        what = f"actuator '{model.actuator(u).name}' of '{self._where}'"
        if not np.isfinite(model.actuator_gear[model.actuator_outadr[u]]).all():
            raise DescriptionError(f"gear of {what} is no number")
        if size == 0.0 or not model.actuator_ctrllimited[control]:
            return None
        site = int(model.actuator_trnid[u, 0])
        name = model.site(site).name or model.actuator(u).name or f"site{site}"
        name = f"{name}_site" if name in self._bodies else name
        SubElement(self._robot, "link", {"name": name})
        body = self._bodies[model.site_bodyid[site]]
        place = model.site_pos[site], rotation_from_quaternion(model.site_quat[site])
        add_joint(self._robot, f"{name}_fixed", "fixed", body, name, *place)
        drag = float(force @ torque) / size**2
        gain = size * float(model.actuator_gainprm[u, 0])
        least, most = (gain * float(end) for end in model.actuator_ctrlrange[control])
        said: dict[str, Any] = {
            "link": name,
            "spin": -int(np.sign(drag)) or None,
            "drag_torque_coefficient": abs(drag),
            "thrust_min": max(least, 0.0),
            "thrust_max": most,
            "rpy": rpy_of_z(force / size),
        }
        if int(model.actuator_dyntype[u]) in _LAGS:
            said["lag"] = float(model.actuator_dynprm[u, 0])
        return from_mapping(MappedRotor, said, what)


def _shape(model: Any, geom: int) -> tuple[str, dict[str, str], np.ndarray]:
    """Tag, sizes and middle of a geom; the box around what URDF has no shape for."""
    size, kind = model.geom_size[geom], int(model.geom_type[geom])
    if kind == _BALL:
        return "sphere", {"radius": repr(float(size[0]))}, np.zeros(3)
    if kind in (_CAPSULE, _CYLINDER):
        length = 2.0 * float(size[1] + (size[0] if kind == _CAPSULE else 0.0))
        return "cylinder", {"radius": repr(float(size[0])), "length": repr(length)}, np.zeros(3)
    middle, half = np.split(model.geom_aabb[geom], 2)
    return "box", {"size": _text(2.0 * half)}, middle


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)
