"""Numbers of the pages are those of evidence/tables: put in when the book is built, or as text in README and docs/paper.md."""

import re

import pytest

import table_numbers
from conftest import ROOT
from sparsurf.cli.recover import EXAMPLES

FARTHEST = 'recover_opponents_means.csv "sampler=farthest dots" percent=10'
AT_44 = "{own:+.2f} ({own_low:+.2f} to {own_high:+.2f})"
ON_A1 = "fragments_surfaces.csv surface=A1_file reading=kept"
SURFACES = "surface=A1_file|A1_dms|A2|A3|A4|A5|B1|B2"
RANGE = "{n_S_low_percent:.0f} to {n_S_high_percent:.0f}"
D_CV = "{d_cv:+.2f} ({d_cv_low:+.2f} to {d_cv_high:+.2f})"
ON_LINKS = "paper_readings.csv surface=A1 row=5"
D_OF = "{{d_{0}:+.2f}} ({{d_low_{0}:+.2f}} to {{d_high_{0}:+.2f}})".format
AT_10 = "proteins_by_n_s.csv percent=10"
SHOWN = {
    "README.md": [
        f"from the true one by {{{{ {FARTHEST} | {{distance:.3f}} }}}} Å on average",
        f"99 % of it by less than {{{{ {FARTHEST} | {{distance_99:.2f}} Å, and its worst point by {{largest:.2f}} }}}} Å (means",
        'deviates by {{ recover_opponents_means.csv "sampler=its corners on the surface" percent=10 | {distance:.3f} }} Å',
        "{{ fragments_verdict.csv rows=10 | {d_inside} of {rows} published d and {Z_inside} of {rows} Z lie }} in the",
        f"At {{{{ {ON_LINKS} | {{n_S_percent:.0f}} % of the dots of A1, d of {{combination}} is {D_OF('kept')} }}}} with islands",
        f"It is {{{{ {ON_LINKS} | {D_OF('kept_scaled')} with a link scaled to their spacing, and {D_OF('full')} }}}} with",
        "For {{ paper_ranges.csv reading=kept row=3 | {n_S_low_percent:.0f} to {n_S_high_percent:.0f} % of A1's dots, {best} is"
        " best there, d {d_cv:.2f} ({d_cv_low:.2f} to {d_cv_high:.2f}), of {n_best_set} that may be; published:"
        " {published} }}",
    ],
    "docs/paper_in_brief.md": [
        "{{ fragments_verdict.csv rows=10 | {d_inside} of {rows} published d and {Z_inside} of {rows} Z lie in the middle 95 % of"
        " {runs} runs }} made",
    ],
    "docs/paper.md": [
        f"surface has {{{{ {ON_A1} | {{dots:,}} dots, {{centres:.0f}} centres of }}}}",
        f"mean roughness of {{{{ {ON_A1} | {{mean_roughness:.4f}} }}}}, as",
        f"n_S runs from {{{{ {ON_A1} | {{n_S_lowest_percent:.2f}} to {{n_S_highest_percent:.2f}} %. }}}}",
        'runs from {{ paper_figures.csv "quantity=lowest roughness" | {value:.2f} to }}'
        ' {{ paper_figures.csv "quantity=highest roughness" | {value:.2f} }}.',
        'α = 0.1 keeps {{ paper_figures.csv "quantity=n_S at alpha 0.1, the others 0" | {value:.0f} }} %',
        'first of {{ paper_figures.csv "quantity=combinations that may be the best, kept" | {value:.0f} }} that',
        'its d is {{ paper_figures.csv "quantity=d of the published best, full" | {value:.2f} }}.',
        'rougher half gains {{ paper_figures.csv "quantity=d of rough_half around kept dots, kept" | {value:.1f} }}',
        'flatter half gains {{ paper_figures.csv "quantity=d of flat_half around kept dots, kept" | {value:.1f} }}',
        'flattest bin gains {{ paper_bins.csv bin=10 "around=kept dots" | {d_kept:.1f} }}.',
        '6, 0) keeps {{ paper_figures.csv "quantity=kept of the roughest tenth, (1, 0, 6, 0)" | {value:.0f} }} % of',
        'dots and {{ paper_figures.csv "quantity=kept of the flattest tenth, (1, 0, 6, 0)" | {value:.0f} }} % of',
        '10, 0) keeps {{ paper_figures.csv "quantity=kept of the roughest tenth, (1, 1, 10, 0)" | {value:.0f} }} %'
        ' and {{ paper_figures.csv "quantity=kept of the flattest tenth, (1, 1, 10, 0)" | {value:.0f} }} %, which',
        'size keeps {{ paper_figures.csv "quantity=kept of all dots, (1, 0, 6, 0)" | {value:.0f} }} %.',
        "by {{ descriptors_changes_means.csv descriptor=published change=turned density=5.35 | {ratio:.2f} }} of",
        "large or dense ([{{ proteins_d.csv reading=kept range=0 | {n} }} here]",
        "{{ fragments_tests.csv | | {measure} | {n_rows} | {p:.2f} | }}",
        "{{ fragments_places.csv | | {range} | {d_published:+.2f} | {d_mean:+.2f} ({d_lowest:+.2f} to {d_highest:+.2f})"
        " | {Z_tS_published:.2f} | {Z_tS_mean:.2f} ({Z_tS_lowest:.2f} to {Z_tS_highest:.2f})"
        " | {d_n_below} of {n_runs} | {n_won} | }}",
        f"{{{{ paper_readings.csv surface=A1 | | {{row}} | {{n_S_percent:.0f}} | {D_OF('kept')} | {D_OF('kept_scaled')}"
        f" | {D_OF('full')} | }}}}",
        f"{{{{ paper_ranges.csv reading=kept | | {RANGE} | {{published}} | {{best}} | {D_CV} | {{n_best_set}}"
        f" | {{published_may_be_best}} | {D_OF('kept_scaled')} | }}}}",
        f"{{{{ paper_ranges.csv reading=full | | {RANGE} | {{best}} | {D_CV} | {{published_may_be_best}} | }}}}",
        "does it: {{ fragments_verdict.csv rows=10 | {d_inside} of {rows} published d and {Z_inside} of {rows} Z lie }}",
        "Z of ten rows ([runs](#table-i)) | {{ fragments_verdict.csv rows=10 | d {d_inside}, Z {Z_inside} of {rows} }}",
        'as many dots (published: 8 of 10) | {{ fragments_inside.csv "surface=A1_dms, other test dots" reading=kept'
        " | {d_above_0} of {rows} }} |",
        "All {{ fragments_verdict.csv rows=10 | {in_span} values lie between }}",
        "All {{ fragments_verdict.csv rows=10 | {n_won} published combinations won }}",
        *(
            f"{{{{ {AT_10} sampler={name} reading=full | {{Z:.2f}} }}}}"
            f" | {{{{ {AT_10} sampler={name} reading=recovered | {{Z:.2f}} }}}} |"
            for name in ("paper", "uniform", "farthest")
        ),
        "{{ fragments_table1.csv | | {row} | {combination} | {d_published:+.2f}"
        " | {d_A1_file:+.2f} ({d_A1_file_low:+.2f} to {d_A1_file_high:+.2f})"
        " | {d_A1_dms:+.2f} ({d_A1_dms_low:+.2f} to {d_A1_dms_high:+.2f})"
        " | {d_A1_exact:+.2f} ({d_A1_exact_low:+.2f} to {d_A1_exact_high:+.2f}) | }}",
        "{{ fragments_table1.csv | | {row} | {Z_published:.2f}"
        " | {Z_A1_file:.2f} ({Z_A1_file_low:.2f} to {Z_A1_file_high:.2f})"
        " | {Z_A1_dms:.2f} ({Z_A1_dms_low:.2f} to {Z_A1_dms_high:.2f})"
        " | {Z_A1_exact:.2f} ({Z_A1_exact_low:.2f} to {Z_A1_exact_high:.2f}) | }}",
        f"{{{{ fragments_surfaces.csv reading=kept {SURFACES} | | {{surface}} | {{dots:,}} | {{mean_roughness:.2f}}"
        " | {n_S_lowest_percent:.2f} to {n_S_highest_percent:.2f} | {n_may_be_best} of 10 | {n_worse} of 10"
        " | {gain:+.2f} ({largest_gain:+.2f}) | }}",
        f"{{{{ fragments_surfaces.csv reading=full {SURFACES} | | {{surface}} | {{n_may_be_best}} of 10"
        " | {n_worse} of 10 | {gain:+.2f} ({largest_gain:+.2f}) | {d_best:+.2f} | }}",
    ],
}


@pytest.mark.parametrize(("page", "text"), [(page, text) for page, texts in SHOWN.items() for text in texts])
def test_a_page_that_is_read_without_the_book_shows_the_numbers_of_the_tables(page, text):
    shown = " ".join(table_numbers.filled(text).split())
    assert shown in " ".join((ROOT / page).read_text(encoding="utf-8").split())


@pytest.mark.parametrize("page", sorted(ROOT.glob("docs/*.md")), ids=lambda path: path.stem)
def test_every_placeholder_of_a_page_has_its_cells(page):
    assert "{{" not in table_numbers.filled(page.read_text(encoding="utf-8"))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "t.csv").write_text(
        "name,percent,Z\nfarthest dots,5,-0.564\nfarthest dots,10,\nuniform,10,1234.56\n"
    )
    return tmp_path


def test_a_placeholder_is_the_text_of_its_row_and_on_its_own_line_of_all_its_rows(folder):
    text = "Z is {{ t.csv name=uniform | {Z:,.0f} at {percent} }}.\n"
    rows = '{{ t.csv "name=farthest dots" | | {percent:g} | {Z:.2f} | }}\n'
    assert table_numbers.filled(text + rows, folder) == "Z is 1,235 at 10.\n| 5 | −0.56 |\n| 10 |  |\n"


@pytest.mark.parametrize("wrong", ["u.csv a=1 | {Z}", "t.csv a=1 | {Z}", "t.csv name=b | {Z}", "t.csv name=uniform | {W}",
                                   "t.csv percent=10 | {Z}", "t.csv name=uniform", "t.csv percent=x | {Z}"])  # fmt: skip
def test_a_wrong_cell_is_named_by_placeholder_and_table(folder, wrong):
    with pytest.raises(ValueError, match=re.escape(f"{{{{ {wrong} }}}}: ")):
        table_numbers.filled(f"Z is {{{{ {wrong} }}}}.", folder)


def test_the_help_of_recover_has_the_errors_of_the_table():
    shown = table_numbers.filled(f"{{{{ {FARTHEST} | {{distance:.2f}} {{distance_99:.2f}} }}}}")
    assert re.findall(r"\d\.\d\d(?= |,)", EXAMPLES) == shown.split()
