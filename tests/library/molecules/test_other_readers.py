"""Outside oracle: atoms, names, residues and positions of real files, as MDAnalysis reads them.

The files are those of the package MDAnalysisTests and of the reference data. Tests skip where a package is not installed.
"""

import bz2
from pathlib import Path
from string import ascii_uppercase

import numpy as np
import pytest

from sparsurf.molecules.read_molecule import MOLECULE_READERS
from sparsurf.molecules.source import open_source
from sparsurf.molecules.trajectory import iterate_parts

# Topology and trajectory; a file whose name does not tell MDAnalysis its format has the name that does behind a colon
PAIRS = """
adk.psf adk_dims.dcd
adk.psf adk_dims2.dcd
adk.psf adk_open.crd
adk.psf adk_open.pdb
adk_closed_NAMD.psf adk_gbis_tmd-fast1_NAMD.dcd
SiN_tric_namd.psf SiN_tric_namd.dcd
tip125_tric_C36.psf tip125_tric_C36.dcd
watdyn.psf watdyn.dcd
2r9r-1b.psf 2r9r-1b.xyz
namd_cgenff.psf namd_cgenff.pdb
1a2c_ins_code.psf
nosegid.psf
adk_notop.psf
parmed_ala3.psf
trz_psf.psf
adk_oplsaa.gro
adk_oplsaa.gro adk_oplsaa.xtc
adk_oplsaa.gro adk_oplsaa.trr
adk_oplsaa.pdb adk_oplsaa.xtc
adk_oplsaa.pdb adk_oplsaa.trr
cobrotoxin.pdb cobrotoxin.xtc
cobrotoxin.pdb cobrotoxin.trr
sample_velocity_file.gro
grovels.gro
residwrap.gro
residwrap_0base.gro
sameresid_diffresname.gro
two_water_gro.gro
two_water_gro_multiframe.gro
two_water_gro_widebox.gro
huge_box.gro
dppc_vesicle_hg.gro
martini_dppc_chol_bilayer.gro
make_whole.gro
plength.gro
bigbox.gro.bz2
contacts/villin_folded.gro.bz2
contacts/villin_unfolded.gro.bz2
coordinates/test.gro
coordinates/test_topology.pdb coordinates/test.xtc
coordinates/test_topology.pdb coordinates/test.trr
coordinates/test_topology.pdb coordinates/test.dcd
coordinates/test_topology.pdb coordinates/test.xyz
coordinates/test_topology.pdb coordinates/test.gro
adk_open.crd
adk_open.pdb
adk_closed.pdb
Amber/ache.prmtop Amber/ache.mdcrd
Amber/anti.top:PRMTOP Amber/anti_md1.mdcrd.bz2
Amber/bala.prmtop Amber/bala.ncdf
Amber/bala.prmtop Amber/bala.trj:TRJ
Amber/ace_tip3p.parm7 Amber/ace_tip3p.nc
Amber/ace_mbondi3.parm7 Amber/ace_mbondi3.nc
Amber/ace_mbondi3.negative.parm7
Amber/capped-ala.prmtop Amber/capped-ala.mdcrd.bz2
Amber/cpptraj_traj.prmtop Amber/cpptraj_traj.nc
Amber/parmed_ala2_solv.parm7 Amber/parmed_ala2_solv.rst7:INPCRD
Amber/posfor.top:PRMTOP Amber/posfor.ncdf
Amber/tz2.truncoct.parm7.bz2 Amber/tz2.truncoct.nc
Amber/ache_chainid.prmtop.bz2
Amber/ala.ff19SB.OPC.parm7.bz2
Amber/chitosan.prmtop
Amber/ache.prmtop windows/WIN_ache.mdcrd
windows/WIN_nmr_neopetrosiamide.pdb
"""


def compare(topology, trajectory, formats):
    """Compare the tables and the first and last frames of a pair of files."""
    mda = pytest.importorskip("MDAnalysis", reason="MDAnalysis is installed by the extra `interop`")
    source = open_source(topology)
    frames = open_source(trajectory) if trajectory else source if source.format.places else None
    theirs = mda.Universe(
        str(topology),
        *([str(trajectory)] if trajectory else []),
        topology_format=formats[0],
        format=formats[1],
    )
    atoms, group = MOLECULE_READERS[source.format.name](source).atoms, theirs.atoms
    if source.format.models:
        atoms = atoms.take(atoms.model == atoms.model[0])
    assert len(atoms) == len(group)
    assert atoms.name.tolist() == group.names.tolist()
    assert atoms.residue_name.tolist() == group.resnames.tolist()
    # MDAnalysis ignores insertion codes of PSF and the labels of parm7, and continues numbers that begin again
    numbers = [int(label.rstrip(ascii_uppercase)) for label in atoms.residue]
    modulo = {"gro": 100_000, "pdb": 10_000}.get(source.format.name, 10**9)
    if "RESIDUE_NUMBER" not in source.text():
        assert numbers == (group.resids % modulo).tolist()
    if frames is None:
        return
    places = np.concatenate([part[0][[0, -1]] for part in iterate_parts(frames, len(atoms))])[[0, -1]]
    of_one_frame = frames.format.name == "gro"  # for MDAnalysis, which reads the first
    for frame, xyz in zip((0,) if of_one_frame else (0, -1), places, strict=False):
        theirs.trajectory[frame]
        np.testing.assert_allclose(xyz, group.positions, atol=2e-4, rtol=1e-6)


@pytest.mark.parametrize("pair", PAIRS.split("\n")[1:-1])
@pytest.mark.filterwarnings("ignore")
def test_files_of_mdanalysis_are_read_as_it_reads_them(tmp_path, pair):
    datafiles = pytest.importorskip("MDAnalysisTests.datafiles", reason="MDAnalysisTests is not installed")
    folder, paths, formats = Path(datafiles.__file__).parent / "data", [], []
    for name in pair.split():
        name, _, form = name.partition(":")
        path = folder / name
        if path.suffix == ".bz2":
            path = tmp_path / path.stem
            path.write_bytes(bz2.decompress((folder / name).read_bytes()))
        paths.append(path)
        formats.append(form or None)
    alone = len(paths) == 1
    compare(paths[0], None if alone else paths[1], [*formats, None] if alone else formats)


@pytest.mark.parametrize(
    ("topology", "trajectory"),
    [
        ("adk.psf", "adk_dims.dcd"),
        ("DPDP.parm7", "DPDP.nc"),
        ("tz2.parm7", "tz2.nc"),
        ("1vii_3frames.pdb", None),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_files_of_the_reference_data_are_read_as_mdanalysis_reads_them(shared, topology, trajectory):
    folder = shared / "data" / "trajectories"
    compare(folder / topology, trajectory and folder / trajectory, [None, None])
