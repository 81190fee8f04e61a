"""The measured errors by the density of the kept dots: those of the evidence, interpolated, and the inverse."""

import itertools

import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.recovery.law import MEASURED


def test_the_measured_errors_are_those_of_the_evidence():
    """In three digits; a table that was measured again must be entered again."""
    table = pd.read_csv(ROOT / "evidence" / "tables" / "spheres_means.csv")
    for (sampler, model, hydrogens), measured in MEASURED.items():
        of_group = table[table["group"] == ("with hydrogens" if hydrogens else "chains")]
        rows = of_group[(of_group["sampler"] == sampler) & (of_group["model"] == model)]
        expected = rows.sort_values("density")[[*measured._fields]].map(lambda cell: float(f"{cell:.3g}"))
        assert measured == tuple(zip(*expected.to_numpy().tolist(), strict=True)), (sampler, model, hydrogens)


def test_the_law_and_its_inverse():
    for hydrogens, sampler, model in itertools.product(
        (False, True), ("farthest", "cover"), ("auto", "spheres")
    ):
        how = {"hydrogens": hydrogens, "sampler": sampler, "reconstruction": model}
        for error in (0.0075, 0.02):
            mean, high_99 = sparsurf.error_at(sparsurf.density_for(error, **how), **how)
            if sampler == "farthest":
                assert mean == pytest.approx(error) and 2 < high_99 / mean < 20
            else:  # both bounds are met, and that of 99 % decides
                assert mean < error and high_99 == pytest.approx(5 * error)
    lines = [
        sparsurf.density_for(0.02, **how) for how in ({}, {"reconstruction": "spheres"}, {"sampler": "cover"})
    ]
    assert lines == sorted(lines, reverse=True) and lines[0] > 2 * lines[1]
    assert sparsurf.density_for(0.02, hydrogens=True) > lines[0]
    for call, words in (
        (lambda: sparsurf.density_for(0), "error is 0"),
        (lambda: sparsurf.density_for(1), "errors of 0.00.* to 0.0.* Å were measured"),
        (lambda: sparsurf.error_at(-1), "density is -1"),
        (lambda: sparsurf.error_at(5), "errors were measured at 0.15 to 2.4 dots"),
        (lambda: sparsurf.error_at(0.5, sampler="cover"), "sampler='cover'"),
        (lambda: sparsurf.density_for(0.02, sampler="uniform"), "sampler is 'uniform'"),
        (
            lambda: sparsurf.density_for(0.02, sampler="cover", reconstruction="interpolant"),
            "for the reconstruction 'spheres'",
        ),
    ):
        with pytest.raises(InputError, match=words):
            call()
