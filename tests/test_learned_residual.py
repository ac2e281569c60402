"""A learned residual: its policy flies as a law, is refused where it does not fit, and training resumes."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.base.user_modules import load_module
from skylimb.studies.envs.tasks import SHORT

EXAMPLE = Path(__file__).parents[1] / "examples" / "learning"
BRIEF = {**SHORT, "stop_at": 3.0}


def residual() -> ModuleType:
    return load_module(EXAMPLE / "residual.py", ("step",))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The law and its preset, with a policy of random weights."""
    for name in ("residual.py", "residual.toml"):
        shutil.copy(EXAMPLE / name, tmp_path / name)
    (tmp_path / "policy.json").write_text(residual().policy_text("hydrus_xi_quad", random_layers()))
    return tmp_path


def random_layers() -> list[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(3)
    sizes = (10, 6, 2)
    return [(rng.normal(size=(m, n)), rng.normal(size=m)) for n, m in pairwise(sizes)]


def test_a_policy_flies_as_a_law_that_is_compiled(folder: Path) -> None:
    controller: Any = skylimb.load_controller(
        str(folder / "residual.toml"), skylimb.load_robot("hydrus_xi_quad")
    )
    assert not controller.in_python
    run = skylimb.run("paper", str(folder / "residual.toml"), set=BRIEF)
    seen = run.log.policy_observation.values
    (w1, b1), (w2, b2) = random_layers()
    said = np.clip(np.tanh(seen @ w1.T + b1) @ w2.T + b2, -1.0, 1.0)
    assert np.ptp(said) > 0.1
    np.testing.assert_allclose(run.log.policy_offset.values, 0.02 * said, atol=1e-12)


def test_without_its_share_it_is_following(folder: Path) -> None:
    silent = {**BRIEF, "controller.translation.share": 0.0}
    run = skylimb.run("paper", str(folder / "residual.toml"), set=silent)
    plain = skylimb.run("paper", "following", set=BRIEF)
    np.testing.assert_allclose(run.log.configuration.values, plain.log.configuration.values, atol=1e-9)


def changed(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda told: told.__setitem__(key, value)


def no_number(told: dict[str, Any]) -> None:
    told["layers"][1]["bias"][0] = float("nan")


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (changed("robot", "dragon"), "robot is 'dragon', this law needs 'hydrus_xi_quad'"),
        (changed("version", 2), "version is 2, this law needs 1"),
        (changed("format", "skylimb calibration"), "format is 'skylimb calibration'"),
        (changed("observation", [["tip_error", 2, 0.02]]), "observation is"),
        (lambda told: told.pop("robot"), "is no policy: KeyError"),
        (lambda told: told["layers"][0]["bias"].pop(), "layer 0 has the wrong shape"),
        (lambda told: told["layers"].pop(), "it says 6 numbers, this law needs 2"),
        (no_number, "layer 1 has the wrong shape, or is not finite"),
    ],
)
def test_a_policy_that_does_not_fit_is_refused(
    folder: Path, spoil: Callable[[dict[str, Any]], None], words: str
) -> None:
    told = json.loads((folder / "policy.json").read_text())
    spoil(told)
    (folder / "policy.json").write_text(json.dumps(told))
    with pytest.raises(ConfigError) as caught:
        skylimb.run("paper", str(folder / "residual.toml"), set=BRIEF)
    assert words in str(caught.value)
    assert "policy.json" in str(caught.value)


def test_a_policy_that_is_not_there_is_missed(folder: Path) -> None:
    (folder / "policy.json").unlink()
    with pytest.raises(ConfigError, match=r"no such file: .*policy\.json"):
        skylimb.run("paper", str(folder / "residual.toml"), set=BRIEF)


@pytest.mark.slow
def test_a_training_that_was_killed_ends_with_the_same_weights(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3")

    def trained(out: str, *rounds: int) -> bytes:
        for number in rounds:
            code = (
                f"import sys; sys.path.insert(0, {str(EXAMPLE)!r}); from pathlib import Path; import train; "
                f"train.train(Path({str(tmp_path / out)!r}), {number}, count=2, steps=64, threads=1)"
            )
            subprocess.run([sys.executable, "-c", code], check=True)
        return (tmp_path / out / "policy.json").read_bytes()

    assert trained("whole", 3) == trained("parts", 1, 3)
    assert (tmp_path / "parts" / "curve.csv").read_text().count("\n") == 4
