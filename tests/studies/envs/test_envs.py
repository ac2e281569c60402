"""Environments keep Gymnasium's rules, and fly what the native driver flies."""

import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from skylimb.base.errors import ConfigError, UnknownNameError, UserCodeError
from skylimb.envs import REWARDS, TASKS, Fleet, FlightEnv, FlightVectorEnv, reward
from skylimb.flight.drivers.native.fly import fly_native
from skylimb.flight.drivers.native.lockstep import LockStep
from skylimb.flight.takeoff import take_off
from skylimb.studies.envs.tasks import SHORT

FORCE = {"translation.force": (0.5, 2.0)}
VARIED = {
    "vary": {"surface.friction": {"uniform": [0.1, 0.4]}, "plant.mass_scale": {"uniform": [0.98, 1.02]}},
    "draws": 3,
}


def flown(
    env: FlightEnv, action: np.ndarray, steps: int
) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
    """What the last of some steps gave; the flight may end before."""
    found = env.step(action)
    for _ in range(steps - 1):
        if found[2] or found[3]:
            break
        found = env.step(action)
    return found


def neutral(env: FlightEnv) -> np.ndarray:
    return env.fleet.actions.neutral.astype(np.float32)


@pytest.fixture(scope="module")
def env() -> FlightEnv:
    return FlightEnv(duration=6.0, **VARIED)


@pytest.mark.parametrize(
    "settings",
    [
        {"actions": "references", "history": 3},
        {"actions": "gains", "gains": FORCE, "observations": "privileged", **VARIED},
        {"actions": "commands"},
        pytest.param({"task": "drawing"}, marks=pytest.mark.slow),
        {"task": "pushing"},
    ],
    ids=str,
)
def test_gymnasiums_own_check_passes(settings: dict[str, Any]) -> None:
    made = FlightEnv(**{"duration": 3.0, "draws": 2, **settings})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*Box observation space m.*imum value is.*infinity.*")
        warnings.filterwarnings("ignore", message=".*not wrapped by.*|.*the environment (spec|is).*")
        check_env(made, skip_render_check=True)
    assert made.observation_space.contains(made.step(made.action_space.sample())[0])


def test_without_an_action_it_is_the_native_drivers_flight() -> None:
    settings = {**SHORT, "stop_at": 2.0}
    (takeoff,) = take_off("paper", ("following",), set=settings)
    (whole,) = fly_native([takeoff])
    flights, rows = LockStep([takeoff, takeoff], 7), []
    assert list(flights.fly([1], 7)) == [7]  # the other one waits
    rows.append(flights.rows[1, :7].copy())
    for _ in range(100):
        flown = flights.fly([0, 1], 7)
        rows.append(flights.rows[1, : flown[1]].copy())
    assert np.array_equal(np.concatenate(rows), whole.signals[: whole.ticks], equal_nan=True)
    assert all(flight.over for flight in flights.flights)
    assert list(flights.fly([0, 1], 7)) == [0, 0]


def test_a_vector_flies_what_single_ones_fly_at_any_number_of_threads(env: FlightEnv) -> None:
    actions = np.random.default_rng(5).uniform(-1.0, 1.0, (40, 3, 3)).astype(np.float32)

    def shown_with(threads: int) -> list[np.ndarray]:
        made = FlightVectorEnv(3, threads, duration=6.0, **VARIED)
        shown = [made.reset(seed=11)[0]]
        for action in actions:
            observations, rewards, *_ = made.step(action)
            shown += [observations, rewards]
        return shown

    one, three = shown_with(1), shown_with(3)
    assert all(np.array_equal(a, b) for a, b in zip(one, three, strict=True))
    for place in range(3):
        alone = [env.reset(seed=11 + place)[0]]
        for action in actions:
            observation, reward, *_ = env.step(action[place])
            alone += [observation, np.float64(reward)]
        assert all(np.array_equal(a, b[place]) for a, b in zip(alone, one, strict=True))
    assert len({one[0][place].tobytes() for place in range(3)}) > 1  # they do not fly the same draw


def test_an_episode_that_has_ended_takes_off_anew_in_the_next_step() -> None:
    made = FlightVectorEnv(2, duration=0.5, draws=1)
    assert made.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert made.observation_space.shape == (2, made.fleet.observed)
    first, _ = made.reset(seed=3)
    quiet = np.zeros((2, 3), np.float32)
    for _ in range(24):
        *_, over, _ = made.step(quiet)
        assert not over.any()
    shown, _, lost, over, info = made.step(quiet)
    assert over.all()
    assert not lost.any()
    assert info["_reward_press"].all()
    shown, rewards, lost, over, info = made.step(np.full((2, 3), 0.7, np.float32))
    assert not over.any()
    assert not rewards.any()
    assert not info.get("_reward_press", np.zeros(2)).any()
    assert np.array_equal(shown, first)  # of the one draw; the action was ignored
    assert made.observation_space.contains(shown)


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (np.array([0.0, np.nan, 0.0]), "action 'path_u' of environment 0 is nan"),
        (np.array([np.inf, 0.0, 0.0]), "action 'path_n' of environment 0 is inf"),
        (np.zeros(2), r"an action has shape \(2,\); 3 numbers are needed"),
        (np.zeros((3, 1)), r"an action has shape \(3, 1\)"),
        (["a", "b", "c"], "actions should be numbers"),
        ([[1.0], [2.0, 3.0], [1.0]], "actions should be numbers"),
        (np.array([1.0j, 0.0, 0.0]), "actions should be numbers"),
        ([None, 0.0, 0.0], "actions should be numbers"),
    ],
)
def test_an_action_that_is_none_is_refused_before_anything_flies(
    env: FlightEnv, action: Any, words: str
) -> None:
    env.reset(seed=2)
    before = env.step(neutral(env))[0]
    env.reset(seed=2)
    with pytest.raises(ConfigError, match=words):
        env.step(action)
    assert np.array_equal(env.step(neutral(env))[0], before)


def test_terms_are_told_one_by_one_and_add_up(env: FlightEnv) -> None:
    env.reset(seed=4)
    _, paid, lost, over, info = flown(env, np.full(3, 0.1), 20)
    told = {name.removeprefix("reward_"): value for name, value in info.items() if name != "draw"}
    assert told.keys() == TASKS["sliding"].rewards.keys() <= REWARDS.keys()
    assert paid == pytest.approx(sum(TASKS["sliding"].rewards[name] * value for name, value in told.items()))
    assert not lost
    assert not over


def test_a_moved_path_is_followed_and_a_privileged_policy_sees_it() -> None:
    made = FlightEnv(duration=4.0, observations="privileged", history=2, reach=0.05, **VARIED)
    names, size = [], 0
    for name, width in made.fleet.layout:
        names += [name] * width
        size += width
    wanted = names.index("drawn surface.friction")
    for seed in range(3):
        shown, info = made.reset(seed=seed)
        drawn = made.fleet.start(info["draw"])[0].values["surface.friction"]
        assert shown[wanted] == shown[size + wanted] == np.float32(drawn)

    def shown_by(action: list[float]) -> np.ndarray:
        shown, _ = made.reset(options={"draw": 1})
        for _ in range(100):
            before, (shown, *_) = shown, made.step(np.array(action))
            assert np.array_equal(shown[size:], before[:size])
        return shown

    root = names.index("true_root_from_reference")
    moved = (shown_by([0.0, 1.0, 0.0]) - shown_by([0.0, 0.0, 0.0]))[root : root + 3]
    assert moved == pytest.approx([0.0, 0.05, 0.0], abs=0.01)  # u is y


def test_signals_of_the_flight_are_shown_besides_or_alone() -> None:
    names = ("contact_force", "cog_position_estimate")
    alone = FlightEnv(observations="signals", signals=names, duration=1.0, draws=1)
    besides = FlightEnv(signals=names, duration=1.0, draws=1)
    assert (
        alone.fleet.layout == besides.fleet.layout[:2] == (("contact_force", 3), ("cog_position_estimate", 3))
    )
    assert np.array_equal(alone.reset(seed=0)[0], besides.reset(seed=0)[0][:6])


def test_gains_are_written_from_end_to_end() -> None:
    made = FlightEnv(actions="gains", gains=FORCE, duration=12.0, draws=1)

    def pressed(action: float) -> float:
        made.reset(seed=0)
        for _ in range(480):
            made.step(np.array([action]))
        return abs(float(made.fleet.last[0, made.fleet.signals.slices["contact_force"]][0]))

    assert pressed(-1.0) == pytest.approx(0.5, abs=0.25)
    assert pressed(1.0) == pytest.approx(2.0, abs=0.4)


def test_thrusts_that_are_too_small_lose_the_flight() -> None:
    made = FlightEnv(actions="commands", duration=5.0, draws=1)
    made.reset(seed=0)
    hover = neutral(made)
    _, _, lost, _, info = flown(made, hover, 5)
    assert not lost
    assert info["reward_lost"] == 0.0
    shown, paid, lost, over, info = flown(made, np.full_like(hover, -1.0), 100)
    assert lost
    assert not over
    assert info["reward_lost"] == -1.0
    assert paid < -40.0
    assert np.isfinite(shown).all()


@pytest.mark.parametrize("robot", ["tilted_hexarotor", "tiltable_hexarotor"])
def test_a_robot_without_an_arm_is_commanded_by_its_thrusts(robot: str) -> None:
    made = FlightEnv(actions="commands", set={"robot": robot}, duration=0.5, draws=1)
    assert {name.partition("_")[0] for name in made.fleet.actions.names} == {"thrust"}
    made.reset(seed=0)
    _, _, lost, over, _ = flown(made, neutral(made), 25)
    assert over
    assert not lost


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"draw": -1}, "draw = -1 is outside of 0"),
        ({"draw": 3.7}, "draw = 3.7 has the wrong type: expected a whole number"),
        ({"draw": "x"}, "draw"),
        ({"drew": 3}, "unknown key 'drew'; did you mean 'draw'"),
    ],
)
def test_options_of_reset_that_are_none_are_refused(env: FlightEnv, options: Any, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        env.reset(options=options)


def test_each_environment_of_a_vector_may_be_told_its_draw() -> None:
    made = FlightVectorEnv(2, duration=0.5, **VARIED)
    assert list(made.reset(seed=1, options={"draw": 2})[1]["draw"]) == [2, 2]
    assert list(made.reset(seed=1, options={"draw": [1, 0]})[1]["draw"]) == [1, 0]
    own = made.reset(seed=1)[1]["draw"][1]
    assert list(made.reset(seed=1, options={"draw": [1, None]})[1]["draw"]) == [1, own]
    with pytest.raises(ConfigError, match=r"draw has 1 values; 2 are needed"):
        made.reset(options={"draw": [1]})
    for seeds in ([1], [1, 2, 3]):
        with pytest.raises(ConfigError, match=f"seed has {len(seeds)} values; 2 are needed"):
            made.reset(seed=seeds)


def test_nothing_is_stepped_before_a_reset_or_after_the_end() -> None:
    made = FlightEnv(duration=0.1, draws=1)
    with pytest.raises(ConfigError, match="no episode goes on"):
        made.step(neutral(made))
    made.reset(seed=0)
    assert flown(made, neutral(made), 5)[3]
    with pytest.raises(ConfigError, match="no episode goes on"):
        made.step(neutral(made))
    with pytest.raises(ConfigError, match="no episode goes on"):
        FlightVectorEnv(2, duration=0.1, draws=1).step(np.zeros((2, 3)))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_term_that_is_no_finite_number_is_named(value: float) -> None:
    @reward
    def endless(seen: Any) -> Any:
        return np.full(len(seen.lost), value)

    made = FlightEnv(rewards={"endless": 1.0}, duration=0.5, draws=1)
    made.reset(seed=0)
    with pytest.raises(UserCodeError, match=f"reward 'endless' returned {value}, no finite number"):
        made.step(neutral(made))


def test_a_term_of_ones_own_is_paid_and_its_mistakes_are_named() -> None:
    @reward
    def height(seen: Any) -> Any:
        return seen.tips[:, 2] if seen.force < 2.0 else seen.tips

    made = FlightEnv(rewards={"height": 2.0}, duration=1.0, draws=1)
    made.reset(seed=0)
    _, paid, _, _, info = made.step(neutral(made))
    assert paid == 2.0 * info["reward_height"]
    assert info["reward_height"] == pytest.approx(1.1, abs=0.15)
    made = FlightEnv(rewards={"height": 2.0}, force=3.0, duration=1.0, draws=1)
    made.reset(seed=0)
    with pytest.raises(UserCodeError, match=r"reward 'height' should return numbers of shape \(1,\)"):
        made.step(neutral(made))
    with pytest.raises(ConfigError, match="'press' has the name of one that ships"):
        reward(REWARDS["press"])


@pytest.mark.parametrize(
    ("settings", "error", "words"),
    [
        ({"task": "slidin"}, UnknownNameError, "did you mean 'sliding'"),
        ({"rewards": {"pres": 1.0}}, UnknownNameError, "did you mean 'press'"),
        ({"reward": {}}, UnknownNameError, "did you mean 'rewards'"),
        ({"actions": "gains"}, ConfigError, "gains that are acted on have a range each"),
        ({"gains": FORCE}, ConfigError, "do not go together"),
        (
            {"actions": "gains", "gains": {"translation.forc": (0.0, 1.0)}},
            UnknownNameError,
            "translation.force",
        ),
        ({"actions": "gains", "gains": {"translation.force": (1.0, -5.0)}}, ConfigError, "from the lower"),
        ({"actions": "gains", "gains": {"translation.force": (-5.0, 1.0)}}, ConfigError, "translation.force"),
        ({"vary": {"surface.frictoin": {"uniform": [0.1, 0.2]}}}, UnknownNameError, "friction"),
        ({"signals": ("contact_forse",)}, UnknownNameError, "did you mean 'contact_force'"),
        ({"count": 0}, ConfigError, "num_envs = 0 is outside of 1"),
        ({"count": 2.5}, ConfigError, "num_envs = 2.5 has the wrong type: expected a whole number"),
        ({"threads": 0}, ConfigError, "threads = 0 is outside of 1"),
        ({"threads": "3"}, ConfigError, "threads = '3' has the wrong type"),
        ({"set": {"stop_at": 0.5}}, ConfigError, "stop_at is what duration says"),
        ({"observations": "signals"}, ConfigError, "signals is empty"),
    ],
)
def test_what_cannot_be_set_is_refused(settings: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        Fleet(**{"draws": 1, "duration": 1.0, **settings})


def test_a_draw_of_another_scene_is_refused() -> None:
    fleet = Fleet(1, duration=1.0, vary={"surface.kind": {"grid": ["board", "step"]}}, draws=2)
    fleet.restart([0], [0])
    with pytest.raises(ConfigError, match="need one robot, one kind of surface"):
        fleet.restart([0], [1])


def test_the_extra_is_named_where_it_is_missing() -> None:
    code = "import sys; sys.modules['gymnasium'] = None; import skylimb; skylimb.envs"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False).stderr
    assert "'gymnasium' is not installed: pip install 'skylimb[learn]'" in said
