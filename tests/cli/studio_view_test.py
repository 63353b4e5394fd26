#!/usr/bin/env python3
"""The pictures of `tessera studio` over its socket, and when they are made anew."""
import contextlib
import pathlib
import shutil
import socket
import unittest

from color_management_test import CONFIG
from studio_case import SAMPLES, SCENE, SIZE, ViewTest
from studio_client import Page
from tessera_process import nightly

READ = (".tessera", ".crt", ".x3d", ".x3dv", ".gltf", ".glb", ".obj", ".ply", ".stl")
ONE = {"spp": 1}


MOVING_SCRIPT = """\
Settings { camera -> Camera { position -> vec3(0, 0, -20) pointing -> vec3(0, 0, 0) fov -> 45 } }
Scene { Sphere { center -> vec3(t, 0, 0) radius -> 1 material -> Material { color -> rgb(1, 0, 0) } } }
"""


class SamePixels(ViewTest):
    def test_the_last_picture_is_that_of_render(self):
        page = self.begin()
        self.show(page)
        piece, shown = self.last_picture(page)
        self.assertEqual((1, 4, 1, SIZE), (piece.scale, piece.samples, piece.version, piece.picture))
        self.assert_same(self.rendered(), shown)

    @nightly
    def test_all_samples(self):
        size = (48, 32)
        names = sorted(each.name for each in SAMPLES.iterdir() if each.suffix in READ)
        self.assertGreater(len(names), 20)
        for path in SAMPLES.iterdir():
            shutil.copy(path, self.opened)
        studio = self.studio("--workers", 2)
        for name in names:
            with self.subTest(name):
                page = self.page(studio)
                self.show(page, name, size=size, overrides={"spp": 4})
                _, shown = self.last_picture(page)
                self.assert_same(self.rendered(name, "--spp", 4, size=size), shown)
                page.close()

    def test_after_edits(self):
        self.text = SCENE
        page = self.begin()
        self.show(page)
        version = 1
        for number in range(1, 12):
            version = self.replace(page, version, "radius: 1.", f"radius: 1.{number % 4}")
        version = self.replace(page, version, "}\nnodes", "} # ä\nnodes")
        page.say("save", file="scene.tessera")
        page.receive("saved")
        version = self.replace(page, version, "r: .7", "r: .2")
        piece, shown = self.last_picture(page, version=version)
        page.say("save", file="scene.tessera")
        page.receive("saved")
        self.assert_same(self.rendered(), shown)

    def test_no_older_picture_after_a_newer(self):
        self.text = SCENE
        page = self.begin()
        self.show(page, size=(480, 270))
        version = 1
        for number in range(30):
            version = self.replace(page, version, "radius: 1.", f"radius: 1.{number % 4}")
            if number % 5 == 0:
                page.receive("pixels")
                page.waiting = [each for each in page.waiting if each[0] != "edited"]
        versions, serials = [], []
        while True:
            piece = page.receive("pixels")
            versions.append(piece.version)
            serials.append(piece.serial)
            if piece.flags & 2 and piece.version == version:
                break
        self.assertEqual(sorted(versions), versions)
        self.assertEqual(sorted(serials), serials)

    def test_cameras_frames_and_options(self):
        turning = SCENE + ('cameras { name: "side" world_from_camera { steps { look_at { eye { x: 5 } '
                           'target { } } } } perspective { field_of_view: 70 } }\n')
        self.begin(turning)
        for wish, options in (({"camera": {"name": "side"}}, ("--camera", "side")),
                              ({"overrides": {"spp": 9}}, ("--spp", 9)),
                              ({"overrides": {"integrator": "path", "seed": 7}}, ("--integrator", "path", "--seed", 7)),
                              ({"overrides": {"max-depth": 1, "shadows": "off"}}, ("--max-depth", 1, "--shadows", "off")),
                              ({"overrides": {"spp": 4, "filter": "gaussian"}}, ("--spp", 4, "--filter", "gaussian")),
                              ({"tone": {"exposure": 1.5, "tone-map": "reinhard"}},
                               ("--exposure", 1.5, "--tone-map", "reinhard"))):
            with self.subTest(wish):
                page = self.page(self.running)
                self.show(page, **wish)
                _, shown = self.last_picture(page)
                self.assert_same(self.rendered("scene.tessera", *options), shown)
                page.close()

    def test_a_free_camera_at_the_place_of_the_scenes(self):
        page = self.begin()
        self.show(page, overrides=ONE)
        _, scenes = self.last_picture(page)
        free = {"eye": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40}
        self.show(page, overrides=ONE, camera=free)
        _, narrow = self.last_picture(page)
        self.assertNotEqual(scenes, narrow)
        written = SCENE.replace('} target { } } } }', '} target { } } } } perspective { field_of_view: 40 }')
        self.scene("narrow.tessera", written)
        self.assert_same(self.rendered("narrow.tessera", "--spp", 1), narrow)
        self.show(page, overrides=ONE, camera={**free, "orthographic": 4})
        _, flat = self.last_picture(page)
        self.assertNotIn(flat, (scenes, narrow))
        self.show(page, overrides=ONE)
        self.assert_same(scenes, self.last_picture(page)[1])


class ColorManaged(ViewTest):
    def environment(self):
        return {**super().environment(), "OCIO": str(self.folder / "config.ocio")}

    def test_a_view_of_the_configuration(self):
        self.write("config.ocio", CONFIG)
        page = self.begin()
        self.show(page, tone={"ocio-view": "halved", "exposure": 1})
        _, shown = self.last_picture(page)
        self.assert_same(self.rendered("scene.tessera", "--ocio-view", "halved", "--exposure", 1), shown)
        self.show(page, tone={"ocio-view": "quartered"})
        why = page.receive("job", where=lambda job: job["state"] == "failed")["why"]
        self.assertIn("quartered", why)
        self.show(page, tone={"ocio-view": "as is"})
        _, shown = self.last_picture(page)
        self.assert_same(self.rendered("scene.tessera", "--ocio-view", "as is"), shown)


class Jobs(ViewTest):
    def test_a_view_that_failed_says_why_each_time(self):
        page = self.begin()
        self.show(page, camera={"eye": [0, 0, 5], "target": [0, 0, 5], "up": [0, 1, 0], "fov": 40})
        for _ in range(2):  # at once, and when the text was read again for the place of the fault
            self.assertTrue(page.receive("job", where=lambda job: job["state"] == "failed").get("why"))

    def test_what_changes_no_scene_starts_nothing(self):
        self.text = SCENE
        page = self.begin()
        self.show(page)
        self.last_picture(page)
        before = self.jobs(page)
        version = self.replace(page, 1, "settings", "# a comment\n\n  settings")
        self.problems(page, version)
        self.show(page)
        self.assertEqual(before, self.jobs(page))

    def test_a_picture_that_the_page_knows_is_not_made_again(self):
        self.text = MOVING_SCRIPT
        page = self.begin(MOVING_SCRIPT, file="a.crt")
        known = {}
        for frame in (1, 2):
            self.show(page, "a.crt", frame=frame)
            known[frame] = page.receive("job", where=lambda job: job["state"] == "done")["digest"]
            self.last_picture(page)
        self.assertNotEqual(known[1], known[2])
        made = self.jobs(page)
        version = self.replace(page, 1, "Scene", "-- a comment\nScene", file="a.crt")
        for frame in (1, 2, 1):
            self.show(page, "a.crt", frame=frame, known=known[frame])
            told = page.receive("job", where=lambda job: job.get("unchanged"))
            self.assertEqual((frame, known[frame], version), (told["frame"], told["digest"], told["version"]))
        self.assertEqual(made, self.jobs(page))
        # Another frame from now on, and the same as before in frame 1.
        version = self.replace(page, version, "vec3(t, 0, 0)", "vec3(2 * t - 1, 0, 0)", file="a.crt")
        self.show(page, "a.crt", frame=1, known=known[1])
        page.receive("job", where=lambda job: job.get("unchanged") and job["version"] == version)
        self.assertEqual(made, self.jobs(page))
        self.show(page, "a.crt", frame=2, known=known[2])
        self.last_picture(page, version=version)
        page.say("save", file="a.crt")
        page.receive("saved")

    def test_tone_is_changed_without_tracing(self):
        page = self.begin()
        self.show(page)
        _, plain = self.last_picture(page)
        before = self.jobs(page)
        for tone, options in (({"exposure": 2}, ("--exposure", 2)), ({"tone-map": "filmic"}, ("--tone-map", "filmic"))):
            self.show(page, tone=tone)
            piece, bright = self.last_picture(page)
            self.assert_same(self.rendered("scene.tessera", *options), bright)
            self.assertNotEqual(plain, bright)
        self.show(page)
        self.assert_same(plain, self.last_picture(page)[1])
        self.assertEqual(before, self.jobs(page))

    def test_pause_resume_and_stop(self):
        page = self.begin()
        long = {"spp": 1024}
        self.show(page, overrides=long, size=(480, 270))
        page.receive("pixels")
        page.say("pause", pane=0)
        page.receive("job", where=lambda each: each["state"] == "paused")
        paused = self.jobs(page)
        page.say("refresh", pane=0)
        page.receive("job", where=lambda each: each.get("serial", 0) > paused[-1])
        page.say("stop", pane=0)
        page.receive("job", where=lambda each: each["state"] == "stopped")
        stopped = self.jobs(page)
        self.text = SCENE
        # A stopped view shows the next scene.
        self.replace(page, 1, "radius: 1.25", "radius: 1")
        self.show(page)
        piece, _ = self.last_picture(page, version=2)
        self.assertGreater(piece.serial, stopped[-1])

    def test_resume_goes_on(self):
        page = self.begin()
        self.show(page, overrides={"spp": 96}, size=(480, 270))
        page.receive("pixels")
        page.say("pause", pane=0)
        page.receive("job", where=lambda each: each["state"] == "paused")
        page.forget()
        page.say("resume", pane=0)
        piece, shown = self.last_picture(page)
        self.assertEqual(96, piece.samples)

    def test_a_view_that_waits_for_saving(self):
        self.text = SCENE
        page = self.begin()
        self.show(page, mode="save")
        self.last_picture(page)
        before = self.jobs(page)
        version = self.replace(page, 1, "radius: 1.25", "radius: 1")
        self.problems(page, version)
        self.assertEqual(before, self.jobs(page))
        page.say("save", file="scene.tessera")
        self.assertEqual(version, self.last_picture(page, version=version)[0].version)

    def test_a_view_that_waits_for_an_order(self):
        self.text = SCENE
        page = self.begin()
        self.show(page, mode="hand")
        self.last_picture(page)
        before = self.jobs(page)
        version = self.replace(page, 1, "radius: 1.25", "radius: 1")
        self.problems(page, version)
        page.say("save", file="scene.tessera")
        page.receive("saved")
        self.assertEqual(before, self.jobs(page))
        page.say("refresh", pane=0)
        self.last_picture(page, version=version)

    def test_a_picture_is_asked_for_before_its_text_is_read(self):
        page = self.begin()
        at = SCENE.index("1.25")
        for version, (mode, ask) in enumerate((("hand", "refresh"), ("save", "save")), 2):
            self.show(page, mode=mode)
            page.say("edit", file="scene.tessera", base=version - 1, changes=[[at, at + 4, f"1.{version}0"]])
            page.say(ask, **({"pane": 0} if ask == "refresh" else {"file": "scene.tessera"}))
            self.last_picture(page, version=version)
        before = self.jobs(page)
        page.say("edit", file="scene.tessera", base=version, changes=[[at, at + 4, "1.50"]])
        self.problems(page, version + 1)
        self.assertEqual(before, self.jobs(page), "the next text waits again")

    def test_several_panes(self):
        page = self.begin(SCENE, "--workers", 2)
        views = {0: None, 1: {"eye": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 40, "orthographic": 4},
                 2: {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40, "orthographic": 4},
                 3: {"eye": [5, 0, 0], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40, "orthographic": 4}}
        for pane, camera in views.items():
            self.show(page, pane=pane, camera=camera, size=(48 + pane, 32))
        shown = {}
        for pane in views:
            piece, shown[pane] = self.last_picture(page, pane)
            self.assertEqual((48 + pane, 32), piece.picture)
        self.assertEqual(4, len(set(shown.values())))
        page.forget()
        page.say("close_view", pane=3)
        self.text = SCENE
        version = self.replace(page, 1, "radius: 1.25", "radius: 1")
        for pane in (0, 1, 2):
            self.last_picture(page, pane, version)
        page.say("list")
        page.receive("files")
        self.assertEqual([], [each.pane for kind, each in page.waiting if kind == "pixels" and each.pane == 3])

    def test_a_pane_goes_from_scene_to_scene(self):
        """Whether or not the next one was read when the one before is in the midst of its passes."""
        page = self.begin()
        other = SCENE.replace("radius: 1.25", "radius: .5")
        self.scene("other.tessera", other)
        self.scene("broken.tessera", "nodes {")
        for _ in range(8):
            for name in ("scene.tessera", "other.tessera", "broken.tessera"):
                self.show(page, name, overrides={"spp": 256})
                page.say("list")
                page.receive("files")
        self.show(page, "other.tessera", overrides={"spp": 9})
        page.forget()
        while True:
            piece, shown = self.last_picture(page)
            if piece.samples == 9:
                break
        self.assert_same(self.rendered("other.tessera", "--spp", 9), shown)

    def test_a_page_is_told_of_the_frame_that_it_shows_itself(self):
        page = self.begin(MOVING_SCRIPT, file="a.crt")
        other = self.page(self.running)
        for each, frame in ((page, 0), (other, 5)):
            self.show(each, "a.crt", frame=frame)
            self.last_picture(each)
        for each, frame in ((page, 0), (other, 5)):
            each.say("centers", file="a.crt")
            self.assertIn([frame, 0, 0], [center for _, _, center, *_ in each.receive("centers")["list"]])
            each.say("export", file="a.crt", name=f"frame{frame}.tessera")
            self.assertEqual(f"frame{frame}.tessera", each.receive("exported", "refused").get("name"))
        self.assertNotEqual(*((self.opened / f"frame{frame}.tessera").read_text() for frame in (0, 5)))

    def test_a_wish_that_makes_no_sense_changes_nothing(self):
        page = self.begin()
        self.show(page, overrides={"spp": 16})
        for _ in range(20):
            self.show(page, overrides={"spp": "many"})
            self.assertIn("spp", page.receive("refused")["why"])
        self.assertEqual(16, self.last_picture(page)[0].samples)

    def test_a_probe_tells_of_the_film(self):
        page = self.begin()
        self.show(page)
        _, shown = self.last_picture(page)
        page.say("probe", pane=0, x=48, y=27)
        probed = page.receive("probed")
        at = 3 * (27 * SIZE[0] + 48)
        self.assertEqual(list(shown[at:at + 3]), probed["shown"])
        self.assertEqual(len(probed["channels"]), len(probed["values"]))

    def test_a_page_that_never_reads_holds_nobody_up(self):
        page = self.begin()
        stalled = Page(self.running.address)
        stalled.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stalled.say("hello", token=self.running.token)
        stalled.say("open", file="scene.tessera")

        def resident():
            status = pathlib.Path(f"/proc/{self.running.process.pid}/status").read_text()
            return int(status.split("VmRSS:")[1].split()[0]) / 1024
        before = resident()
        for number in range(40):
            # Each picture is one of 8 MB.
            with contextlib.suppress(OSError):  # the program may give it up
                stalled.say("view", pane=0, file="scene.tessera", size=[1920, 1080], overrides=ONE,
                            tone={"exposure": number / 10})
            self.show(page, overrides=ONE, tone={"exposure": number / 10})
            self.last_picture(page)
            page.forget()
        # Its queue, what the sockets hold and a few pictures; not forty of them.
        self.assertLess(resident() - before, 200)
        stalled.close()
        self.assert_alive(self.running)


if __name__ == "__main__":
    unittest.main()
