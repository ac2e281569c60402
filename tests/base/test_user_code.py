"""Errors in a user's Python come out as one line with the user's file, line and the remedy."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, SkylimbError, UnknownNameError, UserCodeError
from skylimb.base.user_code import UserCode, guarded, is_users
from skylimb.control.laws.slots import find_law, load_module
from skylimb.control.laws.user_functions import traceable
from skylimb.robots.loader import load_robot

SYMBOL = ca.SX.sym("x", 3)


def users(folder: Path, body: str, imports: str = "") -> Callable[..., Any]:
    """A function `mine(x)` in a file of the user's; its body begins on line 4."""
    file = folder / "mine.py"
    file.write_text(f"{imports}\n\ndef mine(x):\n    {body}\n", encoding="utf-8")
    return load_module(file, ("mine",)).mine


@pytest.mark.parametrize(
    ("imports", "body", "told"),
    [
        (
            "",
            "return 1.0 if x[0] > 0.0 else 2.0",
            "`return 1.0 if .*`: this is known only in flight: .*where",
        ),
        ("", "return max(x[0], 0.0)", r"skylimb\.symbolic\.where\(condition, if_true, if_false\)$"),
        ("", "return x @ x", "incompatible dimensions.*; vectors are columns here: .*dot"),
        ("", "return [1.0, 2.0][x[0]]", "list indices.*needed before the flight"),
        ("import numpy as np", "np.zeros(3)[:] = x", r"`: NumPy arrays take no symbols: .*vector, matrix"),
        ("", "a, b, c = x", r"not iterable.*; take the entries by their index, as in x\[0\]"),
        ("import numpy as np", "return np.isfinite(x)", r"numpy\.isfinite.*; skylimb\.symbolic has"),
        ("import numpy as np", "return np.linalg.inv(np.zeros((3, 3)))", "`: LinAlgError: Singular matrix$"),
        (
            "",
            "return x.nothing",
            "'SX' object has no attribute 'nothing'; skylimb.symbolic has",
        ),
        ("", "return 1 / 0", "ZeroDivisionError: division by zero$"),
        (
            "from skylimb.control.estimation.records import Wrench",
            "return Wrench(x, x).forces",
            r"'Wrench' object has no attribute 'forces'; did you mean 'force'\? \(known: force, torque\)$",
        ),
        (
            "from skylimb.control.estimation.records import Wrench",
            "return Wrench(x, x).moment",
            r"has no attribute 'moment'.*\(known: force, torque\)$",
        ),
        ("import math", "return math.sine", r"has no attribute 'sine'; did you mean 'sin'\?$"),
        ("", "from .tools import x", "relative import.*; files beside it are imported by their names, as in"),
    ],
)
def test_an_error_names_the_users_line_and_the_remedy(
    tmp_path: Path, imports: str, body: str, told: str
) -> None:
    with pytest.raises(UserCodeError, match=told) as caught:
        traceable(users(tmp_path, body, imports), "law 'mine.py'")(SYMBOL)
    assert str(caught.value).startswith("law 'mine.py' fails in ")
    assert "mine.py, line 4, `" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.__cause__ is not None


def test_the_deepest_line_of_the_user_counts(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("def twice(x):\n    return 2.0 * x['a']\n", encoding="utf-8")
    twice = load_module(tmp_path / "helper.py", ("twice",)).twice
    with pytest.raises(UserCodeError, match=r"helper\.py, line 2, `return 2.0 \* x\['a'\]`: KeyError: 'a'"):
        guarded(lambda: twice({}), "law")()


def test_errors_of_skylimbs_own_checks_pass(tmp_path: Path) -> None:
    """What the user raises on purpose as a SkylimbError, and what no line of the user's has part in."""
    own = users(tmp_path, "raise ConfigError('so')", "from skylimb.base.errors import ConfigError")
    with pytest.raises(ConfigError) as caught:
        guarded(own, "law")(1)
    assert str(caught.value) == "so"
    with pytest.raises(UnknownNameError, match=r"^unknown robot 'x'"):
        guarded(load_robot, "law")("x")


def test_an_error_of_skylimbs_below_a_users_line_names_the_line(tmp_path: Path) -> None:
    body = "return load_robot('no_such_robot')"
    own = users(tmp_path, body, "from skylimb import load_robot")
    with pytest.raises(UserCodeError, match=r"line 4, `return load_robot.*`: unknown robot 'no_such_robot'"):
        guarded(own, "law")(1)


def test_a_syntax_error_names_its_own_line(tmp_path: Path) -> None:
    with pytest.raises(UserCodeError, match=r"mine\.py, line 4, `return \(`: SyntaxError: '\(' was never"):
        users(tmp_path, "return (")


def test_ctrl_c_is_no_error_of_the_user() -> None:
    with pytest.raises(KeyboardInterrupt), UserCode("law"):
        raise KeyboardInterrupt


def test_whose_a_file_is() -> None:
    assert is_users(__file__)
    assert is_users("<ipython-input-3>")
    assert not any(map(is_users, (np.__file__, Path.__module__ and load_module.__code__.co_filename)))
    assert not any(map(is_users, ("<string>", "<frozen importlib>", "/x/dist-packages/y.py")))


def test_a_symbol_is_no_float() -> None:
    def mine(x: Any) -> Any:
        whole = np.zeros(3)
        whole[0] = x[0]
        return (), 2.0 * x, {"fine": x, "mine": x * whole}

    told = r"^law fails in .*, line \d+, `whole\[0\] = x\[0\]`: float\(\), the functions of math and writing"
    with pytest.raises(UserCodeError, match=told):
        traceable(mine, "law")(SYMBOL)
    assert np.isnan(float(SYMBOL[0])), "symbols are as CasADi has them outside"
    np.testing.assert_array_equal(traceable(float, "law")(SYMBOL[0] * 0.0 + 2.0), 2.0)


LAW = """
from dataclasses import dataclass
@dataclass(frozen=True)
class Gains: ...
def initial_state(gains, start): return ()
def step(gains, state, inputs):
    return state, inputs, {}
"""


def test_a_law_is_loaded_anew_when_its_file_has_changed(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(LAW, encoding="utf-8")
    first = find_law("translation", "mine.py", tmp_path)
    assert find_law("translation", "mine.py", tmp_path).step is first.step
    (tmp_path / "mine.py").write_text(LAW.replace("inputs, {}", "3 * inputs, {}"), encoding="utf-8")
    assert first.step((), (), 2.0)[1] == 2.0
    assert find_law("translation", "mine.py", tmp_path).step((), (), 2.0)[1] == 6.0


def test_the_command_line_shows_the_traceback_when_it_is_wanted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.py"
    file.write_text("def controller(robot):\n    return 1 / 0\n", encoding="utf-8")
    command = ["run", "--controller", str(file), "--no-video", "--out", str(tmp_path / "out")]
    assert main(command) == 2
    short = capsys.readouterr().err
    assert short.count("\n") == 1
    assert "mine.py, line 2, `return 1 / 0`: ZeroDivisionError" in short
    assert main([*command, "--debug"]) == 2
    long = capsys.readouterr().err
    assert long.endswith(short)
    assert "Traceback (most recent call last)" in long
    assert "ZeroDivisionError: division by zero\n" in long
    assert isinstance(UserCodeError("x"), SkylimbError)
