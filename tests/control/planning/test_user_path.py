"""A path of a user's own: sampled, smooth, and refused where it cannot be flown."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.planning.trajectories import trajectory
from skylimb.control.planning.trajectory_config import TrajectoryConfig
from skylimb.control.planning.user_path import spelled_out, user_path
from skylimb.flight.experiments.experiment import load_experiment

HEART = {"file": str(Path(__file__).parents[3] / "examples" / "user_path.py"), "function": "heart"}

Write = Callable[..., str]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def written(body: str) -> str:
        (tmp_path / "mine.py").write_text(
            f"import numpy as np\n\n\ndef mine(t):\n    {body}\n", encoding="utf-8"
        )
        return str(tmp_path / "mine.py")

    return written


def test_a_function_of_time_is_flown_with_its_derivatives(write: Write) -> None:
    file = write("return 0.1 * np.sin(t), 0.1 * np.cos(t)")
    config = TrajectoryConfig(shape="own", file=file, function="mine", duration=6.0, speed=0.11)
    path, t = trajectory(config), np.linspace(0.5, 5.5, 101)
    place, velocity, acceleration = path.sample(t)
    assert path.duration == 6.0
    np.testing.assert_allclose(place, 0.1 * np.stack([np.sin(t), np.cos(t)], 1), atol=1e-9)
    np.testing.assert_allclose(velocity, 0.1 * np.stack([np.cos(t), -np.sin(t)], 1), atol=1e-7)
    np.testing.assert_allclose(acceleration, -place, atol=1e-4)
    back = trajectory(
        TrajectoryConfig(shape="own", file=file, function="mine", duration=6.0, direction=-1, speed=0.11)
    )
    np.testing.assert_allclose(back.sample(t)[0], path.sample(6.0 - t)[0], atol=1e-9)
    assert [source.path for source in config.sources] == [Path(file).resolve()]


def test_one_array_does_as_well(write: Write) -> None:
    spline = user_path(write("return np.stack([0.01 * t, 0 * t], axis=1)"), "mine", 2.0, 1, 0.1, 0.3)
    np.testing.assert_allclose(spline(np.array(1.0))[0], [0.01, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "return 0.5 * t, 0 * t",
            r"path 'mine' of 'mine\.py' needs 0\.5 m/s at t = .*; trajectory\.speed = 0\.1 m/s",
        ),
        ("return 0.01 * np.sin(9 * t), 0 * t", r"needs 0\.81 m/s\^2 at .*trajectory\.acceleration = 0\.3"),
        ("return np.where(t < 1, 0.0, 0.2), 0 * t", r"jumps by 0\.2 m at t = 0\.9"),
        ("return np.sqrt(t - 1), 0 * t", r"is \[nan, 0\.0\] at t = 0\.000 s, no finite place"),
        (
            "return 0.01 * t + 0j, 0 * t",
            r"path 'mine' of 'mine\.py' returned complex numbers, expected real ones",
        ),
        (
            "return 0.01 * np.random.rand() * t, 0 * t",
            r"gives other places when it is called again: .*with a seed",
        ),
        ("return t", r"should return u and v for every time: .* it returned \(401,\)"),
        ("return t.nothing", r"fails in .*mine\.py, line 5, `return t\.nothing`: AttributeError"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_what_cannot_be_flown_is_refused(write: Write, body: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        user_path(write(body), "mine", 2.0, 1, 0.1, 0.3)


def test_the_short_form_names_file_and_function(write: Write, tmp_path: Path) -> None:
    file = write("return 0 * t, 0 * t")
    long = {"shape": "own", "file": file, "function": "mine", "radius": 1.0}
    assert spelled_out({"shape": f"{file}:mine", "radius": 1.0}) == long
    assert spelled_out({"shape": "circle"}) == {"shape": "circle"}
    experiment = load_experiment("paper", {"trajectory.shape": f"{file}:mine"})
    assert (experiment.trajectory.shape, experiment.trajectory.function) == ("own", "mine")
    (tmp_path / "mine.toml").write_text('[trajectory]\nshape = "mine.py:mine"\n', encoding="utf-8")
    assert load_experiment(str(tmp_path / "mine.toml")).trajectory.file == file


def here(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 0 * t, 0 * t


def test_a_function_at_hand_is_named_by_its_file() -> None:
    experiment = load_experiment("paper", {"trajectory.shape": here})
    assert (experiment.trajectory.file, experiment.trajectory.function) == (__file__, "here")
    with pytest.raises(ConfigError, match="is a function in a file, so that the run can be flown again"):
        load_experiment("paper", {"trajectory.shape": lambda t: (t, t)})


@pytest.mark.parametrize("missing", ["file", "function"])
def test_it_needs_file_and_function(missing: str) -> None:
    file, function = ("" if missing == key else value for key, value in HEART.items())
    with pytest.raises(ConfigError, match=r"trajectory\.shape = 'own' needs"):
        TrajectoryConfig(shape="own", file=file, function=function)
