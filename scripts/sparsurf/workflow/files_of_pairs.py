"""Which files the pairs of a run have: surfaces and structures of both partners, and what is made of them.

The functions of `wildcards` are input functions of Snakemake.
"""

from types import SimpleNamespace

from sparsurf.workflow.code_digests import content


class FilesOfPairs:
    """Pairs of a run and their files.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    files : `FilesOfARun`, of the proteins that may be partners

    Attributes
    ----------
    alone : list of names: pairs whose partners are no proteins of the run
    pictures, texts : lists of paths of all pairs that the first page leads to, in the report and beside it
    summary : list of the path of the page on all pairs, if there are any
    """

    def __init__(self, config, files):
        self._pairs, self._files = config["pairs"], files
        self.folder = f"{files.run}/pairs"
        self.alone = [name for name, pair in self._pairs.items() if "proteins" not in pair]
        pages = ["book.png", "view_1.html", "view_2.html"]
        pages += ["thinning.png"] if config["complementarity"]["thinning"]["run"] else []
        self._pages = pages
        self.pictures = [f"{self.folder}/{name}/{page}" for name in self._pairs for page in pages]
        self.texts = [f"{self.folder}/{name}/pair.md" for name in self._pairs]
        self.summary = [f"{self.folder}/pairs.md"] if self._pairs else []

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
                    folder, end = f"{self._files.run}/{name}/{self._files.conformations(name)[0]}", ""
                found |= {f"surface_{side}": f"{folder}/surface{end}.npz"} if "surface" in kinds else {}
                if "structure" in kinds and name not in self._files.surfaces:
                    found[f"structure_{side}"] = f"{folder}/structure{end}.pdb"
            return found

        return files

    def of_pair(self, wildcards):
        """What a pair must have in the end; residues only where both partners come with atoms."""
        atoms = not set(self.pair(wildcards).get("proteins", ())) & set(self._files.surfaces)
        files = ["pair.md", *self._pages, *(["residues.csv"] if atoms else [])]
        return [f"{self.folder}/{wildcards.pair}/{file}" for file in files]

    def of_pairs(self):
        """What the pairs of the run must have in the end; a mark stays where a file is deleted."""
        files = [file for name in self._pairs for file in self.of_pair(SimpleNamespace(pair=name))]
        return [f"{self.folder}/{name}/.complete" for name in self._pairs] + files + self.summary
