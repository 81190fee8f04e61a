"""
Which sampler keeps the best dots?
==================================

Z is the mean error of a patch's descriptor, and 0 is perfect. Bars are 95 % intervals.
"""

import matplotlib.pyplot as plt

import sparsurf

ready = sparsurf.prepare(sparsurf.surface("../../data/tdp43/topology.pdb"))
samplers = ["farthest", "poisson", "uniform", "paper"]
percents = [2.5, 5, 10, 20]

fig, ax = plt.subplots(figsize=(6, 4), layout="constrained")
for name in samplers:
    subsets = {p: sparsurf.sample(ready, percent=p, sampler=name) for p in percents}
    table = sparsurf.compare(ready, subsets, test_dots=200)
    ax.errorbar(percents, table["Z"], 1.96 * table["Z_se"], label=name, marker="o")
ax.set(xlabel="kept dots (%)", ylabel="Z", xscale="log", ylim=(0, None))
ax.set_xticks(percents, percents)
ax.set_xticks([], minor=True)
ax.legend()

# %%
# Evenly spread dots do best. The reading ``recovered`` compares the surfaces that the dots give back:

kept = {name: sparsurf.sample(ready, percent=5, sampler=name) for name in samplers}
table = sparsurf.compare(ready, kept, reading="recovered", test_dots=100)
print(table[["n_S", "Z", "d"]].round(2))
