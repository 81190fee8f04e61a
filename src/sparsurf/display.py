"""The base class of all results: it draws their picture, shows their page, writes their files and displays them in a notebook."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from sparsurf.arguments import ColourLimits


# Set by `sparsurf`, which names them, since figures and pages are made of results
_functions: list[Callable[[str], Any]] = []


def find_functions_by(find: Callable[[str], Any]) -> None:
    """Set what returns a module of the functions for users by its name."""
    _functions[:] = [find]


def functions(module: str) -> Any:
    """Return a module of the functions for users by its name."""
    return _functions[0](module)


class Shown:
    """A result that can be drawn, shown and written."""

    __slots__ = ()

    def plot(
        self,
        values: ArrayLike | None = None,
        ax: Any = None,
        *,
        name: str = "",
        limits: ColourLimits = None,
    ) -> Axes:
        """Draw the result with matplotlib as the reports do, coloured by `values`, one for each of its dots, or by kind.

        Parameters
        ----------
        values : (N,) array, optional
            Number of each dot, point or vertex.
        ax : Axes, optional
            Where it is drawn (default a new figure).
        name : str
            What the values are, such as 'roughness' or the name of a field (default "", not said), written at the scale of the
            colours, which are those that `sparsurf.write` gives this field.
        limits : pair of float, optional
            Values at the ends of the colours, as in `sparsurf.write`.
        """
        return functions("plot").plot(self, values, ax, name, limits)

    def show(
        self,
        values: ArrayLike | str | Path | None = None,
        *,
        path: str | Path | None = None,
        limits: ColourLimits = None,
    ) -> Any:
        """Show the result on an interactive page, in the browser if there is no notebook.

        Parameters
        ----------
        values : (N,) array, optional
            Number of each dot, point or vertex, as in `plot`. A path in this place is `path`.
        path : str or Path, optional
            File in .html for the page (default a temporary file).
        limits : pair of float, optional
            Values at the ends of the colours of the values, or else of the first field or of the roughness.
        """
        return functions("show").show_in_notebook(self, values, path, limits)

    def write(self, path: str | Path, **options: Any) -> None:
        """Write the result in the format that the suffix of the path names; the options are those of `sparsurf.write`."""
        functions("writing").write(self, path, **options)

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        html: str = functions("show").notebook_html(self)
        return html
