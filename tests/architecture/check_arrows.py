#!/usr/bin/env python3
"""Holds every #include of the project, and every type that is declared and not defined, against the
arrows that its rooms declare; and every import of its Python, against names that are a file's own.

    check_arrows.py --root REPOSITORY --rooms BUILD/rooms.txt

rooms.txt has one line a room, "path: used rooms", and is written when CMake configures. Prints one
line a violation and exits with 1 if there is any.
"""
import argparse
import ast
import pathlib
import re
import sys

ENDINGS = {".h", ".cpp", ".cc", ".hpp", ".inl"}
TOP_FOLDERS = ["base", "proto", "renderer", "scenes", "job", "client", "coordinator", "worker", "bench",
               "cli", "python", "front"]
PYTHON_FOLDERS = ["python", "blender", "examples"]
# A type that is named without being defined; and one that is, outside of any other.
DECLARED = re.compile(r"\b(?:class|struct)\s+([A-Z]\w*)\s*[;*&>]")
DEFINED = re.compile(r"^(?:template\s*<.*>\s*)?(?:class|struct)\s+([A-Z]\w*)\b(?!\s*[;*&>])")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')

# The table of docs/architecture.md, a line a row: what its rooms may not reach, not even through
# others: (prefixes of the rooms, forbidden prefixes, why).
FARM = ["proto/transport", "job", "client", "coordinator", "worker", "cli"]
WALLS = [
    (["base"], [f for f in TOP_FOLDERS if f != "base"], "base knows nothing of ours"),
    (["proto/tessera/v1"], TOP_FOLDERS, "the messages know nothing of ours"),
    (["proto/wire"], FARM + ["renderer", "scenes", "bench"], "encodings see no sockets"),
    (["proto/transport"],
     ["proto/tessera", "proto/wire", "renderer", "scenes", "job", "client", "coordinator", "worker",
      "bench", "cli"],
     "the transport carries bytes"),
    (["renderer/math", "renderer/shapes", "renderer/accel"],
     FARM + ["proto", "scenes", "bench", "renderer/shading", "renderer/film", "renderer/denoise",
             "renderer/image", "renderer/scene"], "intersections know neither scene files nor light"),
    (["renderer/sampler", "renderer/camera", "renderer/shading"],
     FARM + ["proto", "scenes", "bench", "renderer/accel"],
     "what surfaces and lights do is the same for every accelerator"),
    (["renderer/film", "renderer/denoise", "renderer/image"],
     FARM + ["proto", "scenes", "bench", "renderer/scene", "renderer/accel"],
     "pictures know no scenes"),
    (["renderer/scene", "renderer/integrator", "renderer/render"],
     FARM + ["scenes", "bench", "renderer/image"], "the renderer sees no sockets and no files"),
    (["renderer/query"], FARM + ["scenes", "bench", "renderer/image"],
     "ray queries see no sockets and no files"),
    (["scenes"], FARM + ["bench"] + [f"renderer/{room}" for room in (
        "shapes", "accel", "sampler", "camera", "shading", "film", "denoise", "image", "scene",
        "integrator", "render")], "scene files see neither sockets nor the renderer beyond math"),
    (["bench"], FARM, "benchmarks see no sockets"),
    (["bench/error"], FARM + ["proto", "scenes", "renderer"], "measures are functions of numbers"),
    (["job"], ["proto/transport", "client", "coordinator", "worker", "cli", "bench", "scenes",
               "renderer/accel", "renderer/scene", "renderer/render"],
     "what a job is does not depend on who renders it"),
    (["client"], ["coordinator", "worker", "cli", "bench", "scenes", "renderer/accel",
                  "renderer/scene", "renderer/render", "renderer/image"],
     "a client knows the coordinator by its messages alone"),
    (["coordinator/tiles"], ["proto/transport", "client", "worker", "cli", "bench", "scenes",
                             "coordinator/jobs", "renderer/accel", "renderer/integrator", "renderer/scene",
                             "renderer/render"],
     "which tile goes to whom is known without jobs, sockets and what traces"),
    (["coordinator/jobs"], ["proto/transport", "client", "worker", "cli", "bench", "scenes", "renderer/accel",
                            "renderer/integrator", "renderer/scene", "renderer/render"],
     "a job knows neither sockets nor what traces"),
    (["coordinator"], ["client", "worker", "cli", "bench", "scenes", "renderer/accel", "renderer/integrator",
                       "renderer/scene", "renderer/render"],
     "the coordinator neither traces nor knows the worker's code"),
    (["coordinator/store"], ["renderer/accel", "renderer/scene", "scenes", "worker", "cli"],
     "a store keeps tiles and knows nothing of what traces them"),
    (["coordinator/web"], ["client", "worker", "cli", "bench", "scenes", "renderer/accel",
                           "renderer/scene", "renderer/render"],
     "the page shows what the coordinator tells of itself"),
    (["coordinator/tev"], ["client", "worker", "cli", "bench", "scenes", "renderer/accel",
                           "renderer/scene", "renderer/render"], "the viewer is shown pixels"),
    (["worker"], ["client", "coordinator", "cli", "bench", "scenes", "renderer/image"],
     "the worker knows neither the coordinator's code nor files"),
    (["front"], ["cli", "python"], "what front ends share knows none of them"),
    (["python"], ["cli"], "the Python package stands beside the program"),
]

# What only one room may touch: (what, pattern of a line, the rooms that may).
MONOPOLIES = [
    ("ZeroMQ", re.compile(r'#\s*include\s*[<"]zmq'), ["proto/transport"]),
    ("protobuf's parsers",
     re.compile(r"TextFormat|JsonStringToMessage|\bParse(Partial)?From|google/protobuf/(text_format|"
                r"util/json_util)"), ["proto/wire", "python/generate"]),
    ("OpenImageIO", re.compile(r'#\s*include\s*[<"]OpenImageIO'), ["renderer/image/oiio"]),
    ("Embree", re.compile(r'#\s*include\s*[<"]embree'), ["renderer/accel/embree"]),
    ("pugixml", re.compile(r'#\s*include\s*[<"]pugixml'), ["scenes/formats"]),
]


def below(room, prefix):
    return room == prefix or room.startswith(prefix + "/")


def read_rooms(path):
    rooms = {}
    for line in path.read_text().splitlines():
        if line.strip():
            room, _, uses = line.partition(":")
            rooms[room.strip()] = uses.split()
    return rooms


def find_cycle(rooms):
    """One cycle of the arrows as a list of rooms, or None."""
    done, trail = set(), []

    def visit(room):
        if room in trail:
            return trail[trail.index(room):] + [room]
        if room in done:
            return None
        trail.append(room)
        for used in rooms.get(room, []):
            if cycle := visit(used):
                return cycle
        trail.pop()
        done.add(room)
        return None

    for room in rooms:
        if cycle := visit(room):
            return cycle
    return None


def reachable(rooms, start):
    seen, todo = set(), list(rooms.get(start, []))
    while todo:
        room = todo.pop()
        if room not in seen:
            seen.add(room)
            todo += rooms.get(room, [])
    return seen


def check_declarations(rooms):
    for room, uses in rooms.items():
        for used in uses:
            if used not in rooms:
                yield f"{room}: USES {used}, which is no room"
    if cycle := find_cycle(rooms):
        yield "cycle: " + " -> ".join(cycle)
    for room in rooms:
        for prefixes, forbidden, why in WALLS:
            if any(below(room, prefix) for prefix in prefixes):
                for used in sorted(reachable(rooms, room)):
                    if any(below(used, f) for f in forbidden):
                        yield f"{room}: reaches {used}; {why}"


def source_lines(text):
    """(number, line) of every line with comments blanked, so that prose is not taken for code."""
    text = re.sub(r"/\*.*?\*/", lambda m: "\n" * m.group().count("\n"), text, flags=re.S)
    for number, line in enumerate(text.splitlines(), 1):
        yield number, line if INCLUDE.match(line) else line.split("//")[0]


def check_include(rooms, root, room, style, target):
    """What is wrong with one #include of a file in `room`, or None."""
    used = str(pathlib.PurePosixPath(target).parent)
    inside = used in rooms or target.split("/")[0] in TOP_FOLDERS
    if style == "<":
        return f'<{target}> is ours: include it with "..."' if inside else None
    if not inside:
        if (root / room / target).exists():
            return f'"{target}" is not written from the repository\'s root'
        return f'"{target}" is in no room'
    if used not in rooms:
        return f'"{target}" is in {used}, which is no room'
    if used != room and used not in rooms[room]:
        return f'"{target}": {room} does not declare USES {used}'
    return None


def defined_types(rooms, root):
    """The rooms whose headers define a type, by its name."""
    types = {}
    for room in rooms:
        for path in (root / room).glob("*.h"):
            for _, line in source_lines(path.read_text(errors="replace")):
                if defined := DEFINED.match(line):
                    types.setdefault(defined.group(1), set()).add(room)
    return types


def check_declared(rooms, types, room, name):
    """What is wrong with declaring that type in `room`, or None."""
    homes = types.get(name, set())
    if not homes or homes & {room, *rooms[room]}:
        return None
    return f"declares {name} of {', '.join(sorted(homes))}, which {room} does not use"


def check_file(rooms, types, root, room, path):
    name = path.relative_to(root)
    for number, line in source_lines(path.read_text(errors="replace")):
        if include := INCLUDE.match(line):
            if fault := check_include(rooms, root, room, *include.groups()):
                yield f"{name}:{number}: {fault}"
        for declared in DECLARED.finditer(line):
            if fault := check_declared(rooms, types, room, declared.group(1)):
                yield f"{name}:{number}: {fault}"
        for what, pattern, owners in MONOPOLIES:
            if pattern.search(line) and not any(below(room, owner) for owner in owners):
                yield f"{name}:{number}: {what} outside {', '.join(owners)}"


def check_imports(root):
    """Within the Python package no file takes another's private names; whoever uses the package, not
    even its private modules."""
    for folder in PYTHON_FOLDERS:
        for path in sorted((root / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text())):
                if not isinstance(node, (ast.Import, ast.ImportFrom)):
                    continue
                taken = [alias.name for alias in node.names]
                module = getattr(node, "module", None) or ""
                within = getattr(node, "level", 0) > 0
                if within:  # its own modules may be private
                    private = [name for name in taken if module and name.startswith("_")]
                else:
                    private = [full for full in (f"{module}.{name}".lstrip(".") for name in taken)
                               if full.startswith("tessera.") and "._" in full]
                for name in private:
                    yield f"{path.relative_to(root)}:{node.lineno}: imports {name}, which is private"


def unused_arrows(root, rooms):
    for room, uses in rooms.items():
        included = set()
        files = [p for p in (root / room).glob("*") if p.suffix in ENDINGS]
        for path in files:
            for _, line in source_lines(path.read_text(errors="replace")):
                if include := INCLUDE.match(line):
                    included.add(str(pathlib.PurePosixPath(include.group(2)).parent))
        # A room without files of its own is all generated, or not written yet.
        for used in uses if files else []:
            if used in rooms and used not in included:
                yield f"{room}: USES {used}, of which it includes nothing"


def violations(root, rooms):
    yield from check_declarations(rooms)
    types = defined_types(rooms, root)
    for top in TOP_FOLDERS:
        for path in sorted((root / top).rglob("*")):
            if path.suffix in ENDINGS and path.is_file():
                room = path.parent.relative_to(root).as_posix()
                if room not in rooms:
                    yield f"{path.relative_to(root)}: its folder is no room"
                else:
                    yield from check_file(rooms, types, root, room, path)
    yield from check_imports(root)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, required=True)
    parser.add_argument("--rooms", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    rooms = read_rooms(arguments.rooms)
    root = arguments.root.resolve()
    found = [*violations(root, rooms), *unused_arrows(root, rooms)]
    for line in found:
        print(line)
    print(f"{len(rooms)} rooms, {sum(map(len, rooms.values()))} arrows, {len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
