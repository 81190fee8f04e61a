"""Every surface format: one line each."""

from sparsurf.surfaces.formats import csv, dms, npz, ply

FORMATS = (npz.FORMAT, csv.FORMAT, dms.FORMAT, ply.FORMAT)
READABLE = tuple(suffix for each in FORMATS if each.read for suffix in each.suffixes)
