#pragma once

#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// What no scene may hold.
struct SceneFault {
  std::string found, expected;
  std::string path;  ///< "cameras[0].lens.radius_x"
};

/// The first number in `scene` that is infinite or not a number, number of an enumeration that has
/// no such value, field that this version does not know, or message more than kMaxSceneDepth deep.
std::optional<SceneFault> find_fault(const v1::Scene& scene);

/// A type of messages as a walk through scenes needs it: asked of each message anew, these take
/// most of its time.
struct MessageType {
  struct Field {
    const google::protobuf::FieldDescriptor* field;
    const MessageType* inner;  ///< null of a value
  };
  const google::protobuf::Reflection* reflection = nullptr;
  std::vector<Field> fields{};  ///< those that the walk looks at
};

/// Finds the messages of one type in scenes: looks into those fields alone that may hold one, which
/// the constructor works out from scene.proto. Any number of threads may use it at once.
class MessageFinder {
 public:
  explicit MessageFinder(const google::protobuf::Descriptor* wanted);
  MessageFinder(const MessageFinder&) = delete;
  MessageFinder& operator=(const MessageFinder&) = delete;

  /// Calls visit(message) for each in `scene`, one before those that lie in it, until a call
  /// returns true. Whether one did. Throws WorkCancelled where this thread's work is.
  bool any(const v1::Scene& scene,
           const std::function<bool(const google::protobuf::Message&)>& visit) const;

 private:
  static bool any(const google::protobuf::Message& message, const MessageType& type,
                  const MessageType& wanted,
                  const std::function<bool(const google::protobuf::Message&)>& visit);

  const google::protobuf::Descriptor* wanted_;
  std::unordered_map<const google::protobuf::Descriptor*, MessageType> types_;
};

}  // namespace tessera
