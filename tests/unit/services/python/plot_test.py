"""tonus.plot: what is drawn."""

import math
import unittest

import matplotlib.pyplot as plt
import numpy as np

import tonus


def curves(axes):
    """Lines of many points: the ellipses."""
    return [line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 10]


class Outline(unittest.TestCase):
    def test_semi_axes_are_the_eigenvalues_along_the_eigenvectors(self):
        angle = math.radians(30.0)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        line = tonus.plot.outline(turn @ np.diag([300.0, 100.0]) @ turn.T, points=721)
        radius = np.hypot(line[:, 0], line[:, 1])
        self.assertAlmostEqual(radius.max(), 300.0, places=9)
        self.assertAlmostEqual(radius.min(), 100.0, places=9)
        far = line[radius.argmax()]
        self.assertAlmostEqual(math.degrees(math.atan2(far[1], far[0])) % 180.0, 30.0, places=6)

    def test_only_the_symmetric_part_counts(self):
        curl = np.array([[0.0, 40.0], [-40.0, 0.0]])
        matrix = np.array([[300.0, 20.0], [20.0, 200.0]])
        np.testing.assert_allclose(tonus.plot.outline(matrix + curl), tonus.plot.outline(matrix))

    def test_a_matrix_that_is_not_positive_definite_or_not_2_by_2_is_refused(self):
        for matrix in (np.diag([1.0, -1.0]), np.eye(3), np.array([[np.nan, 0.0], [0.0, 1.0]])):
            with self.assertRaises(tonus.Error):
                tonus.plot.outline(matrix)


class Ellipses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.estimates = [e for name in ("reference", "right") for e in tonus.simulate(seed=2, posture=name).identify()]

    def tearDown(self):
        plt.close("all")

    def test_stand_at_their_postures_at_one_scale(self):
        axes = tonus.plot.ellipses(self.estimates, scale=1e-4)
        drawn = curves(axes)
        self.assertEqual(len(drawn), 2)
        for estimate, line in zip(self.estimates, drawn):
            np.testing.assert_allclose((line.max(axis=0) + line.min(axis=0)) / 2, estimate.posture_m, atol=1e-12)
            values = np.linalg.eigvalsh((estimate.K + estimate.K.T) / 2)
            radius = np.hypot(*(line - estimate.posture_m).T)
            self.assertAlmostEqual(radius.max() / (1e-4 * values[1]), 1.0, places=4)

    def test_say_what_they_show_and_in_which_units(self):
        axes = tonus.plot.ellipses(self.estimates, "B")
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("x (m)", "y (m)"))
        self.assertIn("B", axes.get_title())
        self.assertTrue(any("N s/m" in text.get_text() for text in axes.texts))
        self.assertEqual([t.get_text() for t in axes.get_legend().get_texts()], ["reference", "right"])

    def test_without_anything_to_draw_is_one_line(self):
        with self.assertRaisesRegex(tonus.InvalidArgumentError, "ellipses: 0 estimates"):
            tonus.plot.ellipses([])
        with self.assertRaisesRegex(tonus.InvalidArgumentError, "'X0' is not allowed"):
            tonus.plot.ellipses(self.estimates, "X0")


if __name__ == "__main__":
    unittest.main()
