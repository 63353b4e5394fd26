#!/usr/bin/env python3
"""Full pictures and exports of the studio: the files that `tessera render` writes, bit for bit, in
whatever order pages ask for them, and nothing outside of the folder."""
import json
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

import scenes
from studio_client import Studio
from tessera_process import PROGRAM

SETTINGS = "settings { width: 64 height: 48 sampling { samples_per_pixel: 4 } }\n"
SCENE = scenes.ONE_SPHERE + SETTINGS
MANY_SAMPLES = scenes.ONE_SPHERE + SETTINGS.replace("_pixel: 4", "_pixel: 4096")
MOVING = scenes.CAMERA + scenes.SUN + SETTINGS + """
nodes {
  shape { sphere { center { y: 0.5 } radius: 0.5 } }
  keys { time: 0 transform { steps { translate {} } } } keys { time: 1 transform { steps { translate { x: 10 } } } }
}
"""
OVER = ("done", "failed", "cancelled")


class RendersTest(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name) / "opened"
        self.folder.mkdir()
        self.outside = pathlib.Path(temporary.name) / "outside"
        self.outside.mkdir()
        (self.folder / "a.tessera").write_text(SCENE)
        (self.folder / "slow.tessera").write_text(MANY_SAMPLES)
        self.state = {"XDG_STATE_HOME": temporary.name, "XDG_CONFIG_HOME": temporary.name}

    def studio(self, *options):
        studio = Studio(PROGRAM, self.folder, "--workers", "2", *options, env=self.state)
        self.addCleanup(studio.__exit__)
        connect = studio.connect

        def connect_for_the_test(**hello):
            page = connect(**hello)
            self.addCleanup(page.close)
            return page
        studio.connect = connect_for_the_test
        return studio

    def render(self, *arguments):
        """What `tessera render` writes to `-o`, as bytes by its name."""
        run = subprocess.run([PROGRAM, "render", "--quiet", *map(str, arguments)], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)

    def list_where(self, page, job, *states):
        """The job's entry in the first list that has it in one of these states."""
        def find(fields):
            return [each for each in fields["list"] if each["job"] == job and each["state"] in states]
        return find(page.receive("renders", timeout=60, where=find))[0]

    def order(self, page, file="a.tessera", **spec):
        """The number of the job that the page is told of next."""
        known = getattr(page, "known", set())
        page.say("render", file=file, spec=spec)
        new = page.receive("renders", where=lambda fields: {e["job"] for e in fields["list"]} - known)
        page.known = {each["job"] for each in new["list"]}
        return max(page.known - known)

    # ------------------------------------------------------------------------------- pictures

    def test_files_are_those_of_render(self):
        page = self.studio().connect()
        job = self.order(page, outputs=["out.png", "out.exr", "out.ppm"], statistics=True,
                         overrides={"aovs": "depth,normal", "seed": 3, "max-depth": 3})
        entry = self.list_where(page, job, *OVER)
        self.assertEqual(entry["state"], "done", entry)
        self.assertEqual(sorted(entry["written"]), ["out.exr", "out.png", "out.ppm", "out.stats.json"])
        self.render(self.folder / "a.tessera", "--aovs", "depth,normal", "--seed", 3, "--max-depth", 3,
                    *[f"-o{self.outside}/out.{ending}" for ending in ("png", "exr", "ppm")],
                    "--stats", self.outside / "stats.json")
        for ending in ("png", "exr", "ppm"):
            self.assertEqual((self.folder / f"out.{ending}").read_bytes(),
                             (self.outside / f"out.{ending}").read_bytes(), ending)
        ours = json.loads((self.folder / "out.stats.json").read_text())
        theirs = json.loads((self.outside / "stats.json").read_text())
        for name in ("pixels_sha256", "scene", "rays", "samples", "width", "samples_per_pixel"):
            self.assertEqual(ours[name], theirs[name], name)

    def test_its_command_line_makes_the_same_picture(self):
        page = self.studio().connect()
        job = self.order(page, outputs=["x y.png"], camera={"name": "side"},
                         overrides={"spp": 2, "integrator": "path", "size": "32x20"}, tone={"exposure": 1})
        entry = self.list_where(page, job, *OVER)
        picture = (self.folder / "x y.png").read_bytes()
        (self.folder / "x y.png").unlink()
        words = shlex.split(entry["command"])
        self.assertEqual(words[:2], ["tessera", "render"])
        self.render(*words[2:])
        self.assertEqual((self.folder / "x y.png").read_bytes(), picture)
        page.say("export", command={"camera": {"eye": [0, 0, 1], "target": [0, 0, 0]}}, file="a.tessera")
        self.assertIn("camera", page.receive("refused")["why"])

    def test_its_command_line_finds_what_the_scene_names(self):
        def file_that_is_made(page, file, picture):
            entry = self.list_where(page, self.order(page, file=file, outputs=[picture]), *OVER)
            self.assertEqual("done", entry["state"], entry)
            made = (self.folder / picture).read_bytes()
            (self.folder / picture).unlink()
            self.render(*shlex.split(entry["command"])[2:])
            self.assertEqual(made, (self.folder / picture).read_bytes())

        (self.folder / "below").mkdir()
        (self.folder / "below/c.tessera").write_text(SETTINGS + 'includes { file: "../a.tessera" }\n')
        file_that_is_made(self.studio().connect(), "below/c.tessera", "c.png")
        # A folder of assets, and all that is in it, lies around the opened one.
        (self.folder.parent / "d.tessera").write_text(SCENE)
        (self.folder / "d.tessera").write_text(SETTINGS + 'includes { file: "../d.tessera" }\n')
        file_that_is_made(self.studio("--assets", self.folder.parent).connect(), "d.tessera", "d.png")

    def test_denoised_as_render_does(self):
        page = self.studio().connect()
        job = self.order(page, outputs=["out.pfm"], overrides={"denoise": True, "integrator": "path"})
        self.assertEqual(self.list_where(page, job, *OVER)["state"], "done")
        self.render(self.folder / "a.tessera", "--denoise", "--integrator", "path", "-o", self.outside / "out.pfm")
        self.assertEqual((self.folder / "out.pfm").read_bytes(), (self.outside / "out.pfm").read_bytes())

    def test_what_the_editor_has_is_rendered(self):
        page = self.studio().connect()
        page.say("open", file="a.tessera")
        text = page.receive("document")["text"]
        at = text.rindex("y: 0.5")
        page.say("edit", file="a.tessera", base=1, changes=[[at, at + 6, "y: 0.9"]])
        page.receive("edited")
        job = self.order(page, outputs=["out.png"])
        self.list_where(page, job, *OVER)
        (self.outside / "b.tessera").write_text(text[:at] + "y: 0.9" + text[at + 6:])
        self.render(self.outside / "b.tessera", "-o", self.outside / "out.png")
        self.assertEqual((self.folder / "out.png").read_bytes(), (self.outside / "out.png").read_bytes())

    def test_frames_are_numbered_files(self):
        (self.folder / "m.tessera").write_text(MOVING)
        page = self.studio().connect()
        job = self.order(page, file="m.tessera", frames=[0, 2], outputs=["f.png"])
        entry = self.list_where(page, job, *OVER)
        self.assertEqual((entry["state"], entry["frames_done"]), ("done", 3), entry)
        self.render(self.folder / "m.tessera", "--frames", "0-2", "-o", self.outside / "f.png")
        pictures = [(self.folder / f"f.000{i}.png").read_bytes() for i in range(3)]
        self.assertEqual(pictures, [(self.outside / f"f.000{i}.png").read_bytes() for i in range(3)])
        self.assertEqual(len(set(pictures)), 3)

    # --------------------------------------------------------------------------------- orders

    def test_paused_it_goes_on_from_its_tiles_with_the_same_bits(self):
        page = self.studio().connect()
        job = self.order(page, file="slow.tessera", outputs=["slow.pfm"], overrides={"tile": 8, "spp": 1024})
        page.receive("renders", where=lambda fields: any(each.get("tiles_done") for each in fields["list"]),
                     timeout=60)
        page.say("order", job=job, what="pause")
        self.list_where(page, job, "paused")
        page.say("order", job=job, what="resume")
        self.assertEqual(self.list_where(page, job, *OVER)["state"], "done")
        self.render(self.folder / "slow.tessera", "--spp", 1024, "-o", self.outside / "slow.pfm")
        self.assertEqual((self.folder / "slow.pfm").read_bytes(), (self.outside / "slow.pfm").read_bytes())

    def test_one_after_another_and_cancelled_ones_leave_nothing(self):
        page = self.studio().connect()
        slow = self.order(page, file="slow.tessera", outputs=["slow.png"], overrides={"spp": 65536})
        self.list_where(page, slow, "tracing")
        waiting = self.order(page, outputs=["waiting.png"])
        third = self.order(page, outputs=["third.png"])
        page.say("order", job=waiting, what="cancel")
        page.say("order", job=slow, what="cancel")
        last = page.receive("renders", timeout=60, where=lambda fields: len(fields["list"]) == 3 and all(
            each["state"] in OVER for each in fields["list"]))
        states = {each["job"]: each["state"] for each in last["list"]}
        self.assertEqual(states, {slow: "cancelled", waiting: "cancelled", third: "done"})
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()),
                         ["a.tessera", "slow.tessera", "third.png"])
        page.say("order", job=slow, what="forget")
        page.receive("renders", where=lambda fields: len(fields["list"]) == 2)
        page.say("order", job=99, what="cancel")
        self.assertEqual(page.receive("refused")["request"], "order")

    def test_views_are_served_before(self):
        # Of many small tiles, since a view waits for one of them, however slow the machine is.
        many = SETTINGS.replace("width: 64 height: 48", "width: 2048 height: 1536")
        (self.folder / "large.tessera").write_text(scenes.ONE_SPHERE + many)
        page = self.studio().connect()
        slow = self.order(page, file="large.tessera", overrides={"spp": 128})
        self.list_where(page, slow, "tracing")
        page.say("view", pane=0, file="a.tessera", size=[64, 48])
        last, _ = page.picture(where=lambda piece: piece.flags & 2)
        self.assertEqual(last.samples, 4)
        page.say("order", job=slow, what="cancel")
        self.list_where(page, slow, "cancelled")

    # ---------------------------------------------------------------------------- what is wrong

    def test_nothing_is_written_outside_or_over(self):
        page = self.studio().connect()
        (self.folder / "there.png").write_bytes(b"old")
        (self.folder / "link").symlink_to(self.outside)
        for name in ("../outside/x.png", "/tmp/x.png", ".hidden.png", "x.tessera", "x.doc", ""):
            page.say("render", file="a.tessera", spec={"outputs": [name]})
            self.assertEqual(page.receive("refused")["request"], "render", name)
        # Before anything is traced.
        for name in ("there.png", "link/x.png", "nowhere/x.png"):
            page.say("render", file="a.tessera", spec={"outputs": [name]})
            self.assertIn(name, page.receive("refused")["why"])
        page.say("list")
        page.receive("files")
        self.assertEqual([[]], [fields["list"] for kind, fields in page.waiting if kind == "renders"][-1:])
        self.assertEqual((self.folder / "there.png").read_bytes(), b"old")
        self.assertEqual(list(self.outside.iterdir()), [])
        job = self.order(page)
        self.list_where(page, job, "done")
        page.say("export", number=5, job=job, name="rescued.png")
        exported = page.receive("exported", "refused")
        self.assertEqual((exported["number"], exported.get("name")), (5, "rescued.png"))
        page.say("export", job=job, name="there.png", force=True)
        page.receive("exported")
        self.assertEqual((self.folder / "there.png").read_bytes(), (self.folder / "rescued.png").read_bytes())

    def test_scenes_that_cannot_be_and_options_that_are_none(self):
        page = self.studio().connect()
        (self.folder / "wrong.tessera").write_text("nodes { sphere")
        job = self.order(page, file="wrong.tessera")
        self.assertEqual(self.list_where(page, job, *OVER)["state"], "failed")
        for overrides in ({"spp": 0}, {"output": "/tmp/x.png"}, {"stats": "/tmp/x"}, {"sp": 2}, {"connect": "x"}):
            page.say("render", file="a.tessera", spec={"overrides": overrides})
            self.assertEqual(page.receive("refused")["request"], "render", overrides)

    @unittest.skipUnless(os.path.exists("/dev/full"), "there is no /dev/full, which is how a full disk is made here")
    def test_full_disk(self):
        studio = self.studio()
        page = studio.connect()
        # No file may be longer than that from now on, as on a disk that is full.
        subprocess.run(["prlimit", f"--pid={studio.process.pid}", "--fsize=100:"], check=True)
        job = self.order(page, outputs=["out.png"])
        entry = self.list_where(page, job, *OVER)
        self.assertEqual(entry["state"], "failed")
        self.assertIn("out.png", entry["why"])
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["a.tessera", "slow.tessera"])
        subprocess.run(["prlimit", f"--pid={studio.process.pid}", "--fsize=unlimited:"], check=True)
        page.say("export", job=job, name="out.png")
        page.receive("exported")
        self.assertTrue((self.folder / "out.png").stat().st_size > 100)

    def test_read_only_writes_nothing_but_gives_downloads(self):
        page = self.studio("--read-only").connect()
        page.say("render", file="a.tessera", spec={"outputs": ["out.png"]})
        self.assertEqual(page.receive("refused")["request"], "render")
        job = self.order(page)
        self.list_where(page, job, "done")
        self.assertEqual(self.download(page, job=job, name="out.png")[:4], b"\x89PNG")
        self.assertFalse((self.folder / "out.png").exists())

    # -------------------------------------------------------------------------------- exports

    def download(self, page, **wish):
        page.say("export", download=True, **wish)
        exported = page.receive("exported", "refused")
        content = b""
        while len(content) < exported["size"]:
            chunk = page.receive("pixels", where=lambda each: each.kind == 3)
            self.assertEqual(chunk.serial, exported["download"])
            content += chunk.body
        self.assertTrue(chunk.flags & 1)
        return content

    def test_downloads_are_the_files(self):
        page = self.studio().connect()
        job = self.order(page, outputs=["out.png"])
        self.list_where(page, job, *OVER)
        self.assertEqual(self.download(page, job=job, name="out.png"), (self.folder / "out.png").read_bytes())

    def test_picture_of_a_view(self):
        page = self.studio().connect()
        page.say("view", pane=0, file="a.tessera", size=[40, 30])
        page.picture(where=lambda piece: piece.flags & 2)
        page.say("export", pane=0, file="a.tessera", name="view.png")
        self.assertEqual(page.receive("exported", "refused").get("name"), "view.png")
        self.render(self.folder / "a.tessera", "--size", "40x30", "-o", self.outside / "view.png")
        self.assertEqual((self.folder / "view.png").read_bytes(), (self.outside / "view.png").read_bytes())

    def test_a_view_is_exported_as_it_is_seen_whatever_it_is_to_show_next(self):
        page = self.studio().connect()
        view = {"pane": 0, "file": "a.tessera", "size": [40, 30], "mode": "hand"}
        page.say("view", **view)
        page.say("refresh", pane=0)
        page.picture(where=lambda piece: piece.flags & 2)
        page.say("view", **view, overrides={"spp": 64})
        page.say("export", pane=0, file="a.tessera", name="view.png")
        self.assertEqual(page.receive("exported", "refused").get("name"), "view.png")
        self.render(self.folder / "a.tessera", "--size", "40x30", "-o", self.outside / "view.png")
        self.assertEqual((self.folder / "view.png").read_bytes(), (self.outside / "view.png").read_bytes())
        page.say("export", pane=3, file="a.tessera", name="none.png")
        self.assertIn("no picture yet", page.receive("refused")["why"])

    def test_scenes(self):
        page = self.studio().connect()
        page.say("view", pane=0, file="a.tessera", size=[40, 30])
        page.picture(where=lambda piece: piece.flags & 2)
        for ending in ("tessera", "tesserab", "json"):
            page.say("export", file="a.tessera", name=f"copy.{ending}")
            self.assertEqual(page.receive("exported", "refused").get("name"), f"copy.{ending}")
            self.render(self.folder / f"copy.{ending}", "-o", self.outside / f"{ending}.pfm")
        self.render(self.folder / "a.tessera", "-o", self.outside / "a.pfm")
        self.assertEqual({p.read_bytes() for p in self.outside.glob("*.pfm")}, {(self.outside / "a.pfm").read_bytes()})

    # -------------------------------------------------------------------------------- channels

    def test_another_channel_traces_nothing_anew(self):
        page = self.studio().connect()
        view = {"pane": 0, "file": "a.tessera", "size": [40, 30]}
        page.say("view", **view, channel="depth")
        depth, depth_pixels = page.picture(where=lambda piece: piece.flags & 2)
        legend = page.receive("legend", where=lambda each: each["channel"] == "depth" and each["high"] > 1)
        self.assertLess(0, legend["low"])
        self.assertEqual(len(legend["steps"]), 5)
        page.receive("job", where=lambda each: each["state"] == "done")
        page.forget()
        pictures = {depth_pixels}
        for channel in ("normal", "albedo", "id", "position", "error", "samples", "light"):
            page.say("view", **view, channel=channel)
            page.receive("legend", where=lambda each: each["channel"] == channel)
            piece, pixels = page.picture(where=lambda piece: piece.flags & 2)
            self.assertEqual(piece.serial, depth.serial, channel)
            pictures.add(pixels)
        self.assertEqual(len(pictures), 8)
        self.assertEqual([], [each for kind, each in page.waiting if kind == "job" and "serial" in each])
        page.say("probe", pane=0, x=20, y=15)
        probed = page.receive("probed")
        self.assertEqual(len(probed["values"]), len(probed["channels"]))
        self.assertTrue({"R", "depth.Z", "id"} & set(probed["channels"]), probed["channels"])
        # What was shown as light is what `tessera render` makes, whatever is beside it.
        page.say("export", pane=0, file="a.tessera", name="view.png")
        page.receive("exported")
        self.render(self.folder / "a.tessera", "--size", "40x30", "-o", self.outside / "view.png")
        self.assertEqual((self.folder / "view.png").read_bytes(), (self.outside / "view.png").read_bytes())
        page.say("view", **view, channel="dept")
        self.assertIn("depth", page.receive("refused")["why"])

    def test_the_last_pass_is_denoised(self):
        page = self.studio().connect()
        page.say("view", pane=0, file="a.tessera", size=[40, 30], overrides={"denoise": True, "integrator": "path"})
        page.picture(where=lambda piece: piece.flags & 2)
        page.say("export", pane=0, file="a.tessera", name="view.ppm")
        page.receive("exported")
        self.render(self.folder / "a.tessera", "--size", "40x30", "--denoise", "--integrator", "path",
                    "-o", self.outside / "view.ppm")
        self.assertEqual((self.folder / "view.ppm").read_bytes(), (self.outside / "view.ppm").read_bytes())

    # ------------------------------------------------------------------------------- monitoring

    def test_metrics_workers_and_log(self):
        studio = self.studio()
        page = studio.connect()
        job = self.order(page)
        self.list_where(page, job, *OVER)
        metrics = page.receive("metrics", where=lambda each: each["rays_per_second"] > 0)
        for name in ("tiles_per_second", "cpu_program", "cpu_workers", "cpu_machine", "memory", "worker_use"):
            self.assertGreaterEqual(metrics[name], 0, name)
        workers = page.receive("workers", where=lambda each: each["list"])["list"]
        self.assertEqual(len(workers), 2)
        page.receive("log", where=lambda each: any(re.search(r"full picture \d+ of 'a\.tessera'", line["text"])
                                                   for line in each["lines"]))

    def test_keys_are_logged_once_they_rest(self):
        page = self.studio().connect()

        def is_of_reading(fields):
            return any("'a.tessera': read" in line["text"] for line in fields["lines"])
        page.say("open", file="a.tessera")
        page.receive("document")
        page.say("view", pane=0, file="a.tessera", size=[40, 30])
        page.picture(where=lambda piece: piece.flags & 2)
        page.receive("log", where=is_of_reading)
        page.forget()
        for version in range(1, 6):
            page.say("edit", file="a.tessera", base=version, changes=[[0, 0, f"# {version}\n"]])
        page.receive("log", where=is_of_reading)
        page.receive("metrics")
        page.receive("metrics")
        self.assertNotIn("log", [kind for kind, _ in page.waiting])


if __name__ == "__main__":
    unittest.main()
