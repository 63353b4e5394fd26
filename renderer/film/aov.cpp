#include "renderer/film/aov.h"

#include <array>

#include "base/error.h"
#include "renderer/film/tile.h"

namespace tessera {
namespace {

struct Layout {
  Aov aov;
  const char* name;
  std::vector<std::string> channels;
};

std::vector<std::string> origin_channels() {
  std::vector<std::string> names;
  for (size_t i = 0; i < kOriginDepth; ++i) names.push_back("origin." + std::to_string(i));
  return names;
}

const std::array<Layout, 10>& layouts() {
  static const std::array<Layout, 10> layouts{
      {{Aov::albedo, "albedo", {"albedo.R", "albedo.G", "albedo.B"}},
       {Aov::normal, "normal", {"N.X", "N.Y", "N.Z"}},
       {Aov::depth, "depth", {"Z"}},
       {Aov::position, "position", {"P.X", "P.Y", "P.Z"}},
       {Aov::id, "id", {"id"}},
       {Aov::variance, "variance", {"variance.R", "variance.G", "variance.B"}},
       {Aov::samples, "samples", {"samples"}},
       {Aov::origin, "origin", origin_channels()},
       {Aov::primitive, "primitive", {"primitive"}},
       {Aov::alpha, "alpha", {"A"}}}};
  return layouts;
}

}  // namespace

const std::vector<std::string>& aov_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Layout& layout : layouts()) {
      if (AovSet::all().has(layout.aov)) list.emplace_back(layout.name);
    }
    return list;
  }();
  return names;
}

AovSet::AovSet(uint32_t bits) : bits_(bits & ((uint32_t{1} << layouts().size()) - 1)) {}

std::vector<Aov> AovSet::members() const {
  std::vector<Aov> members;
  for (const Layout& layout : layouts()) {
    if (has(layout.aov)) members.push_back(layout.aov);
  }
  return members;
}

bool AovSet::needs_surfaces() const {
  return has(Aov::albedo) || has(Aov::normal) || has(Aov::depth) || has(Aov::position) ||
         has(Aov::id) || has(Aov::origin) || has(Aov::primitive);
}

int AovSet::channels() const {
  int count = kFilmChannels;
  for (const Layout& layout : layouts()) {
    if (has(layout.aov)) count += static_cast<int>(layout.channels.size());
  }
  return count;
}

int AovSet::first_channel(Aov aov) const {
  TESSERA_CHECK(has(aov), layouts()[static_cast<size_t>(aov)].name);
  const auto below = bit(aov) - 1;
  return AovSet(bits_ & below).channels();
}

std::vector<std::string> AovSet::channel_names() const {
  std::vector<std::string> names{"R", "G", "B"};
  for (const Layout& layout : layouts()) {
    if (has(layout.aov)) names.insert(names.end(), layout.channels.begin(), layout.channels.end());
  }
  return names;
}

}  // namespace tessera
