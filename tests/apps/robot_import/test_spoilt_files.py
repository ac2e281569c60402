"""Truncated and mutated descriptions: each loads or is refused in a line, in time, and nothing is written."""

import re
import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lab_style import lab_urdf
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.base.errors import SkylimbError
from skylimb.robots import SHIPPED

TEXT = lab_urdf(gimbal="fixed")
NUMBER = re.compile(r'(?<=")-?\d+\.?\d*(e-?\d+)?(?=")')
NUMBERS = [match.span() for match in NUMBER.finditer(TEXT)]
TAGS = [match.span() for match in re.finditer(r"<[^>]+>", TEXT)]
ODD = ["nan", "inf", "-1", "0", "1e300", "-1e-300", "", "x", "1 2", "\N{DEGREE SIGN}", "0x10", "9" * 400]
SLOWEST = 2.0


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder that stays as it is but for the one file; the readers of files are imported by then."""
    folder = tmp_path_factory.mktemp("spoilt")
    whole = folder.parent / "whole.urdf"
    whole.write_text(TEXT, encoding="utf-8")
    check_robot_file(whole)
    return folder


def loads_or_is_refused(place, content):
    path = place / "spoilt.urdf"
    path.write_bytes(content)
    begin, said = time.process_time(), "it loads"
    try:
        check_robot_file(path)
    except SkylimbError as error:
        said = str(error)
    assert "\n" not in said
    assert 0 < len(said) < 1500
    assert time.process_time() - begin < SLOWEST
    assert [file.name for file in place.iterdir()] == ["spoilt.urdf"]


QUIET = settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


@QUIET
@given(st.integers(0, len(TEXT)))
def test_a_file_that_ends_early(place, end):
    loads_or_is_refused(place, TEXT[:end].encode())


@QUIET
@given(st.sampled_from(NUMBERS), st.sampled_from(ODD))
def test_a_number_that_is_none(place, span, word):
    loads_or_is_refused(place, (TEXT[: span[0]] + word + TEXT[span[1] :]).encode())


@QUIET
@given(st.sampled_from(TAGS), st.sampled_from(TAGS))
def test_a_tag_twice_or_missing(place, one, other):
    tag = TEXT[other[0] : other[1]]
    loads_or_is_refused(place, (TEXT[: one[0]] + TEXT[one[1] :]).encode())
    loads_or_is_refused(place, (TEXT[: one[1]] + tag + TEXT[one[1] :]).encode())


@QUIET
@given(st.binary(max_size=400))
def test_any_bytes(place, content):
    loads_or_is_refused(place, content)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('friction="0.05"', 'friction="0x10"'),
        ('<link name="link2">', '<link name="link2"><visual><geometry><box size=""/></geometry></visual>'),
    ],
)
def test_what_a_search_of_thousands_found(place, old, new):
    """Found by `benchmarks/spoilt_files.py`: these ended in raw errors."""
    text = (SHIPPED / "hydrus_xi_quad" / "hydrus_xi_quad.urdf").read_text(encoding="utf-8")
    assert old in text
    loads_or_is_refused(place, text.replace(old, new).encode())
