#!/usr/bin/env python3
"""Which files `tessera studio` reads and writes, and how it begins and ends."""
import json
import os
import re
import signal
import socket
import stat
import unittest

from studio_case import SCENE, StudioTest
from tessera_process import PATIENCE, marked_processes, wait_until


class Files(StudioTest):
    def test_saving_keeps_what_was_not_edited(self):
        cases = {"crlf": b"# one\r\n# two\r\n", "mixed": b"# one\r\n# two\n# three", "none": b"# one",
                 "mark": b"\xef\xbb\xbf# one\n"}
        page = self.page(self.studio("--workers", 1))
        for name, content in cases.items():
            path = self.scene(f"{name}.tessera", content)
            path.chmod(0o640)
            document = self.open(page, path.name)
            self.assertNotIn("\r", document["text"])
            self.edit(page, 1, (2, 5, "eins"), file=path.name)
            page.say("save", file=path.name)
            saved = page.receive("saved")
            after = path.read_bytes()
            self.assertEqual(content.replace(b"one", b"eins"), after, name)
            self.assertNotEqual(document["hash"], saved["hash"])
            self.assertEqual(0o640, stat.S_IMODE(path.stat().st_mode))
        self.assertEqual(sorted(f"{name}.tessera" for name in cases), sorted(os.listdir(self.opened)))

    def test_hard_links_stay_linked(self):
        path, other = self.scene(), self.opened / "other.tessera"
        os.link(path, other)
        page = self.page(self.studio("--workers", 1))
        self.open(page)
        self.edit(page, 1, (0, 0, "# linked\n"))
        page.say("save", file="scene.tessera")
        page.receive("saved")
        self.assertTrue(path.samefile(other))
        self.assertEqual("# linked\n" + SCENE, other.read_text())

    def test_what_another_program_wrote_is_told_and_not_overwritten(self):
        path = self.scene()
        page = self.page(self.studio("--workers", 1))
        self.open(page)
        self.edit(page, 1, (0, 0, "# mine\n"))
        path.write_text("# theirs\n" + SCENE)
        told = page.receive("disk")
        self.assertEqual(("changed", "# theirs\n" + SCENE), (told["state"], told["text"]))
        page.say("save", file="scene.tessera")
        self.assertIn("keep your text", page.receive("refused")["why"])
        self.assertEqual("# theirs\n" + SCENE, path.read_text())
        page.say("save", file="scene.tessera", force=True)
        page.receive("saved")
        self.assertEqual("# mine\n" + SCENE, path.read_text())
        path.unlink()
        self.assertEqual("deleted", page.receive("disk", where=lambda each: each["state"] != "changed")["state"])
        page.say("save", file="scene.tessera", force=True)
        page.receive("saved")
        self.assertEqual("# mine\n" + SCENE, path.read_text())

    def test_a_save_that_comes_before_the_news_is_refused_too(self):
        path = self.scene()
        page = self.page(self.studio("--workers", 1))
        self.open(page)
        self.edit(page, 1, (0, 0, "# mine\n"))
        path.write_text("# theirs\n")
        page.say("save", file="scene.tessera")
        self.assertIn("keep your text", page.receive("refused")["why"])
        self.assertEqual("# theirs\n", path.read_text())

    def test_saving_as(self):
        self.scene()
        taken = self.scene("taken.tessera", "# taken\n")
        page = self.page(self.studio("--workers", 1))
        self.open(page)
        self.edit(page, 1, (0, 0, "# copy\n"))
        page.say("save", file="scene.tessera", **{"as": "taken.tessera"})
        self.assertIn("taken.tessera", page.receive("refused")["why"])
        self.assertEqual("# taken\n", taken.read_text())
        page.say("save", file="scene.tessera", **{"as": "new.tessera"})
        self.assertEqual("new.tessera", page.receive("saved")["as"])
        self.assertEqual("# copy\n" + SCENE, (self.opened / "new.tessera").read_text())
        self.assertEqual(SCENE, (self.opened / "scene.tessera").read_text())

    def test_nothing_outside_of_the_folder(self):
        self.scene()
        secret = self.write("secret.tessera", "# secret\n")
        (self.folder / "sub").mkdir()
        (self.folder / "sub/deep.tessera").write_text("# secret\n")
        (self.opened / "link.tessera").symlink_to(secret)
        (self.opened / "sub").symlink_to(self.folder / "sub")
        (self.opened / ".hidden.tessera").write_text("# secret\n")
        os.mkfifo(self.opened / "pipe.tessera")
        names = ["../secret.tessera", str(secret), "link.tessera", "sub/deep.tessera", ".hidden.tessera", "",
                 ".", "..", "a/../../secret.tessera", "pipe.tessera", "scene.tessera/", "x\0.tessera", "none.tessera",
                 "/etc/passwd", "x" * 5000]
        page = self.page(self.studio("--workers", 1))
        for name in names:
            page.say("open", file=name)
            kind = page.receive("refused", "document")
            self.assertIn("why", kind, name)
            self.assertNotIn("text", kind, name)
        self.open(page)
        for name in (*names, "new/"):
            if name in ("none.tessera", ""):
                continue
            page.say("save", file="scene.tessera", **{"as": name})
            self.assertTrue(page.receive("refused")["why"], name)
        self.assertEqual("# secret\n", secret.read_text())
        page.say("list")
        listed = {each["name"] for each in page.receive("files")["entries"]}
        self.assertEqual({"scene.tessera"}, {name for name in listed if not name.startswith("sub")} - {"link.tessera"})

    def test_no_view_and_no_picture_follows_a_link_out_of_the_folder(self):
        secret = self.write("secret.tessera", SCENE)
        (self.folder / "sub").mkdir()
        (self.folder / "sub/deep.tessera").write_text(SCENE)
        (self.opened / "link.tessera").symlink_to(secret)
        (self.opened / "sub").symlink_to(self.folder / "sub")
        self.scene("model.tessera", 'includes { file: "sub/deep.tessera" }\n')
        self.scene()
        (self.opened / "inside.tessera").symlink_to("scene.tessera")
        page = self.page(self.studio("--workers", 1))
        for name in ("link.tessera", "sub/deep.tessera", "model.tessera"):
            self.show(page, file=name)
            problems = page.receive("problems", where=lambda each: each["file"] == name)["list"]
            self.assertEqual(["error"], [each["severity"] for each in problems], name)
            self.assertRegex(problems[0]["message"], "out of the folder|not inside the asset root", name)
            page.say("render", file=name, spec={"outputs": ["out.png"]})
            job = page.receive("renders", where=lambda each: each["list"] and each["list"][-1]["file"] == name
                               and each["list"][-1]["state"] not in ("queued", "reading"))["list"][-1]
            self.assertEqual("failed", job["state"], name)
        self.show(page, file="inside.tessera")
        self.last_picture(page)

    def test_includes_stay_below_the_folder_too(self):
        self.write("secret.tessera", "nodes { shape { sphere { radius: -1 } } }\n")
        self.scene("scene.tessera", 'includes { file: "../secret.tessera" }\n')
        page = self.page(self.studio("--workers", 1))
        self.open(page)
        self.show(page)
        problems = page.receive("problems")["list"]
        self.assertEqual(["error"], [each["severity"] for each in problems])
        self.assertNotIn("radius", json.dumps(problems))

    def test_read_only_writes_nothing(self):
        path = self.scene()
        page = self.page(self.studio("--workers", 1, "--read-only"))
        self.assertTrue(page.welcome["read_only"])
        self.assertTrue(self.open(page)["read_only"])
        page.say("edit", file="scene.tessera", base=1, changes=[[0, 0, "x"]])
        self.assertIn("read-only", page.receive("refused")["why"])
        page.say("save", file="scene.tessera", **{"as": "new.tessera"})
        self.assertIn("read-only", page.receive("refused")["why"])
        self.show(page)
        self.last_picture(page)
        page.say("render", file="scene.tessera", spec={"outputs": ["new.png"], "force": True})
        self.assertIn("read-only", page.receive("refused")["why"])
        page.say("settings", theme="light")
        page.say("workspace", open=["scene.tessera"])
        other = self.page(self.studios[0])
        self.assertEqual({"theme": "light"}, other.welcome["settings"], "they last as long as the program")
        self.assertEqual([path], list(self.opened.iterdir()))
        self.assertFalse((self.folder / "state").exists())
        self.assertFalse((self.folder / "config").exists())

    def test_a_picture_is_not_begun_where_its_name_is_taken(self):
        self.scene()
        for name in ("taken.png", "new.stats.json", "frame.0001.png"):
            (self.opened / name).write_bytes(b"kept")
        page = self.page(self.studio("--workers", 1))
        page.receive("renders")
        for spec in ({"outputs": ["taken.png"]}, {"outputs": ["new.png"], "statistics": True},
                     {"outputs": ["frame.png"], "frames": [1, 2]}):
            page.say("render", file="scene.tessera", spec=spec)
            self.assertIn("there is one of that name", page.receive("refused")["why"])
        page.say("list")
        page.receive("files")
        self.assertEqual([], [kind for kind, _ in page.waiting if kind == "renders"])

    def test_saving_elsewhere_keeps_the_draft(self):
        self.scene()
        studio = self.studio("--workers", 1)
        page = self.page(studio)
        self.open(page)
        self.edit(page, 1, (0, 0, "# mine\n"))
        wait_until(lambda: list((self.folder / "state").rglob("*.draft")), "there is a draft")
        page.say("save", file="scene.tessera", **{"as": "new.tessera"})
        page.receive("saved")
        self.kill(studio)
        page = self.page(self.studio("--workers", 1))
        self.assertEqual("# mine\n" + SCENE, self.open(page)["draft"]["text"])

    def test_bytes_that_are_no_text_are_shown_and_not_edited(self):
        path = self.scene("scene.tessera", b"# \xff\n")
        page = self.page(self.studio("--workers", 1))
        document = self.open(page)
        self.assertFalse(document["editable"])
        page.say("edit", file="scene.tessera", base=1, changes=[[0, 0, "x"]])
        self.assertTrue(page.receive("refused")["why"])
        self.assertEqual(b"# \xff\n", path.read_bytes())

    def test_settings_and_workspace_outlast_the_program(self):
        page = self.page(self.studio("--workers", 1))
        page.say("settings", theme="light", font=15)
        page.say("workspace", open=["scene.tessera"])
        page.say("list")
        page.receive("files")
        self.assertEqual(0, self.end_studio(self.studios[0]))
        page = self.page(self.studio("--workers", 1))
        self.assertEqual({"theme": "light", "font": 15}, page.welcome["settings"])
        self.assertEqual({"open": ["scene.tessera"]}, page.welcome["workspace"])
        other = self.folder / "other"
        other.mkdir()
        page = self.page(self.studio("--workers", 1, path=other))
        self.assertEqual({"theme": "light", "font": 15}, page.welcome["settings"])
        self.assertEqual({}, page.welcome["workspace"], "it is that of the folder")


class Life(StudioTest):
    def test_what_was_typed_last_is_offered_again(self):
        self.scene()
        for sent, typed in ((signal.SIGINT, "# one\n"), (signal.SIGTERM, "# two\n")):
            studio = self.studio("--workers", 1)
            page = self.page(studio)
            self.open(page)
            self.edit(page, 1, (0, 0, typed))
            self.assertEqual(0, self.end_studio(studio, sent))
            self.assertEqual(SCENE, (self.opened / "scene.tessera").read_text())
            studio = self.studio("--workers", 1)
            page = self.page(studio)
            self.assertEqual(typed + SCENE, self.open(page)["draft"]["text"])
            self.assertEqual(0, self.end_studio(studio))

    def test_ctrl_c_ends_it_and_leaves_nothing(self):
        self.scene()
        for sent in (signal.SIGINT, signal.SIGTERM):
            studio = self.studio()
            page = self.page(studio)
            self.open(page)
            self.show(page, size=(1920, 1080), overrides={"spp": 4096})
            page.receive("pixels")
            self.assertEqual(0, self.end_studio(studio, sent))
            faults = [line for line in studio.said.splitlines() if " info " not in line]
            self.assertEqual([], faults)
            self.assertEqual([], marked_processes(self.mark))
            self.assertEqual([], list(self.temporary.iterdir()))
            self.assertEqual(["scene.tessera"], os.listdir(self.opened))
            with self.assertRaises(OSError):
                socket.create_connection(studio.address.split(":"), timeout=5)

    def test_the_next_free_port_without_an_address(self):
        first = self.start("studio", self.opened, "--no-open", "--workers", 1)
        second = self.start("studio", self.opened, "--no-open", "--workers", 1)
        ports = [int(re.search(r":(\d+)/#token", each.stdout.readline())[1]) for each in (first, second)]
        self.assertTrue(all(7190 <= port < 7222 for port in ports), ports)
        self.assertEqual(2, len(set(ports)), ports)
        for each in (first, second):
            each.send_signal(signal.SIGINT)
            self.assertEqual(0, each.wait(timeout=PATIENCE))

    def test_an_address_in_use_is_told(self):
        studio = self.studio("--workers", 1)
        result = self.run_program("studio", self.opened, "--no-open", "--http", studio.address)
        self.assertNotEqual(0, result.code)
        self.assertIn(studio.address, result.err)

    def test_a_file_is_opened_in_its_folder(self):
        path = self.scene()
        page = self.page(self.studio("--workers", 1, path=path))
        self.assertEqual((str(self.opened), "scene.tessera"), (page.welcome["folder"], page.welcome["file"]))
        self.assert_error(self.run_program("studio", self.folder / "nothing", "--no-open"), 1, "nothing")

    def test_a_worker_that_crashes_costs_no_page(self):
        self.scene()
        studio = self.studio("--workers", 1)
        page = self.page(studio)
        self.open(page)
        self.show(page)
        _, before = self.last_picture(page)
        worker, = (each for each in marked_processes(self.mark) if each != studio.process.pid)
        os.kill(worker, signal.SIGKILL)
        self.show(page, overrides={"spp": 16})
        piece, after = self.last_picture(page)
        self.assertEqual(16, piece.samples)
        self.assertNotEqual(before, after)


if __name__ == "__main__":
    unittest.main()
