"""The notebooks of examples/python run as they are."""

import os
import pathlib
import tempfile
import unittest

import nbclient
import nbformat

from support import RECORDED, SOURCE, ankle, own_domain, run
from system import System

NOTEBOOKS = SOURCE / "examples/python"


class Notebooks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # Kernels' own files go into the test's folder.
        self.environment(JUPYTER_RUNTIME_DIR=str(self.folder / "runtime"), IPYTHONDIR=str(self.folder / "ipython"),
                         JUPYTER_CONFIG_DIR=str(self.folder / "config"), PYDEVD_DISABLE_FILE_VALIDATION="1",
                         MPLBACKEND="module://matplotlib_inline.backend_inline")

    def environment(self, **variables):
        for name, value in variables.items():
            before = os.environ.get(name)
            os.environ[name] = value
            restore = (lambda n=name: os.environ.pop(n)) if before is None else (
                lambda n=name, b=before: os.environ.__setitem__(n, b))
            self.addCleanup(restore)

    def execute(self, name):
        """What the notebook's cells give; an error of a cell is the test's."""
        notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
        nbclient.NotebookClient(notebook, timeout=200, kernel_name="python3").execute()
        text = []
        for cell in notebook.cells:
            for output in cell.get("outputs", []):
                self.assertNotEqual(output.get("name"), "stderr", output)
                text.append(output.get("text") or output.get("data", {}).get("text/plain", ""))
        return "\n".join(text)

    def test_a_measured_record_from_file_to_matrices(self):
        ankle()
        output = self.execute("measured_record")
        self.assertIn("N m s/rad", output)
        self.assertIn("<Figure", output)

    def test_a_studys_tables(self):
        data = self.folder / "data"
        for subject in ("sub-01", "sub-02"):
            run("demo", RECORDED.parent / "protocol.toml", "--data", data, "--domain", own_domain(), "--subject", subject,
                "--rig-seed", subject[-1])
        self.environment(TONUS_ARCHIVE=str(data / "archive.sqlite"))
        output = self.execute("study_tables")
        self.assertIn("sub-02", output)
        self.assertRegex(output, r"largest displacement \d\.\d\d mm of 5 mm commanded")

    def test_a_live_session(self):
        system = System(self.folder)
        self.addCleanup(system.stop)
        self.environment(TONUS_GATEWAY=system.url)
        session = system.run()
        self.addCleanup(session.communicate, timeout=60)
        output = self.execute("live_session")
        self.assertIn("completed: 8 of 8 trials counted", output)
        self.assertIn("state_variable", output)


if __name__ == "__main__":
    unittest.main()
