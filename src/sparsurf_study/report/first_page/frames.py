"""Trajectories on the first page: one combination followed over the frames, and the quality of simulations."""

from __future__ import annotations

from typing import Any

from sparsurf.patches.readings import words_of
from sparsurf.recovery.readings import readings_of_columns
from sparsurf.views.numbers import number
from sparsurf_study.report.first_page.run import MAX_SHOWN, Run, TableLink


def of_frames(run: Run) -> list[dict[str, Any]]:
    """Collect each protein whose frames were followed with one combination."""
    found = []
    for protein in run.ending("ensemble.csv")[:MAX_SHOWN]:
        table = run.read(f"{protein}/ensemble.csv")
        measured = {"N": ("dots", 0), "area": ("area (Å²)", 0), "mean_roughness": ("mean roughness", 3)}
        measured["n_S_percent"] = ("n_S (%)", 1)
        for reading in readings_of_columns(table, "d_"):
            measured[f"d_{reading}"] = (f"d {words_of(reading)}", 2)
        rows: list[list[Any]] = []
        for column, (label, digits) in measured.items():
            values = table[column].agg(["mean", "std", "min", "max"])
            rows.append([label, *(number(x, digits) if digits else f"{x:,.0f}" for x in values)])
        found.append(
            {
                "name": protein,
                "n_frames": len(table),
                "kept": table["n_S_percent"].agg(["mean", "min", "max"]).tolist(),
                "roughness": table["mean_roughness"].agg(["mean", "min", "max"]).tolist(),
                "figures": run.figures(protein, "frame_figures"),
                "table": TableLink(["measure", "mean", "standard deviation", "lowest", "highest"], rows),
                "links": run.links(protein, "frames"),
            }
        )
    return found


def of_simulations(run: Run) -> list[dict[str, Any]]:
    """Collect each protein that was simulated in the run."""
    found = []
    for folder in run.ending("simulation.png")[:MAX_SHOWN]:
        protein = folder.split("/")[0]
        figure = run.figure(f"{folder}/simulation.png")
        found.append({"name": protein, "figure": figure, "links": run.links(protein, "simulations")})
    return found
