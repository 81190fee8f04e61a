"""Name the phrases of pages, messages and docstrings over which readers have stumbled; `make test` runs it."""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
# A pattern, a phrase that it rejects, and how to say the same
BANNED = (
    (r"\b(give|gave|giving)s? ((it|them|the \w+) )?back\b", "dots that give the surface back", "reconstruct"),
    (r"\b(come|came)s? back\b", "pieces of the surface come back", "is reconstructed"),
    (r"\b(come|came)s? out\b", "flat patches come out equal", "is, results"),
    (r"\bÅ off\b|\bhow far off\b|\b(lie|lay)s? off\b", "the surface is 0.02 Å off", "deviates by"),
    (r"\bas (many|much) (as|uniform|random)\b", "as many uniform dots", "the same number of, of the same size"),
    (r", too(?=[.,;:)]|$)", "it loses, too.", "also, as well"),
    (r"\bknows? (no|its?|nothing)\b", "these dots know no molecule", "has, keeps"),
    (r"\bmay be the best\b|\b(of \S+|those) that may be\b", "one of 16 that may be", "is statistically indistinguishable"),
    (r"\bas (\S+ ){1,3}(do|does) it\b", "as the authors' code does it", "as in"),
    (r"\bmade for the\b", "a link made for the full surface", "chosen for"),
    (r"\bholds? the true\b|\b(hold|contain)s? the truth\b", "intervals hold the truth", "contain the true value"),
    (r"\bone average patch\b", "but one average patch would be closer", "the mean patch"),
    (r"\bhardly\b", "the sign hardly depends on it", "little, rarely, almost not"),
    (r"\bwhat (it|they) (keep|take|give|hold)s?\b", "closer to what they keep", "a noun"),
    (r"\btak(e|es|ing) (\S+ ){1,2}along\b", "`--ligands HEM` takes a heme along", "include"),
    (r"\bno need of\b", "no need of the scan", "without"),
    (r"\bgo by the\b", "go by the order", "use the ranking"),
    (r"\bdiffers? all over\b", "the forms differ all over", "differ almost everywhere"),
    (r"\b(cut|fall|break)s? (\S+ ){0,3}(in)?to (pieces|islands)\b", "patches fall to pieces", "is fragmented"),
    (r"\bis about (placing|dots)\b", "the key is about placing dots", "applies when dots are placed"),
    (r"\bof one's own\b", "a config of one's own", "of your own"),
    (r"\b(surface|page|form),? to (turn|rotate)\b(?! it)", "the surface to rotate", "interactive, can be rotated"),
    (r"\b(made|the surface) again\b", "Table I is made again", "reproduced, reconstructed"),
    (r"\blooks? (whole|alike)\b", "such a file looks whole", "looks complete, is similar"),
    (r"\b(has|have|takes?) no part in\b", "stride has no part in it", "does not affect"),
    (r"\bit (wins|loses)\b", "on the full surface it loses", "is better, is worse"),
    (r"\b(that|which) (is|are) no (?!\w+er\b|more\b|less\b)(?=\w)", "properties that are no lists", "are not, must be"),
    (r"\b(has|is) no room for (?!nodes)", "a CSV has no room for triangles", "cannot store"),
    (r"\bnames none\b(?! of)", "--fields names none", "contains no name"),
    (r"\b0 would be the same\b", "0 would be the same surface", "an identical surface has a Z of 0"),
    (r"\brecovered (surface|field)s?\b|\b(surface|field)s? (\w+ )?recovered\b", "the recovered surface", "is reconstructed"),
    (r"\bcorners on the surface\b", "its corners on the surface", "vertices projected onto the surface"),
    (r"\bas \w+ as the dots allow\b", "as high as the dots allow", "the highest point at which the cone contains all dots"),
    (r"\bnot all dots of\b", "these are not all dots of their surface", "this Surface is a subset"),
    (r", as (?=[\[\d])", "a list in brackets, as [1, 2]", "such as"),
)  # fmt: skip
PATTERNS = {re.compile(pattern, re.I): plain for pattern, _, plain in BANNED}
PAGES = (
    "README.md", "CHANGELOG.md", "docs/*.md", "docs/reference/*.md", "CONTRIBUTING.md", "config/README.md", "data/*/README.md",
    "evidence/README.md", "results/README.md",
)  # fmt: skip
CONFIGS = ("config.yaml", "studies/*.yaml", "evidence/*.yaml", "config/schema.json")
CODE = ("docs/gallery/*.py", "scripts/*.py", "src/**/*.py", "src/**/*.js", "src/**/*.yaml")
TEMPLATES = ("src/**/*.html", "src/**/*.j2", "src/**/*.rst")


def files(*globs: str) -> list[Path]:
    return sorted({path for pattern in globs for path in ROOT.glob(pattern)})


def prose(path: Path) -> Iterator[tuple[int, str]]:
    """The parts of a file that people read, each with the number of its first line."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        yield from strings(ast.parse(text))
    elif path.suffix == ".md":
        hidden = r"(?ms)^```.*?^```|<!--.*?-->|`[^`\n]*`"
        yield 1, re.sub(hidden, lambda part: "`" + "\n" * part[0].count("\n"), text)
    else:
        yield 1, text


def strings(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Docstrings, and strings and f-strings with the places of their values left as they are."""
    parts = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            parts |= {id(value) for value in node.values}
            yield (
                node.lineno,
                "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values),
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in parts:
            yield node.lineno, node.value


def faults(text: str) -> Iterator[tuple[int, str]]:
    """Each banned phrase of a text with the line on which it begins."""
    flat = re.sub(r"\s", " ", text)  # of the same length: a phrase may go on in the next line
    for pattern, plain in PATTERNS.items():
        loose = re.compile(pattern.pattern.replace(" ", " +"), re.I)
        for found in loose.finditer(flat):
            around = " ".join(flat[max(0, found.start() - 40) : found.end() + 20].split())
            yield text.count("\n", 0, found.start()), f"...{around}...: {plain}"


def main() -> int:
    """Print each banned phrase with its file and line; return 1 if there is one."""
    blind = [
        f"{pattern} does not find {phrase}"
        for pattern, phrase, _ in BANNED
        if not re.search(pattern, phrase, re.I)
    ]
    wrong = [
        f"{path.relative_to(ROOT)}:{line + at}: {said}"
        for path in files(*PAGES, *CONFIGS, *CODE, *TEMPLATES)
        for line, text in prose(path)
        for at, said in faults(text)
    ]
    print(*blind, *wrong, sep="\n", end="\n" * bool(blind or wrong))
    return int(bool(blind or wrong))


if __name__ == "__main__":
    sys.exit(main())
