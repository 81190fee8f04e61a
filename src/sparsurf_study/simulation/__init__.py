"""The paper's molecular dynamics, run by GROMACS: from a structure to a trajectory."""
