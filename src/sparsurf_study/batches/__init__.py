"""Thousands of structures: a job for a batch of them, a table for all of them."""
