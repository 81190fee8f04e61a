"""An error of the user, whose message each door words in its own way."""

import logging
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from sparsurf.errors import FILE, InputError, argument, naming_file


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


def test_messages_call_the_file_that_is_read_by_its_name(caplog):
    """The innermost file is named, also after an error, and each thread reads its own."""

    def refuse(name, both=None):
        with naming_file(name):
            if both:
                both.wait()  # until the other thread reads its file, too
            raise InputError(f"{FILE}: line 3 is wrong.")

    with naming_file("top.pdb"), caplog.at_level(logging.WARNING, "sparsurf"):
        with pytest.raises(InputError, match=r"^run\.xtc: line 3"):
            refuse("run.xtc")
        logging.getLogger("sparsurf").warning("%s has %d atoms", FILE, 5)
        both = threading.Barrier(2)
        with ThreadPoolExecutor(2) as pool:
            answers = [pool.submit(refuse, name, both) for name in ("a.gro", "b.gro")]
            errors = [answer.exception() for answer in answers]
    assert caplog.messages == ["top.pdb has 5 atoms"]
    assert [str(error) for error in errors] == ["a.gro: line 3 is wrong.", "b.gro: line 3 is wrong."]
    assert str(InputError(f"{FILE} holds no atoms.")) == "the file holds no atoms."
