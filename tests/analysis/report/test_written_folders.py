"""What a run and a comparison leave on disk: the record all or nothing, the rest part by part."""

import base64
import csv
import errno
import json
import os
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import pytest
import xarray as xr
from matplotlib.figure import Figure

from skylimb.analysis import write_comparison, write_report, write_run, write_videos
from skylimb.analysis.figures import report_figures
from skylimb.analysis.recording import Run, load_runs
from skylimb.analysis.report import attempts, output, videos
from skylimb.analysis.report.output import write_records, write_scores
from skylimb.analysis.report.places import film_mark
from skylimb.analysis.report.report import render_report
from skylimb.analysis.scores.registry import NUMERIC_KEYS
from skylimb.analysis.scores.user_scores import UserFigure, scored
from skylimb.apps.cli import main
from skylimb.base.errors import OutputError


@pytest.fixture(scope="module")
def comparison(four_runs, tmp_path_factory):
    """The folder of a comparison, to be looked at; who changes it takes a copy."""
    return write_comparison(four_runs, tmp_path_factory.mktemp("comparison") / "out")


class Page(HTMLParser):
    """Collects a page's pictures, links and text, and checks that its elements are closed in order."""

    EMPTY = frozenset({"meta", "img", "link", "br"})

    def __init__(self, text):
        super().__init__()
        self.open, self.found, self.text = [], [], ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.text += data

    def all(self, tag):
        return [attrs for name, attrs in self.found if name == tag]


def test_a_run_leaves_its_files(make_run, tmp_path):
    run = make_run(slide=2.0)
    assert write_run(run, tmp_path / "out") == tmp_path / "out"
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"log.nc", "metrics.json", "config.toml", "figures", "report.html"}
    assert json.loads((tmp_path / "out/metrics.json").read_text()) == run.metrics
    assert (tmp_path / "out/config.toml").read_text() == run.config
    xr.testing.assert_identical(load_runs(tmp_path / "out")["hybrid"].log, Run.load(tmp_path / "out").log)


def test_a_comparison_leaves_its_files(four_runs, comparison):
    names = {path.name for path in (comparison).iterdir()}
    assert names == {*four_runs, "metrics.csv", "report.html", "figures"}
    with (comparison / "metrics.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["run"] for row in rows] == list(four_runs)
    assert list(rows[0]) == ["run", "controller", "status", "cause", *NUMERIC_KEYS]
    for row, run in zip(rows, four_runs.values(), strict=True):
        assert row["status"] == run.status
        assert row["cause"] == run.cause
        for key in NUMERIC_KEYS:
            assert (float(row[key]) if row[key] else None) == run.metrics[key]
    assert list(load_runs(comparison)) == list(four_runs)
    failed = json.loads((comparison / "admittance/metrics.json").read_text())
    assert failed["status"] == "FAILED"
    assert failed["cause"]
    assert failed["tilt_max"] is None


def test_the_report_is_one_file_that_says_it_all(comparison):
    page = Page((comparison / "report.html").read_text(encoding="utf-8"))
    pictures = page.all("img")
    assert len(pictures) == 6
    for picture in pictures:
        assert len(picture["alt"]) > 40
        kind, data = picture["src"].split(",")
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data)[1:4] == b"PNG"
    assert page.all("link") == []
    assert [script for script in page.all("script") if "src" in script] == []  # all that runs is in the page
    for link in page.all("a"):
        if link["href"].startswith("#"):
            assert any(attrs.get("id") == link["href"][1:] for _, attrs in page.found)
        else:
            assert (comparison / link["href"]).is_file()
    assert "Z. Luo" in page.text
    for words in ("tilt above 1 rad at t = 5.00 s", "3 of 4 flights finished", "paper 0.134", "seed 3"):
        assert words in page.text
    for name in ("pid", "impedance", "admittance", "hybrid"):
        assert f"skylimb run {name}/config.toml" in page.text
        assert (comparison / name / "config.toml").is_file()
    assert "nan" not in re.sub(r"[^a-z ]", " ", page.text.lower()).split()


def test_the_report_lists_what_the_controller_made_of_the_contact(make_log, tmp_path, comparison):
    title = "What the controller made of the contact"
    assert title not in (comparison / "report.html").read_text()
    changes = [[2.5, "approach", "settle", "touched"]] + [[3.0 + 0.01 * i, "a", "b", "c"] for i in range(60)]
    log = make_log(slide=1.0).assign_attrs(contact_transitions=json.dumps(changes))
    (tmp_path / "figures").mkdir()
    text = render_report({"following": Run("following", "following", log, {})}, tmp_path)
    page = Page(text)
    assert title in page.text
    assert "Following: 61 changes of the contact's state" in page.text
    assert "The first 60" in page.text
    assert "<td>2.500</td><td>approach</td><td>settle</td><td>touched</td>" in text


def test_the_report_lists_what_happened_once_for_all_flights(
    make_log, make_event, happening, tmp_path, comparison
):
    assert '<h2 id="events">' not in (comparison / "report.html").read_text()
    (tmp_path / "figures").mkdir()
    log = happening(make_log(slide=1.0), make_event(time=3.0), make_event("gain", 2.0, 0.5, "a.b to 2"))

    def text(*logs):
        return render_report({f"run {k}": Run("pid", "pid", log, {}) for k, log in enumerate(logs)}, tmp_path)

    shared = text(log, log)
    assert shared.count("<td>2.000</td><td>0.5</td><td>gain</td><td>a.b to 2</td>") == 1
    assert shared.index("<td>1</td><td>2.000</td>") < shared.index("<td>2</td><td>3.000</td>")
    assert "<summary>2 events</summary>" in shared
    apart = text(log, happening(log, make_event(time=1.0)), happening(log))
    assert "<summary>run 0: 2 events</summary>" in apart
    assert "<summary>run 1: 1 event</summary>" in apart
    assert "run 2: " not in apart.split('id="events"')[1].split("<h2")[0]
    many = text(happening(log, *(make_event(time=0.01 * k) for k in range(70))))
    assert "<details><summary>70 events" in many  # closed until somebody wants them
    assert "The first 60" in many


def test_figures_stand_before_the_contacts_states(make_log, tmp_path):
    """A drawing has dozens of changes of state: nobody scrolls through them to the first figure."""
    log = make_log(slide=1.0).assign_attrs(
        contact_transitions=json.dumps([[0.1 * i, "a", "b", "c"] for i in range(51)])
    )
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "poses.png").write_bytes(b"PNG")
    text = render_report({"following": Run("following", "following", log, {})}, tmp_path)
    assert text.index('id="figures"') < text.index('id="contact"')
    assert "<details><summary>Following: 51 changes" in text  # closed until somebody wants them


def test_a_report_says_at_its_top_what_was_done_as_commanded_and_what_was_not(make_log, tmp_path):
    (tmp_path / "figures").mkdir()
    missed = {"done": False, "missed": ["the pen touches 88 % of the time, 95 % commanded"]}

    def words(**scores: dict[str, Any]) -> str:
        runs = {name: Run(name, name, make_log(slide=1.0), found) for name, found in scores.items()}
        return " ".join(Page(render_report(runs, tmp_path)).text.split())

    assert "the flight finished done as commanded" in words(following={"done": True})
    assert "done as commanded" not in words(pid={"done": None})  # nothing was commanded that could be judged
    one, two = words(hybrid=missed), words(hybrid=missed, following={"done": True})
    assert "the flight finished not done as commanded" in one
    assert "all 2 flights finished 1 of 2 done as commanded" in two
    for each in (one, two):
        assert "Hybrid missed 1 tolerance the pen touches 88 % of the time, 95 % commanded" in each


def test_words_of_the_users_are_not_taken_for_markup(make_log, tmp_path, no_figures):
    log = make_log(status="FAILED", cause="<b>1 & 2</b>", slide=1.0)
    runs = {"a<i>b".replace("<i>", "-"): Run("a-b", "<script>x</script>", log, {})}
    write_comparison(runs, tmp_path / "out")
    text = (tmp_path / "out/report.html").read_text()
    assert "<script>x" not in text
    assert "&lt;b&gt;1 &amp; 2&lt;/b&gt;" in text


@pytest.mark.parametrize("write", [write_run, write_comparison])
def test_an_existing_folder_is_refused_before_anything_is_drawn(make_run, tmp_path, monkeypatch, write):
    run = make_run(slide=1.0)
    (tmp_path / "out").mkdir()
    (tmp_path / "out/mine").write_text("mine")
    monkeypatch.setattr(report_figures, "write_figures", lambda *_: pytest.fail("must not draw"))
    with pytest.raises(OutputError, match="exists already"):
        write(run if write is write_run else {"a": run}, tmp_path / "out")
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "mine"]


def test_a_record_that_cannot_be_written_leaves_nothing(make_run, tmp_path, monkeypatch):
    run = make_run(slide=1.0)
    odd = replace(run, log=run.log.assign(odd=("time", [object()] * run.log.sizes["time"])))
    with pytest.raises(OutputError, match="variable 'odd' holds object"):
        write_comparison({"a": run, "b": odd}, tmp_path / "deep" / "out")
    assert list(tmp_path.iterdir()) == []


def test_what_fails_after_the_record_is_named_and_the_rest_is_there(make_run, tmp_path):
    def torn(run):
        raise ValueError("no paper")

    run = make_run(slide=1.0)
    figures = [UserFigure("torn", torn), UserFigure("whole", lambda run: Figure())]
    folder = write_records({run.name: run}, tmp_path / "out")
    (line,) = write_report({run.name: run}, folder, figures)
    assert re.match(r"figure 'torn' fails in .*line \d+, `raise ValueError.*: ValueError: no paper$", line)
    assert (folder / "failed.txt").read_text() == f"{line}\n"
    assert {path.stem for path in (folder / "figures").iterdir()} >= {"cog_tracking", "whole"}
    assert not list(folder.glob("figures/torn*"))
    assert len(Page((folder / "report.html").read_text()).all("img")) == 5
    assert write_report({run.name: run}, folder, figures[1:]) == ()
    assert not (folder / "failed.txt").exists()
    with pytest.warns(UserWarning, match="no paper"):
        write_run(run, tmp_path / "at-once", figures=figures)


def test_scores_go_into_a_record_that_has_others(make_run, make_log, tmp_path):
    run = make_run(slide=1.0)
    folder = write_records({"a": replace(run, metrics={}), "b": run}, tmp_path / "out")
    before = (folder / "b/log.nc").read_bytes()
    assert load_runs(folder)["a"].metrics == {}
    assert write_scores({"a": run, "b": run}, folder) == ()
    loaded = load_runs(folder)["a"]
    assert loaded.metrics == run.metrics
    xr.testing.assert_identical(loaded.log.drop_attrs(), load_runs(folder)["b"].log.drop_attrs())
    assert json.loads((folder / "a/metrics.json").read_text()) == run.metrics
    assert (folder / "b/log.nc").read_bytes() == before


@pytest.mark.parametrize("name", ["../up", "figures", ".hidden", "a/b", ""])
def test_names_that_cannot_be_folders_are_refused(make_run, tmp_path, name):
    with pytest.raises(OutputError, match="cannot be the name of a folder"):
        write_comparison({name: make_run(slide=1.0)}, tmp_path / "out")
    with pytest.raises(OutputError, match="at least one run"):
        write_comparison({}, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_each_run_of_a_comparison_has_its_record_and_no_figures_of_its_own(comparison, four_runs):
    for name in four_runs:
        names = {path.name for path in (comparison / name).iterdir()}
        assert names == {"log.nc", "metrics.json", "config.toml"}


@pytest.fixture
def filmed(monkeypatch, no_figures):
    """A camera that only notes what it was asked to film."""
    taken = []

    def film(run, log, path, *, progress, threads):
        progress(1, 2)
        taken.append((run.name, log.relative_to(path.parent).as_posix(), threads))
        path.write_bytes(f"film of {run.name}".encode())

    monkeypatch.setattr(videos, "film_record", film)
    return taken


def test_the_report_is_there_before_its_videos_and_shows_them_after(make_run, tmp_path, filmed):
    runs = {name: make_run(name, slide=1.0) for name in ("pid", "hybrid")}
    folder = write_comparison(runs, tmp_path / "out", videos_follow=True)
    page = Page((folder / "report.html").read_text())
    assert [video["src"] for video in page.all("video")] == ["pid/video.mp4", "hybrid/video.mp4"]
    assert "Reload the page" in page.text
    told = []
    assert write_videos(runs, folder, lambda *step: told.append(step)) == ()
    assert sorted(told) == [("hybrid", 1, 2), ("pid", 1, 2)]
    assert sorted(filmed)[0][:2] == ("hybrid", "log.nc")
    page = Page((folder / "report.html").read_text())
    sources = [base64.b64decode(video["src"].split(",")[1]) for video in page.all("video")]
    assert sources == [b"film of pid", b"film of hybrid"]
    assert "Reload the page" not in page.text


def test_the_video_of_a_single_run_lies_beside_its_log(make_run, tmp_path, filmed):
    run = make_run(slide=1.0)
    folder = write_run(run, tmp_path / "out", videos_follow=True)
    assert write_videos({run.name: run}, folder) == ()
    assert (folder / "video.mp4").read_bytes() == b"film of hybrid"
    assert len(Page((folder / "report.html").read_text()).all("video")) == 1
    with pytest.raises(OutputError, match="does not exist"):
        write_videos({run.name: run}, tmp_path / "nowhere")


def test_the_film_of_another_flight_is_not_shown(make_run, tmp_path, no_figures, capsys):
    run, other = make_run(slide=1.0), make_run(slide=1.5)
    folder = write_run(run, tmp_path / "out")
    film = folder / "video.mp4"
    for shown, count in ((run, 1), (other, 0)):
        film.write_bytes(b"film " + film_mark(shown).encode() + b" of it")
        assert main(["score", str(folder)]) == 0
        assert len(Page((folder / "report.html").read_text()).all("video")) == count
        assert (f"note: '{film}' shows another flight" in capsys.readouterr().out) == (count == 0)
    assert film.exists()  # it may be the only one


def test_cores_are_shared_among_the_videos(make_run, tmp_path, monkeypatch, filmed):
    monkeypatch.setattr("os.cpu_count", lambda: 8)
    runs = {name: make_run(name, slide=1.0) for name in ("pid", "hybrid")}
    write_videos(runs, write_comparison(runs, tmp_path / "out"))
    assert [threads for _, _, threads in filmed] == [4, 4]


def test_a_video_that_cannot_be_drawn_is_a_warning(make_run, tmp_path, monkeypatch, caplog, no_figures):
    def film(run, _log, path, **_):
        if run.name == "hybrid":
            raise OutputError("no video of 'hybrid': no off-screen renderer works here")
        path.write_bytes(b"film")

    monkeypatch.setattr(videos, "film_record", film)
    runs = {name: make_run(name, slide=1.0) for name in ("pid", "hybrid")}
    folder = write_comparison(runs, tmp_path / "out", videos_follow=True)
    assert write_videos(runs, folder) == ("no video of 'hybrid': no off-screen renderer works here",)
    assert "no off-screen renderer" in caplog.text
    assert not (folder / "hybrid/video.mp4").exists()
    page = Page((folder / "report.html").read_text())
    assert len(page.all("video")) == 1
    assert "Reload the page" not in page.text


def test_an_interruption_keeps_the_report_and_what_was_filmed(make_run, tmp_path, monkeypatch, no_figures):
    def film(run, _log, path, *, progress, threads):
        path.write_bytes(b"film")
        progress(1, 1)

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(videos, "film_record", film)
    run = make_run(slide=1.0)
    folder = write_run(run, tmp_path / "out", videos_follow=True)
    with pytest.raises(KeyboardInterrupt):
        write_videos({run.name: run}, folder, interrupt)
    page = Page((folder / "report.html").read_text())
    assert len(page.all("video")) == 1
    assert "Reload the page" not in page.text


def test_a_disk_that_is_full_after_the_record_loses_no_flight(make_run, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    run = make_run(slide=1.0)
    folder = write_records({run.name: replace(run, metrics={})}, tmp_path / "out")
    for module in (output, attempts):
        monkeypatch.setattr(module, "replace_text", full)
    monkeypatch.setattr(output, "replacing", full)
    monkeypatch.setattr("skylimb.analysis.figures.style.save", full)
    failed = write_report({run.name: run}, folder)
    assert [line.partition(" failed: ")[0] for line in failed] == [
        "metrics.json", "scores in log.nc",
        "figure 'pen_traces'", "figure 'cog_tracking'", "figure 'contact_direction'", "figure 'poses'",
        "report.html",
    ]  # fmt: skip
    assert all("No space left on device" in line for line in failed)
    assert Run.load(folder).metrics == {}
    xr.testing.assert_equal(Run.load(folder).log, run.log)


def test_a_report_can_be_made_anew_from_the_logs_alone(comparison, tmp_path):
    folder = shutil.copytree(comparison, tmp_path / "out")
    whole = {path.relative_to(folder) for path in folder.rglob("*")}
    kept = (folder / "pid/log.nc").read_bytes()
    wanted = (folder / "metrics.csv").read_text()
    for path in [
        *folder.rglob("*.png"),
        *folder.rglob("*.pdf"),
        folder / "report.html",
        folder / "pid/metrics.json",
    ]:
        path.unlink()
    (folder / "metrics.csv").write_text("run\npid\nimpedance\nadmittance\nhybrid\n")
    (folder / "pid" / "video.mp4").write_bytes(b"film")
    assert write_report({name: scored(run) for name, run in load_runs(folder).items()}, folder) == ()
    (folder / "pid" / "video.mp4").unlink()
    assert {path.relative_to(folder) for path in folder.rglob("*")} == whole
    assert (folder / "metrics.csv").read_text() == wanted
    assert (folder / "pid/log.nc").read_bytes() == kept
    page = Page((folder / "report.html").read_text())
    assert base64.b64decode(page.all("video")[0]["src"].split(",")[1]) == b"film"


def test_a_single_run_can_have_a_report_as_well(make_run, tmp_path):
    folder = write_run(make_run(slide=2.0), tmp_path / "out")
    write_report(load_runs(folder), folder)
    page = Page((folder / "report.html").read_text())
    assert len(page.all("img")) == 4
    assert "skylimb run config.toml" in page.text
    with pytest.raises(OutputError, match="does not exist"):
        write_report({}, tmp_path / "nowhere")


def test_large_videos_are_linked_and_not_put_into_the_page(make_run, tmp_path, monkeypatch, no_figures):
    monkeypatch.setattr("skylimb.analysis.report.report.EMBED_BYTES", 3)
    folder = write_comparison({"a": make_run(slide=1.0)}, tmp_path / "out")
    (folder / "a/video.mp4").write_bytes(b"film")
    write_report(load_runs(folder), folder)
    assert Page((folder / "report.html").read_text()).all("video")[0]["src"] == "a/video.mp4"
