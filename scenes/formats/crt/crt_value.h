#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/color.h"
#include "renderer/math/vec.h"
#include "scenes/formats/crt/crt_syntax.h"

namespace tessera {

struct CrtList;
struct CrtEntity;
struct CrtMacro;
struct CrtScope;

struct CrtLight {
  v1::Light message;
};
struct CrtCamera {
  v1::Camera message;
};
struct CrtTexture {
  v1::Texture message;
};
struct CrtMaterial {
  v1::Material message;
  const CrtTexture* color = nullptr;  ///< of the surface, if it is not one colour
  const CrtTexture* bump = nullptr;
  double bump_height = 0;
};
struct CrtBackground {
  v1::Background message;
  std::string image;  ///< of a panorama: the file, as the script names it
  CrtSpan image_span;
};

/// What follows from something that was reported: it silences what follows from it in turn.
struct CrtFailed {
  friend bool operator==(CrtFailed, CrtFailed) = default;
};
struct CrtNothing {
  friend bool operator==(CrtNothing, CrtNothing) = default;
};

/// A value of the language. Small; what is larger lives in a CrtHeap, is immutable and shared.
using CrtValue =
    std::variant<CrtNothing, CrtFailed, int32_t, double, bool, const std::string*, Vec3, Color,
                 const CrtList*, const CrtEntity*, const CrtLight*, const CrtMaterial*,
                 const CrtCamera*, const CrtBackground*, const CrtTexture*, const CrtMacro*>;

struct CrtList {
  std::vector<CrtValue> items;
};

/// What is in the scene: a shape, a file's model, or a set operation on two others.
struct CrtEntity {
  enum class Kind : uint8_t { empty, shape, include, set_operation };
  Kind kind = Kind::shape;
  v1::Shape shape;          ///< without materials
  v1::Include include;      ///< without transform
  v1::Transform placement;  ///< entity from shape's axes; empty for most
  const CrtMaterial* material = nullptr;
  bool one_sided = false;  ///< seen from its front only, where it stands alone
  v1::Csg::Operation operation = v1::Csg::UNION;
  const CrtEntity* left = nullptr;
  const CrtEntity* right = nullptr;
  v1::Transform modifiers;  ///< outermost first, as the description wants them
  CrtSpan span;
  uint32_t nesting = 0;  ///< of set operations, counted as the writer writes them
  uint32_t leaves = 1;
};

struct CrtMacro {
  const CrtSyntax* syntax = nullptr;
  CrtScope* scope = nullptr;  ///< where it was made
};

/// Where large values live, all until the script is done: nothing is freed, so what was ever made
/// counts against the limit. Throws CrtLimitError beyond it.
class CrtHeap {
 public:
  static constexpr uint64_t kMaxBytes = uint64_t{512} << 20;

  const std::string* text(std::string value, CrtSpan where);
  const CrtList* list(std::vector<CrtValue> items, CrtSpan where);
  template <typename T>
  const T* add(T value, CrtSpan where) {
    charge(1024, where);
    return &std::get<std::deque<T>>(pools_).emplace_back(std::move(value));
  }
  void charge(uint64_t bytes, CrtSpan where);

 private:
  std::tuple<std::deque<std::string>, std::deque<CrtList>, std::deque<CrtEntity>,
             std::deque<CrtLight>, std::deque<CrtMaterial>, std::deque<CrtCamera>,
             std::deque<CrtBackground>, std::deque<CrtTexture>, std::deque<CrtMacro>>
      pools_;
  uint64_t bytes_ = 0;
};

/// "an integer", "a vector" ...
std::string_view type_name(const CrtValue& value);
/// As type_name, with the value where it is short: "the integer 3".
std::string describe(const CrtValue& value);

template <typename T>
bool holds(const CrtValue& value) {
  return std::holds_alternative<T>(value);
}
inline bool is_number(const CrtValue& value) {
  return holds<int32_t>(value) || holds<double>(value);
}
/// Of an integer or a float.
double number_of(const CrtValue& value);
/// An integer, which a whole float stands for too: one comes of computing with t or of functions.
std::optional<int32_t> whole_number(const CrtValue& value);
/// As Java writes it: 3, 0.5, 1.0, 1.5E-4.
std::string number_text(const CrtValue& value);

}  // namespace tessera
