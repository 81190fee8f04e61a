# Trajectory or structure or surface -> frames -> surface -> roughness -> grid -> tables, figures, report.
# Read from top to bottom in the order the data flow. Every key of the config: config.yaml.

import sys
from functools import partial
from pathlib import Path

from snakemake.utils import min_version

min_version("9.0")


report: "scripts/report/first.rst"


HOME = Path(workflow.current_basedir)  # where this file lies, also where another workflow imports it
sys.path.insert(0, str(HOME / "scripts"))  # before a sparsurf that is installed
from sparsurf.simulation.protocol import STAGES
from sparsurf.workflow import code_digests
from sparsurf.workflow.config import checked
from sparsurf.workflow.files_of_a_run import FilesOfARun
from sparsurf.workflow.files_of_pairs import FilesOfPairs
from sparsurf.workflow.jobs import one_of, use_this_library
from sparsurf.workflow.needs import needs
from sparsurf.workflow.outputs import figure, inside, shown

use_this_library()

if not {"proteins", "pairs"} & set(config):  # a config of one's own replaces the default study as a whole

    configfile: "config.yaml" if Path("config.yaml").is_file() else str(HOME / "config.yaml")


config = checked(config, workflow.configfiles, HOME)
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
JOBS = config["ensemble"]["jobs"]  # that share the frames of a trajectory
CHOOSING = ("paper", "paper_corrected")  # samplers that take the combination which is best in its range
THREADS = 8  # of a job that takes minutes; Snakemake scales them down to --cores

RUN = files.run
PROTEIN = f"{RUN}/{{protein}}"
CONFORMATION = f"{PROTEIN}/{{conformation}}"
SIMULATION = f"{PROTEIN}/simulation"
PAIR = f"{RUN}/pairs/{{pair}}"
LOGS = f"{RUN}/logs"
PROTEIN_LOGS = f"{LOGS}/{{protein}}"
CONFORMATION_LOGS = f"{PROTEIN_LOGS}/{{conformation}}"
PAIR_LOGS = f"{LOGS}/pairs/{{pair}}"
# What several rules read
KERNELS = inside(RUN, kernels=".kernels")
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
ENSEMBLE = inside(PROTEIN, table="ensemble.csv", over_time="residues_over_time.csv", residues="residues.csv")
DOTS = inside(PAIR, dots="propensity.csv")
FIRST_PAGE = inside(RUN, md="index.md", html="index.html", part=".front_page.html")  # part: opens the report


wildcard_constraints:
    protein=one_of(files.proteins),
    pair=one_of(config["pairs"]),
    conformation="[cf][0-9]+",
    stage=one_of(STAGES),
    k="[0-9]+",


ruleorder: summarise_pairs > write_front_page  # the first page of pairs alone


# What a run is asked for
rule all:
    default_target: True
    input:
        KERNELS["kernels"],  # at once: they are compiled while the frames are chosen
        files.of_proteins(),
        pairs.of_pairs(),


rule compare:
    input:
        f"{RUN}/compare.md",


rule complete_protein:  # each by itself, so that one that fails does not keep the others from being finished
    input:
        files.of_protein,
        files.of_conformations,
    output:
        touch(f"{PROTEIN}/.complete"),


rule complete_pair:
    input:
        pairs.of_pair,
    output:
        touch(f"{PAIR}/.complete"),


# From structures to conformations: fetched, simulated where asked for, chosen from the frames
rule compile_kernels:
    output:
        mark=KERNELS["kernels"],
    log:
        f"{LOGS}/compile_kernels.log",
    localrule: True  # as all that takes seconds: not worth a job of a cluster
    conda:
        "envs/study.yaml"
    threads: 2
    params:
        **made_by("compile_kernels.py"),
        descriptor=config["patches"]["descriptor"],
    message:
        "Compiling the kernels (once, half a minute)"
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


rule prepare_system:  # hydrogens, a box of water, ions; from here to judge_simulation only where `simulate` asks for it
    input:
        unpack(files.given),
    output:
        system=directory(f"{SIMULATION}/system"),
        contents=f"{SIMULATION}/system.json",
    log:
        f"{PROTEIN_LOGS}/prepare_system.log",
    wildcard_constraints:
        protein=one_of(files.simulated),
    conda:
        "envs/study.yaml"
    params:
        **made_by("prepare_system.py", "seed"),
        chosen=lambda wildcards: files.protein(wildcards).chosen,
        simulate=lambda wildcards: files.protein(wildcards).simulate,
    message:
        "Putting {wildcards.protein} into water"
    script:
        "scripts/prepare_system.py"


rule simulate_stage:  # minimise, nvt, npt, production: each begins where the one before ended
    input:
        unpack(files.stage_before),
        system=f"{SIMULATION}/system",
    output:
        folder=directory(f"{SIMULATION}/{{stage}}"),
    log:
        f"{PROTEIN_LOGS}/simulate_{{stage}}.log",
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("simulate_stage", files.nanoseconds),
    params:
        **made_by("simulate_stage.py", "seed"),
        simulate=lambda wildcards: files.protein(wildcards).simulate,
        stage="{stage}",
        work=f"{SIMULATION}/.running/{{stage}}",  # outlives a killed job: checkpoints
    message:
        "Simulating {wildcards.protein}: {wildcards.stage}"
    script:
        "scripts/simulate_stage.py"


rule judge_simulation:
    input:
        **{stage: f"{SIMULATION}/{stage}" for stage in STAGES},
        system=f"{SIMULATION}/system",
    output:
        **inside(SIMULATION, topology="topology.pdb", trajectory="trajectory.xtc"),
        **inside(SIMULATION, energies="energies.csv", motion="motion.csv", quality="quality.csv"),
        **figure(f"{PROTEIN}/figures/simulation", "Simulation", "simulation"),
    log:
        f"{PROTEIN_LOGS}/judge_simulation.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("judge_simulation.py"),
        simulate=lambda wildcards: files.protein(wildcards).simulate,
    message:
        "Quality of the simulation of {wildcards.protein}"
    script:
        "scripts/judge_simulation.py"


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
        **needs("choose_frames", files.megabytes),
    params:
        **made_by("choose_frames.py", "frames", "seed"),
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
        **made_by("measure_floors.py", "surface", "patches", "sampling", "evaluation", "seed"),
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
    priority: 2  # with all cores; the figures of one surface then share them with those of another
    conda:
        "envs/study.yaml"
    threads: THREADS
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
        **made_by("draw_figures.py", "patches", "sampling", "seed", figures=FIGURES),
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
        **made_by("take_minimal.py", "patches", "sampling", "evaluation", "minimal", "seed"),
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
        **made_by("draw_view.py", "patches", "sampling", "seed"),
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


rule compare_samplers:
    input:
        **(ROUGH_SURFACE | GRID | RANGES | FLOORS),
        structure=files.structure,
    output:
        **inside(CONFORMATION, table="compare.csv", pairs="compare_pairs.csv", fewer="compare_fewer.csv"),
        **inside(CONFORMATION, alone="compare_alone.csv", needed="needed.csv", page="compare.md"),
        **figure(f"{CONFORMATION}/figures/compare", "Samplers compared", "compare"),
    log:
        f"{CONFORMATION_LOGS}/compare_samplers.log",
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("compare_samplers", files.dots),
    params:
        **made_by("compare_samplers.py", "patches", "sampling", "evaluation", "compare", "seed"),
    message:
        "Comparing samplers on {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/compare_samplers.py"


# One combination over all frames of a trajectory
rule follow_frames:  # some of the frames; one job does them all unless ensemble.jobs says otherwise
    input:
        unpack(files.molecule),
        **KERNELS,
    output:
        rows=temp(f"{PROTEIN}/ensemble/{{k}}of{JOBS}.csv"),
    log:
        f"{PROTEIN_LOGS}/follow_frames_{{k}}of{JOBS}.log",
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("follow_frames", files.megabytes, 1 / (JOBS * config["ensemble"]["stride"])),
    params:
        **made_by("follow_frames.py", "surface", "patches", "sampling", "evaluation", "ensemble", "seed"),
        reading=lambda wildcards: files.protein(wildcards).reading,
        protein=lambda wildcards: wildcards.protein,
        part=lambda wildcards: (int(wildcards.k), JOBS),
        path_to_part=lambda wildcards, output: f"{output.rows}.part",  # outlives a killed job
    message:
        f"n_S and d of one combination over the frames of {{wildcards.protein}}, part {{wildcards.k}} of {JOBS}"
    script:
        "scripts/follow_frames.py"


rule follow_ensemble:
    input:
        unpack(files.molecule),
        rows=[f"{PROTEIN}/ensemble/{k}of{JOBS}.csv" for k in range(1, JOBS + 1)],
    output:
        **ENSEMBLE,
    log:
        f"{PROTEIN_LOGS}/follow_ensemble.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("follow_ensemble.py"),
        reading=lambda wildcards: files.protein(wildcards).reading,
    message:
        "All frames of {wildcards.protein} in one table"
    script:
        "scripts/follow_ensemble.py"


rule draw_ensemble:
    input:
        **ENSEMBLE,
    output:
        **figure(f"{PROTEIN}/figures/ensemble", "n_S and d over time", "ensemble"),
        residues=shown(f"{PROTEIN}/figures/residues.png", "Residues over time", "residues_over_time"),
        residues_svg=f"{PROTEIN}/figures/residues.svg",
    log:
        f"{PROTEIN_LOGS}/draw_ensemble.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        **made_by("draw_ensemble.py", "ensemble"),
    message:
        "Figure of {wildcards.protein} over time"
    script:
        "scripts/draw_ensemble.py"


# All conformations and proteins together
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


rule summarise_comparison:
    input:
        tables=files.every("compare.csv"),
    output:
        **inside(RUN, table="compare.csv", needed="compare_needed.csv", page="compare.md"),
        **figure(f"{RUN}/compare", "Over all proteins", "compare", "Samplers compared"),
    log:
        f"{LOGS}/summarise_comparison.log",
    localrule: True
    conda:
        "envs/study.yaml"
    params:
        **made_by("summarise_comparison.py"),
    message:
        "Comparing samplers over all conformations and proteins"
    script:
        "scripts/summarise_comparison.py"


# Pairs: what the patches of one partner say of the other's
rule make_partners:
    input:
        unpack(pairs.given),
        **KERNELS,
    output:
        **{f"surface_{side}": f"{PAIR}/surface_{side}.npz" for side in (1, 2)},
        **{f"structure_{side}": f"{PAIR}/structure_{side}.pdb" for side in (1, 2)},
    log:
        f"{PAIR_LOGS}/make_partners.log",
    wildcard_constraints:
        pair=one_of(pairs.alone),
    conda:
        "envs/study.yaml"
    params:
        **made_by("make_partners.py", "surface", "patches.D_link"),
        pair=pairs.pair,
    message:
        "Surfaces of both partners of {wildcards.pair}"
    script:
        "scripts/make_partners.py"


rule match_partners:
    input:
        unpack(pairs.partners("surface", "structure")),
        **KERNELS,
    output:
        **DOTS,
        **{f"ply_{side}": f"{PAIR}/partner_{side}.ply" for side in (1, 2)},
        **inside(PAIR, best="best_pairs.csv", agreement="agreement.csv", contacts="contacts.csv"),
        page=f"{PAIR}/pair.md",
    log:
        f"{PAIR_LOGS}/match_partners.log",
    conda:
        "envs/study.yaml"
    threads: THREADS
    params:
        **made_by("match_partners.py", "patches", "complementarity", "seed"),
        pair=pairs.pair,
    message:
        "Comparing the patches of both partners of {wildcards.pair}"
    script:
        "scripts/match_partners.py"


rule tabulate_pair_residues:
    input:
        unpack(pairs.partners("structure")),
        **DOTS,
    output:
        **{f"pdb_{side}": f"{PAIR}/partner_{side}.pdb" for side in (1, 2)},
        residues=f"{PAIR}/residues.csv",
    log:
        f"{PAIR_LOGS}/tabulate_pair_residues.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("tabulate_pair_residues.py"),
    message:
        "Propensity of the residues of {wildcards.pair}"
    script:
        "scripts/tabulate_pair_residues.py"


rule draw_pair:
    input:
        unpack(pairs.partners("surface")),
        **(DOTS | KERNELS),
    output:
        **figure(f"{PAIR}/book", "{pair}", "book", "Pairs"),
    log:
        f"{PAIR_LOGS}/draw_pair.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("draw_pair.py"),
    message:
        "Picture of both partners of {wildcards.pair}"
    script:
        "scripts/draw_pair.py"


rule draw_pair_views:
    input:
        unpack(pairs.partners("surface", "structure")),
        **(DOTS | KERNELS),
    output:
        view_1=shown(f"{PAIR}/view_1.html", "{pair}, partner 1 to turn", "pair_view", "Pairs"),
        view_2=shown(f"{PAIR}/view_2.html", "{pair}, partner 2 to turn", "pair_view", "Pairs"),
    log:
        f"{PAIR_LOGS}/draw_pair_views.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("draw_pair_views.py", "patches", "sampling", "seed"),
    message:
        "Pages of both partners of {wildcards.pair} to look at"
    script:
        "scripts/draw_pair_views.py"


rule thin_pair:
    input:
        unpack(pairs.partners("surface", "structure")),
        **KERNELS,
    output:
        **figure(f"{PAIR}/thinning", "{pair}, fewer centres", "thinning", "Pairs"),
        table=f"{PAIR}/thinning.csv",
    log:
        f"{PAIR_LOGS}/thin_pair.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("thin_pair.py", "patches", "complementarity", "seed"),
    message:
        "Maps of {wildcards.pair} from fewer centres"
    script:
        "scripts/thin_pair.py"


rule summarise_pairs:
    input:
        tables=expand(f"{PAIR}/agreement.csv", pair=config["pairs"]),
        pages=[] if files.proteins else pairs.pictures,
    output:
        **({} if files.proteins else FIRST_PAGE),
        **inside(pairs.folder, table="pairs.csv", page="pairs.md"),
        means=shown(f"{pairs.folder}/means.csv", "Means over pairs", "pairs", "Pairs"),
    log:
        f"{LOGS}/summarise_pairs.log",
    conda:
        "envs/study.yaml"
    params:
        **made_by("summarise_pairs.py"),
    message:
        "Agreement with the interface, over all pairs"
    script:
        "scripts/summarise_pairs.py"


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


# The page that leads to all of it
rule write_front_page:
    input:
        surfaces=f"{RUN}/surfaces.csv",
        grids=files.every("grid.csv"),
        best=files.every("best.json"),
        minimal=files.every("minimal.csv"),
        enough=files.every("enough.csv"),
        needed=[f"{RUN}/compare_needed.csv"] if config["compare"]["run"] else [],
        pages=lambda wildcards: files.led_to(wildcards) + pairs.pictures,
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
