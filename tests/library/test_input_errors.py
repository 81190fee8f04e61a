"""An error of the user, whose message each door words in its own way."""

import pickle

from sparsurf.errors import InputError, argument


def test_each_door_words_the_arguments_of_an_error():
    error = InputError(f"{argument('patches.d_link')} is 5; choose `{argument('r_patch')}` above it.")
    assert error.arguments == ("patches.d_link", "r_patch")
    assert str(error) == "d_link is 5; choose `r_patch` above it."
    assert error.worded(str.upper) == "PATCHES.D_LINK is 5; choose `R_PATCH` above it."


def test_an_error_keeps_its_arguments_on_the_way_from_another_process():
    error = pickle.loads(pickle.dumps(InputError(f"{argument('seed')} is -1.")))
    assert error.arguments == ("seed",) and str(error) == "seed is -1."


def test_control_characters_of_a_file_are_escaped():
    assert str(InputError("x.pdb holds \x1b[2J\x02.\n")) == r"x.pdb holds \x1b[2J\x02." + "\n"
