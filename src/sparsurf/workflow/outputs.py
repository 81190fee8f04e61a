"""Outputs of rules: how a rule names them, and what a run has in the end, which follows from the rules."""

import re
from functools import cached_property
from pathlib import Path

from snakemake.io import report

ALL_FRAMES = "*"  # in `without`: what a protein has over all of its frames
OF_CHOICE = {"draw_frames"}  # says nothing where the frames are chosen from one
OF_SEVERAL_FRAMES = {*OF_CHOICE, "draw_ensemble"}  # rules that say nothing of a single structure
IN_REPORT = 50  # proteins whose conformations the report shows: of more no browser could show it
CAPTIONS = Path(__file__).parents[1] / "report" / "captions"


def inside(folder, **files):
    """Paths of files of one folder, by their names in a rule."""
    return {name: f"{folder}/{file}" for name, file in files.items()}


def shown(path, label, caption, category=None):
    """`path`, shown in the report under `label` among the results of its protein, with report/captions/<caption>.rst."""
    category = category or ("{protein}" if "{protein}" in path else "All surfaces")
    within = {"subcategory": "{conformation}"} if "{conformation}" in path else {}
    text = CAPTIONS / f"{caption}.rst"
    return report(
        path,
        caption=str(text) if text.is_file() else None,
        category=category,
        labels={"result": label},
        **within,
    )


def figure(path, label, caption, category=None):
    """Outputs `png`, shown in the report, and `svg` of a figure; `path` comes without its ending."""
    return {"png": shown(f"{path}.png", label, caption, category), "svg": f"{path}.svg"}


def _job(rule):
    """What a rule's log is called, * in place of wildcards: its name, which a workflow that imports it may change."""
    return Path(re.sub(r"{.*?}", "*", str(rule.log[0]))).stem if rule.log else rule.name


class Outputs:
    """What a run has in the end: the outputs of every rule, for every protein, conformation, pair and site that it is for.

    A rule is for those that its wildcard constraints let through. Temporary files, marks, and files with other wildcards, which
    only lead to those, are not asked for. The functions of `wildcards` are input functions of Snakemake.

    Parameters
    ----------
    workflow : Snakemake's; all of its rules are there once an input function is called
    files : `FilesOfARun`
    pair, site : `FilesOfPairs` and `FilesOfSites`, by the name of their wildcard

    Attributes
    ----------
    places : list of the pairs and sites as paths in the run's folder, like pairs/<name>
    """

    def __init__(self, workflow, files, **named):
        self._workflow, self._files = workflow, files
        self._named = {f"{what}s/{name}": {what: name} for what, each in named.items() for name in each.names}
        self.places = [*self._named]

    @cached_property
    def _by_wildcards(self):
        """Outputs of all rules, each with its job, by the names of their wildcards; without those of an importing workflow."""
        found = {}
        for rule in self._workflow.rules:
            job = _job(rule)
            for file in rule.output:
                own = str(file).startswith(f"{self._files.run}/")
                if own and not {"touch", "temp"} & file.flags.keys():
                    found.setdefault(frozenset(file.get_wildcard_names()), []).append((file, job))
        return found

    def _made(self, but=(), **values):
        """Outputs for these values of wildcards, without those that a run goes `without` and those of the rules `but`;
        {path: whether the report shows it}."""
        found = {}
        for file, job in self._by_wildcards.get(frozenset(values), ()):
            path = str(file.apply_wildcards(values))
            left_out = job in but or self._files.goes_without(*values.values(), job)
            if file.match(path) and not left_out:
                found[path] = "report" in file.flags
        return found

    def _of_frames(self, name, but=OF_SEVERAL_FRAMES):
        """Outputs for a protein over all of its frames, which wait for no choice of conformations."""
        return {} if self._files.goes_without(name, ALL_FRAMES) else self._made(but, protein=name)

    def _of_protein(self, name):
        but = OF_CHOICE if self._files.steps_over_frames(name) else OF_SEVERAL_FRAMES
        found = self._of_frames(name, () if self._files.has_frames(name) else but)
        for each in self._files.conformations(name):
            found |= self._made(protein=name, conformation=each)
        return found

    def of_protein(self, wildcards):
        """Outputs for a protein and for each of its conformations."""
        return list(self._of_protein(wildcards.protein))

    def of_place(self, wildcards):
        """Outputs for a pair, or for a site."""
        return list(self._made(**self._named[wildcards.place]))

    def of_run(self, wildcards=None):
        """Outputs over all proteins, pairs and sites."""
        return list(self._made())

    def each(self):
        """Input functions of each protein, pair and site; a mark stays where one of their files is deleted."""
        parts = (self._of_frames, self._of_protein)
        proteins = [
            lambda _, of=of, name=name: list(of(name)) for name in self._files.proteins for of in parts
        ]
        return proteins + [lambda _, named=named: list(self._made(**named)) for named in self._named.values()]

    def jobs(self, wildcards=None):
        """Jobs that have a log."""
        return sorted({_job(rule) for rule in self._workflow.rules if rule.log})

    def all_but(self, *after, shown=None):
        """Input function: all outputs but for files that come `after` them; with `shown` only those in the report, or not."""

        def files(wildcards):
            found = self._made()
            for name in self._files.proteins:
                found |= self._of_protein(name)
            for named in self._named.values():
                found |= self._made(**named)
            return [
                path for path, is_shown in found.items() if path not in after and shown in (None, is_shown)
            ]

        return files
