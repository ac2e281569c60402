"""Every figure draws any number of runs, failed ones among them, and shows what it says."""

import itertools
import json
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from PIL import Image

from skylimb.analysis import write_figures
from skylimb.analysis.figures import REPORT_FIGURES, boxes, drawing, over_time, pose_strip, style, traces
from skylimb.analysis.figures.style import CONTROLLER_COLOURS, colours
from skylimb.analysis.recording import Run

FILES = {picture.name for picture in REPORT_FIGURES} - {"drawing", "area", "task"}


def used(figure):
    return [ax for ax in figure.axes if ax.axison]


def height(line):
    return float(np.asarray(line.get_ydata())[0])


def texts(figure):
    figure.draw_without_rendering()
    found = [ax.get_title() for ax in figure.axes] + [
        text.get_text() for ax in figure.axes for text in ax.texts
    ]
    labels = [tick.get_text() for ax in figure.axes for tick in ax.get_xticklabels()]
    return found + labels


@pytest.fixture(scope="module")
def six(make_run):
    return {f"flight {i}": make_run("hybrid", f"flight {i}", slide=2.0, dt=0.02) for i in range(6)}


@pytest.mark.parametrize("picture", REPORT_FIGURES, ids=lambda picture: picture.name)
def test_every_figure_draws_any_number_of_runs(six, picture, tmp_path):
    for path in style.save(picture.draw({"flight 0": six["flight 0"]}), tmp_path / picture.name):
        assert path.stat().st_size > 1500
    assert len(style.png(picture.draw(six))) > 1500


def test_poses_are_drawn_of_flights_that_lived_to_slide(make_run):
    slid, lost = make_run("hybrid"), make_run("pid")
    lost = Run("pid", "pid", lost.log.isel(time=slice(0, 5)))
    assert not pose_strip.poses_seen({"pid": lost})
    assert pose_strip.poses_seen({"pid": lost, "hybrid": slid})
    (picture,) = [one for one in REPORT_FIGURES if one.name == "poses"]
    assert picture.suits is pose_strip.poses_seen


def test_where_the_surface_was_looked_for_is_shaded(make_log):
    changes = [[3.5, "slide", "lost", "no force"], [4.0, "lost", "recontact", "rested"]]
    changes += [[4.25, "recontact", "settle", "touched"], [8.0, "slide", "lost", "no force"]]
    log = make_log().assign_attrs(contact_transitions=json.dumps(changes))
    figure = over_time.contact_direction({"following": Run("following", "following", log, {})})
    patches = [patch for patch in figure.axes[0].patches if isinstance(patch, Rectangle)]
    blue = [patch for patch in patches if to_hex(patch.get_facecolor()) == style.LOST.lower()]
    stretches = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in blue]
    np.testing.assert_allclose(stretches, [(3.5, 4.0), (4.0, 4.25), (8.0, float(log.time[-1]))])
    [legend] = figure.legends
    assert "surface lost, looked for again" in [text.get_text() for text in legend.get_texts()]


def test_the_laws_own_target_is_drawn_beside_the_missions_reference(make_log):
    log = make_log()
    own = log.assign(cog_position_target=log.cog_position_reference + 0.4)
    figure = over_time.cog_tracking({"a": Run("a", "following", own, {}), "b": Run("b", "hybrid", log, {})})
    dotted = [[line for line in ax.lines if line.get_linestyle() == ":"] for ax in figure.axes]
    assert [len(lines) for lines in dotted] == [1, 0, 1, 0]
    drawn = np.asarray(dotted[0][0].get_ydata())
    keep = style.thin(log.sizes["time"])
    np.testing.assert_allclose(drawn, own.cog_position_target.values[keep, 1])
    assert "the law's own target" in [text.get_text() for text in figure.legends[0].get_texts()]
    plain = over_time.cog_tracking({"b": Run("b", "hybrid", log, {})})
    assert "the law's own target" not in [text.get_text() for text in plain.legends[0].get_texts()]


@pytest.mark.parametrize("picture", REPORT_FIGURES, ids=lambda picture: picture.name)
def test_a_flight_lost_before_it_touched_is_drawn_too(make_log, picture):
    log = make_log(status="FAILED", cause="fell").isel(time=slice(0, 150))
    runs = {"pid": Run("pid", "pid", log, {}), "hybrid": Run("hybrid", "hybrid", log, {})}
    assert len(style.png(picture.draw(runs))) > 1500


@pytest.fixture
def named(monkeypatch):
    """For what asks which files there are, not what is in them."""

    def save(figure, stem):
        files = stem.with_suffix(".png"), stem.with_suffix(".pdf")
        for file in files:
            file.touch()
        return files

    monkeypatch.setattr(style, "save", save)


@pytest.mark.usefixtures("named")
def test_only_figures_that_compare_need_several_runs(make_run, tmp_path):
    run = make_run(slide=2.0)
    write_figures({"a": run}, tmp_path / "one")
    names = {path.name for path in (tmp_path / "one").iterdir()}
    assert names == {
        f"{name}.{kind}"
        for name in FILES - {"sliding_errors", "contact_distributions"}
        for kind in ("png", "pdf")
    }
    write_figures({"a": run, "b": run}, tmp_path / "two")
    assert {path.stem for path in (tmp_path / "two").iterdir()} == FILES
    lost = make_run(slide=2.0, status="FAILED", cause="hit the floor")
    write_figures({"a": lost, "b": lost}, tmp_path / "lost")
    found = {path.stem for path in (tmp_path / "lost").iterdir()}
    assert found == FILES - {"sliding_errors", "contact_distributions"}


def test_a_flight_of_a_second_has_a_scale_of_time(make_run):
    log = make_run().log.isel(time=slice(0, 260))
    figure = over_time.cog_tracking({"hybrid": Run("hybrid", "hybrid", log)})
    figure.draw_without_rendering()
    within = [tick for tick in figure.axes[1].get_xticks() if 0.0 <= tick <= 1.3]
    assert len(within) >= 4


@pytest.mark.usefixtures("named")
def test_a_flight_that_touched_nothing_has_no_pen_trace(make_run, tmp_path):
    run = make_run(slide=2.0)
    free = Run("free", "hybrid", run.log.assign(contact=0 * run.log.contact), {})
    write_figures({"free": free}, tmp_path / "free")
    names = {path.stem for path in (tmp_path / "free").iterdir()}
    assert names == {"cog_tracking", "contact_direction", "poses"}
    write_figures({"free": free, "run": run}, tmp_path / "both")
    assert {path.stem for path in (tmp_path / "both").iterdir()} == FILES


def test_a_ceiling_is_no_line_when_seen_from_above(make_run):
    run = make_run(slide=2.0)

    def boards(run):
        figure = pose_strip.poses({"a": run})
        return sum(line.get_color() == pose_strip.BOARD for ax in figure.axes for line in ax.lines)

    assert boards(run) == 5
    down = json.loads(run.log.attrs["surface"]) | {"axis_v": [1.0, 0.0, 0.0], "normal": [0.0, 0.0, -1.0]}
    over = Run("a", "hybrid", run.log.assign_attrs(surface=json.dumps(down)), {})
    assert boards(over) == 0


def test_files_are_sharp_and_embed_their_fonts(make_run, tmp_path, sharp):
    picture, document = style.save(over_time.cog_tracking({"a": make_run(slide=2.0)}), tmp_path / "x")
    with Image.open(picture) as image:
        assert round(image.info["dpi"][0]) == style.DPI
        assert image.width == pytest.approx(style.DPI * 0.75 * style.WIDTH, abs=2)
    content = document.read_bytes()
    assert b"/FontFile2" in content
    assert b"/Type3" not in content


def test_a_picture_does_not_depend_on_when_it_is_drawn(make_run, tmp_path):
    runs = {"a": make_run(slide=2.0)}
    first = [path.read_bytes() for path in style.save(pose_strip.poses(runs), tmp_path / "x")]
    assert first[0] == style.save(pose_strip.poses(runs), tmp_path / "y")[0].read_bytes()


def test_pen_traces_show_what_was_drawn(make_run):
    run = make_run(error=(0.0, 0.05, 0.0))
    (ax,) = used(traces.pen_traces({"hybrid": run}))
    nominal, trace, first = ax.lines
    drawn = np.array(trace.get_data()).T
    meant = np.array(nominal.get_data()).T
    # +y is to the left for the robot; the pen is pushed 50 mm there, and tilted onto the board's plane.
    assert np.mean(drawn[:, 0]) - np.mean(meant[:, 0]) == pytest.approx(
        -0.05 / np.cos(np.radians(20)), abs=0.02
    )
    assert np.ptp(drawn[:, 1]) == pytest.approx(0.6, abs=0.01)
    assert np.array(first.get_data()).ravel() == pytest.approx(drawn[0])
    assert to_hex(trace.get_color()).upper() == CONTROLLER_COLOURS["hybrid"].upper()


def test_contact_is_shaded_where_there_is_contact(make_run):
    run = make_run(slide=4.0)
    figure = over_time.cog_tracking({"hybrid": run})
    touching = run.log.time.values[run.log.contact.values > 0]
    for ax in used(figure):
        (shade,) = ax.patches
        box = shade.get_path().transformed(shade.get_patch_transform()).get_extents()
        assert (box.x0, box.x1) == pytest.approx((touching[0], touching[-1]))


def test_adaptation_is_shaded_only_where_the_arm_adapts(make_run):
    colour = style.ADAPTATION.lower()

    def shaded(run):
        figure = over_time.contact_direction({"a": run})
        return any(to_hex(patch.get_facecolor()) == colour for ax in used(figure) for patch in ax.patches)

    assert shaded(make_run("hybrid"))
    assert not shaded(make_run("impedance"))


def test_boxes_stand_at_the_scores_and_the_papers_medians_beside_them(four_runs):
    figure = boxes.sliding_errors(four_runs)
    left, right = used(figure)
    heights = {round(height(line), 6) for line in left.lines if line.get_linewidth() == 1.6}
    scores = {round(run.metrics["error_u_median"], 6) for run in four_runs.values() if not run.failed}
    assert heights == scores
    diamonds = [height(line) for line in left.lines if line.get_marker() == "D"]
    assert diamonds == [0.134, 0.079, 0.105, 0.083]
    assert not [line for line in right.lines if line.get_marker() == "D"]  # the paper prints no z


def test_the_papers_medians_only_stand_beside_the_papers_configuration(make_run):
    run = make_run("pid")
    run.log.attrs["config"] = run.config.replace('shape = "circle"', 'shape = "line"')
    left, _ = used(boxes.sliding_errors({"pid": run, "other": run}))
    assert not [line for line in left.lines if line.get_marker() == "D"]


def test_poses_come_at_quarters_of_the_path(make_run):
    run = make_run("hybrid", slide=6.0)
    figure = pose_strip.poses({"hybrid": run})
    titles = [ax.get_title() for ax in figure.axes]
    assert titles == ["start of the path", *(f"{part}% of the path" for part in (25, 50, 75, 100))]
    words = [next(text.get_text() for text in ax.texts if "reach" in text.get_text()) for ax in figure.axes]
    shown = [text.splitlines()[-1] for text in words]
    reach = run.log.reach.values[run.log.phase.values == 4]
    assert shown == [f"reach {reach[round(f * (len(reach) - 1))]:.2f} m" for f in pose_strip.FRACTIONS]


def test_poses_of_a_path_that_nobody_ended_are_not_called_parts_of_the_path(make_run):
    run = make_run("hybrid", slide=6.0)
    log = run.log.isel(time=slice(0, int(np.flatnonzero(run.log.phase.values == 4)[-50])))
    lost = Run("lost", "hybrid", log.assign_attrs(status="FAILED"))

    def titles(**runs):
        return [ax.get_title() for ax in pose_strip.poses(runs).axes]

    assert titles(lost=lost)[1:5] == [f"{part}% of what was flown" for part in (25, 50, 75, 100)]
    assert titles(lost=lost, whole=run)[1:5] == [f"{part}% of the path" for part in (25, 50, 75, 100)]


def test_a_clock_that_was_held_back_takes_no_pose_from_the_others(make_run):
    quick, slow = make_run("hybrid", slide=3.0, dt=0.01), make_run("following", slide=6.0, dt=0.01)
    sliding = slow.log.phase.values == 4
    clock = np.cumsum(np.where(sliding, 0.005, 0.01))
    paced = Run("following", "following", slow.log.assign(mission_time=("time", clock)), {})
    figure = pose_strip.poses({"quick": quick, "paced": paced})
    shown = [any("reach" in text.get_text() for text in ax.texts) for ax in figure.axes]
    assert shown == [True] * 10
    unpaced = pose_strip.poses({"quick": quick, "slow": slow})
    assert [any("reach" in text.get_text() for text in ax.texts) for ax in unpaced.axes].count(True) == 8


def whole(figure):
    """Nothing of a figure is cut off at its edge."""
    style.png(figure)
    box, (wide, tall) = figure.get_tightbbox(), figure.get_size_inches()
    return min(box.x0, box.y0) > -0.01 and box.x1 < wide + 0.01 and box.y1 < tall + 0.01


@pytest.mark.parametrize("picture", REPORT_FIGURES, ids=lambda picture: picture.name)
def test_nothing_of_a_single_flight_is_cut_off_at_the_edge(six, picture, sharp):
    assert whole(picture.draw({"flight 0": six["flight 0"]}))


@pytest.mark.parametrize("count", [5, 10, 14])
@pytest.mark.parametrize("draw", [boxes.sliding_errors, boxes.contact_distributions])
def test_boxes_of_many_runs_stand_apart_from_the_numbers_of_others(six, draw, count, sharp):
    """Of ten, each median's number lay on the next box; long names left no room for what an axis shows."""
    figure = draw({f"my_long_gains_{i}": six[f"flight {i % 6}"] for i in range(count)})
    assert whole(figure)
    for ax in figure.axes:
        figure.draw_without_rendering()
        label = ax.yaxis.label.get_window_extent()
        assert label.y1 < figure.bbox.y1
        found = [patch.get_window_extent() for patch in ax.patches]
        for number in ax.texts:
            words = number.get_window_extent()
            assert not any(box.x0 < words.x1 and words.x0 < box.x1 - 1.0 for box in found)


def test_the_scale_bar_lies_above_all_robots(six):
    figure = pose_strip.poses({"flight 0": six["flight 0"]})
    ax = figure.axes[0]
    bar = next(line for line in ax.lines if not line.get_clip_on())
    others = [line for line in ax.lines if line is not bar]
    assert height(bar) > max(float(np.max(line.get_ydata())) for line in others)


@pytest.mark.parametrize("flat", [0, 1])
def test_a_drawing_that_is_a_line_has_room_for_the_numbers_of_its_scale(make_run, monkeypatch, flat):
    run = make_run("hybrid", "drawing", slide=2.0, dt=0.02)
    seen = drawing.as_seen
    monkeypatch.setattr(drawing, "as_seen", lambda log, line: seen(log, line) * np.eye(2)[1 - flat])
    figure = drawing.drawn_line({"drawing": run})
    assert whole(figure)
    assert numbers_stand_apart(figure.axes[0], flat)


@pytest.mark.parametrize("flat", [0, 1])
def test_a_straight_stroke_has_room_for_the_numbers_of_its_scale(make_run, monkeypatch, flat):
    seen = traces.on_board
    monkeypatch.setattr(traces, "on_board", lambda *given: seen(*given) * [[0.01, 1.0], [1.0, 0.01]][flat])
    assert numbers_stand_apart(traces.pen_traces({"a": make_run()}).axes[0], flat)


def numbers_stand_apart(ax, flat):
    """Whether an axis (0 for x, 1 for y) has two numbers at least, none on another."""
    ax.figure.draw_without_rendering()
    ticks = [ax.get_xticklabels(), ax.get_yticklabels()][flat]
    inside = [ax.get_xlim(), ax.get_ylim()][flat]
    boxes = [
        tick.get_window_extent() for tick in ticks if inside[0] <= tick.get_position()[flat] <= inside[1]
    ]
    ends = sorted((box.y0, box.y1) if flat else (box.x0, box.x1) for box in boxes)
    return len(ends) >= 2 and all(before[1] <= after[0] for before, after in itertools.pairwise(ends))


@pytest.mark.parametrize("picture", REPORT_FIGURES, ids=lambda picture: picture.name)
def test_a_failed_flight_is_named_as_one_and_nothing_is_cut_off_at_the_edge(four_runs, picture, sharp):
    figure = picture.draw(four_runs)
    assert whole(figure)
    words = " ".join([*texts(figure), *(ax.get_ylabel() for ax in figure.axes)])
    assert "failed" in words


def test_panels_fill_their_rows():
    assert [style.panels(count) for count in (1, 4, 5, 6, 9)] == [(1, 1), (1, 4), (2, 3), (2, 3), (3, 3)]
    assert style.panels(3, 2) == (2, 2)


def test_a_legend_has_the_colours_of_the_runs(make_run):
    runs = {name: make_run(name, slide=1.0, dt=0.02) for name in ("pid", "hybrid")}
    wanted = set(colours(runs).values())
    for draw in (over_time.cog_tracking, over_time.contact_direction, traces.pen_traces, pose_strip.poses):
        legend = draw(runs).legends[0]
        assert wanted <= {to_hex(line.get_color()).upper() for line in legend.findobj(Line2D)}, draw.__name__


def test_each_run_has_a_colour_of_its_own(make_run):
    names = ("pid", "impedance", "admittance", "hybrid")
    runs = {name: make_run(name, slide=1.0, dt=0.02) for name in names}
    assert colours(runs) == {name: CONTROLLER_COLOURS[name] for name in names}
    same = {f"hybrid {i}": Run(f"hybrid {i}", "hybrid", runs["hybrid"].log, {}) for i in range(6)}
    assert len(set(colours(same).values())) == 6


def test_the_callers_settings_are_left_alone(make_run):
    before = dict(matplotlib.rcParams)
    pose_strip.poses({"a": make_run(slide=1.0)})
    assert dict(matplotlib.rcParams) == before


def test_drawing_needs_no_pyplot():
    code = "import sys, skylimb.analysis.figures; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
