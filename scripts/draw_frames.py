"""The frames of a trajectory in the plane of its first principal components."""

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.frames import frames_projection
from sparsurf.workflow.jobs import run


def main(inputs, outputs, name):
    """Draw clusters, chosen frames, silhouettes and explained variance."""
    tables = {key: pd.read_csv(path) for key, path in inputs.items()}
    projection, frames = tables["projection"], tables["frames"]
    figure = frames_projection(
        projection[["pc1", "pc2"]].to_numpy(),
        projection["cluster"].to_numpy(),
        projection.reset_index().set_index("frame")["index"].loc[frames["frame"]].to_numpy(),
        frames["conformation"].to_numpy(),
        tables["explained"]["explained"].to_numpy(),
        dict(zip(tables["silhouette"]["K"], tables["silhouette"]["silhouette"], strict=True)),
        name,
    )
    layout.save(figure, outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
