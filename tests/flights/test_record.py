import json

import skylimb
from skylimb.config import flatten
from skylimb.flights.record import config_units
from skylimb.keys import rows_of, tables_of


def test_units_of_the_configuration_stand_under_its_dotted_keys() -> None:
    experiment = skylimb.load_experiment("paper")
    controller = skylimb.load_controller("hybrid", skylimb.load_robot("hydrus_xi_quad"))
    units = config_units(experiment, controller)
    assert units["surface.slope"] == "rad"
    assert units["trajectory.speed"] == "m/s"
    assert units["plant.cog_offset"] == "m"
    assert "surface.friction" not in units
    assert json.loads(json.dumps(units)) == units
    of_experiment = {name for name in units if not name.startswith("controller.")}
    assert of_experiment <= {name for name, _, _ in rows_of(tables_of(experiment))}
    # Keys of the log's `config`, but for those that are not set.
    assert {name for name in of_experiment if name not in flatten(experiment)} == {
        "plant.foot",
        "plant.peg",
        "stop_at",
        "surface_error",
        "surface.damping",
        "surface.motion_direction",
        "trajectory.center",
        "wrap.radius",
    } & of_experiment


class NumpyController:
    name = "own"


def test_a_controller_of_ones_own_has_no_units() -> None:
    experiment = skylimb.load_experiment("paper")
    units = config_units(experiment, NumpyController())  # type: ignore[arg-type]
    assert not [name for name in units if name.startswith("controller.")]
