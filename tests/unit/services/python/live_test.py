"""subscribe(): a whole session, live, from the gateway."""

import asyncio
import os
import pathlib
import signal
import socket
import tempfile
import time
import unittest

import numpy as np

import tonus
from system import System


class LiveSession(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.system = System(cls.folder.name)
        cls.addClassCleanup(cls.system.stop)

    def test_states_verdicts_and_estimates_of_a_session_arrive_as_it_runs(self):
        verdicts, estimates, phases = {}, {}, set()
        with tonus.subscribe(self.system.url, timeout=60.0) as live:
            first = next(live)  # the rig is there: the session may begin
            self.assertIn(first.topic, tonus.live.TOPICS)
            session = self.system.run()
            deadline = time.monotonic() + 120.0
            for message in live:
                self.assertLess(time.monotonic(), deadline, (phases, verdicts))
                if message.topic == "trial/verdict":
                    verdicts[message.data["trial_id"]] = message.data["is_valid"]
                elif message.topic == "session/state":
                    phases.add(message.data["phase"])
                elif message.estimate is not None:
                    estimates[message.data["estimate_id"]] = message.estimate
                # Topics come in no order among each other.
                if "completed" in phases and len(verdicts) == 8 and any(e.trials_used == 8 for e in estimates.values()):
                    break
        output, _ = session.communicate(timeout=60)
        self.assertEqual(session.returncode, 0, output)
        self.assertEqual(list(verdicts.values()), [True] * 8)
        self.assertIn("running", phases)
        estimate = next(iter(estimates.values()))
        self.assertEqual(estimate.trials_used, 8)
        self.assertTrue(estimate.is_ok)
        published = self.archived(estimate.trials_used)
        np.testing.assert_array_equal(estimate.K, published.K)
        np.testing.assert_array_equal(estimate.ci95.M, published.ci95.M)
        np.testing.assert_array_equal(estimate.posture_m, published.posture_m)

    def archived(self, trials):
        """The estimate of so many trials, once the archive has it: its commits come after the gateway's news."""
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            for estimate in tonus.open(self.system.data).session().published:
                if estimate.trials_used == trials:
                    return estimate
        raise AssertionError(f"the archive has no estimate of {trials} trials")

    def test_works_with_async_and_inside_of_a_running_loop(self):
        async def once(topic):
            async with tonus.subscribe(self.system.url, [topic], timeout=60.0) as live:
                async for message in live:
                    return message.topic

        async def sync_inside():
            with tonus.subscribe(self.system.url, ["rig/state"], timeout=60.0) as live:
                return next(iter(live)).topic

        self.assertEqual(asyncio.run(once("rig/state")), "rig/state")
        self.assertEqual(asyncio.run(sync_inside()), "rig/state")

    def test_silence_is_a_timeout_after_which_it_can_be_used_further(self):
        with tonus.subscribe(self.system.url, ["estimate/live"], timeout=0.05) as live:
            for _ in range(2):
                with self.assertRaisesRegex(tonus.TimeoutError, "nothing came within 0.05 s"):
                    next(live)

    def test_a_topic_that_does_not_exist_is_refused(self):
        with self.assertRaisesRegex(tonus.UnavailableError, "400.*topic"):
            next(tonus.subscribe(self.system.url, ["rig/samples"]))

    def test_an_address_of_another_kind_and_nobody_there_are_one_line(self):
        with self.assertRaisesRegex(tonus.InvalidArgumentError, "ftp://.*expected http"):
            tonus.subscribe("ftp://host")
        with socket.socket() as taken:  # bound, and nobody listens
            taken.bind(("127.0.0.1", 0))
            with self.assertRaisesRegex(tonus.UnavailableError, "cannot be reached") as caught:
                next(tonus.subscribe(f"http://127.0.0.1:{taken.getsockname()[1]}"))
        self.assertNotIn("\n", str(caught.exception))

    def test_a_closed_subscription_gives_nothing_more(self):
        live = tonus.subscribe(self.system.url, ["rig/state"], timeout=60.0)
        next(live)
        live.close()
        live.close()
        self.assertEqual(list(live), [])


class EndOfTheGateway(unittest.TestCase):
    def test_is_an_error_that_says_so_and_a_wrong_token_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens = pathlib.Path(folder) / "tokens.toml"
            tokens.write_text('view = ["view-token-0123456789"]\noperate = ["operate-token-0123456789"]\n')
            os.chmod(tokens, 0o600)
            system = System(folder, "--dashboard-tokens", str(tokens))
            self.addCleanup(system.stop)
            for token in (None, "wrong-token-0123456789"):
                with self.assertRaisesRegex(tonus.UnavailableError, "401.*token") as caught:
                    next(tonus.subscribe(system.url, token=token))
                self.assertNotIn("wrong-token", str(caught.exception))
            live = tonus.subscribe(system.url, ["rig/state"], token="view-token-0123456789", timeout=60.0)
            next(live)
            system.process.send_signal(signal.SIGTERM)
            with self.assertRaisesRegex(tonus.UnavailableError, "ended the connection"):
                for message in live:
                    self.assertEqual(message.topic, "rig/state")
            self.assertEqual(list(live), [])


if __name__ == "__main__":
    unittest.main()
