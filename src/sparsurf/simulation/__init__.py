"""From a structure to a trajectory: the paper's molecular dynamics, run by GROMACS. Nothing here knows a surface."""
