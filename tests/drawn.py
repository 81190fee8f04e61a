"""What a figure puts on the page, for the tests of the figures."""

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
