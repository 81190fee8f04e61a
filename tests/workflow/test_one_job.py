"""One job for all steps of a conformation: each step gets what its own rule would give it."""

import inspect
from importlib import import_module
from types import SimpleNamespace

import analyse_conformation

OUTPUTS = (
    "surface", "structure", "dms", "components", "roughness", "floors", "floor_distances", "minimal", "ply", "whole",
    "recovered", "required_dots", "curves", "fields", "fields_recovered", "page", "picture", "residues", "pdb", "cif",
    "pml", "cxc", "bild",
)  # fmt: skip


def test_every_step_gets_the_files_and_settings_of_the_job(monkeypatch):
    own = inspect.signature(analyse_conformation.main).parameters
    given = {name: f"<{name}>" for name in own} | {"patches": {"D_link": "<d_link>"}}
    given["outputs"] = {name: f"results/{name}" for name in OUTPUTS}
    calls = {}
    steps = (
        "compute_surface",
        "measure_roughness",
        "measure_floors",
        "select_minimal_subset",
        "draw_view",
        "tabulate_residues",
    )
    for step in steps:
        signature = inspect.signature(getattr(analyse_conformation, step).main)

        def note(*args, step=step, signature=signature, **kwargs):
            calls[step] = dict(signature.bind(*args, **kwargs).arguments)

        monkeypatch.setattr(analyse_conformation, step, SimpleNamespace(main=note))
    analyse_conformation.main(**given)
    assert tuple(calls) == steps
    outputs = given["outputs"] | {"distances": "results/floor_distances"}
    renamed = {
        ("compute_surface", "settings"): given["surface_settings"],
        ("compute_surface", "d_link"): "<d_link>",
        ("draw_view", "minimal_settings"): given["minimal"],
        ("measure_floors", "conformation"): outputs["structure"],
        ("measure_floors", "structure"): given["structure"],
        ("select_minimal_subset", "minimal"): given["minimal"],
        ("select_minimal_subset", "floors"): outputs["floor_distances"],
        ("select_minimal_subset", "table"): outputs["minimal"],
        ("tabulate_residues", "table"): outputs["residues"],
        ("select_minimal_subset", "ranges"): None,
        ("select_minimal_subset", "whole_curve"): False,
        ("draw_view", "grid"): None,
        ("draw_view", "best"): None,
    }
    handed_on = set()
    for step, arguments in calls.items():
        for name in inspect.signature(import_module(step).main).parameters:
            if name in arguments or name in given or name in outputs:
                expected = renamed.get((step, name), outputs.get(name, given.get(name)))
                assert arguments.get(name, "not given") == expected, (step, name)
        handed_on |= {str(value) for value in arguments.values()}
    assert {str(path) for path in given["outputs"].values()} <= handed_on
