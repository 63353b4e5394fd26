#!/usr/bin/env python3
"""Holds every #include of the project, and every type that is declared and not defined, against the
dependencies that its modules declare; and every import of its Python, against names that are a file's own.

    check_dependencies.py --root REPOSITORY --modules BUILD/modules.txt

modules.txt has one line a module, "path: used modules", and is written when CMake configures. Prints one
line a violation and exits with 1 if there is any.
"""
import argparse
import ast
import pathlib
import re
import sys

ENDINGS = {".h", ".cpp", ".cc", ".hpp", ".inl"}
TOP_FOLDERS = ["base", "proto", "renderer", "scenes", "job", "client", "coordinator", "worker", "bench", "metrics",
               "cli", "python", "front", "web", "studio", "image", "query"]
PYTHON_FOLDERS = ["python", "blender", "examples"]
# A type that is named without being defined; and one that is, outside of any other.
DECLARED = re.compile(r"\b(?:class|struct)\s+([A-Z]\w*)\s*[;*&>]")
DEFINED = re.compile(r"^(?:template\s*<.*>\s*)?(?:class|struct)\s+([A-Z]\w*)\b(?!\s*[;*&>])")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')

# The table of docs/architecture.md, a line a row: what its modules may not reach, not even through
# others: (prefixes of the modules, forbidden prefixes, why).
FARM = ["proto/transport", "job", "client", "coordinator", "worker", "cli", "web", "studio"]
WALLS = [
    (["base"], [f for f in TOP_FOLDERS if f != "base"], "base knows nothing of ours"),
    (["proto/tessera/v1"], TOP_FOLDERS, "the messages know nothing of ours"),
    (["proto/wire"], FARM + ["renderer", "image", "query", "scenes", "bench"], "encodings see no sockets"),
    (["proto/transport"],
     ["proto/tessera", "proto/wire", "renderer", "image", "query", "scenes", "job", "client", "coordinator",
      "worker", "bench", "cli", "web"],
     "the transport carries bytes"),
    (["web"], [f for f in FARM if f != "web"] + ["renderer", "image", "query", "scenes", "bench", "front", "python"],
     "what serves pages knows neither jobs nor scenes"),
    (["renderer/math", "renderer/shapes", "renderer/accel"],
     FARM + ["proto", "scenes", "bench", "renderer/shading", "renderer/film", "renderer/denoise",
             "image", "renderer/scene"], "intersections know neither scene files nor light"),
    (["renderer/sampler", "renderer/camera", "renderer/shading"],
     FARM + ["proto", "scenes", "bench", "renderer/accel"],
     "what surfaces and lights do is the same for every accelerator"),
    (["renderer/film", "renderer/denoise"],
     FARM + ["proto", "scenes", "bench", "renderer/scene", "renderer/accel", "image"],
     "pictures know no scenes"),
    (["renderer/scene", "renderer/integrator", "renderer/render"],
     FARM + ["scenes", "bench", "image", "query"], "the renderer sees no sockets and no files"),
    (["image"], FARM + ["proto", "scenes", "bench", "renderer/scene", "renderer/accel", "query"],
     "image files know no scenes"),
    (["query"], FARM + ["scenes", "bench", "image"],
     "ray queries see no sockets and no files"),
    (["scenes"], FARM + ["bench"] + [f"renderer/{module}" for module in (
        "shapes", "accel", "sampler", "camera", "shading", "film", "denoise", "scene",
        "integrator", "render")] + ["image", "query"], "scene files see neither sockets nor the renderer beyond math"),
    (["scenes/edit"], ["scenes/generate", "scenes/mesh"],
     "an edit is a function of texts: text and change in, changed text out"),
    (["metrics"], [f for f in TOP_FOLDERS if f not in ("base", "metrics")],
     "a measure is a function of two pictures"),
    (["bench"], [f for f in FARM if f != "web"], "benchmarks see no sockets of the farm"),
    (["bench/studio"], ["renderer", "image", "query", "scenes"],
     "the studio is measured as its page sees it"),
    (["bench/error"], FARM + ["proto", "scenes", "renderer", "image", "query"], "measures are functions of numbers"),
    (["job"], ["proto/transport", "client", "coordinator", "worker", "cli", "bench", "web", "scenes",
               "renderer/accel", "renderer/scene", "renderer/render"],
     "what a job is does not depend on who renders it"),
    (["client"], ["coordinator", "worker", "cli", "bench", "web", "scenes", "renderer/accel",
                  "renderer/scene", "renderer/render", "image"],
     "a client knows the coordinator by its messages alone"),
    (["coordinator/tiles"], ["proto/transport", "client", "worker", "cli", "bench", "web", "scenes",
                             "coordinator/jobs", "renderer/accel", "renderer/integrator", "renderer/scene",
                             "renderer/render"],
     "which tile goes to whom is known without jobs, sockets and what traces"),
    (["coordinator/jobs"], ["proto/transport", "client", "worker", "cli", "bench", "web", "scenes",
                            "renderer/accel", "renderer/integrator", "renderer/scene", "renderer/render"],
     "a job knows neither sockets nor what traces"),
    (["coordinator"], ["client", "worker", "cli", "bench", "scenes", "renderer/accel", "renderer/integrator",
                       "renderer/scene", "renderer/render"],
     "the coordinator neither traces nor knows the worker's code"),
    (["coordinator/store"], ["web", "renderer/accel", "renderer/scene", "scenes", "worker", "cli"],
     "a store keeps tiles and knows nothing of what traces them"),
    (["coordinator/web"], ["client", "worker", "cli", "bench", "scenes", "renderer/accel",
                           "renderer/scene", "renderer/render"],
     "the page shows what the coordinator tells of itself"),
    (["coordinator/tev"], ["client", "worker", "cli", "bench", "scenes", "renderer/accel",
                           "renderer/scene", "renderer/render"], "the viewer is shown pixels"),
    (["worker"], ["client", "coordinator", "cli", "bench", "web", "scenes", "image"],
     "the worker knows neither the coordinator's code nor files"),
    (["front"], ["cli", "python", "studio"], "what front ends share knows none of them"),
    (["studio"], ["cli", "bench", "python", "coordinator/web"],
     "the studio stands on front, as the other front ends do"),
    (["studio/files"], [f for f in TOP_FOLDERS if f not in ("base", "studio")],
     "texts and files are kept without knowing what is in them"),
    (["python"], ["cli", "bench", "studio"], "the Python package stands beside the program"),
]

# What only one module may touch: (what, pattern of a line, the modules that may).
MONOPOLIES = [
    ("ZeroMQ", re.compile(r'#\s*include\s*[<"]zmq'), ["proto/transport"]),
    ("protobuf's parsers",
     re.compile(r"TextFormat|JsonStringToMessage|\bParse(Partial)?From|google/protobuf/(text_format|"
                r"util/json_util)"), ["proto/wire", "python/generate", "scenes/edit/generate"]),
    ("OpenImageIO", re.compile(r'#\s*include\s*[<"]OpenImageIO'), ["image/oiio"]),
    ("Embree", re.compile(r'#\s*include\s*[<"]embree'), ["renderer/accel/embree"]),
    ("Boost.Beast", re.compile(r'#\s*include\s*[<"]boost/(beast|asio)'), ["web"]),
    ("pugixml", re.compile(r'#\s*include\s*[<"]pugixml'), ["scenes/formats"]),
]


def below(module, prefix):
    return module == prefix or module.startswith(prefix + "/")


def read_modules(path):
    modules = {}
    for line in path.read_text().splitlines():
        if line.strip():
            module, _, uses = line.partition(":")
            modules[module.strip()] = uses.split()
    return modules


def find_cycle(modules):
    """One cycle of the dependencies as a list of modules, or None."""
    done, trail = set(), []

    def visit(module):
        if module in trail:
            return trail[trail.index(module):] + [module]
        if module in done:
            return None
        trail.append(module)
        for used in modules.get(module, []):
            if cycle := visit(used):
                return cycle
        trail.pop()
        done.add(module)
        return None

    for module in modules:
        if cycle := visit(module):
            return cycle
    return None


def reachable(modules, start):
    seen, todo = set(), list(modules.get(start, []))
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += modules.get(module, [])
    return seen


def check_declarations(modules):
    for module, uses in modules.items():
        for used in uses:
            if used not in modules:
                yield f"{module}: USES {used}, which is no module"
    if cycle := find_cycle(modules):
        yield "cycle: " + " -> ".join(cycle)
    for module in modules:
        for prefixes, forbidden, why in WALLS:
            if any(below(module, prefix) for prefix in prefixes):
                for used in sorted(reachable(modules, module)):
                    if any(below(used, f) for f in forbidden):
                        yield f"{module}: reaches {used}; {why}"


def source_lines(text):
    """(number, line) of every line with comments blanked, so that prose is not taken for code."""
    text = re.sub(r"/\*.*?\*/", lambda m: "\n" * m.group().count("\n"), text, flags=re.S)
    for number, line in enumerate(text.splitlines(), 1):
        yield number, line if INCLUDE.match(line) else line.split("//")[0]


def check_include(modules, root, module, style, target):
    """What is wrong with one #include of a file in `module`, or None."""
    used = str(pathlib.PurePosixPath(target).parent)
    inside = used in modules or target.split("/")[0] in TOP_FOLDERS
    if style == "<":
        return f'<{target}> is ours: include it with "..."' if inside else None
    if not inside:
        if (root / module / target).exists():
            return f'"{target}" is not written from the repository\'s root'
        return f'"{target}" is in no module'
    if used not in modules:
        return f'"{target}" is in {used}, which is no module'
    if used != module and used not in modules[module]:
        return f'"{target}": {module} does not declare USES {used}'
    return None


def defined_types(modules, root):
    """The modules whose headers define a type, by its name."""
    types = {}
    for module in modules:
        for path in (root / module).glob("*.h"):
            for _, line in source_lines(path.read_text(errors="replace")):
                if defined := DEFINED.match(line):
                    types.setdefault(defined.group(1), set()).add(module)
    return types


def check_declared(modules, types, module, name):
    """What is wrong with declaring that type in `module`, or None."""
    homes = types.get(name, set())
    if not homes or homes & {module, *modules[module]}:
        return None
    return f"declares {name} of {', '.join(sorted(homes))}, which {module} does not use"


def check_file(modules, types, root, module, path):
    name = path.relative_to(root)
    for number, line in source_lines(path.read_text(errors="replace")):
        if include := INCLUDE.match(line):
            if fault := check_include(modules, root, module, *include.groups()):
                yield f"{name}:{number}: {fault}"
        for declared in DECLARED.finditer(line):
            if fault := check_declared(modules, types, module, declared.group(1)):
                yield f"{name}:{number}: {fault}"
        for what, pattern, owners in MONOPOLIES:
            if pattern.search(line) and not any(below(module, owner) for owner in owners):
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


def unused_dependencies(root, modules):
    for module, uses in modules.items():
        included = set()
        files = [p for p in (root / module).glob("*") if p.suffix in ENDINGS]
        for path in files:
            for _, line in source_lines(path.read_text(errors="replace")):
                if include := INCLUDE.match(line):
                    included.add(str(pathlib.PurePosixPath(include.group(2)).parent))
        # A module without files of its own is all generated, or not written yet.
        for used in uses if files else []:
            if used in modules and used not in included:
                yield f"{module}: USES {used}, of which it includes nothing"


def violations(root, modules):
    yield from check_declarations(modules)
    types = defined_types(modules, root)
    for top in TOP_FOLDERS:
        for path in sorted((root / top).rglob("*")):
            if path.suffix in ENDINGS and path.is_file():
                module = path.parent.relative_to(root).as_posix()
                if module not in modules:
                    yield f"{path.relative_to(root)}: its folder is no module"
                else:
                    yield from check_file(modules, types, root, module, path)
    yield from check_imports(root)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, required=True)
    parser.add_argument("--modules", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    modules = read_modules(arguments.modules)
    root = arguments.root.resolve()
    found = [*violations(root, modules), *unused_dependencies(root, modules)]
    for line in found:
        print(line)
    print(f"{len(modules)} modules, {sum(map(len, modules.values()))} dependencies, {len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
