#!/usr/bin/env python3
"""Farm test 28: no file descriptor is left, in the coordinator or in a worker."""
import os
import resource
import signal
import socket
import time
import unittest

from service_test import ServiceTest
from tessera_process import wait_until


def limited(count):
    """Between fork and exec: so many descriptors and no more."""
    return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (count, count))}


def processor_seconds(process):
    with open(f"/proc/{process.pid}/stat", encoding="ascii") as stat:
        fields = stat.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Descriptors(ServiceTest):
    LIMIT = 80

    def test_a_coordinator_turns_away_whom_it_has_none_for(self):
        service = self.start("serve", "--bind", self.endpoint, "--store", self.store,
                             **limited(self.LIMIT))
        self.assertIn("serving at", service.stdout.readline())
        worker = self.worker()
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        port = int(self.endpoint.rpartition(":")[2])
        held = []
        while len(held) < 2 * self.LIMIT:  # each is ended if it says nothing for 5 s
            try:
                held.append(socket.create_connection(("127.0.0.1", port), timeout=5))
            except OSError:
                break
        before, used = time.monotonic(), processor_seconds(service)
        self.assertEqual(self.expected(), self.pixels_of(job, worker))
        for one in held:
            one.close()
        # It must not have spent all the while in circles: one thread of it would be busy throughout.
        self.assertLess(processor_seconds(service) - used, 0.5 * (time.monotonic() - before) + 1)
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=60)
        self.assertEqual(0, service.returncode, log)
        self.assertIn(log.count("no file descriptor is left"), (1, 2), log)  # a channel
        self.assertEqual(0, worker.wait(60))

    def pixels_of(self, job, worker):
        """Once the job has ended, of which the worker's old connection tells while no new ones are
        let in; a client gets in when those that say nothing are ended."""
        wait_until(lambda: self.run_program("status", job, "--connect", self.endpoint).code == 0,
                   "a client gets in again")
        self.assertIsNone(worker.poll())
        return self.pixels(job)

    def test_too_few_to_begin_with_is_an_error(self):
        for command in (["serve", "--bind", "tcp://127.0.0.1:*"],
                        ["worker", "--connect", self.endpoint, "--quiet", "--threads", 1],
                        ["status", "--connect", self.endpoint]):
            for count in (6, 8, 12, 20):
                with self.subTest(command=command[0], count=count):
                    result = self.run_program(*command, **limited(count))
                    self.assertEqual(3, result.code, result.err)
                    self.assertIn("descriptor", result.err)


del ServiceTest

if __name__ == "__main__":
    unittest.main()
