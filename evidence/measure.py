"""Run the measurement of a rule of the evidence, the script of all of them.

The rule is called VERB_TOPIC, as in measure_curve, and its function has the same name in measures/TOPIC.py. To run one from a
terminal: make evidence RULES=measure_curve.
"""

from importlib import import_module

from sparsurf_study.workflow.jobs import job

with job(snakemake) as this:
    topic = this.rule.split("_", 1)[1]
    getattr(import_module(f"measures.{topic}"), this.rule)(this)
