# Trajectory or structure or surface -> frames -> surface -> roughness -> grid -> tables, figures, report.
# Read from top to bottom in the order the data flow. Every key of the config: config.yaml.

import sys
from pathlib import Path
from types import SimpleNamespace

from snakemake.utils import min_version

sys.path.append(str(Path(workflow.basedir) / "scripts"))
from sparsurf import InputError
from sparsurf.config import check
from sparsurf.download import file_name, source
from sparsurf.workflow import conformations_of, digest, made, one_of

min_version("9.0")


if "proteins" not in config:  # a config of one's own replaces the default study as a whole

    configfile: "config.yaml"


try:
    config = check(config, workflow.configfiles)
except InputError as error:
    raise SystemExit(f"\n{error}\n") from None

RUN = f"results/{config['run']}"
SURFACES = [name for name, protein in config["proteins"].items() if "surface" in protein]
FETCHED = {name: file_name(source(each)) for name, each in config["proteins"].items() if source(each)}
MOLECULES = [name for name in config["proteins"] if name not in SURFACES]


wildcard_constraints:
    protein=one_of(config["proteins"]),
    conformation="[cf][0-9]+",


def molecule(wildcards):
    """Input function: the files of a structure or trajectory."""
    name = wildcards.protein
    files = {
        key: config["proteins"][name][key]
        for key in ("structure", "trajectory")
        if key in config["proteins"][name]
    }
    return files | ({"structure": f"{RUN}/{name}/download/{FETCHED[name]}"} if name in FETCHED else {})


def of_conformations(*files):
    """Input function: `files` of every conformation of a protein, known once its frames are chosen."""

    def expand_all(wildcards):
        name = wildcards.protein
        found = ["c1"]
        if name in MOLECULES:
            found = conformations_of(checkpoints.choose_frames.get(protein=name).output.frames)
        return [f"{RUN}/{name}/{conformation}/{file}" for conformation in found for file in files]

    return expand_all


FOLLOWED = MOLECULES if config["ensemble"]["run"] else []
PROMISED = ["surface.ply", "ranges.csv", "ranges.md", "best.json", "best.md", "minimal.csv", "minimal.ply"]
PROMISED += [f"figures/fig{k}.{end}" for k in range(1, 6) for end in ("png", "svg")]
PROMISED += ["compare.csv"] if config["compare"]["run"] else []


rule all:
    default_target: True
    input:
        expand(f"{RUN}/{{protein}}/.complete", protein=config["proteins"]),
        f"{RUN}/summary.csv",
        [f"{RUN}/verdict.md"] if "paper" in config else [],
        [f"{RUN}/compare.md"] if config["compare"]["run"] else [],


rule compare:
    input:
        f"{RUN}/compare.md",


rule complete_protein:  # each by itself, so that one that fails does not keep the others from being finished
    input:
        lambda wildcards: (
            expand(
                f"{RUN}/{{protein}}/figures/frames.{{end}}", end=["png", "svg"], protein=wildcards.protein
            )
            if wildcards.protein in MOLECULES
            else []
        ),
        lambda wildcards: (
            f"{RUN}/{wildcards.protein}/figures/ensemble.png" if wildcards.protein in FOLLOWED else []
        ),
        of_conformations(*PROMISED),
    output:
        touch(f"{RUN}/{{protein}}/.complete"),


rule compile_kernels:
    output:
        mark=f"{RUN}/.kernels",
    log:
        f"{RUN}/logs/compile_kernels.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("compile_kernels.py"),
    message:
        "Compiling the kernels (once, half a minute)"
    script:
        "scripts/compile_kernels.py"


rule fetch_structure:
    output:
        structure=f"{RUN}/{{protein}}/download/{{file}}",
        record=f"{RUN}/{{protein}}/download/{{file}}.json",
    log:
        f"{RUN}/logs/{{protein}}/fetch_{{file}}.log",
    wildcard_constraints:
        protein=one_of(FETCHED),
        file=one_of(FETCHED.values()),
    conda:
        "envs/study.yaml"
    params:
        protein=lambda wildcards: config["proteins"][wildcards.protein],
        code=digest("fetch_structure.py"),
    message:
        "Fetching {wildcards.protein}"
    script:
        "scripts/fetch_structure.py"


checkpoint choose_frames:
    input:
        unpack(molecule),
    output:
        frames=f"{RUN}/{{protein}}/frames.csv",
        silhouette=f"{RUN}/{{protein}}/silhouette.csv",
        projection=f"{RUN}/{{protein}}/projection.csv",
        explained=f"{RUN}/{{protein}}/explained.csv",
        structures=directory(f"{RUN}/{{protein}}/structures"),
    log:
        f"{RUN}/logs/{{protein}}/choose_frames.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    params:
        protein=lambda wildcards: config["proteins"][wildcards.protein],
        settings=config["frames"] | {"seed": config["seed"]},
        code=digest("choose_frames.py"),
    message:
        "Choosing the conformations of {wildcards.protein}"
    script:
        "scripts/choose_frames.py"


rule make_surface:
    input:
        structures=f"{RUN}/{{protein}}/structures",
        kernels=f"{RUN}/.kernels",
    output:
        structure=f"{RUN}/{{protein}}/{{conformation}}/structure.pdb",
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
        dms=f"{RUN}/{{protein}}/{{conformation}}/surface.dms",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/make_surface.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    params:
        settings=config["surface"],
        d_link=config["patches"]["D_link"],
        code=digest("make_surface.py"),
    message:
        "Molecular surface of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/make_surface.py"


rule take_surface:
    input:
        lambda wildcards: config["proteins"][wildcards.protein]["surface"],
    output:
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/take_surface.log",
    wildcard_constraints:
        protein=one_of(SURFACES),
    conda:
        "envs/study.yaml"
    params:
        code=digest("take_surface.py"),
    message:
        "Reading the surface of {wildcards.protein}"
    script:
        "scripts/take_surface.py"


rule measure_roughness:
    input:
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
        kernels=f"{RUN}/.kernels",
    output:
        roughness=f"{RUN}/{{protein}}/{{conformation}}/roughness.csv",
        ply=f"{RUN}/{{protein}}/{{conformation}}/surface.ply",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/measure_roughness.log",
    conda:
        "envs/study.yaml"
    params:
        patches=config["patches"],
        code=digest("measure_roughness.py"),
    message:
        "Roughness of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/measure_roughness.py"


rule evaluate_grid:
    input:
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
        roughness=f"{RUN}/{{protein}}/{{conformation}}/roughness.csv",
        kernels=f"{RUN}/.kernels",
    output:
        grid=f"{RUN}/{{protein}}/{{conformation}}/grid.csv",
        distances=f"{RUN}/{{protein}}/{{conformation}}/distances.npz",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/evaluate_grid.log",
    conda:
        "envs/study.yaml"
    threads: workflow.cores
    params:
        settings={key: config[key] for key in ("patches", "sampling", "evaluation", "seed")},
        code=digest("evaluate_grid.py"),
    message:
        "Sampling and comparing {wildcards.protein}/{wildcards.conformation} over the grid"
    script:
        "scripts/evaluate_grid.py"


rule tabulate_best:
    input:
        grid=f"{RUN}/{{protein}}/{{conformation}}/grid.csv",
        distances=f"{RUN}/{{protein}}/{{conformation}}/distances.npz",
    output:
        ranges=report(
            f"{RUN}/{{protein}}/{{conformation}}/ranges.csv",
            caption="scripts/report/ranges.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Best combination per range of n_S"},
        ),
        ranges_md=f"{RUN}/{{protein}}/{{conformation}}/ranges.md",
        best=f"{RUN}/{{protein}}/{{conformation}}/best.json",
        best_md=f"{RUN}/{{protein}}/{{conformation}}/best.md",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/tabulate_best.log",
    conda:
        "envs/study.yaml"
    params:
        settings=config["tables"],
        code=digest("tabulate_best.py"),
    message:
        "Best combinations of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/tabulate_best.py"


rule take_minimal:
    input:
        **(
            {"ranges": f"{RUN}/{{protein}}/{{conformation}}/ranges.csv"}
            if config["minimal"]["sampler"].startswith("paper")
            else {}
        ),
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
        roughness=f"{RUN}/{{protein}}/{{conformation}}/roughness.csv",
        kernels=f"{RUN}/.kernels",
    output:
        table=f"{RUN}/{{protein}}/{{conformation}}/minimal.csv",
        ply=f"{RUN}/{{protein}}/{{conformation}}/minimal.ply",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/take_minimal.log",
    conda:
        "envs/study.yaml"
    params:
        settings={key: config[key] for key in ("patches", "sampling", "evaluation", "minimal", "seed")},
        code=digest("take_minimal.py"),
    message:
        "Minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/take_minimal.py"


rule compare_samplers:
    input:
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
        roughness=f"{RUN}/{{protein}}/{{conformation}}/roughness.csv",
        grid=f"{RUN}/{{protein}}/{{conformation}}/grid.csv",
        ranges=f"{RUN}/{{protein}}/{{conformation}}/ranges.csv",
        kernels=f"{RUN}/.kernels",
    output:
        table=f"{RUN}/{{protein}}/{{conformation}}/compare.csv",
        needed=f"{RUN}/{{protein}}/{{conformation}}/needed.csv",
        page=f"{RUN}/{{protein}}/{{conformation}}/compare.md",
        png=report(
            f"{RUN}/{{protein}}/{{conformation}}/figures/compare.png",
            caption="scripts/report/compare.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Samplers compared"},
        ),
        svg=f"{RUN}/{{protein}}/{{conformation}}/figures/compare.svg",
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/compare_samplers.log",
    conda:
        "envs/study.yaml"
    threads: workflow.cores
    params:
        settings={key: config[key] for key in ("patches", "sampling", "evaluation", "seed")}
        | {"compare": {key: value for key, value in config["compare"].items() if key != "run"}},
        code=digest("compare_samplers.py"),
    message:
        "Comparing samplers on {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/compare_samplers.py"


rule summarise_comparison:
    input:
        lambda wildcards: [
            path
            for name in config["proteins"]
            for path in of_conformations("compare.csv")(SimpleNamespace(protein=name))
        ],
    output:
        table=f"{RUN}/compare.csv",
        needed=f"{RUN}/compare_needed.csv",
        page=f"{RUN}/compare.md",
        png=report(
            f"{RUN}/compare.png",
            caption="scripts/report/compare.rst",
            category="Samplers compared",
            labels={"result": "Over all proteins"},
        ),
        svg=f"{RUN}/compare.svg",
    log:
        f"{RUN}/logs/summarise_comparison.log",
    conda:
        "envs/study.yaml"
    params:
        code=digest("summarise_comparison.py"),
    message:
        "Comparing samplers over all conformations and proteins"
    script:
        "scripts/summarise_comparison.py"


rule draw_frames:
    input:
        frames=f"{RUN}/{{protein}}/frames.csv",
        projection=f"{RUN}/{{protein}}/projection.csv",
        silhouette=f"{RUN}/{{protein}}/silhouette.csv",
        explained=f"{RUN}/{{protein}}/explained.csv",
    output:
        png=report(
            f"{RUN}/{{protein}}/figures/frames.png",
            caption="scripts/report/frames.rst",
            category="{protein}",
            labels={"result": "Frames and conformations"},
        ),
        svg=f"{RUN}/{{protein}}/figures/frames.svg",
    log:
        f"{RUN}/logs/{{protein}}/draw_frames.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    params:
        code=digest("draw_frames.py"),
    message:
        "Figure of the frames of {wildcards.protein}"
    script:
        "scripts/draw_frames.py"


rule draw_figures:
    input:
        surface=f"{RUN}/{{protein}}/{{conformation}}/surface.npz",
        roughness=f"{RUN}/{{protein}}/{{conformation}}/roughness.csv",
        grid=f"{RUN}/{{protein}}/{{conformation}}/grid.csv",
        best=f"{RUN}/{{protein}}/{{conformation}}/best.json",
        kernels=f"{RUN}/.kernels",
    output:
        png1=report(
            f"{RUN}/{{protein}}/{{conformation}}/figures/fig1.png",
            caption="scripts/report/fig1.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Fig. 1, roughness"},
        ),
        png2=report(
            f"{RUN}/{{protein}}/{{conformation}}/figures/fig2.png",
            caption="scripts/report/fig2.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Fig. 2, number of dots"},
        ),
        png3=report(
            f"{RUN}/{{protein}}/{{conformation}}/figures/fig3.png",
            caption="scripts/report/fig3.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Fig. 3, d over the grid"},
        ),
        png4=report(
            f"{RUN}/{{protein}}/{{conformation}}/figures/fig4.png",
            caption="scripts/report/fig4.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Fig. 4, rough and flat patches"},
        ),
        png5=report(
            f"{RUN}/{{protein}}/{{conformation}}/figures/fig5.png",
            caption="scripts/report/fig5.rst",
            category="{protein}",
            subcategory="{conformation}",
            labels={"result": "Fig. 5, surfaces"},
        ),
        svgs=expand(f"{RUN}/{{{{protein}}}}/{{{{conformation}}}}/figures/fig{{k}}.svg", k=range(1, 6)),
    log:
        f"{RUN}/logs/{{protein}}/{{conformation}}/draw_figures.log",
    conda:
        "envs/study.yaml"
    threads: workflow.cores
    params:
        settings={key: config[key] for key in ("patches", "sampling", "seed")},
        code=digest("draw_figures.py"),
    message:
        "Figures of {wildcards.protein}/{wildcards.conformation}"
    script:
        "scripts/draw_figures.py"


SUMMED = ["best.json", "ranges.csv", "grid.csv", "roughness.csv", "surface.npz"]


rule summarise_run:
    input:
        lambda wildcards: [
            path
            for name in config["proteins"]
            for path in of_conformations(*SUMMED)(SimpleNamespace(protein=name))
        ],
    output:
        summary=report(
            f"{RUN}/summary.csv",
            caption="scripts/report/summary.rst",
            category="All surfaces",
            labels={"result": "Best combination per surface and range of n_S"},
        ),
        surfaces=f"{RUN}/surfaces.csv",
        relation=f"{RUN}/relation.csv",
        markdown=f"{RUN}/summary.md",
        png=report(
            f"{RUN}/summary.png",
            caption="scripts/report/summary.rst",
            category="All surfaces",
            labels={"result": "Best parameters against mean roughness"},
        ),
        svg=f"{RUN}/summary.svg",
    log:
        f"{RUN}/logs/summarise_run.log",
    conda:
        "envs/study.yaml"
    params:
        patches=config["patches"],
        seed=config["seed"],
        code=digest("summarise_run.py"),
    message:
        "Best parameters against mean roughness, over all surfaces"
    script:
        "scripts/summarise_run.py"


rule follow_ensemble:
    input:
        unpack(molecule),
        kernels=f"{RUN}/.kernels",
    output:
        table=f"{RUN}/{{protein}}/ensemble.csv",
    log:
        f"{RUN}/logs/{{protein}}/follow_ensemble.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    threads: workflow.cores
    params:
        protein=lambda wildcards: config["proteins"][wildcards.protein],
        settings={
            key: config[key] for key in ("surface", "patches", "sampling", "evaluation", "ensemble", "seed")
        },
        code=digest("follow_ensemble.py"),
    message:
        "n_S and d of one combination over the frames of {wildcards.protein}"
    script:
        "scripts/follow_ensemble.py"


rule draw_ensemble:
    input:
        table=f"{RUN}/{{protein}}/ensemble.csv",
    output:
        png=report(
            f"{RUN}/{{protein}}/figures/ensemble.png",
            caption="scripts/report/ensemble.rst",
            category="{protein}",
            labels={"result": "n_S and d over time"},
        ),
        svg=f"{RUN}/{{protein}}/figures/ensemble.svg",
    log:
        f"{RUN}/logs/{{protein}}/draw_ensemble.log",
    wildcard_constraints:
        protein=one_of(MOLECULES),
    conda:
        "envs/study.yaml"
    params:
        combination=config["ensemble"]["combination"],
        code=digest("draw_ensemble.py"),
    message:
        "Figure of {wildcards.protein} over time"
    script:
        "scripts/draw_ensemble.py"


if "paper" in config:  # the name of the protein that is the paper's A1

    rule reproduce_paper:
        input:
            **{
                key: f"{RUN}/{config['paper']}/c1/{file}"
                for key, file in {
                    "surface": "surface.npz",
                    "roughness": "roughness.csv",
                    "grid": "grid.csv",
                    "ranges": "ranges.csv",
                    "best": "best.json",
                }.items()
            },
            kernels=f"{RUN}/.kernels",
        output:
            verdict=f"{RUN}/verdict.md",
            html=report(
                f"{RUN}/verdict.html",
                caption="scripts/report/verdict.rst",
                category="The paper",
                labels={"result": "Claim by claim"},
            ),
            rows=report(
                f"{RUN}/paper_rows.csv",
                caption="scripts/report/verdict.rst",
                category="The paper",
                labels={"result": "Table I, row by row"},
            ),
            selected=f"{RUN}/paper_as_published.csv",
            links=f"{RUN}/paper_links.csv",
            defects=f"{RUN}/paper_defects.csv",
            bins=f"{RUN}/paper_roughness.csv",
        log:
            f"{RUN}/logs/reproduce_paper.log",
        conda:
            "envs/study.yaml"
        threads: workflow.cores
        params:
            settings={key: config[key] for key in ("patches", "sampling", "evaluation", "seed")}
            | {"made": made(config, config["paper"])},
            name=f"{config['paper']}/c1",
            code=digest("reproduce_paper.py"),
        message:
            "Comparing with the paper"
        script:
            "scripts/reproduce_paper.py"
