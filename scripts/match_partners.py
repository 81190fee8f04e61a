"""Match both partners of a pair: propensity of every dot, best-matching patches, agreement with the interface."""

from sparsurf_study.workflow.jobs import job
from sparsurf.surfaces.formats.colours import scale_of
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf_study.pairs.matching import NEAREST, best_pairs, contacts, match, tables_of_partners
from sparsurf_study.pairs.partners import read_partners, select_centres
from sparsurf_study.rounding import write_rounded

with job(snakemake) as s:
    settings, seed, within = s.settings, s.params.seed, s.params.interface
    partners = read_partners(
        s.input.surface_1, s.input.surface_2, s.input.get("structure_1"), s.input.get("structure_2"),
        settings.patches.d_link, s.wildcards.pair,
    )  # fmt: skip
    centres = [select_centres(partner, s.params.centres, settings, seed, s.threads) for partner in partners]
    matched = match(*partners, centres, NEAREST, settings.patches, s.threads)
    dots, agreement = tables_of_partners(matched, s.params.smoothing, within, seed, s.threads)
    dots.to_csv(s.output.dots, index=False, float_format="%.6g")
    write_rounded(s.output.best, best_pairs(matched))
    write_rounded(s.output.agreement, agreement)
    write_rounded(s.output.contacts, contacts(*partners, within, settings.patches, seed, s.threads))
    for side, partner in enumerate(partners, 1):
        table = dots[dots["partner"] == side]
        columns = {key: table[key].to_numpy() for key in ("similarity_smoothed", "interface")}
        propensity = scale_of("propensity", table["propensity_smoothed"])
        write_ply(s.output[f"ply_{side}"], partner.surface, propensity, columns)
