"""Leaves an animation to a farm, watches it, and fetches its pictures.

    farm.py [FRAMES [WIDTH [ENDPOINT]]]           writes roll.0000.png and so on

Without an endpoint, it starts a farm of one worker on this machine.
"""
import contextlib
import subprocess
import sys

import tessera as ts

frames = max(2, int(sys.argv[1])) if len(sys.argv) > 1 else 24
width = int(sys.argv[2]) if len(sys.argv) > 2 else 640


def program(stack: contextlib.ExitStack, *arguments: str) -> subprocess.Popen[str]:
    """Starts the program `tessera`, which is ended with the stack."""
    process = stack.enter_context(subprocess.Popen([ts.program(), *arguments], text=True,
                                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL))
    stack.callback(process.terminate)
    return process


def small_farm(stack: contextlib.ExitStack) -> str:
    """Starts a coordinator and a worker; returns where they are."""
    serve = program(stack, "serve", "--bind", "tcp://127.0.0.1:*")
    assert serve.stdout is not None
    endpoint = serve.stdout.readline().split()[-1]  # "serving at tcp://127.0.0.1:PORT"
    program(stack, "worker", "--connect", endpoint)
    return endpoint


last = frames - 1
scene = ts.Scene(width=width, height=width * 9 // 16, spp=4, background="lightsteelblue",
                 frames=ts.Frames(first=0, last=last, per_second=24))
scene.camera = ts.Camera.look_at(eye=(0, 2, 7), target=(0, 0.7, 0), fov=35)
scene.add(ts.Plane(), material=ts.Classic(diffuse=ts.CheckerTexture(mapping="object")))
die = scene.add(ts.Box(), material=ts.Classic(diffuse="crimson", specular="white"))
# It rolls a full turn, by eighths; on an edge it is higher than on a face.
die.keys = ts.keys((last / 24 * eighth / 8,
                    ts.translate(0.6 * eighth - 2.4, 0.85 if eighth % 2 else 0.6, 0)
                    @ ts.rotate("z", -45 * eighth) @ ts.scale(0.6)) for eighth in range(9))
scene.add(ts.PointLight(position=(4, 6, 5)))

with contextlib.ExitStack() as stack:
    endpoint = sys.argv[3] if len(sys.argv) > 3 else small_farm(stack)
    with ts.Farm(endpoint) as farm:
        job = farm.submit(scene, frames=(0, last), name="roll")
        for status in job.watch():
            print(f"job {job.number}: {status['state']}, {farm.workers()} workers")
        for frame in job.frames():
            job.fetch(frame).save(f"roll.{frame:04}.png")
            print(f"roll.{frame:04}.png")
