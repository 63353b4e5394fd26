#!/usr/bin/env python3
"""What the features that a scene does not use cost it, in instructions.

  tests/bench/unused_features.py build/release                icosphere:6, lit as a model by itself
  tests/bench/unused_features.py build/release bunny.obj ...  these scenes
  tests/bench/unused_features.py build/release --check        only whether what is to be deleted
                                                              is there, with a list of it

Of a finished build whose source is unchanged, the few files that ask a scene for features while it
is traced are compiled once more, with those questions deleted, and linked to a program of their own
in BUILD/unused_features. Both programs then render each scene under callgrind; what a further
sample a pixel takes is told for each, and how much more of it is the features'. The pictures must be
equal to the last bit. The exit code is 1 where one differs, or the features take more than --most.
Needs valgrind. Takes a minute for a scene.
"""

import argparse
import json
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
WHITTED = "renderer/integrator/whitted.cpp"
DIRECT = "renderer/integrator/direct_light.cpp"
POINT_HEADER = "renderer/integrator/surface_point.h"
POINT = "renderer/integrator/surface_point.cpp"
MATERIAL = "renderer/shading/material.h"
COMPILED = [WHITTED, DIRECT, POINT]

# (the feature, its file, what stands there exactly once, what stands in its place)
DELETIONS = [
    ("fog", WHITTED, "const bool foggy = !kPlain && scene_->fog.kind != FogKind::none;",
     "constexpr bool foggy = false;"),
    ("grain", WHITTED, "if (!kPlain && point.material->grain > 0)", "if (false)"),
    ("missing and other backs", POINT, "if (is_back && material->sides != Sides::two_sided) {",
     "if (false) {"),
    ("flat materials", POINT, "normal = material->flat ? geometric_normal : ", "normal = "),
    ("vertex colours", POINT_HEADER,
     "if (!point.surface.has_vertex_color) return material.diffuse;",
     "if (true) return material.diffuse;"),
    ("unlit materials", DIRECT, "if (!kPlain && material.model == MaterialModel::unlit) {",
     "if (false) {"),
    ("refraction beside reflection", DIRECT,
     "!kPlain && material.transmission == Transmission::refract;", "false;"),
    ("clear shadows", DIRECT, "if (kPlain || !occluders.clear) return kWhite;",
     "if (true) return kWhite;"),
    ("soft shadows", DIRECT, "return kPlain ? kBlack : kWhite * (1 - light.shadow_intensity);",
     "return kBlack;"),
    ("bounded shadows", DIRECT, "if (!kLambert && std::isfinite(light.shadow_distance)) {",
     "if (false) {"),
    ("attenuated ambient light", DIRECT,
     "if (!kPlain && light.ambient_attenuated) ambient += light.ambient * sample.factor;", ""),
    ("ambient light of the whole scene", DIRECT,
     "if (kPlain || !light.ambient_attenuated) ambient += light.ambient;",
     "ambient += light.ambient;"),
    ("light that is subtracted", DIRECT, "if (!kPlain && shades_itself) {",
     "if (false) {"),
    ("lights without shadows", DIRECT, "if (kPlain || light.casts_shadow)\n", "if (true)\n"),
    ("half-Lambert and signed Lambert", MATERIAL,
     "} else if (material.diffuse_model == DiffuseModel::half_lambert) {", "} else if (false) {"),
    ("the switch of shadow rays left out", DIRECT, "if (kPlain || skips) {",
     "if (true) {"),
    ("that of faint branches", WHITTED, " || !scene_->skips.faint_branches", ""),
    ("that of texture points", POINT, "if (scene.skips.texture_points) {", "if (true) {"),
    ("the one or the other", MATERIAL, "if (kLambert || material.diffuse_model == DiffuseModel::lambert) {",
     "if (true) {"),
]


def run(command, **options):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{shlex.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def write_plain_source(folder):
    for name in {file for _, file, _, _ in DELETIONS} | set(COMPILED):
        text = (ROOT / name).read_text()
        for feature, file, old, new in DELETIONS:
            if file != name:
                continue
            if text.count(old) != 1:
                sys.exit(f"{name}: '{old}' is there {text.count(old)} times; bring '{feature}' in "
                         "DELETIONS up to date")
            text = text.replace(old, new)
        copy = folder / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(text)


def compile_plain(build, folder):
    """Headers of the plain source go before those of the other. Files that are compiled together in
    this build are so here."""
    objects = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        names = [name for name in COMPILED if ROOT / name == source]
        plain = folder / names[0] if names else folder / source.name
        if source.parent.name == "Unity" and source.exists():
            text = source.read_text()
            names = [name for name in COMPILED if f'"{ROOT / name}"' in text]
            for name in names:
                text = text.replace(f'"{ROOT / name}"', f'"{folder / name}"')
            if names:
                plain.write_text(text)
        if not names:
            continue
        words = shlex.split(entry["command"])
        words[words.index(entry["file"])] = str(plain)
        objects.append(f"{plain}.o")
        words[words.index("-o") + 1] = objects[-1]
        compiler = next(i for i, word in enumerate(words) if word.endswith("++"))
        words[compiler + 1:compiler + 1] = [f"-I{folder}", "-w"]
        run(words, cwd=entry["directory"])
    return objects


def link_plain(build, folder, objects):
    """What the objects define is not looked for in the libraries that come after them."""
    last = run(["ninja", "-C", str(build), "-t", "commands", "bin/tessera"]).splitlines()[-1]
    command = re.sub(r"^: && | && :$", "", last)
    program = folder / "tessera"
    command = command.replace("-o bin/tessera", shlex.join([*objects, "-o", str(program)]), 1)
    run(["sh", "-c", command], cwd=build)
    return program


def instructions(program, scene, samples, folder):
    """Of a render, and the picture."""
    picture, counts = folder / "picture.pfm", folder / "callgrind.out"
    run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}", program, "render", scene,
         "--size", "400x300", "--spp", str(samples), "--workers", "0", "--threads", "1",
         "-o", picture])
    total = re.search(r"^(?:summary|totals): (\d+)", counts.read_text(errors="replace"), re.M)
    return int(total.group(1)), picture.read_bytes()


def sample_cost(program, scene, folder):
    few, _ = instructions(program, scene, 1, folder)
    many, picture = instructions(program, scene, 3, folder)
    return (many - few) / 2, picture


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--most", type=float, default=2, help="per cent [2]")
    options = parser.parse_args()
    build = options.build.resolve()
    folder = build / "unused_features"
    write_plain_source(folder)
    if options.check:
        for feature, file, _, _ in DELETIONS:
            print(f"{feature:36} {file}")
        return 0
    plain = link_plain(build, folder, compile_plain(build, folder))
    full = build / "bin" / "tessera"
    scenes = options.scenes
    if not scenes:
        run([full, "convert", "icosphere:6", folder / "icosphere.tesserab"])
        scenes = [folder / "icosphere.tesserab"]
    failed = False
    print(f"{'scene':24} {'with, M':>9} {'without, M':>10} {'more':>7}")
    for scene in scenes:
        with_all, picture = sample_cost(full, scene, folder)
        without, plain_picture = sample_cost(plain, scene, folder)
        more = 100 * (with_all / without - 1)
        differs = picture != plain_picture
        failed |= differs or more > options.most
        print(f"{scene.name:24} {with_all / 1e6:9.1f} {without / 1e6:10.1f} {more:5.2f} %"
              f"{'  OTHER PIXELS' if differs else ''}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
