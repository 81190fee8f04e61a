"""Write docs/example.html, a page of `sparsurf show`, and a picture of it where there is Chromium.

The page has neither a date nor a path of this machine, so that it changes only with the program. With the path of the structure
1hvr of evidence/structures.csv, docs/ligand.png is drawn in its place: the page of its ligand.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import sparsurf
from sparsurf.api.page_metadata import About
from sparsurf.api.pages import page_of_surface
from sparsurf.api.show import surface_to_show
from sparsurf.molecules.source import open_source

ROOT = Path(__file__).parent.parent
STRUCTURE = "data/tdp43/topology.pdb"
PAGE, PICTURE = ROOT / "docs" / "example.html", ROOT / "docs" / "example.png"
LIGAND, PICTURE_OF_LIGAND = "XK2", ROOT / "docs" / "ligand.png"
BROWSERS = "chromium", "chromium-browser", "google-chrome"
SIZE = "1400,900"  # pixels
GRAPHICS = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)  # WebGL without a graphics card


def page() -> str:
    """Return the page, as the command writes it."""
    dots, about = surface_to_show(open_source(STRUCTURE), None, 0)
    undated = About(
        about.name, about.heard, files=about.files, command=f"sparsurf show {STRUCTURE}", is_dated=False
    )
    return page_of_surface(dots, undated)


def draw(page_path: Path, picture: Path) -> None:
    """Draw the first view of a page, if there is Chromium."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print(f"{picture.relative_to(ROOT)} shows the former page: there is no Chromium to draw it")
        return
    options = ("--headless", "--no-sandbox", "--hide-scrollbars", "--virtual-time-budget=5000", *GRAPHICS)
    place = (f"--screenshot={picture}", f"--window-size={SIZE}", page_path.as_uri())
    subprocess.run([browser, *options, *place], check=True, capture_output=True)


def draw_ligand(structure: str) -> None:
    """Draw the page of a structure with a ligand."""
    with tempfile.TemporaryDirectory() as folder:
        page_path = Path(folder, "page.html")
        sparsurf.show(sparsurf.read_molecule(structure, ligands=[LIGAND]), page_path, open_browser=False)
        draw(page_path, PICTURE_OF_LIGAND)


def main() -> None:
    """Write the page, and its picture if it has changed; with an argument, draw the page of a ligand."""
    if sys.argv[1:]:
        draw_ligand(sys.argv[1])
        return
    os.chdir(ROOT)
    text = page()
    if PAGE.is_file() and PAGE.read_text(encoding="utf-8") == text and PICTURE.is_file():
        return
    PAGE.write_text(text, encoding="utf-8")
    print(f"renewed {PAGE.relative_to(ROOT)}")
    draw(PAGE, PICTURE)


if __name__ == "__main__":
    main()
