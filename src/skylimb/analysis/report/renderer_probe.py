"""Whether this machine can draw without a window, in a process of its own: exit code 0 when it can.

How MuJoCo draws is settled by MUJOCO_GL when it is first imported, and a broken graphics driver may crash.
"""

import sys

import mujoco

_SCENE = "<mujoco><worldbody><light/><geom size='.1'/></worldbody></mujoco>"


def main() -> int:
    """Draw one small picture."""
    model = mujoco.MjModel.from_xml_string(_SCENE)
    with mujoco.Renderer(model, 16, 16) as renderer:
        renderer.update_scene(mujoco.MjData(model))
        return 0 if renderer.render().shape == (16, 16, 3) else 1


if __name__ == "__main__":
    sys.exit(main())
