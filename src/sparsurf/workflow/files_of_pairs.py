"""Which files the pairs of a run come from: surfaces and structures of both partners.

The functions of `wildcards` are input functions of Snakemake.
"""

from sparsurf.workflow.code_digests import content


class FilesOfPairs:
    """Pairs of a run and their files.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    files : `FilesOfARun`, of the proteins that may be partners

    Attributes
    ----------
    names : list of all pairs
    alone : list of those whose partners are no proteins of the run
    with_atoms : list of those of which both partners come with atoms
    """

    def __init__(self, config, files):
        self._pairs = {
            name: pair for name, pair in config["pairs"].items() if f"pairs/{name}" not in config["without"]
        }
        self._files, self.folder = files, f"{files.run}/pairs"
        self.names = list(self._pairs)
        self.alone = [name for name, pair in self._pairs.items() if "proteins" not in pair]
        bare = {name for name, pair in self._pairs.items() if {*pair.get("proteins", ())} & {*files.surfaces}}
        self.with_atoms = [name for name in self.names if name not in bare]

    def pair(self, wildcards):
        """What the config says about a pair."""
        return self._pairs[wildcards.pair]

    def given(self, wildcards):
        """The structures of a pair that is no pair of proteins."""
        pair = self.pair(wildcards)
        if "complex" in pair:
            return {"complex": pair["complex"]}
        return dict(zip(("first", "second"), pair["files"], strict=True))

    def contents(self, wildcards):
        """Digests of these files."""
        return [content(path) for path in self.given(wildcards).values()]

    def partners(self, *kinds):
        """Input function: of both partners the `kinds` 'surface' and, where there are atoms, 'structure'."""

        def files(wildcards):
            found = {}
            for side, name in enumerate(self.pair(wildcards).get("proteins", (None, None)), 1):
                folder, end = f"{self.folder}/{wildcards.pair}", f"_{side}"
                if name:
                    folder, end = f"{self._files.run}/{name}/{self._files.first(name)}", ""
                found |= {f"surface_{side}": f"{folder}/surface{end}.npz"} if "surface" in kinds else {}
                if "structure" in kinds and name not in self._files.surfaces:
                    found[f"structure_{side}"] = f"{folder}/structure{end}.pdb"
            return found

        return files
