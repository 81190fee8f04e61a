"""Numbers of a study, as arrays and tables: the grid, its best combinations, ensembles and summaries."""
