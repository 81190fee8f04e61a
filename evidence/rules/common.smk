# Functions that the rules share.


def structure_file(name):
    """Path of a structure by its name: the local file or that of rule fetch_structure."""
    structure = STRUCTURES[name]
    return local_file(structure, DATA) or f"{RESULTS}/structures/{Path(structure.url or structure.file).name}"


def structure(wildcards):
    """Path of the structure of a protein."""
    return structure_file(wildcards.protein)


def one_of(names):
    """Regular expression that matches these names and nothing else."""
    return "|".join(map(re.escape, names)) or "(?!)"


def structures_of(names):
    """Paths of the paper's protein, first, and of these others, by name."""
    return {name: structure_file(name) for name in [PAPERS, *names]}


def fragment(wildcards):
    """Path of the structure or of the dots of a surface."""
    return structure_file(FRAGMENTS[wildcards.surface]["structure"])


def spheres_group(wildcards):
    """Group of the structures of a part."""
    return SPHERES_PARTS[wildcards.part][0]
