"""Settings of the book, for Sphinx: `make docs`."""

import os
import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from pygments.lexers.special import TextLexer
from sphinx.util.logging import getLogger
from sphinx_gallery.sorting import ExplicitOrder

sys.path.insert(0, str(Path(__file__).parent))

import reference
import sparsurf
from sparsurf import compile_kernels

project, author, release = "sparsurf", "the sparsurf authors", sparsurf.__version__
copyright = author
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["_build", "gallery"]
nitpick_ignore_regex = [("py:.*", ".*")]
suppress_warnings = ["config.cache"]  # the order of the gallery is no plain value

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
smartquotes = False  # --mesh keeps its two dashes
numpydoc_show_class_members = False

LONGEST = 20  # s, of an example


def _mind_the_time(gallery, script, when):
    """Refuse a script of more than LONGEST s; time of the processor, so that a busy machine refuses none."""
    used = sum(os.times()[:4])
    if when == "before":
        _mind_the_time.start = used
    elif (took := used - _mind_the_time.start) > LONGEST:
        getLogger(__name__).warning("%s takes %.0f s, at most are %d; shorten it.", script, took, LONGEST)


GALLERY = [
    "roughness",
    "patch_and_descriptor",
    "law_of_the_sampling",
    "recover_a_mesh",
    "minimal_into_pymol",
    "trajectory",
]
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "_gallery",
    "filename_pattern": r"/\w+\.py",
    "within_subsection_order": ExplicitOrder([*(f"{name}.py" for name in GALLERY), "*"]),
    "abort_on_example_error": False,
    "download_all_examples": False,
    "show_signature": False,
    "capture_repr": (),
    "notebook_extensions": set(),
    "reset_modules": ("matplotlib", _mind_the_time),
    "reset_modules_order": "both",
    "min_reported_time": 1e6,
    "write_computation_times": False,
}

html_theme = "furo"
html_static_path, html_css_files = ["style"], ["gallery.css"]
html_title = f"sparsurf {release}"
html_show_sphinx = html_copy_source = html_show_copyright = False
html_math_renderer = "mathml"


def _formula(block):
    def visit(translator, node):
        formula = tex2mathml(node.astext(), as_block=block)
        room = 'display="block" style="padding-block: 0.6em"'  # without it, the theme shows a bar to scroll
        translator.body.append(formula.replace('display="block"', room))
        raise nodes.SkipNode

    return visit, None


# The order of the pages, by parts
PARTS = {
    "Start": ["start", "tutorial", "trajectory", "partners", "python", "_gallery/index"],
    "Tasks": ["study", "cluster", "learning", "msms"],
    "Method and findings": ["few_dots", "paper_spheres", "why", "paper", "proteins", "method"],
    "Reference": [
        "reference/functions",
        "_outside/commands",
        "reference/config",
        "_outside/outputs",
        "reference/odd_files",
        "reference/statements",
        "reference/tables",
    ],
    "Work on it": ["_outside/contributing", "_outside/evidence"],
}


def _complete(app, name, source):
    """Add the order of the pages to the first one, where GitHub would show it as text, and link the copies in OUTSIDE."""
    if name == "index":
        for part, pages in PARTS.items():
            source[0] += "\n```{toctree}\n:hidden:\n:caption: " + "\n".join([part, "", *pages, "```", ""])
    depth = name.count("/")
    for path, copy in OUTSIDE.items():
        source[0] = source[0].replace(f"]({'../' * (depth + 1)}{path}", f"]({'../' * depth}{copy}")


# Pages of the repository that the book shows as well; Sphinx reads only what lies in docs/
OUTSIDE = {
    "CONTRIBUTING.md": "_outside/contributing.md",
    "evidence/README.md": "_outside/evidence.md",
    "results/README.md": "_outside/outputs.md",
}


def _write_pages(app):
    """Write the pages that are not stored in docs/ into a folder that git ignores."""
    docs = Path(app.srcdir)
    pages = {copy: (docs.parent / path).read_text(encoding="utf-8") for path, copy in OUTSIDE.items()}
    pages["_outside/outputs.md"] += f"\n## Columns of every table\n\n{''.join(reference.columns())}"
    pages["_outside/commands.md"] = reference.commands_and_formats()
    (docs / "_outside").mkdir(exist_ok=True)
    for path, text in pages.items():
        (docs / path).write_text(text.replace("](docs/", "](../"), encoding="utf-8")


def setup(app):
    """Formulas as MathML, which browsers draw without a script; what pages hold for the book alone.

    Drawings in Mermaid, which GitHub shows, are text in the book.
    """
    app.add_lexer("mermaid", TextLexer)
    app.add_html_math_renderer("mathml", inline_renderers=_formula(False), block_renderers=_formula(True))
    app.connect("builder-inited", _write_pages)
    app.connect("source-read", _complete)
    for compile_part in compile_kernels.PARTS.values():  # once, so that no script of the gallery pays for it
        compile_part()
