# Trajectory or structure or surface -> frames -> surface -> roughness -> grid -> tables, figures, report.
# Read from top to bottom in the order the data flow. Every key of the config: config.yaml.

import sys
from pathlib import Path

from snakemake.utils import min_version

min_version("9.0")


report: "scripts/report/first.rst"


HOME = Path(workflow.current_basedir)  # where this file lies, also where another workflow imports it
sys.path.insert(0, str(HOME / "scripts"))  # before a sparsurf that is installed
from sparsurf.simulation.protocol import STAGES, length_ns, stage_before
from sparsurf.workflow.config import checked
from sparsurf.workflow.code_digests import digest
from sparsurf.workflow.jobs import conformations_of, one_of, use_this_library
from sparsurf.workflow.needs import is_small, megabytes, needs, thousand_dots
from sparsurf.workflow.protein import proteins

use_this_library()

if not {"proteins", "pairs"} & set(config):  # a config of one's own replaces the default study as a whole

    configfile: "config.yaml" if Path("config.yaml").is_file() else str(HOME / "config.yaml")


config = checked(config, workflow.configfiles, HOME)

# The figures of a conformation: scripts/sparsurf/report/figures/<name>.py, captioned in scripts/report/<name>.rst
FIGURES = {
    "roughness": "Fig. 1, roughness",
    "number_of_dots": "Fig. 2, number of dots",
    "d_over_grid": "Fig. 3, d over the grid",
    "rough_and_flat": "Fig. 4, rough and flat patches",
    "subsets": "Fig. 5, surfaces",
}
PROTEINS = proteins(config)
SURFACES = [name for name, protein in PROTEINS.items() if protein.surface]
MOLECULES = [name for name in PROTEINS if name not in SURFACES]
FETCHED = {name: protein.download for name, protein in PROTEINS.items() if protein.source}
SIMULATED = [name for name, protein in PROTEINS.items() if protein.simulate is not None]
JOBS = config["ensemble"]["jobs"]  # that share the frames of a trajectory
CHOOSING = ("paper", "paper_corrected")  # samplers that take the combination which is best in its range
FEW_FRAMES = not SIMULATED and all(
    is_small("choose_frames", megabytes(PROTEINS[name].files.values())) for name in MOLECULES
)
THREADS = 8  # of a job that takes minutes; Snakemake scales them down to --cores

RUN = f"results/{config['run']}"
PROTEIN = f"{RUN}/{{protein}}"
CONFORMATION = f"{PROTEIN}/{{conformation}}"
CONFORMATION_PDB = f"{PROTEIN}/structures/{{conformation}}.pdb"
LOGS = f"{RUN}/logs"
PROTEIN_LOGS = f"{LOGS}/{{protein}}"
CONFORMATION_LOGS = f"{PROTEIN_LOGS}/{{conformation}}"
SIMULATION = f"{PROTEIN}/simulation"
KERNELS = {"kernels": f"{RUN}/.kernels"}
FRAMES = {key: f"{PROTEIN}/{key}.csv" for key in ("frames", "silhouette", "projection", "explained")}
ENSEMBLE = {
    "table": f"{PROTEIN}/ensemble.csv",
    "over_time": f"{PROTEIN}/residues_over_time.csv",
    "residues": f"{PROTEIN}/residues.csv",
}
SURFACE = {"surface": f"{CONFORMATION}/surface.npz"}
ROUGH_SURFACE = SURFACE | {"roughness": f"{CONFORMATION}/roughness.csv"} | KERNELS
GRID = {"grid": f"{CONFORMATION}/grid.csv"}
DISTANCES = {"distances": f"{CONFORMATION}/distances.npz"}
RANGES = {"ranges": f"{CONFORMATION}/ranges.csv"}
BEST = {"best": f"{CONFORMATION}/best.json"}
BINS = {"bins": f"{CONFORMATION}/rough_and_flat.csv"}
FLOORS = {"floors": f"{CONFORMATION}/floors.csv"}
ENOUGH = {"enough": f"{CONFORMATION}/enough.csv"}
FIRST_PAGE = {"md": f"{RUN}/index.md", "html": f"{RUN}/index.html"}
FIRST_PAGE["part"] = f"{RUN}/.front_page.html"  # scripts/report/first.rst shows it


wildcard_constraints:
    protein=one_of(PROTEINS),
    pair=one_of(config["pairs"]),
    conformation="[cf][0-9]+",


def protein(wildcards):
    """What the config says about a protein."""
    return PROTEINS[wildcards.protein]


def simulate(wildcards):
    """How a protein is simulated."""
    return protein(wildcards).simulate


def nanoseconds(wildcards):
    """Simulated time of a stage."""
    return length_ns(wildcards.stage, simulate(wildcards))


def settings(*sections):
    """Sections of the config that a rule depends on."""
    return {section: config[section] for section in sections}


def given(wildcards):
    """Input function: the files that the config names for a molecule, or that were fetched."""
    own = protein(wildcards)
    fetched = {"structure": f"{RUN}/{wildcards.protein}/download/{own.download}"} if own.source else {}
    return own.files | fetched


def structure(wildcards):
    """Input function: the structure of a conformation; none of a ready surface."""
    return f"{CONFORMATION}/structure.pdb" if wildcards.protein in MOLECULES else []


def atoms(wildcards):
    """Input function: the structure of a conformation, and its trajectory where it is a frame of one; or neither."""
    if wildcards.protein not in MOLECULES:
        return {}
    files = molecule(wildcards)
    frames = {"frames": FRAMES["frames"].format(**wildcards)} if "trajectory" in files else {}
    return (files if frames else {}) | frames | {"own": f"{CONFORMATION}/structure.pdb".format(**wildcards)}


def molecule(wildcards):
    """Input function: the files of a structure or trajectory that enter the study, simulated or not."""
    if wildcards.protein in SIMULATED:
        folder = SIMULATION.format(protein=wildcards.protein)
        return {"structure": f"{folder}/topology.pdb", "trajectory": f"{folder}/trajectory.xtc"}
    return given(wildcards)


def before(wildcards):
    """Input function: the stage of a simulation that ends where another begins."""
    stage = stage_before(wildcards.stage)
    return {"before": f"{SIMULATION}/{stage}".format(**wildcards)} if stage else {}


def of_conformations(*files):
    """Input function: `files` of every conformation of a protein, or of all; known once the frames are chosen."""

    def expand_all(wildcards):
        found = []
        for name in [wildcards.protein] if "protein" in wildcards.keys() else PROTEINS:
            frames = name in MOLECULES and checkpoints.choose_frames.get(protein=name).output.frames
            own = [file for file in files if name in MOLECULES or file not in OF_ATOMS]
            for conformation in conformations_of(frames) if frames else ["c1"]:
                found += [f"{RUN}/{name}/{conformation}/{file}" for file in own]
        return found

    return expand_all


def led_to(wildcards):
    """Input function: what the first page leads to."""
    figures = [f"figures/{name}.png" for name in FIGURES]
    found = of_conformations("view.html", "enough.csv", "ranges.csv", "residues.csv", *figures)(wildcards)
    found += [path.format(protein=name) for name in MOLECULES for path in OF_MOLECULE if path.endswith("png")]
    found += [f"{RUN}/{file}" for file in ("summary.csv", "summary.png")]
    found += [f"{RUN}/compare.png"] if config["compare"]["run"] else []
    return found + ([f"{RUN}/verdict.html"] if "paper" in config else []) + OF_PAIRS


def dots(wildcards):
    """Dots of a conformation in thousands, from the size of the file that it comes from: what its jobs need grows so."""
    surface = protein(wildcards).surface
    return thousand_dots([surface or CONFORMATION_PDB.format(**wildcards)], of_dots=bool(surface))


def frames_mb(wildcards):
    """Size in MB of the files of a structure or trajectory."""
    return megabytes(molecule(wildcards).values())


def shown(path, label, caption, category=None):
    """`path`, shown in the report under `label` among the results of its protein, with scripts/report/<caption>.rst."""
    category = category or ("{protein}" if "{protein}" in path else "All surfaces")
    within = {"subcategory": "{conformation}"} if "{conformation}" in path else {}
    within |= {"category": category, "labels": {"result": label}}
    caption = f"scripts/report/{caption}.rst"
    return report(path, caption=caption if (HOME / caption).is_file() else None, **within)


OF_ATOMS = ["residues.csv"]  # what a ready surface has not
# What every protein of some kind, and every conformation, must have in the end.
OF_MOLECULE = [f"{PROTEIN}/figures/frames.png", f"{PROTEIN}/figures/frames.svg"]
OF_SIMULATED = [f"{PROTEIN}/figures/simulation.png"]
OF_MOLECULE += [
    f"{PROTEIN}/figures/{name}.png" for name in ("ensemble", "residues") if config["ensemble"]["run"]
]
OF_CONFORMATION = "surface.ply ranges.csv ranges.md best.json best.md minimal.csv minimal.ply view.html residues.csv".split()
OF_CONFORMATION += [f"figures/{name}.{kind}" for name in FIGURES for kind in ("png", "svg")]
OF_CONFORMATION += ["compare.csv"] if config["compare"]["run"] else []
OF_PAIR = ["book.png", "view_1.html", "view_2.html"]
OF_PAIR += ["thinning.png"] if config["complementarity"]["thinning"]["run"] else []
OF_PAIRS = expand(f"{RUN}/pairs/{{pair}}/{{file}}", pair=config["pairs"], file=OF_PAIR)


localrules:  # of a few seconds each: not worth a job of a cluster
    all,
    compare,
    complete_protein,
    compile_kernels,
    fetch_structure,
    draw_frames,
    draw_ensemble,
    summarise_run,
    summarise_comparison,
    write_front_page,


ruleorder: summarise_pairs > write_front_page  # the first page of pairs alone


rule all:
    default_target: True
    input:
        KERNELS["kernels"],  # at once: they are compiled while the frames are chosen
        expand(f"{PROTEIN}/.complete", protein=PROTEINS),
        FIRST_PAGE["html"],
        FIRST_PAGE["part"],
        [f"{RUN}/summary.csv"] if PROTEINS else [],
        expand(f"{RUN}/pairs/{{pair}}/.complete", pair=config["pairs"]),
        [f"{RUN}/pairs/pairs.md"] if config["pairs"] else [],
        [f"{RUN}/verdict.md"] if "paper" in config else [],
        [f"{RUN}/compare.md"] if config["compare"]["run"] else [],


rule compare:
    input:
        f"{RUN}/compare.md",


rule complete_protein:  # each by itself, so that one that fails does not keep the others from being finished
    input:
        lambda wildcards: OF_MOLECULE if wildcards.protein in MOLECULES else [],
        lambda wildcards: OF_SIMULATED if wildcards.protein in SIMULATED else [],
        of_conformations(*OF_CONFORMATION),
    output:
        touch(f"{PROTEIN}/.complete"),


rule compile_kernels:
    output:
        mark=f"{RUN}/.kernels",
    log:
        f"{LOGS}/compile_kernels.log",
    conda:
        "envs/study.yaml"
    threads: 2
    params:
        descriptor=config["patches"]["descriptor"],
        code=digest("compile_kernels.py"),
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
        protein=one_of(FETCHED),
        file=one_of(FETCHED.values()),
    conda:
        "envs/study.yaml"
    params:
        url=lambda wildcards: protein(wildcards).source,
        sha256=lambda wildcards: protein(wildcards).sha256,
        code=digest("fetch_structure.py"),
    message:
        "Fetching {wildcards.protein}"
    script:
        "scripts/fetch_structure.py"


rule prepare_system:  # hydrogens, a box of water, ions; from here to judge_simulation only where `simulate` asks for it
    input:
        unpack(given),
    output:
        system=directory(f"{SIMULATION}/system"),
        contents=f"{SIMULATION}/system.json",
    log:
        f"{PROTEIN_LOGS}/prepare_system.log",
    wildcard_constraints:
        protein=one_of(SIMULATED),
    conda:
        "envs/study.yaml"
    params:
        chosen=lambda wildcards: protein(wildcards).chosen,
        simulate=simulate,
        settings=settings("seed"),
        code=digest("prepare_system.py"),
    message:
        "Putting {wildcards.protein} into water"
    script:
        "scripts/prepare_system.py"


rule simulate_stage:  # minimise, nvt, npt, production: each begins where the one before ended
    input:
        unpack(before),
        system=f"{SIMULATION}/system",
    output:
        folder=directory(f"{SIMULATION}/{{stage}}"),
    log:
        f"{PROTEIN_LOGS}/simulate_{{stage}}.log",
    wildcard_constraints:
        protein=one_of(SIMULATED),
        stage=one_of(STAGES),
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("simulate_stage", nanoseconds),
    params:
        simulate=simulate,
        settings=settings("seed"),
        stage="{stage}",
        work=f"{SIMULATION}/.running/{{stage}}",  # outlives a killed job: checkpoints
        code=digest("simulate_stage.py"),
    message:
        "Simulating {wildcards.protein}: {wildcards.stage}"
    script:
        "scripts/simulate_stage.py"


rule judge_simulation:
    input:
        **{stage: f"{SIMULATION}/{stage}" for stage in STAGES},
        system=f"{SIMULATION}/system",
    output:
        topology=f"{SIMULATION}/topology.pdb",
        trajectory=f"{SIMULATION}/trajectory.xtc",
        energies=f"{SIMULATION}/energies.csv",
        motion=f"{SIMULATION}/motion.csv",
        quality=f"{SIMULATION}/quality.csv",
        png=shown(f"{PROTEIN}/figures/simulation.png", "Simulation", "simulation"),
        svg=f"{PROTEIN}/figures/simulation.svg",
    log:
        f"{PROTEIN_LOGS}/judge_simulation.log",
    wildcard_constraints:
        protein=one_of(SIMULATED),
    conda:
        "envs/study.yaml"
    params:
        simulate=simulate,
        code=digest("judge_simulation.py"),
    message:
        "Quality of the simulation of {wildcards.protein}"
    script:
        "scripts/judge_simulation.py"


checkpoint choose_frames:
    input:
        unpack(molecule),
    output:
        **FRAMES,
        structures=directory(f"{PROTEIN}/structures"),
    log:
        f"{PROTEIN_LOGS}/choose_frames.log",
    localrule: FEW_FRAMES
    conda:
        "envs/study.yaml"
    resources:
        **needs("choose_frames", frames_mb),
    params:
        reading=lambda wildcards: protein(wildcards).reading,
        settings=settings("frames", "seed"),
        code=digest("choose_frames.py"),
    message:
        "Choosing the conformations of {wildcards.protein}"
    script:
        "scripts/choose_frames.py"


rule draw_frames:
    input:
        **FRAMES,
    output:
        png=shown(f"{PROTEIN}/figures/frames.png", "Frames and conformations", "frames"),
        svg=f"{PROTEIN}/figures/frames.svg",
    log:
        f"{PROTEIN_LOGS}/draw_frames.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("draw_frames.py"),
    message:
        "Figure of the frames of {wildcards.protein}"
    script:
        "scripts/draw_frames.py"


rule make_surface:
    input:
        **KERNELS,
        structures=f"{PROTEIN}/structures",
    output:
        structure=f"{CONFORMATION}/structure.pdb",
        surface=f"{CONFORMATION}/surface.npz",
        dms=f"{CONFORMATION}/surface.dms",
    log:
        f"{CONFORMATION_LOGS}/make_surface.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    resources:
        **needs("make_surface", dots),
    params:
        settings=settings("surface") | {"D_link": config["patches"]["D_link"]},
        code=digest("make_surface.py"),
    message:
        "Molecular surface of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/make_surface.py"


rule take_surface:
    input:
        surface=lambda wildcards: protein(wildcards).surface,
    output:
        surface=f"{CONFORMATION}/surface.npz",
    log:
        f"{CONFORMATION_LOGS}/take_surface.log",
    wildcard_constraints:
        protein=one_of(SURFACES),
    conda:
        "envs/study.yaml"
    resources:
        **needs("take_surface", dots),
    params:
        code=digest("take_surface.py"),
    message:
        "Reading the surface of {wildcards.protein}"
    script:
        "scripts/take_surface.py"


rule measure_roughness:
    input:
        **(SURFACE | KERNELS),
    output:
        roughness=f"{CONFORMATION}/roughness.csv",
        ply=f"{CONFORMATION}/surface.ply",
    log:
        f"{CONFORMATION_LOGS}/measure_roughness.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("measure_roughness", dots),
    params:
        settings=settings("patches"),
        code=digest("measure_roughness.py"),
    message:
        "Roughness of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_roughness.py"


rule measure_floors:
    input:
        unpack(atoms),
        **ROUGH_SURFACE,
    output:
        **FLOORS,
    log:
        f"{CONFORMATION_LOGS}/measure_floors.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("measure_floors", dots),
    params:
        reading=lambda wildcards: protein(wildcards).reading,
        settings=settings("surface", "patches", "sampling", "evaluation", "seed"),
        code=digest("measure_floors.py"),
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
    priority: 1  # with all cores; the figures of one surface then share them with those of another
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("evaluate_grid", dots),
    params:
        settings=settings("patches", "sampling", "evaluation", "seed"),
        code=digest("evaluate_grid.py"),
    message:
        "Sampling and comparing {wildcards.protein}/{wildcards.conformation} over the grid"
    script:
        "scripts/evaluate_grid.py"


rule tabulate_best:
    input:
        **(GRID | DISTANCES | FLOORS),
    output:
        ranges=shown(f"{CONFORMATION}/ranges.csv", "Best combination per range of n_S", "ranges"),
        ranges_md=f"{CONFORMATION}/ranges.md",
        best=f"{CONFORMATION}/best.json",
        best_md=f"{CONFORMATION}/best.md",
    log:
        f"{CONFORMATION_LOGS}/tabulate_best.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("tabulate_best", dots),
    params:
        settings=settings("tables"),
        code=digest("tabulate_best.py"),
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
    conda:
        "envs/study.yaml"
    resources:
        **needs("draw_figures", dots),
    params:
        settings=settings("patches", "sampling", "seed"),
        code=digest("draw_figures.py", *(f"sparsurf/report/figures/{name}.py" for name in FIGURES)),
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
        table=f"{CONFORMATION}/minimal.csv",
        ply=f"{CONFORMATION}/minimal.ply",
    log:
        f"{CONFORMATION_LOGS}/take_minimal.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("take_minimal", dots),
    params:
        settings=settings("patches", "sampling", "evaluation", "minimal", "seed"),
        code=digest("take_minimal.py"),
    message:
        "Minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/take_minimal.py"


rule draw_view:
    input:
        **(ROUGH_SURFACE | GRID | BEST),
        minimal=f"{CONFORMATION}/minimal.csv",
        structure=structure,
    output:
        page=shown(f"{CONFORMATION}/view.html", "Turn, sample and pick dots", "view"),
    log:
        f"{CONFORMATION_LOGS}/draw_view.log",
    conda:
        "envs/study.yaml"
    resources:
        **needs("draw_view", dots),
    params:
        settings=settings("patches", "sampling", "seed"),
        code=digest("draw_view.py"),
    message:
        "Page of {wildcards.protein}/{wildcards.conformation} to look at"
    script:
        "scripts/draw_view.py"


rule tabulate_residues:
    input:
        **ROUGH_SURFACE,
        minimal=f"{CONFORMATION}/minimal.csv",
        structure=f"{CONFORMATION}/structure.pdb",
    output:
        table=shown(f"{CONFORMATION}/residues.csv", "Residue by residue", "residues"),
        pdb=f"{CONFORMATION}/structure_roughness.pdb",
        cif=f"{CONFORMATION}/structure_roughness.cif",
    log:
        f"{CONFORMATION_LOGS}/tabulate_residues.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    resources:
        **needs("tabulate_residues", dots),
    params:
        code=digest("tabulate_residues.py"),
    message:
        "Residues of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/tabulate_residues.py"


rule compare_samplers:
    input:
        **(ROUGH_SURFACE | GRID | RANGES | FLOORS),
        structure=structure,
    output:
        table=f"{CONFORMATION}/compare.csv",
        needed=f"{CONFORMATION}/needed.csv",
        pairs=f"{CONFORMATION}/compare_pairs.csv",
        fewer=f"{CONFORMATION}/compare_fewer.csv",
        alone=f"{CONFORMATION}/compare_alone.csv",
        page=f"{CONFORMATION}/compare.md",
        png=shown(f"{CONFORMATION}/figures/compare.png", "Samplers compared", "compare"),
        svg=f"{CONFORMATION}/figures/compare.svg",
    log:
        f"{CONFORMATION_LOGS}/compare_samplers.log",
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("compare_samplers", dots),
    params:
        settings=settings("patches", "sampling", "evaluation", "seed")
        | {"compare": {key: value for key, value in config["compare"].items() if key != "run"}},
        code=digest("compare_samplers.py"),
    message:
        "Comparing samplers on {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/compare_samplers.py"


rule summarise_comparison:
    input:
        tables=of_conformations("compare.csv"),
    output:
        table=f"{RUN}/compare.csv",
        needed=f"{RUN}/compare_needed.csv",
        page=f"{RUN}/compare.md",
        png=shown(f"{RUN}/compare.png", "Over all proteins", "compare", "Samplers compared"),
        svg=f"{RUN}/compare.svg",
    log:
        f"{LOGS}/summarise_comparison.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("summarise_comparison.py"),
    message:
        "Comparing samplers over all conformations and proteins"
    script:
        "scripts/summarise_comparison.py"


rule summarise_run:
    input:
        results=of_conformations(
            "best.json", "ranges.csv", "grid.csv", "roughness.csv", "surface.npz", "enough.csv"
        ),
    output:
        summary=shown(f"{RUN}/summary.csv", "Best combination per surface and range of n_S", "summary"),
        surfaces=f"{RUN}/surfaces.csv",
        relation=f"{RUN}/relation.csv",
        markdown=f"{RUN}/summary.md",
        png=shown(f"{RUN}/summary.png", "Best parameters against mean roughness", "summary"),
        svg=f"{RUN}/summary.svg",
    log:
        f"{LOGS}/summarise_run.log",
    conda:
        "envs/study.yaml"
    params:
        settings=settings("patches", "seed"),
        code=digest("summarise_run.py"),
    message:
        "Best parameters against mean roughness, over all surfaces"
    script:
        "scripts/summarise_run.py"


rule write_front_page:
    input:
        surfaces=f"{RUN}/surfaces.csv",
        grids=of_conformations("grid.csv"),
        best=of_conformations("best.json"),
        minimal=of_conformations("minimal.csv"),
        enough=of_conformations("enough.csv"),
        needed=[f"{RUN}/compare_needed.csv"] if config["compare"]["run"] else [],
        pages=led_to,
    output:
        **FIRST_PAGE,
    log:
        f"{LOGS}/write_front_page.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("write_front_page.py"),
    message:
        "First page of the run"
    script:
        "scripts/write_front_page.py"


rule follow_frames:  # some of the frames; one job does them all unless ensemble.jobs says otherwise
    input:
        unpack(molecule),
        **KERNELS,
    output:
        rows=temp(f"{PROTEIN}/ensemble/{{k}}of{JOBS}.csv"),
    log:
        f"{PROTEIN_LOGS}/follow_frames_{{k}}of{JOBS}.log",
    wildcard_constraints:
        k="[0-9]+",
    conda:
        "envs/study.yaml"
    threads: THREADS
    resources:
        **needs("follow_frames", frames_mb, 1 / (JOBS * config["ensemble"]["stride"])),
    params:
        reading=lambda wildcards: protein(wildcards).reading,
        protein=lambda wildcards: wildcards.protein,
        part=lambda wildcards: (int(wildcards.k), JOBS),
        settings=settings("surface", "patches", "sampling", "evaluation", "ensemble", "seed"),
        path_to_part=lambda wildcards, output: f"{output.rows}.part",  # outlives a killed job
        code=digest("follow_frames.py"),
    message:
        "n_S and d of one combination over the frames of {wildcards.protein}, part {wildcards.k} of {JOBS}"
    script:
        "scripts/follow_frames.py"


rule follow_ensemble:
    input:
        unpack(molecule),
        rows=[f"{PROTEIN}/ensemble/{k}of{JOBS}.csv" for k in range(1, JOBS + 1)],
    output:
        **ENSEMBLE,
    log:
        f"{PROTEIN_LOGS}/follow_ensemble.log",
    conda:
        "envs/study.yaml"
    params:
        reading=lambda wildcards: protein(wildcards).reading,
        code=digest("follow_ensemble.py"),
    message:
        "All frames of {wildcards.protein} in one table"
    script:
        "scripts/follow_ensemble.py"


rule draw_ensemble:
    input:
        **ENSEMBLE,
    output:
        png=shown(f"{PROTEIN}/figures/ensemble.png", "n_S and d over time", "ensemble"),
        svg=f"{PROTEIN}/figures/ensemble.svg",
        residues=shown(f"{PROTEIN}/figures/residues.png", "Residues over time", "residues_over_time"),
        residues_svg=f"{PROTEIN}/figures/residues.svg",
    log:
        f"{PROTEIN_LOGS}/draw_ensemble.log",
    conda:
        "envs/study.yaml"
    params:
        settings=settings("ensemble"),
        code=digest("draw_ensemble.py"),
    message:
        "Figure of {wildcards.protein} over time"
    script:
        "scripts/draw_ensemble.py"


PAIR = f"{RUN}/pairs/{{pair}}"
PAIR_LOGS = f"{LOGS}/pairs/{{pair}}"
DOTS = {"dots": f"{PAIR}/propensity.csv"}


def has_atoms(pair):
    """Whether both partners of a pair come with atoms."""
    return not set(config["pairs"][pair].get("proteins", ())) & set(SURFACES)


def files_of_pair(wildcards):
    """Input function: the structures of a pair that is no pair of proteins."""
    pair = config["pairs"][wildcards.pair]
    return (
        {"complex": pair["complex"]} if "complex" in pair else dict(zip(("first", "second"), pair["files"]))
    )


def partners_of(*kinds):
    """Input function: surfaces and, where there are atoms, structures of both partners."""

    def files(wildcards):
        found = {}
        for side, name in enumerate(config["pairs"][wildcards.pair].get("proteins", (None, None)), 1):
            folder, end = f"{RUN}/pairs/{wildcards.pair}", f"_{side}"
            if name:
                frames = name in MOLECULES and checkpoints.choose_frames.get(protein=name).output.frames
                folder, end = f"{RUN}/{name}/{conformations_of(frames)[0] if frames else 'c1'}", ""
            found |= {f"surface_{side}": f"{folder}/surface{end}.npz"} if "surface" in kinds else {}
            if "structure" in kinds and name not in SURFACES:
                found[f"structure_{side}"] = f"{folder}/structure{end}.pdb"
        return found

    return files


def of_pair(wildcards):
    """Input function: what a pair must have in the end."""
    files = ["pair.md", *OF_PAIR] + (["residues.csv"] if has_atoms(wildcards.pair) else [])
    return [f"{RUN}/pairs/{wildcards.pair}/{file}" for file in files]


rule complete_pair:
    input:
        of_pair,
    output:
        touch(f"{PAIR}/.complete"),


rule make_partners:
    input:
        unpack(files_of_pair),
        **KERNELS,
    output:
        **{f"surface_{side}": f"{PAIR}/surface_{side}.npz" for side in (1, 2)},
        **{f"structure_{side}": f"{PAIR}/structure_{side}.pdb" for side in (1, 2)},
    log:
        f"{PAIR_LOGS}/make_partners.log",
    conda:
        "envs/study.yaml"
    params:
        pair=lambda wildcards: config["pairs"][wildcards.pair],
        settings=settings("surface") | {"D_link": config["patches"]["D_link"]},
        code=digest("make_partners.py"),
    message:
        "Surfaces of both partners of {wildcards.pair}"
    script:
        "scripts/make_partners.py"


rule match_partners:
    input:
        unpack(partners_of("surface", "structure")),
        **KERNELS,
    output:
        **DOTS,
        **{f"ply_{side}": f"{PAIR}/partner_{side}.ply" for side in (1, 2)},
        best=f"{PAIR}/best_pairs.csv",
        agreement=f"{PAIR}/agreement.csv",
        contacts=f"{PAIR}/contacts.csv",
        page=f"{PAIR}/pair.md",
    log:
        f"{PAIR_LOGS}/match_partners.log",
    conda:
        "envs/study.yaml"
    threads: THREADS
    params:
        pair=lambda wildcards: config["pairs"][wildcards.pair],
        settings=settings("patches", "complementarity", "seed"),
        code=digest("match_partners.py"),
    message:
        "Comparing the patches of both partners of {wildcards.pair}"
    script:
        "scripts/match_partners.py"


rule tabulate_pair_residues:
    input:
        unpack(partners_of("structure")),
        **DOTS,
    output:
        **{f"pdb_{side}": f"{PAIR}/partner_{side}.pdb" for side in (1, 2)},
        residues=f"{PAIR}/residues.csv",
    log:
        f"{PAIR_LOGS}/tabulate_pair_residues.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("tabulate_pair_residues.py"),
    message:
        "Propensity of the residues of {wildcards.pair}"
    script:
        "scripts/tabulate_pair_residues.py"


rule draw_pair:
    input:
        unpack(partners_of("surface")),
        **(DOTS | KERNELS),
    output:
        png=shown(f"{PAIR}/book.png", "{pair}", "book", "Pairs"),
        svg=f"{PAIR}/book.svg",
    log:
        f"{PAIR_LOGS}/draw_pair.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("draw_pair.py"),
    message:
        "Picture of both partners of {wildcards.pair}"
    script:
        "scripts/draw_pair.py"


rule draw_pair_views:
    input:
        unpack(partners_of("surface", "structure")),
        **(DOTS | KERNELS),
    output:
        view_1=shown(f"{PAIR}/view_1.html", "{pair}, partner 1 to turn", "pair_view", "Pairs"),
        view_2=shown(f"{PAIR}/view_2.html", "{pair}, partner 2 to turn", "pair_view", "Pairs"),
    log:
        f"{PAIR_LOGS}/draw_pair_views.log",
    conda:
        "envs/study.yaml"
    params:
        settings=settings("patches", "sampling", "seed"),
        code=digest("draw_pair_views.py"),
    message:
        "Pages of both partners of {wildcards.pair} to look at"
    script:
        "scripts/draw_pair_views.py"


rule thin_pair:
    input:
        unpack(partners_of("surface", "structure")),
        **KERNELS,
    output:
        table=f"{PAIR}/thinning.csv",
        png=shown(f"{PAIR}/thinning.png", "{pair}, fewer centres", "thinning", "Pairs"),
        svg=f"{PAIR}/thinning.svg",
    log:
        f"{PAIR_LOGS}/thin_pair.log",
    conda:
        "envs/study.yaml"
    params:
        settings=settings("patches", "complementarity", "seed"),
        code=digest("thin_pair.py"),
    message:
        "Maps of {wildcards.pair} from fewer centres"
    script:
        "scripts/thin_pair.py"


rule summarise_pairs:
    input:
        tables=expand(f"{PAIR}/agreement.csv", pair=config["pairs"]),
        pages=[] if PROTEINS else OF_PAIRS,
    output:
        **({} if PROTEINS else FIRST_PAGE),
        table=f"{RUN}/pairs/pairs.csv",
        means=shown(f"{RUN}/pairs/means.csv", "Means over pairs", "pairs", "Pairs"),
        page=f"{RUN}/pairs/pairs.md",
    log:
        f"{LOGS}/summarise_pairs.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("summarise_pairs.py"),
    message:
        "Agreement with the interface, over all pairs"
    script:
        "scripts/summarise_pairs.py"


if "paper" in config:  # the name of the protein that is the paper's A1
    A1 = {"protein": config["paper"], "conformation": "c1"}

    rule reproduce_paper:
        input:
            **{
                key: path.format(**A1)
                for key, path in (ROUGH_SURFACE | GRID | RANGES | BEST | BINS | FLOORS | ENOUGH).items()
            },
        output:
            verdict=f"{RUN}/verdict.md",
            html=shown(f"{RUN}/verdict.html", "Claim by claim", "verdict", "The paper"),
            rows=shown(f"{RUN}/paper_rows.csv", "Table I, row by row", "verdict", "The paper"),
            runs=f"{RUN}/paper_as_published.csv",
            places=f"{RUN}/paper_places.csv",
            links=f"{RUN}/paper_links.csv",
            defects=f"{RUN}/paper_defects.csv",
            family=f"{RUN}/paper_family.csv",
        log:
            f"{LOGS}/reproduce_paper.log",
        conda:
            "envs/study.yaml"
        threads: THREADS
        params:
            settings=settings("surface", "patches", "sampling", "evaluation", "seed"),
            path_to_surface=PROTEINS[config["paper"]].surface,
            name="/".join(A1.values()),
            code=digest("reproduce_paper.py"),
        message:
            "Comparing with the paper"
        script:
            "scripts/reproduce_paper.py"
