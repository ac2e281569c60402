"""Descriptions in the laboratory's style, made up small."""

from made_robots import link

DUMMY = (
    '<link name="{name}"><inertial><mass value="0.00001"/>'
    '<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>\n'
)
FIXED = (
    '<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{xyz}"/></joint>\n'
)
MOVING = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{xyz}"/><axis xyz="{axis}"/><limit {limit}/></joint>\n'
)


def lab_urdf(*, gimbal: str = "continuous", extra: str = "", dust: float = 1e-6, name: str = "rotor") -> str:
    """A quadrotor with vectoring rotors in the laboratory's style: dummy root, thrust limits on the axles."""
    parts = [
        '<baselink name="fc"/><thrust_link name="thrust"/><m_f_rate value="-0.0172"/>\n',
        DUMMY.format(name="root", i=1e-6),
        FIXED.format(name="root_joint", parent="root", child="main", xyz="0 0 0.01"),
        link("main", 1.0, gyration=0.1),
        link("battery", 0.3, gyration=0.03),
        FIXED.format(name="main2battery", parent="main", child="battery", xyz="0 0 -0.04"),
    ]
    for k in range(4):
        x, y = (0.2, 0.2, -0.2, -0.2)[k], (0.2, -0.2, -0.2, 0.2)[k]
        limit = 'lower="-1.5" upper="1.5"' if gimbal == "revolute" else ""
        parts.append(link(f"arm{k + 1}", 0.05, gyration=0.02))
        parts.append(
            MOVING.format(
                name=f"gimbal{k + 1}",
                kind=gimbal,
                parent="main",
                child=f"arm{k + 1}",
                xyz=f"{x} {y} 0.02",
                axis="1 0 0" if k % 2 else "0 1 0",
                limit=f'{limit} effort="3" velocity="8"',
            )
        )
        parts.append(DUMMY.format(name=f"thrust{k + 1}", i=dust))
        parts.append(
            MOVING.format(
                name=f"{name}{k + 1}",
                kind="continuous",
                parent=f"arm{k + 1}",
                child=f"thrust{k + 1}",
                xyz="0 0 0.03",
                axis=f"0 0 {-1 if k % 2 else 1}",
                limit='effort="100" lower="0.5" upper="12" velocity="0.5"',
            )
        )
    return f'<?xml version="1.0"?>\n<robot name="lab quad">\n{"".join(parts)}{extra}</robot>\n'
