"""Figures of the evidence in the form of the book."""

from PIL import Image

WIDTH = 1400  # pixels of a figure in the book


def reduce_figure(path: str, copy: str, colours: int = 0) -> None:
    """Copy a PNG for the book, at most `WIDTH` pixels wide, in a number of colours unless 0."""
    image = Image.open(path).convert("RGB")
    if image.width > WIDTH:
        image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    (image.quantize(colours) if colours else image).save(copy, optimize=True)
