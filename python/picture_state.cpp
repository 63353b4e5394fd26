// Pictures as tuples of what Python can pickle, and back.
#include <pybind11/stl.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "front/rendered_picture.h"
#include "proto/wire/scene_codec.h"
#include "python/array.h"
#include "python/bindings.h"
#include "python/interruptible.h"

namespace py = pybind11;

namespace tessera {
namespace {

using Corners = std::tuple<int, int, int, int>;
using Metadata = std::tuple<std::string, uint32_t, uint32_t, std::string, std::string, int, int>;
/// All values as (h, w, channels); the first column and row of the frame that they are of, and the
/// bits of what is beside light; a scene with what is asked of its numbers; what files tell of it;
/// holes; statistics.
using State =
    std::tuple<Array, int, int, uint32_t, py::bytes, Metadata, std::vector<Corners>, std::string>;

State state_of(const std::shared_ptr<RenderedPicture>& picture) {
  const Film& film = picture->film;
  const ImageMetadata& told = picture->metadata;
  v1::Scene asked;
  *asked.mutable_settings()->mutable_output() = picture->output;
  std::vector<Corners> holes;
  for (const PixelRect& r : picture->report.holes) holes.emplace_back(r.x0, r.y0, r.x1, r.y1);
  return {Array(picture, film.values().data(), kElementOf<float>,
                {film.height(), film.width(), film.channels()}),
          film.rect().x0,
          film.rect().y0,
          film.aovs().bits(),
          serialize_scene(asked),
          {told.scene_digest, told.seed, told.samples_per_pixel, told.denoiser, told.colors,
           told.frame_width, told.frame_height},
          holes,
          picture->statistics};
}

std::shared_ptr<RenderedPicture> picture_of(const State& state) {
  const auto& [values, x0, y0, aovs, settings, told, holes, statistics] = state;
  const Array::Shape& shape = values.shape();
  const auto is_span = [](int from, py::ssize_t length) {
    return from >= 0 && 0 < length && length <= std::numeric_limits<int>::max() - from;
  };
  const std::optional<v1::Scene> asked = parse_scene(std::string(settings));
  if (shape.size() != 3 || !is_span(y0, shape[0]) || !is_span(x0, shape[1]) || !asked ||
      !AovSet::knows(aovs) || shape[2] != AovSet(aovs).channels() || values.type().code != 'f') {
    throw usage_error("state: of no picture; expected one of this version of Tessera");
  }
  const PixelRect rect{x0, y0, x0 + static_cast<int>(shape[1]), y0 + static_cast<int>(shape[0])};
  const auto picture = run_unlocked(
      values.bytes().size(), [values = values, rect, aovs = aovs,
                              output = asked->settings().output()](const std::atomic<bool>&) {
        auto made = std::make_shared<RenderedPicture>(
            RenderedPicture{.film = Film(rect, AovSet(aovs)), .output = output});
        std::memcpy(made->film.values().data(), values.data(), values.bytes().size());
        return made;
      });
  ImageMetadata& metadata = picture->metadata;
  std::tie(metadata.scene_digest, metadata.seed, metadata.samples_per_pixel, metadata.denoiser,
           metadata.colors, metadata.frame_width, metadata.frame_height) = told;
  for (const auto& [left, top, right, bottom] : holes) {
    picture->report.holes.push_back({left, top, right, bottom});
  }
  picture->statistics = statistics;
  return picture;
}

}  // namespace

void bind_picture_state(py::module_& module) {
  module.def("picture_state", &state_of, py::arg().none(false), "What a picture is made of.");
  module.def("picture_of_state", &picture_of, "The picture that is made of that.");
}

}  // namespace tessera
