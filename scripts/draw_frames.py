"""Draw the frames of a trajectory in the plane of its first principal components."""

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.frames import frames_projection
from sparsurf.workflow.jobs import job


def main(frames: str, silhouette: str, projection: str, explained: str, png: str, name: str) -> None:
    """Draw clusters, chosen frames, silhouettes and explained variance."""
    chosen, coordinates = pd.read_csv(frames), pd.read_csv(projection)
    silhouettes = pd.read_csv(silhouette)
    row_of_frame = pd.Series(range(len(coordinates)), index=coordinates["frame"])
    figure = frames_projection(
        coordinates[["pc1", "pc2"]].to_numpy(),
        coordinates["cluster"].to_numpy(),
        row_of_frame.loc[chosen["frame"]].to_numpy(),
        chosen["conformation"].tolist(),
        pd.read_csv(explained)["explained"].to_numpy(),
        dict(zip(silhouettes["K"], silhouettes["silhouette"], strict=True)),
        name,
    )
    layout.save(figure, png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            frames=snakemake.input.frames,
            silhouette=snakemake.input.silhouette,
            projection=snakemake.input.projection,
            explained=snakemake.input.explained,
            png=snakemake.output.png,
            name=snakemake.wildcards.protein,
        )
