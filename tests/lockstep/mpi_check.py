#!/usr/bin/python3
"""Runs over MPI with 1, 2 and 4 farms, cut and gone on with by another number, ended by SIGTERM, and robbed of a farm: the
history of the run that nobody disturbed, to the byte. Called by ctest with the build folder; 77 means skipped."""
import importlib.machinery
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

build, root = sys.argv[1], os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
if not shutil.which("mpirun"):
    print("skipped: no mpirun here")
    sys.exit(77)
loader = importlib.machinery.SourceFileLoader("campaign", f"{root}/tools/kill-campaign")
loader.exec_module(campaign := importlib.util.module_from_spec(importlib.util.spec_from_loader("campaign", loader)))
folder = tempfile.mkdtemp(prefix="talik-mpi-")
scene = f"{folder}/scene.toml"
with open(scene, "w") as file:
    file.write(campaign.SCENE.replace("0.08 s", "0.4 s").replace("-0.1 m/s", "-0.02 m/s"))  # long enough to be met half way
environment = dict(os.environ, TALIK_CACHE=f"{folder}/cache", OMP_NUM_THREADS="1", TALIK_BUILD=build, ASAN_OPTIONS="detect_leaks=0")  # MPI's own


def finish(process):
    try:
        out = process.communicate(timeout=120)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        sys.exit(f"hang: {process.args}\n{process.communicate()[0]}")
    return process.returncode, out


def start(output, farms, *more):
    command = [f"{root}/tools/run-mpi", "-n", str(farms), scene, "--output", f"{folder}/{output}", "--threads", "1", *more]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)


def history(output):
    with open(f"{folder}/{output}/history.csv", "rb") as file:
        return file.read()


def check(holds, what, out=""):
    print(("ok    " if holds else "FAULT ") + what)
    if not holds:
        sys.exit(out)


def farms_of(job):
    """Process ids of the rve-farm processes below a job."""
    found, open_ones = [], [job.pid]
    while open_ones:
        pid = open_ones.pop()
        try:
            if os.readlink(f"/proc/{pid}/exe").endswith("/rve-farm"):
                found.append(pid)
            for task in os.listdir(f"/proc/{pid}/task"):
                with open(f"/proc/{pid}/task/{task}/children") as file:
                    open_ones += [int(child) for child in file.read().split()]
        except OSError:
            pass
    return found


def half_way(output, job):
    """Until a few checkpoints have been written."""
    end = time.monotonic() + 60
    while time.monotonic() < end and job.poll() is None:
        newest = campaign.newest_checkpoint(f"{folder}/{output}")
        if newest and int(newest[-9:]) >= 60:
            return
        time.sleep(0.002)


try:
    plain = subprocess.run([f"{build}/bin/mpm-driver", "run", scene, "--output", f"{folder}/plain", "--threads", "1", "--quiet"], env=environment)
    check(plain.returncode == 0, "a run over shared memory, for comparison")
    for farms in (1, 2, 4):
        code, out = finish(start(f"mpi-{farms}", farms, "--quiet"))
        check(code == 0 and history(f"mpi-{farms}") == history("plain"), f"{farms} farm(s) over MPI: the same history", out)

    code, out = finish(start("cut", 2, "--quiet", "--until", "0.1"))
    check(code == 0, "a run cut half way, with 2 farms", out)
    code, out = finish(start("cut", 3, "--quiet", "--restart", campaign.newest_checkpoint(f"{folder}/cut")))
    check(code == 0 and history("cut") == history("plain"), "gone on with by 3: the same history", out)

    job = start("term", 2)
    half_way("term", job)
    os.kill(job.pid, signal.SIGTERM)  # as a batch system does before its time is up
    code, out = finish(job)
    check(code == 1 and ("stopped by SIGUSR1 at t =" in out or "stopped because the farm was asked to end at t =" in out), "SIGTERM: an emergency checkpoint", out)
    code, out = finish(start("term", 1, "--quiet", "--restart", campaign.newest_checkpoint(f"{folder}/term")))
    check(code == 0 and history("term") == history("plain"), "gone on with from there by 1 farm: the same history", out)

    job = start("killed", 2, "--restarts", "2")
    half_way("killed", job)
    victims = farms_of(job)
    if victims:
        os.kill(victims[-1], signal.SIGKILL)
    code, out = finish(job)
    check(bool(victims) and code == 0 and f"the farm (process {victims[-1]}) died without a word" in out, "a killed farm is named, not its survivors", out)
    check(history("killed") == history("plain"), "and tools/run-mpi starts the job again: the same history", out)
finally:
    shutil.rmtree(folder, ignore_errors=True)
