#include "job/scene_motion.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <vector>

namespace tessera {
namespace {

namespace pb = google::protobuf;

bool has_keys(const pb::Message& message) {
  if (message.GetDescriptor() == v1::TransformKey::descriptor()) return true;
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const pb::Message& inside = field->is_repeated()
                                      ? reflection.GetRepeatedMessage(message, field, i)
                                      : reflection.GetMessage(message, field);
      if (has_keys(inside)) return true;
    }
  }
  return false;
}

}  // namespace

bool moves(const v1::Scene& scene) { return has_keys(scene); }

v1::FrameSettings settled(const v1::FrameSettings& frame, bool scene_moves) {
  v1::FrameSettings result = frame;
  if (!scene_moves) result.clear_time();
  return result;
}

}  // namespace tessera
