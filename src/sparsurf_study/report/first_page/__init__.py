"""The first page of a run: one module for each thing that a run can contain, which reads its values from the tables."""
