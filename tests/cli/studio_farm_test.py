#!/usr/bin/env python3
"""The studio and who traces for it: workers that join from elsewhere, farms that are elsewhere, and the
animations that come of it."""
import json
import os
import shlex
import unittest

import animation
import scenes
from png import read_png
from service_test import free_port
from studio_case import StudioTest
from tessera_process import wait_until

OVER = ("done", "failed", "cancelled")
MOVING = scenes.MOVING.replace("settings {", "settings { width: 48 height: 32")
MANY_TILES = {"size": "128x96", "spp": 16, "tile": 8}


class RenderingTest(StudioTest):
    def order(self, page, file="scene.tessera", **spec):
        """The number of the job that the page is told of next."""
        page.say("render", file=file, spec=spec)
        known = getattr(page, "known", set())
        new = page.receive("renders", where=lambda fields: {e["job"] for e in fields["list"]} - known)
        page.known = {each["job"] for each in new["list"]}
        return max(page.known - known)

    def entry(self, page, job, where):
        """The job's entry in the first list in which it is so."""
        def find(fields):
            return [each for each in fields["list"] if each["job"] == job and where(each)]
        return find(page.receive("renders", timeout=60, where=find))[0]

    def ended(self, page, job, state="done"):
        entry = self.entry(page, job, lambda each: each["state"] in OVER)
        self.assertEqual(state, entry["state"], entry)
        return entry

    def download(self, page, **wish):
        page.say("export", download=True, **wish)
        exported = page.receive("exported", "refused")
        self.assertIn("download", exported)
        content = b""
        while len(content) < exported["size"]:
            chunk = page.receive("pixels", where=lambda each: each.kind == 3)
            self.assertEqual(chunk.serial, exported["download"])
            content += chunk.body
        return exported, content

    def rendered_bytes(self, *arguments, name="own.png"):
        result = self.run_program("render", "--quiet", *map(str, arguments), "-o", self.folder / name)
        self.assertEqual(0, result.code, result.err)
        return (self.folder / name).read_bytes()


class Animations(RenderingTest):
    def test_all_frames_in_one_file(self):
        self.scene("moving.tessera", MOVING)
        page = self.page(self.studio("--workers", 2))
        job = self.order(page, "moving.tessera", frames=[2, 5], per_second=12.5,
                         outputs=["all.apng", "all.gif", "f.png"])
        entry = self.ended(page, job)
        self.assertEqual({"all.apng", "all.gif", *(f"f.000{i}.png" for i in range(2, 6))}, set(entry["written"]))
        frames, delays = animation.read_apng(self.opened / "all.apng")
        self.assertTrue(frames == [read_png(self.opened / f"f.000{i}.png") for i in range(2, 6)])
        self.assertEqual([(2, 25)] * 4, delays)
        self.assertEqual([8] * 4, animation.read_gif(self.opened / "all.gif")[1])
        # The command line that the page shows makes the same files.
        made = {name: (self.opened / name).read_bytes() for name in ("all.apng", "all.gif")}
        words = shlex.split(entry["command"])
        self.assertIn("--fps", words)
        result = self.run_program(*words[1:])
        self.assertEqual(0, result.code, result.err)
        for name, content in made.items():
            self.assertTrue((self.opened / name).read_bytes() == content, f"{name} differs")

    def test_the_rate_is_the_scenes_where_none_is_said(self):
        self.scene("moving.tessera", MOVING)
        page = self.page(self.studio("--workers", 1))
        self.ended(page, self.order(page, "moving.tessera", frames=[0, 1], outputs=["all.gif"]))
        self.assertEqual([10, 10], animation.read_gif(self.opened / "all.gif")[1])

    def test_a_file_that_is_there_is_kept(self):
        self.scene("moving.tessera", MOVING)
        (self.opened / "all.gif").write_bytes(b"mine")
        page = self.page(self.studio("--workers", 1))
        page.say("render", file="moving.tessera", spec={"frames": [0, 3], "outputs": ["all.gif"]})
        self.assertIn("all.gif", page.receive("refused")["why"])
        self.assertEqual(b"mine", (self.opened / "all.gif").read_bytes())
        self.ended(page, self.order(page, "moving.tessera", frames=[0, 1], outputs=["all.gif"], force=True))
        self.assertEqual(2, len(animation.read_gif(self.opened / "all.gif")[0]))

    def test_rates_that_are_none(self):
        self.scene("moving.tessera", MOVING)
        page = self.page(self.studio("--workers", 1))
        for wrong in (0, -1, "24", None):
            page.say("render", file="moving.tessera", spec={"frames": [0, 1], "per_second": wrong, "outputs": ["a.gif"]})
            if wrong is not None:
                self.assertIn("per_second", page.receive("refused")["why"])
        page.receive("renders", where=lambda fields: len(fields["list"]) == 1)


class Joining(RenderingTest):
    def joined(self, page, name):
        """What the page is told of the worker, once that traced a tile."""
        def find(fields):
            return [each for each in fields["list"] if each["name"].endswith(f":{name}") and each["tiles"] > 0]
        return find(page.receive("workers", timeout=60, where=find))[0]

    def test_a_worker_that_joins_traces_too(self):
        self.scene()
        for options in ((), ("--bind", "tcp://127.0.0.1:*")):
            with self.subTest(options=options):
                studio = self.studio("--workers", 1, *options)
                page = self.page(studio)
                command = page.welcome["worker_command"]
                self.assertRegex(command, "tcp://127.0.0.1:[1-9]" if options else "ipc://")
                words = shlex.split(command)
                self.assertEqual(["tessera", "worker"], words[:2])
                worker = self.start(*words[1:])
                page.receive("workers", timeout=60, where=lambda fields: len(fields["list"]) == 2)
                job = self.order(page, overrides=MANY_TILES)
                self.ended(page, job)
                self.joined(page, worker.pid)
                _, picture = self.download(page, job=job, name="a.png")
                self.assertTrue(self.rendered_bytes(self.opened / "scene.tessera", "--size", "128x96", "--spp", 16)
                                == picture, "the pictures differ")
                self.end_studio(studio)
                self.assertEqual(0, worker.wait(timeout=60), "it was not told to end")

    def test_only_keys_of_the_list_join(self):
        self.scene()
        for name, role in (("own", "coordinator"), ("node", "worker"), ("other", "worker")):
            self.assertEqual(0, self.run_program("keygen", f"{name}.key", "--role", role).code)
        self.write("farm.allow", (self.folder / "node.pub").read_text())
        studio = self.studio("--workers", 1, "--bind", "tcp://127.0.0.1:*", "--key", self.folder / "own.key", "--allow",
                             self.folder / "farm.allow")
        page = self.page(studio)
        words = shlex.split(page.welcome["worker_command"])
        self.assertEqual((self.folder / "own.pub").read_text().split()[0], words[words.index("--server-key") + 1])
        at = words.index("--key") + 1
        stranger = self.start(*words[1:at], self.folder / "other.key", *words[at + 1:])
        worker = self.start(*words[1:at], self.folder / "node.key", *words[at + 1:])
        page.receive("workers", timeout=60, where=lambda fields: len(fields["list"]) == 2)
        self.ended(page, self.order(page, overrides=MANY_TILES))
        self.joined(page, worker.pid)
        self.assertEqual(2, len(page.receive("workers")["list"]), "a stranger was let in")
        stranger.kill()
        # Who is taken off the list is shut out.
        self.write("farm.allow", "")
        os.kill(studio.process.pid, 1)
        page.receive("workers", timeout=60, where=lambda fields: not any(
            each["name"].endswith(f":{worker.pid}") and each["state"] == "active" for each in fields["list"]))
        worker.kill()

    def test_wrong_options_are_told(self):
        self.scene()

        def studio(*options):
            return self.run_program("studio", self.opened, "--no-open", *options)
        self.assert_error(studio("--key", "own.key"), 2, "--key", "--bind")
        self.assert_error(studio("--bind", "tcp://127.0.0.1:*", "--key", "own.key"), 2, "--allow")
        self.assert_error(studio("--bind", "tcp://0.0.0.0:*"), 2, "can be reached from other machines")
        self.assert_error(studio("--bind", "nonsense"), 2, "nonsense")



class Elsewhere(RenderingTest):
    """Full pictures that a farm traces."""

    def setUp(self):
        super().setUp()
        self.endpoint = f"tcp://127.0.0.1:{free_port()}"
        self.scene()

    def serve(self):
        process = self.start("serve", "--bind", self.endpoint, "--store", self.folder / "farm")
        self.assertIn("serving at", process.stdout.readline())
        return process

    def worker(self):
        return self.start("worker", "--connect", self.endpoint, "--threads", 2, "--quiet")

    def connected(self, *options):
        return self.page(self.studio("--workers", 1, "--connect", self.endpoint, *options))

    def jobs(self):
        return json.loads(self.run_program("status", "--connect", self.endpoint, "--json").out)["jobs"]

    def test_full_pictures_are_traced_there(self):
        service, worker = self.serve(), self.worker()
        page = self.connected()
        job = self.order(page, overrides={**MANY_TILES, "denoise": True, "integrator": "path"}, outputs=["a.exr"])
        self.ended(page, job)
        self.rendered_bytes(self.opened / "scene.tessera", "--size", "128x96", "--spp", 16, "--denoise", "--integrator",
                            "path", name="own.exr")
        result = self.run_program("compare", self.opened / "a.exr", "own.exr")
        self.assertEqual(0, result.code, result.out)
        self.assertRegex(result.out, r"max difference +0\n")
        # The studio's own worker has traced nothing of it.
        farm = page.receive("farm", where=lambda fields: "jobs" in fields)
        self.assertEqual(self.endpoint, farm["endpoint"])
        wait_until(lambda: self.jobs() == [], "the job is deleted where it was traced")
        self.stop(worker, service)

    def test_animations_too(self):
        service, worker = self.serve(), self.worker()
        self.scene("moving.tessera", MOVING)
        page = self.connected()
        self.ended(page, self.order(page, "moving.tessera", frames=[0, 2], outputs=["all.apng"]))
        self.rendered_bytes(self.opened / "moving.tessera", "--frames", "0-2", name="own.apng")
        self.assertTrue((self.opened / "all.apng").read_bytes() == (self.folder / "own.apng").read_bytes())
        self.stop(worker, service)

    def test_what_is_done_is_seen_while_it_is_traced(self):
        service, worker = self.serve(), self.worker()
        page = self.connected()
        job = self.order(page, overrides={**MANY_TILES, "spp": 65536})
        entry = self.entry(page, job, lambda each: 0 < each.get("tiles_done", 0) < each["tiles_total"])
        self.assertFalse(entry["has_picture"])
        exported, picture = self.download(page, job=job, name="part.png", show=True)
        self.assertTrue(exported["show"])
        (self.folder / "part.png").write_bytes(picture)
        width, height, pixels = read_png(self.folder / "part.png")
        self.assertEqual((128, 96), (width, height))
        black = sum(pixels[at:at + 3] == b"\0\0\0" for at in range(0, len(pixels), 3))
        self.assertTrue(0 < black < 128 * 96, "it is no part of a picture")
        listed = page.receive("farm", where=lambda fields: fields.get("jobs"))["jobs"]
        self.assertEqual("running", listed[0]["state"])
        page.say("order", job=job, what="cancel")
        self.ended(page, job, "cancelled")
        wait_until(lambda: self.jobs() == [], "it is deleted there")
        self.stop(worker, service)

    def test_pauses_there(self):
        service, worker = self.serve(), self.worker()
        page = self.connected()
        job = self.order(page, overrides={**MANY_TILES, "spp": 2048}, outputs=["a.pfm"])
        self.entry(page, job, lambda each: each.get("tiles_done", 0) > 0)
        page.say("order", job=job, what="pause")
        wait_until(lambda: [each["state"] for each in self.jobs()] == ["paused"], "the farm pauses it")
        done = self.jobs()[0]["tiles"]["done"]
        page.say("order", job=job, what="resume")
        self.ended(page, job)
        self.assertGreater(done, 0)
        own = self.rendered_bytes(self.opened / "scene.tessera", "--size", "128x96", "--spp", 2048, name="own.pfm")
        self.assertTrue((self.opened / "a.pfm").read_bytes() == own, "the pictures differ")
        self.stop(worker, service)

    def test_a_farm_that_is_lost_is_told_and_nothing_is_lost(self):
        service, worker = self.serve(), self.worker()
        page = self.connected()
        job = self.order(page, overrides={**MANY_TILES, "spp": 2048}, outputs=["a.pfm"])
        self.entry(page, job, lambda each: each.get("tiles_done", 0) > 0)
        service.kill()
        service.communicate()
        lost = page.receive("farm", timeout=60, where=lambda fields: "trouble" in fields)
        self.assertIn(self.endpoint, lost["trouble"])
        self.entry(page, job, lambda each: "does not answer" in each.get("waiting_for", ""))
        # Views go on meanwhile.
        self.show(page)
        self.last_picture(page)
        service = self.serve()
        page.receive("farm", timeout=60, where=lambda fields: "trouble" not in fields)
        self.ended(page, job)
        own = self.rendered_bytes(self.opened / "scene.tessera", "--size", "128x96", "--spp", 2048, name="own.pfm")
        self.assertTrue((self.opened / "a.pfm").read_bytes() == own, "the pictures differ")
        self.stop(worker, service)

    def stop(self, *processes):
        for process in processes:
            process.terminate()
            process.communicate(timeout=60)


class Here(RenderingTest):
    def test_what_is_done_is_seen_while_it_is_traced(self):
        self.scene()
        page = self.page(self.studio("--workers", 1))
        job = self.order(page, overrides={**MANY_TILES, "spp": 65536})
        self.entry(page, job, lambda each: 0 < each.get("tiles_done", 0) < each["tiles_total"])
        _, picture = self.download(page, job=job, name="part.png", show=True)
        (self.folder / "part.png").write_bytes(picture)
        width, height, pixels = read_png(self.folder / "part.png")
        self.assertEqual((128, 96), (width, height))
        black = sum(pixels[at:at + 3] == b"\0\0\0" for at in range(0, len(pixels), 3))
        self.assertTrue(0 < black < 128 * 96, "it is no part of a picture")
        page.say("order", job=job, what="cancel")
        self.ended(page, job, "cancelled")


if __name__ == "__main__":
    unittest.main()
