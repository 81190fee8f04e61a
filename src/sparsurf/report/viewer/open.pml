# The surface in the colours of its roughness, and the dots of minimal.csv. Open it from this folder: pymol open.pml
load structure_roughness.pdb, structure
hide everything, structure
show cartoon, structure
show surface, structure
spectrum b, 0x440154 0x31688E 0x35B779 0xFDE725, structure, 0.2, 0.9
python
import csv
from pymol import cgo
spheres = [cgo.COLOR, 0.84, 0.37, 0.0]
with open("minimal.csv") as rows:
    for row in csv.DictReader(rows):
        spheres += [cgo.SPHERE, float(row["x"]), float(row["y"]), float(row["z"]), 0.3]
cmd.load_cgo(spheres, "minimal")
python end
bg_color white
orient structure
