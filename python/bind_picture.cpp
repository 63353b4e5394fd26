#include <fmt/format.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/all_failures.h"
#include "base/cancellation.h"
#include "base/core_count.h"
#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "front/rendered_picture.h"
#include "image/image_file.h"
#include "metrics/difference.h"
#include "metrics/picture_error.h"
#include "metrics/ssim.h"
#include "python/array.h"
#include "python/array_source.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "renderer/film/auto_exposure.h"
#include "renderer/math/encodings.h"

namespace py = pybind11;

namespace tessera {
namespace {

using PicturePointer = std::shared_ptr<RenderedPicture>;
using StopFlag = const std::atomic<bool>&;
using OptionValues = std::vector<std::pair<std::string, OptionValue>>;

/// The settings of `--exposure`, `--tone-map` and the like laid over what the scene asks.
OutputSettings settings_of(const RenderedPicture& picture, const OptionValues& values) {
  OutputOptions options;
  OptionList list;
  add_output_options(list, options);
  for (const auto& [name, value] : values) assign_option(list, name, value);
  return shown_settings("scene", picture, options);
}

constexpr size_t kPixelsBetweenLooks = size_t{1} << 20;

/// Channels [first, first + count) of every pixel, in an array of their own.
template <typename Value>
std::vector<Value> gather(const Film& film, int first, int count) {
  const auto channels = static_cast<size_t>(film.channels());
  const auto kept = static_cast<size_t>(count);
  const size_t pixels = film.values().size() / channels;
  std::vector<Value> out(pixels * kept);
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    if (pixel % kPixelsBetweenLooks == 0) Cancellation::check();
    const float* from = &film.values()[pixel * channels + static_cast<size_t>(first)];
    for (size_t i = 0; i < kept; ++i) out[pixel * kept + i] = static_cast<Value>(from[i]);
  }
  return out;
}

Array to_srgb(const PicturePointer& picture, const OptionValues& values) {
  const OutputSettings settings = settings_of(*picture, values);
  std::vector<uint8_t> bytes = run_abandonably([picture, settings](StopFlag) {
    if (settings.color_management) check_color_management(*settings.color_management);
    return picture->film.aovs().empty() ? shown_bytes(picture->film, settings)
                                        : shown_bytes(picture->film.with_only({}), settings);
  });
  return Array(std::move(bytes), {picture->film.height(), picture->film.width(), kFilmChannels});
}

std::string encoded(const PicturePointer& picture, const std::string& path,
                    const OutputSettings& settings) {
  return run_abandonably([picture, path, settings](StopFlag) {
    return encode_image(path, picture->film, settings, picture->metadata);
  });
}

/// The bytes of a file that `path` would name.
py::bytes encode(const PicturePointer& picture, const std::string& path,
                 const OptionValues& values) {
  return py::bytes(encoded(picture, path, settings_of(*picture, values)));
}

/// Writes all files that can be written, and then tells which cannot. Writing is waited for: after
/// Ctrl-C no file is to appear.
void save(const PicturePointer& picture, const std::vector<std::string>& paths,
          const OptionValues& values) {
  const OutputSettings settings = settings_of(*picture, values);
  if (settings.color_management) {
    const ColorManagement names = *settings.color_management;
    run_abandonably([names](StopFlag) { check_color_management(names); });
  }
  AllFailures failures;
  for (const std::string& path : paths) {
    failures.attempt([&] {
      const std::string bytes = encoded(picture, path, settings);
      run_interruptibly([&](StopFlag) { write_output_file(path, bytes); });
    });
  }
  failures.throw_if_any();
}

/// The linear light of one code after the other, where those of files with 8 or 16 bits a value,
/// in single or double precision, are worked out once each.
class LightOfCodes {
 public:
  float operator()(double code) {
    const double nearest = std::nearbyint(code * kMost);
    if (!(nearest >= 0 && nearest <= kMost)) return light_of(code);
    const double exact = nearest / kMost;
    const bool is_single = code != exact && code == static_cast<double>(static_cast<float>(exact));
    if (code != exact && !is_single) return light_of(code);
    float& known = known_[2 * static_cast<size_t>(nearest) + (is_single ? 1 : 0)];
    if (known < 0) known = light_of(code);
    return known;
  }

 private:
  static constexpr double kMost = 65535;  ///< codes of 8 bits are among those of 16
  static float light_of(double code) { return static_cast<float>(srgb_to_linear(code)); }

  std::vector<float> known_ = std::vector<float>(2 * 65536, -1.0f);
};

/// The linear light of codes in sRGB from 0 to 1, as the command line has it.
Array linear_of_srgb(const py::handle& given) {
  const ArraySource codes = array_source(given, "array");
  // Integers are a share of the largest that their type has.
  const double most =
      codes.kind == 'u' ? std::exp2(8 * static_cast<double>(codes.item_size)) - 1 : 1;
  // In single precision, as files are read: a picture that is saved and read again is the same.
  const auto share = [most](double code) {
    return most == 1 ? code : double{static_cast<float>(code / most)};
  };
  std::vector<float> light = run_abandonably([codes, share](StopFlag) {
    std::vector<float> made;
    made.reserve(static_cast<size_t>(codes.count()));
    LightOfCodes light_of;
    constexpr py::ssize_t kBetweenLooks = 1 << 20;
    for (py::ssize_t at = 0; at < codes.count(); at += kBetweenLooks) {
      Cancellation::check();
      for_each_element<double>(codes, at, std::min(kBetweenLooks, codes.count() - at),
                               [&](double code) { made.push_back(light_of(share(code))); });
    }
    return made;
  });
  return {std::move(light), codes.shape};
}

size_t picture_bytes(int width, int height) {
  return film_bytes(PixelRect{0, 0, width, height}, {});
}

/// A picture of light alone, from (h, w, 3) float32 values in a row.
PicturePointer picture_of_light(int width, int height, const void* light) {
  RenderedPicture picture{.film = Film(PixelRect{0, 0, width, height}), .output = {}};
  std::memcpy(picture.film.values().data(), light, picture_bytes(width, height));
  picture.metadata.frame_width = width;
  picture.metadata.frame_height = height;
  return std::make_shared<RenderedPicture>(std::move(picture));
}

/// float32 in a row, three for each of so many pixels.
ArraySource light_source(const py::handle& values, int64_t pixels) {
  ArraySource light = array_source(values, "values");
  if (!light.is_plain(kElementOf<float>) || light.count() != pixels * kFilmChannels) {
    throw usage_error("values: not as many float32 as the picture has");
  }
  return light;
}

/// The picture of such values in an array.
PicturePointer from_values(int width, int height, const py::handle& values) {
  const ArraySource light = light_source(values, int64_t{width} * height);
  return run_unlocked(picture_bytes(width, height), [light, width, height](StopFlag) {
    return picture_of_light(width, height, light.data);
  });
}

/// The picture with other light, (h, w, 3) float32 values in a row: all else stays.
PicturePointer with_light(const PicturePointer& picture, const py::handle& values) {
  const ArraySource light = light_source(values, picture->film.rect().area());
  return run_unlocked(picture->film.values().size_bytes(), [picture, light](StopFlag) {
    Film film = picture->film.with_only(picture->film.aovs());
    const auto channels = static_cast<size_t>(film.channels());
    const size_t pixels = film.values().size() / channels;
    const auto* from = reinterpret_cast<const float*>(light.data);
    for (size_t pixel = 0; pixel < pixels; ++pixel) {
      std::copy_n(from + pixel * kFilmChannels, kFilmChannels, &film.values()[pixel * channels]);
    }
    return std::make_shared<RenderedPicture>(RenderedPicture{.film = std::move(film),
                                                             .output = picture->output,
                                                             .metadata = picture->metadata,
                                                             .report = picture->report,
                                                             .statistics = picture->statistics});
  });
}

/// Whether both have the same bits, in light and beside it.
bool have_same_bits(const PicturePointer& a, const PicturePointer& b) {
  if (a->film.width() != b->film.width() || a->film.height() != b->film.height() ||
      a->film.aovs().bits() != b->film.aovs().bits())
    return false;
  const size_t bytes = a->film.values().size_bytes();
  return run_unlocked(bytes, [a, b, bytes](StopFlag) {
    return std::memcmp(a->film.values().data(), b->film.values().data(), bytes) == 0;
  });
}

std::vector<std::string> names_of(AovSet aovs) {
  std::vector<std::string> names;
  for (size_t i = 0; i < aov_names().size(); ++i) {
    if (aovs.has(static_cast<Aov>(i))) names.push_back(aov_names()[i]);
  }
  return names;
}

/// (the names of channels, all values, whether the file holds floats).
py::tuple read_file(const std::string& path) {
  FloatImage image = run_abandonably([path](StopFlag) { return read_image(path); });
  const auto channels = static_cast<py::ssize_t>(image.channels.size());
  return py::make_tuple(image.channels,
                        Array(std::move(image.values), {image.height, image.width, channels}),
                        !image.meaning.from_integers);
}

/// The picture in a file: red, green and blue as linear light; and a warning, or "".
std::pair<PicturePointer, std::string> picture_from_file(const std::string& path) {
  return run_abandonably([path](StopFlag) {
    const FloatImage image = read_image(path);
    return std::pair(picture_of_light(image.width, image.height, linear_light(image).data()),
                     image.part_note);
  });
}

/// How far the light of one picture is from that of another of the same size, the reference.
struct Comparison {
  Difference difference;
  PictureError error;
  double ssim = 0;
};

/// The fields of `tessera.Metrics` by their names.
py::dict compare(const PicturePointer& first, const PicturePointer& second) {
  const auto [difference, error, ssim] = run_abandonably([first, second](StopFlag) {
    std::array<std::vector<float>, 2> light;
    const std::array films{&first->film, &second->film};
    for_each_parallel(2, core_count(), [&](size_t i) {
      if (films[i]->channels() > kFilmChannels) {
        light[i] = gather<float>(*films[i], 0, kFilmChannels);
      }
    });
    const auto light_of = [&](size_t i) -> PictureView {
      const Film& film = *films[i];
      const bool is_light_alone = film.channels() == kFilmChannels;
      return {film.width(), film.height(),
              is_light_alone ? film.values() : std::span<const float>(light[i])};
    };
    const PictureView a = light_of(0), b = light_of(1);
    return Comparison{difference_of(a.values, b.values, kFilmChannels, size_t(a.width)),
                      picture_error(a, b), mean_ssim(a, b)};
  });
  const auto width = static_cast<size_t>(first->film.width());
  using namespace py::literals;
  return py::dict(
      "max"_a = difference.greatest, "mean"_a = difference.mean, "rmse"_a = difference.rmse,
      "rel_mse"_a = error.rel_mse, "flip"_a = error.flip, "ssim"_a = ssim,
      "trimmed_rel_mse"_a = error.trimmed_rel_mse, "smape"_a = error.smape,
      "error_99_9"_a = error.error_99_9, "mean_ratio"_a = error.mean_ratio,
      "not_finite"_a = error.not_finite, "max_of"_a = py::tuple(py::cast(difference.greatest_of)),
      "differing"_a = difference.pixels_unequal,
      "where"_a = py::make_tuple(difference.x0, difference.y0, difference.x1, difference.y1),
      "worst"_a = py::make_tuple(difference.worst_pixel % width, difference.worst_pixel / width));
}

/// A view of all values, (h, w, channels); the first three channels are light.
Array values_of(const PicturePointer& picture) {
  const Film& film = picture->film;
  return Array(picture, film.values().data(), kElementOf<float>,
               {film.height(), film.width(), film.channels()});
}

/// Where an AOV's channels are among those of a pixel.
struct ChannelsOfAov {
  int first, count;
  bool is_whole;  ///< its numbers are whole
};

ChannelsOfAov find_channels(const Film& film, const std::string& name) {
  const std::vector<std::string>& names = aov_names();
  const auto found = std::find(names.begin(), names.end(), name);
  const bool is_known = found != names.end() || name == "alpha";
  const Aov aov = name == "alpha" ? Aov::alpha : static_cast<Aov>(found - names.begin());
  if (!is_known || !film.aovs().has(aov)) {
    const std::vector<std::string> held = names_of(film.aovs());
    if (held.empty()) {
      throw usage_error(
          fmt::format("aov: '{}'; expected none: this picture has no AOVs, which "
                      "render(aovs=[...]) asks for and read_image() leaves out",
                      name));
    }
    throw usage_error(fmt::format("aov: '{}'; expected one of those that were rendered: {}{}", name,
                                  fmt::join(held, ", "), suggestion(name, held)));
  }
  return {film.aovs().first_channel(aov), AovSet().with(aov).channels() - kFilmChannels,
          aov == Aov::id || aov == Aov::primitive || aov == Aov::origin};
}

/// So many channels from one on, copied: (h, w, count), or (h, w) of one.
template <typename Value>
Array copy_of_channels(const PicturePointer& picture, int first, int count) {
  Array::Shape shape = {picture->film.height(), picture->film.width()};
  if (count > 1) shape.push_back(count);
  return Array(run_abandonably([picture, first, count](StopFlag) {
                 return gather<Value>(picture->film, first, count);
               }),
               shape);
}

Array copy_of_aov(const PicturePointer& picture, const std::string& name) {
  const auto [first, count, is_whole] = find_channels(picture->film, name);
  return is_whole ? copy_of_channels<uint32_t>(picture, first, count)
                  : copy_of_channels<float>(picture, first, count);
}

}  // namespace

void bind_picture(py::module_& module) {
  bind_class<RenderedPicture, PicturePointer>(module, "Picture")
      .def_property_readonly("width", [](const RenderedPicture& p) { return p.film.width(); })
      .def_property_readonly("height", [](const RenderedPicture& p) { return p.film.height(); })
      .def_property_readonly("aovs",
                             [](const RenderedPicture& p) { return names_of(p.film.aovs()); })
      .def_property_readonly("has_alpha",
                             [](const RenderedPicture& p) { return p.film.aovs().has(Aov::alpha); })
      .def_property_readonly("statistics", [](const RenderedPicture& p) { return p.statistics; })
      .def_property_readonly("holes",
                             [](const RenderedPicture& p) {
                               py::list out;
                               for (const PixelRect& r : p.report.holes) {
                                 out.append(py::make_tuple(r.x0, r.y0, r.x1, r.y1));
                               }
                               return out;
                             })
      .def("sha256",
           [](const PicturePointer& picture) {
             return run_abandonably([picture](StopFlag) { return picture->film.pixels_sha256(); });
           })
      .def("equals", &have_same_bits)
      .def_property_readonly("values", &values_of)
      .def("light",
           [](const PicturePointer& picture) {
             return copy_of_channels<float>(picture, 0, kFilmChannels);
           })
      .def("channels", &copy_of_aov)
      .def("channels_of",
           [](const RenderedPicture& picture, const std::string& name) {
             const auto [first, count, is_whole] = find_channels(picture.film, name);
             return py::make_tuple(first, count, is_whole);
           })
      .def("with_light", &with_light)
      .def("auto_exposure",
           [](const PicturePointer& picture) {
             return run_abandonably([picture](StopFlag) { return auto_exposure(picture->film); });
           })
      .def("to_srgb", &to_srgb)
      .def("encode", &encode)
      .def("save", &save);
  module.def("linear_of_srgb", &linear_of_srgb);
  module.def("picture_from_values", &from_values);
  module.def("read_picture", &read_file);
  module.def("picture_from_file", &picture_from_file);
  module.def("holds_floats", [](const std::string& path) { return holds_floats(path); });
  module.def("holds_aovs", [](const std::string& path) { return holds_aovs(path); });
  module.def("compare", &compare);
}

}  // namespace tessera
