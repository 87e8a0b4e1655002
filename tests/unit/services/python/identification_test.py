"""identify(), read_bids() and simulate(): the numbers of the programs."""

import math
import pathlib
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import tonus
from support import ankle, identified

NUMBERS = ("M_kg", "B_Ns_per_m", "K_N_per_m", "X0_m", "std", "ci95", "sigma_N", "condition_number", "explained_share",
           "checks", "status", "reasons", "lag_s", "lag_ci95_s", "band_Hz", "degrees_of_freedom", "samples", "units")


def trials_of(recording):
    """Each perturbation's rows by themselves: force, position, commanded, onset."""
    trials = []
    for event in recording.events.itertuples():
        onset = round(event.onset_s * recording.rate)
        first = max(0, onset - round(recording.rate))
        end = onset + round(event.duration_s * recording.rate) + 1  # as identify() takes them: to the event's end
        rows = slice(first, end)
        trials.append((recording.force[rows], recording.position[rows], recording.commanded[rows], onset - first))
    return trials


class MeasuredAnkle(unittest.TestCase):
    def test_a_dataset_gives_what_the_command_line_gives_to_the_last_bit(self):
        dataset = ankle()
        found = [e.as_dict() for e in tonus.read_bids(dataset).identify()]
        self.assertEqual(found, identified(dataset))

    def test_its_arrays_give_what_the_command_line_gives_to_the_last_bit(self):
        dataset = ankle()
        expected = identified(dataset, "--force-sign", "-1")
        recordings = tonus.read_bids(dataset, force_sign=-1)
        self.assertEqual(len(recordings), len(expected))
        for recording, wanted in zip(recordings, expected):
            found = tonus.identify(recording.force, recording.displacement, recording.rate,
                                   units=(recording.displacement_unit, recording.force_unit)).as_dict()
            for key in NUMBERS:
                self.assertEqual(found.get(key), wanted.get(key), key)

    def test_every_method_gives_what_the_command_line_gives(self):
        dataset = ankle()
        options = ("--method", "lowpass", "--model", "no_damping", "--cutoff", "25")
        found = tonus.read_bids(dataset)[0].identify(method="lowpass", model="no_damping", cutoff=25.0)
        self.assertEqual([e.as_dict() for e in found], identified(dataset, *options)[:1])


class SimulatedArm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.recording = tonus.simulate(seed=7)

    def test_the_same_profile_and_seed_give_the_same_bits_and_another_seed_gives_others(self):
        again, other = tonus.simulate(seed=7), tonus.simulate(seed=8)
        np.testing.assert_array_equal(again.force, self.recording.force)
        np.testing.assert_array_equal(again.position, self.recording.position)
        self.assertFalse(np.array_equal(other.force, self.recording.force))

    def test_half_the_joint_stiffness_in_a_profile_is_half_the_stiffness_found(self):
        text = "[subject.joint_stiffness_Nm_per_rad]\nshoulder = 11.0\nelbow = 8.5\ntwo_joint = 4.0\n"
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "soft.toml"
            file.write_text(text)
            soft = tonus.simulate(file, seed=7).identify()[0]
        ratio = soft.K / self.recording.identify()[0].K  # the default: 22, 17 and 8
        np.testing.assert_allclose(ratio, np.full((2, 2), 0.5), atol=0.02)

    def test_arrays_of_two_axes_give_what_the_raw_recording_gives_to_the_last_bit(self):
        forces, places, commands, onsets = zip(*trials_of(self.recording))
        found = tonus.identify(list(forces), list(places), self.recording.rate, onset=list(onsets),
                               commanded=list(commands), handle_mass=self.recording.handle_mass).as_dict()
        wanted = self.recording.identify()[0].as_dict()
        for key in NUMBERS:
            self.assertEqual(found.get(key), wanted.get(key), key)

    def test_an_estimate_gives_arrays_units_and_ellipses(self):
        estimate = self.recording.identify()[0]
        self.assertTrue(estimate.is_ok, estimate)
        self.assertEqual(estimate.K.shape, (2, 2))
        self.assertEqual(estimate.ci95.K.shape, (2, 2, 2))
        self.assertTrue(np.all(estimate.ci95.K[..., 0] <= estimate.K))
        self.assertTrue(np.all(estimate.K <= estimate.ci95.K[..., 1]))
        self.assertEqual(estimate.units["K"], "N/m")
        ellipse = estimate.ellipse("K")
        values = np.linalg.eigvalsh((estimate.K + estimate.K.T) / 2)  # ascending: the closed form
        self.assertAlmostEqual(ellipse.size / (math.pi * values[0] * values[1]), 1.0, places=12)
        self.assertAlmostEqual(ellipse.shape, values[1] / values[0], places=12)

    def test_a_table_has_a_row_for_each_estimate_and_units_in_its_names(self):
        estimates = self.recording.identify(method="all")
        frame = tonus.table(estimates)
        self.assertEqual(list(frame.method), ["lowpass", "optimal", "state_variable", "refined"])
        self.assertEqual(frame.K_xy_N_per_m[2], estimates[2].K[0, 1])
        self.assertEqual(frame.K_xy_std_N_per_m[2], estimates[2].std.K[0, 1])
        self.assertEqual(frame.X0_y_high95_m[0], estimates[0].ci95.X0[1, 1])

    def test_other_threads_run_during_long_work(self):
        # With this interval Python takes the lock from nobody: it changes hands only where it is given up.
        before = sys.getswitchinterval()
        progress = {"began": False, "ended": False}

        def work():
            progress["began"] = True
            tonus.simulate(seed=1, sets=20)
            progress["ended"] = True

        sys.setswitchinterval(1000.0)
        try:
            worker = threading.Thread(target=work)
            worker.start()
            seen = False
            while worker.is_alive():
                seen = seen or (progress["began"] and not progress["ended"])
                time.sleep(0)
            worker.join()
        finally:
            sys.setswitchinterval(before)
        self.assertTrue(progress["ended"])
        self.assertTrue(seen, "the interpreter's lock was held during simulate()")


class WrongInput(unittest.TestCase):
    def refused(self, kind, pattern, call):
        with self.assertRaisesRegex(kind, pattern) as caught:
            call()
        self.assertIsInstance(caught.exception, tonus.Error)
        self.assertNotIn("\n", str(caught.exception))

    def test_is_refused_with_one_line_that_names_value_and_limit(self):
        x, f = np.zeros((100, 2)), np.zeros((100, 2))
        cases = [
            (ValueError, "displacement of 99 rows is not allowed; expected 100", lambda: tonus.identify(f, x[:99], 200)),
            (ValueError, "columns", lambda: tonus.identify(f, x[:, 0], 200)),
            (ValueError, r"force: shape \(100, 3\)", lambda: tonus.identify(np.zeros((100, 3)), x, 200)),
            (ValueError, "rate: 0", lambda: tonus.identify(f, x, 0)),
            (ValueError, "rate: nan", lambda: tonus.identify(f, x, float("nan"))),
            (ValueError, "onset: row 100", lambda: tonus.identify(f, x, 200, onset=100)),
            (ValueError, "onset: row -1", lambda: tonus.identify(f, x, 200, onset=-1)),
            (ValueError, "method: .*'magic'", lambda: tonus.identify(f, x, 200, method="magic")),
            (ValueError, "model: .*'magic'", lambda: tonus.identify(f, x, 200, model="magic")),
            (ValueError, "window", lambda: tonus.identify(f, x, 200, window=-1.0)),
            (ValueError, "2 trials are not allowed; expected 1", lambda: tonus.identify([f], [x, x], 200)),
            (ValueError, "'all' is not allowed", lambda: tonus.identify(f, x, 200, method="all")),
            (ValueError, "posture: 'nowhere'", lambda: tonus.simulate(posture="nowhere")),
            (ValueError, "seed: -1", lambda: tonus.simulate(seed=-1)),
            (ValueError, "sets: 0", lambda: tonus.simulate(sets=0)),
            (ValueError, "profile_toml", lambda: tonus.simulate(profile_toml="[subject]\nunknown = 1\n")),
            (LookupError, "does not exist", lambda: tonus.simulate("/nonexistent/profile.toml")),
            (LookupError, "nonexistent", lambda: tonus.read_bids("/nonexistent")),
            (ValueError, "force_sign|sign", lambda: tonus.read_bids(ankle(), force_sign=3)[0]),
        ]
        for kind, pattern, call in cases:
            try:
                self.refused(kind, pattern, call)
            except unittest.SkipTest:
                continue

    def test_a_posture_out_of_reach_is_refused(self):
        self.refused(tonus.Error, "", lambda: tonus.simulate(posture="far", posture_m=(3.0, 3.0)))

    def test_an_unknown_setting_is_a_type_error(self):
        with self.assertRaisesRegex(TypeError, "no setting 'windou'"):
            tonus.simulate().identify(windou=1.0)

    def test_too_little_data_is_undetermined_and_has_no_numbers(self):
        rng = np.random.default_rng(1)
        estimate = tonus.identify(rng.normal(size=(400, 2)), rng.normal(size=(400, 2)), 200.0, onset=200)
        self.assertEqual(estimate.status, "undetermined")
        self.assertTrue(np.all(np.isnan(estimate.K)))
        self.assertTrue(estimate.reasons)

    def test_a_gap_in_a_trial_leaves_it_out_with_the_reason(self):
        recording = tonus.simulate(seed=7)
        trials = trials_of(recording)
        forces = [t[0].copy() for t in trials]
        forces[3][250] = np.nan
        estimate = tonus.identify(forces, [t[1] for t in trials], recording.rate, onset=[t[3] for t in trials])
        self.assertEqual(estimate.trials_used, 15)
        self.assertEqual([t["trial"] for t in estimate.trials_rejected], [4])
        self.assertIn("missing", estimate.trials_rejected[0]["reason"])


if __name__ == "__main__":
    unittest.main()
