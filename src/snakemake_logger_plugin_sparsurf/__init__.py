"""What `make run` says on the terminal: Snakemake finds this module by its name (`--logger sparsurf`)."""

from sparsurf_study.workflow.terminal import Terminal as LogHandler

__all__ = ["LogHandler"]
