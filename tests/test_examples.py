import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"

EXPECTED = {
    "stepped": ["touched at", "stopped from outside", "pressed with up to"],
    "run": ["hybrid: OK", "error_y_median", "estimated force while in touch"],
    "own_controller": ["hybrid: OK", " upright: OK"],
    "own_slope": ["20 degrees, leak as in the paper: OK", "FAILED, lost position", "leak compensated: OK"],
    "own_gains": ["k_a =    8 N/m: OK", "k_a =   32 N/m: OK"],
}


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_examples_run(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(path), run_name="__main__")
    out = capsys.readouterr().out
    for line in EXPECTED[path.stem]:
        assert line in out
