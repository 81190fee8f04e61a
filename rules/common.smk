# Shared by the rules: the proteins of a run, their input files, and the final outputs.

import re
from dataclasses import astuple

from sparsurf_study.batches.assignment import batched_structures, batches_of
from sparsurf import kinds
from sparsurf_study.workflow.code_version import code_of
from sparsurf_study.workflow.config import check_config, proteins, sampled_proteins, with_absolute_paths
from sparsurf_study.workflow.jobs import let_jobs_import_packages
from sparsurf_study.workflow.memory import memory_of_grid
from sparsurf_study.report.figure_names import figures_with_svg
from sparsurf_study.workflow.origin import origin_of
from sparsurf_study.workflow.conformations import first_column, has_one_model, without_zeros

let_jobs_import_packages()


PREFIX = workflow.modifier.path_modifier.prefix or ""  # of a workflow that imports this one, for its paths
HERE = workflow.is_main_process and workflow.resource_settings.nodes is None  # jobs do not run on a cluster
try:
    config = check_config(config, workflow.configfiles, HOME, HERE)
except ValueError as error:
    raise SystemExit(f"\n{error}\n") from None
if PREFIX:  # is for results
    config = with_absolute_paths(config)

EXCLUDED = {without_zeros(place) for place in config["exclude"]}
PROTEINS = {name: protein for name, protein in proteins(config).items() if name not in EXCLUDED}
BATCHED = {name: PROTEINS[name] for name in batched_structures(config)}
if BATCHED:  # some of them get the pages of a study, too, of the model that the batch takes
    PROTEINS = {name: BATCHED[name] for name in config.get("pages", []) if name in BATCHED}
    PROTEINS = {
        name: protein if has_one_model(protein) else protein.model_copy(update={"model": protein.model or 1})
        for name, protein in PROTEINS.items()
        if f"{name}/*" not in EXCLUDED
    }
BATCHES = batches_of(config)
PAIRS = {name: pair for name, pair in config["pairs"].items() if f"pairs/{name}" not in EXCLUDED}
CHANGES = {name: forms for name, forms in config["changes"].items() if f"changes/{name}" not in EXCLUDED}
FIGURES_WITH_SVG = figures_with_svg("paper" in config)
READY_SURFACES = [name for name, protein in PROTEINS.items() if protein.surface]
MOLECULES = [name for name in PROTEINS if name not in READY_SURFACES]
SAMPLED = [name for name in sampled_proteins(config) if name in PROTEINS]  # over the grid; the others are not
SIMULATED = [name for name, protein in PROTEINS.items() if protein.simulate is not None]
DOWNLOADS = {name: protein.download for name, protein in PROTEINS.items() if protein.source}
SINGLE_FRAME = [name for name in MOLECULES if has_one_model(PROTEINS[name])]
SEVERAL_FRAMES = [name for name in MOLECULES if name not in SINGLE_FRAME]
RULES_OF_SAMPLING = ("distance_from_moved_centre", "chance_in_every_patch")
LENGTHS_OF_GLOSSARY = {key: config["patches"][key] for key in ("r_patch", "r_zernike")}
LENGTHS_OF_GLOSSARY["interface"] = config["complementarity"]["interface"]
# What the first page names; no parameter of its rule, since no result follows from it
config["origin"] = astuple(origin_of(config, workflow.configfiles))
SURFACE_AND_STRUCTURE = (("surface", "npz"), ("structure", "pdb"))
FIRST = "c1" if config["frames"]["selection"] == "clusters" else "f0"  # conformation of a single frame

# Several grids share the cores of this machine; the conformations of a trajectory are two at least
N_FRAMES = len(config["frames"]["selection"]) if isinstance(config["frames"]["selection"], list) else 2
MOVING = [name for name in SAMPLED if PROTEINS[name].trajectory or name in SIMULATED]
N_GRIDS = len(SAMPLED) + (N_FRAMES - 1) * len(MOVING)
GRID_THREADS = max(1, min(8, workflow.cores // N_GRIDS)) if HERE and workflow.cores and N_GRIDS else 8
GRID_MB = memory_of_grid(config) / 1e6  # all distances of a grid, at the worst moment


def any_of(names):
    """Regular expression of a wildcard that is one of `names`; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"


def in_report(path, title, category="{protein}", caption=None):
    """An output that Snakemake's report shows; `caption` names a file of src/sparsurf_study/report/captions/, by default that of the output's name."""
    return report(
        path,
        caption=HOME / f"src/sparsurf_study/report/captions/{caption or Path(path).stem}.rst",
        category=category,
        subcategory="{conformation}" if "{conformation}" in path else None,
        labels={"result": title},
    )


def part_of(section, *keys):
    """Some keys of a section: a job is run again only where one of these changes."""
    return {key: config[section][key] for key in keys}


def log_names(rules):
    """What the names of the logs of rules begin with; the rules themselves may be renamed by a workflow that imports this one."""
    return [Path(str(log)).stem.partition("{")[0] for rule in rules for log in rule.log]


def is_excluded(*place):
    """Whether the config excludes a protein, or one of its conformations."""
    return without_zeros("/".join(place)) in EXCLUDED


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
    takes_them = config["minimal"]["sampler"] in kinds.samplers_of_combinations()
    return if_sampled("ranges.csv")(wildcards) if takes_them else []


# Final outputs: `rule all` asks for the ends, which no other rule reads; the first page lists all results


def outputs(*of_rules, **wildcards):
    """Paths of outputs of rules for values of their wildcards, each a name or a list of names."""
    paths = [path for files in of_rules for path in expand(files, run=config["run"], **wildcards)]
    # Snakemake puts the prefix of a module before it again
    return [path.removeprefix(PREFIX) for path in paths]


def follows_frames(protein):
    """Whether all frames of a molecule are followed with one combination."""
    return config["ensemble"]["run"] and protein in MOLECULES and not is_excluded(protein, "*")


def ends_before_frames(wildcards):
    """Ends of the proteins that do not wait for the choice of their frames."""
    ends = [
        path for protein in SIMULATED for path in outputs(rules.judge_simulation.output.png, protein=protein)
    ]
    followed = [protein for protein in PROTEINS if follows_frames(protein)]
    return ends + (outputs(rules.follow_ensemble.output[0], protein=followed) if followed else [])


def ends_of_protein(protein):
    """Ends of one protein and of its conformations."""
    ends = [rules.draw_roughness.output.page, rules.draw_view.output.page]
    if protein in MOLECULES:
        ends += [rules.tabulate_residues.output.table]
    if protein in SAMPLED:
        ends += [rules.draw_figures.output[0]]
    else:
        ends += [rules.measure_floors.output.floors]
    if config["compare"]["run"] and protein in SAMPLED:
        ends += [rules.compare_samplers.output[0]]
    of_conformations = outputs(*ends, protein=protein, conformation=conformations(protein))
    return of_conformations + outputs(*drawings_of_protein(protein), protein=protein)


def drawings_of_protein(protein):
    """Outputs of the rules that draw the frames of a protein."""
    if not has_several_frames(protein):
        return []
    return [rules.draw_frames.output, *([rules.draw_ensemble.output] if config["ensemble"]["run"] else [])]


def ends_beside_proteins(wildcards):
    """Ends of the pairs, of the forms that are compared, and of the comparison with the paper."""
    ends = outputs(rules.draw_pair.output[0], pair=PAIRS) if PAIRS else []
    with_residues = [pair for pair in PAIRS if not {*PAIRS[pair].get("proteins", ())} & {*READY_SURFACES}]
    ends += outputs(rules.tabulate_pair_residues.output[0], pair=with_residues) if with_residues else []
    ends += outputs(rules.draw_changes.output[0], comparison=CHANGES) if CHANGES else []
    if "paper" in config and not is_excluded(config["paper"], "c1"):
        ends += outputs(rules.reproduce_paper.output.page)
    return ends


def first_page(wildcards):
    """The first page of a run, which needs all of its results."""
    return outputs(closing_rule().output.page)


def closing_rule():
    """The rule that writes the first page."""
    return rules.summarise_batches if BATCHED else rules.close_run


def deleted_results(wildcards):
    """Results that are missing although the run was closed: Snakemake looks for those alone that `all` asks for."""
    if not Path(PREFIX + first_page(wildcards)[0]).exists():
        return []
    files = outputs(closing_rule().output) + results_before_pages(wildcards)
    files += outputs(rules.analyse_batch.output, batch=BATCHES) if BATCHED else []
    return [path for path in files if not Path(PREFIX + path).exists()]


def results_before_pages(wildcards):
    """All outputs except the first page and its tables."""
    files = [rules.summarise_surfaces.output] if PROTEINS else []
    if SAMPLED:
        files += [rules.summarise_best.output]
    if config["compare"]["run"] and SAMPLED:
        files += [rules.summarise_comparison.output]
    if PAIRS:
        files += [rules.summarise_pairs.output]
    of_proteins = [path for protein in PROTEINS for path in outputs_of_protein(protein)]
    return outputs(*files) + outputs_beside_proteins() + of_proteins


def outputs_of_protein(protein):
    """Outputs of one protein and of its conformations."""
    files = [rules.choose_frames.output] if protein in MOLECULES else []
    if protein in SIMULATED:
        files += [rules.judge_simulation.output[name] for name in ("energies", "motion", "quality", "png")]
    files += [rules.follow_ensemble.output] if follows_frames(protein) else []
    of_conformations = [
        path
        for conformation in conformations(protein)
        for path in outputs(*outputs_of_conformation(protein), protein=protein, conformation=conformation)
    ]
    return outputs(*files, *drawings_of_protein(protein), protein=protein) + of_conformations


def outputs_of_conformation(protein):
    """Outputs of each conformation of a protein, with wildcards."""
    files = [rules.read_surface.output if protein in READY_SURFACES else rules.compute_surface.output]
    files += [rules.measure_roughness.output, rules.draw_roughness.output]
    files += [rules.measure_floors.output.floors]
    files += [rules.select_minimal_subset.output, rules.draw_view.output]
    if protein in MOLECULES:
        files += [rules.tabulate_residues.output]
    if protein in SAMPLED:
        files += [rules.evaluate_grid.output, rules.tabulate_best.output, rules.draw_figures.output]
    if config["compare"]["run"] and protein in SAMPLED:
        files += [rules.compare_samplers.output]
    return files


def outputs_beside_proteins():
    """Outputs of the pairs, of the forms that are compared, and of the comparison with the paper."""
    files = []
    for pair in PAIRS:
        files += outputs(rules.match_partners.output, rules.draw_pair.output, pair=pair)
        if not {*PAIRS[pair].get("proteins", ())} & {*READY_SURFACES}:
            files += outputs(rules.tabulate_pair_residues.output, pair=pair)
    if CHANGES:
        files += outputs(rules.compare_forms.output, rules.draw_changes.output, comparison=CHANGES)
    if "paper" in config and not is_excluded(config["paper"], "c1"):
        files += outputs(rules.reproduce_paper.output)
    return files
