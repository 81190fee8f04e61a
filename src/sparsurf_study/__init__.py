"""The study of Grassmann et al.: grid, tables, pages and workflow, on top of the library `sparsurf`."""

import os

# All figures are files, whatever backend Jupyter or a desktop sets for its windows
os.environ["MPLBACKEND"] = "agg"
