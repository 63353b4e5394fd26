#include "scenes/edit/message_path.h"

#include <fmt/format.h>

#include <charconv>

#include "base/error.h"
#include "scenes/edit/message_outline.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;

struct Segment {
  std::string name;
  std::optional<size_t> index;
};

/// Takes the first segment off the path.
Segment take_segment(std::string_view& path) {
  const size_t dot = path.find('.');
  std::string_view first = path.substr(0, dot);
  path.remove_prefix(dot == std::string_view::npos ? path.size() : dot + 1);
  Segment made;
  const size_t bracket = first.find('[');
  if (bracket != std::string_view::npos) {
    size_t index = 0;
    const char* const end = first.data() + first.size();
    const auto [stop, error] = std::from_chars(first.data() + bracket + 1, end, index);
    if (error == std::errc() && stop + 1 == end && *stop == ']') made.index = index;
    if (made.index) first = first.substr(0, bracket);
  }
  made.name = first;
  return made;
}

Refusal no_field(const pb::Descriptor& type, const std::string& name) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  return {fmt::format("'{}' is no field of {}", name, type.name()),
          fmt::format("one of {}{}", field_list(type), suggestion(name, names)),
          {}};
}

}  // namespace

std::string field_list(const pb::Descriptor& type) {
  std::string names;
  for (int i = 0; i < type.field_count(); ++i) names += (i > 0 ? ", " : "") + type.field(i)->name();
  return names;
}

MessagePath find_field(const SyntaxTree& tree, int32_t node, std::string_view path) {
  MessagePath found{.node = node};
  const pb::Descriptor* type = tree[node].message;
  bool is_missing = false;
  while (true) {
    if (!type) {
      found.refusal = Refusal{"what has no fields", "a message", {}};
      return found;
    }
    const Segment segment = take_segment(path);
    const pb::FieldDescriptor* field = type->FindFieldByName(segment.name);
    if (!field) {
      found.refusal = no_field(*type, segment.name);
      return found;
    }
    const auto there = is_missing ? std::vector<int32_t>{} : occurrences(tree, found.node, field);
    int32_t next = -1;
    if (!field->is_repeated()) {
      if (!there.empty()) next = there.back();
    } else if (segment.index) {
      if (*segment.index < there.size()) next = there[*segment.index];
      if (*segment.index > there.size()) {
        found.refusal = Refusal{fmt::format("{}[{}]", segment.name, *segment.index),
                                fmt::format("an index of at most {}", there.size()),
                                {}};
        return found;
      }
    }
    if (path.empty()) {
      found.field = field;
      found.leaf = next;
      return found;
    }
    type = field->message_type();
    if (next >= 0) {
      found.node = next;
      type = tree[next].message;
    } else {
      is_missing = true;
      found.missing.push_back(field);
    }
  }
}

DraftPlace find_draft(Draft& draft, std::string_view path) {
  DraftPlace place{.holder = &draft};
  while (true) {
    const pb::Descriptor* type = place.holder->field->message_type();
    const Segment segment = take_segment(path);
    place.field = type ? type->FindFieldByName(segment.name) : nullptr;
    if (!place.field) {
      place.refusal = type ? no_field(*type, segment.name) : Refusal{"a value", "a message", {}};
      return place;
    }
    if (path.empty()) return place;
    Draft* next = nullptr;
    for (Draft& part : place.holder->parts)
      if (part.field == place.field) next = &part;
    if (!next) next = &place.holder->parts.emplace_back(Draft{place.field, "", {}});
    place.holder = next;
  }
}

}  // namespace tessera::edit
