# Trajectory or structure or surface -> frames -> surface -> roughness -> grid -> tables, figures, report, in this order.
# What only some studies ask for is included at its place, from a file called like its key of the config (config.yaml).

import sys
from functools import partial
from pathlib import Path

from snakemake.utils import min_version

min_version("9.0")


report: "src/sparsurf/report/captions/first.rst"


HOME = Path(workflow.current_basedir)  # where this file lies, also where another workflow imports it
sys.path.insert(0, str(HOME / "src"))  # before a sparsurf that is installed
if not Path(getattr(sys.modules.get("sparsurf"), "__file__", HOME)).is_relative_to(HOME):
    for name in [name for name in sys.modules if name.partition(".")[0] == "sparsurf"]:
        del sys.modules[name]  # which Snakemake's logger may have loaded already
from sparsurf.workflow import code_digests
from sparsurf.workflow.config import checked, completed
from sparsurf.workflow.files_of_a_run import FilesOfARun
from sparsurf.workflow.files_of_pairs import FilesOfPairs
from sparsurf.workflow.files_of_sites import FilesOfSites
from sparsurf.workflow.jobs import in_one_environment, one_of, use_this_library
from sparsurf.workflow.needs import needs
from sparsurf.workflow.outputs import IN_REPORT, Outputs, figure, inside, shown
from sparsurf.workflow.registries import names

use_this_library()

HERE = workflow.is_main_process and workflow.resource_settings.nodes is None  # not on a cluster
config = checked(completed(config, HOME), workflow.configfiles, HOME, HERE)
made_by = partial(code_digests.made_by, config)

files = FilesOfARun(config, checkpoints)
pairs = FilesOfPairs(config, files)
sites = FilesOfSites(config, files)
outputs = Outputs(workflow, files, pair=pairs, site=sites)  # of the rules below
defects = ("sampling.moved_centre", "sampling.every_patch")  # what a sampling goes by beside its combination
KERNEL_PARTS = ("surfaces", "patches")
of_each = shown if len(files.proteins) <= IN_REPORT else lambda path, *_: path  # of a conformation
THREADS = 8  # of a job that takes minutes; Snakemake scales them down to --cores

RUN = files.run
PROTEIN = f"{RUN}/{{protein}}"
CONFORMATION = f"{PROTEIN}/{{conformation}}"
LOGS = f"{RUN}/logs"
PROTEIN_LOGS = f"{LOGS}/{{protein}}"
CONFORMATION_LOGS = f"{PROTEIN_LOGS}/{{conformation}}"
# What several rules read
KERNELS = inside(RUN, **{f"kernels_of_{part}": f".kernels_of_{part}" for part in KERNEL_PARTS})
FRAMES = inside(PROTEIN, frames="frames.csv", silhouette="silhouette.csv")
FRAMES |= inside(PROTEIN, projection="projection.csv", explained="explained.csv")
SURFACE = inside(CONFORMATION, surface="surface.npz")
ROUGH_SURFACE = SURFACE | inside(CONFORMATION, roughness="roughness.csv") | KERNELS
GRID, FLOORS, RANGES, MINIMAL = (
    inside(CONFORMATION, **{name: f"{name}.csv"}) for name in ("grid", "floors", "ranges", "minimal")
)
BEST = inside(CONFORMATION, best="best.json")
SUMMARY = inside(RUN, relation="relation.csv", page="summary.html")
SUMMARY |= figure(f"{RUN}/summary", "Best parameters against mean roughness", "summary")
SUMMARY["summary"] = shown(f"{RUN}/summary.csv", "Best combination per surface and range of n_S", "summary")
SAMPLED = config["sampling"]["run"]
if not SAMPLED:  # nothing follows from the grid
    GRID = RANGES = BEST = SUMMARY = {}
FIELDS = inside(CONFORMATION, fields="fields.npz", given_back="fields.csv") if config["fields"] else {}
ENOUGH = inside(CONFORMATION, enough="enough.csv", curves="curves.csv")
WARNINGS, CRATE = f"{RUN}/warnings.csv", "ro-crate-metadata.json"
FIRST_PAGE = inside(RUN, html="index.html", part=".front_page.html", failures="failures.csv", crate=CRATE)


wildcard_constraints:
    protein=one_of(files.proteins),
    conformation="[cf][0-9]+",
    pair=one_of(pairs.names),


# What a run is asked for
rule all:
    default_target: True
    input:
        KERNELS.values(),  # at once: they are compiled while the frames are chosen
        [f"{RUN}/{place}/.complete" for place in [*files.proteins, *outputs.places]],
        outputs.of_run,
        *outputs.each(),


rule complete_protein:  # each by itself, so that one that fails does not keep the others from being finished
    input:
        outputs.of_protein,
    output:
        touch(f"{PROTEIN}/.complete"),


rule complete_place:  # a pair, or a site
    input:
        outputs.of_place,
    output:
        touch(f"{RUN}/{{place}}/.complete"),
    wildcard_constraints:
        place=one_of(outputs.places),


# From structures to conformations: fetched, simulated where asked for, chosen from the frames
rule compile_kernels:
    output:
        mark=f"{RUN}/.kernels_of_{{part}}",
    log:
        f"{LOGS}/compile_kernels_of_{{part}}.log",
    wildcard_constraints:
        part=one_of(KERNEL_PARTS),
    priority: 4  # both before the frames are chosen, which takes less time than the difference between the two
    localrule: True  # as all that takes seconds: not worth a job of a cluster
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
    params:
        **made_by("fetch_structure.py"),
        url=lambda wildcards: files.protein(wildcards).source,
        sha256=lambda wildcards: files.protein(wildcards).sha256,
    message:
        "Fetching {wildcards.protein}"
    script:
        "scripts/fetch_structure.py"


if files.simulated:

    include: "rules/simulate.smk"


checkpoint choose_frames:
    input:
        unpack(files.molecule),
    output:
        **FRAMES,
        structures=directory(f"{PROTEIN}/structures"),
    log:
        f"{PROTEIN_LOGS}/choose_frames.log",
    wildcard_constraints:
        protein=one_of(files.many),
    priority: 3  # a mistake in a structure is told early
    localrule: files.few_frames
    resources:
        **needs("choose_frames", files.megabytes(config["frames"]["stride"])),
    params:
        **made_by("choose_frames.py", "frames", "seed"),
        contents=files.contents,
        molecule_options=lambda wildcards: files.protein(wildcards).molecule_options,
    message:
        "Choosing the conformations of {wildcards.protein}"
    script:
        "scripts/choose_frames.py"


use rule choose_frames as choose_only_frame with:  # no checkpoint: a thousand structures are planned at once
    wildcard_constraints:
        protein=one_of(files.single),


rule draw_frames:
    input:
        **FRAMES,
    output:
        **figure(f"{PROTEIN}/figures/frames", "Frames and conformations", "frames"),
    log:
        f"{PROTEIN_LOGS}/draw_frames.log",
    wildcard_constraints:
        protein=one_of(files.many),
    localrule: True
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
        **inside(CONFORMATION, structure="structure.pdb", dms="surface.dms", components="components.csv"),
    log:
        f"{CONFORMATION_LOGS}/make_surface.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
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
        **inside(CONFORMATION, roughness="roughness.csv"),
    log:
        f"{CONFORMATION_LOGS}/measure_roughness.log",
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
    resources:
        **needs("measure_floors", files.dots),
    params:
        **made_by("measure_floors.py", "surface", "patches", *defects, "evaluation.test_dots", "seed"),
        molecule_options=lambda wildcards: files.protein(wildcards).molecule_options,
    message:
        "Noise floors of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_floors.py"


if SAMPLED:

    include: "rules/sampling.smk"


rule take_minimal:
    input:
        **(ROUGH_SURFACE | FLOORS),
        **(RANGES if config["minimal"]["sampler"] in names("samplers", "choosing") else {}),
        structure=files.structure,
        table=files.table,
    output:
        **(ENOUGH | FIELDS | inside(CONFORMATION, table="minimal.csv", recovered="recovered.csv")),
        **inside(CONFORMATION, ply="minimal.ply", whole="surface.ply"),
    log:
        f"{CONFORMATION_LOGS}/take_minimal.log",
    resources:
        **needs("take_minimal", files.dots),
    params:
        **made_by("take_minimal.py", "patches", *defects, "evaluation.test_dots", "minimal", "fields", "seed"),
        contents=lambda wildcards: code_digests.content(files.protein(wildcards).table or ""),
    message:
        "Minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/take_minimal.py"


rule draw_view:
    input:
        **(ROUGH_SURFACE | GRID | BEST | MINIMAL | FIELDS),
        structure=files.structure,
    output:
        page=of_each(f"{CONFORMATION}/view.html", "Turn, sample and pick dots", "view"),
        picture=f"{CONFORMATION}/view.png",
    log:
        f"{CONFORMATION_LOGS}/draw_view.log",
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
        **(ROUGH_SURFACE | MINIMAL | FIELDS),
        structure=f"{CONFORMATION}/structure.pdb",
    output:
        **inside(CONFORMATION, pdb="structure_roughness.pdb", cif="structure_roughness.cif"),
        **inside(CONFORMATION, pml="open.pml", cxc="open.cxc", bild="minimal.bild"),
        table=of_each(f"{CONFORMATION}/residues.csv", "Residue by residue", "residues"),
    log:
        f"{CONFORMATION_LOGS}/tabulate_residues.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    resources:
        **needs("tabulate_residues", files.dots),
    params:
        **made_by("tabulate_residues.py"),
    message:
        "Residues of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/tabulate_residues.py"


if not SAMPLED:

    include: "rules/minimal.smk"


if config["compare"]["run"]:

    include: "rules/compare.smk"


if config["ensemble"]["run"]:

    include: "rules/ensemble.smk"


if files.proteins:

    rule summarise_run:
        input:
            results=files.every("surface.npz", "roughness.csv", "minimal.csv"),
            read_too=files.every(
                "enough.csv",
                "curves.csv",
                "floors.csv",
                *(Path(path).name for path in (GRID | RANGES | BEST).values()),
            ),
        output:
            **SUMMARY,
            surfaces=f"{RUN}/surfaces.csv",
            enough=shown(f"{RUN}/enough.png", "How many dots are enough", "enough"),
            enough_svg=f"{RUN}/enough.svg",
        log:
            f"{LOGS}/summarise_run.log",
        localrule: True
        params:
            **made_by("summarise_run.py", "patches", "minimal", "seed"),
        message:
            "All surfaces side by side"
        script:
            "scripts/summarise_run.py"


if pairs.names:

    include: "rules/pairs.smk"


if sites.names:

    include: "rules/sites.smk"


if files.goes_on_with(config.get("paper"), "c1"):

    include: "rules/paper.smk"


rule collect_warnings:  # of all jobs, so that the first page can show them
    input:
        results=outputs.all_but(WARNINGS, *FIRST_PAGE.values()),
    output:
        table=WARNINGS,
    log:
        f"{LOGS}/collect_warnings.log",
    localrule: True
    params:
        **made_by("collect_warnings.py"),
        places=[*files.proteins, *outputs.places, *config["without"]],
        jobs=outputs.jobs,
    message:
        "Warnings of the run"
    script:
        "scripts/collect_warnings.py"


rule write_front_page:
    input:
        pages=outputs.all_but(*FIRST_PAGE.values(), shown=True),
        beside=outputs.all_but(*FIRST_PAGE.values(), shown=False),
    output:
        **FIRST_PAGE,
    log:
        f"{LOGS}/write_front_page.log",
    localrule: True
    params:
        **made_by("write_front_page.py"),
        folder=lambda wildcards, output: str(Path(output.html).parent),
        without=config["without"],
        floor=config["minimal"].get("floor"),
    message:
        "First page of the run"
    script:
        "scripts/write_front_page.py"


in_one_environment(workflow, HOME)
