"""The same numbers with the BLAS kernels of an older processor and other threads; tests/same_numbers.py has more settings."""

import pytest

import same_numbers


@pytest.mark.release
def test_the_library_gives_the_same_numbers_on_an_older_processor(capsys):
    assert same_numbers.main(["--quick"]) == 0, capsys.readouterr().out
