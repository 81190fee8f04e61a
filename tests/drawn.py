"""What a figure puts on the page, for the tests of the figures."""

from itertools import combinations

import numpy as np
from matplotlib.colors import to_hex, to_rgba_array
from matplotlib.text import Text


def drawn_texts(figure, monkeypatch):
    """Boxes, in pixels, of all texts that a drawing of the figure puts on the page."""
    drawn, draw = [], Text.draw

    def note(self, renderer):
        if self.get_visible() and self.get_text().strip():
            drawn.append(self)
        return draw(self, renderer)

    monkeypatch.setattr(Text, "draw", note)
    figure.canvas.draw()
    monkeypatch.undo()
    renderer = figure.canvas.get_renderer()
    return [(t.get_text(), t.get_window_extent(renderer)) for t in dict.fromkeys(drawn)]


def words_of(figure):
    """The texts that stand on the page beside the panels, in the order in which they were written."""
    return [text.get_text() for text in figure.texts]


def bars_of(container):
    """x, y and the two ends of every error bar, (n, 4)."""
    line, _, (bars,) = container
    ends = np.array([each if len(each) == 2 else np.full((2, 2), np.nan) for each in bars.get_segments()])
    middle = ends.mean(axis=1)[:, 1] if line is None else line.get_ydata()
    return np.column_stack([ends[:, 0, 0], np.asarray(middle, float), ends[:, 0, 1], ends[:, 1, 1]])


def colour_of(line):
    return to_hex(line.get_color()).upper()


def legend_of(owner):
    """Texts and colours of a legend's entries, in its order; lines and bars."""
    legend = owner.legends[0] if hasattr(owner, "legends") else owner.get_legend()
    handles = legend.legend_handles
    shown = [h.get_facecolor() if hasattr(h, "get_facecolor") else h.get_color() for h in handles]
    shown = [to_hex(next(iter(to_rgba_array(c)), "white")).upper() for c in shown]
    return list(zip([t.get_text() for t in legend.get_texts()], shown, strict=True))


def check_texts(figure, monkeypatch):
    """Every text lies inside the figure and touches no other; boxes of mathematics reach half a pixel beyond the ink."""
    texts = drawn_texts(figure, monkeypatch)
    assert texts
    width, height = figure.canvas.get_width_height()
    for words, box in texts:
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height, f"{words!r} is cut off"
    for (one, a), (other, b) in combinations(texts, 2):
        apart = min(a.x1, b.x1) - max(a.x0, b.x0) <= 0.5 or min(a.y1, b.y1) - max(a.y0, b.y0) <= 0.5
        assert apart, f"{one!r} and {other!r} overlap"
