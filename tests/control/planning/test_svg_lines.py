"""What a drawing may be made of."""

import signal
import subprocess
import sys

import pytest

from hostile_files import svg, uses
from skylimb.base.errors import ConfigError
from skylimb.control.planning import svg_lines


def read(path: str) -> int:
    """Points of the lines of an SVG with one path."""
    text = f'<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0{path}" fill="none" stroke="red"/></svg>'
    return sum(map(len, svg_lines.svg_lines(text.encode(), "mine.svg")))


def test_curves_are_few_and_straight_pieces_may_be_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(svg_lines, "_MOST_CURVES", 3)
    assert read(" l 1 2 l 2 -1" * 5) >= 11
    assert read(" q 1 2 2 0" * 3) > 11
    with pytest.raises(ConfigError, match=r"mine\.svg has 4 curves, more than 3; make it simpler"):
        read(" q 1 2 2 0" * 4)


@pytest.mark.parametrize(
    ("words", "seen"),
    [
        ("%s", True),
        ('<g opacity="0">%s</g>', False),
        ('<g style="opacity:0%%">%s</g>', False),
        ('<g opacity="0.5">%s</g>', True),
        ('<g visibility="hidden">%s</g>', False),
        ('<g visibility="collapse">%s</g>', False),
        ('<g visibility="hidden"><g visibility="visible">%s</g></g>', True),
        ('<g opacity="0"><g opacity="1">%s</g></g>', False),
        ('<g opacity="0"><text>not seen</text></g>%s', True),
    ],
)
def test_what_nobody_sees_is_not_drawn(words: str, seen: bool) -> None:
    path = '<path d="M0 0 H9" stroke="red"/>'
    text = f'<svg xmlns="http://www.w3.org/2000/svg">{words % path}</svg>'
    if seen:
        assert len(svg_lines.svg_lines(text.encode(), "mine.svg")) == 1
    else:
        with pytest.raises(ConfigError, match="nothing to draw"):
            svg_lines.svg_lines(text.encode(), "mine.svg")


@pytest.mark.skipif(not hasattr(signal, "ITIMER_PROF"), reason="a system without timers of the processor")
def test_a_drawing_that_asks_for_too_much_ends_by_its_own_clock() -> None:
    """In parts of a second, whatever the process that waits for it does."""
    command = [sys.executable, "-m", svg_lines.__name__, "", "0.1"]
    done = subprocess.run(command, input=svg(uses(9)).encode(), capture_output=True, timeout=120, check=False)
    assert done.returncode == -signal.SIGPROF
