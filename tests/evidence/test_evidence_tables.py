"""Every committed table and figure of the evidence is requested and written by a rule."""

import re

from conftest import ROOT

EVIDENCE = ROOT / "evidence"
NOT_BY_RULES = {"bench.csv"}  # of evidence/bench.py
OPTIONAL_TABLES = {  # requested where their program and structures are there
    "potential_apbs.csv": "POTENTIAL_TABLES",
    "potential_apbs_means.csv": "POTENTIAL_TABLES",
    "sites_searches.csv": "CHANCE_TABLES",
    "sites_chance.csv": "CHANCE_TABLES",
    "cofactors.csv": "COFACTOR_TABLES",
    "cofactors_means.csv": "COFACTOR_TABLES",
    "cofactors_learned.csv": "COFACTOR_TABLES",
    "cofactors_learned_means.csv": "COFACTOR_TABLES",
}


def test_every_committed_table_is_requested_and_written_by_a_rule():
    requested = (EVIDENCE / "Snakefile").read_text(encoding="utf-8")
    rules = "".join(path.read_text(encoding="utf-8") for path in (EVIDENCE / "rules").glob("*.smk"))
    for table in {path.name for path in (EVIDENCE / "tables").glob("*.csv")} - NOT_BY_RULES:
        assert f'f"{{TABLES}}/{table}"' in rules, table
        if names := OPTIONAL_TABLES.get(table):
            assert f"lambda wildcards: {names}," in requested, table
            listed = " ".join(re.findall(rf"^    {names} = \[(.*?)\]$", rules, re.MULTILINE | re.DOTALL))
            assert f'f"{{TABLES}}/{table}"' in listed, table
        else:
            assert f'f"{{TABLES}}/{table}"' in requested, table


def test_every_requested_file_is_committed():
    lines = (EVIDENCE / "Snakefile").read_text(encoding="utf-8").splitlines()
    folders = {"{TABLES}": "evidence/tables", "{FIGURES}": "docs", "{LIBRARY}": "src/sparsurf"}
    requested = [line.strip().removeprefix('f"').removesuffix('",') for line in lines]
    paths = [path for path in requested if path.startswith(tuple(folders))]
    assert len(paths) > 90
    for path in paths:
        constant, _, name = path.partition("/")
        assert (ROOT / folders[constant] / name).is_file(), path
