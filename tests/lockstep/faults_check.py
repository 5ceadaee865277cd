#!/usr/bin/python3
"""What can stand in the way of an exchange: /dev/shm too small or not writable, another user, two runs at once, what a dead
run left, a foreign file under its name; in shared memory and in a folder. One clear line, the right exit code, nothing harmed.
Called by ctest with the build folder. What needs rights that are lacking here (namespaces, other users) is said and left out."""
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
loader = importlib.machinery.SourceFileLoader("campaign", f"{root}/tools/kill-campaign")
loader.exec_module(campaign := importlib.util.module_from_spec(importlib.util.spec_from_loader("campaign", loader)))
folder = tempfile.mkdtemp(prefix="talik-faults-")
os.chmod(folder, 0o755)
scene = f"{folder}/scene.toml"
with open(scene, "w") as file:
    file.write(campaign.SCENE)
environment = dict(os.environ, TALIK_CACHE=f"{folder}/cache", OMP_NUM_THREADS="1")
count = 0


def start(*command, before=()):
    return subprocess.Popen([*before, *command], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def driver(exchange, before=()):
    global count
    count += 1
    return start(f"{build}/bin/mpm-driver", "run", scene, "--output", f"{folder}/out-{count}", "--threads", "1", "--quiet", "--until", "0.01", *(["--exchange", exchange] if exchange else []), before=before)


def farm(exchange, before=()):
    return start(f"{build}/bin/rve-farm", "serve", "--exchange", exchange, "--threads", "1", "--quiet", "--attach-seconds", "20", before=before)


def expect(process, code, words, what):
    try:
        out = process.communicate(timeout=60)[0]
    except subprocess.TimeoutExpired:
        process.kill()
        sys.exit(f"hang: {what}\n{process.communicate()[0]}")
    errors = [line for line in out.splitlines() if line.startswith("error: ")]
    holds = process.returncode == code and (words is None or (len(errors) == 1 and words in errors[0]))
    print(("ok    " if holds else "FAULT ") + what)
    if not holds:
        sys.exit(f"exit code {process.returncode} where {code} is due, one line with \"{words}\":\n{out}")


def signed(path):
    end = time.monotonic() + 10
    while time.monotonic() < end:
        with open(path, "rb") as file:
            if any(file.read(8)):
                return
        time.sleep(0.01)
    raise SystemExit(f"{path} was not signed within 10 s")


def appears(path):
    end = time.monotonic() + 30
    while not os.path.exists(path) and time.monotonic() < end:
        time.sleep(0.002)


try:
    expect(driver(None), 0, None, "a run, for its packings")
    if subprocess.run(["unshare", "-m", "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True).returncode == 0:
        mounted = lambda options: ["unshare", "-m", "sh", "-c", f"mount -t tmpfs -o {options} tmpfs /dev/shm && exec \"$@\"", "sh"]
        expect(driver(None, before=mounted("size=256k")), 4, "/dev/shm has 0.2 MiB, the exchange needs 2.0 MiB", "/dev/shm too small")
        expect(driver(None, before=mounted("ro")), 4, "cannot make shared memory in /dev/shm: Read-only file system", "/dev/shm not writable")
    else:
        print("left out: mount namespaces are not permitted here")

    name = f"faults-{os.getpid()}"
    first = driver(f"shm:{name}")
    appears(f"/dev/shm/talik-{name}")
    if os.geteuid() == 0 and shutil.which("setpriv"):
        nobody = ["setpriv", "--reuid", "65534", "--clear-groups"]
        expect(farm(f"shm:{name}", before=nobody), 2, "belongs to another user", "another user's farm, shared memory")
    expect(driver(f"shm:{name}"), 2, f"is in use by process {first.pid}", "two runs of one name at once")
    second = farm(f"shm:{name}")
    expect(first, 0, None, "the first run is none the worse")
    expect(second, 0, None, "and its farm")

    killed = driver(f"shm:{name}")
    appears(f"/dev/shm/talik-{name}")
    signed(f"/dev/shm/talik-{name}")  # one that is not is taken for new, for ten seconds
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    second = farm(f"shm:{name}")
    expect(driver(f"shm:{name}"), 0, None, "a segment left by a dead run does not bar the next")
    expect(second, 0, None, "nor its farm")
    assert not os.path.exists(f"/dev/shm/talik-{name}")

    foreign = f"/dev/shm/talik-{name}-foreign"
    with open(foreign, "w") as file:
        file.write("somebody else's" * 100)
    expect(driver(f"shm:{name}-foreign"), 2, "belongs to another user or program", "a foreign file under the name")
    with open(foreign) as file:
        assert file.read() == "somebody else's" * 100
    os.unlink(foreign)

    place = f"{folder}/exchange"
    first = driver(f"file:{place}")
    appears(f"{place}/driver.id")
    assert os.stat(place).st_mode & 0o777 == 0o700
    if os.geteuid() == 0 and shutil.which("setpriv"):
        expect(farm(f"file:{place}", before=nobody), 2, "belongs to another user", "another user's farm, a folder")
    expect(driver(f"file:{place}"), 2, "is in use by another run", "two runs in one folder at once")
    second = farm(f"file:{place}")
    expect(first, 0, None, "the first run is none the worse")
    expect(second, 0, None, "and its farm")
    killed = driver(f"file:{place}")
    appears(f"{place}/driver.id")
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    second = farm(f"file:{place}")
    expect(driver(f"file:{place}"), 0, None, "a folder left by a dead run does not bar the next")
    expect(second, 0, None, "nor its farm")
    os.makedirs(f"{folder}/letters")
    with open(f"{folder}/letters/to-mother.txt", "w") as file:
        file.write("dear")
    expect(driver(f"file:{folder}/letters"), 2, "holds files that are no exchange's", "a folder of other files")
    assert os.listdir(f"{folder}/letters") == ["to-mother.txt"]
    expect(driver(f"file:{scene}"), 2, "is not a folder", "a file in the folder's place")
finally:
    shutil.rmtree(folder, ignore_errors=True)
