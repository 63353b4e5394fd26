#!/usr/bin/env python3
"""What `tessera studio` says of texts that are wrong, and where."""
import shutil
import unittest

from studio_case import SAMPLES, SCENE, ViewTest
from tessera_process import nightly


class Errors(ViewTest):
    def test_places_are_counted_in_utf_16(self):
        text = '# ä😀\r\nmetadata { title: "Tür 😀" } nodes { shape { sphere { radius: -1 } } }\r\nmaterials { name: 3 }\r\n'
        page = self.begin(text.encode())
        self.show(page)
        wrong = self.problems(page, 1)
        self.assertTrue(wrong)
        shown = self.opened_as["text"].split("\n")
        for each in wrong:
            self.assertEqual(("error", "scene.tessera"), (each["severity"], each["file"]))
            self.assertTrue(each["message"])
        first = wrong[0]
        line = shown[first["line"] - 1].encode("utf-16-le")
        found = line[2 * (first["column"] - 1):].decode("utf-16-le")
        self.assertIn(first["line"], (2, 3))
        expected = ("-1", "radius") if first["line"] == 2 else ("3", "name")
        self.assertTrue(found.startswith(expected), found)

    def test_the_last_good_picture_stays_and_is_told_to_be_old(self):
        self.text = SCENE
        page = self.begin()
        self.show(page)
        self.last_picture(page)
        before = self.jobs(page)
        version = self.replace(page, 1, "radius: 1.25", "radius: ")
        wrong, = self.problems(page, version)
        self.assertEqual("error", wrong["severity"])
        stale = page.receive("job", where=lambda each: "stale" in each)["stale"]
        self.assertTrue(stale["as_of"])
        self.assertIn("expected a number", stale["why"])
        self.assertEqual(before, self.jobs(page))
        version = self.replace(page, version, "radius: ", "radius: 1")
        self.assertEqual([], self.problems(page, version))
        self.last_picture(page, version=version)

    def test_errors_of_what_is_included_name_its_file(self):
        (self.opened / "parts").mkdir()
        text = "# part\nnodes { name: \"ä\" shape { sphere { radius: xy } } }\n"
        (self.opened / "parts/part.tessera").write_text(text)
        page = self.begin('includes { file: "parts/part.tessera" }\n' + SCENE)
        self.show(page)
        wrong = self.problems(page, 1)[0]
        # Of a file that nobody has open the place has its end too, in the editor's columns.
        column = text.split("\n")[1].index("xy") + 1
        self.assertEqual(("parts/part.tessera", 2, column, 2, column + 2),
                         tuple(map(wrong.get, ("file", "line", "column", "end_line", "end_column"))))
        self.assertEqual(0, wrong["version"])
        # A text that is open stands for the file, and its problems tell its version.
        self.open(page, "parts/part.tessera")
        self.edit(page, 1, (0, 0, "#\n"), file="parts/part.tessera")
        page.receive("problems", where=lambda each: each["list"] and (each["list"][0]["line"], each["list"][0]["version"]) == (3, 2))
        self.edit(page, 2, (text.index("xy") + 2, text.index("xy") + 4, ".5"), file="parts/part.tessera")
        page.receive("problems", where=lambda each: not each["list"])
        self.last_picture(page)

    def test_errors_of_a_material_library_name_its_file(self):
        for name in ("pawn.obj", "pawn.mtl"):
            shutil.copy(SAMPLES / name, self.opened)
        library = self.opened / "pawn.mtl"
        lines = library.read_text().splitlines()
        number = next(at for at, line in enumerate(lines) if line.startswith("Kd"))
        lines[number] = "Kd blue"
        library.write_text("\n".join(lines) + "\n")
        page = self.begin('includes { file: "pawn.obj" }\n' + SCENE)
        self.show(page)
        wrong = self.problems(page, 1)
        self.assertIn(("pawn.mtl", number + 1), [(each["file"], each["line"]) for each in wrong])

    def test_a_misspelt_word_has_a_suggestion(self):
        self.text = SCENE
        page = self.begin()
        self.show(page)
        version = self.replace(page, 1, "radius", "radiuss")
        wrong, = self.problems(page, version)
        self.assertEqual("radius", wrong["suggestion"])
        column = self.text.split("\n")[wrong["line"] - 1].index("radiuss") + 1
        self.assertEqual((column, wrong["line"], column + len("radiuss")),
                         (wrong["column"], wrong["end_line"], wrong["end_column"]))

    def test_warnings_are_told_beside_a_picture(self):
        unused = 'materials { name: "unused" classic { diffuse { value { r: 1 } } } }\n'
        page = self.begin(SCENE + unused)
        self.show(page)
        self.last_picture(page)
        told, = self.problems(page, 1)
        column = unused.index('"unused"') + 1
        line = SCENE.count("\n") + 1
        self.assertEqual(("warning", "material 'unused' is not used", "scene.tessera", line, column, line, column + 8),
                         tuple(map(told.get, ("severity", "message", "file", "line", "column", "end_line",
                                              "end_column"))))

    def test_what_an_included_file_does_not_use_is_told_too(self):
        (self.opened / "part.obj").write_text("mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one\nf 1 2 3\n")
        (self.opened / "part.mtl").write_text("newmtl one\nnewmtl idle\n")
        page = self.begin('includes { file: "part.obj" }\n' + SCENE)
        self.show(page)
        self.assertEqual([("warning", "material 'idle' is not used")],
                         [(each["severity"], each["message"]) for each in self.problems(page, 1)])

    def test_a_scene_that_cannot_be_rendered_costs_its_picture_alone(self):
        self.text = SCENE
        page = self.begin()
        self.show(page, overrides={"camera": "none"})
        kind = page.receive("refused", "job", where=lambda each: each.get("why"))
        self.assertTrue(kind["why"])
        self.show(page)
        self.last_picture(page)

    @nightly
    def test_a_scene_of_many_lines(self):
        rows = "".join(f"nodes {{ shape {{ sphere {{ center {{ x: {number % 100} y: {number // 100} }} radius: .4 }} }} }}\n"
                       for number in range(100_000))
        self.text = SCENE + rows
        page = self.begin(self.text)
        if not self.opened_as["editable"]:
            self.fail(f"{len(self.text)} bytes: {self.opened_as['why']}")
        self.show(page, overrides={"spp": 1})
        self.last_picture(page)
        version = self.replace(page, 1, "radius: 1.25", "radius: 1")
        version = self.replace(page, version, "x: 99 y: 999 }", "x: -1 y: 0 }")
        piece, shown = self.last_picture(page, version=version)
        page.say("save", file="scene.tessera")
        page.receive("saved")
        self.assertEqual(self.text, (self.opened / "scene.tessera").read_text())
        version = self.replace(page, version, "x: -1 y: 0 }", "x: -1 z }")
        wrong = self.problems(page, version)
        self.assertEqual(100_000 + SCENE.count("\n"), wrong[0]["line"])
        # Last, since meanwhile nobody answers for the page, which is given up after a while.
        self.assert_same(self.rendered("scene.tessera", "--spp", 1), shown)


if __name__ == "__main__":
    unittest.main()
