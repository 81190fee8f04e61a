"""Numbers about subsets, as arrays and tables, without sentences and figures."""
