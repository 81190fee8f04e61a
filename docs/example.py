"""Write docs/example.html, a page of `sparsurf show`, and a picture of it where there is Chromium.

The page has neither a date nor a path of this machine, so that it changes only with the program.
"""

import os
import shutil
import subprocess
from pathlib import Path

from sparsurf.api.page_metadata import About
from sparsurf.api.pages import page_of_surface
from sparsurf.api.show import surface_to_show
from sparsurf.molecules.source import open_source

ROOT = Path(__file__).parent.parent
STRUCTURE = "data/tdp43/topology.pdb"
PAGE, PICTURE = ROOT / "docs" / "example.html", ROOT / "docs" / "example.png"
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


def main() -> None:
    """Write the page, and its picture if it has changed."""
    os.chdir(ROOT)
    text = page()
    if PAGE.is_file() and PAGE.read_text(encoding="utf-8") == text and PICTURE.is_file():
        return
    PAGE.write_text(text, encoding="utf-8")
    print(f"renewed {PAGE.relative_to(ROOT)}")
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print(f"{PICTURE.relative_to(ROOT)} shows the former page: there is no Chromium to draw it")
        return
    options = ("--headless", "--no-sandbox", "--hide-scrollbars", "--virtual-time-budget=5000", *GRAPHICS)
    place = (f"--screenshot={PICTURE}", f"--window-size={SIZE}", PAGE.as_uri())
    subprocess.run([browser, *options, *place], check=True, capture_output=True)


if __name__ == "__main__":
    main()
