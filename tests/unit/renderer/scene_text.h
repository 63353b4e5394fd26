#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <string>

#include "renderer/render/tile_renderer.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// A scene from its text form.
inline v1::Scene parse_scene(const std::string& text) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
  return scene;
}

/// A frame of `scene` whose other settings are the scene's.
inline v1::FrameSettings frame_of(int width, int height) {
  v1::FrameSettings frame;
  frame.set_width(static_cast<uint32_t>(width));
  frame.set_height(static_cast<uint32_t>(height));
  frame.set_accelerator("linear");
  return frame;
}

inline TilePixels render_rect(const TileRenderer& renderer, const PixelRect& rect,
                              uint32_t samples = 1, uint32_t first = 0) {
  TileProgress progress;
  auto tile = renderer.render({rect, first, samples}, progress);
  EXPECT_TRUE(tile.has_value());
  return tile ? std::move(*tile) : TilePixels{};
}

/// A scene of which tracing asks everything at every hit, as if it had every feature.
inline std::shared_ptr<const Scene> with_every_feature(const std::shared_ptr<const Scene>& scene) {
  // Nobody else has it, and it was not made const.
  std::const_pointer_cast<Scene>(scene)->features = {
      .shadows = true, .rich = true, .alpha = scene->features.alpha};
  return scene;
}

/// The whole frame.
inline TilePixels render_text(const std::string& text, int width, int height,
                              const BlobStore& blobs = {}) {
  const auto frame = frame_of(width, height);
  const v1::Scene scene = parse_scene(text);
  const auto renderer = make_tile_renderer(scene, blobs, frame, 1);
  const uint32_t samples = scene.settings().sampling().has_samples_per_pixel()
                               ? scene.settings().sampling().samples_per_pixel()
                               : 1;
  return render_rect(*renderer, {0, 0, width, height}, samples);
}

/// The one pixel of a frame of 1 x 1, red, green and blue.
inline std::vector<float> render_pixel(const std::string& text) {
  return render_text(text, 1, 1).values;
}

}  // namespace tessera
