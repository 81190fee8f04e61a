"""Outputs of rules: several of one folder, files that Snakemake's report shows, figures as PNG and SVG."""

from pathlib import Path

from snakemake.io import report

CAPTIONS = Path(__file__).parents[2] / "report"


def inside(folder, **files):
    """Paths of files of one folder, by their names in a rule."""
    return {name: f"{folder}/{file}" for name, file in files.items()}


def shown(path, label, caption, category=None):
    """`path`, shown in the report under `label` among the results of its protein, with scripts/report/<caption>.rst."""
    category = category or ("{protein}" if "{protein}" in path else "All surfaces")
    within = {"subcategory": "{conformation}"} if "{conformation}" in path else {}
    text = f"scripts/report/{caption}.rst" if (CAPTIONS / f"{caption}.rst").is_file() else None
    return report(path, caption=text, category=category, labels={"result": label}, **within)


def figure(path, label, caption, category=None):
    """Outputs `png`, shown in the report, and `svg` of a figure; `path` comes without its ending."""
    return {"png": shown(f"{path}.png", label, caption, category), "svg": f"{path}.svg"}
