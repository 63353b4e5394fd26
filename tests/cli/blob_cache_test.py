#!/usr/bin/env python3
"""What a worker has of a scene is never sent again: kept on disk, or in memory shared on one machine."""
import pathlib
import signal
import subprocess

from tessera_process import PROGRAM, TesseraTest

FRAME = ["--size", "64x48", "--spp", "1"]
SIDE = 200


def hills(side=SIDE):
    """A mesh of 79,202 triangles, well over a megabyte."""
    lines = [f"v {i / side} {j / side} {((i * 7919 + j * 104729) % 97) / 2000}"
             for j in range(side) for i in range(side)]
    for j in range(side - 1):
        for i in range(side - 1):
            a = j * side + i + 1
            lines += [f"f {a} {a + 1} {a + side}", f"f {a + 1} {a + side + 1} {a + side}"]
    return "\n".join(lines) + "\n"


class BlobCache(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("hills.obj", hills())
        self.cache = self.folder / "cache"
        self.alone = self.render(self.scene, "--workers", "0", *FRAME)
        self.serve = self.start("serve", "--bind", "tcp://127.0.0.1:*")
        self.endpoint = self.serve.stdout.readline().split()[-1]
        self.workers = []

    def worker(self, *options, prefix=()):
        worker = subprocess.Popen(
            [*prefix, PROGRAM, "worker", "--connect", self.endpoint, "--threads", "1", *options],
            cwd=self.folder, env=self.environment(), text=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(self.end, worker)
        self.workers.append(worker)
        return worker

    def cached(self, *options, **more):
        return self.worker("--cache", self.cache, *options, **more)

    def stop(self, worker):
        worker.send_signal(signal.SIGTERM)
        _, err = worker.communicate(timeout=20)
        self.assertEqual(0, worker.returncode, err)
        self.workers.remove(worker)
        return err

    def shipped(self, *options):
        """Bytes of the scene that one render sends to the workers; the picture must be right."""
        stats = self.render(self.scene, "--connect", self.endpoint, *FRAME, *options)
        if not options:
            self.assertEqual(self.alone["pixels_sha256"], stats["pixels_sha256"])
        return stats["bytes"]["scene"]

    def files(self):
        return sorted(p for p in self.cache.iterdir() if p.suffix != ".tmp")

    def tearDown(self):
        for worker in list(self.workers):
            self.stop(worker)
        self.serve.send_signal(signal.SIGTERM)
        self.assertEqual(0, self.serve.wait(10))
        super().tearDown()

    def test_it_is_sent_once_over_restarts(self):
        worker = self.cached()
        whole = self.shipped()
        self.assertGreater(whole, 1 << 20)
        self.assertEqual(0, self.shipped())  # it holds the built scene still
        self.stop(worker)
        self.assertGreaterEqual(sum(f.stat().st_size for f in self.files()), whole)
        worker = self.cached()
        self.assertEqual(0, self.shipped())
        # Another seed needs the scene built anew, of the same blobs.
        self.assertEqual(0, self.shipped("--seed", "7"))
        self.stop(worker)
        # Without it, all is sent again.
        self.worker()
        self.assertEqual(whole, self.shipped())

    def test_a_damaged_file_is_fetched_again(self):
        worker = self.cached()
        whole = self.shipped()
        self.stop(worker)
        largest = max(self.files(), key=lambda f: f.stat().st_size)
        content = bytearray(largest.read_bytes())
        content[len(content) // 2] ^= 1
        largest.write_bytes(content)
        worker = self.cached()
        self.assertEqual(largest.stat().st_size, self.shipped())
        self.assertIn("is damaged", self.stop(worker))
        self.cached()
        self.assertEqual(0, self.shipped())
        self.assertGreater(whole, 0)

    def test_a_disk_that_is_full_is_gone_on_without(self):
        worker = self.cached(prefix=("prlimit", "--fsize=65536"))
        whole = self.shipped()
        self.assertGreater(whole, 1 << 20)
        self.assertIn("goes on without", self.stop(worker))
        self.assertTrue(all(f.stat().st_size <= 65536 for f in self.files()))

    def test_the_budget_holds(self):
        worker = self.cached("--cache-budget", "1M")
        self.shipped()
        self.stop(worker)
        self.assertLessEqual(sum(f.stat().st_size for f in self.files()), 1 << 20)

    def test_workers_of_one_machine_share_it(self):
        first = self.cached()
        whole = self.shipped()
        self.stop(first)
        for _ in range(3):
            self.cached()
        self.assertEqual(0, self.shipped())
        self.assertGreater(whole, 0)

    def test_local_workers_map_the_memory_of_their_coordinator(self):
        stats = self.render(self.scene, "--workers", "3", *FRAME)
        self.assertEqual(self.alone["pixels_sha256"], stats["pixels_sha256"])
        # Beside the description itself, only small blobs travel.
        self.assertLess(stats["bytes"]["scene"], 3 * (64 << 10))

    def test_wrong_options_are_told(self):
        def worker(*options):
            return self.run_program("worker", "--connect", self.endpoint, *options)
        self.assert_error(worker("--cache-budget", "1G"), 2, "--cache")
        self.assert_error(worker("--cache", "c", "--cache-budget", "1X"), 2, "500M or 10G")
        self.assert_error(worker("--cache", "c", "--cache-budget", "0"), 2, "500M or 10G")
        self.assert_error(worker("--cache", "hills.obj"), 2, "is no folder")
        self.cache.mkdir(mode=0o700)
        self.cache.chmod(0o777)
        self.assert_error(worker("--cache", self.cache), 2, "others can write")
