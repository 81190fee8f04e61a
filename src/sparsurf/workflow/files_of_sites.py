"""Which files the sites of a run come from: what is known of the conformations that they name.

The functions of `wildcards` are input functions of Snakemake.
"""

from pathlib import Path

from sparsurf import InputError

ALL = "all"  # targets: every other conformation of the study that comes with atoms
DESCRIBE = "describe_places"  # the rule that puts a conformation's places into numbers


class FilesOfSites:
    """Sites of a run and their files.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    files : `FilesOfARun`, of the proteins that may be named

    Attributes
    ----------
    names : list of all
    sought, compared : lists of those that look for a site, and of those that compare two conformations
    proteins : list of the proteins that are described
    """

    def __init__(self, config, files):
        self._sites = {
            name: site for name, site in config["sites"].items() if f"sites/{name}" not in config["without"]
        }
        self._files = files
        self.names = list(self._sites)
        self.sought = [name for name, site in self._sites.items() if "query" in site]
        self.compared = [name for name in self.names if name not in self.sought]
        searched = [targets_of(self._sites[name]) for name in self.sought]
        named = [self._sites[name]["query"] for name in self.sought]
        named += [each for targets in searched if targets != ALL for each in targets]
        self.proteins = [
            name
            for name in files.proteins
            if (ALL in searched and name in files.molecules)
            or name in {each.partition("/")[0] for each in named}
        ]

    def site(self, wildcards):
        """What the config says about a site."""
        return self._sites[wildcards.site]

    def places(self, wildcards):
        """The described places of the `query` and of the `targets`; none where a conformation is named that is not there."""
        site = self.site(wildcards)
        if not self.there(wildcards):
            return {}
        query, *named = map(self._folder, named_in(site))
        if targets_of(site) == ALL:
            conformations = [
                f"{self._files.run}/{name}/{each}"
                for name in self._files.molecules
                for each in self._files.conformations(name)
                if not self._files.goes_without(name, each, DESCRIBE)
            ]
            named = [each for each in conformations if each != query]
        targets = [f"{each}/places.sites" for each in dict.fromkeys(named)]  # b and b/c1 are one
        return {
            "query": f"{query}/places.sites", "structure": f"{query}/structure.pdb", "targets": targets,
        }  # fmt: skip

    def surfaces(self, wildcards):
        """The same with the surfaces of all of these, and the structures of those that have one."""
        found = self.places(wildcards)
        folders = [Path(path).parent for path in ([found["query"], *found["targets"]] if found else [])]
        atoms = [folder for folder in folders if folder.parent.name in self._files.molecules]
        return found | {
            "surfaces": [str(folder / "surface.npz") for folder in folders],
            "structures": [str(folder / "structure.pdb") for folder in atoms],
        }

    def forms(self, wildcards):
        """The surfaces and structures of two conformations that are compared; none where one is not there."""
        if not self.there(wildcards):
            return {}
        return {
            f"{what}_{side}": f"{self._folder(name)}/{what}.{end}"
            for side, name in enumerate(named_in(self.site(wildcards)), 1)
            for what, end in (("surface", "npz"), ("structure", "pdb"))
        }

    def there(self, wildcards):
        """Whether all conformations that a site names are those of the study."""
        return all(map(self._conformation, named_in(self.site(wildcards))))

    def _conformation(self, named):
        """The one that is named, f7 or f0007, or a protein's first; None where it is not there."""
        protein, _, own = named.partition("/")
        if not own:
            return self._files.first(protein)
        same = (each for each in self._files.conformations(protein) if each[0] == own[0])
        return next((each for each in same if int(each[1:]) == int(own[1:])), None)

    def _folder(self, named):
        """Its folder."""
        return f"{self._files.run}/{named.partition('/')[0]}/{self._conformation(named)}"


def refuse_absent(inputs, key, name):
    """Raise InputError where a site has not the input that each has whose conformations are there."""
    if key not in inputs:
        raise InputError(
            f"sites.{name} names a conformation that this study has not; frames.csv of its protein lists them."
        )


def targets_of(site):
    """Names of the targets of a site, or ALL."""
    return site.get("targets", ALL)


def named_in(site):
    """Proteins and conformations that a site of the config names, the query first."""
    if "changes" in site:
        return [*site["changes"]]
    targets = targets_of(site)
    return [site["query"], *(targets if targets != ALL else ())]


def asked_for(config):
    """Proteins or conformations that each pair and site of a config asks for, by pairs/<name> and sites/<name>."""
    found = {f"pairs/{name}": pair.get("proteins", ()) for name, pair in config["pairs"].items()}
    return found | {f"sites/{name}": named_in(site) for name, site in config["sites"].items()}
