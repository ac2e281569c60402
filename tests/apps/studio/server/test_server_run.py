"""The command from its first line to its last: a token by default, and a farewell that keeps the flight."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from websockets.sync.client import connect

from skylimb.analysis.recording import Run
from skylimb.apps.cli.main import main


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (("--controller", "pid", "hybrid", "following"), "at most 2"),
        (("--out", "/dev/null"), "'/dev/null' is a file, not a folder"),
    ],
)
def test_what_cannot_be_is_refused_before_a_page_opens(
    said: tuple[str, ...], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["studio", "--no-browser", *said]) == 2
    captured = capsys.readouterr()
    assert why in captured.err
    assert captured.out == ""


def test_the_end_that_the_system_asks_for_says_farewell_and_keeps(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "skylimb",
        "studio",
        "free_flight",
        "--no-browser",
        "--out",
        str(tmp_path),
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url, watch = (process.stdout.readline().split()[k] for k in (2, 3))
        address, _, token = url.partition("?")
        assert token.startswith("token=")
        assert watch.startswith(f"{address}?token=")
        assert watch != url
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(address, timeout=10)
        with connect(
            address.replace("http", "ws") + f"socket?page=one&{token}",
            origin=address.rstrip("/"),  # type: ignore[arg-type]
            max_size=2**24,
        ) as page:
            frames = 0
            while frames < 5:
                frames += not isinstance(page.recv(timeout=60), str)
            process.send_signal(signal.SIGTERM)
            said = {}
            while said.get("event") != "farewell":
                message = page.recv(timeout=60)
                said = json.loads(message) if isinstance(message, str) else said
        assert said["folder"] == str(tmp_path / "kept-1")
        assert f"the flight is kept in {tmp_path / 'kept-1'}" in process.stdout.read()
        assert process.wait(60) == 0
    assert Run.load(tmp_path / "kept-1").stopped
