# Trajectory or structure or surface -> frames -> surface -> roughness -> grid -> tables, figures, report, in this order.
# What only some studies ask for is included at its place, from a file called like its key of the config (config.yaml).

import sys
from functools import partial
from pathlib import Path

from snakemake.utils import min_version

min_version("9.0")


report: "scripts/report/first.rst"


HOME = Path(workflow.current_basedir)  # where this file lies, also where another workflow imports it
sys.path.insert(0, str(HOME / "scripts"))  # before a sparsurf that is installed
from sparsurf.workflow import code_digests
from sparsurf.workflow.config import checked, completed
from sparsurf.workflow.files_of_a_run import FilesOfARun
from sparsurf.workflow.files_of_pairs import FilesOfPairs
from sparsurf.workflow.jobs import one_of, use_this_library
from sparsurf.workflow.needs import needs
from sparsurf.workflow.outputs import figure, inside, shown

use_this_library()

HERE = workflow.is_main_process and workflow.resource_settings.nodes is None  # not on a cluster
config = checked(completed(config, HOME), workflow.configfiles, HOME, HERE)
made_by = partial(code_digests.made_by, config)

# The figures of a conformation: scripts/sparsurf/report/figures/<name>.py, captioned in scripts/report/<name>.rst
FIGURES = {
    "roughness": "Fig. 1, roughness",
    "number_of_dots": "Fig. 2, number of dots",
    "d_over_grid": "Fig. 3, d over the grid",
    "rough_and_flat": "Fig. 4, rough and flat patches",
    "subsets": "Fig. 5, surfaces",
}
files = FilesOfARun(config, FIGURES, checkpoints)
pairs = FilesOfPairs(config, files)
CHOOSING = ("paper", "paper_corrected")  # samplers that take the combination which is best in its range
defects = ("sampling.moved_centre", "sampling.every_patch")  # what a sampling goes by beside its combination
KERNEL_PARTS = ("surfaces", "patches")
THREADS = 8  # of a job that takes minutes; Snakemake scales them down to --cores

RUN = files.run
PROTEIN = f"{RUN}/{{protein}}"
CONFORMATION = f"{PROTEIN}/{{conformation}}"
LOGS = f"{RUN}/logs"
PROTEIN_LOGS = f"{LOGS}/{{protein}}"
CONFORMATION_LOGS = f"{PROTEIN_LOGS}/{{conformation}}"
# What several rules read
KERNELS = inside(RUN, **{f"kernels_of_{part}": f".kernels_of_{part}" for part in KERNEL_PARTS})
FRAMES = {key: f"{PROTEIN}/{key}.csv" for key in ("frames", "silhouette", "projection", "explained")}
SURFACE = inside(CONFORMATION, surface="surface.npz")
ROUGH_SURFACE = SURFACE | inside(CONFORMATION, roughness="roughness.csv") | KERNELS
GRID = inside(CONFORMATION, grid="grid.csv")
DISTANCES = inside(CONFORMATION, distances="distances.npz")
FLOORS = inside(CONFORMATION, floors="floors.csv")
RANGES = inside(CONFORMATION, ranges="ranges.csv")
BEST = inside(CONFORMATION, best="best.json")
BINS = inside(CONFORMATION, bins="rough_and_flat.csv")
ENOUGH = inside(CONFORMATION, enough="enough.csv")
MINIMAL = inside(CONFORMATION, minimal="minimal.csv")
FIRST_PAGE = inside(RUN, md="index.md", html="index.html", part=".front_page.html")  # part: opens the report


wildcard_constraints:
    protein=one_of(files.proteins),
    conformation="[cf][0-9]+",


# What a run is asked for
rule all:
    default_target: True
    input:
        KERNELS.values(),  # at once: they are compiled while the frames are chosen
        files.of_proteins(),
        *files.of_each(),
        pairs.of_pairs(),
    message:
        f"All of {RUN} is there"


rule complete_protein:  # each by itself, so that one that fails does not keep the others from being finished
    input:
        files.of_protein,
        files.of_conformations,
    output:
        touch(f"{PROTEIN}/.complete"),
    message:
        "All of {wildcards.protein} is there"


# From structures to conformations: fetched, simulated where asked for, chosen from the frames
rule compile_kernels:
    output:
        mark=f"{RUN}/.kernels_of_{{part}}",
    log:
        f"{LOGS}/compile_kernels_of_{{part}}.log",
    wildcard_constraints:
        part=one_of(KERNEL_PARTS),
    priority: 2  # both before the frames are chosen, which takes less time than the difference between the two
    localrule: True  # as all that takes seconds: not worth a job of a cluster
    conda:
        "envs/study.yaml"
    params:
        **made_by("compile_kernels.py"),
        part="{part}",
        descriptor=config["patches"]["descriptor"],
    message:
        "Compiling the kernels of {wildcards.part} (once)"
    script:
        "scripts/compile_kernels.py"


rule fetch_structure:
    output:
        structure=f"{PROTEIN}/download/{{file}}",
        record=f"{PROTEIN}/download/{{file}}.json",
    log:
        f"{PROTEIN_LOGS}/fetch_{{file}}.log",
    wildcard_constraints:
        protein=one_of(files.fetched),
        file=one_of(files.fetched.values()),
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        **made_by("fetch_structure.py"),
        url=lambda wildcards: files.protein(wildcards).source,
        sha256=lambda wildcards: files.protein(wildcards).sha256,
    message:
        "Fetching {wildcards.protein}"
    script:
        "scripts/fetch_structure.py"


include: "simulate.smk"


checkpoint choose_frames:
    input:
        unpack(files.molecule),
    output:
        **FRAMES,
        structures=directory(f"{PROTEIN}/structures"),
    log:
        f"{PROTEIN_LOGS}/choose_frames.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    localrule: files.few_frames
    conda:
        "envs/study.yaml"
    resources:
        **needs("choose_frames", files.megabytes(config["frames"]["stride"])),
    params:
        **made_by("choose_frames.py", "frames", "seed"),
        contents=files.contents,
        reading=lambda wildcards: files.protein(wildcards).reading,
    message:
        "Choosing the conformations of {wildcards.protein}"
    script:
        "scripts/choose_frames.py"


rule draw_frames:
    input:
        **FRAMES,
    output:
        **figure(f"{PROTEIN}/figures/frames", "Frames and conformations", "frames"),
    log:
        f"{PROTEIN_LOGS}/draw_frames.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        **made_by("draw_frames.py"),
    message:
        "Figure of the frames of {wildcards.protein}"
    script:
        "scripts/draw_frames.py"


# The method, conformation by conformation: surface, roughness, the grid, the best of it
rule make_surface:
    input:
        **KERNELS,
        structures=f"{PROTEIN}/structures",
    output:
        **SURFACE,
        **inside(CONFORMATION, structure="structure.pdb", dms="surface.dms"),
    log:
        f"{CONFORMATION_LOGS}/make_surface.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    conda:
        "envs/study.yaml"
    resources:
        **needs("make_surface", files.dots),
    params:
        **made_by("make_surface.py", "surface", "patches.D_link"),
    message:
        "Molecular surface of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/make_surface.py"


rule take_surface:
    input:
        surface=lambda wildcards: files.protein(wildcards).surface,
    output:
        **SURFACE,
    log:
        f"{CONFORMATION_LOGS}/take_surface.log",
    wildcard_constraints:
        protein=one_of(files.surfaces),
    conda:
        "envs/study.yaml"
    resources:
        **needs("take_surface", files.dots),
    params:
        **made_by("take_surface.py"),
        contents=files.contents,
    message:
        "Reading the surface of {wildcards.protein}"
    script:
        "scripts/take_surface.py"


rule measure_roughness:
    input:
        **(SURFACE | KERNELS),
    output:
        **inside(CONFORMATION, roughness="roughness.csv", ply="surface.ply"),
    log:
        f"{CONFORMATION_LOGS}/measure_roughness.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("measure_roughness", files.dots),
    params:
        **made_by("measure_roughness.py", "patches"),
    message:
        "Roughness of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_roughness.py"


rule measure_floors:
    input:
        unpack(files.atoms),
        **ROUGH_SURFACE,
    output:
        **FLOORS,
    log:
        f"{CONFORMATION_LOGS}/measure_floors.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("measure_floors", files.dots),
    params:
        **made_by("measure_floors.py", "surface", "patches", *defects, "evaluation.test_dots", "seed"),
        reading=lambda wildcards: files.protein(wildcards).reading,
    message:
        "Noise floors of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_floors.py"


rule evaluate_grid:
    input:
        **ROUGH_SURFACE,
    output:
        **(GRID | DISTANCES),
    log:
        f"{CONFORMATION_LOGS}/evaluate_grid.log",
    priority: 2  # before what only follows from them
    conda:
        "envs/study.yaml"
    threads: files.side_by_side(THREADS, workflow.resource_settings.cores if HERE else None)
    resources:
        **needs("evaluate_grid", files.dots, besides=files.distances),
    params:
        **made_by("evaluate_grid.py", "patches", "sampling", "evaluation", "seed"),
    message:
        "Sampling and comparing {wildcards.protein}/{wildcards.conformation} over the grid"
    script:
        "scripts/evaluate_grid.py"


rule tabulate_best:
    input:
        **(GRID | DISTANCES | FLOORS),
    output:
        **inside(CONFORMATION, ranges_md="ranges.md", best="best.json", best_md="best.md"),
        ranges=shown(f"{CONFORMATION}/ranges.csv", "Best combination per range of n_S", "ranges"),
    log:
        f"{CONFORMATION_LOGS}/tabulate_best.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("tabulate_best", files.dots, besides=files.distances),
    params:
        **made_by("tabulate_best.py", "tables"),
    message:
        "Best combinations of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/tabulate_best.py"


rule draw_figures:
    input:
        **(ROUGH_SURFACE | GRID | BEST),
    output:
        **{name: shown(f"{CONFORMATION}/figures/{name}.png", FIGURES[name], name) for name in FIGURES},
        **BINS,
        svgs=[f"{CONFORMATION}/figures/{name}.svg" for name in FIGURES],
    log:
        f"{CONFORMATION_LOGS}/draw_figures.log",
    priority: 1  # the longest of what is left: shorter ones fill the end
    conda:
        "envs/study.yaml"
    resources:
        **needs("draw_figures", files.dots),
    params:
        **made_by("draw_figures.py", "patches", *defects, "evaluation.test_dots", "seed", figures=FIGURES),
    message:
        "Figures of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/draw_figures.py"


rule take_minimal:
    input:
        **(ROUGH_SURFACE | FLOORS),
        **(RANGES if config["minimal"]["sampler"] in CHOOSING else {}),
    output:
        **ENOUGH,
        **inside(CONFORMATION, table="minimal.csv", ply="minimal.ply"),
    log:
        f"{CONFORMATION_LOGS}/take_minimal.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("take_minimal", files.dots),
    params:
        **made_by("take_minimal.py", "patches", *defects, "evaluation.test_dots", "minimal", "seed"),
    message:
        "Minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/take_minimal.py"


rule draw_view:
    input:
        **(ROUGH_SURFACE | GRID | BEST | MINIMAL),
        structure=files.structure,
    output:
        page=shown(f"{CONFORMATION}/view.html", "Turn, sample and pick dots", "view"),
    log:
        f"{CONFORMATION_LOGS}/draw_view.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("draw_view", files.dots),
    params:
        **made_by("draw_view.py", "patches", *defects, "seed"),
    message:
        "Page of {wildcards.protein}/{wildcards.conformation} to look at"
    script:
        "scripts/draw_view.py"


rule tabulate_residues:
    input:
        **(ROUGH_SURFACE | MINIMAL),
        structure=f"{CONFORMATION}/structure.pdb",
    output:
        **inside(CONFORMATION, pdb="structure_roughness.pdb", cif="structure_roughness.cif"),
        table=shown(f"{CONFORMATION}/residues.csv", "Residue by residue", "residues"),
    log:
        f"{CONFORMATION_LOGS}/tabulate_residues.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("tabulate_residues", files.dots),
    params:
        **made_by("tabulate_residues.py"),
    message:
        "Residues of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/tabulate_residues.py"


include: "compare.smk"
include: "ensemble.smk"


rule summarise_run:
    input:
        results=files.every(
            "best.json", "ranges.csv", "grid.csv", "roughness.csv", "surface.npz", "enough.csv"
        ),
    output:
        **inside(RUN, surfaces="surfaces.csv", relation="relation.csv", markdown="summary.md"),
        **figure(f"{RUN}/summary", "Best parameters against mean roughness", "summary"),
        summary=shown(f"{RUN}/summary.csv", "Best combination per surface and range of n_S", "summary"),
    log:
        f"{LOGS}/summarise_run.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        **made_by("summarise_run.py", "patches", "seed"),
    message:
        "Best parameters against mean roughness, over all surfaces"
    script:
        "scripts/summarise_run.py"


include: "pairs.smk"


# The paper beside it
if "paper" in config:  # the name of the protein that is the paper's A1
    A1 = {"protein": config["paper"], "conformation": "c1"}
    OF_A1 = ROUGH_SURFACE | GRID | RANGES | BEST | BINS | FLOORS | ENOUGH

    rule reproduce_paper:
        input:
            **{key: path.format(**A1) for key, path in OF_A1.items()},
        output:
            **inside(RUN, verdict="verdict.md", runs="paper_as_published.csv", places="paper_places.csv"),
            **inside(RUN, links="paper_links.csv", defects="paper_defects.csv", family="paper_family.csv"),
            html=shown(f"{RUN}/verdict.html", "Claim by claim", "verdict", "The paper"),
            rows=shown(f"{RUN}/paper_rows.csv", "Table I, row by row", "verdict", "The paper"),
        log:
            f"{LOGS}/reproduce_paper.log",
        conda:
            "envs/study.yaml"
        threads: THREADS
        params:
            **made_by("reproduce_paper.py", "surface", "patches", "sampling", "evaluation", "seed"),
            path_to_surface=files.proteins[config["paper"]].surface,
            name="/".join(A1.values()),
        message:
            "Comparing with the paper"
        script:
            "scripts/reproduce_paper.py"


rule write_front_page:
    input:
        surfaces=f"{RUN}/surfaces.csv",
        grids=files.every("grid.csv"),
        best=files.every("best.json"),
        minimal=files.every("minimal.csv"),
        enough=files.every("enough.csv"),
        needed=[f"{RUN}/compare_needed.csv"] if config["compare"]["run"] else [],
        pages=lambda wildcards: files.led_to(wildcards) + pairs.pictures,
        beside=lambda wildcards: files.led_to_beside(wildcards) + pairs.texts + pairs.summary,
    output:
        **FIRST_PAGE,
    log:
        f"{LOGS}/write_front_page.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        **made_by("write_front_page.py"),
    message:
        "First page of the run"
    script:
        "scripts/write_front_page.py"
