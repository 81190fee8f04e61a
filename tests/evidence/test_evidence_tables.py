"""Every committed table and figure of the evidence is requested and written by a rule."""

from conftest import ROOT

EVIDENCE = ROOT / "evidence"
NOT_BY_RULES = {"bench.csv"}  # of evidence/bench.py
WITHOUT_APBS = {"potential_apbs.csv", "potential_apbs_means.csv"}  # requested where APBS is installed


def test_every_committed_table_is_requested_and_written_by_a_rule():
    requested = (EVIDENCE / "Snakefile").read_text(encoding="utf-8")
    rules = "".join(path.read_text(encoding="utf-8") for path in (EVIDENCE / "rules").glob("*.smk"))
    for table in {path.name for path in (EVIDENCE / "tables").glob("*.csv")} - NOT_BY_RULES:
        assert f'f"{{TABLES}}/{table}"' in rules, table
        assert f'f"{{TABLES}}/{table}"' in requested or table in WITHOUT_APBS, table


def test_every_requested_file_is_committed():
    lines = (EVIDENCE / "Snakefile").read_text(encoding="utf-8").splitlines()
    folders = {"{TABLES}": "evidence/tables", "{FIGURES}": "docs", "{LIBRARY}": "src/sparsurf"}
    requested = [line.strip().removeprefix('f"').removesuffix('",') for line in lines]
    paths = [path for path in requested if path.startswith(tuple(folders))]
    assert len(paths) > 90
    for path in paths:
        constant, _, name = path.partition("/")
        assert (ROOT / folders[constant] / name).is_file(), path
