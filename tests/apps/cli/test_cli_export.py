from pathlib import Path

import pytest

from skylimb.apps.cli import main


def test_export_c_leaves_what_it_promises(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "c"
    assert main(["export-c", "--controller", "pid", "--rate", "250", str(folder)]) == 0
    out = capsys.readouterr().out
    for name in ("controller_function.c", "controller.c", "controller.h", "test_vector.h", "main.c"):
        assert (folder / name).is_file()
        assert name in out
    assert "0.004" in (folder / "controller.h").read_text()
    assert main(["export-c", str(folder)]) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--controller", "hybird"], "did you mean 'hybrid'"),
        (["--rate", "0"], "--rate = 0 Hz"),
        (["--robot", "hydra"], "hydra"),
        (["--log", "flown", "--calibration", "mine.toml"], "--calibration cannot stand beside --log"),
        (["--log", "flown", "--rate", "100"], "--rate cannot stand beside --log"),
    ],
)
def test_what_cannot_be_exported_leaves_nothing(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export-c", *words, str(tmp_path / "c")]) == 2
    assert message in capsys.readouterr().err
    assert not any(tmp_path.iterdir())
