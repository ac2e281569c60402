"""Laws in a user's file: a traced tick shows what they read and give, held against the other laws."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import skylimb
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError
from skylimb.control.cascade import Cascade
from skylimb.control.contact.laws import following
from skylimb.control.controller import load_controller
from skylimb.control.laws.preset import preset_mapping
from skylimb.robots.model import Robot

HEAD = """
from dataclasses import dataclass
from skylimb.control.needs import Needs
from skylimb.control.records import ContactView
from skylimb.control.estimation.body_state import AngleRateFilter, initial_angle_rate_state, see_body
from skylimb.control.estimation.records import Estimate
from skylimb.base.rotations import rotation_error

@dataclass(frozen=True)
class Gains:
    share: float = 0.0

def initial_state(gains, start):
    return ()
"""
STEP = "def step(gains, state, inputs):\n    pull = {}\n    return state, {}, {}\n"

Load = Callable[..., Cascade]


def view(*fields: str, signals: str = "{}") -> str:
    """A contact law that gives these fields."""
    return STEP.format(0.0, f"ContactView({', '.join(f'{field}=0.0' for field in fields)})", signals)


def force(pull: str) -> str:
    """A translation law that reads what its pull is made of."""
    return STEP.format(
        pull, "inputs.estimate.body.model.mass * inputs.estimate.body.model.gravity + pull", "{}"
    )


FOLLOWED = [name.partition(".")[2] for name in following.PROVIDES]


@pytest.fixture
def load(tmp_path: Path, robot: Robot) -> Load:
    """Loads a preset some of whose slots are filled by laws of the user's own."""

    def build(preset: str, laws: dict[str, str], **gains: Any) -> Any:
        tables, _ = preset_mapping(preset)
        tables.pop("robots", None)
        for slot, body in laws.items():
            (tmp_path / f"{slot}.py").write_text(HEAD + body)
            tables[slot] = {"law": f"{slot}.py"}
        tables["translation"] |= {key: value for key, value in gains.items() if key != "law"}
        file = tmp_path / "own.toml"
        file.write_text(write_toml(tables))
        return load_controller(str(file), robot)

    return build


def test_what_a_users_law_gives_is_seen(load: Load) -> None:
    cascade = load("following", {"contact": view(*FOLLOWED)})
    assert cascade.preset.slots.contact.gives == set(following.PROVIDES)
    changed = cascade.with_gains({"translation.force": 2.0})
    told = r"^here: translation law 'following' needs contact\.across \(translation\.feed = 0\.5\), which"
    with pytest.raises(ConfigError, match=told):
        changed.check_gain("translation.feed", 0.5, "here", 0.005)


CONTACT, TRANSLATION = "contact law 'contact.py'", "translation law 'translation.py'"


@pytest.mark.parametrize(
    ("preset", "slot", "body", "gains", "told"),
    [
        # A law that ships needs what a user's law does not give, and the other way round.
        ("following", "contact", view("engaged"), {}, "shape law 'recentring' needs contact.anchor, which "
         f"{CONTACT} does not give (contact laws that do: drawing, following)"),
        ("following", "contact", view(*FOLLOWED), {"feed": 1.0}, "controller own: translation law "
         f"'following' needs contact.across (translation.feed = 1), which {CONTACT} does not give"),
        ("hybrid", "translation", force("inputs.contact.tip.position"), {}, "line 16, `pull = "
         f"inputs.contact.tip.position`: {TRANSLATION} needs contact.tip, which contact law 'open' does not "
         "give (contact laws that do: task_frame); a law that can do without it names it in OPTIONAL"),
        ("hybrid", "translation", force("inputs.residual.force"), {}, "needs residual, which allocation law "
         "'pseudoinverse' does not give (allocation laws that do: bounded, level, planned, pointed)"),
        ("hybrid", "translation", force("inputs.estimate.bias"), {},
         "estimation laws that do: kalman, moving_horizon, predictive"),
        ("hybrid", "contact", STEP.format("inputs.arm.rate", 0.0, {}), {},
         f"{CONTACT} needs arm.rate, which shape law 'admittance' gives only after it"),
        # A law is not as it declares.
        ("hybrid", "contact", 'PROVIDES = ("contact.anchor",)\n' + view("anchor", "engaged"), {},
         f"{CONTACT} gives contact.engaged, which its PROVIDES does not name"),
        ("task_frame", "contact", 'PROVIDES = ("contact.tip",)\n' + view(), {},
         f"{CONTACT} does not give contact.tip, which its PROVIDES names"),
        ("hybrid", "translation", 'REQUIRES = ("estimate.body",)\n' + force("inputs.estimate.arm[0]"), {},
         f"{TRANSLATION} reads estimate.arm, which its REQUIRES and OPTIONAL do not name"),
        ("hybrid", "translation", 'REQUIRES = ("contact.tip",)\n' + force("0.0"), {},
         f"controller own: {TRANSLATION} needs contact.tip, which contact law 'open' does not give"),
        ("hybrid", "translation", 'OPTIONAL = {"contact.tip": "share"}\n' + force("0.0"), {"share": 0.5},
         "needs contact.tip (translation.share = 0.5), which contact law 'open' does not give"),
        # A declaration names what there is not.
        ("hybrid", "translation", 'OPTIONAL = {"contact.tip": "shore"}\n' + force("0.0"), {}, "mean 'share'"),
        ("hybrid", "translation", 'REQUIRES = ("contact.top",)\n' + force("0.0"), {}, "mean 'contact.tip'"),
        ("hybrid", "contact", 'PROVIDES = ("arm.rate",)\n' + view(), {},
         f"PROVIDES of {CONTACT}: 'arm.rate'"),
        # A law gives no record.
        ("hybrid", "contact", STEP.format(0.0, 0.0, {}), {},
         "step returns one float as its output, expected a ContactView"),
        # The pace.
        ("hybrid", "contact", "def needs(gains):\n    return Needs(paced=True)\n" + view(), {},
         f"{CONTACT} sets the mission's pace, but has no signal 'pace'"),
        ("hybrid", "contact", view(signals="{'pace': 1.0}"), {},
         f"{CONTACT} has a signal 'pace', but its needs do not say paced=True"),
    ],
)  # fmt: skip
def test_users_laws_that_do_not_fit_are_refused_when_they_are_read(
    load: Load, preset: str, slot: str, body: str, gains: dict[str, Any], told: str
) -> None:
    with pytest.raises(ConfigError, match=re.escape(told)):
        load(preset, {slot: body}, **gains)


def test_a_field_that_may_be_absent_is_none(load: Load) -> None:
    body = 'OPTIONAL = {"residual": ""}\n' + force("0.0 if inputs.residual is None else 1.0 / 0.0")
    load("hybrid", {"translation": body})
    with pytest.raises(ConfigError, match="ZeroDivisionError"):
        load("task_frame", {"translation": body})


def test_a_law_may_build_on_one_that_ships(load: Load) -> None:
    own = (
        "from skylimb.control.translation.laws import {0}\n"
        "Gains, initial_state = {0}.Gains, {0}.initial_state\n"
        "def step(gains, state, inputs):\n    return {0}.step(gains, state, inputs)\n"
    )
    load("pid", {"translation": own.format("pid")}, **preset_mapping("pid")[0]["translation"])
    gains = preset_mapping("following")[0]["translation"]
    with pytest.raises(
        ConfigError, match=r"contact\.across.*; a law that can do without it names it in OPTIONAL$"
    ):
        load("following", {"translation": own.format("following")}, **gains)
    whole = own.format("following") + "OPTIONAL = following.OPTIONAL\n"
    load("following", {"translation": whole}, **gains)
    with pytest.raises(ConfigError, match=r"needs contact\.across \(translation\.feed = 1\)"):
        load("following", {"translation": whole}, **{**gains, "feed": 1.0})


def test_an_estimation_without_any_wrench_flies_with_laws_that_need_none(load: Load, tmp_path: Path) -> None:
    seeing = (
        "def initial_state(gains, start):\n    return initial_angle_rate_state(start.robot)\n"
        "def step(gains, state, sensed):\n    state, body = see_body(AngleRateFilter(), state, sensed)\n"
        "    return state, Estimate(body), {}\n"
        "def commanded(gains, state, estimate, rotors, dt):\n    return state\n"
    )
    with pytest.raises(ConfigError, match=r"attitude law 'impedance' needs estimate\.wrench, which est"):
        load("pid", {"estimation": seeing})
    turning = (
        "def step(gains, state, inputs, R_target):\n    body = inputs.estimate.body\n"
        "    e, rate = rotation_error(body.R_WC, R_target), body.angular_velocity\n"
        "    return state, -body.model.inertia_C @ (40.0 * e + 14.0 * rate), {}\n"
    )
    load("pid", {"estimation": seeing, "attitude": turning})
    run = skylimb.run("push", controller=str(tmp_path / "own.toml"))
    assert run.status == "OK"
    assert "external_force_estimate" not in run.log
