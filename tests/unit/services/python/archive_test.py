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


class AuxiliaryChannels(unittest.TestCase):
    """A session with the EMG of two muscles of the simulated subject and a trigger."""

    PROTOCOL = """schema = 1
kind = "unloaded"
name = "muscles"
posture = [{ name = "reference", position_m = [0.0, 0.38] }]
antagonists = [{ first = "ElbowFlexor", second = "ElbowExtensor" }]
[perturbation]
directions = 4
sets = 1
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [0.8, 1.0]
wait_s = [1.0, 1.2]
end_rest_s = 0.2
[reference_contraction]
trials = 1
duration_s = 1.0
"""
    PROFILE = "".join(
        f'[[auxiliary]]\nname = "{name}"\ntype = "{kind}"\nunit = "{unit}"\nrate_Hz = {rate}\n'
        for name, kind, unit, rate in (("ElbowFlexor", "EMG", "mV", 2000.0), ("ElbowExtensor", "EMG", "mV", 1000.0),
                                       ("Onset", "TRIG", "n/a", 200.0)))

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        (cls.folder / "protocol.toml").write_text(cls.PROTOCOL)
        (cls.folder / "profile.toml").write_text(cls.PROFILE)
        run("demo", cls.folder / "protocol.toml", "--profile", cls.folder / "profile.toml", "--data", cls.folder / "data",
            "--domain", own_domain())
        cls.archive = cls.folder / "data" / "archive.sqlite"
        cls.session = tonus.open(cls.archive).session()

    def test_have_the_values_and_times_of_the_csv_export(self):
        out = self.folder / "csv"
        run("export", self.session.id, "--archive", self.archive, "--format", "csv", "--out", out)
        for trial in self.session.trials:
            table = pd.read_csv(out / "auxiliary" / f"trial-{trial.attempt}.csv", float_precision="round_trip",
                                keep_default_na=False, na_values=[""])
            self.assertEqual(list(trial.auxiliary), ["ElbowFlexor", "ElbowExtensor", "Onset"])
            for name, channel in trial.auxiliary.items():
                rows = table[table.channel == name]
                np.testing.assert_array_equal(channel.values, rows.value.to_numpy(np.float32))
                np.testing.assert_allclose(channel.time, rows.time_s, rtol=0, atol=1e-12)
                self.assertEqual({channel.unit}, set(rows.unit))

    def test_stand_on_the_time_axis_of_the_trial(self):
        trial = self.session.trials[1]
        for name, rate in (("ElbowFlexor", 2000.0), ("ElbowExtensor", 1000.0), ("Onset", 200.0)):
            channel = trial.auxiliary[name]
            self.assertEqual(channel.rate, rate)
            self.assertEqual(len(channel.values), len(trial) * rate / 200.0)
            self.assertAlmostEqual(channel.time[-1], trial.time[-1], places=9)
        onset = trial.auxiliary["Onset"]
        self.assertAlmostEqual(onset.time[np.argmax(onset.values > 0.5)], 0.0, places=9)

    def test_verdicts_have_the_activity_relative_to_the_contraction(self):
        for trial in self.session.trials[1:]:
            self.assertEqual(set(trial.muscles), {"ElbowFlexor", "ElbowExtensor"})
            self.assertTrue(trial.muscles["ElbowFlexor"]["is_normalised"])
            self.assertLess(trial.muscles["ElbowFlexor"]["before_onset"], 0.05)
            self.assertGreater(trial.co_contraction, 0.5)

    def test_of_a_rig_without_them_are_none(self):
        archive = self.folder / "recorded.sqlite"
        shutil.copy(RECORDED, archive)
        trial = tonus.open(archive).session().trials[0]
        self.assertEqual(trial.auxiliary, {})
        self.assertEqual(trial.muscles, {})
        self.assertTrue(np.isnan(trial.co_contraction))


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
