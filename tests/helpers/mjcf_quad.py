"""A quadrotor with an arm of two joints as an MJCF file, its joints' anchors beside their bodies' origins."""

SITES = "".join(
    f'<site name="thrust{k}" pos="{x} {y} 0.05" zaxis="{0.1 * x} 0 1"/>'
    for k, (x, y) in enumerate(((0.2, 0.2), (0.2, -0.2), (-0.2, -0.2), (-0.2, 0.2)), 1)
)
MOTORS = "".join(
    f'<general name="motor{k}" site="thrust{k}" gear="0 0 1 0 0 {0.02 * (-1) ** k}" ctrlrange="0.2 13" '
    'ctrllimited="true" dyntype="filter" dynprm="0.03"/>'
    for k in range(1, 5)
)
QUAD = f"""<mujoco model="arm quad"><compiler angle="radian"/>
<worldbody><geom type="plane" size="1 1 1"/>
<body name="base" pos="0 0 1"><freejoint/><inertial pos="0.01 0 0" mass="1.3" diaginertia="0.02 0.03 0.04"/>
<geom name="hull" type="box" size="0.1 0.08 0.03"/>{SITES}
<body name="upper" pos="0 0 -0.05" euler="0.1 0.2 0.3">
<joint name="shoulder" axis="0 1 0" pos="0.01 0 0.02" range="-1.5 1.5" damping="0.1" actuatorfrcrange="-4 4"/>
<geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.01" mass="0.1"/>
<body name="lower" pos="0.2 0 0"><joint name="elbow" axis="0 1 0" range="-2 2"/>
<geom type="cylinder" fromto="0 0 0 0.2 0 0" size="0.01" mass="0.05"/>
<body name="finger" pos="0.2 0 0"><joint name="grip" type="slide" axis="1 0 0" range="0.01 0.05"/>
<geom type="sphere" size="0.01" mass="0.01"/></body></body></body></body></worldbody>
<actuator>{MOTORS}<position joint="elbow" kp="50" forcerange="-3 3" gear="2"/></actuator></mujoco>"""

MAPPING = 'joints = [{ name = "shoulder", role = "shape" }, { name = "elbow", role = "shape" }]\n'
