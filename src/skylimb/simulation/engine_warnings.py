"""The engine's own warnings: each means a state that cannot be trusted."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco


def raised_warnings(counts: Sequence[int]) -> str:
    """What the engine has warned of, in words; empty without a warning. `counts` counts each kind."""
    raised = ", ".join(mujoco.mjtWarning(i).name for i, number in enumerate(counts) if number > 0)
    return f"the physics engine warned ({raised})" if raised else ""
