"""What the tests of `tessera studio` share: a folder with scenes, and the program that serves it."""
import os
import pathlib
import shutil
import signal

from png import read_png, without_alpha
from studio_client import Closed, Studio
from tessera_process import PATIENCE, PROGRAM, TesseraTest, is_worker, marked_processes, wait_until

SCENE = """\
settings { width: 96 height: 54 sampling { samples_per_pixel: 4 } }
cameras { name: "front" world_from_camera { steps { look_at { eye { y: 1 z: 5 } target { } } } } }
background { gradient { sky { r: 0.4 g: 0.6 b: 1 } ground { r: 0.8 g: 0.7 b: 0.6 } } }
materials { name: "red" classic { diffuse { value { r: .7 g: .1 b: .1 } } } }
nodes { name: "ball" shape { materials: "red" sphere { radius: 1.25 } } }
nodes { name: "sun" light { directional { direction { x: -0.5 y: -1 z: -0.6 } } } }
"""
SIZE = (96, 54)
SAMPLES = pathlib.Path(__file__).parents[2] / "scenes/samples"


class StudioTest(TesseraTest):
    """`self.opened` is the folder that studios of the test open."""

    def setUp(self):
        super().setUp()
        self.opened = self.folder / "scenes"
        self.opened.mkdir()
        self.studios = []

    def tearDown(self):
        for studio in self.studios:
            self.assertEqual(0, self.end_studio(studio), "the studio's exit code")
        super().tearDown()

    def environment(self):
        return {**super().environment(), "XDG_STATE_HOME": str(self.folder / "state"),
                "XDG_CONFIG_HOME": str(self.folder / "config")}

    def studio(self, *options, path=None, **more):
        """The program, which answers; it is ended with the test."""
        studio = Studio(PROGRAM, path or self.opened, *map(str, options), env=self.environment(), **more)
        self.studios.append(studio)
        return studio

    def end_studio(self, studio, sent=signal.SIGTERM):
        """Its exit code."""
        self.studios = [each for each in self.studios if each is not studio]
        if studio.process.poll() is None:
            studio.process.send_signal(sent)
        studio.said = studio.process.communicate(timeout=PATIENCE)[1]
        return studio.process.returncode

    def kill(self, studio):
        """As a crash ends it, with its workers."""
        self.studios.remove(studio)
        studio.process.kill()
        studio.process.communicate()
        wait_until(lambda: not any(map(is_worker, marked_processes(self.mark))), "its workers are gone too")
        for left in self.temporary.iterdir():
            shutil.rmtree(left, ignore_errors=True)

    def page(self, studio, **hello):
        """A page that was welcomed."""
        page = studio.connect(**hello)
        self.addCleanup(page.close)
        page.welcome = page.receive("welcome")
        return page

    def scene(self, name="scene.tessera", text=SCENE):
        path = self.opened / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def open(self, page, file="scene.tessera"):
        page.say("open", file=file)
        return page.receive("document", where=lambda each: each["file"] == file)

    def edit(self, page, base, *changes, file="scene.tessera"):
        """The version that the changes made."""
        page.say("edit", file=file, base=base, changes=[list(each) for each in changes])
        answer = page.receive("edited", where=lambda each: each["version"] == base + 1)
        return answer["version"]

    def show(self, page, file="scene.tessera", size=SIZE, pane=0, **wish):
        page.say("view", pane=pane, file=file, size=list(size), **wish)

    def last_picture(self, page, pane=0, version=None):
        """The RGB bytes of the next picture that is the last one of its ladder."""
        piece, rgba = page.picture(
            pane, lambda each: each.flags & 2 and (version is None or each.version == version))
        self.assertEqual({255}, set(rgba[3::4]), "not every pixel was painted")
        return piece, without_alpha(rgba)

    def rendered(self, file="scene.tessera", *options, size=SIZE):
        """The RGB bytes of what `tessera render` makes of the file."""
        result = self.run_program("render", self.opened / file, "-o", self.folder / "own.png", "--size",
                                  f"{size[0]}x{size[1]}", "--quiet", *options)
        self.assertEqual(0, result.code, result.err)
        width, height, pixels = read_png(self.folder / "own.png")
        self.assertEqual(size, (width, height))
        return pixels

    def assert_same(self, one, other):
        """Without the long list of all that differs."""
        self.assertTrue(one == other, "the pixels differ")

    def assert_closed(self, page, code):
        """The program closes that page with that code."""
        with self.assertRaises(Closed) as closed:
            while True:
                page.receive("nothing")
        self.assertEqual(code, closed.exception.code)

    def assert_alive(self, studio):
        self.page(studio).close()
        self.assertIsNone(studio.process.poll())

    def descriptors(self, studio):
        return len(os.listdir(f"/proc/{studio.process.pid}/fd"))


class ViewTest(StudioTest):
    def begin(self, text=SCENE, *options, file="scene.tessera", **more):
        """A page that has opened the scene."""
        if text is not None:
            self.scene(file, text)
        self.running = self.studio(*(options or ("--workers", 1)), **more)
        page = self.page(self.running)
        self.opened_as = self.open(page, file)
        return page

    def jobs(self, page):
        """The serials of the jobs that a page was told of by now, in order."""
        page.say("list")
        page.receive("files")
        serials = []
        for kind, fields in page.waiting:
            if kind == "job" and "serial" in fields and fields["serial"] not in serials:
                serials.append(fields["serial"])
        return serials

    def problems(self, page, version):
        return page.receive("problems", where=lambda each: each["version"] == version)["list"]

    def replace(self, page, version, old, new, file="scene.tessera"):
        """An edit of the one place where the text has `old`."""
        at = self.text.index(old)
        self.text = self.text.replace(old, new, 1)
        return self.edit(page, version, (at, at + len(old), new), file=file)
