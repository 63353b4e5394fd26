"""Renders by the real program, for the scripts of this folder."""
import array
import resource
import subprocess


def pixels(path):
    """The numbers of a PFM file."""
    with open(path, "rb") as file:
        for _ in range(3):
            file.readline()
        values = array.array("f")
        values.frombytes(file.read())
    return values


def mean_square(values, truth):
    return sum((a - b) ** 2 for a, b in zip(values, truth)) / len(truth)


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def render(program, scene, picture, *options):
    """The pixels, and the processor seconds, of one thread."""
    begin = cpu_seconds()
    subprocess.run([program, "render", scene, "--pattern", "owen-sobol", "--workers", "0",
                    "--threads", "1", "--quiet", "-o", picture, *options], check=True)
    return pixels(picture), cpu_seconds() - begin
