"""The list of planted mistakes follows the code: `python tests/mutation/run.py` plants them."""

from mutation.mistakes import mistakes, without_place


def test_every_mistake_has_its_one_place():
    """Where this fails, the code has moved on: give the mistake its new text in mistakes.toml."""
    assert not list(without_place())


def test_there_are_hundreds_of_mistakes_in_all_rooms():
    rooms = {file.split("/")[1] for file, *_ in mistakes() if file.startswith("sparsurf/")}
    assert {
        "complementarity",
        "molecules",
        "patches",
        "recovery",
        "report",
        "sampling",
        "study",
        "surfaces",
        "workflow",
    } <= rooms
    assert len(mistakes()) >= 500
