"""A name that is unknown is answered with the nearest, and with as much as fits into a line."""

import pytest

from skylimb.base.errors import nearest, unknown_name


def test_all_names_are_listed_up_to_two_dozen() -> None:
    names = [f"n{k:02}" for k in range(25)]
    assert (
        str(unknown_name("thing", "x", names[:24])) == f"unknown thing 'x' (known: {', '.join(names[:24])})"
    )
    assert (
        str(unknown_name("thing", "x", names)) == f"unknown thing 'x' (known: {', '.join(names[:24])}, ...)"
    )
    assert str(unknown_name("thing", "x", [])) == "unknown thing 'x' (known: none)"


@pytest.mark.parametrize(("letters", "shown"), [(100, "x" * 100), (101, "x" * 100 + "...")])
def test_a_long_name_is_cut(letters: int, shown: str) -> None:
    assert str(unknown_name("thing", "x" * letters, ["y"])) == f"unknown thing '{shown}' (known: y)"


def test_a_name_is_shown_in_one_line() -> None:
    assert str(unknown_name("thing", "a\n\udcff", ["y"])) == r"unknown thing 'a\n\udcff' (known: y)"


def test_what_was_given_is_no_guess_of_what_was_meant() -> None:
    assert nearest("robots/mine", ["robots/mine", "robots/mind"]) == "robots/mind"
    assert nearest("robots/mine", ["robots/mine"]) is None
    assert nearest("robots/mine" + 100 * "x", ["robots/mine" + 99 * "x"]) is None  # it would take its time
