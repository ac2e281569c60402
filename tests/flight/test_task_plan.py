"""A posture planned for an experiment, written and flown."""

import dataclasses
import re
import shutil
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import trimesh

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.apps.cli import main
from skylimb.base.errors import ConfigError, DescriptionError, UnreachableError
from skylimb.base.rotations import rot_z
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.task import TaskPosture, judged_posture, travel
from skylimb.control.planning.task_family import standing_in
from skylimb.control.planning.tip_pose import link_distances, tip_position
from skylimb.control.planning.vectoring_search import evaluate, posture_function
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_results import NotHeld
from skylimb.studies.planning.rehearsal import Rehearsal, rehearse
from skylimb.studies.planning.task_plan import plan_posture, write_planned


@pytest.fixture(scope="module")
def robot():
    return skylimb.load_robot("hydrus_xi_quad")


@pytest.fixture(scope="module")
def plan(robot):
    """The plan from a sixth of the starts: the first leads to the best posture, as the slow tests know."""
    experiment = skylimb.load_experiment("paper")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skylimb.control.planning.task_posture._STARTS", 4)
        return plan_posture(experiment, robot, skylimb.load_controller("hybrid", robot))


@pytest.fixture(scope="module")
def applied(tmp_path_factory, plan):
    folder = tmp_path_factory.mktemp("plan") / "planned"
    write_planned(plan, folder)
    return folder


def test_it_holds_what_a_servo_of_the_papers_posture_does_not(robot, plan):
    assert isinstance(plan.nominal, NotHeld)
    assert str(plan.nominal.limit) == "the servo of 'joint2' (3.3 N m)"
    assert plan.nominal.greatest is not None
    assert 2.0 < plan.nominal.greatest < plan.force == 3.0
    assert plan.planned.margin > 3.0
    turn = rot_z(-plan.planned.heading)
    for push, margin in zip(plan.task.pushes, plan.planned.margins, strict=True):
        held = can_hold(robot, plan.planned.joint_angles, plan.planned.vectoring_angles, turn @ push)
        assert held
        assert held.margin == pytest.approx(margin, abs=1e-3)
        assert np.abs(held.joint_angles - plan.planned.joint_angles).max() <= 3.3 / 50.0 + 1e-6


def test_the_margin_is_the_torque_that_is_left(robot, plan):
    """Thrusts, pushed by that torque in any direction, stay within their limits; by more they do not."""
    found, worst = plan.planned, int(np.argmin(plan.planned.margins))
    push = rot_z(-found.heading) @ plan.task.pushes[worst]
    held = can_hold(robot, found.joint_angles, found.vectoring_angles, push)
    assert held
    matrix = robot.wrench_function(held.joint_angles, held.vectoring_angles).full()[2:]
    swing = found.margin * np.linalg.norm(np.linalg.inv(matrix)[:, 1:], axis=1)
    thrusts = found.thrusts[worst]
    assert np.all(thrusts - swing >= 1.0 - 1e-4)
    assert np.all(thrusts + swing <= 30.0 + 1e-4)
    assert np.any(thrusts - 1.01 * swing < 1.0) or np.any(thrusts + 1.01 * swing > 30.0)


def test_it_keeps_joints_links_and_rotors_clear(robot, plan):
    lower, upper = travel(robot)
    assert np.all(plan.planned.joint_angles >= lower - 1e-6)
    assert np.all(plan.planned.joint_angles <= upper + 1e-6)
    import casadi as ca

    distances = np.array(link_distances(robot, ca.DM(plan.planned.joint_angles)))
    assert distances.min() >= 0.1 - 1e-6


def test_a_posture_is_judged_as_it_is(robot, plan):
    again = judged_posture(
        robot, plan.task, plan.planned.joint_angles, plan.planned.vectoring_angles, plan.planned.heading
    )
    assert again
    assert again.margins == pytest.approx(plan.planned.margins, abs=1e-3)


def test_its_angles_keep_the_criteria_all_along_its_family(plan):
    low, high = plan.task.criteria.span(plan.there)
    bounded = posture_function(plan.there, plan.task.criteria)
    for theta in np.linspace(low, high, 9):
        psi = evaluate(plan.coefficients, low, high, theta)
        values = np.concatenate([part.full().ravel() for part in bounded.function(theta, psi)])
        assert np.all(values >= np.array(bounded.low) - 2e-3)
        assert np.all(values <= np.array(bounded.high) + 2e-3)
    nominal = plan.there.description.posture.theta_nominal
    here = evaluate(plan.coefficients, low, high, nominal)
    assert np.allclose(here, plan.planned.vectoring_angles, atol=1e-9)


@pytest.mark.slow
def test_a_posture_that_a_controller_loses_is_not_proposed(robot, plan, monkeypatch):
    """The best one is not taken where a flight in it is lost; where all are, the plan says why."""
    task_plan = import_module("skylimb.studies.planning.task_plan")
    lost = iter(map(Rehearsal, ["", "lost attitude", ""]))
    monkeypatch.setattr(task_plan, "_flown", lambda *_: next(lost))
    experiment, controller = skylimb.load_experiment("paper"), skylimb.load_controller("hybrid", robot)
    best = plan_posture(experiment, robot, controller)
    assert best.planned.margin == pytest.approx(plan.planned.margin, abs=1e-6)
    second = plan_posture(experiment, robot, controller)
    assert second.planned.margin < plan.planned.margin
    monkeypatch.setattr(task_plan, "_flown", lambda *_: Rehearsal("lost attitude"))
    with pytest.raises(UnreachableError, match="flies paper: lost attitude"):
        plan_posture(experiment, robot, controller)


def test_what_flies_worse_than_its_own_posture_is_not_proposed(robot, plan, monkeypatch):
    """More torque is left in it, and its force spreads more: the plan says so; `by` takes it all the same."""
    task_plan = import_module("skylimb.studies.planning.task_plan")
    own, there = Rehearsal("", 2.0, 1.0, 0.10, 0.004), Rehearsal("", 2.0, 0.98, 0.12, 0.004)
    monkeypatch.setattr(task_plan, "rehearse", lambda *_: own)
    monkeypatch.setattr(task_plan, "_flown", lambda *_: there)
    monkeypatch.setattr(task_plan, "best_postures", lambda *_: [plan.planned])
    monkeypatch.setattr(task_plan, "settled_in", lambda *_: (plan.planned, plan.there, plan.coefficients))
    experiment, controller = skylimb.load_experiment("paper"), skylimb.load_controller("hybrid", robot)
    with pytest.raises(UnreachableError) as caught:
        plan_posture(experiment, robot, controller, 2.0)
    assert "stands best as it does" in str(caught.value)
    assert (
        "in touch 0.98 of the time (1.00 in its own); the force spreads by 0.12 N (0.10 in its own)"
        in str(caught.value)
    )
    assert plan_posture(experiment, robot, controller, 2.0, "margin").planned_flight is there
    monkeypatch.setattr(task_plan, "_flown", lambda *_: own)
    assert plan_posture(experiment, robot, controller, 2.0).planned is plan.planned


def test_the_asked_force_is_the_one_that_is_flown(robot, monkeypatch):
    task_plan = import_module("skylimb.studies.planning.task_plan")
    asked = []
    monkeypatch.setattr(task_plan, "rehearse", lambda experiment, _: asked.append(experiment) or Rehearsal())
    monkeypatch.setattr(task_plan, "best_postures", lambda *_: [])
    with pytest.raises(UnreachableError):
        plan_posture(
            skylimb.load_experiment("paper"), robot, skylimb.load_controller("following", robot), 1.5
        )
    assert asked[0].trajectory.force == (1.5, 1.5)


def test_a_force_of_the_path_is_planned_for(robot, monkeypatch):
    """The plan of push_and_slide, which presses up to 3 N, was one for the 1 N of the controller's gain."""
    task_plan = import_module("skylimb.studies.planning.task_plan")
    asked = []
    task = task_plan._task
    monkeypatch.setattr(task_plan, "_task", lambda *args: asked.append(args[-1]) or task(*args))
    monkeypatch.setattr(task_plan, "rehearse", lambda *_: Rehearsal())
    monkeypatch.setattr(task_plan, "best_postures", lambda *_: [])
    experiment = skylimb.load_experiment("push_and_slide")
    controller = skylimb.load_controller("drawing", robot)
    for force in (None, 0.5):
        with pytest.raises(UnreachableError):
            plan_posture(experiment, robot, controller, force)
    assert asked == [3.0, 0.5]


def test_a_flight_that_is_refused_counts_as_lost(robot):
    experiment = skylimb.load_experiment("paper")
    hard = dataclasses.replace(
        experiment, trajectory=dataclasses.replace(experiment.trajectory, force=(12.0, 12.0))
    )
    assert "12 N" in rehearse(hard, skylimb.load_controller("following", robot)).lost


def test_a_posture_in_which_the_robot_is_not_flown_counts_as_lost(robot, plan, monkeypatch):
    """The tool of dragon points down in some, and gives no heading there: the planner passed over none."""
    task_plan = import_module("skylimb.studies.planning.task_plan")

    def refused(*_):
        raise DescriptionError("the tool points down")

    monkeypatch.setattr(task_plan, "write_planned", refused)
    assert task_plan._flown(plan, skylimb.load_controller("hybrid", robot)).lost == "the tool points down"


def test_a_score_that_is_not_there_makes_no_posture_worse():
    flown = Rehearsal("", 2.0, 1.0, float("nan"), 0.004)
    assert not flown.worse_than(Rehearsal("", 2.0, 1.0, 0.1, 0.004))
    assert not Rehearsal("", 2.0, 1.0, 0.1, 0.004).worse_than(flown)


def test_the_family_takes_the_tip_to_and_fro(robot, plan):
    there = standing_in(robot, plan.planned.joint_angles, plan.planned.vectoring_angles)
    family = posture_family(there)
    assert np.allclose(family.joint_angles(0.0), plan.planned.joint_angles)
    psi = plan.planned.vectoring_angles
    near, here = (tip_position(there, family.joint_angles(theta), psi) for theta in (0.02, 0.0))
    moved = near - here
    assert abs(moved[1]) < 0.05 * abs(moved[0])
    assert family.reach_max - family.reach_min > 0.02


def test_what_is_written_is_what_was_planned_and_flies(applied, plan):
    robot = skylimb.load_robot(str(applied / "robot"))
    assert np.allclose(robot.nominal_posture(), plan.planned.joint_angles, atol=1e-6)
    run = skylimb.run(str(applied / "experiment.toml"), controller="hybrid")
    assert run.status == "OK"
    assert np.allclose(run.log["joint_angles_command"].values[0], plan.planned.joint_angles, atol=1e-6)
    assert np.allclose(
        run.log["vectoring_angles_command"].values[0], plan.planned.vectoring_angles, atol=1e-6
    )
    assert run.metrics["contact_fraction"] > 0.5


def test_what_cannot_be_planned_is_refused(robot):
    controller = skylimb.load_controller("hybrid", robot)
    with pytest.raises(ConfigError, match="touches nothing"):
        plan_posture(skylimb.load_experiment("free_flight"), robot, controller)
    with pytest.raises(ConfigError, match="stands still"):
        plan_posture(skylimb.load_experiment("paper", {"trajectory.shape": "hold"}), robot, controller)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.usefixtures("no_picture")
def test_three_rotors_with_an_arm_are_planned_for_and_flown(tmp_path):
    arm = (("shoulder_pitch", "0 1 0", 0.12), ("elbow_pitch", "0 1 0", 0.12))
    tail = {"rotors": 3, "turning": 1.5, "fixed": (0, 2), "mass": 1.2}
    folder, out = tmp_path / "tricopter", tmp_path / "planned"
    skylimb.import_robot(multirotor_with_arm(tmp_path / "tricopter.urdf", joints=arm, **tail), folder)
    light = {"robot": str(folder), "controller.translation.force": 0.5, "approach.doubtful": "fly"}
    plan = skylimb.plan("board_tilted_hexarotor", "following", 0.5, light, by="margin")
    assert isinstance(plan.nominal, TaskPosture)
    assert plan.planned.margin > plan.nominal.margin
    assert np.abs(plan.planned.joint_angles - plan.nominal.joint_angles).max() > 0.05
    write_planned(plan, out)
    flown = skylimb.load_robot(str(out / "robot"))
    assert (flown.n_rotors, flown.n_vectoring, plan.robot.n_rotors) == (3, 1, 4)
    run = skylimb.run(str(out / "experiment.toml"), "following", set={"controller.translation.force": 0.5})
    assert run.status == "OK"
    assert run.metrics["contact_fraction"] > 0.95
    assert run.metrics["pen_line_rms"] < 0.008


@pytest.mark.slow
def test_a_push_that_nothing_holds_is_refused(robot):
    controller = skylimb.load_controller("hybrid", robot)
    with pytest.raises(UnreachableError) as caught:
        plan_posture(skylimb.load_experiment("paper"), robot, controller, 25.0)
    said = re.fullmatch(
        r"'hydrus_xi_quad' cannot do this task: no posture holds all of the 8 pushes: the .* is in the way; "
        r"what can be held is at most (1\d\.\d) N",
        str(caught.value),
    )
    assert said, caught.value


@pytest.mark.slow
def test_the_verb_prints_draws_and_writes(tmp_path, capsys):
    folder, picture = tmp_path / "planned", tmp_path / "p.png"
    assert main(["plan", "paper", "--apply", str(folder), "--picture", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert {path.name for path in folder.iterdir()} == {"experiment.toml", "robot"}
    assert "worst margin" in capsys.readouterr().out


@pytest.mark.parametrize("words", [["--force", "much"], ["--force", "-1"]])
def test_bad_words_are_one_line_and_write_nothing(words, tmp_path, capsys):
    assert main(["plan", "paper", *words, "--apply", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()
    assert capsys.readouterr().err.count("\n") == 1


def test_the_meshes_of_a_robot_go_along(tmp_path, robot, plan):
    folder = tmp_path / "meshed"
    shutil.copytree(robot.description.folder, folder)
    trimesh.creation.box((0.1, 0.1, 0.1)).export(folder / "box.stl")
    (urdf,) = folder.glob("*.urdf")
    shown = '<visual><geometry><mesh filename="box.stl"/></geometry></visual>'
    urdf.write_text(urdf.read_text().replace("</link>", f"{shown}</link>", 1))
    meshed = dataclasses.replace(plan, robot=skylimb.load_robot(str(folder)))
    write_planned(meshed, tmp_path / "planned")
    assert (tmp_path / "planned" / "robot" / "box.stl").read_bytes() == (folder / "box.stl").read_bytes()
    again = skylimb.load_robot(str(tmp_path / "planned" / "robot"))
    meshes = [visual.mesh for link in again.description.links for visual in link.visuals if visual.mesh]
    assert [Path(mesh).name for mesh in meshes] == ["box.stl"]
