"""What the library logs, and who hears it."""

import logging

import pytest

from sparsurf.messages import kind_of_warning, listening, no_warnings


def test_what_was_said_before_is_not_said_again(caplog):
    log = logging.getLogger("sparsurf")
    with pytest.raises(KeyError), no_warnings():
        log.warning("once")
        raise KeyError
    log.warning("again")
    assert caplog.messages == ["again"]
    with no_warnings():
        with no_warnings():
            pass
        log.warning("within the outer one")
    assert caplog.messages == ["again"]


def test_warnings_of_one_template_are_of_one_kind():
    """A template that is a whole sentence is known by its plain words without numbers."""
    log, found = logging.getLogger("sparsurf"), []
    with listening(found.append):
        log.warning("%s lacks %d atoms", "a.pdb", 3)
        log.info("%s is fine", "a.pdb")
        log.warning("%s: %s", "a.pdb", "the bond CA-CB of ALA 3 is 3.1 Å long")
        log.warning("%s: %s", "b.pdb: x", "the bond N-CA of GLY 44 is 2.9 Å long")
    assert found[0].getMessage() == "a.pdb lacks 3 atoms" and len(found) == 3
    assert tuple(map(kind_of_warning, found)) == (
        "%s lacks %d atoms",
        "the bond of is long",
        "the bond of is long",
    )


@pytest.mark.parametrize("level", [logging.NOTSET, logging.ERROR, logging.DEBUG])
def test_others_hear_what_is_passed_on_to_them_and_all_of_it_afterwards(caplog, level):
    """What another listens to more closely is shown at the level that a user chose, by the handlers that were there."""
    log, heard = logging.getLogger("sparsurf"), []
    log.setLevel(level)
    before = log.handlers, log.propagate, log.level
    shown = [
        line
        for line in ("note", "warning", "error")
        if log.isEnabledFor({"note": 20, "warning": 30, "error": 40}[line])
    ]
    try:
        with pytest.raises(KeyError), listening(heard.append, logging.INFO, pass_on=True):
            log.info("note")
            log.warning("warning")
            log.error("error")
            with listening(lambda record: None):
                log.error("for nobody else")
            raise KeyError
        assert (log.handlers, log.propagate, log.level) == before
        assert [record.getMessage() for record in heard] == ["note", "warning", "error"]
        assert caplog.messages == shown
    finally:
        log.setLevel(logging.NOTSET)
