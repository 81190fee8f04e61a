# Shared by the rules: the proteins of a run, their input files, and the final outputs.

import re

from sparsurf.batches.assignment import TABLES, batched_structures, batches_of
from sparsurf.settings import SAMPLERS_OF_COMBINATIONS
from sparsurf.workflow.code_version import METHOD, REPORT
from sparsurf.workflow.config import check_config, proteins, sampled_proteins
from sparsurf.workflow.jobs import let_jobs_import_library
from sparsurf.workflow.memory import memory_of_grid
from sparsurf.workflow.names import FIGURES, PAPER_FIGURES
from sparsurf.workflow.conformations import first_column, has_one_model, same_conformation, without_zeros

let_jobs_import_library()

if not {"proteins", "pairs"} & config.keys():  # a config that names neither changes the default study

    configfile: HOME / "config.yaml"


HERE = workflow.is_main_process and workflow.resource_settings.nodes is None  # jobs do not run on a cluster
try:
    config = check_config(config, workflow.configfiles, HOME, HERE)
except ValueError as error:
    raise SystemExit(f"\n{error}\n") from None

EXCLUDED = {without_zeros(place) for place in config["exclude"]}
PROTEINS = {name: protein for name, protein in proteins(config).items() if name not in EXCLUDED}
BATCHED = {
    name: PROTEINS[name] for name in batched_structures(config)
}  # structures that are analysed in batches
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
READY_SURFACES = [name for name, protein in PROTEINS.items() if protein.surface]
MOLECULES = [name for name in PROTEINS if name not in READY_SURFACES]
SAMPLED = [name for name in sampled_proteins(config) if name in PROTEINS]  # over the grid; the others are not
SIMULATED = [name for name, protein in PROTEINS.items() if protein.simulate is not None]
DOWNLOADS = {name: protein.download for name, protein in PROTEINS.items() if protein.source}
SINGLE_FRAME = [name for name in MOLECULES if has_one_model(PROTEINS[name])]
SEVERAL_FRAMES = [name for name in MOLECULES if name not in SINGLE_FRAME]
CHANGES_FILES = (
    "changes.csv",
    "changes.png",
    "changed_1.pdb",
    "changed_2.pdb",
    "view_1.html",
    "view_2.html",
)
RULES_OF_SAMPLING = ("distance_from_moved_centre", "chance_in_every_patch")
SURFACE_AND_STRUCTURE = (("surface", "npz"), ("structure", "pdb"))
FIRST = "c1" if config["frames"]["selection"] == "clusters" else "f0"  # conformation of a single frame

GRID_MB = memory_of_grid(config) / 1e6  # all distances of a grid, at the worst moment


def any_of(names):
    """Regular expression of a wildcard that is one of `names`; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"


def in_report(path, title, category="{protein}", caption=None):
    """An output that Snakemake's report shows; `caption` names a file of report/captions/, by default that of the output's name."""
    return report(
        path,
        caption=HOME / f"src/sparsurf/report/captions/{caption or Path(path).stem}.rst",
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
    found = [name for name in names if not conformation or same_conformation(name, conformation)]
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


def frames_around_conformation(wildcards):
    """The trajectory of a conformation and the table of its chosen frames; empty for a single structure."""
    files = molecule_files(wildcards)
    if wildcards.protein in READY_SURFACES or "trajectory" not in files:
        return {}
    return files | {"frames": f"results/{wildcards.run}/{wildcards.protein}/frames.csv"}


def if_sampled(file):
    """Input function: a result of the grid of a conformation; empty if its protein is not sampled."""
    return lambda wildcards: (
        f"results/{wildcards.run}/{wildcards.protein}/{wildcards.conformation}/{file}"
        if wildcards.protein in SAMPLED
        else []
    )


def ranges_of_paper_sampler(wildcards):
    """The table of best combinations, where the sampler of the minimal subset takes its parameters from it."""
    takes_them = config["minimal"]["sampler"] in SAMPLERS_OF_COMBINATIONS
    return if_sampled("ranges.csv")(wildcards) if takes_them else []


def stage_before(wildcards):
    """Folder of the previous stage of a simulation; empty for the first."""
    before = {"nvt": "minimise", "npt": "nvt", "production": "npt"}.get(wildcards.stage)
    return f"results/{wildcards.run}/{wildcards.protein}/simulation/{before}" if before else []


def partner_files(wildcards):
    """Surfaces of both partners of a pair, and their structures where they have atoms."""
    own = f"results/{wildcards.run}/pairs/{wildcards.pair}"
    proteins_of_pair = PAIRS[wildcards.pair].get("proteins")
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


def compared_forms(wildcards):
    """Surfaces and structures of two forms that are compared; none where the study has no such conformation."""
    folders = [folder_of(place) for place in CHANGES[wildcards.comparison]]
    if None in folders:
        return {}
    return {
        f"{kind}_{n}": f"{folder}/{kind}.{end}"
        for n, folder in enumerate(folders, 1)
        for kind, end in SURFACE_AND_STRUCTURE
    }


# Final outputs


def early_outputs(protein):
    """Files of one protein that are known before its frames are chosen."""
    files = []
    if protein in MOLECULES:
        files += ["frames.csv", "silhouette.csv", "projection.csv", "explained.csv", "structures"]
    if protein in SIMULATED:
        files += ["simulation/energies.csv", "simulation/motion.csv", "simulation/quality.csv"]
        files += ["figures/simulation.png"]
    if config["ensemble"]["run"] and protein in MOLECULES and not is_excluded(protein, "*"):
        files += ["ensemble.csv", "residues_over_time.csv", "residues.csv"]
    return [f"results/{config['run']}/{protein}/{file}" for file in files]


def protein_outputs(protein):
    """Files of one protein and of its conformations."""
    files = []
    if has_several_frames(protein):
        files += ["figures/frames.png"]
        if config["ensemble"]["run"]:
            files += ["figures/ensemble.png"]
            files += ["figures/residues.png"]
    for conformation in conformations(protein):
        files += [f"{conformation}/{file}" for file in conformation_files(protein)]
    return early_outputs(protein) + [f"results/{config['run']}/{protein}/{file}" for file in files]


def conformation_files(protein):
    """Files of each conformation of a protein."""
    files = ["surface.npz", "surface.ply", "roughness.csv", "floors.csv", "required_dots.csv", "curves.csv"]
    files += ["minimal.csv", "minimal.ply", "recovered.csv", "fields.csv", "fields.npz"]
    files += ["view.html", "view.png"]
    if protein in MOLECULES:
        files += ["structure.pdb", "surface.dms", "components.csv", "residues.csv", "minimal.bild"]
        files += ["structure_roughness.pdb", "structure_roughness.cif", "open.pml", "open.cxc"]
    if protein in SAMPLED:
        files += ["grid.csv", "distances.npz", "best.json", "ranges.csv"]
        files += ["rough_and_flat.csv", *(f"figures/{figure}.png" for figure in FIGURES)]
        files += [f"figures/{figure}.svg" for figure in PAPER_FIGURES]
    if config["compare"]["run"] and protein in SAMPLED:
        files += ["compare.csv", "figures/compare.png"]
    return files


def batch_tables(wildcards):
    """Tables of all batches."""
    return [f"results/{config['run']}/{table}/{batch}.parquet" for table in TABLES for batch in BATCHES]


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


def results_of_pages(wildcards):
    """Files of the structures of batches that get the pages of a study."""
    run = f"results/{config['run']}"
    files = ["surfaces.csv", "required_dots.png"] if PROTEINS else []
    of_proteins = [file for protein in PROTEINS for file in protein_outputs(protein)]
    return [f"{run}/{file}" for file in files] + of_proteins


def outputs_beside_proteins():
    """Files of the pairs, of the forms that are compared, and of the comparison with the paper."""
    files = [f"pairs/{pair}/{file}" for pair in PAIRS for file in pair_files(pair)]
    files += [f"changes/{name}/{file}" for name in CHANGES for file in CHANGES_FILES]
    if "paper" in config and not is_excluded(config["paper"], "c1"):
        files += ["verdict.html", "table1.png", "table1.svg", "paper_as_published.csv", "paper_places.csv"]
        files += ["paper_tests.csv", "paper_rows.csv", "paper_links.csv", "paper_defects.csv"]
        files += ["paper_family.csv"]
    return [f"results/{config['run']}/{file}" for file in files]


def results_before_pages(wildcards):
    """All outputs except the first page and its tables."""
    run = f"results/{config['run']}"
    if BATCHED:
        files = batch_tables(wildcards) + [f"{run}/distributions.png"]
        return files + results_of_pages(wildcards)
    files = []
    if PROTEINS:
        files += ["surfaces.csv", "required_dots.png"]
    if SAMPLED:
        files += ["summary.csv", "relation.csv"]
    if config["compare"]["run"] and SAMPLED:
        files += ["compare.csv", "compare.png"]
    if PAIRS:
        files += ["pairs/pairs.csv", "pairs/pairs.png"]
    of_proteins = [file for protein in PROTEINS for file in protein_outputs(protein)]
    return [f"{run}/{file}" for file in files] + outputs_beside_proteins() + of_proteins


def pair_files(pair):
    """Files of a pair."""
    files = ["propensity.csv", "best_pairs.csv", "agreement.csv", "contacts.csv"]
    files += ["partner_1.ply", "partner_2.ply", "book.png", "view.html"]
    if not set(PAIRS[pair].get("proteins", ())) & set(READY_SURFACES):
        files += ["partner_1.pdb", "partner_2.pdb", "residues.csv", "open.pml", "open.cxc"]
    return files


def final_outputs(wildcards):
    """All outputs of a run."""
    pages = ["warnings.csv", "index.html", "failures.csv", "ro-crate-metadata.json"]
    return [f"results/{config['run']}/{page}" for page in pages] + results_before_pages(wildcards)
