// Mirrors and glass without noise, by Whitted's integrator: to a millionth.
#include <string>

#include "tests/accuracy/support.h"

namespace tessera {
namespace {

/// The camera at the origin, turned about y by `degrees` from -z towards +x.
std::string looks(double degrees, const std::string& more = "") {
  return "cameras { world_from_camera { steps { rotate { axis { y: 1 } angle: " + number(-degrees) +
         " } } } } settings { sampling { pattern: CENTER } integrator { max_depth: 100 " + more +
         " } } ";
}

TEST(Optics, TheImagesOfACorridorOfMirrorsFadeByThePowersOfTheirShare) {
  const std::string corridor =
      "materials { name: 'mirror' classic { diffuse { value { } } reflectivity " + grey(0.9) +
      " } } materials { name: 'end' unlit { } } " +
      node("plane { normal { x: 1 } offset: -1 }", "mirror") +
      node("plane { normal { x: 1 } offset: 1 }", "mirror") +
      node("plane { normal { z: 1 } offset: -10 }", "end");
  for (int k = 0; k <= 30; ++k) {  // to the middle of the k-th image of the end
    const double truth = std::pow(0.9, k), degrees = std::atan(2 * k / 10.0) * 180 / kPi;
    EXPECT_NEAR(render_pixel(corridor + looks(degrees))[0], truth, 1e-6 * truth) << k;
  }
}

TEST(Optics, APrismDeviatesAsItsAngleSays) {
  // Of 60 degrees and n = 1.5, passed symmetrically: 2 asin(n sin(30 degrees)) - 60 degrees.
  const double n = 1.5, half = 30 * kPi / 180, incidence = std::asin(n * std::sin(half));
  const double deviation = 2 * incidence - 2 * half;
  EXPECT_NEAR(deviation * 180 / kPi, 37.1807, 1e-4);
  // Its apex is at (0, 1), so that the ray, which goes along x inside, passes faces at x = -+face.
  const double face = std::tan(half), cosine = std::cos(deviation / 2),
               sine = std::sin(deviation / 2);
  const std::string f = number(face), b = number(2 * face);
  const std::string prism =
      "materials { name: 'glass' classic { diffuse { value { } } transparency { value: 1 } "
      "refractive_index: 1.5 } } materials { name: 'glow' unlit { } } " +
      node(
          "mesh { inline_positions: [0,1,-5, -" + b + ",-1,-5, " + b + ",-1,-5, 0,1,5, -" + b +
              ",-1,5, " + b +
              ",-1,5] inline_triangles: [0,2,1, 3,4,5, 0,1,4, 0,4,3, 1,2,5, 1,5,4, 2,0,3, 2,3,5] }",
          "glass") +
      "cameras { world_from_camera { steps { look_at { eye { x: " + number(-face - 10 * cosine) +
      " y: " + number(-10 * sine) + " } target { x: -" + f + " } up { z: 1 } } } } } " +
      "settings { sampling { pattern: CENTER } integrator { max_depth: 3 } } ";
  const auto seen = [&](double up) {
    return render_pixel(
        prism + node("sphere { radius: .01 center { x: " + number(face + 30 * cosine + up * sine) +
                         " y: " + number(-30 * sine + up * cosine) + " } }",
                     "glow"))[0];
  };
  // Fresnel's share is the same at both faces.
  const double ci = std::cos(incidence), ct = std::cos(half);
  const double across = (ci - n * ct) / (ci + n * ct), along = (n * ci - ct) / (n * ci + ct);
  const double passed = 1 - (across * across + along * along) / 2;
  EXPECT_NEAR(seen(0), passed * passed, 1e-5);
  for (const double up : {-0.02, 0.02}) EXPECT_EQ(seen(up), 0) << up;  // .04 degrees off
}

TEST(Optics, SlabsReflectWhatTheyDoNotLetThroughOrAbsorb) {
  // All inner reflections; what is seen is a ball behind the camera.
  const auto slab = [](double absorption) {
    return render_pixel(
        "materials { name: 'glass' classic { diffuse { value { } } transparency { value: 1 } "
        "refractive_index: 1.5 absorption { r: " +
        number(absorption) + " } } } materials { name: 'glow' unlit { } } " +
        node("box { min { x: -9 y: -9 } max { x: 9 y: 9 z: .5 } }", "glass") +
        node("sphere { center { z: 13 } }", "glow") +
        "settings { sampling { pattern: CENTER } integrator { max_depth: 60 } } ")[0];
  };
  const double R = 0.04;
  for (const double absorption : {0.0, 1.0, 3.0}) {
    const double tau = std::exp(-absorption * 0.5), again = 1 - R * R * tau * tau;
    const double truth = R + R * tau * tau * (1 - R) * (1 - R) / again;
    EXPECT_NEAR(slab(absorption), truth, 1e-6 * truth) << absorption;
  }
}

// What fills the innermost solid that was entered and not left takes the light, wherever the camera
// is.
TEST(Optics, SolidsInsideOfEachOtherAbsorbEachByItself) {
  const auto seen = [](double eye, const std::string& more, const std::string& integrator) {
    return render_pixel(
        "materials { name: 'ink' dielectric { refractive_index: 1 absorption { r: .1 g: .5 b: 1 } "
        "} } "
        "materials { name: 'air' dielectric { refractive_index: 1 } } "
        "materials { name: 'wine' classic { diffuse { value { } } transparency { value: 1 } "
        "absorption { r: .2 } } } "
        "materials { name: 'hole' classic { } opacity { value: 0 } } "
        "materials { name: 'lamp' classic { diffuse { value { } } emission " +
        grey(1) + " } } cameras { world_from_camera { steps { translate { z: " + number(eye) +
        " } } } perspective { field_of_view: .02 } } settings { sampling { pattern: CENTER } "
        "integrator { kind: '" +
        integrator + "' } } " + node("sphere { radius: 5 }", "ink") +
        node("disc { center { z: -1 } radius: .3 }", "lamp") + more);
  };
  for (const std::string integrator : {"whitted", "path"}) {
    const auto expect = [&](double eye, const std::string& more, double ink, double wine) {
      const auto rgb = seen(eye, more, integrator);
      const double truth[] = {std::exp(-.1 * ink - .2 * wine), std::exp(-.5 * ink), std::exp(-ink)};
      for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(rgb[c], truth[c], 2e-6 * truth[c]) << integrator << eye << more << c;
    };
    const std::string bubble = node("sphere { radius: .5 }", "air");
    const std::string drop = node("sphere { radius: .75 }", "wine");
    for (const double outside : {0.0, 4.0}) {  // the camera stands in the ink, or beyond it
      const double eye = 3 + outside, way = outside > 0 ? 6 : 4;
      expect(eye, "", way, 0);
      expect(eye, bubble, way - 1, 0);
      // Beyond three surfaces paths are ended by lot, and the picture is one by chance.
      if (integrator == "whitted") expect(eye, drop + bubble, way - 1.5, .5);
      expect(eye, node("disc { center { z: 1 } radius: .5 }", "hole"), way, 0);
    }
    expect(.6, drop + bubble, .25, .35);  // in the drop
    expect(.1, drop + bubble, .25, .25);  // in the bubble
  }
}

}  // namespace
}  // namespace tessera
