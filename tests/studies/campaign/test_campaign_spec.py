import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest, norm, truncnorm

from skylimb.analysis.scores.registry import NUMERIC_KEYS, SCORES
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError, SkylimbError
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.draws import draw
from skylimb.studies.campaign.frozen import campaign_from_mapping, differences, freeze
from skylimb.studies.campaign.reading import load_spec, spec_from_mapping
from skylimb.studies.campaign.spec import CampaignSpec

SpecWriter = Callable[..., Path]
REPOSITORY = Path(__file__).parents[3]


@pytest.mark.parametrize("name", ["campaign.toml", "tune.toml"])
def test_the_examples_can_be_flown(name: str) -> None:
    campaign = freeze(load_spec(REPOSITORY / "examples" / name))
    assert campaign.spec.draws == 8


def test_what_the_folder_keeps_reads_back_to_the_same_campaign(write_spec: SpecWriter) -> None:
    vary = """
    "surface.friction" = { normal = [0.4, 0.1], within = [0.1, 0.8] }
    "surface.slope" = { grid = [-0.3, 0.3] }
    "plant.rotor_scale" = { log_uniform = [0.9, 1.1], size = 4 }
    "controller.attitude.damping_ratio" = { choice = [[1.1, 1.1, 0.8], [0.9, 0.9, 0.8]] }
    """
    more = '[stop]\nuntil = "success"\nwidth = 0.1\n[success]\ntilt_max = { max = 0.5 }\n'
    campaign = freeze(load_spec(write_spec(vary=vary, more=more)))
    tables = tomllib.loads(write_toml(campaign.to_mapping()))
    assert campaign_from_mapping(tables, "here") == campaign


def test_keys_of_vary_need_no_quotes(write_spec: SpecWriter) -> None:
    quoted = load_spec(write_spec(vary='"surface.friction" = { uniform = [0.1, 0.8] }'))
    plain = load_spec(write_spec(vary="surface.friction = { uniform = [0.1, 0.8] }"))
    assert quoted == plain


def test_files_are_looked_for_beside_the_spec(write_spec: SpecWriter, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('robot = "hydrus_xi_quad"\n[surface]\nfriction = 0.3\n')
    path = write_spec()
    path.write_text(path.read_text().replace('experiment = "paper"', 'experiment = "mine.toml"'))
    assert freeze(load_spec(path)).experiment["surface"]["friction"] == 0.3


def test_an_edited_height_map_makes_another_campaign(write_spec: SpecWriter, tmp_path: Path) -> None:
    heights = tmp_path / "wall.csv"
    heights.write_text("0, 0, 0, 0\n0, 1, 1, 0\n0, 1, 1, 0\n0, 0, 0, 0\n")
    (tmp_path / "mine.toml").write_text(
        'robot = "hydrus_xi_quad"\n[surface]\nkind = "heightmap"\nfile = "wall.csv"\nrelief = 0.02\n'
    )
    path = write_spec()
    path.write_text(path.read_text().replace('experiment = "paper"', 'experiment = "mine.toml"'))
    begun = freeze(load_spec(path)).to_mapping()
    assert differences(begun, freeze(load_spec(path)).to_mapping()) == []
    heights.write_text(heights.read_text().replace("1, 1", "1, 2"))
    (change,) = differences(begun, freeze(load_spec(path)).to_mapping())
    assert change.startswith("frozen.files.surface.file: ")


def test_a_campaign_of_grids_needs_no_number_of_draws(write_spec: SpecWriter) -> None:
    path = write_spec(vary='"surface.friction" = { grid = [0.1, 0.2, 0.3] }\n"seed" = { grid = [1, 2] }')
    path.write_text(path.read_text().replace("draws = 4\n", ""))
    spec = load_spec(path)
    assert spec.draws == 6
    drawn = [draw(spec, index) for index in range(6)]
    assert {(d.values["surface.friction"], d.seed) for d in drawn} == {
        (friction, seed) for friction in (0.1, 0.2, 0.3) for seed in (1, 2)
    }


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ('"surface.fricton" = { uniform = [0.1, 0.8] }', ["surface.fricton", "friction"]),
        ('"surface.friction" = { unifrom = [0.1, 0.8] }', ["unifrom", "uniform"]),
        ('"surface.friction" = { uniform = [-0.5, 0.8] }', ["surface.friction", "-0.5"]),
        ('"surface.friction" = { uniform = [0.8, 0.1] }', ["surface.friction", "lower"]),
        ('"surface.friction" = { uniform = [0.1, 0.8], sise = 2 }', ["sise", "size"]),
        ('"surface.friction" = { uniform = [0.1] }', ["surface.friction", "needs 2"]),
        ('"surface.friction" = { uniform = [0.1, 0.2], choice = [1] }', ["surface.friction", "exactly one"]),
        ('"surface.friction" = 0.4', ["surface.friction", "uniform"]),
        ('"surface.friction" = { choice = [] }', ["surface.friction", "one or more"]),
        ('"surface.friction" = { normal = [0.0, 0.3] }', ["draw ", "friction"]),
        ('"surface.friction" = { log_uniform = [0.0, 0.3] }', ["surface.friction", "above 0"]),
        ('"plant.rotor_scale.0" = { normal = [1.0, 0.02] }', ["rotor_scale", "size = N"]),
        ('"plant.cog_offset.3" = { normal = [0.0, 0.001] }', ["cog_offset", "0 .. 2"]),
        ('"plant.thrust_scale.0" = { uniform = [0.9, 1.1] }', ["thrust_scale"]),
        ('"controller.translation.mas" = { uniform = [1, 2] }', ["mas"]),
        ('"trajectory.direction" = { uniform = [-1, 1] }', ["trajectory.direction"]),
    ],
)
def test_a_distribution_that_cannot_be_is_refused_by_name(
    vary: str, words: list[str], write_spec: SpecWriter
) -> None:
    with pytest.raises(SkylimbError) as caught:
        freeze(load_spec(write_spec(vary=vary)))
    message = str(caught.value)
    assert all(word in message for word in words), message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("head", "more", "words"),
    [
        ("drws = 3", "", ["drws", "draws"]),
        ('sampling = "sobl"', "", ["sobl", "sobol"]),
        ('logs = "worst"', "", ["worst K"]),
        ('score = "error"', "", ["score", "error_u_median"]),
        ("", '[stop]\nuntil = "sucess"\nwidth = 0.1', ["sucess", "success"]),
        ("", '[stop]\nuntil = "success"\nwidth = 0.0', ["width"]),
        ("", "[success]\ntilt = { max = 0.3 }", ["tilt", "tilt_max"]),
        ("", "[success]\ntilt_max = { }", ["tilt_max", "min or max"]),
        ("", "[success]\ntilt_max = { min = 0.9, max = 0.1 }", ["tilt_max.min = 0.9 is above max = 0.1"]),
        ("", '[tune]\nobjective = "tilt_max"\n[tune.gains]\n"shape.mass" = [3.0, 1.0]', ["shape.mass"]),
    ],
)
def test_a_spec_that_cannot_be_is_refused_by_name(
    head: str, more: str, words: list[str], write_spec: SpecWriter
) -> None:
    with pytest.raises(SkylimbError) as caught:
        load_spec(write_spec(head=head, more=more))
    assert all(word in str(caught.value) for word in words), str(caught.value)


GAIN = 'gains = { "translation.sum_limit.0" = [1.0, 2.0] }'


def tuned(write_spec: SpecWriter, objective: str, head: str = "") -> CampaignSpec:
    return load_spec(write_spec(head=head, more=f'[tune]\nobjective = "{objective}"\n{GAIN}'))


def test_every_score_with_a_direction_can_be_tuned_by(write_spec: SpecWriter) -> None:
    directed = [key for key in NUMERIC_KEYS if SCORES[key].directed]
    assert {"pen_line_rms", "force_error_rms", "valve_left", "line_frechet", "done"} <= set(directed)
    for objective in directed:
        assert tuned(write_spec, objective).tune is not None
    assert tuned(write_spec, "near_fraction", 'measures = ["contact"]').scores["near_fraction"].sign == -1.0


@pytest.mark.parametrize(
    ("objective", "message"),
    [
        (
            "line_length_drawn",
            "tune.objective = 'line_length_drawn' does not say which flight is better, as neither its small "
            "nor its large values are; those that do, the nearest name first: line_",
        ),
        (
            "contact_force_normal_mean",
            "the nearest name first: contact_force_normal_peak, contact_force_normal_std, ",
        ),
        ("pen_line_rsm", "unknown tune.objective 'pen_line_rsm'; did you mean 'pen_line_rms'?"),
        ("near_fraction", 'one of the further numbers: measures = ["contact"]'),
    ],
)
def test_what_cannot_be_tuned_by_is_told_with_what_can(
    objective: str, message: str, write_spec: SpecWriter
) -> None:
    with pytest.raises(ConfigError) as caught:
        tuned(write_spec, objective)
    assert message in str(caught.value)


def test_controllers_are_ranked_by_few_scores_and_by_the_campaigns_own(write_spec: SpecWriter) -> None:
    def ranked(spec: CampaignSpec) -> list[str]:
        return [key for key, score in spec.scores.items() if score.directed and score.ranked]

    usual = ranked(load_spec(write_spec()))
    assert usual == [
        "error_u_median", "error_v_median", "displacement_median", "contact_force_normal_std",
        "contact_force_normal_peak", "contact_fraction", "tilt_max",
    ]  # fmt: skip
    assert set(ranked(load_spec(write_spec(head='score = "pen_line_rms"')))) == {*usual, "pen_line_rms"}


def test_a_users_set_is_computed_where_it_is_asked_for(write_spec: SpecWriter, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "import skylimb\n\n\n@skylimb.metric(on_demand='mine')\ndef slow(run):\n    return 1.0\n",
        encoding="utf-8",
    )
    assert "slow" not in load_spec(write_spec(head='use = ["mine.py"]')).keys
    assert load_spec(write_spec(head='use = ["mine.py"]\nmeasures = ["mine"]')).keys[-1] == "slow"
    with pytest.raises(ConfigError, match="unknown set of measures 'min'; did you mean 'mine'"):
        load_spec(write_spec(head='use = ["mine.py"]\nmeasures = ["min"]'))


def test_controllers_of_one_name_are_refused(write_spec: SpecWriter) -> None:
    with pytest.raises(SkylimbError, match="same name"):
        freeze(load_spec(write_spec(controllers='["pid", "pid"]')))


def test_a_draw_depends_on_spec_and_index_alone(write_spec: SpecWriter) -> None:
    path = write_spec(draws=3000, vary='"surface.friction" = { uniform = [0.1, 0.8] }')
    spec = load_spec(path)
    forwards = [draw(spec, index) for index in (0, 1, 1500, 2999)]
    backwards = [draw(load_spec(path), index) for index in (2999, 1500, 1, 0)]
    assert forwards == backwards[::-1]
    assert len({d.seed for d in forwards}) == 4


@pytest.mark.parametrize("sampling", ["sobol", "halton", "random"])
def test_draws_follow_their_distributions(sampling: str, write_spec: SpecWriter) -> None:
    vary = """
    "surface.friction" = { uniform = [0.1, 0.8] }
    "plant.thrust_scale" = { normal = [1.0, 0.02] }
    "plant.cog_offset.0" = { normal = [0.0, 0.02], within = [-0.01, 0.03] }
    """
    spec = load_spec(write_spec(draws=1024, vary=vary, head=f'sampling = "{sampling}"'))
    values = [draw(spec, index).values for index in range(1024)]

    def column(key: str) -> np.ndarray:
        return np.array([entry[key] for entry in values])

    assert kstest((column("surface.friction") - 0.1) / 0.7, "uniform").pvalue > 0.01
    assert kstest(column("plant.thrust_scale"), norm(1.0, 0.02).cdf).pvalue > 0.01
    truncated = truncnorm(-0.5, 1.5, 0.0, 0.02)
    assert kstest(column("plant.cog_offset.0"), truncated.cdf).pvalue > 0.01


def test_low_discrepancy_points_fill_the_range_evenly(write_spec: SpecWriter) -> None:
    spec = load_spec(write_spec(draws=64, vary='"surface.friction" = { uniform = [0.0, 1.0] }'))
    values = [draw(spec, index).values["surface.friction"] for index in range(64)]
    assert np.histogram(values, bins=64, range=(0.0, 1.0))[0].tolist() == [1] * 64


def test_every_point_is_flown_in_every_cell(write_spec: SpecWriter) -> None:
    vary = '"surface.friction" = { uniform = [0.1, 0.8] }\n"surface.slope" = { grid = [-0.3, 0.0, 0.3] }'
    spec = load_spec(write_spec(draws=9, vary=vary))
    drawn = [draw(spec, index).values for index in range(9)]
    assert [entry["surface.slope"] for entry in drawn] == [-0.3, 0.0, 0.3] * 3
    frictions = [entry["surface.friction"] for entry in drawn]
    assert frictions[0] == frictions[1] == frictions[2] != frictions[3] == frictions[5]


def test_extremes_are_what_can_be_drawn() -> None:
    rotors = Distribution(uniform=(0.9, 1.1), size=4)
    assert rotors.extremes() == [[0.9] * 4, [1.1] * 4]
    assert rotors.value(np.array([0.0, 0.5, 0.25, 0.75])) == pytest.approx([0.9, 1.0, 0.95, 1.05])
    assert Distribution(choice=("a", "b")).value(np.array([0.999999])) == "b"
    assert Distribution(log_uniform=(1.0, 100.0)).value(np.array([0.5])) == pytest.approx(10.0)


def test_a_users_metric_is_known_by_name(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "import skylimb\n\n\n@skylimb.metric(unit='N', smaller_is_better=False)\n"
        "def my_push(run):\n    return float(run.log.contact_force_normal.max())\n",
        encoding="utf-8",
    )
    text = (
        'experiment = "paper"\ncontrollers = ["pid"]\ndraws = 2\nuse = ["mine.py"]\nscore = "my_push"\n'
        '[success]\nmy_push = { min = 1.0 }\n[tune]\nobjective = "my_push"\n'
        'gains = { "translation.sum_limit.0" = [1.0, 2.0] }\n'
    )
    (tmp_path / "spec.toml").write_text(text, encoding="utf-8")
    spec = load_spec(tmp_path / "spec.toml")
    assert spec.keys[-1] == "my_push"
    assert spec.scores["my_push"].sign == -1.0
    campaign = freeze(spec)
    again = campaign_from_mapping(campaign.to_mapping(), "there")
    assert again == campaign
    assert again.use.keys() == {(tmp_path / "mine.py").as_posix()}
    (tmp_path / "mine.py").write_text("x = 1\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="has no metric and no figure"):
        load_spec(tmp_path / "spec.toml")


@pytest.mark.parametrize(
    ("robot", "key", "value", "others"),
    [
        ("hydrus_xi_quad", "estimation.smoothing.imu", True, {"position": 10.0}),
        ("tilted_hexarotor", "estimation.smoothing.position", 20.0, {"position": 20.0, "on": False}),
        ("tilted_hexarotor", "estimation.smoothing.on", True, {"on": True}),
    ],
)
def test_a_drawn_gain_counts_like_one_that_is_set(
    robot: str, key: str, value: Any, others: dict[str, Any]
) -> None:
    """With the gains that a preset has for an IMU, and before those that it has for a robot."""
    drawn = {f"controller.{key}": {"choice": [value]}}
    spec = {"experiment": "paper", "controllers": ["drawing"], "draws": 1, "set": {"sensors.imu.on": True}}
    campaign = freeze(spec_from_mapping({**spec, "vary": drawn}, "here"))
    gains = campaign.gains_of(campaign.draw(0), "drawing")
    made: Any = campaign.load("drawing", load_robot(robot), gains)
    smoothing = made.tables()["estimation"]["smoothing"]
    assert {name: smoothing[name] for name in others} == others
