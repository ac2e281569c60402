"""What is loaded when: a command that answers at once, a flight that pays for no figure."""

import subprocess
import sys

import pytest

HEAVY = {"casadi", "h5py", "jinja2", "matplotlib", "mujoco", "numpy", "pandas", "scipy", "trimesh", "xarray"}
DRAWING = {"PIL", "av", "fontTools", "jinja2", "matplotlib", "rich"}


def loaded_by(code: str) -> set[str]:
    """Packages in memory after some code has run in a fresh interpreter."""
    report = "import sys; sys.stderr.write(' '.join({name.partition('.')[0] for name in sys.modules}))"
    ran = subprocess.run(
        [sys.executable, "-c", f"{code}\n{report}"], capture_output=True, text=True, check=True
    )
    return set(ran.stderr.split())


@pytest.mark.parametrize(
    ("code", "absent"),
    [
        ("import skylimb; skylimb.__version__; dir(skylimb)", HEAVY | DRAWING),
        (
            "import skylimb.analysis.recording, skylimb.studies.campaign, skylimb.studies.reproduction",
            HEAVY | DRAWING,
        ),
        ("from skylimb.apps.cli import main; main(['--help'])", HEAVY | {"PIL", "av", "rich"}),
        ("from skylimb.apps.cli import main; main(['run', '--help'])", HEAVY),
        ("from skylimb.base.files import replace_text", HEAVY | DRAWING),
        ("from skylimb.analysis.scores.metrics import metrics", DRAWING | {"mujoco", "casadi"}),
        ("from skylimb.analysis import write_report, write_videos", {"mujoco", "casadi", "av"}),
        ("import skylimb.flight.plan, skylimb.flight.realtime.fly_robot", DRAWING | {"mujoco", "xarray"}),
        ("import skylimb; skylimb.run", DRAWING),
    ],
)
def test_nothing_is_loaded_before_it_is_needed(code: str, absent: set[str]) -> None:
    assert loaded_by(code) & absent == set()


def test_every_public_name_is_there() -> None:
    """The names of the lazy packages are those of their stubs, and each leads somewhere."""
    code = """
import skylimb
from skylimb.analysis import figures, recording
from skylimb.studies import reproduction
for package in (skylimb, skylimb.analysis, figures, recording, reproduction):
    assert package.__all__ and set(package.__all__) <= set(dir(package))
    for name in package.__all__:
        assert getattr(package, name) is not None, name
    try:
        package.nonsense
    except AttributeError as error:
        assert "nonsense" in str(error)
    else:
        raise SystemExit(1)
"""
    loaded_by(code)
