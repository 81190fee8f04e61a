"""Take all steps of one conformation in one process: surface, roughness, floors, minimal subset, page and residues."""

import compute_surface
import draw_view
import measure_floors
import measure_roughness
import select_minimal_subset
import tabulate_residues
from sparsurf.workflow.jobs import job


def main(
    structures: str,
    structure: str | None,
    trajectory: str | None,
    frames: str | None,
    field_table: str | None,
    outputs: dict[str, str],
    surface_settings: dict,
    patches: dict,
    distance_from_moved_centre: bool,
    chance_in_every_patch: bool,
    test_dots: int | str,
    minimal: dict,
    field_names: list[str],
    seed: int,
    molecule_options: dict,
    name: str,
    title: str,
    threads: int = 1,
) -> None:
    """Write what the rules of these steps write; `outputs` are the paths by their names in rules/minimal.smk."""
    rules = {
        "patches": patches,
        "distance_from_moved_centre": distance_from_moved_centre,
        "chance_in_every_patch": chance_in_every_patch,
        "seed": seed,
        "name": name,
        "threads": threads,
    }
    compute_surface.main(
        structures=structures,
        surface=outputs["surface"],
        structure=outputs["structure"],
        dms=outputs["dms"],
        components=outputs["components"],
        settings=surface_settings,
        d_link=patches["D_link"],
        name=name,
    )
    measure_roughness.main(outputs["surface"], outputs["roughness"], patches, name, threads)
    measure_floors.main(
        surface=outputs["surface"],
        roughness=outputs["roughness"],
        conformation=outputs["structure"],
        structure=structure,
        trajectory=trajectory,
        frames=frames,
        floors=outputs["floors"],
        distances=outputs["floor_distances"],
        surface_settings=surface_settings,
        test_dots=test_dots,
        molecule_options=molecule_options,
        **rules,
    )
    select_minimal_subset.main(
        surface=outputs["surface"],
        roughness=outputs["roughness"],
        floors=outputs["floor_distances"],
        ranges=None,
        structure=outputs["structure"],
        field_table=field_table,
        table=outputs["minimal"],
        ply=outputs["ply"],
        whole=outputs["whole"],
        recovered=outputs["recovered"],
        required_dots=outputs["required_dots"],
        curves=outputs["curves"],
        fields=outputs["fields"],
        fields_recovered=outputs["fields_recovered"],
        test_dots=test_dots,
        minimal=minimal,
        field_names=field_names,
        whole_curve=False,
        **rules,
    )
    draw_view.main(
        surface=outputs["surface"],
        roughness=outputs["roughness"],
        minimal=outputs["minimal"],
        fields=outputs["fields"],
        structure=outputs["structure"],
        grid=None,
        best=None,
        required_dots=outputs["required_dots"],
        page=outputs["page"],
        picture=outputs["picture"],
        minimal_settings=minimal,
        title=title,
        **rules,
    )
    tabulate_residues.main(
        surface=outputs["surface"],
        roughness=outputs["roughness"],
        minimal=outputs["minimal"],
        fields=outputs["fields"],
        structure=outputs["structure"],
        table=outputs["residues"],
        pdb=outputs["pdb"],
        cif=outputs["cif"],
        pml=outputs["pml"],
        cxc=outputs["cxc"],
        bild=outputs["bild"],
        name=name,
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            structures=snakemake.input.structures,
            structure=snakemake.input.get("structure"),
            trajectory=snakemake.input.get("trajectory"),
            frames=snakemake.input.get("frames"),
            field_table=snakemake.input.table or None,
            outputs=dict(snakemake.output.items()),
            surface_settings=snakemake.params.surface,
            patches=snakemake.params.patches,
            distance_from_moved_centre=snakemake.params.distance_from_moved_centre,
            chance_in_every_patch=snakemake.params.chance_in_every_patch,
            test_dots=snakemake.params.test_dots,
            minimal=snakemake.params.minimal,
            field_names=snakemake.params.fields,
            seed=snakemake.params.seed,
            molecule_options=snakemake.params.molecule_options,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            title=snakemake.params.title,
            threads=snakemake.threads,
        )
