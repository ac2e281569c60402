"""Pages and the flight: who is let in, who drives, what arrives, and what ten thousand wrong messages do."""

from __future__ import annotations

import json
import random
import string
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus

from of_kind import of_kind
from skylimb.apps.studio.messages import Scores
from skylimb.flight.events import GainChange, Push


def get(studio: Any, path: str = "/", **headers: str) -> tuple[int, str, dict[str, str]]:
    request = urllib.request.Request(f"http://127.0.0.1:{studio.port}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status, answer.read().decode(), dict(answer.headers)
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(), dict(error.headers)


def test_the_page_may_load_nothing_from_elsewhere(studio: Any) -> None:
    for path in ("/", "/vendor.js", "/studio.js", "/studio.css"):
        status, _, headers = get(studio, path)
        assert status == 200
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert "http" not in headers["Content-Security-Policy"]


@pytest.mark.parametrize("path", ["/../server.py", "/%2e%2e/server.py", "/index.html", "/etc/passwd", "//"])
def test_no_other_file_is_served(studio: Any, path: str) -> None:
    assert get(studio, path)[0] == 404


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1:1", "127.0.0.1.evil:{port}"]
)
def test_a_name_that_is_not_ours_is_refused(studio: Any, host: str) -> None:
    assert get(studio, Host=host.format(port=studio.port))[0] == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", None, "https://127.0.0.1:{port}", "http://127.0.0.1:1"]
)
def test_a_page_from_elsewhere_is_refused(studio: Any, origin: str | None) -> None:
    given = origin and origin.format(port=studio.port)
    with pytest.raises(InvalidStatus, match="403"), studio.page(origin=given):
        pass


def test_the_token_opens(run_studio: Callable[..., Any], tmp_path: Path) -> None:
    with run_studio(tmp_path, token="sesame-sesame") as studio:
        assert "token=sesame-sesame" in studio.url
        assert get(studio, "/")[0] == 403
        assert get(studio, "/?token=wrong")[0] == 403
        assert get(studio, "/?token=sesame-sesame")[0] == 200
        for token in ("", "sesame", "sesame-sesame2"):
            with pytest.raises(InvalidStatus, match="403"), studio.page(token=token):
                pass
        with studio.page(token="sesame-sesame") as page:
            assert page.event("hello")["scene"]["experiment"] == "free_flight"


def test_an_address_for_watching_lets_nobody_drive(run_studio: Callable[..., Any], tmp_path: Path) -> None:
    with run_studio(tmp_path, token="sesame-sesame") as studio:
        watching = studio.server.access.watching_url
        watch = watching.partition("token=")[2]
        assert len(watch) >= 16
        with (
            studio.page("watcher", token=watch) as watcher,
            studio.page("owner", token="sesame-sesame") as owner,
        ):
            seat = watcher.event("seats")
            assert not seat["drives"]
            assert not seat["may_drive"]
            assert "watch" not in seat
            assert owner.event("seats")["watch"] == watching
            watcher.event("hello")
            for what in ("take over", "restart", "undo"):
                watcher.say(what)
                assert "watching only" in watcher.event("refused")["text"]
                time.sleep(1.1)  # of many refusals only some are said
            assert owner.state_where(lambda state: state["undo"] is None)


def test_frames_come_and_the_time_goes_on(studio: Any) -> None:
    with studio.page() as page:
        hello = page.event("hello")
        frame = page.frame()
        assert len(frame) == hello["scene"]["layout"]["size"]
        assert page.frame_where(lambda later: later[0] != frame[0]) is not None


def test_a_page_that_confirms_nothing_is_sent_little(studio: Any) -> None:
    with studio.page() as page:
        page.event("hello")
        page.say = lambda *_, **__: None  # type: ignore[method-assign]
        page.frame()
        begun, count = time.monotonic(), len(page.frames)
        while time.monotonic() - begun < 0.8:
            try:
                page.connection.recv(timeout=0.2)
                count += 1
            except TimeoutError:
                pass
        assert count < 12


def test_a_gain_is_changed_and_told_to_all(studio: Any) -> None:
    key, value = "controller.translation.normalized_stiffness", [3.0, 3.0, 2.0]
    with studio.page("first") as page, studio.page("second") as other:
        other.event("hello")
        page.event("hello")
        page.say("set", key=key, value=value)
        other.state_where(lambda _: other.value(key) == value)
    change = of_kind(studio.session.live.flights[0].experiment, GainChange)[-1]
    assert (f"controller.{change.key}", change.value) == (key, tuple(value))


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ({"do": "speed", "times": 50}, "20"),
        ({"do": "speed", "times": "fast"}, "float"),
        ({"do": "sped", "times": 1}, "sped"),
        ({"do": "pause", "paused": True, "also": 1}, "also"),
        ({"do": "poke", "link": "link9", "point": [0, 0, 0], "force": [1, 0, 0]}, "link9"),
        ({"do": "poke", "link": "link1", "point": [0, 0, 0], "force": [1e3, 0, 0]}, "50"),
        ({"do": "set", "key": "controller.translation.stiff", "value": 1.0}, "stiff"),
        (
            {"do": "set", "key": "controller.translation.normalized_stiffness", "value": "stiff"},
            "expected a number",
        ),
        ({"do": "set", "key": "controller.translation.normalized_stiffness", "value": [1.0]}, "it needs 3"),
        (
            {"do": "set", "key": "controller.translation.normalized_stiffness", "value": [-1, 1, 1]},
            "stiffness",
        ),
        ({"do": "set", "key": "approach.contact", "value": 1}, "true or false"),
        ({"do": "set", "key": "sensors.latency", "value": 99.0}, "latency"),
        ({"do": "set", "key": "trajectory.function", "value": "evil.py:run"}, "names a file"),
        ({"do": "set", "key": "trajectory.file", "value": "/etc/passwd"}, "trajectory.file"),
        ({"do": "set", "key": "controller.translation.law", "value": "../evil.py"}, "names a file"),
        ({"do": "set", "key": "robot", "value": "../robot"}, "names a file"),
        ({"do": "controllers", "names": ["../evil.py"]}, "evil.py"),
        (
            {"do": "set", "key": "controller.translation.normalized_stiffness", "value": 1.0, "entry": 9},
            "no entry 10",
        ),
        ({"do": "set", "key": "controller.translation.normalized_stiffness", "value": 1.0, "entry": -1}, "0"),
        ({"do": "rewind", "time": -1.0}, "0.0"),
        ({"do": "jump", "branch": 99}, "branch 99 is not there"),
        ({"do": "undo", "seen": 0.5}, "int"),
        ({"do": "keep", "name": "../../etc"}, "letters, digits"),
        ({"do": "surface", "friction": -1}, "0.0"),
        ({"do": "draw"}, "either strokes, or an SVG, or words"),
        ({"do": "draw", "svg": "<svg/>", "text": "hi"}, "either strokes, or an SVG, or words"),
        ({"do": "draw", "text": "hi", "font": "../font"}, "../font"),
        ({"do": "rewind", "time": 0.1, "changes": [{"key": "../x", "value": 1}]}, "regex"),
        ({"do": "step"}, "while it is paused"),
        ({"do": "draw", "svg": "<!DOCTYPE x [<!ENTITY a 'b'>]><svg/>"}, "ENTITY"),
        ({"do": "draw", "svg": "no drawing"}, "draw"),
    ],
)
def test_what_cannot_be_is_refused_with_a_line(studio: Any, message: dict[str, Any], said: str) -> None:
    with studio.page() as page:
        page.event("hello")
        page.connection.send(json.dumps(message))
        assert said in page.event("refused")["text"]


def test_one_drives_and_the_others_watch(studio: Any) -> None:
    with studio.page("first") as first:
        while not first.event("seats")["drives"]:
            pass
        with studio.page("second") as second:
            assert not second.event("seats")["drives"]
            second.say("restart")
            assert "watches" in second.event("refused")["text"]
            second.say("take over")
            while not second.event("seats")["drives"]:
                pass
            while first.event("seats")["drives"]:
                pass


def test_a_page_that_comes_back_finds_its_seat_and_the_past(studio: Any) -> None:
    with studio.page("driver") as page:
        page.say("take over")
        page.frame()
    with studio.page("other") as other, studio.page("driver") as again:
        assert not other.event("seats")["drives"]
        assert again.event("seats")["drives"]
        again.frame()
        assert len(again.history) > 16


def test_a_poke_is_released_when_its_page_leaves(studio: Any) -> None:
    with studio.page("poker") as page:
        page.say("take over")
        page.say("restart")
        page.event("restarted")
        page.say("poke", link="link1", point=[0, 0, 0], force=[0, 1.0, 0])
        begun = page.frame()[0]
        page.frame_where(lambda frame: frame[0] > begun + 0.2)
    until = time.monotonic() + 10
    while (
        of_kind(studio.session.live.flights[0].experiment, Push)[-1].duration > 20
        and time.monotonic() < until
    ):
        time.sleep(0.02)
    assert of_kind(studio.session.live.flights[0].experiment, Push)[-1].duration < 20


def nonsense(random_: random.Random) -> str | bytes:
    """A message that is wrong, nearly right, or right."""
    words = (
        "pause",
        "speed",
        "restart",
        "rewind",
        "set",
        "back",
        "undo",
        "redo",
        "jump",
        "poke",
        "release",
        "surface",
        "got",
        "draw",
    )
    fields = (
        "paused",
        "times",
        "time",
        "entry",
        "branch",
        "seen",
        "to",
        "key",
        "value",
        "link",
        "point",
        "force",
        "frame",
        "strokes",
    )
    values: list[Any] = [
        None, True, 0, -1, 1e300, "", "link1", "x" * 300, [], [0, 0, 0], [1, "a"], {"a": 1}, [[[0, 0]]],
        "controller.translation.normalized_stiffness", [2, 2, 2], 2**70, "\u0000", "../../x",
    ]  # fmt: skip
    match random_.randrange(5):
        case 0:
            return random_.randbytes(random_.randrange(60))
        case 1:
            return "".join(random_.choices(string.printable, k=random_.randrange(80)))
        case 2:
            return "[" * random_.randrange(3000)
        case _:
            chosen = random_.sample(fields, random_.randrange(4))
            given = {name: random_.choice(values) for name in chosen}
            return json.dumps({"do": random_.choice(words), **given})


def test_ten_thousand_wrong_messages_end_nothing(run_studio: Callable[..., Any], tmp_path: Path) -> None:
    random_ = random.Random(13)
    with run_studio(tmp_path) as studio:
        with studio.page() as page:
            page.event("hello")
            for _ in range(10_000):
                page.connection.send(nonsense(random_))
        with studio.page() as page:
            page.event("hello")
            assert page.event("seats")["drives"]
            page.say("restart")
            page.say("pause", paused=False)
            page.event("restarted")
            first = page.frame()[0]
            page.frame_where(lambda frame: frame[0] != first)
        assert {path.name for path in tmp_path.iterdir()} <= {"drawings"}  # nothing was kept


def test_pages_hear_that_a_flight_is_busy(studio: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    done = threading.Event()
    monkeypatch.setitem(studio.flight._acts, Scores, lambda _: done.wait(60.0))
    with studio.page() as page:
        page.event("hello")
        page.say("scores")
        try:
            while not page.event("alive")["busy"]:
                pass
        finally:
            done.set()
        page.frame()
        while page.event("alive")["busy"]:
            pass


def test_a_drawing_of_many_quotes_and_lines_is_read(run_studio: Callable[..., Any], tmp_path: Path) -> None:
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 L 9 1"/><!--' + '"\n' * 230_000 + "--></svg>"
    )
    with run_studio(tmp_path, experiment="paper") as studio, studio.page() as page:
        page.event("hello")
        page.say("draw", svg=svg)
        assert page.event("restarted")["why"] == "a new drawing"
