"""Colours of values: from which to which value, in which colour, and the key that tells so in each format."""

import re
from dataclasses import replace

import numpy as np
import pytest

import sparsurf
from peptides import peptide
from sparsurf import Surface
from sparsurf.cli.command import main
from sparsurf.errors import InputError
from sparsurf.surfaces.formats.colours import KIND_COLOURS, VERTEX_GREY, VIRIDIS, scale_of

GREY, WHITE = VERTEX_GREY.tolist(), [255, 255, 255]
RED, BLUE = [178, 24, 43], [33, 102, 172]
ALPHAFOLD = ["#ff7d45", "#ffdb13", "#65cbf3", "#0053d6"]


def colours(name, values, *limits):
    return scale_of(name, values, *limits).colours.tolist()


def test_fields_with_a_zero_are_white_there_and_have_equal_colours_at_equal_values():
    assert colours("potential", [-9, -5, 0, 5, 9]) == [RED, RED, WHITE, BLUE, BLUE]
    assert colours("hbond", [-1, 0, 1, np.nan]) == [RED, WHITE, BLUE, GREY]
    assert colours("hydropathy", [-4.5, 0, 4.5])[1] == WHITE == colours("mean_hydropathy", [0, 1, 2])[0]
    assert colours("potential", [-2, 0, 8], (-2, 8)) == [RED, WHITE, BLUE]  # white stays at 0
    half = np.mean([WHITE, BLUE], axis=0)
    assert np.abs(colours("potential", [4.0], (-2, 8))[0] - half).max() < 2
    assert colours("potential", [0, 5], (0, 5)) == [WHITE, BLUE] and colours(
        "potential", [-5, 0], (-5, 0)
    ) == [RED, WHITE]
    low, high = VIRIDIS[[0, -1]].tolist()
    assert colours("roughness", [0.2, 0.9]) == colours("mean_roughness", [0.1, 1]) == [low, high]
    assert colours("depth", [3, 7]) == [low, high] and colours("depth", [3, 7], (0, 5))[1] == high


def test_the_confidence_of_a_prediction_has_the_bands_of_the_database():
    plddt = np.array([0, 49.9, 50, 69.9, 70.1, 89.9, 90, 100])
    for values in (plddt, plddt / 100):
        scale = scale_of("bfactor", values, is_prediction=True)
        found = [f"#{bytes(rgb).hex()}" for rgb in scale.colours.tolist()]
        assert found == [ALPHAFOLD[k] for k in (0, 0, 1, 1, 2, 2, 3, 3)]
    assert colours("bfactor", [69.9, 70.1]) == VIRIDIS[[0, -1]].tolist()  # what is no prediction has none


@pytest.fixture(scope="module")
def predicted(tmp_path_factory):
    """A peptide of four residues, 69.9 and 70.1 in turn, that says what its B factors are."""
    text = peptide(["ALA", "GLY", "ALA", "GLY"])
    lines = [
        f"{line[:60]}{69.9 if int(line[22:26]) % 2 else 70.1:6.2f}{line[66:]}"
        if line.startswith("ATOM")
        else line
        for line in text.splitlines()
    ]
    path = tmp_path_factory.mktemp("predicted") / "model.pdb"
    path.write_text("\n".join(["TITLE     ALPHAFOLD MONOMER V2.0 PREDICTION", *lines, "END\n"]))
    return path


@pytest.mark.parametrize("suffix", ["ply", "bild", "cxc", "pml", "png", "html"])
def test_each_format_has_a_key_and_the_terminal_a_line(predicted, tmp_path, capsys, suffix):
    if suffix == "png":
        pytest.importorskip("matplotlib", reason="matplotlib is installed by the extra `plot`")
    output = tmp_path / f"a.{suffix}"
    assert main(["surface", str(predicted), "--fields", "bfactor", "-o", str(output)]) == 0
    said = capsys.readouterr().err
    assert "coloured by bfactor in the bands of AlphaFold DB, with bounds at 50, 70 and 90\n" in said
    assert (
        main(["surface", str(predicted), "--fields", "potential", "--limits", "-3,3", "-o", str(output)]) == 0
    )
    assert "coloured by potential from -3 to 3\n" in capsys.readouterr().err
    if suffix in ("png", "html"):
        return
    text = output.read_text()
    wanted = {
        "ply": "comment potential: -3 #b2182b, 0 #ffffff, 3 #2166ac",
        "bild": ".comment potential: -3 #b2182b, 0 #ffffff, 3 #2166ac",
        "cxc": 'key "#b2182b:-3" "#ffffff:0" "#2166ac:3" colorTreatment blended',
        "pml": 'cmd.ramp_new("potential", "none", [-3.0, 0.0, 3.0], '
        "[[0.698, 0.094, 0.169], [1.0, 1.0, 1.0], [0.129, 0.4, 0.675]])",
    }
    assert wanted[suffix] in text.splitlines()


def test_a_key_of_bands_names_them(predicted, tmp_path):
    dots = sparsurf.surface(predicted)
    dots = replace(dots, fields={"bfactor": sparsurf.fields(dots, "bfactor")["bfactor"].to_numpy()})
    assert set(dots.fields["bfactor"]) == {69.9, 70.1}
    sparsurf.write(dots, tmp_path / "a.cxc")
    (key,) = re.findall("^key .*$", (tmp_path / "a.cxc").read_text(), re.M)
    assert re.findall("#[0-9a-f]{6}", key) == ALPHAFOLD and key.endswith("colorTreatment distinct")
    assert set(re.findall(r"^\.color (.*)$", (tmp_path / "a_dots.bild").read_text(), re.M)) == {
        "1.00 0.86 0.07", "0.40 0.80 0.95",
    }  # fmt: skip
    sparsurf.write(dots, tmp_path / "a.pml")
    assert '"none", [0, 50, 50, 70, 70, 90, 90, 100], [[1.0, 0.49,' in (tmp_path / "a.pml").read_text()


def test_two_states_compare_at_equal_limits(shared, tmp_path):
    folder = shared / "data" / "bad" / "eighth"
    lines = {}
    for name in ("scores", "scores_doubled"):
        dots = sparsurf.surface(folder / f"{name}.pdb")
        dots = replace(dots, fields={"bfactor": sparsurf.fields(dots, "bfactor")["bfactor"].to_numpy()})
        sparsurf.write(dots, tmp_path / "a.ply", limits=(0, 60))
        text = (tmp_path / "a.ply").read_text()
        body = np.array([line.split() for line in text.partition("end_header\n")[2].splitlines()], float)
        assert np.array_equal(body[:, 6:9], scale_of("", dots.fields["bfactor"], (0, 60)).colours)
        lines[name] = body[:, 6:9]
    first, doubled = lines.values()
    value = np.linspace(0, 60, 61)
    table = {tuple(rgb): v for v, rgb in zip(value, scale_of("", value).colours.tolist(), strict=True)}
    halves = np.array([table[tuple(rgb)] for rgb in first])  # B is a whole number, by its residue
    twice = np.array([table[tuple(rgb)] for rgb in doubled])
    assert np.array_equal(twice, np.minimum(2 * halves, 60)) and len(np.unique(halves)) > 50


def test_wrong_limits_are_a_sentence(blob, predicted, tmp_path, capsys):
    dots = Surface(*blob, fields={"height": blob[0][:, 2]})
    for wrong in ((5, -5), (1, 1), (0, np.nan), 3, "a,b", (1, 2, 3)):
        with pytest.raises(InputError, match=r"limits is .*two numbers, the lower one first"):
            sparsurf.write(dots, tmp_path / "a.ply", limits=wrong)
    bare = Surface(*blob)
    for result in (bare, sparsurf.mesh(bare, n_vertices=200)):
        with pytest.raises(InputError, match=r"field, and .*a\.ply"):
            sparsurf.write(result, tmp_path / "a.ply", limits=(0, 1))
    with pytest.raises(InputError, match=r".*a\.csv has none"):
        sparsurf.write(dots, tmp_path / "a.csv", limits=(0, 1))
    with pytest.raises(InputError, match="limits are those"):
        dots.plot(limits=(0, 1))
    line = [
        "surface",
        str(predicted),
        "--fields",
        "potential",
        "--limits=5,-5",
        "-o",
        str(tmp_path / "b.ply"),
    ]
    assert main(line) == 1 and "--limits is '5,-5'" in capsys.readouterr().err
    assert not (tmp_path / "b.ply").exists()


def test_one_value_and_values_of_some_dots_are_told(blob):
    assert scale_of("bfactor", np.full(3, 20.0)).words == (
        "coloured by bfactor, which is 20 at every dot, so that all have one colour"
    )
    some = scale_of("x", np.where(np.arange(10) < 5, np.nan, np.arange(10)))
    said = "coloured by x from 5 to 9, its lowest and highest value; `--limits` fixes them"
    assert some.words == f"{said}; 5 of 10 dots have no value and are grey"
    assert some.colours[:5].tolist() == [GREY] * 5


def test_a_page_opens_with_the_first_field_and_the_limits(blob, monkeypatch):
    monkeypatch.setattr("webbrowser.open", lambda link: True)
    dots = Surface(*blob, fields={"height": blob[0][:, 2]})
    pages = [sparsurf.show(dots, limits=limits, open_browser=False).html for limits in (None, (0, 1), (0, 2))]
    assert len(set(pages)) == 3  # the colours are packed in it
    assert dots.show(limits=(0, 1)).html == pages[1]
    with pytest.raises(InputError, match=r"\(1, 0\)"):
        sparsurf.show(dots, limits=(1, 0))


def test_one_value_has_no_key_where_a_key_needs_two_colours(blob, tmp_path):
    for name in ("a.cxc", "a.pml"):
        sparsurf.write(Surface(*blob, fields={"height": np.full(len(blob[0]), 20.0)}), tmp_path / name)
        assert not re.search(r"^(key|cmd\.ramp_new)", (tmp_path / name).read_text(), re.M)


def test_a_picture_has_the_first_field_with_its_bar(blob):
    pytest.importorskip("matplotlib", reason="matplotlib is installed by the extra `plot`")
    from sparsurf.views import pictures

    dots = Surface(*blob, kind=np.zeros(len(blob[0]), int))
    figure = pictures.values_picture(dots, scale_of("potential", np.full(len(dots), -5.0)), "p")
    picture, bar = figure.axes
    assert bar.get_ylim() == (-5, 5) and bar.get_ylabel() == "electrostatic potential (kT/e)"
    pixels = np.asarray(picture.images[0].get_array(), float)[..., :3].reshape(-1, 3)
    drawn = pixels[pixels.min(axis=1) < 0.6 * pixels.max()]
    hue = np.median(drawn / drawn.max(axis=1, keepdims=True), axis=0)
    assert np.abs(hue - np.array(RED) / RED[0]).max() < 0.2 and KIND_COLOURS[0, 2] > KIND_COLOURS[0, 0]


def test_limits_beyond_all_values_are_told():
    values = np.array([1.0, 2.0, np.nan])
    assert "1 to 2, lie beyond" in scale_of("q", values, (5.0, 6.0)).words
    assert "beyond" not in scale_of("q", values, (2.0, 6.0)).words
