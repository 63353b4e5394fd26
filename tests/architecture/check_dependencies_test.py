#!/usr/bin/env python3
"""Plants each kind of violation in a small tree and looks whether check_dependencies finds it."""
import pathlib
import re
import tempfile
import unittest

import check_dependencies

MODULES = {
    "base": [],
    "proto/wire": ["base"],
    "proto/transport": ["base"],
    "renderer/math": ["base"],
    "renderer/accel": ["base", "renderer/math"],
    "image": ["base"],
    "scenes/formats": ["base", "proto/wire"],
    "coordinator": ["base", "proto/wire", "proto/transport"],
    "worker": ["base", "proto/transport", "renderer/accel"],
    "cli": ["base", "coordinator", "worker"],
}


class Dependencies(unittest.TestCase):
    def found(self, files, extra_dependencies=None):
        """The violations in a tree of `files`, with `extra_dependencies` added to MODULES."""
        modules = {module: list(uses) for module, uses in MODULES.items()}
        for module, uses in (extra_dependencies or {}).items():
            modules[module] = modules.get(module, []) + uses
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            return list(check_dependencies.violations(root, modules))

    def assert_one(self, expected, files, extra_dependencies=None):
        found = self.found(files, extra_dependencies)
        self.assertEqual(1, len(found), found)
        self.assertIn(expected, found[0])

    def test_a_clean_tree_has_none(self):
        self.assertEqual([], self.found({
            "base/error.h": "#pragma once\n#include <string>\n",
            "renderer/accel/bvh.cpp": '#include "renderer/accel/bvh.h"\n'
                                      '#include "renderer/math/vec.h"\n',
            "proto/transport/socket.cpp": "#include <zmq.hpp>\n",
            "proto/wire/decode.cpp": "message.ParseFromArray(data, size);\n",
            "scenes/formats/x.cpp": "// TextFormat is proto/wire's\n#include <pugixml.hpp>\n",
            "cli/render.cpp": '#include "coordinator/job.h"\n#include "worker/loop.h"\n',
        }))

    def test_an_import_of_a_private_name(self):
        self.assertEqual([], self.found({"python/tessera/scene.py": "from . import _core\nfrom .rays import Hits\n"
                                                                    "from __future__ import annotations\n",
                                         "examples/a.py": "import tessera as ts\nfrom os import _exit\n"}))
        self.assert_one("python/tessera/scene.py:2: imports _mix", {
            "python/tessera/scene.py": "import os\nfrom .rays import _mix, Hits\n"})
        for line in ("import tessera._core", "from tessera import _core", "from tessera._core import x",
                     "from tessera.rays import _mix"):
            self.assert_one("examples/a.py:1: imports tessera.", {"examples/a.py": line + "\n"})

    def test_an_include_without_a_dependency(self):
        self.assert_one("renderer/math/vec.cpp:2: \"renderer/accel/bvh.h\"", {
            "renderer/math/vec.cpp": '#include <cmath>\n#include "renderer/accel/bvh.h"\n'})

    def test_a_dependency_does_not_reach_through_another_module(self):
        self.assert_one("does not declare USES renderer/math",
                        {"worker/loop.cpp": '#include "renderer/math/vec.h"\n'})

    def test_a_type_declared_against_the_dependencies(self):
        store = {"coordinator/store.h": "class TileStore {\n};\n"}
        for line in ["class TileStore;", "struct TileStore;", "std::shared_ptr<class TileStore> s;",
                     "void keep(class TileStore& store);"]:
            with self.subTest(line=line):
                self.assert_one("worker/job.h:2: declares TileStore of coordinator, which worker",
                                {**store, "worker/job.h": f"#pragma once\n{line}\n"})

    def test_types_declared_along_the_dependencies(self):
        self.assertEqual([], self.found({
            "coordinator/store.h": "class TileStore;\nclass TileStore final : public Store {\n};\n",
            "cli/render.h": "class TileStore;\n",
            "worker/loop.h": "class Loop {\n  class Impl;\n  // class TileStore;\n};\n",
            "base/lists.h": "template <class T> struct List {\n};\n",
            # One of its own by the same name as another's.
            "renderer/math/own.h": "struct Other {\n};\n",
            "image/own.h": "struct Other {\n};\nclass Other;\n",
        }))

    def test_a_cycle_of_dependencies(self):
        self.assert_one("cycle: renderer/math -> renderer/accel -> renderer/math", {},
                        {"renderer/math": ["renderer/accel"]})

    def test_the_renderer_sees_no_sockets(self):
        self.assert_one("image: reaches proto/transport", {},
                        {"image": ["proto/transport"]})

    def test_the_documented_modules_have_their_walls(self):
        """Each row of the table but the program's names the modules of one wall, in the same order."""
        page = (pathlib.Path(__file__).parents[2] / "docs/architecture.md").read_text()
        table = page.partition("| module |")[2].partition("\n\n")[0]
        rows = []
        for line in table.splitlines()[2:]:
            modules = re.findall("`([^`]+)`", line.split("|")[1])
            if modules == ["cli"]:
                continue
            folder = modules[0].rpartition("/")[0]
            rows.append([module if "/" in module or not folder else f"{folder}/{module}" for module in modules])
        self.assertEqual([[p + "/*" if p == "scenes" else p for p in prefixes]
                          for prefixes, _, _ in check_dependencies.WALLS], rows)

    def test_every_wall_stands(self):
        for prefixes, forbidden, why in check_dependencies.WALLS:
            for prefix in prefixes:
                for module in forbidden:
                    with self.subTest(wall=prefix, module=module):
                        lines = self.found({}, {f"{prefix}/x": [f"{module}/y"], f"{module}/y": []})
                        self.assertIn(f"{prefix}/x: reaches {module}/y; {why}", lines)

    def test_walls_hold_through_other_modules(self):
        found = self.found({}, {"scenes/formats": ["proto/extra"],
                                "proto/extra": ["proto/transport"]})
        self.assertEqual(1, len(found), found)
        self.assertIn("scenes/formats: reaches proto/transport", found[0])

    def test_coordinator_and_worker_are_strangers(self):
        self.assertTrue(any("worker: reaches coordinator" in line
                            for line in self.found({}, {"worker": ["coordinator"]})))
        self.assertTrue(any("coordinator: reaches worker" in line
                            for line in self.found({}, {"coordinator": ["worker"]})))

    def test_the_coordinator_does_not_trace(self):
        self.assertTrue(any("coordinator: reaches renderer/accel" in line
                            for line in self.found({}, {"coordinator": ["renderer/accel"]})))

    def test_a_library_outside_its_module(self):
        for what, module, line in [("ZeroMQ", "coordinator", "#include <zmq.h>"),
                                 ("OpenImageIO", "image",
                                  "#include <OpenImageIO/imageio.h>"),
                                 ("pugixml", "renderer/math", '#include "pugixml.hpp"'),
                                 ("protobuf's parsers", "scenes/formats",
                                  "google::protobuf::TextFormat::Parser parser;"),
                                 ("protobuf's parsers", "worker", "m.ParseFromString(bytes);"),
                                 ("protobuf's parsers", "cli", "JsonStringToMessage(text, &m);")]:
            with self.subTest(line=line):
                found = self.found({f"{module}/x.cpp": f"int before;\n{line}\n"})
                self.assertTrue(any(f"{module}/x.cpp:2: {what}" in v for v in found), found)

    def test_a_file_outside_every_module(self):
        self.assert_one("its folder is no module", {"renderer/lost/x.cpp": "int x;\n"})

    def test_our_headers_in_angle_brackets_or_by_a_short_path(self):
        self.assert_one("is ours", {"renderer/math/a.cpp": "#include <renderer/accel/bvh.h>\n"})
        self.assert_one("not written from the repository's root", {
            "renderer/math/a.cpp": '#include "vec.h"\n', "renderer/math/vec.h": "\n"})

    def test_a_dependency_that_nothing_uses(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "renderer/accel").mkdir(parents=True)
            (root / "renderer/accel/a.cpp").write_text('#include "base/error.h"\n')
            self.assertEqual(["renderer/accel: USES renderer/math, of which it includes nothing"],
                             list(check_dependencies.unused_dependencies(root, MODULES)))

    def test_an_unknown_module_in_a_dependency(self):
        self.assert_one("USES renderer/mth, which is no module", {},
                        {"renderer/accel": ["renderer/mth"]})


if __name__ == "__main__":
    unittest.main()
