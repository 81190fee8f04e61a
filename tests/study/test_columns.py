"""Every column of every table is listed with type, unit and meaning, and the list is what readers and docs use."""

import pandas as pd
import pytest

from conftest import ROOT
from small_study import table_of
from sparsurf import registry
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.surfaces.surface import RESERVED_COLUMNS
from sparsurf_study import columns
from sparsurf_study.analysis.tables import read_table
from sparsurf_study.pairs import residue_moments

NAMES = {
    *registry.TABLE["field"],
    *residue_moments.MOMENT_FIELDS,
    *registry.TABLE["sampler"],
    "score",
}  # of fields and samplers; the small study has a field called score
PLACES = ("<field>", "<sampler>", "<floor>")


def check(table, path):
    """Check the columns of one CSV against those of its table: names, presence and types."""
    frame = pd.read_csv(path, dtype=str, keep_default_na=False)
    described = {name: table.column(name) for name in frame}
    assert None not in described.values(), f"{path.name}: {[n for n in described if described[n] is None]}"
    for name, column in described.items():
        if column.name in ("<field>", "<sampler>"):
            assert name in NAMES or name.startswith("paper"), f"{path.name}: {name}"
        values = frame[name][frame[name] != ""]
        if column.type == "bool":
            assert set(values) <= {"True", "False"}, f"{path.name}: {name}"
        elif column.type != "text":
            numbers = pd.to_numeric(values)
            assert column.type == "float" or (numbers == numbers.round()).all(), f"{path.name}: {name}"
    present = set(described.values())
    lacking = [column.name for column in table.columns if not column.optional and column not in present]
    assert not lacking, f"{path.name}: {lacking}"


def test_every_column_of_every_table_of_a_run_is_listed(study):
    run = study / "results" / "small"
    paths = [path for path in sorted(run.rglob("*.csv")) if "logs" not in path.relative_to(run).parts]
    assert len(paths) > 60
    for path in paths:
        check(table_of(path.relative_to(run).as_posix()), path)


@pytest.mark.parametrize(
    "arguments",
    [
        "surface --fields hydropathy",
        "roughness",
        "residues",
        "minimal --percent 5",
        "descriptors --every 300",
    ],
)
def test_every_column_of_the_command_line_is_listed(tmp_path, arguments):
    name, *options = arguments.split()
    file = str(ROOT / "data/tdp43/topology.pdb")
    cut = ["--selection", "residue 209 to 216"]
    assert command.main([name, file, *cut, *options, "-q", "-o", str(tmp_path / "out.csv")]) in (0, None)
    check(columns.tables()[f"sparsurf {name}"], tmp_path / "out.csv")


def test_every_column_is_explained_with_a_known_type():
    for key, table in columns.tables().items():
        assert len({column.name for column in table.columns}) == len(table.columns), key
        for column in table.columns:
            assert column.type in ("text", "int", "float", "bool", "bytes") and column.meaning, (
                f"{key}: {column.name}"
            )


def test_a_table_that_lacks_a_column_is_refused_by_name(tmp_path):
    path = tmp_path / "floors.csv"
    path.write_text("floor,Z,se,low,high,draws\nturned,1,0.1,0.8,1.2,10\n")
    with pytest.raises(InputError, match="column test_dots: delete"):
        read_table(path)
    assert columns.missing_columns("own_table.csv", ["a"]) == []
    assert columns.missing_columns("residues.csv", ["chain", "residue", "residue_name", "area"]) != []


@pytest.mark.parametrize(
    ("table", "name", "described", "unit", "words"),
    [
        ("residues", "mean_roughness", "mean_roughness", "", "R_i is 1"),  # not as any field
        ("residues", "mean_hydropathy", "mean_<field>", "unit of the field", "mean of the field"),
        ("residues", "area", "area", "Å²", "exact area"),
        ("grid", "d_low_kept", "d_low_<reading>", "", "lower end of the 95 % interval of `d_<reading>`"),
        ("grid", "d_high_full", "d_high_<reading>", "", "upper end of the 95 % interval of `d_<reading>`"),
        ("grid", "d_se_kept_scaled", "d_se_<reading>", "", "error of `d_<reading>`"),
        ("ranges", "d_cv_low", "d_cv_low", "", "lower end of the 95 % interval of `d_cv`"),
    ],
)
def test_a_column_has_its_most_specific_description(table, name, described, unit, words):
    column = columns.tables()[f"<protein>/<conformation>/{table}.csv"].column(name)
    assert (column.name, column.type, column.unit) == (described, "float", unit) and words in column.meaning


def test_columns_that_are_missing_are_those_of_the_table_that_is_meant():
    """Three tables are called residues.csv; what a file has says which one it is."""
    of_pair = ["partner", "chain", "residue", "residue_name", "dots", "propensity_smoothed", "interface"]
    lacking = columns.missing_columns("residues.csv", of_pair)
    assert lacking == ["propensity_k_smoothed", "similarity_smoothed"]
    frames = ["chain", "residue", "residue_name", "mean_roughness", "sd_roughness", "most_rough", "frames"]
    assert columns.missing_columns("residues.csv", frames) == ["largest_roughness"]
    assert columns.tables()["<protein>/<conformation>/grid.csv"].column("nothing") is None


def test_a_column_of_a_file_of_dots_is_read_as_no_field():
    for table in ("<protein>/<conformation>/minimal.csv", "sparsurf minimal", "sparsurf recover"):
        names = {column.name for column in columns.tables()[table].columns}
        assert names <= RESERVED_COLUMNS | {"<field>"}, table
