"""The picture of the rules tells all of them, and docs/rules.svg is what the code draws."""

import re
import runpy

from conftest import ROOT, WORKFLOW
from drawn import drawn_texts
from sparsurf.report.figures import rules

NO_WORK = {"all", "compare", "complete_protein", "complete_pair"}  # they only ask for what others make


def test_every_rule_has_its_place():
    named = re.findall(r"^ *(?:rule|checkpoint) (\w+):", WORKFLOW, re.M)
    drawn = [name for *_, names in rules.STAGES.values() for name in names]
    strange = set(drawn) ^ (set(named) - NO_WORK)
    assert not strange, (
        f"place them in STAGES of report/figures/rules.py, then run scripts/draw_rules.py: {strange}"
    )
    assert len(drawn) == len(set(drawn))
    assert {title for arrow in rules.ARROWS for title in arrow} == set(rules.STAGES)


def test_texts_stay_in_their_boxes(monkeypatch):
    figure = rules.draw()
    texts = drawn_texts(figure, monkeypatch)
    boxes = [patch.get_window_extent() for patch in figure.axes[0].patches][: len(rules.STAGES)]
    assert len(texts) == 2 * len(boxes)
    for k, (words, box) in enumerate(texts):
        outer = boxes[k // 2]
        assert outer.x0 <= box.x0 and box.x1 <= outer.x1 and outer.y0 <= box.y0 and box.y1 <= outer.y1, words


def test_the_stored_picture_is_what_the_command_draws(tmp_path):
    main = runpy.run_path(str(ROOT / "scripts" / "draw_rules.py"))["main"]
    main(tmp_path / "rules.svg")
    assert (tmp_path / "rules.svg").read_bytes() == (ROOT / "docs" / "rules.svg").read_bytes()
