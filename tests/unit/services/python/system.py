"""A whole system of services, for tests that look on while it runs."""

import pathlib
import re
import signal
import subprocess

from support import PROGRAM, RECORDED, own_domain


class System:
    """`tonus up --dashboard` on loopback, in a folder and a DDS domain of its own."""

    def __init__(self, folder, *options):
        self.data = pathlib.Path(folder) / "data"
        self.process = subprocess.Popen(
            [PROGRAM, "up", "--data", str(self.data), "--domain", own_domain(), "--speed", "max", "--dashboard",
             "--dashboard-listen", "127.0.0.1:0", *options],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for line in self.process.stdout:
            found = re.search(r"https?://127\.0\.0\.1:\d+", line)
            if found:
                self.url = found.group(0)
                return
        self.stop()
        raise AssertionError("the system printed no address")

    def run(self, *options):
        """Runs the recorded session's protocol, as another program."""
        return subprocess.Popen([PROGRAM, "run", str(RECORDED.parent / "protocol.toml"), "--data", str(self.data),
                                 "--domain", own_domain(), *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True)

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        self.process.wait(timeout=60)
        self.process.stdout.close()
