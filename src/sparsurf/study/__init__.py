"""Numbers about subsets: arrays and tables, no sentence, no figure."""
