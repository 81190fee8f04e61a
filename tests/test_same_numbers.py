"""The same numbers with the BLAS kernels of an older processor and other threads; tests/same_numbers.py has more settings."""

import pytest

import same_numbers


def test_the_library_gives_the_same_numbers_on_an_older_processor(capsys):
    assert same_numbers.main(["--quick"]) == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    ("first", "second", "same"),
    [
        ([1.0, 2], [1.0 + 1e-10, 2], True),
        ([1.0], [1.0 + 1e-8], False),
        ([1e6], [1e6 + 1e-4], True),
        ([2], [3], False),
        (["A"], ["B"], False),
        ([float("nan")], [float("nan")], True),
        ([1.0], [1.0, 2.0], False),
    ],
)
def test_choices_are_equal_and_numbers_agree(first, second, same):
    assert (same_numbers.differences({"what": first}, {"what": second}) == []) == same
