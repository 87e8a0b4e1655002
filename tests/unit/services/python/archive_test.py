"""open(): archives as arrays and tables."""

import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np
import pandas as pd

import tonus
from support import PROGRAM, RECORDED, identified, own_domain, run


class RecordedSession(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.file = pathlib.Path(cls.folder.name) / "archive.sqlite"
        shutil.copy(RECORDED, cls.file)
        cls.session = tonus.open(cls.file).session()

    def test_every_trial_has_the_rows_of_the_csv_export(self):
        out = pathlib.Path(self.folder.name) / "csv"
        run("export", self.session.id, "--archive", self.file, "--format", "csv", "--out", out)
        for trial in self.session.trials:
            rows = pd.read_csv(out / "samples" / f"trial-{trial.attempt}.csv", float_precision="round_trip")
            np.testing.assert_array_equal(trial.time, rows.time_s)
            np.testing.assert_array_equal(trial.position, rows[["x_m", "y_m"]])
            np.testing.assert_array_equal(trial.force, rows[["fx_N", "fy_N"]])
            np.testing.assert_array_equal(trial.commanded, rows[["xc_m", "yc_m"]])
            np.testing.assert_array_equal(trial.phase, rows.phase)
            self.assertEqual(trial.time[trial.onset], 0.0)

    def test_displacement_is_the_position_from_the_posture(self):
        trial = self.session.trials[0]
        np.testing.assert_array_equal(trial.displacement, trial.position - np.array([0.0, 0.38]))

    def test_all_rows_at_once_are_the_rows_of_the_trials_without_a_copy(self):
        again = self.session.refresh()
        samples = again.samples
        self.assertEqual(len(samples), sum(len(t) for t in again.trials))
        for trial, (first, end) in zip(again.trials, samples.bounds):
            self.assertTrue(np.shares_memory(trial.force, samples.force))
            np.testing.assert_array_equal(trial.force, samples.force[first:end])
        single = self.session.trials[5]
        np.testing.assert_array_equal(single.force, again.trials[5].force)

    def test_nothing_can_be_written(self):
        for name in ("time", "force", "position", "displacement", "commanded", "phase", "is_missing"):
            with self.assertRaises(ValueError):
                getattr(self.session.trials[0], name)[0] = 0

    def test_estimates_are_those_that_were_published_and_those_of_today_to_the_last_bit(self):
        shown = json.loads(run("show", self.session.id, "--archive", self.file, "--json"))["conditions"]
        self.assertEqual([e.as_dict() for e in self.session.published], shown)
        anew = self.session.identify(method="all")
        self.assertEqual([e.as_dict() for e in anew], identified(self.file, "--method", "all"))
        frame = self.session.estimates
        self.assertEqual(len(frame), len(shown))
        self.assertEqual(frame.K_xx_N_per_m[0], shown[0]["K_N_per_m"][0][0])
        self.assertEqual(list(frame.y_m), [0.38] * len(frame))

    def test_a_trial_of_the_table_is_the_trial_that_the_command_line_shows(self):
        shown = json.loads(run("show", self.session.id, "--archive", self.file, "--json"))["trials"]
        frame = self.session.trials_table
        self.assertEqual(list(frame.attempt), [t["attempt"] for t in shown])
        self.assertEqual(list(frame.direction_deg), [t["direction_deg"] for t in shown])
        self.assertEqual(list(frame.is_valid), [t["is_valid"] for t in shown])
        self.assertEqual(list(frame.rows), [t["samples"]["expected"] for t in shown])

    def test_the_file_stays_as_it_is_byte_for_byte(self):
        before = self.file.read_bytes()
        session = tonus.open(self.file).session()
        session.samples, session.estimates, session.identify()
        self.assertEqual(self.file.read_bytes(), before)

    def test_the_data_folder_and_the_file_are_the_same_archive(self):
        self.assertEqual(tonus.open(self.folder.name).session().id, self.session.id)

    def test_a_session_is_found_by_the_beginning_of_its_id(self):
        self.assertEqual(tonus.open(self.file).session(self.session.id[:8]).id, self.session.id)

    def test_arrays_live_longer_than_what_they_were_read_from(self):
        force = tonus.open(self.file).session().trials[0].force
        np.testing.assert_array_equal(force, self.session.trials[0].force)


class WrongArchive(unittest.TestCase):
    def refused(self, kind, pattern, call):
        with self.assertRaisesRegex(kind, pattern) as caught:
            call()
        self.assertIsInstance(caught.exception, tonus.Error)
        self.assertNotIn("\n", str(caught.exception))

    def test_is_refused_by_its_kind_with_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            (place / "text.sqlite").write_text("no archive at all, but longer than a header of SQLite would be" * 40)
            (place / "short.sqlite").write_bytes(RECORDED.read_bytes()[:100_000])
            self.refused(tonus.NotFoundError, "no such file", lambda: tonus.open(place / "none.sqlite"))
            self.refused(tonus.NotFoundError, "no such file", lambda: tonus.open(place))
            self.refused(tonus.Error, "text.sqlite", lambda: tonus.open(place / "text.sqlite"))
            self.refused(tonus.Error, "short.sqlite", lambda: tonus.open(place / "short.sqlite").session().samples)
            self.refused(tonus.InvalidArgumentError, "ftp://", lambda: tonus.open("ftp://host/archive"))
            self.refused(tonus.Error, "postgresql://.*", lambda: tonus.open("postgresql://nobody@127.0.0.1:1/none"))
            self.refused(tonus.NotFoundError, "ffff", lambda: tonus.open(RECORDED.parent / "session.sqlite")
                         .session("ffff"))
            self.assertEqual(sorted(p.name for p in place.iterdir()), ["short.sqlite", "text.sqlite"])

    def test_one_damaged_block_costs_its_rows_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "archive.sqlite"
            shutil.copy(RECORDED, file)
            import sqlite3
            connection = sqlite3.connect(file)
            with connection:
                connection.execute("UPDATE blocks SET payload = zeroblob(length(payload)) WHERE block = "
                                   "(SELECT block FROM blocks ORDER BY first_sequence LIMIT 1 OFFSET 3)")
            connection.close()
            session = tonus.open(file).session()
            whole = tonus.open(RECORDED).session()
            missing = int(session.samples.is_missing.sum())
            self.assertGreater(missing, 0)
            self.assertLess(missing, 300)
            self.assertTrue(np.all(np.isnan(session.samples.force[session.samples.is_missing])))
            there = ~session.samples.is_missing
            np.testing.assert_array_equal(session.samples.force[there], whole.samples.force[there])


class RunningArchive(unittest.TestCase):
    def test_is_read_while_it_is_written(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder) / "data"
            protocol = RECORDED.parent / "protocol.toml"
            system = subprocess.Popen([PROGRAM, "demo", str(protocol), "--data", str(place), "--domain",
                                       own_domain()], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            self.addCleanup(system.wait)
            self.addCleanup(lambda: system.poll() is None and system.kill())
            counts = []
            while system.poll() is None:
                try:
                    session = tonus.open(place).session()
                except tonus.Error:  # before the first session there is no archive, or an empty one
                    self.assertFalse(counts, "the archive could be read before")
                    continue
                counts.append(len(session.samples))
            error = system.stderr.read()
            system.stderr.close()
            self.assertEqual(system.returncode, 0, error)
            session = tonus.open(place).session()
            counts.append(len(session.samples))
            self.assertEqual(counts, sorted(counts))
            self.assertTrue(session.is_whole)
            self.assertEqual(session.state["phase"], "completed")
            self.assertEqual(session.state["counted"], session.planned_trials)


if __name__ == "__main__":
    unittest.main()
