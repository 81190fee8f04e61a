"""Tables of single structures, read as one."""

from measures.tables import read_tables


def test_a_complex_that_looks_like_a_number_keeps_its_name(tmp_path):
    for name in ("1E96", "1CGI"):
        (tmp_path / f"{name}.csv").write_text(f"complex,auc\n{name},0.5\n")
    table = read_tables([tmp_path / "1E96.csv", tmp_path / "1CGI.csv"])
    assert table["complex"].tolist() == ["1E96", "1CGI"] and table["auc"].sum() == 1
