#include <fmt/format.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "bench/error/difference.h"
#include "bench/error/metrics.h"
#include "bench/error/ssim.h"
#include "front/all_failures.h"
#include "front/output_settings.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/picture.h"
#include "renderer/image/image_file.h"

namespace py = pybind11;

namespace tessera {
namespace {

using PicturePointer = std::shared_ptr<RenderedPicture>;
using OptionValues = std::vector<std::pair<std::string, OptionValue>>;

/// The settings of `--exposure`, `--tone-map` and the like laid over what the scene asks.
OutputSettings settings_of(const RenderedPicture& picture, const OptionValues& values) {
  OutputOptions options;
  OptionList list;
  add_output_options(list, options);
  for (const auto& [name, value] : values) assign_option(list, name, value);
  return output_settings("scene", picture.output, options);
}

/// Channels [first, first + count) of every pixel, in an array of their own.
template <typename Value>
std::vector<Value> gather(const Film& film, int first, int count) {
  const auto channels = static_cast<size_t>(film.channels());
  const auto kept = static_cast<size_t>(count);
  const size_t pixels = film.values().size() / channels;
  std::vector<Value> out(pixels * kept);
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    const float* from = &film.values()[pixel * channels + static_cast<size_t>(first)];
    for (size_t i = 0; i < kept; ++i) out[pixel * kept + i] = static_cast<Value>(from[i]);
  }
  return out;
}

Array to_srgb(const PicturePointer& picture, const OptionValues& values) {
  const OutputSettings settings = settings_of(*picture, values);
  if (settings.color_management) {
    throw usage_error("--ocio-...: are for files; expected them at save()");
  }
  std::vector<uint8_t> bytes = picture->film.aovs().empty()
                                   ? to_8_bit(picture->film, settings)
                                   : to_8_bit(picture->film.with_only({}), settings);
  return Array(std::move(bytes), {picture->film.height(), picture->film.width(), kFilmChannels});
}

/// The bytes of a file that `path` would name.
py::bytes encode(const PicturePointer& picture, const std::string& path,
                 const OptionValues& values) {
  std::string bytes;
  {
    const GilRelease release;
    bytes = encode_image(path, picture->film, settings_of(*picture, values), picture->metadata);
  }
  return py::bytes(bytes);
}

/// Writes all files that can be written, and then tells which cannot.
void save(const PicturePointer& picture, const std::vector<std::string>& paths,
          const OptionValues& values) {
  const OutputSettings settings = settings_of(*picture, values);
  if (settings.color_management) check_color_management(*settings.color_management);
  AllFailures failures;
  for (const std::string& path : paths) {
    failures.attempt([&] {
      check_writable(path);
      write_image(path, picture->film, settings, picture->metadata);
    });
  }
  failures.throw_if_any();
}

/// A picture of light alone, from (h, w, 3) float32 values in a row.
PicturePointer from_values(int width, int height, const py::buffer& values) {
  const py::buffer_info info = values.request();
  Film film(PixelRect{0, 0, width, height});
  if (info.size * info.itemsize != static_cast<py::ssize_t>(film.values().size_bytes())) {
    throw usage_error("values: not as many as the picture has");
  }
  std::memcpy(film.values().data(), info.ptr, film.values().size_bytes());
  RenderedPicture picture{.film = std::move(film), .output = {}};
  picture.metadata.frame_width = width;
  picture.metadata.frame_height = height;
  return std::make_shared<RenderedPicture>(std::move(picture));
}

/// The picture with other light, (h, w, 3) float32 values in a row: all else stays.
PicturePointer with_light(const PicturePointer& picture, const py::buffer& values) {
  const py::buffer_info info = values.request();
  const auto* light = static_cast<const float*>(info.ptr);
  Film film = picture->film.with_only(picture->film.aovs());
  const auto channels = static_cast<size_t>(film.channels());
  const size_t pixels = film.values().size() / channels;
  if (info.itemsize != sizeof(float) ||
      info.size != static_cast<py::ssize_t>(pixels * kFilmChannels)) {
    throw usage_error("values: not as many as the picture has");
  }
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    std::copy_n(light + pixel * kFilmChannels, kFilmChannels, &film.values()[pixel * channels]);
  }
  return std::make_shared<RenderedPicture>(RenderedPicture{.film = std::move(film),
                                                           .output = picture->output,
                                                           .metadata = picture->metadata,
                                                           .report = picture->report,
                                                           .statistics = picture->statistics});
}

/// Whether both have the same bits, in light and beside it.
bool have_same_bits(const RenderedPicture& a, const RenderedPicture& b) {
  const auto first = std::as_bytes(a.film.values()), second = std::as_bytes(b.film.values());
  return a.film.width() == b.film.width() && a.film.height() == b.film.height() &&
         a.film.aovs().bits() == b.film.aovs().bits() && std::ranges::equal(first, second);
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
  FloatImage image;
  {
    const GilRelease release;
    image = read_image(path);
  }
  const auto channels = static_cast<py::ssize_t>(image.channels.size());
  return py::make_tuple(image.channels,
                        Array(std::move(image.values), {image.height, image.width, channels}),
                        image.is_float);
}

/// Light of the same size, (h, w, 3) float32 in a row each, the second as the reference: the fields
/// of `tessera.Metrics` by their names.
py::dict compare(const py::buffer& first, const py::buffer& second) {
  const auto taken = [](const py::buffer& buffer) {
    const py::buffer_info info = buffer.request();
    const auto* values = static_cast<const float*>(info.ptr);
    return Picture{static_cast<int>(info.shape.at(1)), static_cast<int>(info.shape.at(0)),
                   std::vector<float>(values, values + info.size)};
  };
  const Picture a = taken(first), b = taken(second);
  const auto width = static_cast<size_t>(a.width);
  Difference difference;
  PictureError error;
  double ssim = 0;
  {
    const GilRelease release;
    difference = difference_of(a.values, b.values, kFilmChannels, width);
    error = picture_error(a, b);
    ssim = mean_ssim(a, b);
  }
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

}  // namespace

Array channels_of(const PicturePointer& picture, const std::string& name) {
  const Film& film = picture->film;
  const py::ssize_t height = film.height(), width = film.width();
  if (name == "light") {
    if (film.aovs().empty()) {
      return Array(picture, film.values().data(), kElementOf<float>,
                   {height, width, kFilmChannels});
    }
    return Array(gather<float>(film, 0, kFilmChannels), {height, width, kFilmChannels});
  }
  const std::vector<std::string>& names = aov_names();
  const auto found = std::find(names.begin(), names.end(), name);
  const auto aov = static_cast<Aov>(found - names.begin());
  if (found == names.end() || !film.aovs().has(aov)) {
    const std::vector<std::string> held = names_of(film.aovs());
    if (held.empty()) {
      throw usage_error(
          fmt::format("aov: '{}'; expected none: this picture has no AOVs, which "
                      "render(aovs=[...]) asks for",
                      name));
    }
    throw usage_error(fmt::format("aov: '{}'; expected one of those that were rendered: {}{}", name,
                                  fmt::join(held, ", "), suggestion(name, held)));
  }
  const int first = film.aovs().first_channel(aov);
  const int count = AovSet().with(aov).channels() - kFilmChannels;
  if (aov == Aov::id) return Array(gather<uint32_t>(film, first, 1), {height, width});
  if (count == 1) return Array(gather<float>(film, first, 1), {height, width});
  return Array(gather<float>(film, first, count), {height, width, count});
}

void bind_picture(py::module_& module) {
  using Release = py::call_guard<GilRelease>;
  bind_class<RenderedPicture, PicturePointer>(module, "Picture")
      .def_property_readonly("width", [](const RenderedPicture& p) { return p.film.width(); })
      .def_property_readonly("height", [](const RenderedPicture& p) { return p.film.height(); })
      .def_property_readonly("aovs",
                             [](const RenderedPicture& p) { return names_of(p.film.aovs()); })
      .def_property_readonly("statistics", [](const RenderedPicture& p) { return p.statistics; })
      .def_property_readonly("holes",
                             [](const RenderedPicture& p) {
                               py::list out;
                               for (const PixelRect& r : p.report.holes) {
                                 out.append(py::make_tuple(r.x0, r.y0, r.x1, r.y1));
                               }
                               return out;
                             })
      .def(
          "sha256", [](const RenderedPicture& p) { return p.film.pixels_sha256(); }, Release())
      .def("equals", &have_same_bits, Release())
      .def("channels", &channels_of)
      .def("with_light", &with_light)
      .def("to_srgb", &to_srgb)
      .def("encode", &encode)
      .def("save", &save, Release());
  module.def("picture_from_values", &from_values);
  module.def("read_picture", &read_file);
  module.def("compare", &compare);
}

}  // namespace tessera
