#include "studio/source_request.h"

#include <algorithm>

namespace tessera::page {
namespace {

struct SourceKind {
  Source::What what;
  const char* name;
  bool changes_text;
};
constexpr std::array kSourceKinds{SourceKind{Source::What::set, "set", true},
                                  SourceKind{Source::What::reset, "reset", true},
                                  SourceKind{Source::What::add, "add", true},
                                  SourceKind{Source::What::remove, "remove", true},
                                  SourceKind{Source::What::duplicate, "duplicate", true},
                                  SourceKind{Source::What::write_camera, "write_camera", true},
                                  SourceKind{Source::What::write_settings, "write_settings", true},
                                  SourceKind{Source::What::place, "place", true},
                                  SourceKind{Source::What::fields, "fields", false},
                                  SourceKind{Source::What::placement, "placement", false},
                                  SourceKind{Source::What::complete, "complete", false},
                                  SourceKind{Source::What::hover, "hover", false},
                                  SourceKind{Source::What::camera_text, "camera_text", false}};

const SourceKind& source_kind(Source::What what) {
  return *std::ranges::find(kSourceKinds, what, &SourceKind::what);
}

}  // namespace

const char* name_of(Source::What what) { return source_kind(what).name; }

std::optional<Source::What> source_of(std::string_view message) {
  const auto* const found = std::ranges::find_if(
      kSourceKinds, [message](const SourceKind& each) { return each.name == message; });
  return found == kSourceKinds.end() ? std::nullopt : std::optional(found->what);
}

bool Source::changes_text() const { return source_kind(what).changes_text; }

}  // namespace tessera::page
