"""The frames of a trajectory in the plane of its first principal components."""

import pandas as pd

from sparsurf import figures, page
from sparsurf.workflow import job


def main(paths, path_to_figure):
    """Draw clusters, chosen frames, silhouettes and explained variance."""
    tables = {key: pd.read_csv(path) for key, path in paths.items()}
    projection, frames = tables["projection"], tables["frames"]
    figure = figures.frames_projection(
        projection[["pc1", "pc2"]].to_numpy(),
        projection["cluster"].to_numpy(),
        projection.reset_index().set_index("frame")["index"].loc[frames["frame"]].to_numpy(),
        frames["conformation"].to_numpy(),
        tables["explained"]["explained"].to_numpy(),
        dict(zip(tables["silhouette"]["K"], tables["silhouette"]["silhouette"], strict=True)),
    )
    page.save(figure, path_to_figure)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            paths={key: snakemake.input[key] for key in ("frames", "projection", "silhouette", "explained")},
            path_to_figure=output["png"].removesuffix(".png"),
        )
