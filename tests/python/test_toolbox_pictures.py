"""Pictures of the classic toolbox: its brightness, light functions, mirrors, grain and screen, against
a model of it in numpy.
"""
import math

import numpy as np
import pytest

import tessera as ts

SIZE = 60


class Model:
    """A picture of white spheres as the toolbox makes it: each a centre, a radius and (diffuse,
    ambient, highlight); point lights; an eye that looks at a centre through a screen.
    """

    def __init__(self, spheres, lights, eye, centre, width):
        self.centers = np.array([s[0] for s in spheres], float)
        self.radii = np.array([s[1] for s in spheres], float)
        self.materials = np.array([s[2] for s in spheres], float)
        self.lights = np.array(lights, float)
        self.eye, self.centre, self.width = np.array(eye, float), np.array(centre, float), width

    def screen(self):
        """Directions through the middles of the units of the screen, rows from the top."""
        view = (self.centre - self.eye) / 2
        right = np.cross(view, (0, 0, 1))
        right /= np.linalg.norm(right)
        up = np.cross(right, view)
        up /= np.linalg.norm(up)
        at = ((np.arange(SIZE) + .5) / SIZE - .5) * self.width
        return view + at[None, :, None] * right - at[:, None, None] * up

    def nearest(self, o, d, t_max=np.inf):
        """The least t in (1e-9, t_max) and the sphere that is there; -1: none."""
        v = o[..., None, :] - self.centers
        a, b = (d * d).sum(-1)[..., None], 2 * (v * d[..., None, :]).sum(-1)
        c = (v * v).sum(-1) - self.radii ** 2
        with np.errstate(invalid="ignore"):
            root = np.sqrt(b * b - 4 * a * c)
            t = np.stack([(-b - root) / (2 * a), (-b + root) / (2 * a)])
        t = np.where((t > 1e-9) & (t < t_max), t, np.inf).min(0)
        return t.min(-1), np.where(np.isfinite(t.min(-1)), t.argmin(-1), -1)

    def brightness(self, ambient):
        """The brightness from 0 to 1 and whether all lights are before the surface there."""
        d = self.screen()
        t, hit = self.nearest(np.broadcast_to(self.eye, d.shape), d)
        d, hit, seen = d[hit >= 0], hit[hit >= 0], hit >= 0
        p = self.eye + t[seen][:, None] * d
        n = (p - self.centers[hit]) / self.radii[hit][:, None]
        r = d - 2 * (d * n).sum(-1)[:, None] * n
        r /= np.linalg.norm(r, axis=-1)[:, None]
        diffuse, own_ambient, highlight = self.materials[hit].T
        sum_, front = ambient * own_ambient, np.ones(len(p), bool)
        for light in self.lights:
            to_light = light - p
            l = to_light / np.linalg.norm(to_light, axis=-1)[:, None]
            open_ = self.nearest(p + 1e-9 * n, to_light, 1)[1] < 0
            sum_ = sum_ + open_ * (diffuse * np.maximum(0, (n * l).sum(-1)) +
                                   highlight * np.maximum(0, (r * l).sum(-1)))
            front &= (n * l).sum(-1) > 1e-6
        out, known = np.zeros(seen.shape), np.zeros(seen.shape, bool)
        out[seen], known[seen] = np.clip(sum_, 0, 1), front
        return out, known


SPHERES = [((0, 0, 0), 1, (.5, .2, .3)), ((1.5, -.4, .6), .5, (.8, .1, .0)),
           ((-1, -1.2, -.3), .4, (.2, .5, .6))]
LIGHTS = [(3, -9, 5), (-2, -8, 6)]


def scene_of(model, **options):
    scene = ts.Scene(width=SIZE, height=SIZE, transfer="display", **options)
    scene.camera = ts.Camera.screen(model.eye, model.centre, model.width)
    for center, radius, (diffuse, ambient, highlight) in zip(model.centers, model.radii,
                                                             model.materials):
        scene.add(ts.Sphere(center, radius, material=ts.Classic.toolbox(
            diffuse=diffuse, ambient=ambient, highlight=highlight)))
    scene.add([ts.PointLight(position) for position in model.lights])
    return scene


@pytest.fixture(scope="module")
def model():
    return Model(SPHERES, LIGHTS, (.5, -9, 1), (.2, 0, .1), 1.8)


@pytest.mark.parametrize("response", [None, ts.LIGHT_1, ts.LIGHT_2])
def test_brightness(model, response):
    expected, known = model.brightness(ambient=.6)
    if response:
        a, b, c = response
        expected = np.clip(a * expected ** 2 + b * expected + c, 0, 1)
    picture = scene_of(model, ambient=(.6, .6, .6), response=response).render(workers=0).to_srgb()
    assert known.sum() > 400 and len(np.unique(picture[known])) > 80
    assert (picture[..., 0] == picture[..., 2]).all()
    off = np.abs(picture[..., 0] - 255 * expected)[known]
    assert off.max() <= 1


def test_light_functions(model):
    assert ts.LIGHT_1 == (-1.2, 2.2, 0) and ts.LIGHT_2 == (.476, .5239, 0)
    for response, end in ((ts.LIGHT_1, 1), (ts.LIGHT_2, .9999)):
        def f(x):
            x = np.clip(x, 0, 1)
            return response[0] * x * x + response[1] * x + response[2]
        assert (f(np.array([0., 1.])) == (0, pytest.approx(end, abs=1e-15))).all()
        ends = [ts.Scene(width=1, height=1, transfer="display", response=response, background=(x,) * 3)
                .render(workers=0).to_srgb()[0, 0, 0] for x in (0., 1., 3.)]
        assert ends == [0, 255, 255]
        given = scene_of(model, response=response).render(workers=0).to_srgb()
        applied = scene_of(model).render(workers=0).apply(f).to_srgb(transfer="display")
        assert np.abs(given.astype(int) - applied).max() <= 1 and given.any()


def test_materials():
    made = ts.Classic.toolbox(diffuse=.5, ambient=.25, highlight=.1, colour="red", roughness=.2)
    assert tuple(made.diffuse) == (.5, 0, 0) and tuple(made.ambient) == (.25, 0, 0)
    assert made.specular == (.1, .1, .1) and made.shininess == 1 and made.specular_model == "phong"
    assert made.grain == .2 and made.reflectivity is None and type(made) is ts.Classic
    mirror = ts.Classic.toolbox(mirror=True, name="mirror")
    assert mirror.reflectivity == (1, 1, 1) and not any(mirror.diffuse) and mirror.name == "mirror"
    with pytest.raises(TypeError, match="did you mean"):
        ts.Classic.toolbox(nam="x")


def test_colours():
    assert ts.color("red") == (1, 0, 0) and ts.color((.1, .2, .3)) == (.1, .2, .3)
    assert ts.color("#c33") == ts.color("#cc3333") == ts.color(" #CC3333")
    assert ts.color("#808080").r == pytest.approx(((128 / 255 + .055) / 1.055) ** 2.4, rel=1e-15)
    assert ts.hsl(120, 1, .5) == (0, 1, 0) and ts.hsl(0, 1, 1) == (1, 1, 1)
    assert ts.hsl(240, 1, .25).b == pytest.approx(((.5 + .055) / 1.055) ** 2.4, rel=1e-15)
    with pytest.raises(ValueError, match="'rad': no colour; .* did you mean 'red'"):
        ts.color("rad")


def test_the_background_glows_towards_lights():
    lights, solid, glow = np.array([(4, 3, 5), (-6, 2, 1)], float), .1, .4
    scene = ts.Scene(width=9, height=9, background=ts.Background(solid=(solid,) * 3, glow=glow))
    scene.camera = ts.Camera.screen((0, 0, 0), (0, 5, 1), 6)
    scene.add([ts.PointLight(position) for position in lights])
    _, directions = scene.tracer().camera_rays()
    towards = lights / np.linalg.norm(lights, axis=1)[:, None]
    expected = solid + glow * np.maximum(0, directions @ towards.T).sum(-1)
    assert scene.render(workers=0).linear[..., 0] == pytest.approx(expected, rel=1e-5)
    assert np.ptp(expected) > .2


def test_facing_mirrors_end():
    for depth in (3, 100):
        scene = ts.Scene(width=1, height=1, max_depth=depth, ambient=(1, 1, 1))
        scene.camera = ts.Camera.screen((0, 0, .5), (0, 1, .5), .001)
        for y in (-1, 1):
            scene.add(ts.Plane((0, 1, 0), y, material=ts.Classic.toolbox(ambient=.002, mirror=True)))
        image = scene.render(workers=0)
        # Each mirror adds its own ambient light; the last one mirrors nothing any more.
        assert image.linear[0, 0, 0] == pytest.approx(.002 * (depth + 1), rel=1e-5)


def test_grain_is_the_same_each_time():
    def picture(roughness):
        scene = ts.Scene(width=40, height=40, ambient=(1, 1, 1))
        scene.add(ts.Plane((0, 0, 1), material=ts.Classic.toolbox(ambient=.9, roughness=roughness)))
        return scene.render(workers=0).linear
    rough = picture(.5)
    assert (rough == picture(.5)).all()
    assert rough.min() > .9 - .5 * .3 - 1e-6 and rough.max() <= np.float32(.9)
    assert rough.std() == pytest.approx(.15 / math.sqrt(12), rel=.1)
    assert (picture(0) == np.float32(.9)).all()


@pytest.mark.parametrize("eye, centre", [((-7, 3, 2), (1, 0, 0)), ((7, 3, 2), (1, 0, 0)),
                                         ((0, -9, 0), (0, 0, 0))])
def test_the_screen(eye, centre):
    """Upright for views along +x and along -x."""
    model = Model([((0, 0, 0), 1, (1, 1, 1))], [], eye, centre, 4)
    scene = ts.Scene(width=SIZE, height=SIZE)
    scene.camera = ts.Camera.screen(eye, centre, 4)
    origins, directions = scene.tracer().camera_rays()
    expected = model.screen()
    expected /= np.linalg.norm(expected, axis=-1)[..., None]
    assert np.abs(directions - expected).max() < 1e-12
    assert (origins == eye).all()
    assert (directions[0, :, 2] > directions[-1, :, 2]).all()


def test_the_screen_straight_up_and_down():
    for eye in ((0, 0, 5), (0, 0, -5)):
        scene = ts.Scene(width=3, height=3)
        scene.camera = ts.Camera.screen(eye, (0, 0, 0), 2)
        assert scene.tracer().camera_rays()[1][1, 1].tolist() == [0, 0, -eye[2] / 5]
