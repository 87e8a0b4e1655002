"""What the tests of the package share."""

import fcntl
import functools
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["TONUS_PROGRAM"]
SOURCE = pathlib.Path(os.environ["TONUS_SOURCE"])
RECORDED = SOURCE / "tests/acceptance/recorded_session/session.sqlite"


def run(*arguments):
    """What `tonus` prints; an error with its text where it fails."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=240)
    if done.returncode != 0:
        raise AssertionError(f"tonus {' '.join(map(str, arguments))}: {done.returncode}: {done.stderr}")
    return done.stdout


def identified(source, *options):
    """The conditions of `tonus identify SOURCE --json`."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "results.json"
        run("identify", source, *options, "--json", file)
        return json.loads(file.read_text())["conditions"]


def ankle():
    """The measured ankle's dataset; skips, with the reason, where it is not there."""
    data = os.environ.get("TONUS_DATA_DIR")
    if not data or not (pathlib.Path(data) / "ankle/dataset_description.json").exists():
        raise unittest.SkipTest("TONUS_DATA_DIR does not name a folder with measured records (ankle/)")
    return pathlib.Path(data) / "ankle"


@functools.lru_cache(maxsize=None)
def own_domain():
    """A DDS domain that no other test has, as own_domain() of tests/support; locked until the process ends."""
    start = os.getpid() % 120
    for i in range(120):
        candidate = 100 + (start + i) % 120
        file = os.open(f"/tmp/tonus-test-domain-{candidate}.lock", os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return str(candidate)
        except OSError:
            os.close(file)
    raise AssertionError("no DDS domain from 100 to 219 is free")
