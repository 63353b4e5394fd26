#include <pybind11/stl.h>

#include <string>
#include <utility>

#include "base/error.h"
#include "front/texture_decoder.h"
#include "python/array.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/mesh_arrays.h"
#include "renderer/math/encodings.h"
#include "scenes/import/mip_levels.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// The picture in a file: (h, w, c) uint8, half or float, as the file has them.
Array read_texture(const std::string& path) {
  const DecodedTexture decoded =
      run_abandonably([path](const std::atomic<bool>&) { return decode_texture(path, false); });
  return Array(decoded.texels, decoded.texels->data(), texel_type(decoded.bits),
               {decoded.height, decoded.width, decoded.channels});
}

/// The texels (h, w) or (h, w, c) followed by all smaller levels, in a row, and how many there are.
std::pair<Array, uint32_t> with_mip_levels(const Array& texels, bool is_srgb) {
  const Array::Shape& shape = texels.shape();
  const auto side = [&](size_t axis) { return static_cast<uint32_t>(shape[axis]); };
  DecodedTexture texture{.width = side(1),
                         .height = side(0),
                         .channels = shape.size() == 3 ? side(2) : 1,
                         .bits = static_cast<uint32_t>(8 * texels.type().size),
                         .texels = nullptr};
  texture.texels = copy_to_blob(texels.bytes());
  const auto [all, levels] = run_abandonably([texture, is_srgb](const std::atomic<bool>&) {
    DecodedTexture made = texture;
    const uint32_t count = add_mip_levels(made, is_srgb);
    return std::pair(made.texels, count);
  });
  const auto size = static_cast<py::ssize_t>(all->size()) / texels.type().size;
  return {Array(all, all->data(), texels.type(), {size}), levels};
}

}  // namespace

void bind_textures(py::module_& module) {
  module.def("read_texture", &read_texture, "The picture in a file as an array.");
  module.def("srgb_to_linear", &srgb_to_linear, "A channel of sRGB from 0 to 1 as linear light.");
  module.def("with_mip_levels", &with_mip_levels, "Texels with all smaller levels behind them.");
}

}  // namespace tessera
