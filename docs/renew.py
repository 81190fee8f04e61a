"""Renew what pages take from elsewhere: numbers of evidence/tables, lists of outputs and odd files, the drawing of the rules.

The captions of Snakemake's report are files, as it reads nothing else; they are renewed from the catalogue of outputs as well.
"""

import sys
from pathlib import Path

import reference
import table_numbers
from sparsurf_study import catalogue

ROOT = Path(__file__).parent.parent
PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "evidence" / "README.md",
        ROOT / "results" / "README.md",
        *ROOT.glob("docs/*.md"),
        *ROOT.glob("docs/reference/*.md"),
    ]
)
CAPTIONS = ROOT / "src" / "sparsurf_study" / "report" / "captions"


def renewed(page: Path) -> str:
    """Return a page as the tables and the code have it now."""
    text = reference.renewed(page.read_text(encoding="utf-8"))
    page_numbers = table_numbers.of_pages().get(page.relative_to(ROOT).as_posix())
    return table_numbers.renewed(text, page_numbers) if page_numbers else text


def captions() -> dict[Path, str]:
    """Return the file of each caption of Snakemake's report, as the catalogue has it now."""
    return {
        CAPTIONS / catalogue.caption_file(output): f"{output.caption}\n"
        for output in catalogue.outputs().values()
        if output.title
    }


def renew_captions() -> None:
    """Write every caption that differs, and delete those whose output has gone."""
    written = captions()
    for path in {*CAPTIONS.glob("*.rst")} - written.keys():
        path.unlink()
    for path, text in written.items():
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            print(f"renewed {path.relative_to(ROOT)}")


def main() -> None:
    """Write every page and caption that differs, and name it."""
    renew_captions()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        try:
            new = renewed(page)
        except ValueError as error:
            sys.exit(f"{page.relative_to(ROOT)}: {error}")
        if new != text:
            page.write_text(new, encoding="utf-8")
            print(f"renewed {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
