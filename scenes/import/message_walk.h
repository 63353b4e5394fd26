#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <string>
#include <vector>

namespace tessera {

/// Calls enter(message) for `message` and every message inside it, the outer ones first, and
/// use(field, text) for each text that they hold. Maps are left out.
template <typename Enter, typename Use>
void walk_message(const google::protobuf::Message& message, const Enter& enter, const Use& use) {
  using Field = google::protobuf::FieldDescriptor;
  enter(message);
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  std::vector<const Field*> fields;
  reflection.ListFields(message, &fields);
  for (const Field* field : fields) {
    if (field->is_map()) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == Field::CPPTYPE_MESSAGE)
        walk_message(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                          : reflection.GetMessage(message, field),
                     enter, use);
      else if (field->cpp_type() == Field::CPPTYPE_STRING)
        use(*field, field->is_repeated() ? reflection.GetRepeatedString(message, field, i)
                                         : reflection.GetString(message, field));
    }
  }
}

}  // namespace tessera
