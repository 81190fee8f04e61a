"""What a figure puts on the page, for the tests of the figures."""

import os
from itertools import combinations

import numpy as np
from matplotlib import __version__
from matplotlib.text import Text
from PIL import Image
from scipy.ndimage import uniform_filter

from sparsurf.views import layout

MADE_BY = "3.11"  # matplotlib that drew the stored pictures; others space letters otherwise
REDUCED = 6  # stored pixels are so many of a figure's on a side
# Of 255, over 3 by 3 stored pixels: more than another FreeType changes, less than an eye sees
TOLERANCE = 12


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


def differs(figure, stored, folder):
    """Draw a figure; say where it differs from the stored picture, and where both lie, or "" if an eye sees no difference.

    With BASELINE=new in the environment, it is stored instead.
    """
    layout.save(figure, folder / "found.png")
    found = Image.open(folder / "found.png").convert("RGB").reduce(REDUCED)
    if os.environ.get("BASELINE") == "new":
        found.save(stored)
    wanted = Image.open(stored).convert("RGB")
    if found.size != wanted.size:
        return f"{found.size} in place of {wanted.size} pixels: {folder}/found.png"
    difference = np.subtract(found, wanted, dtype=float)
    difference = abs(uniform_filter(difference, (3, 3, 0))).max(axis=2)
    if difference.max() <= TOLERANCE:
        return ""
    y, x = np.unravel_index(difference.argmax(), difference.shape)
    return f"by {difference.max():.0f} at pixel {REDUCED * x}, {REDUCED * y}: {folder}/found.png"


def of_another_matplotlib():
    """Return whether stored pictures cannot be compared."""
    return not __version__.startswith(MADE_BY + ".")
