"""The study of Grassmann et al.: grid, tables, pages and workflow, on top of the library `sparsurf`; not in the wheel."""
