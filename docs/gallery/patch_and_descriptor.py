"""
A patch and its descriptor
==========================

The dots within 6 Å of a dot are turned so that their mean normal points up. Their distances to the tip of a cone become an image,
and its Zernike invariants describe the patch, however it is turned about its normal.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import binned_statistic_2d

import sparsurf
from sparsurf.patches.islands import patch

dots = sparsurf.surface("../../data/tdp43/topology.pdb")
dot = int(np.argmax(sparsurf.roughness(dots, r_patch=6)))  # the flattest
own = patch(sparsurf.prepare(dots).index, dot, 6.0)  # its largest island

up = dots.normals[own].mean(axis=0)
across = np.linalg.svd(up[None])[2][1:]  # two directions at right angles to it
axes = np.array([*across, up / np.linalg.norm(up)])
x, y, z = axes @ (dots.points[own] - dots.points[own].mean(axis=0)).T
apex = (z - np.hypot(x, y)).min()  # of a cone of 45 degrees that holds the patch
r = np.sqrt(x**2 + y**2 + (z - apex) ** 2)
image = binned_statistic_2d(x, y, r, bins=25).statistic
z_nm = sparsurf.descriptors(dots, [dot])[0]

fig = plt.figure(figsize=(10, 3.3), layout="constrained")
solid = dots.take(own).plot(r, ax=fig.add_subplot(131), name="distance to the tip (Å)")
solid.set_title("patch, seen from above")
flat = fig.add_subplot(132)
flat.imshow(image.T, origin="lower")
flat.set_title("image: distance to the tip")
bars = fig.add_subplot(133)
bars.bar(range(len(z_nm)), z_nm, width=1)
bars.set(xlabel="order (n, m)", ylabel="|c$_{nm}$|", yscale="log", title="descriptor")
