"""What the maps of a pair are worth from fewer and fewer centres."""

from sparsurf.pairs.thinning import thinning
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import thinning_figure
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import partners, recipe_of


def main(inputs, outputs, settings, name):
    """Write thinning.csv and its figure; in one thread, so that seconds can be compared."""
    rules = settings["complementarity"]
    asked, patches = rules["thinning"], settings["patches"]
    table = thinning(
        *partners(inputs, settings, name),
        asked["percents"],
        asked["samplers"],
        asked["draws"],
        asked["recovered"],
        recipe_of(settings),
        smoothing=rules["smoothing"],
        within=rules["interface"],
        seed=settings["seed"],
        rules={"r_patch": patches["R_patch"], "d_link": patches["D_link"]}
        | {defect: settings["sampling"][defect] for defect in ("moved_centre", "every_patch")},
    )
    table.to_csv(outputs["table"], index=False, float_format="%.6g")
    layout.save(thinning_figure(table, name), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
