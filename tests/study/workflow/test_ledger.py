"""The ledger: outputs that appear together, the record of a job, kills inside its writes, and what disagrees with the records."""

import errno
import json
import os
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from snakemake.rules import Namedlist  # where every version since 9.0 has it

from small_study import copy_of, planned_jobs, run_job
from sparsurf.errors import InputError
from sparsurf_study.workflow import adoption, checksums, jobs, ledger
from sparsurf_study.workflow.checksums import Checksums
from sparsurf_study.workflow.code_version import code_of

RUN = Path("results", "r")
LONG_AGO = (10**9, 10**9)

# A fork of the job is killed inside each write below results/, half of the file on the disk; the job itself before a renaming
KILLER = """
import os, signal, sys
def kill(outputs, last, notes):
    state = {{"busy": False, "renames": 0}}
    def note(event, arguments):
        if state["busy"] or event not in ("open", "os.rename"):
            return
        path = os.path.abspath(os.fsdecode(arguments[0])) if isinstance(arguments[0], (str, bytes, os.PathLike)) else ""
        if not path.startswith(os.path.abspath("results") + os.sep) or os.sep + "logs" + os.sep in path or ".ledger" in path:
            return
        state["renames"] += event == "os.rename"
        if event == "os.rename" and state["renames"] == last:
            os.kill(os.getpid(), signal.SIGKILL)
        if event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR):
            state["busy"] = True
            if not (job := os.fork()):
                with open(path, "wb", buffering=0) as stream:
                    stream.write(b"hal")
                    os.kill(os.getpid(), signal.SIGKILL)
            os.waitpid(job, 0)
            left = [path for path in outputs if os.path.exists(path)]
            with open(notes, "a") as stream:
                stream.write(" ".join([os.path.basename(path) + ":", *left]) + chr(10))
            os.unlink(path)
            state["busy"] = False
    sys.addaudithook(note)
kill({outputs!r}, {last}, {notes!r})
"""
SLOW = ("compare_samplers", "reproduce_paper", "evaluate_grid")


def test_a_job_that_is_killed_inside_any_of_its_writes_leaves_nothing_half_and_gives_the_same_bytes(
    study, tmp_path, monkeypatch
):
    """Each job of a conformation and of the run, killed in each write and before its last renaming, and then run again."""
    folder = copy_of(study, tmp_path / "own")
    config = yaml.safe_load((study / "config.yaml").read_text())
    (folder / "results/small/index.html").unlink()
    monkeypatch.chdir(folder)
    planned = planned_jobs(folder, config, all_jobs=True)
    places = [["small", "moving", "f0000"], ["small"]]
    chosen = [job for job in planned if list(job["wildcards"]) in places and job["script"]]
    n_kills = 0
    for job in [job for job in chosen if job["rule"] not in SLOW]:
        outputs, notes = list(job["output"]), tmp_path / f"{job['rule']}.txt"
        killer = KILLER.format(outputs=outputs, last=len(outputs), notes=str(notes))
        assert run_job(folder, job, killer).returncode != 0
        kills = notes.read_text().splitlines()
        assert len(kills) >= len(outputs) and all(line.endswith(":") for line in kills), job["rule"]
        there = [path for path in outputs if (folder / path).exists()]
        assert len(there) == len(outputs) - 1 and all(same(folder / path, study / path) for path in there)
        assert {*there} <= ledger.disagreements(Path("results", "small")).results.keys()
        done = run_job(folder, job)
        assert done.returncode == 0, done.stdout + done.stderr
        assert all(same(folder / path, study / path) for path in outputs), job["rule"]
        n_kills += len(kills) + 1
    assert n_kills > 55 and not [*(folder / "results").rglob(".*.new")]


def same(path, known):
    """Whether a file has the bytes of another; page and crate of the run name the config, and are compared at their ends."""
    whole = path.name not in ("index.html", "ro-crate-metadata.json")
    return path.read_bytes()[0 if whole else -50 :] == known.read_bytes()[0 if whole else -50 :]


def snakemake(
    inputs=("in.csv",), outputs=("results/r/p/explained.csv", "results/r/p/frames.csv"), rule="work", **params
):
    """What Snakemake hands to a script of a job of the run r."""
    given = {"input": list(inputs), "output": list(outputs)}
    lists = {
        kind: Namedlist(fromdict={f"{kind[0]}{k}": path for k, path in enumerate(paths)})
        for kind, paths in given.items()
    }
    params = Namedlist(fromdict={"code": "c0de", "seed": 3} | params)
    log = f"results/r/logs/p/{rule}.log"
    for path in (log, *outputs):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    return SimpleNamespace(rule=rule, log=[log], params=params, **lists)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty working folder with one input."""
    monkeypatch.chdir(tmp_path)
    Path("in.csv").write_text("x\n1\n")
    os.utime("in.csv", LONG_AGO)
    monkeypatch.setattr(sys, "__stderr__", SimpleNamespace(write=lambda _: None, flush=lambda: None))
    return tmp_path


def run(job=None, text="y\n2\n", during=lambda: None):
    """Run a job that writes all of its outputs."""
    job = job or snakemake()
    for path in job.output:  # as Snakemake does
        Path(path).unlink(missing_ok=True)
    with jobs.job(job) as s:
        for path in s.output:
            Path(path).write_text(text)
        during()
        assert not any(Path(path).exists() for path in job.output)
    return job


def said(found):
    """The sentences about results, without those that need none."""
    return {path: sentence for path, sentence in found.results.items() if sentence}


def test_a_job_records_what_it_read_wrote_and_computed_with(folder):
    job = run()
    assert [Path(path).read_text() for path in job.output] == ["y\n2\n"] * 2
    (record,) = ledger.read_records(RUN).values()
    of_input, of_output = (checksums.checksum_of_file(path) for path in ("in.csv", job.output[0]))
    assert record.inputs == {"in.csv": of_input} and record.outputs == dict.fromkeys(job.output, of_output)
    assert (record.rule, record.code, record.config) == ("work", "c0de", {"seed": 3})
    import numpy

    assert record.versions["numpy"] == numpy.__version__ and record.versions.keys() == {*ledger.LIBRARIES}
    assert ledger.disagreements(RUN) == ledger.Disagreements()
    assert sorted(path.name for path in (folder / RUN / "p").iterdir()) == ["explained.csv", "frames.csv"]


def test_a_job_that_fails_leaves_no_output_and_no_record(folder):
    run()
    with pytest.raises(SystemExit), jobs.job(snakemake()) as s:
        Path(s.output[0]).write_text("half")
        jobs.logging.getLogger("sparsurf").warning("%s is odd", s.output[1])
        raise InputError(f"{s.output[0]} is wrong.")
    assert Path("results/r/logs/p/work.log").read_text().splitlines() == [
        "WARNING results/r/p/frames.csv is odd",
        "ERROR results/r/p/explained.csv is wrong.",
    ]
    assert (
        Path("results/r/p/explained.csv").read_text() == "y\n2\n"
    )  # Snakemake removes what an earlier job wrote
    assert not ledger.read_records(RUN) and not [*Path(RUN).rglob(".*.new")]


def test_names_of_outputs_stay_in_lists_and_folders(folder):
    """A rule names single outputs, lists of them, and folders."""
    job = snakemake(
        outputs=["results/r/p/a.svg", "results/r/p/b.svg", "results/r/p/one", "results/r/q/c.csv"]
    )
    job.output = Namedlist(job.output)
    for name, place in (("svg", (0, 2)), ("one", (2, None)), ("none", (3, 3)), ("table", (3, None))):
        job.output._set_name(name, place[0], end=place[1])
    with jobs.job(job) as s:
        assert [Path(path).name for path in s.output.svg] == ["a.svg", "b.svg"] and list(s.output.none) == []
        assert s.output["table"] == s.output.table == s.output[3] and s.output.get("other") is None
        Path(s.output.one).mkdir()
        for path in (*s.output.svg, s.output.table, f"{s.output.one}/f0.pdb"):
            Path(path).write_text(Path(path).name)
    assert Path("results/r/p/one/f0.pdb").read_text() == "f0.pdb" and Path("results/r/q/c.csv").exists()
    Path("results/r/p/one/f0.pdb").write_text("edited")
    assert said(ledger.disagreements(RUN)) == {
        "results/r/p/one": "one of p was changed after its job: it is computed again."
    }
    with jobs.job(job) as s:  # over the folder of an earlier job
        Path(s.output.one).mkdir()
        for path in (*s.output.svg, s.output.table, f"{s.output.one}/f1.pdb"):
            Path(path).write_text("again")
    assert [path.name for path in Path("results/r/p/one").iterdir()] == ["f1.pdb"]


@pytest.mark.parametrize("edit", ["appended", "replaced", "deleted"])
def test_results_of_an_input_that_was_changed_while_a_job_read_it_are_not_kept(folder, edit):
    def change():
        text = Path("in.csv").read_text()
        Path("in.csv").unlink()
        if edit != "deleted":
            Path("in.csv").write_text(text + "3\n" if edit == "appended" else text.replace("1", "2"))
            os.utime("in.csv", LONG_AGO)

    with pytest.raises(SystemExit):
        run(during=change)
    log = Path("results/r/logs/p/work.log").read_text()
    assert "ERROR in.csv was changed while work read it; run again when the file is complete.\n" in log
    assert not any(Path("results/r/p").iterdir()) and not ledger.read_records(RUN)


def test_an_input_that_was_only_touched_while_a_job_read_it_is_the_same(folder):
    run(during=lambda: os.utime("in.csv"))
    assert len(ledger.read_records(RUN)) == 1


def test_an_input_that_was_changed_after_planning_is_refused(folder):
    """Other jobs of the run may have read the former file."""
    planned = {"in.csv": Checksums().of("in.csv")}
    run(with_planned(planned))
    Path("in.csv").write_text("x\n2\n")
    with pytest.raises(SystemExit):
        run(with_planned(planned))
    assert (
        "ERROR in.csv was changed after the study had started; run again.\n"
        in Path("results/r/logs/p/work.log").read_text()
    )


def with_planned(planned):
    """A job whose rule has the checksums of its inputs as a parameter."""
    job = snakemake()
    job.params = Namedlist(fromdict={"code": "c0de", "inputs": planned})
    return job


def test_each_disagreement_is_one_sentence(folder):
    """Of two jobs in a row, and of a file that no job has recorded."""
    run()
    run(snakemake(["results/r/p/explained.csv"], ["results/r/q.csv"], "second"))
    metadata = folder / "metadata"
    for output in ("results/r/p/explained.csv", "results/r/q.csv"):
        path = ledger.path_of_metadata(metadata, output)
        path.parent.mkdir(exist_ok=True)
        path.write_text("{}")
    assert ledger.disagreements(RUN, metadata) == ledger.Disagreements()
    digit, times = Path("results/r/p/frames.csv"), os.stat("results/r/p/frames.csv")
    digit.write_text("y\n3\n")
    os.utime(digit, ns=(times.st_atime_ns, times.st_mtime_ns))
    changed = "frames.csv of p was changed after its job: it is computed again."
    found = ledger.disagreements(RUN, metadata)
    assert said(found) == {"results/r/p/frames.csv": changed} and "results/r/p/explained.csv" in found.results
    run()
    Path("in.csv").write_text("x\n7\n")
    os.utime("in.csv", LONG_AGO)
    found = said(ledger.disagreements(RUN, metadata))
    assert found == {
        "results/r/p/explained.csv": "explained.csv of p was made from another in.csv: it is computed again."
    }
    run(text="y\n9\n")
    found = said(ledger.disagreements(RUN, metadata))
    assert found == {
        "results/r/q.csv": "q.csv was made from another results/r/p/explained.csv: it is computed again."
    }
    run(snakemake(["results/r/p/explained.csv"], ["results/r/q.csv"], "second"))
    path.unlink()
    found = said(ledger.disagreements(RUN, metadata))
    assert found == {"results/r/q.csv": "q.csv has lost its metadata in .snakemake/: it is computed again."}
    assert said(ledger.disagreements(RUN)) == {}
    Path("results/r/p/residues.csv").write_text("")
    Path("results/r/p/.hidden").write_text("")
    found = said(ledger.disagreements(RUN))
    assert found == {
        "results/r/p/residues.csv": "residues.csv of p has no record of its job: it is computed again."
    }


def test_files_of_the_user_are_no_results(folder):
    """Notes beside results, in whatever folder; what a rule writes there without a record is one."""
    run()
    for name in ("notes.txt", "p/notes.txt", "p/c1/table.xlsx", "p/f0/mine.csv"):
        (RUN / name).parent.mkdir(exist_ok=True)
        (RUN / name).write_text("of the user")
    assert ledger.disagreements(RUN) == ledger.Disagreements()
    (RUN / "p/f0/minimal.csv").write_text("")
    assert [*ledger.disagreements(RUN).results] == ["results/r/p/f0/minimal.csv"]


def test_results_that_are_gone_need_no_word(folder):
    """Temporary ones that Snakemake removes, and what the user has deleted, which rules ask for where it is needed."""
    run()
    Path("results/r/p/explained.csv").unlink()
    assert ledger.disagreements(RUN) == ledger.Disagreements()


def test_of_many_that_disagree_in_one_way_the_number_is_said(folder):
    outputs = [f"results/r/p/{k}.csv" for k in range(30)]
    run(snakemake(outputs=outputs))
    for path in outputs[:21]:
        Path(path).write_text("")
    found = ledger.disagreements(RUN)
    assert found.lines == ["21 results in results/r/ were changed after their jobs: they are computed again."]
    assert not said(found) and found.results.keys() == {*outputs}


def test_of_two_jobs_that_wrote_one_file_the_later_counts(folder):
    """As `read_surface` and `compute_surface` do, where a protein becomes a surface."""
    for rule, text in (("first", "1"), ("later", "2")):
        run(snakemake(rule=rule), text)
    assert ledger.disagreements(RUN) == ledger.Disagreements()


def test_results_of_a_version_without_records_are_told_once_and_made_again(folder):
    run()
    (record,) = ledger.read_records(RUN)
    record.unlink()
    found = ledger.disagreements(RUN)
    (line,) = found.lines
    assert "results/r/ has no records of its jobs, as version 3.0.0 and earlier ones left it" in line
    assert found.results == dict.fromkeys(["results/r/p/explained.csv", "results/r/p/frames.csv"], "")


@pytest.mark.parametrize(
    "damage",
    [
        "",
        "{",
        "[]",
        '{"rule": "x"}',
        '{"rule": "x", "outputs": [], "unknown": 1}',
        '{"rule": "x", "outputs": {"a": 1}}',
        '{"rule": "x", "outputs": {"/etc/passwd": "0"}}',
        '{"rule": "x", "outputs": {"in.csv": "0"}}',
        '{"rule": "x", "outputs": {"results/r/../../in.csv": "0"}}',
        *(
            json.dumps({"rule": "x", "outputs": {"results/r/p/frames.csv": "0"}, "inputs": {name: "0"}})
            for name in ("a\0", "a" * 5000, "a/" * 3000, "\ud800")
        ),
    ],
)
def test_a_damaged_record_is_none(folder, damage):
    run()
    run(snakemake(["in.csv"], ["results/r/q.csv"], "second"))
    path = next(path for path, record in ledger.read_records(RUN).items() if record.rule == "work")
    path.write_text(damage)
    sentence = "{} of p has no record of its job: it is computed again."
    assert said(ledger.disagreements(RUN)) == {
        f"results/r/p/{name}": sentence.format(name) for name in ("explained.csv", "frames.csv")
    }


@pytest.mark.parametrize("key", ["outputs", "inputs"])
def test_an_edited_record_does_not_hold(folder, key):
    run()
    (path,) = ledger.read_records(RUN)
    content = json.loads(path.read_text())
    content[key] = {name: "0" * 64 for name in content[key]}
    path.write_text(json.dumps(content))
    assert said(ledger.disagreements(RUN))


def test_records_of_a_newer_version_are_refused(folder):
    run()
    (path,) = ledger.read_records(RUN)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"format": 2, "new": 1}))
    before = path.read_bytes(), Path("results/r/p/explained.csv").read_bytes()
    with pytest.raises(
        InputError, match=r"^results/r/ was written by a newer version of sparsurf, .* another `run`"
    ):
        ledger.disagreements(RUN)
    assert before == (path.read_bytes(), Path("results/r/p/explained.csv").read_bytes())


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES])
def test_a_record_that_cannot_be_written_is_a_sentence_and_keeps_other_results(folder, monkeypatch, number):
    run(snakemake(outputs=["results/r/kept.csv"], rule="earlier"))

    def full(path, *_):
        raise OSError(number, "words", str(path))

    with monkeypatch.context() as patch:
        patch.setattr(ledger, "write_json", full)
        with pytest.raises(SystemExit):
            run()
    (sentence,) = [
        line
        for line in Path("results/r/logs/p/work.log").read_text().splitlines()
        if line.startswith("ERROR")
    ]
    assert f"{os.strerror(number)}. Free or repair the disk and run again: finished results stay." in sentence
    assert Path("results/r/kept.csv").exists() and not Path("results/r/p/explained.csv").exists()
    assert ledger.disagreements(RUN) == ledger.Disagreements()


def test_other_versions_of_libraries_are_told_and_nothing_runs_again(folder, monkeypatch):
    run()
    now = ledger.versions()
    run(snakemake(rule="second", outputs=["results/r/q.csv"]))
    monkeypatch.setattr(ledger, "versions", lambda: now | {"numpy": "9.9"})
    run(snakemake(rule="third", outputs=["results/r/s.csv"]))
    found = ledger.disagreements(RUN)
    assert found.results == {} and len(found.lines) == 1
    assert found.lines[0].startswith(
        f"2 jobs of results/r/ computed with numpy {now['numpy']}, and 9.9 is installed now:"
    )
    told = ledger.libraries_of(RUN, ["results/r/q.csv", "results/r/s.csv"])
    assert (
        told[0] == f"numpy {' and '.join(sorted([now['numpy'], '9.9']))}"
        and told[1] == f"scipy {now['scipy']}"
    )
    assert ledger.libraries_of(RUN, ["results/r/s.csv"])[0] == "numpy 9.9"


def test_a_large_run_is_compared_by_sizes_and_times(folder, monkeypatch):
    """Which is said once; a change is found by them, whatever its date says."""
    outputs = [f"results/r/p/{k}.csv" for k in range(5)]
    run(snakemake(outputs=outputs))
    monkeypatch.setattr(ledger, "MOST_FILES", 4)
    monkeypatch.setattr(checksums, "SECONDS_UNTIL_SETTLED", -1.0)
    read = []
    monkeypatch.setattr(checksums, "checksum_of_file", lambda path: read.append(str(path)) or as_it_is(path))
    found = ledger.disagreements(RUN)
    assert len(found.lines) == 1 and "sizes and times tell" in found.lines[0] and not found.results
    assert {*outputs} <= {*read}
    read.clear()
    assert ledger.disagreements(RUN).lines == found.lines and read == []
    times = os.stat(outputs[2])
    Path(outputs[2]).write_text("y\n5\n")
    os.utime(outputs[2], ns=(times.st_atime_ns, times.st_mtime_ns))
    assert [*said(ledger.disagreements(RUN))] == [outputs[2]] and read == [outputs[2]]


as_it_is = checksums.checksum_of_file


def test_a_checksum_is_kept_until_the_file_changes(folder, monkeypatch):
    store, read = folder / "results/r/.ledger/.checksums.json", []
    store.parent.mkdir(parents=True)
    monkeypatch.setattr(checksums, "checksum_of_file", lambda path: read.append(str(path)) or as_it_is(path))

    def known():
        kept = Checksums(store)
        found = kept.of_all(["in.csv", "none.csv"])
        kept.save()
        return found["in.csv"], len(found)

    first = known()
    assert first == (as_it_is("in.csv"), 1) and known() == first
    assert read == ["in.csv"] * 2  # its entry was changed a moment ago, and might be again at the same time
    now = time.time()
    monkeypatch.setattr(checksums.time, "time", lambda: now + 3)
    assert [known(), known()] == [first] * 2 and len(read) == 3
    Path("in.csv").write_text("x\n2\n")
    os.utime("in.csv", LONG_AGO)  # of the same size and date
    assert known() == (as_it_is("in.csv"), 1) != first and len(read) == 4
    for damage in ("{", "[1]"):
        store.write_text(damage)
        assert known()[0] == as_it_is("in.csv")


def test_a_folder_is_read_by_one_of_the_jobs_of_its_conformations(folder, monkeypatch):
    """Each of a thousand would else read the structures of all."""
    read = []
    monkeypatch.setattr(checksums, "checksum_of_file", lambda path: read.append(str(path)) or as_it_is(path))
    monkeypatch.setattr(checksums, "SECONDS_UNTIL_SETTLED", -1.0)
    Path("results/r/p/structures").mkdir(parents=True)
    for k in range(3):
        Path(f"results/r/p/structures/f{k}.pdb").write_text(f"{k}")
    for k in range(2):
        run(snakemake(["results/r/p/structures"], [f"results/r/p/f{k}/explained.csv"], f"work_{k}"))
    assert len([path for path in read if path.endswith(".pdb")]) == 3
    first, second = ledger.read_records(RUN).values()
    assert (
        first.inputs == second.inputs == {"results/r/p/structures": Checksums().of("results/r/p/structures")}
    )
    Path("results/r/p/structures/f1.pdb").write_text("9")
    run(snakemake(["results/r/p/structures"], ["results/r/p/f3/explained.csv"], "work_3"))
    assert [*ledger.read_records(RUN).values()][-1].inputs != first.inputs


def test_a_folder_has_the_checksum_of_its_files_and_their_names(folder):
    for name in ("a/x.pdb", "a/sub/y.pdb"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(name)
    first = Checksums().of("a")
    Path("a/.snakemake_timestamp").write_text("")
    assert Checksums().of("a") == first
    Path("a/x.pdb").rename("a/z.pdb")
    assert Checksums().of("a") != first


def test_the_first_link_that_differs_is_named_from_the_inputs_to_the_page(folder):
    """And the code of a job; the links after it are not read."""
    run()
    run(snakemake(["results/r/p/explained.csv"], ["results/r/q.csv"], "second"))
    assert [*ledger.broken_links(RUN, {"c0de"})] == []
    assert next(ledger.broken_links(RUN, {"other"})) == "work had other code when it made explained.csv of p."
    Path("results/r/q.csv").write_text("9")
    assert [*ledger.broken_links(RUN, {"c0de"})] == ["q.csv was changed after second had made it."]
    Path("results/r/p/explained.csv").write_text("9")
    first, last = ledger.broken_links(RUN, {"c0de"})
    assert first == "explained.csv of p was changed after work had made it." and last.startswith("q.csv")
    Path("in.csv").write_text("9")
    assert (
        next(ledger.broken_links(RUN, {"c0de"}))
        == "in.csv is not the file from which work made explained.csv of p."
    )
    Path("in.csv").unlink()
    assert (
        next(ledger.broken_links(RUN, {"c0de"}))
        == "in.csv is missing, from which work made explained.csv of p."
    )


def test_what_is_written_without_a_job_where_others_failed_is_made_again_without_a_word(folder):
    run()
    Path("results/r/p/frames.csv").write_text("partial")
    ledger.replace_records(RUN, ["results/r/p/frames.csv"])
    Path("results/r/p/explained.csv").unlink()
    found = ledger.disagreements(RUN)
    assert found.results == {"results/r/p/frames.csv": ""} and not said(found)
    run()
    assert not ledger.disagreements(RUN).results  # once: the newer record counts


SIMULATED = {"structure": "in.pdb", "simulate": {"ns": 2}}
FETCHED = {"pdb": "1ubi"}


@pytest.fixture
def earlier(folder):
    """Results of a download and of a simulation of 3.0.0, with Snakemake's metadata; the config."""
    from sparsurf_study.workflow.config import check_config

    Path("in.pdb").write_text("")
    config = check_config({"proteins": {"s": SIMULATED, "d": FETCHED}, "seed": 4})
    stages = ["system/topol.top", "system.json", *(f"{stage}/end.gro" for stage in adoption.STAGES)]
    for name in [f"s/simulation/{stage}" for stage in stages] + [
        "d/download/1UBI.cif.gz",
        "s/c1/surface.npz",
    ]:
        (RUN / name).parent.mkdir(parents=True, exist_ok=True)
        (RUN / name).write_text(name)
    digest = checksums.checksum_of_file(RUN / "d/download/1UBI.cif.gz")
    origin = {"url": "https://files.rcsb.org/download/1UBI.cif.gz", "bytes": 1, "sha256": digest}
    (RUN / "d/download/1UBI.cif.gz.json").write_text(json.dumps(origin))
    simulate = config["proteins"]["s"]["simulate"]
    for output, params in (("system", [simulate, 4]), *((stage, [simulate, 4]) for stage in adoption.STAGES)):
        write_metadata(f"{RUN}/s/simulation/{output}", params)
    write_metadata(f"{RUN}/d/download/1UBI.cif.gz", [origin["url"], None])
    return config


def write_metadata(output, params):
    path = ledger.path_of_metadata(Path("metadata"), output)
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps({"params": [*map(repr, params), repr("the code")]}))


def test_downloads_and_simulations_of_an_earlier_version_are_kept(earlier):
    """Also where plain Snakemake asks, which adopts nothing."""
    assert [*ledger.disagreements(RUN).results] == ["results/r/s/c1/surface.npz"]
    adopted = adoption.adopt(earlier, RUN, Path("metadata"))
    assert [kept.log for kept in adopted] == [
        "s/prepare_system", *(f"s/simulate_{stage}" for stage in adoption.STAGES), "d/fetch_1UBI.cif.gz"
    ]  # fmt: skip
    words = adoption.adopted_in_words(adopted, RUN)
    assert (
        words
        == "Kept as they are in results/r/, without a complete record: 1 download and 5 stages of simulations."
    )
    found = ledger.disagreements(RUN, Path("metadata"))
    assert [*found.results] == ["results/r/s/c1/surface.npz"] and "no records of its jobs" in found.lines[0]
    assert adoption.adopt(earlier, RUN, Path("metadata")) == []  # told once
    for path in Path("metadata").iterdir():  # Snakemake has lost them
        path.unlink()
    assert len(adoption.adopt(earlier, RUN, Path("metadata"))) == 6
    adoption.forget(adopted, RUN)
    assert not ledger.read_records(RUN)


def test_downloads_and_simulations_with_other_parameters_are_not_kept(earlier):
    longer = {"proteins": earlier["proteins"] | {"s": earlier["proteins"]["s"] | {"simulate": {"ns": 9}}}}
    of_downloads = ["d/fetch_1UBI.cif.gz"]
    adopted = adoption.adopt(earlier | longer, RUN, Path("metadata"))
    assert [kept.log for kept in adopted] == of_downloads
    adoption.forget(adopted, RUN)
    assert [kept.log for kept in adoption.adopt(earlier | {"seed": 5}, RUN, Path("metadata"))] == of_downloads
    adoption.forget(adopted, RUN)
    (RUN / "d/download/1UBI.cif.gz").write_text("another file")
    (RUN / "s/simulation/system.json").unlink()
    kept = [kept.log for kept in adoption.adopt(earlier, RUN, Path("metadata"))]
    assert kept == [f"s/simulate_{stage}" for stage in adoption.STAGES]
    for path in Path("metadata").iterdir():
        path.unlink()
    assert adoption.adopt(earlier | longer, RUN, Path("metadata")) == []  # as their records tell


def test_a_download_from_another_address_is_not_kept(earlier):
    """Without records and metadata, what was written beside the file tells its address."""
    for path in Path("metadata").iterdir():
        path.unlink()
    protein = earlier["proteins"]["d"]
    kept = [
        [job.log for job in adoption.adopt({"proteins": {"d": entry}, "seed": 4}, RUN, Path("metadata"))]
        for entry in ({"url": "https://example.org/download/1UBI.cif.gz"}, protein)
    ]
    assert kept == [[], ["d/fetch_1UBI.cif.gz"]]


def test_the_record_of_a_real_job_names_the_code_of_its_script(study):
    records = ledger.read_records(study / "results" / "small")
    codes = {record.rule: record.code for record in records.values()}
    assert codes["measure_roughness"] == code_of("measure_roughness") and len(codes) > 25
