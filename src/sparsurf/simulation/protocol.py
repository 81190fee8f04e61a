"""The protocol of the paper's molecular dynamics as GROMACS parameters, stage by stage.

Source: paper, 'Protein structures and computation of the molecular surfaces'. Where it is silent (time constant of the
thermostat, position restraints while the water settles) the usual GROMACS choice stands. Lengths come in Å.
"""

STAGES = ("minimise", "nvt", "npt", "production")
DEFAULTS = {
    "ns": 1.0,  # length of the production; the paper's is 10,000
    "nvt_ns": 0.1,
    "npt_ns": 0.1,
    "save_ps": 1.0,  # time between saved frames
    "time_step_fs": 2.0,
    "temperature": 300.0,  # K
    "pressure": 1.0,  # bar
    "cutoff": 12.0,  # Å, of the short-range interactions
    "margin": 11.0,  # Å, from each atom of the protein to the border of the box
    "force_field": "charmm27",
    "water": "tip3p",
}
CHOICE = ("selection", "chains", "residues", "model", "altloc")  # keys of a protein that choose its atoms
BEFORE = ("simulate", *CHOICE)  # keys of a protein whose work is done when its simulation ends
ENERGIES = 500  # stored values of temperature, pressure, ... per stage, at least

MINIMISE = """\
integrator = steep
emstep = 0.01
emtol = 1000
nsteps = 50000
nstenergy = 1
"""
DYNAMICS = """\
integrator = md
dt = {dt:g}
nsteps = {steps}
nstxout-compressed = {save}
compressed-x-grps = Protein
compressed-x-precision = 1000
nstenergy = {energies}
nstlog = {energies}
constraints = h-bonds
constraint-algorithm = lincs
tcoupl = V-rescale
tc-grps = Protein Non-Protein
tau-t = 0.1 0.1
ref-t = {temperature:g} {temperature:g}
"""
EVERYWHERE = """\
cutoff-scheme = Verlet
coulombtype = PME
rcoulomb = {cutoff:g}
rvdw = {cutoff:g}
pbc = xyz
"""
BAROSTAT = """\
pcoupl = Parrinello-Rahman
pcoupltype = isotropic
tau-p = 2
ref-p = {pressure:g}
compressibility = 4.5e-5
"""
BEGIN = {  # each stage goes on where the one before ended; the protein is held while the water settles
    "nvt": "define = -DPOSRES\ncontinuation = no\ngen-vel = yes\ngen-temp = {temperature:g}\ngen-seed = {seed}\n",
    "npt": "define = -DPOSRES\nrefcoord-scaling = com\ncontinuation = yes\ngen-vel = no\n" + BAROSTAT,
    "production": "continuation = yes\ngen-vel = no\n" + BAROSTAT,
}


def stage_before(stage):
    """Name of the stage that ends where `stage` begins; None for the first."""
    place = STAGES.index(stage)
    return STAGES[place - 1] if place else None


def length_ns(stage, settings):
    """Simulated time of a stage in ns; 0 for the minimisation."""
    return {"minimise": 0.0, "production": settings["ns"]}.get(stage, settings.get(f"{stage}_ns"))


def completed(asked):
    """The config's `simulate` of a protein with every default filled in."""
    return DEFAULTS | asked


def velocity_seed(seed):
    """The seed as GROMACS wants it: positive, of 31 bits."""
    return max(1, seed % (2**31 - 1))


def steps(stage, settings):
    """Number of time steps of a stage of dynamics, at least 1."""
    return max(1, round(length_ns(stage, settings) * 1e6 / settings["time_step_fs"]))


def parameters(stage, settings, seed):
    """Text of the GROMACS parameter file (mdp) of a stage.

    Parameters
    ----------
    stage : one of STAGES
    settings : dict with the keys of DEFAULTS; Å, ns, ps, fs, K, bar
    seed : int, of the initial velocities

    Returns
    -------
    str
    """
    everywhere = EVERYWHERE.format(cutoff=settings["cutoff"] / 10)  # nm
    if stage == "minimise":
        return MINIMISE + everywhere
    number = steps(stage, settings)
    values = settings | {
        "dt": settings["time_step_fs"] / 1000,
        "steps": number,
        "save": max(1, round(1000 * settings["save_ps"] / settings["time_step_fs"])),
        "energies": max(1, number // ENERGIES),
        "seed": velocity_seed(seed),
    }
    return (DYNAMICS + BEGIN[stage]).format(**values) + everywhere
