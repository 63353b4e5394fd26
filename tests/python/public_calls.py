"""Every public call of the package, and what tests of all of them have to know of each.

The large inputs are no larger than needed: Python itself keeps the lock while it frees a gigabyte, joins
texts of that size, makes a table of a million entries larger, or moves what it has pickled so far.

A call is `Class.method` of the class that defines it, a function, or `Class.__init__` where a class has one
of its own. A new one has to be put into a table here: test_public_calls.py compares.
"""
import functools
import inspect
import re
import typing

import tessera as ts
from tessera import compat

#: Special methods that no script calls: Python does, where it makes, looks up or deletes.
OF_PYTHON = {"__del__", "__delattr__", "__getattr__", "__getattribute__", "__getnewargs__", "__init_subclass__",
             "__new__", "__setattr__"}
#: Classes that only the package makes, whose constructors are no calls.
MADE_BY_US = {"AllHits", "Located", "Array", "BaseFarm", "OfThisProcess", "Image", "Job", "Task", "Tracer"}

#: What tells the unit or the range of a number.
UNIT = re.compile(
    r"\b(metres?|degrees?|seconds?|pixels?|texels?|stops?|bounces|factors?|shares?|exponent|any (length|number)|"
    r"how many|how often|increasing|refractive index|unit normals?|lengths of|per (axis|channel)|([0-9]+|three) numbers|"
    r"(of (that|the)|by (its|their)|frame's) numbers?)\b|[<>]=? ?[0-9]|-?[0-9.]+ (\w+ )?to -?[0-9]|\bin [\[(][0-9]|"
    r"\bat (least|most) \S|\bfrom \S+ (up )?to \S|^[0-9]+ [^,;]+, [0-9]+ ", re.I)


def is_special(name):
    """Whether a call is made by an operator, `with`, `pickle`, `copy`, `repr` or a notebook."""
    return name.rpartition(".")[2].startswith("_") and not name.endswith(".__init__")


def public_calls():
    """The function, property or method by its name."""
    calls = {}
    for name in (*ts.__all__, "MeshIntersector"):
        thing = vars(ts).get(name) or getattr(compat, name)
        if not inspect.isclass(thing):
            if callable(thing):
                calls[name] = thing
            continue
        if issubclass(thing, (Exception, Warning)):
            continue
        for made in thing.__mro__:
            if made.__module__.split(".")[0] != "tessera":
                continue
            for member, held in vars(made).items():
                is_property = isinstance(held, (property, functools.cached_property))
                is_call = is_property or isinstance(held, (classmethod, staticmethod)) or inspect.isroutine(held)
                is_public = (made.__module__ != "tessera._messages" and made.__name__ not in MADE_BY_US
                             if member == "__init__" else member not in OF_PYTHON
                             and re.fullmatch(r"[a-zA-Z]\w*|__\w+__|_repr_\w+_", member))
                if is_call and is_public:
                    calls[f"{made.__name__}.{member}"] = held if is_property else getattr(made, member)
    return calls


class Large(typing.NamedTuple):
    """A call on inputs for which it takes long, as test_large_inputs.py measures."""

    setup: str
    call: str
    is_heard: bool = True
    """Whether Ctrl-C ends it. Where it does not, `call` passes over memory once, in less than 0.2 s,
    or is a call of numpy."""


#: What the scripts of LARGE begin with.
COMMON = """
import copy, gc, os, pickle, signal, sys, threading, time
import numpy as np
import tessera as ts
from tessera import compat
random = np.random.default_rng(1)
gc.disable()  # which keeps the lock while it looks through all that there is

def picture(n=4000, aovs=()):
    if not aovs:
        return ts.Image.from_array(random.random((n, n, 3), "f4"))
    small = ts.Scene(nodes=[ts.Sphere()], background=1).render(size=(4, 4), spp=1, aovs=aovs, workers=0)
    restore, (state, has_16_bits) = small.__reduce__()
    values = random.random((n, n, state[0].shape[2]), "f4")
    return restore((ts.Array.from_bytes(values.tobytes(), "f", list(values.shape)), *state[1:]), has_16_bits)

def grid(n=1000):
    corner = np.arange(n * n).reshape(n, n)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    positions = np.stack([u, .01 * random.random((n, n)), v], -1).reshape(-1, 3)
    return positions, np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)

def spheres(n=300_000):
    return ts.Scene(nodes=[ts.Sphere(radius=i + 1, name=str(i)) for i in range(n)])

def ground(n=1500):
    return ts.Scene(nodes=[ts.Mesh(*grid(n))], background=1)

def matrices(n=5_000_000):
    return np.tile(np.eye(4)[:3], (n, 1, 1))

def rays(n=6_000_000):
    origins = random.normal(size=(n, 3))
    origins[:, 1] = 3
    return origins, (0, -1, .1)
"""
_TRACER = "t = ground(500).tracer(); o, d = rays()"
_INTERSECTOR = "m = compat.MeshIntersector(*grid(500)); o, d = rays(); d = np.tile(d, (len(o), 1))"
_HITS = "t = ground(500).tracer(); h = t.intersect(*rays(4_000_000))"

#: Calls that can take long, and whose lock and Ctrl-C are looked at.
LARGE = {
    "AllHits.ray": [Large("t = ground(500).tracer(); h = t.intersect_all(*rays(4_000_000))", "h.ray", False)],
    "Array.__eq__": [Large("a = bytearray(10**9); b, c = (ts.Array.from_bytes(a, 'd', [len(a) // 8]) for _ in 'bc')",
                           "b == c", False)],
    "Array.__reduce_ex__": [Large("a = ts.Array.from_bytes(bytes(12 * 10**7), 'd', [15 * 10**6])", "pickle.dumps(a)")],
    "Array.from_bytes": [Large("a = bytearray(5 * 10**8)", "ts.Array.from_bytes(a, 'd', [len(a) // 8])")],
    "Array.of": [Large("a = random.random(15_000_000).tolist()", "ts.Array.of(a, 'd', [len(a)])")],
    "Hits.__getitem__": [Large(_HITS, "h[::2]", False)],
    "Hits.hit": [Large(_HITS, "h.hit", False)],
    "Image.__array__": [Large("i = picture()", "np.array(i, 'f8')", False)],
    "Image.__eq__": [Large("i = picture(6000); j = pickle.loads(pickle.dumps(i))", "i == j", False)],
    "Image.__reduce__": [Large("i = picture(3000)", "pickle.dumps(i)"),
                         Large("i = pickle.dumps(picture(3000))", "pickle.loads(i)")],
    "Image._repr_png_": [Large("i = picture(6000)", "i._repr_png_()")],
    "Image.aov": [Large("i = picture(2000, 'all')", "i.aov('origin')", False)],
    "Image.apply": [Large("i = picture(3000, 'all')", "i.apply(lambda light: light)")],
    "Image.auto_exposure": [Large("i = picture(6000)", "i.auto_exposure()")],
    "Image.from_array": [Large("a = random.integers(0, 256, (4500, 4500, 3), 'u1')", "ts.Image.from_array(a)"),
                         Large("a = random.random((4000, 4000, 3))", "ts.Image.from_array(a)", False)],
    "Image.save": [Large("i = picture(6000)", "i.save(folder + '/x.png')"),
                   Large("i = picture(3000)", "i.save(folder + '/x.exr')")],
    "Image.sha256": [Large("i = picture(6000)", "copy.deepcopy(i)._picture.sha256()")],
    "Image.to_srgb": [Large("i = picture(6000)", "i.to_srgb()"),
                      Large("i = picture(6000)", "i.to_srgb(tone_map='filmic')")],
    "ImageTexture.__init__": [
        Large("a = random.integers(0, 256, (5000, 5000, 3), 'u1')", "ts.ImageTexture(a)"),
        Large("a = random.random((3000, 3000, 3), 'f4')", "ts.ImageTexture(a, encoding='srgb')"),
        Large("picture(5000).save(folder + '/x.png')", "ts.ImageTexture(folder + '/x.png')")],
    "Instances.__init__": [Large("m = matrices()", "ts.Instances('ball', m)")],
    "Instances.__eq__": [Large("m = matrices(); i, j = (ts.Instances('ball', m) for _ in 'ij')", "i == j",
                               False)],
    "Located.__reduce__": [Large(_HITS, "pickle.dumps(h[:], protocol=5, buffer_callback=[].append)")],
    "Mesh.__init__": [Large("p, r = grid(3000)", "ts.Mesh(p, r)"),
                      Large("p, r = grid(2000); c = random.integers(0, 256, (len(p), 3), 'u1')",
                            "ts.Mesh(p, r, colors=c)")],
    "Mesh.is_closed": [Large("m = ts.Mesh(*grid(1500))", "m.is_closed")],
    "Mesh.merge_vertices": [Large("m = ts.Mesh(*grid(500))", "m.merge_vertices(1e-5)")],
    "Mesh.open_edges": [Large("m = ts.Mesh(*grid(1500))", "m.open_edges()")],
    "MeshIntersector.intersects_any": [Large(_INTERSECTOR, "m.intersects_any(o, d)")],
    "MeshIntersector.intersects_first": [Large(_INTERSECTOR, "m.intersects_first(o, d)")],
    "Scene.check": [Large("s = ground()", "s.check()")],
    "Scene.digest": [Large("s = spheres(150_000)", "s.digest")],
    "Scene.find": [Large("s = spheres(100_000)", "s.find('99999')")],
    "Scene.info": [Large("s = ground()", "s.info()")],
    "Scene.instances": [Large("s = ts.Scene(); m = matrices()", "s.instances(ts.Sphere(), m)")],
    "Scene.render": [Large("s = ground(1700)", "s.render(size=(8, 8), spp=1, workers=0)"),
                     Large("s = ground(10)", "s.render(size=(1280, 720), spp=2, denoise=True, workers=0)")],
    "Scene.save": [Large("s = spheres(150_000)", "s.save(folder + '/x.tessera')")],
    "Scene.to_dict": [Large("s = spheres()", "s.to_dict()")],
    "Scene.tracer": [Large("s = ground()", "s.tracer()"), Large("s = ground(700)", "s.tracer(accel='octree')")],
    "Tracer.__reduce_ex__": [
        Large("t = ground(2000).tracer()", "pickle.dumps(t, protocol=5, buffer_callback=[].append)")],
    "Tracer.camera_rays": [Large("t = ts.Scene(nodes=[ts.Sphere()]).tracer()", "t.camera_rays((8000, 4000))")],
    "Tracer.contains": [Large("t = ts.Sphere().tracer(); p = random.normal(size=(6_000_000, 3))", "t.contains(p)"),
                        Large("t = ground(300).tracer(); p = random.normal(size=(10**6, 3))",
                              "t.contains(p, method='winding')"),
                        Large("s = ground()", "s.tracer().contains((0, 0, 0))")],
    "Tracer.crossings": [Large(_TRACER, "t.crossings(o, d)")],
    "Tracer.intersect": [Large(_TRACER, "t.intersect(o, d)")],
    "Tracer.intersect_all": [Large(_TRACER, "t.intersect_all(o, d)")],
    "Tracer.occluded": [Large(_TRACER, "t.occluded(o, d)")],
    "Tracer.spawn": [Large(_HITS, "t.spawn(h, (0, 1, 0))")],
    "Located.point": [Large(_HITS, "h[:].point")],
    "Value.__eq__": [Large("s = spheres(150_000); t = pickle.loads(pickle.dumps(s))", "s == t"),
                     Large("p, r = grid(2500); s = ts.Mesh(p, r)", "ts.Mesh(p, r) == s")],
    "Value.__reduce__": [Large("s = ground(600)", "pickle.dumps(s)"),
                         Large("s = pickle.dumps(ground(3500))", "pickle.loads(s)")],
    "compare": [Large("i, j = picture(2500), picture(2500)", "ts.compare(i, j)")],
    "load": [Large("spheres().save(folder + '/x.tessera')", "ts.load(folder + '/x.tessera')"),
             Large("ground(2500).save(folder + '/x.tesserab')", "ts.load(folder + '/x.tesserab')")],
    "load_dict": [Large("d = spheres(100_000).to_dict()", "ts.load_dict(d)")],
    "read_image": [Large("picture(5000).save(folder + '/x.png')", "ts.read_image(folder + '/x.png')"),
                   Large("picture(3000).save(folder + '/x.exr')", "ts.read_image(folder + '/x.exr')")],
}

#: Calls that are in no script of LARGE, by the reason.
SMALL = {
    "Reads or sets what is there.": """
        AllHits.__len__ AllHits.__repr__ AllHits.counts Array.__copy__ Array.__deepcopy__ Array.__getitem__
        Array.__len__ Array.__repr__ Array.format Array.shape BaseFarm.__enter__ BaseFarm.__reduce__
        BaseFarm.closed Camera.pose Color.__repr__ Farm.__repr__ Hits.__bool__ Hits.__len__ Hits.__repr__
        Hits._repr_html_ Hits.shape Image.__copy__ Image.__deepcopy__ Image.__repr__ Image.alpha Image.aovs
        Image.height
        Image.holes Image.linear Image.shape Image.size Image.stats Image.width Instances.__len__
        Instances.transforms Job.__eq__ Job.__hash__ Job.__reduce__ Job.__repr__ Job.farm LocalFarm.__repr__
        Located.__copy__ Located.__deepcopy__ Located.instance Located.name Located.primitive Located.t
        Located.uv Mesh.material Metrics.__repr__ Progress.__repr__ Rect.__repr__ Scene.camera Shape.material
        Summary.__repr__ Task.__enter__ Task.__reduce__ Task.__repr__ Task.cancel Task.done Task.progress
        Threads.__repr__ Tracer.__repr__ Tracer.bounds Tracer.instances Tracer.materials Tracer.statistics
        Transform.array Value.__copy__ Value.__repr__ Vec.__eq__ Vec.__getitem__ Vec.__hash__ Vec.__iter__
        Vec.__len__ Vec.__matmul__ Vec.__ne__ Vec.__reduce__ Vec.__repr__ Vec.length Vec.x Vec.y Vec.z program""",
    "Works on few numbers, or leaves arrays to numpy.": """
        Box.from_corners Camera.from_intrinsics Camera.look_at Camera.screen Classic.toolbox Color.__add__
        Color.__mul__ Color.__neg__ Color.__radd__ Color.__rmul__ Color.__rsub__ Color.__sub__ Color.__truediv__
        Lens.__init__ Plane.through Rectangle.from_corners Transform.inverse Vec.__add__ Vec.__floordiv__
        Vec.__ge__ Vec.__gt__ Vec.__init__ Vec.__le__ Vec.__lt__ Vec.__mod__ Vec.__mul__ Vec.__neg__ Vec.__pow__
        Vec.__radd__ Vec.__rfloordiv__ Vec.__rmatmul__ Vec.__rmod__ Vec.__rmul__ Vec.__rpow__ Vec.__rsub__
        Vec.__rtruediv__ Vec.__sub__ Vec.__truediv__ Vec.cross Vec.dot Vec.normalized Triangle color hsl keys
        look_at matrix reflect rotate scale solve_quadratic translate""",
    "Works on the parts of a scene in Python, which lets go of the lock and hears Ctrl-C between any two.": """
        Placed.__and__ Placed.__or__ Placed.__sub__ Placed.copy Placed.flip Placed.mirror Placed.reflect
        Placed.shift Scene.__init__ Scene.add""",
    "Is what a call of LARGE does.": """
        Image.__hash__ Located.material Located.normal Located.point_error Located.shading_normal
        Located.texcoord Mesh.from_ MeshIntersector.__init__ MeshIntersector.contains_points
        MeshIntersector.intersects_id MeshIntersector.intersects_location Placed.contains Placed.intersect
        Placed.tracer Scene._repr_html_ Scene.frames Task.result Task.show render""",
    "Waits for tiles without the lock; test_interrupt.py and test_tasks.py end the wait.": """
        Task.__aiter__ Task.__await__ Task.__exit__ Task.__iter__ Task.snapshot""",
    "Starts or ends threads, processes and connections without the lock; see test_farm.py.": """
        BaseFarm.__exit__ BaseFarm.close Farm.__init__ Farm.close LocalFarm.__init__ Threads.__init__""",
    "Asks a coordinator without the lock, and heeds Ctrl-C; see test_farm.py.": """
        Farm.job Farm.jobs Farm.submit Farm.workers Job._repr_html_ Job.cancel Job.fetch Job.forget Job.frames
        Job.pause Job.resume Job.retry Job.snapshot Job.status Job.wait Job.watch""",
    "Applies a matrix by numpy, which lets go of the lock.": "Transform.__matmul__",
}
