"""The figures of a run, of a trajectory and of a simulation show the numbers of their tables."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from drawn import bars_of, colour_of, legend_of, words_of
from sparsurf.recovery.readings import READINGS
from sparsurf.report.figures import distributions, over_time, summary_figures
from sparsurf.report.figures.simulation import simulation_figure
from sparsurf.sampling.combination import PARAMETERS

BLUE, ORANGE, GREEN, BLACK, WHITE = "#0072B2", "#E69F00", "#009E73", "#000000", "#FFFFFF"
LIMITS = [0.0, 20.0, 60.0, 100.0]  # % of the dots
WORDS = [READINGS[reading].words for reading in ("kept", "full")]


def winners(proteins, ranges=3):
    """summary.csv of invented winners: everything differs by protein, range and reading."""
    rows = []
    for j, reading in enumerate(("kept", "full")):
        for s, (name, rough) in enumerate(proteins.items()):
            for k in range(ranges):
                d = 2 - j + 0.1 * s + 0.3 * k
                rows.append(
                    {"protein": name, "conformation": "c1", "mean_roughness": rough, "reading": reading}
                    | {"range": k + 1, "alpha": 0.2 * (1 + s), "beta": 0.4 * k, "gamma": 2.0 * (s + k + j)}
                    | {"delta": 10 - s, "n_S_percent": LIMITS[k] + 5 + s, "d": d + 5}
                    | {"d_cv": d, "d_cv_low": d - 0.2, "d_cv_high": d + 0.2}
                )
    return pd.DataFrame(rows)


def relations(gains=(0.1, -0.2, 0.3), p=(0.01, 0.2, 0.04)):
    rows = [
        {"reading": reading, "range": k + 1, "n_S_low_percent": LIMITS[k], "n_S_high_percent": LIMITS[k + 1]}
        | {"gain": (1 + j) * gains[k], "gain_low": (1 + j) * gains[k] - 0.05, "p": p[k]}
        | {"gain_high": (1 + j) * gains[k] + 0.05}
        for j, reading in enumerate(("kept", "full"))
        for k in range(3)
    ]
    return pd.DataFrame(rows)


def test_winners_are_drawn_against_mean_roughness_in_the_colour_of_their_range():
    table = winners({"a": 0.5, "b": 0.62, "c": 0.7, "d": 0.55})
    figure = summary_figures.summary_figure(table, relations())
    of_one = len(PARAMETERS) + 2  # d and the gain
    assert [w for w in words_of(figure) if w in WORDS] == WORDS
    for j, reading in enumerate(("kept", "full")):
        panels = figure.axes[of_one * j : of_one * (j + 1)]
        rows = table[table["reading"] == reading]
        for ax, name, greek in zip(panels, PARAMETERS, "αβγδ", strict=False):
            dots = ax.collections[0]
            x, y = dots.get_offsets().T
            np.testing.assert_array_equal(x, rows["mean_roughness"])
            known = np.unique(rows[name])
            step = np.diff(known).min() if len(known) > 1 else 1.0
            aside = np.asarray(y) - rows[name].to_numpy()
            np.testing.assert_allclose(
                aside, (rows["range"] - 2) * step / 6, atol=1e-12
            )  # ranges side by side
            assert ax.get_ylabel() == (greek if j == 0 else "")
        bars = np.vstack([bars_of(each) for each in panels[4].containers])
        wanted = rows[["mean_roughness", "d_cv", "d_cv_low", "d_cv_high"]]
        np.testing.assert_allclose(bars, wanted)
        shown = [colour_of(each[0]) for each in panels[4].containers]
        assert shown == [to_hex(c).upper() for c in panels[0].collections[0].get_facecolors()]
        assert len(set(shown[:3])) == 3 and shown[:3] == shown[3:6]
        own = relations()[relations()["reading"] == reading]
        middle = [10.0, 40.0, 80.0]
        gains = bars_of(panels[5].containers[0])
        np.testing.assert_allclose(gains[:, 0], middle)
        np.testing.assert_allclose(gains[:, 2:], own[["gain_low", "gain_high"]])
        related, other = panels[5].lines[-2:]
        assert related.get_markerfacecolor() == "black" and other.get_markerfacecolor() == "white"
        np.testing.assert_allclose(
            related.get_xydata(), own[own["p"] < 0.05].assign(x=[10, 80])[["x", "gain"]]
        )
        np.testing.assert_allclose(other.get_xydata(), own[own["p"] > 0.05].assign(x=[40])[["x", "gain"]])
        assert panels[5].get_ylim() == pytest.approx((-1.1 * 0.65, 1.1 * 0.65))
    bar = figure.axes[-1]
    assert [t.get_text() for t in bar.get_yticklabels()] == ["0", "20", "60", "100"]


def test_the_end_of_every_range_has_its_colour():
    table = winners({"a": 0.5, "b": 0.62, "c": 0.7})
    figure = summary_figures.summary_figure(table, relations())
    viridis = summary_figures.colormaps["viridis"]
    shown = [to_hex(c) for c in figure.axes[0].collections[0].get_facecolors()[:3]]
    assert shown[0] == to_hex(viridis(0)) and shown[-1] == to_hex(viridis(255))


def trajectory(n=100, step=200.0):
    k = np.arange(n)
    table = pd.DataFrame({"frame": 3 * k, "time_ps": step * k, "n_S_percent": 40 + np.sin(k)})
    table["mean_roughness"] = 0.6 + 0.01 * np.cos(k)
    for j, reading in enumerate(("kept", "full")):
        table[f"d_{reading}"], table[f"d_se_{reading}"] = (
            1 - 2 * j + 0.2 * np.sin(k / (9 + j)),
            0.1 + k % 3 / 50,
        )
    return table


def test_the_spread_over_frames_is_that_of_all_frames():
    table = trajectory().iloc[:4].assign(n_S_percent=[40.0, 42, 44, 46])
    beside = over_time.ensemble_figure(table, (1, 0, 6, 4)).axes[1]
    assert beside.get_title() == "mean 43.0, sd 2.6"  # sqrt(20 / 3), as on the page


def test_one_combination_is_followed_over_time():
    table = trajectory().assign(d_recovered=lambda t: 0.1 * t["d_kept"], d_se_recovered=0.02)
    figure = over_time.ensemble_figure(table, (1, 0, 6, 4))
    columns = ["n_S_percent", "mean_roughness", "d_kept", "d_full", "d_recovered"]
    titles = [ax.get_title(loc="left") for ax in figure.axes[::2]]
    assert READINGS["recovered"].words in titles[-1]
    for k, column in enumerate(columns):
        ax, beside = figure.axes[2 * k : 2 * k + 2]
        np.testing.assert_allclose(
            ax.lines[0].get_xydata(), np.column_stack([table["time_ps"] / 1000, table[column]])
        )
        mean = [
            table[column][max(0, i - 2) : i + 3].mean() for i in range(100)
        ]  # windows of five, shorter at the ends
        np.testing.assert_allclose(ax.lines[1].get_ydata(), mean)
        counts = [patch.get_width() for patch in beside.patches]
        assert sum(counts) == 100
        values = table[column]
        said = beside.get_title().replace("−", "-")
        wanted = float(said.split()[1].rstrip(",")), float(said.split()[3])
        assert wanted == pytest.approx((values.mean(), values.std(ddof=0)), abs=0.06 * values.std(ddof=0))
        if column.startswith("d_"):
            _, middle, low, high = bars_of(beside.containers[-1])[0]
            error = table[column.replace("d_", "d_se_")].mean()
            assert (low, middle, high) == pytest.approx(
                (values.mean() - error, values.mean(), values.mean() + error)
            )
        else:
            assert len(beside.containers) == 1
    assert [ax.get_ylabel() for ax in figure.axes[::2]] == [
        "$n_S$ (% of the dots)", "mean roughness", *["$d = Z_{tR} - Z_{tS}$"] * 3,
    ]  # fmt: skip
    assert all(title.endswith(words) for title, words in zip(titles[2:], WORDS, strict=False))
    assert figure.legends[0].get_title().get_text() == "α = 1, β = 0, γ = 6, δ = 4"
    assert figure.axes[-2].get_xlabel() == "time (ns)"
    assert "moving mean, 5 frames" in [text for text, _ in legend_of(figure)]


def test_one_frame_has_a_mean_and_no_spread():
    figure = over_time.ensemble_figure(trajectory(1), (1, 0, 6, 4))
    titles = [ax.get_title() for ax in figure.axes[1::2]]
    assert titles == ["mean 40.00", "mean 0.61", "mean 1.00", "mean −1.00"]


@pytest.mark.parametrize(
    "step, label, last", [(200.0, "time (ns)", 19.8), (50.0, "time (ps)", 4950), (np.nan, "frame", 297)]
)
def test_time_is_reported_in_the_unit_that_reads_best(step, label, last):
    values, words = over_time.time_axis(trajectory(step=step))
    assert words == label and values.iloc[-1] == pytest.approx(last)


def test_residues_are_drawn_over_time():
    n = 12
    values = 0.4 + np.arange(4 * n).reshape(4, n) / 100
    values[2, 3] = np.nan
    rows = pd.DataFrame(values, columns=[f"r{k}" for k in range(n)])
    rows.insert(0, "time_ps", 100.0 * np.arange(4))
    rows.insert(0, "frame", range(4))
    residues = pd.DataFrame(
        {"chain": ["A"] * 7 + ["B"] * 5, "residue": [str(20 + k) for k in range(n)]}
        | {"mean_roughness": np.nanmean(values, axis=0), "sd_roughness": [0.01] * 11 + [np.nan]}
    )
    figure = over_time.residues_figure(rows, residues)
    ax, beside, _ = figure.axes
    image = ax.images[0]
    np.testing.assert_array_equal(image.get_array().filled(-1), np.nan_to_num(values.T, nan=-1))
    assert image.get_extent() == [
        -50.0,
        350.0,
        n - 0.5,
        -0.5,
    ]  # the first residue on top, frames in the middle of theirs
    assert (image.norm.vmin, image.norm.vmax) == (np.nanmin(values), np.nanmax(values))
    assert to_hex(image.cmap(np.ma.masked)).upper() == over_time.BURIED
    names = dict(zip(ax.get_yticks(), [t.get_text() for t in ax.get_yticklabels()], strict=True))
    assert names[0] == "A 20" and names[6] == "A 26" and names[7] == "B 27" and names[11] == "B 31"
    assert [line.get_ydata()[0] for line in ax.lines] == [6.5]  # where A ends
    np.testing.assert_allclose(
        beside.lines[0].get_xydata(), np.column_stack([residues["mean_roughness"], range(n)])
    )
    band = beside.collections[0].get_paths()[0].vertices
    at = band[band[:, 1] == 4, 0]
    assert (at.min(), at.max()) == pytest.approx(
        (residues["mean_roughness"][4] - 0.01, residues["mean_roughness"][4] + 0.01)
    )
    assert beside.get_ylim() == ax.get_ylim() == (n - 0.5, -0.5)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (ps)", "residue")
    assert any("grey: buried" in words for words in words_of(figure))


def stages():
    """energies.csv of three stages after a minimisation, each with numbers of its own, and what was aimed at."""
    rows, lengths = [], {"minimise": 5, "nvt": 30, "npt": 50, "production": 80}
    for s, (stage, n) in enumerate(lengths.items()):
        k = np.arange(n)
        rows.append(
            pd.DataFrame({"stage": stage, "time_ps": 200.0 * k, "temperature_K": 300 + s + np.sin(k)}).assign(
                pressure_bar=1.0 + 10 * s + np.cos(k), density_kg_m3=990.0 + s, potential_kJ_mol=-5000.0 - k
            )
        )
    judged = pd.DataFrame({"quantity": ["temperature_K", "pressure_bar"], "target": [300.0, 1.0]})
    t = np.arange(90)
    motion = pd.DataFrame({"time_ps": 100.0 * t, "rmsd": np.sqrt(t), "radius_of_gyration": 11 + t / 100})
    return pd.concat(rows, ignore_index=True), motion, judged


def test_a_simulation_is_drawn_stage_after_stage():
    energies, motion, judged = stages()
    figure = simulation_figure(energies, motion, judged)
    assert [ax.get_title(loc="left").split("  ")[1].split(" (")[0] for ax in figure.axes] == [
        "temperature", "pressure", "density", "potential energy", "Cα RMSD to the first frame", "radius of gyration",
    ]  # fmt: skip
    columns = ["temperature_K", "pressure_bar", "density_kg_m3", "potential_kJ_mol"]
    begins = {"nvt": 0.0, "npt": 5.8, "production": 5.8 + 9.8}  # ns: where the one before ended
    for ax, column in zip(figure.axes, columns, strict=False):
        whole = [line for line in ax.lines if line.get_linewidth() == 0.4]
        for line, colour, (stage, begin) in zip(whole, (BLUE, ORANGE, GREEN), begins.items(), strict=True):
            own = energies[energies["stage"] == stage]
            np.testing.assert_allclose(line.get_xdata(), begin + own["time_ps"] / 1000)
            np.testing.assert_allclose(
                line.get_ydata(), own[column] / (1000 if column.startswith("pot") else 1)
            )
            assert colour_of(line) == colour
        assert ax.get_xlabel() == "time (ns)"
        target = [line.get_ydata()[0] for line in ax.lines if line.is_dashed()]
        assert target == {"temperature_K": [300.0], "pressure_bar": [1.0]}.get(column, [])
    for ax, column in zip(figure.axes[4:], ("rmsd", "radius_of_gyration"), strict=True):
        pale, dark = ax.lines
        np.testing.assert_allclose(pale.get_xydata(), np.column_stack([motion["time_ps"], motion[column]]))
        # means of windows of 90 // 20 = 4 values, two before to one after
        wanted = [motion[column][max(0, i - 2) : i + 2].mean() for i in range(1, 90)]
        found = np.asarray(dark.get_ydata(), float)[1:]
        np.testing.assert_allclose(found[2:-2], wanted[2:-2])
        assert ax.get_xlabel() == "time of the production (ps)"
    said = dict(legend_of(figure))
    assert [said[w] for w in ("NVT, protein held", "NPT, protein held", "production")] == [
        BLUE,
        ORANGE,
        GREEN,
    ]
    short = energies[energies["stage"] != "production"].groupby("stage", sort=False).head(30)
    few = simulation_figure(
        pd.concat([short, energies[energies["stage"] == "production"].head(30)]), motion, judged
    )
    assert (
        len([line for line in few.axes[2].lines if line.get_linewidth() == 1.0]) == 0
    )  # too few for a moving mean


def test_measures_of_a_run_are_counted_and_their_medians_drawn():
    numbers = {"atoms": [100.0, 210, 420, 1600], "mean_roughness": [0.5, 0.52, 0.6, np.nan]}
    numbers |= {"area_per_atom": [7.0] * 4, "cavity_percent": [0.0, 0, 1, 2]}
    axes = distributions.figure(pd.DataFrame(numbers)).axes
    assert [ax.get_xlabel() for ax in axes] == [
        "atoms",
        "mean roughness",
        "area per atom / Å²",
        "dots in cavities / %",
    ]
    assert [sum(bar.get_height() for bar in ax.patches) for ax in axes] == [4, 3, 4, 4]
    assert [ax.lines[0].get_xdata()[0] for ax in axes] == pytest.approx([315, 0.52, 7, 0.5])
    assert [ax.get_xscale() for ax in axes] == ["log", "linear", "linear", "linear"]
    # equal ratios are equally wide: log 2.1 and log 4.2 are .27 and .52 of log 16
    counts = [bar.get_height() for bar in axes[0].patches]
    assert np.flatnonzero(counts).tolist() == [0, 10, 20, 39]
