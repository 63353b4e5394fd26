#include "job/scene_motion.h"

#include "proto/wire/scene_walk.h"

namespace tessera {

bool moves(const v1::Scene& scene) {
  static const MessageFinder keys(v1::TransformKey::descriptor());
  return keys.any(scene, [](const google::protobuf::Message&) { return true; });
}

v1::FrameSettings settled(const v1::FrameSettings& frame, bool scene_moves) {
  v1::FrameSettings result = frame;
  if (!scene_moves) result.clear_time();
  return result;
}

}  // namespace tessera
