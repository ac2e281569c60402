"""A quadrotor with an arm of two joints as an SDF that uses frames, an include and poses of all kinds."""

from pathlib import Path

LINK = """<link name="{name}"><pose{seen}>{pose}</pose><inertial><pose>{middle}</pose><mass>{mass}</mass>
<inertia><ixx>{i}</ixx><iyy>{i}</iyy><izz>{i}</izz><ixy>{cross}</ixy></inertia></inertial>
<visual name="shape"><pose>{middle}</pose><geometry>{shape}</geometry></visual></link>
"""
JOINT = """<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{pose}
<axis><xyz{seen}>{axis}</xyz><limit><lower>{low}</lower><upper>{high}</upper><effort>5</effort></limit>
<dynamics><damping>0.02</damping></dynamics></axis></joint>
"""
PLUGIN = """<plugin filename="gz-sim-multicopter-motor-model-system" name="motor{k}">
<jointName>spin_{name}</jointName><linkName>{name}</linkName><turningDirection>{way}</turningDirection>
<timeConstantUp>0.0125</timeConstantUp><timeConstantDown>0.025</timeConstantDown>
<maxRotVelocity>1000</maxRotVelocity><motorConstant>8.5e-06</motorConstant>
<momentConstant>0.016</momentConstant><motorNumber>{k}</motorNumber></plugin>
"""
PLACES = {"fr": (0.2, -0.2), "bl": (-0.2, 0.2), "fl": (0.2, 0.2), "br": (-0.2, -0.2)}


def _link(name: str, pose: str, mass: float, shape: str, **more: object) -> str:
    said = {"seen": "", "middle": "0.01 0 0.02 0 0 0", "i": 0.01 * mass, "cross": 0.001 * mass, **more}
    return LINK.format(name=name, pose=pose, mass=mass, shape=shape, **said)


def _body() -> str:
    """What is in the model of the body: its base stands off the model's origin, and is turned."""
    box = "<box><size>0.2 0.1 0.06</size></box>"
    disc = "<cylinder><radius>0.12</radius><length>0.01</length></cylinder>"
    parts = ["<pose>0 0 0.4 0 0 0</pose>", _link("base", "0.1 0 0.24 0 0 0.3", 1.2, box)]
    for k, (name, (x, y)) in enumerate(PLACES.items()):
        at = ' relative_to="base"'
        parts.append(_link(name, f"{x} {y} 0.05 0 0 0", 0.02, disc, seen=at, middle="0 0 0 0 0 0", cross=0.0))
        ends = {"low": -1e16, "high": 1e16}
        spin = {"name": f"spin_{name}", "kind": "revolute", "parent": "base", "child": name, "pose": ""}
        parts.append(JOINT.format(**spin, seen="", axis="0 0 1", **ends))
        parts.append(PLUGIN.format(name=name, k=k, way="ccw" if k < 2 else "cw"))
    return "".join(parts)


def _arm() -> str:
    """What is in the model of the arm, beside the body that it includes.

    Its first joint stands off its child's frame, the second's axis is said in the model's; a capsule and an
    ellipsoid come along, and a frame at the end.
    """
    capsule = "<capsule><radius>0.0625</radius><length>0.25</length></capsule>"
    ball = "<ellipsoid><radii>0.02 0.02 0.1</radii></ellipsoid>"
    arm = [
        '<frame name="mount" attached_to="base"><pose>0.1 0 0 0 0 0</pose></frame>',
        _link("upper", "0.15 0 0 0 0.2 0", 0.1, capsule, seen=' relative_to="mount"'),
        _link("lower", "0.3 0 0 0 0 0", 0.1, ball, seen=' relative_to="elbow_pitch"'),
    ]
    seen = {"kind": "revolute", "low": -1.5, "high": 1.5}
    shoulder = {"name": "shoulder_pitch", "parent": "mount", "child": "upper", "axis": "0 1 0", "seen": ""}
    arm.append(JOINT.format(**seen, **shoulder, pose="<pose>-0.15 0 0.01 0 0.1 0</pose>"))
    elbow = {"name": "elbow_pitch", "parent": "upper", "child": "lower", "axis": "-0.6 0.8 0"}
    at = '<pose relative_to="upper">0.3 0 0 0 -0.2 0</pose>'
    arm.append(JOINT.format(**seen, **elbow, seen=' expressed_in="__model__"', pose=at))
    arm.append('<frame name="tool0" attached_to="lower"><pose>0.3 0 0 0 0 0</pose></frame>')
    return "".join(arm)


def _model(name: str, content: str) -> str:
    return f'<?xml version="1.0"?>\n<sdf version="1.9"><model name="{name}">{content}</model></sdf>'


def whole_sdf() -> str:
    """Body and arm in one model."""
    return _model("whole", _body() + _arm())


def write_sdf(folder: Path) -> Path:
    """`folder/armed/model.sdf`, which includes the body beside it, turned over its yaw."""
    include = (
        '<include merge="true"><uri>model://body</uri><pose degrees="true">0 0 1 0 0 20</pose></include>'
    )
    for name, content in (("armed", include + _arm()), ("body", _body())):
        (folder / name).mkdir()
        (folder / name / "model.sdf").write_text(_model(name, content), encoding="utf-8")
        config = f"<model><name>{name}</name><version>1</version><sdf version='1.9'>model.sdf</sdf></model>"
        (folder / name / "model.config").write_text(config, encoding="utf-8")
    return folder / "armed" / "model.sdf"
