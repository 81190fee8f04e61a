# The config is read by `check_config` in rules/common.smk, which fills in the defaults, so that there is no `configfile:` here.
# Trajectory or structure or surface -> frames -> surface -> roughness -> sampling over the grid -> descriptors compared ->
# tables, best parameters, figures, in this order. The parts that a config switches on or off, the grid among them, are in rules/.
#
# All rules follow the same conventions. `params` names each key of the config that the script reads: Snakemake runs a job again
# where a parameter changes, so that a key which a script does not need would run it in vain. `code` does the same for the modules
# that scripts call, and `inputs` for files of the user that are replaced by older ones. Memory and time grow with
# `attempt`: on a cluster, a job that was ended for want of either is started again. A `localrule` takes seconds, less than it would
# wait in the queue of a cluster.

import os
import sys
from importlib.util import find_spec
from pathlib import Path

from snakemake.utils import min_version

min_version("9.27")

# A clone runs its own code. Loaded from a hosted repository, the rules run the installed package, of the same version.
IS_CLONE = isinstance(workflow.current_basedir, os.PathLike)
if IS_CLONE:
    HOME = Path(workflow.current_basedir)
    sys.path.insert(0, str(HOME / "src"))
    import sparsurf

    if not Path(sparsurf.__file__).resolve().is_relative_to((HOME / "src").resolve()):
        # an installed one, which the logger plugin has imported: rules, study and library must be of one version
        for name in [
            name for name in sys.modules if name.partition(".")[0] in ("sparsurf", "sparsurf_study")
        ]:
            del sys.modules[name]
else:
    wanted = Path(workflow.source_path("src/sparsurf/version.py")).read_text().split('"')[-2]
    missing = [name for name in ("sparsurf", "sparsurf_study", "matplotlib", "psutil") if not find_spec(name)]
    installed = f"lacks {missing[0]}" if missing else f"has {__import__('sparsurf').__version__}"
    if installed != f"has {wanted}":
        raise SystemExit(
            f"\nThese rules need sparsurf {wanted} with the extra `study`, but the environment of Snakemake {installed}: "
            f"run pip install 'sparsurf[study]=={wanted}' there.\n"
        )
    import sparsurf_study

    HOME = Path(sparsurf_study.__file__).parent  # It holds the default study, as a clone does.


include: "rules/common.smk"


wildcard_constraints:
    run=any_of([config["run"]]),
    protein=any_of(PROTEINS),
    conformation="[cf][0-9]+",
    pair=any_of(PAIRS),
    comparison=any_of(CHANGES),
    batch=any_of(BATCHES),


rule all:
    input:
        # There is one file for each protein, so that a protein whose frames cannot be read does not stop the others.
        expand("results/{run}/{protein}/.complete", run=config["run"], protein=PROTEINS),
        ends_before_frames,
        ends_beside_proteins,
        first_page,
        # The next two make Snakemake run again what was deleted or changed after the run.
        deleted_results,
        changed_results,


onstart:
    begin_run()


onsuccess:
    if (RUN / manifest.NAME).exists():  # A run of which single files are asked for has no manifest.
        print(answers_of_run(RUN, "paper" in config))


onerror:
    print(*reasons(RUN, BEGIN), sep="\n", file=sys.stderr)


rule complete_protein:
    input:
        ends_of_protein,
    output:
        touch("results/{run}/{protein}/.complete"),
    localrule: True
    message:
        "{wildcards.protein} is complete"


rule fetch_structure:
    output:
        structure="results/{run}/{protein}/download/{file}",
        record="results/{run}/{protein}/download/{file}.json",
    log:
        "results/{run}/logs/{protein}/fetch_{file}.log",
    wildcard_constraints:
        protein=any_of(DOWNLOADS),
        file=any_of(DOWNLOADS.values()),
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        url=of_protein("source"),
        sha256=of_protein("sha256"),
        name="{protein}",
    message:
        "Fetching {wildcards.protein}"
    script:
        "scripts/fetch_structure.py"


if SIMULATED:

    include: "rules/simulate.smk"


checkpoint choose_frames:
    input:
        unpack(molecule_files),
    output:
        frames="results/{run}/{protein}/frames.csv",
        silhouette="results/{run}/{protein}/silhouette.csv",
        projection="results/{run}/{protein}/projection.csv",
        explained="results/{run}/{protein}/explained.csv",
        structures=directory("results/{run}/{protein}/structures"),
    log:
        "results/{run}/logs/{protein}/choose_frames.log",
    wildcard_constraints:
        protein=any_of(SEVERAL_FRAMES),
    priority: 3  # A mistake in a structure is reported early.
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 50 * input.size_mb),
        runtime=lambda wildcards, input, attempt: attempt * (10 + input.size_mb / 50),
    params:
        frames=config["frames"],
        seed=config["seed"],
        molecule_options=of_protein("molecule_options"),
        inputs=stamps_of(molecule_files),
        code=CODE["numbers"],
    message:
        "Choosing the conformations of {wildcards.protein}"
    script:
        "scripts/choose_frames.py"


# It is no checkpoint, so that a thousand structures are planned at once.
use rule choose_frames as choose_single_frame with:
    wildcard_constraints:
        protein=any_of(SINGLE_FRAME),


rule draw_frames:
    input:
        frames="results/{run}/{protein}/frames.csv",
        silhouette="results/{run}/{protein}/silhouette.csv",
        projection="results/{run}/{protein}/projection.csv",
        explained="results/{run}/{protein}/explained.csv",
    output:
        png=in_report("results/{run}/{protein}/figures/frames.png"),
        svg="results/{run}/{protein}/figures/frames.svg",
    log:
        "results/{run}/logs/{protein}/draw_frames.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        code=CODE["pages"],
    message:
        "Figure of the frames of {wildcards.protein}"
    script:
        "scripts/draw_frames.py"


rule compute_surface:
    input:
        structures="results/{run}/{protein}/structures",
    output:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        structure="results/{run}/{protein}/{conformation}/structure.pdb",
        components="results/{run}/{protein}/{conformation}/components.csv",
        surface_atoms="results/{run}/{protein}/{conformation}/surface_atoms.csv",
    log:
        "results/{run}/logs/{protein}/{conformation}/compute_surface.log",
    wildcard_constraints:
        protein=any_of(MOLECULES),
    priority: 4  # The first picture of a surface comes before the next surface, and before all grids.
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
    params:
        surface=config["surface"],
        d_link=config["patches"]["d_link"],
        code=CODE["numbers"],
    message:
        "Molecular surface of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/compute_surface.py"


rule read_surface:
    input:
        surface=of_protein("surface"),
    output:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
    log:
        "results/{run}/logs/{protein}/{conformation}/read_surface.log",
    wildcard_constraints:
        protein=any_of(READY_SURFACES),
    priority: 4
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 50 * input.size_mb),
    params:
        inputs=stamps_of(of_protein("surface")),
        code=CODE["numbers"],
    message:
        "Reading the surface of {wildcards.protein}"
    script:
        "scripts/read_surface.py"


rule measure_roughness:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
    output:
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
    log:
        "results/{run}/logs/{protein}/{conformation}/measure_roughness.log",
    priority: 5
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 100 * input.size_mb),
    params:
        patches=part_of("patches", "r_patch", "d_link", "roughness"),
        code=CODE["numbers"],
    message:
        "Roughness of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_roughness.py"


rule draw_roughness:  # It draws what is seen first, which needs no grid.
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        structure=structure_of_conformation,
    output:
        page=in_report("results/{run}/{protein}/{conformation}/surface.html"),
        png=in_report("results/{run}/{protein}/{conformation}/figures/roughness.png"),
        svg="results/{run}/{protein}/{conformation}/figures/roughness.svg",
        picture="results/{run}/{protein}/{conformation}/pictures/roughness.png",
    log:
        "results/{run}/logs/{protein}/{conformation}/draw_roughness.log",
    priority: 6
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
    params:
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        patches=part_of("patches", "r_patch", "d_link", "roughness"),
        title=title_of_page,
        code=CODE["pages"],
    message:
        "First picture of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/draw_roughness.py"


rule measure_floors:
    input:
        conformation=structure_of_conformation,
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
    output:
        floors="results/{run}/{protein}/{conformation}/floors.csv",
    log:
        "results/{run}/logs/{protein}/{conformation}/measure_floors.log",
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
    params:
        surface=config["surface"],
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        evaluation=part_of("evaluation", "test_dots"),
        seed=config["seed"],
        molecule_options=of_protein("molecule_options"),
        code=CODE["numbers"],
    message:
        "Noise floor of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_floors.py"


if SAMPLED:

    include: "rules/sampling.smk"


rule select_minimal_subset:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        ranges=ranges_of_paper_sampler,
        structure=structure_of_conformation,
        table=table_of_protein,
    output:
        table="results/{run}/{protein}/{conformation}/minimal.csv",
        ply="results/{run}/{protein}/{conformation}/minimal.ply",
        whole="results/{run}/{protein}/{conformation}/surface.ply",
        recovered="results/{run}/{protein}/{conformation}/recovered.csv",
        reconstructed="results/{run}/{protein}/{conformation}/reconstructed.npz",
        fields="results/{run}/{protein}/{conformation}/fields.npz" if config["fields"] else [],
        fields_recovered="results/{run}/{protein}/{conformation}/fields.csv" if config["fields"] else [],
    log:
        "results/{run}/logs/{protein}/{conformation}/select_minimal_subset.log",
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 100 * input.size_mb),
    params:
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        evaluation=part_of("evaluation", "test_dots"),
        minimal=config["minimal"],
        fields=config["fields"],
        seed=config["seed"],
        inputs=stamps_of(of_protein("table")),
        code=CODE["numbers"],
    message:
        "Minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/select_minimal_subset.py"


rule draw_view:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        minimal="results/{run}/{protein}/{conformation}/minimal.csv",
        reconstructed="results/{run}/{protein}/{conformation}/reconstructed.npz",
        fields="results/{run}/{protein}/{conformation}/fields.npz" if config["fields"] else [],
        structure=structure_of_conformation,
        grid=if_sampled("grid.csv"),
        best=if_sampled("best.json"),
    output:
        page=in_report("results/{run}/{protein}/{conformation}/view.html"),
        picture="results/{run}/{protein}/{conformation}/view.png",
    log:
        "results/{run}/logs/{protein}/{conformation}/draw_view.log",
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
    params:
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        minimal=config["minimal"],
        seed=config["seed"],
        title=title_of_page,
        code=CODE["pages"],
    message:
        "Page of {wildcards.protein}/{wildcards.conformation} to look at"
    script:
        "scripts/draw_view.py"


rule tabulate_residues:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        minimal="results/{run}/{protein}/{conformation}/minimal.csv",
        fields="results/{run}/{protein}/{conformation}/fields.npz" if config["fields"] else [],
        structure="results/{run}/{protein}/{conformation}/structure.pdb",
    output:
        table=in_report("results/{run}/{protein}/{conformation}/residues.csv"),
        pdb="results/{run}/{protein}/{conformation}/structure_roughness.pdb",
        pml="results/{run}/{protein}/{conformation}/open.pml",
        cxc="results/{run}/{protein}/{conformation}/open.cxc",
        bild="results/{run}/{protein}/{conformation}/minimal.bild",
    log:
        "results/{run}/logs/{protein}/{conformation}/tabulate_residues.log",
    wildcard_constraints:
        protein=any_of(MOLECULES),
    conda:
        "envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
    params:
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        code=CODE["pages"],
    message:
        "Residues of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/tabulate_residues.py"


if config["compare"]["run"]:

    include: "rules/compare.smk"


if config["ensemble"]["run"]:

    include: "rules/ensemble.smk"


rule summarise_surfaces:
    input:
        surfaces=every_conformation("surface.npz"),
        roughness=every_conformation("roughness.csv"),
        minimal=every_conformation("minimal.csv"),
        recovered=every_conformation("recovered.csv"),
        residues=every_conformation("residues.csv", MOLECULES),
        components=every_conformation("components.csv", MOLECULES),
        ranges=every_conformation("ranges.csv", SAMPLED),
        best=every_conformation("best.json", SAMPLED),
        grid=every_conformation("grid.csv", SAMPLED),
    output:
        table="results/{run}/surfaces.csv",
        png=in_report("results/{run}/required_dots.png"),
    log:
        "results/{run}/logs/summarise_surfaces.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        minimal=config["minimal"],
        sampled=SAMPLED,
        exclude=[*config["exclude"]],
        code=CODE["pages"],
    message:
        "All surfaces side by side"
    script:
        "scripts/summarise_surfaces.py"


if PAIRS:

    include: "rules/pairs.smk"


if CHANGES:

    include: "rules/changes.smk"


if COMPARES_WITH_PAPER:

    include: "rules/paper.smk"


if BATCHED:

    include: "rules/batches.smk"

else:

    rule close_run:
        input:
            results=results_before_pages,
        output:
            page="results/{run}/index.html",
            failures="results/{run}/failures.csv",
            warnings="results/{run}/warnings.csv",
            checks="results/{run}/checks.csv",
            crate="results/{run}/ro-crate-metadata.json",
            sums="results/{run}/SHA256SUMS",
        log:
            "results/{run}/logs/close_run.log",
        localrule: True
        conda:
            "envs/study.yaml"
        params:
            exclude=config["exclude"],
            lengths=LENGTHS_OF_GLOSSARY,
            minimal=config["minimal"],
            # The page lists jobs and describes outputs: it is written again where a rule or a description changes
            jobs=log_names(workflow.rules),
            catalogue=catalogue.checksum(),
            code=CODE["pages"],
        message:
            "First page of the run"
        script:
            "scripts/close_run.py"
