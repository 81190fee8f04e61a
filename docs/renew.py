"""Renew what the pages take from elsewhere: numbers of evidence/tables, and lists of functions, commands, files and columns."""

import sys
from pathlib import Path

import reference
import table_numbers

ROOT = Path(__file__).parent.parent
PAGES = sorted([ROOT / "README.md", ROOT / "evidence" / "README.md", *ROOT.glob("docs/*.md")])


def renewed(text: str) -> str:
    """Return a page as the tables and the code have it now."""
    return table_numbers.renewed(reference.renewed(text))


def main() -> None:
    """Write every page that differs, and name it."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        try:
            new = renewed(text)
        except ValueError as error:
            sys.exit(f"{page.relative_to(ROOT)}: {error}")
        if new != text:
            page.write_text(new, encoding="utf-8")
            print(f"renewed {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
