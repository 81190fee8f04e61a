# The surface in the colours of its roughness, the dots of minimal.csv, and, switched off, each field of residues.csv.
# Open it from this folder: pymol open.pml
load structure_roughness.pdb, structure
hide everything, structure
show cartoon, structure
show surface, structure
spectrum b, 0x440154 0x31688E 0x35B779 0xFDE725, structure, %LOW%, %HIGH%
python
import csv
from pymol import cgo
spheres = [cgo.COLOR, 0.84, 0.37, 0.0]
with open("minimal.csv") as rows:
    for row in csv.DictReader(rows):
        spheres += [cgo.SPHERE, float(row["x"]), float(row["y"]), float(row["z"]), 0.3]
cmd.load_cgo(spheres, "minimal")
with open("residues.csv") as rows:
    residues = list(csv.DictReader(rows))
for column in residues[0]:
    if column.startswith("mean_") and column != "mean_roughness":
        shown = {(row["chain"], row["residue"]): float(row[column]) for row in residues if row[column]}
        most = max(map(abs, shown.values()), default=0.0) or 1.0
        cmd.create(column, "structure")
        cmd.alter(column, "b = shown.get((chain, resi), 0.0)", space={"shown": shown})
        cmd.spectrum("b", "red_white_blue", column, -most, most)
        cmd.disable(column)
python end
bg_color white
orient structure
