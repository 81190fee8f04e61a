# Shared by the rules: the proteins of a run, their input files, and the final outputs.

import os
import re
import shutil
import time
from base64 import urlsafe_b64decode
from dataclasses import astuple

from sparsurf_study.batches.assignment import batched_structures, batches_of
from sparsurf import registry
from sparsurf_study import catalogue, manifest
from sparsurf_study.catalogue import first_of_each_rule
from sparsurf_study.workflow.code import versions_of_code
from sparsurf_study.config.check import check_config, proteins, sampled_proteins, with_absolute_paths
from sparsurf_study.workflow.jobs import let_jobs_import_packages
from sparsurf_study.workflow.ends import answers_of_run, reasons
from sparsurf_study.config.memory import memory_of_grid
from sparsurf_study.workflow.folders import hold_folder
from sparsurf_study.workflow.origin import note_config, origin_of
from sparsurf_study.config.conformations import first_column, has_one_model, without_zeros
from sparsurf_study.workflow.slurm import guard_slurm
from sparsurf_study.workflow.stopping import end_jobs_on_sigterm

# Before anything else: every process that Snakemake starts from here on inherits the path
let_jobs_import_packages(IS_CLONE)


# The prefix that a workflow which imports this one puts before its paths.
PREFIX = workflow.modifier.path_modifier.prefix or ""
# Jobs run on this machine and not on a cluster.
HERE = workflow.is_main_process and workflow.resource_settings.nodes is None
try:
    config = check_config(config, workflow.configfiles, HOME, HERE)
except ValueError as error:
    raise SystemExit(f"\n{error}\n") from None  # a traceback of Snakemake would hide the sentence
if PREFIX:  # Snakemake also puts it before inputs, but the files of the user lie where the config says
    config = with_absolute_paths(config)

EXCLUDED = {without_zeros(place) for place in config["exclude"]}
PROTEINS = {name: protein for name, protein in proteins(config).items() if name not in EXCLUDED}
BATCHED = {name: PROTEINS[name] for name in batched_structures(config)}
if BATCHED:  # Some structures also get the pages of a study, of the model that the batch takes.
    PROTEINS = {name: BATCHED[name] for name in config.get("pages", []) if name in BATCHED}
    PROTEINS = {
        name: protein if has_one_model(protein) else protein.model_copy(update={"model": protein.model or 1})
        for name, protein in PROTEINS.items()
        if f"{name}/*" not in EXCLUDED
    }
BATCHES = batches_of(config)
PAIRS = {name: pair for name, pair in config["pairs"].items() if f"pairs/{name}" not in EXCLUDED}
CHANGES = {name: forms for name, forms in config["changes"].items() if f"changes/{name}" not in EXCLUDED}
READY_SURFACES = [name for name, protein in PROTEINS.items() if protein.surface]
MOLECULES = [name for name in PROTEINS if name not in READY_SURFACES]
# The proteins that are sampled over the grid.
SAMPLED = [name for name in sampled_proteins(config) if name in PROTEINS]
SIMULATED = [name for name, protein in PROTEINS.items() if protein.simulate is not None]
DOWNLOADS = {name: protein.download for name, protein in PROTEINS.items() if protein.source}
SINGLE_FRAME = [name for name in MOLECULES if has_one_model(PROTEINS[name])]
SEVERAL_FRAMES = [name for name in MOLECULES if name not in SINGLE_FRAME]
RULES_OF_SAMPLING = ("distance_from_moved_centre", "chance_in_every_patch")
LENGTHS_OF_GLOSSARY = {key: config["patches"][key] for key in ("r_patch", "r_zernike")}
LENGTHS_OF_GLOSSARY["interface"] = config["complementarity"]["interface"]
# What the first page names; no parameter of its rule, since no result follows from it
config["origin"] = astuple(origin_of(config, workflow.configfiles, IS_CLONE))
RUN = Path(PREFIX, "results", config["run"])
BEGIN = time.time()
CODE = versions_of_code()
# Results that were changed since the end of the last run.
CHANGED = [*manifest.differing(RUN)] if workflow.is_main_process else []
SURFACE_AND_STRUCTURE = (("surface", "npz"), ("structure", "pdb"))
FIRST = "c1" if config["frames"]["selection"] == "clusters" else "f0"  # The conformation of a single frame.

# Several grids share the cores of this machine; the conformations of a trajectory are two at least
N_FRAMES = len(config["frames"]["selection"]) if isinstance(config["frames"]["selection"], list) else 2
MOVING = [name for name in SAMPLED if PROTEINS[name].trajectory or name in SIMULATED]
N_GRIDS = len(SAMPLED) + (N_FRAMES - 1) * len(MOVING)
# Its value is not part of a result, so that a study computed with other cores has the same numbers
GRID_THREADS = max(1, min(8, workflow.cores // N_GRIDS)) if HERE and workflow.cores and N_GRIDS else 8
GRID_MB = memory_of_grid(config) / 1e6  # The memory of all distances of a grid at the worst moment.


def any_of(names):
    """Regular expression of a wildcard that is one of `names`; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"


def in_report(path):
    """An output that Snakemake's report shows, with the title, category and caption that the catalogue has for it."""
    listed = catalogue.output_of(path.removeprefix("results/{run}/"))
    # Snakemake reads it beside the rules: in a hosted repository, only relative paths lead there
    above = HOME if IS_CLONE else ".." if workflow.current_basedir.get_filename() == "rules" else "."
    return report(
        path,
        caption=f"{above}/src/sparsurf_study/report/captions/{catalogue.caption_file(listed)}",
        category=catalogue.with_wildcards(listed.category or "<protein>"),
        subcategory="{conformation}" if "{conformation}" in path else None,
        labels={"result": catalogue.with_wildcards(listed.title)},
    )


def part_of(section, *keys):
    """Some keys of a section: a job is run again only where one of these changes."""
    return {key: config[section][key] for key in keys}


def of_protein(key):
    """Input function or parameter: what the config says about the protein of a job."""
    return lambda wildcards: getattr(PROTEINS[wildcards.protein], key)


def stamps_of(input_function):
    """Parameter: sizes and dates of the files of the user among some inputs, by path.

    Snakemake does not see an older file in place of another.
    """

    def stamps(wildcards):
        files = input_function(wildcards) or []
        paths = [files] if isinstance(files, str) else files.values() if isinstance(files, dict) else files
        found = {path: os.stat(path) for path in paths if not path.startswith(ours) and os.path.exists(path)}
        return {path: [status.st_size, status.st_mtime_ns] for path, status in found.items()}

    ours = f"results/{config['run']}/"
    return stamps


def changed_results(wildcards):
    """No files: what a killed job left, for which Snakemake does not look behind a checkpoint, and what was changed after the run."""
    if workflow.is_main_process:
        folder = Path(".snakemake", "incomplete")
        names = [
            "".join(part.removeprefix("@") for part in path.relative_to(folder).parts)
            for path in folder.rglob("*")
        ]
        workflow.dag.forcefiles.update(urlsafe_b64decode(name).decode() for name in names)
        changed = [Path(name) for name, _ in CHANGED]
        workflow.dag.forcefiles.update(
            str(RUN / part) for name in changed for part in (name, *name.parents[:-1])
        )
    return []


def begin_run():
    """Say what is replaced or was changed after the run; its checksums are of finished results, which are about to change."""
    if not hold_folder():
        raise SystemExit("\nAnother study runs in this folder; wait for it to end.\n")
    end_jobs_on_sigterm()
    if workflow.executor_plugin.name == "slurm":
        guard_slurm()
    for name, state in CHANGED:
        print(f"{RUN / name} is {state}: it is computed again.", file=sys.stderr, flush=True)
    path_to_config = Path(*workflow.configfiles[:1] or [HOME / "config.yaml"]).resolve()
    if RUN.exists() and not os.access(RUN, os.W_OK):
        raise SystemExit(f"\n{RUN} cannot be written. Make this folder writable and run again.\n")
    try:
        shutil.rmtree(RUN / ".ledger", ignore_errors=True)  # records of version 5
        if replaced := note_config(RUN, path_to_config):
            print(replaced, file=sys.stderr, flush=True)
        manifest.keep(RUN, {name for name, _ in CHANGED})
    except OSError as error:
        raise SystemExit(
            f"\n{error.filename or RUN}: {error.strerror}. Free or repair the disk and run again.\n"
        ) from None


def log_names(rules):
    """What the names of the logs of rules begin with; the rules themselves may be renamed by a workflow that imports this one."""
    return [Path(str(log)).stem.partition("{")[0] for rule in rules for log in rule.log]


def is_excluded(*place):
    """Whether the config excludes a protein, or one of its conformations, also with all of its protein."""
    return not {place[0], without_zeros("/".join(place))}.isdisjoint(EXCLUDED)


COMPARES_WITH_PAPER = "paper" in config and not is_excluded(config["paper"], "c1")


def all_conformations(protein):
    """Names of the conformations of a protein; Snakemake asks again once its frames are chosen."""
    if protein in READY_SURFACES:
        return ["c1"]
    if protein in SINGLE_FRAME:
        return [FIRST]
    frames = checkpoints.choose_frames.get(run=config["run"], protein=protein).output.frames
    return first_column(frames)


def title_of_page(wildcards):
    """Name of a conformation on its pages; a single structure goes by the name of its protein."""
    alone = wildcards.conformation == "c1" and wildcards.protein not in SEVERAL_FRAMES
    return wildcards.protein if alone else f"{wildcards.protein}/{wildcards.conformation}"


def conformations(protein):
    """Names of the conformations of a protein that are not excluded."""
    return [name for name in all_conformations(protein) if not is_excluded(protein, name)]


def has_several_frames(protein):
    """Whether a molecule has frames to choose from; Snakemake asks again once they are read."""
    if protein not in SEVERAL_FRAMES or is_excluded(protein, "*"):
        return False
    chosen = checkpoints.choose_frames.get(run=config["run"], protein=protein).output
    return len(first_column(chosen.projection)) > 1


def folder_of(place):
    """Folder of a conformation that the config names as protein (its first) or protein/conformation; None if there is none."""
    protein, _, conformation = place.partition("/")
    names = conformations(protein) if conformation else all_conformations(protein)[:1]
    wanted = without_zeros(place)
    found = [name for name in names if not conformation or without_zeros(f"{protein}/{name}") == wanted]
    return f"results/{config['run']}/{protein}/{found[0]}" if found else None


def every_conformation(file, names=tuple(PROTEINS)):
    """Input function: a file of every conformation of every protein, or of those of `names`."""
    return lambda wildcards: [
        f"results/{wildcards.run}/{protein}/{conformation}/{file}"
        for protein in names
        for conformation in conformations(protein)
    ]


def structure_file(wildcards):
    """The structure of a protein, local or downloaded."""
    protein = PROTEINS[wildcards.protein]
    if protein.source:
        return f"results/{wildcards.run}/{wildcards.protein}/download/{protein.download}"
    return protein.structure


def molecule_files(wildcards):
    """Structure and trajectory of a molecule, which may be simulated."""
    if wildcards.protein in SIMULATED:
        folder = f"results/{wildcards.run}/{wildcards.protein}/simulation"
        return {"structure": f"{folder}/topology.pdb", "trajectory": f"{folder}/trajectory.xtc"}
    trajectory = PROTEINS[wildcards.protein].trajectory
    return {"structure": structure_file(wildcards)} | ({"trajectory": trajectory} if trajectory else {})


def table_of_protein(wildcards):
    """The table with values of the residues of a protein; empty if it has none."""
    return PROTEINS[wildcards.protein].table or []


def structure_of_conformation(wildcards):
    """The structure of a conformation; empty for a ready surface."""
    if wildcards.protein in READY_SURFACES:
        return []
    return f"results/{wildcards.run}/{wildcards.protein}/{wildcards.conformation}/structure.pdb"


def if_sampled(file):
    """Input function: a result of the grid of a conformation; empty if its protein is not sampled."""
    return lambda wildcards: (
        f"results/{wildcards.run}/{wildcards.protein}/{wildcards.conformation}/{file}"
        if wildcards.protein in SAMPLED
        else []
    )


def ranges_of_paper_sampler(wildcards):
    """The table of best combinations, where the sampler of the minimal subset takes its parameters from it."""
    takes_them = config["minimal"]["sampler"] in registry.samplers_of_combinations()
    return if_sampled("ranges.csv")(wildcards) if takes_them else []


def structures_of_batch(wildcards):
    """Structures of a batch with their keys, by name."""
    return {
        name: {
            "path": BATCHED[name].structure,
            "table": BATCHED[name].table,
            "options": BATCHED[name].molecule_options,
        }
        for name in BATCHES[wildcards.batch]
    }


def files_of_batch(wildcards):
    """Files that a batch reads."""
    structures = structures_of_batch(wildcards).values()
    return list(
        dict.fromkeys(path for entry in structures for path in (entry["path"], entry["table"]) if path)
    )


def names_of_forms(wildcards):
    """Names of two forms that are compared."""
    return CHANGES[wildcards.comparison]


def compared_forms(wildcards):
    """Surfaces and structures of two forms that are compared; the tables of the names that there are if one of them is absent."""
    forms = names_of_forms(wildcards)
    folders = [folder_of(form) for form in forms]
    absent = [(n, form.partition("/")[0]) for n, form in enumerate(forms, 1) if not folders[n - 1]]
    if absent:
        return {f"names_{n}": f"results/{config['run']}/{protein}/frames.csv" for n, protein in absent}
    return {
        f"{kind}_{n}": f"{folder}/{kind}.{end}"
        for n, folder in enumerate(folders, 1)
        for kind, end in SURFACE_AND_STRUCTURE
    }


def entry_of_pair(wildcards):
    """Entry of a pair in the config, with the order of its partners, which Snakemake does not see."""
    return PAIRS[wildcards.pair]


def files_of_pair(wildcards):
    """Files of a pair that is given by structures: one of each partner, or one of both."""
    pair = entry_of_pair(wildcards)
    return pair.get("files") or [pair["complex"]]


def partner_files(wildcards):
    """Surfaces of both partners of a pair, and their structures where they have atoms."""
    own = f"results/{wildcards.run}/pairs/{wildcards.pair}"
    proteins_of_pair = entry_of_pair(wildcards).get("proteins")
    if not proteins_of_pair:
        return {
            f"{kind}_{n}": f"{own}/{kind}_{n}.{end}" for kind, end in SURFACE_AND_STRUCTURE for n in (1, 2)
        }
    return {
        f"{kind}_{n}": f"{folder_of(protein)}/{kind}.{end}"
        for n, protein in enumerate(proteins_of_pair, 1)
        for kind, end in SURFACE_AND_STRUCTURE
        if kind == "surface" or protein in MOLECULES
    }


def stage_before(wildcards):
    """Folder of the previous stage of a simulation; empty for the first."""
    before = {"nvt": "minimise", "npt": "nvt", "production": "npt"}.get(wildcards.stage)
    return f"results/{wildcards.run}/{wildcards.protein}/simulation/{before}" if before else []


# Final outputs, from the catalogue: `rule all` asks for one of each rule, and the first page lists all results


def paths(outputs, **wildcards):
    """Paths of outputs of the catalogue for values of their wildcards."""
    return [f"results/{config['run']}/{output.wildcards.format(**wildcards)}" for output in outputs]


def conditions_of_run():
    """Conditions of the catalogue that hold for the run."""
    holds = {"surfaces": PROTEINS, "sampled": SAMPLED, "compare": config["compare"]["run"] and SAMPLED}
    holds |= {"pairs": PAIRS, "paper": COMPARES_WITH_PAPER}
    return {name for name, value in holds.items() if value}


def conditions_of_protein(protein):
    """Conditions of the catalogue that hold for a protein, without waiting for the choice of its frames."""
    follows_frames = config["ensemble"]["run"] and protein in MOLECULES and not is_excluded(protein, "*")
    holds = {"simulated": protein in SIMULATED, "ensemble": follows_frames}
    return catalogue.conditions_of_protein(config, protein) | {name for name in holds if holds[name]}


def outputs_of_protein(protein):
    """Outputs of a protein beside those of its conformations; Snakemake asks again once its frames are chosen."""
    several = {"several_frames"} if has_several_frames(protein) else set()
    return catalogue.requested("<protein>", conditions_of_protein(protein) | several)


def ends_before_frames(wildcards):
    """An output of each rule of the proteins that does not wait for the choice of their frames."""
    ends = []
    for protein in PROTEINS:
        conditions = conditions_of_protein(protein) & {"simulated", "ensemble"}
        ends += paths(first_of_each_rule(catalogue.requested("<protein>", conditions)), protein=protein)
    return ends


def ends_of_protein(wildcards):
    """An output of each rule of a protein and of its conformations."""
    protein = wildcards.protein
    of_conformations = catalogue.requested("<protein>/<conformation>", conditions_of_protein(protein))
    ends = paths(first_of_each_rule(outputs_of_protein(protein)), protein=protein)
    for conformation in conformations(protein):
        ends += paths(first_of_each_rule(of_conformations), protein=protein, conformation=conformation)
    return ends


def ends_beside_proteins(wildcards):
    """An output of each rule of the pairs, of the forms that are compared, and of the comparison with the paper."""
    ends = []
    for pair in PAIRS:
        ends += paths(
            first_of_each_rule(
                catalogue.requested("pairs/<pair>", catalogue.conditions_of_pair(config, pair))
            ),
            pair=pair,
        )
    for comparison in CHANGES:
        ends += paths(
            first_of_each_rule(catalogue.requested("changes/<comparison>", ())), comparison=comparison
        )
    return ends + paths(first_of_each_rule(catalogue.requested("", conditions_of_run() & {"paper"})))


def first_page(wildcards):
    """The first page of a run, which needs all of its results."""
    return paths([catalogue.outputs()["index.html"]])


def deleted_results(wildcards):
    """Results that are missing although the run was closed: Snakemake looks for those alone that `all` asks for."""
    if not Path(PREFIX + first_page(wildcards)[0]).exists():
        return []
    closing = {"closing", "batches"} if BATCHED else {"closing"}
    patterns = paths(catalogue.requested("", closing), batch="{batch}")
    files = expand(patterns, batch=BATCHES) + results_before_pages(wildcards)
    return [path for path in files if not Path(PREFIX + path).exists()]


def results_before_pages(wildcards):
    """All outputs except the first page and its tables."""
    files = paths(catalogue.requested("", conditions_of_run()))
    for pair in PAIRS:
        files += paths(
            catalogue.requested("pairs/<pair>", catalogue.conditions_of_pair(config, pair)), pair=pair
        )
    for comparison in CHANGES:
        files += paths(catalogue.requested("changes/<comparison>", ()), comparison=comparison)
    for protein in PROTEINS:
        files += paths(outputs_of_protein(protein), protein=protein)
        of_conformations = catalogue.requested("<protein>/<conformation>", conditions_of_protein(protein))
        for conformation in conformations(protein):
            files += paths(of_conformations, protein=protein, conformation=conformation)
    return files
