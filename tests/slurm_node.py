"""A real Slurm of one node on the loopback address: started for a test, and ended after it.

Needs Debian's slurm-wlm and munge, and root; `missing` says what is lacking. Without accounting, as many small
clusters are, or with it, for which slurmdbd and mariadb-server are needed.
"""

import getpass
import os
import shutil
import signal
import socket
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

CPUS = 2
CONFIGURED = Path(
    "/etc/slurm/slurm.conf"
)  # the steps of a job look there: Snakemake hides SLURM_CONF from them
PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "scancel", "munged", "munge")
PROGRAMS_OF_ACCOUNTS = ("slurmdbd", "mariadbd", "mariadb-install-db", "sacct")
SETTINGS = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
SlurmdParameters=config_overrides
MinJobAge=600
SchedulerParameters=sched_interval=2,batch_sched_delay=0,sched_min_interval=100000
{accounting}
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=2
JobAcctGatherParams=OverMemoryKill
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
PartitionName=short Nodes={host} MaxTime=1 State=UP
"""

NO_ACCOUNTING = "AccountingStorageType=accounting_storage/none"
ACCOUNTING = """\
AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=127.0.0.1
AccountingStoragePort={port}
AccountingStoragePass={folder}/munge.socket"""
OF_ACCOUNTS = """\
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
DbdHost={host}
DbdAddr=127.0.0.1
DbdPort={port}
SlurmUser=root
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort={database}
StorageUser=slurm
StorageLoc=slurm
LogFile={folder}/slurmdbd.log
PidFile={folder}/slurmdbd.pid
"""
GRANT = "CREATE USER slurm@{place}; GRANT ALL ON *.* TO slurm@{place};"

_started = []  # processes of the running node


class DidNotStart(Exception):
    """Its daemons are there, but this machine does not let them run."""


def missing(accounts=False):
    """Why no Slurm, with accounts if wanted, can be started here; an empty text where it can."""
    programs = [*PROGRAMS, *(PROGRAMS_OF_ACCOUNTS if accounts else ())]
    lacking = [name for name in programs if shutil.which(name) is None]
    if lacking:
        return f"{lacking[0]} is not installed (tests/install_extras.sh)"
    if CONFIGURED.exists():
        return "this machine has a Slurm of its own"
    return "" if getpass.getuser() == "root" else "Slurm's daemons need root"


@contextmanager
def running(folder, accounts=False):
    """Environment, a dict, in which Slurm's commands speak to a node of one's own; its state is in `folder`."""
    folder = Path(folder)
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    environment = os.environ | {"SLURM_CONF": str(folder / "slurm.conf")}
    host = socket.gethostname().split(".")[0]
    megabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20
    *ports, port, database = free_ports(4)
    values = {
        "host": host,
        "folder": folder,
        "ports": ports,
        "cpus": CPUS,
        "port": port,
        "database": database,
    }
    values["accounting"] = (ACCOUNTING if accounts else NO_ACCOUNTING).format(**values)
    (folder / "slurm.conf").write_text(SETTINGS.format(memory=megabytes * 9 // 10, **values))
    CONFIGURED.parent.mkdir(exist_ok=True)
    CONFIGURED.unlink(missing_ok=True)  # a link that leads nowhere: its run was killed
    CONFIGURED.symlink_to(folder / "slurm.conf")
    try:
        _started.append(start_munge(folder))
        if accounts:
            start_accounts(folder, environment, values)
        for daemon in ("slurmctld", "slurmd"):
            start_daemon(daemon, environment)
        wait_until_up(environment, folder)
        yield environment
    finally:
        subprocess.run(["scancel", "--user", "root"], env=environment, check=False, capture_output=True)
        time.sleep(1)
        CONFIGURED.unlink()
        while _started:
            process = _started.pop()
            process.send_signal(signal.SIGTERM)
            process.wait(20)


def start_daemon(daemon, environment):
    """Start one of Slurm's daemons, which stays in the foreground."""
    conf = Path(environment["SLURM_CONF"])
    with open(conf.with_name(f"{daemon}.out"), "ab") as out:
        command = [daemon, "-D", "-f", conf]
        _started.append(subprocess.Popen(command, env=environment, stdout=out, stderr=out))


def start_accounts(folder, environment, values):
    """Start slurmdbd above a database of its own, and register the cluster."""
    (folder / "slurmdbd.conf").write_text(OF_ACCOUNTS.format(**values))
    (folder / "slurmdbd.conf").chmod(0o600)
    own = ["--no-defaults", "--user=root", f"--datadir={folder}/database"]
    create = ["mariadb-install-db", *own, "--auth-root-authentication-method=normal"]
    subprocess.run(create, check=True, capture_output=True)
    place = [f"--socket={folder}/database.socket", f"--port={values['database']}"]
    more = ["--bind-address=127.0.0.1", f"--pid-file={folder}/database.pid"]
    daemons = {"mariadbd": ["mariadbd", *own, *place, *more], "slurmdbd": ["slurmdbd", "-D"]}
    grant = "".join(GRANT.format(place=name) for name in ("localhost", "'127.0.0.1'"))
    ready = {
        "mariadbd": ["mariadb", "--no-defaults", "--user=root", place[0], "--execute", grant],
        "slurmdbd": ["sacctmgr", "--immediate", "add", "cluster", "test"],
    }
    for name, command in daemons.items():
        with open(folder / f"{name}.out", "wb") as out:
            _started.append(subprocess.Popen(command, env=environment, stdout=out, stderr=out))
        for _ in range(60):
            if subprocess.run(ready[name], env=environment, capture_output=True, check=False).returncode == 0:
                break
            time.sleep(0.5)
        else:
            raise DidNotStart(f"{name} did not come up: {(folder / f'{name}.out').read_text()[-1000:]}")


@contextmanager
def without_controller(environment):
    """End slurmctld, which keeps its state, and start it again at the end."""
    (controller,) = (process for process in _started if process.args[0] == "slurmctld")
    controller.terminate()
    controller.wait()
    _started.remove(controller)
    try:
        yield
    finally:
        start_daemon("slurmctld", environment)


def start_munge(folder):
    """munged with a key and a socket of its own, in the foreground."""
    key, place = folder / "munge.key", folder / "munge"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    place.mkdir(mode=0o755)
    names = {"key-file": key, "socket": folder / "munge.socket", "pid-file": place / "pid"}
    names |= {"log-file": place / "log", "seed-file": place / "seed"}
    command = ["munged", "--foreground", "--force", *(f"--{name}={path}" for name, path in names.items())]
    with open(folder / "munged.out", "wb") as out:
        return subprocess.Popen(command, stdout=out, stderr=out)


def wait_until_up(environment, folder):
    """Return when the node takes jobs."""
    for _ in range(60):
        answer = subprocess.run(
            ["sinfo", "-h", "-o", "%t"], env=environment, capture_output=True, text=True, check=False
        )
        if answer.stdout.strip() in ("idle", "mix", "alloc"):
            return
        time.sleep(0.5)
    logs = "".join(path.read_text(errors="replace")[-1000:] for path in folder.glob("*.out"))
    raise DidNotStart(f"Slurm did not come up: {answer.stdout}{answer.stderr}\n{logs}")


def free_ports(n):
    """`n` ports of the loopback address that nobody listens on."""
    sockets = [socket.socket() for _ in range(n)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports
