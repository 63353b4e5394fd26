#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/color.h"
#include "renderer/math/vec.h"
#include "scenes/formats/x3d/document/x3d_document.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// An axis and an angle in radians.
struct X3dRotation {
  Vec3 axis{0, 0, 1};
  double angle = 0;
};

/// Reads the values of fields; a field that is not there has its default. What cannot be read is
/// left out with a warning. Every number is finite.
class X3dValues {
 public:
  /// Both must outlive this.
  X3dValues(const X3dDocument& document, Warnings& warnings)
      : document_(document), warnings_(warnings) {}

  /// Tells what was met when the document was read.
  void tell_remarks() const;

  bool boolean(const X3dNode& node, std::string_view name, bool otherwise) const;
  double number(const X3dNode& node, std::string_view name, double otherwise) const;
  /// In radians, whatever the file's unit.
  double angle(const X3dNode& node, std::string_view name, double otherwise) const;
  std::vector<double> angles(const X3dNode& node, std::string_view name) const;
  /// The value of that field in [0, `most`], with a warning that says what is `expected`.
  double clamped(const X3dNode& node, std::string_view name, double value,
                 std::string_view expected = "0 or more",
                 double most = std::numeric_limits<double>::infinity()) const;
  /// The same of an angle in radians, which may be above `most` by what rounding makes of it.
  double clamped_angle(const X3dNode& node, std::string_view name, double angle,
                       std::string_view expected, double most) const;
  /// At least 0, with a warning.
  double amount(const X3dNode& node, std::string_view name, double otherwise) const;
  /// Clamped to [0, 1] with a warning.
  double share(const X3dNode& node, std::string_view name, double otherwise) const;
  int64_t integer(const X3dNode& node, std::string_view name, int64_t otherwise) const;
  Vec3 vec3(const X3dNode& node, std::string_view name, const Vec3& otherwise) const;
  /// Each component clamped to [0, 1] with a warning.
  Color color(const X3dNode& node, std::string_view name, const Color& otherwise) const;
  X3dRotation rotation(const X3dNode& node, std::string_view name) const;
  std::string text(const X3dNode& node, std::string_view name) const;
  /// The index in `choices` of what a field gives; of the first one where it gives nothing or, with
  /// a warning, none of them.
  size_t choice(const X3dNode& node, std::string_view name, std::string_view given,
                std::span<const std::string_view> choices) const;
  /// The same of all of a field's text.
  size_t choice(const X3dNode& node, std::string_view name,
                std::span<const std::string_view> choices) const {
    return choice(node, name, text(node, name), choices);
  }
  /// A list of strings; in XML, one without quotes is one string.
  std::vector<std::string> strings(const X3dNode& node, std::string_view name) const;

  /// So many numbers; empty where the field is not there, or left out.
  std::vector<double> exactly(const X3dNode& node, std::string_view name, size_t count) const;
  /// All numbers of a list, a multiple of `width`, with 0 for what is none; empty where the field
  /// is not there.
  std::vector<double> numbers(const X3dNode& node, std::string_view name, size_t width) const;
  /// The same as single-precision values.
  std::vector<float> floats(const X3dNode& node, std::string_view name, size_t width) const;
  /// The points of a Coordinate node, x y z each, with NaN for what is no finite number.
  std::vector<float> points(const X3dNode& node) const;
  /// Integers, and where each is written.
  struct Integers {
    std::vector<int32_t> values;
    std::vector<uint32_t> offsets;
  };
  /// Stands for what is no integer, where 0 would be a value: no index or count is this small.
  static constexpr int32_t kNoInteger = std::numeric_limits<int32_t>::min();
  /// `none` stands for what is no integer; the warning says what is `taken`.
  Integers integers(const X3dNode& node, std::string_view name, int32_t none = 0,
                    std::string_view taken = "0 is taken") const;
  /// A list of counts that divides `points` points: where each run begins, and where the last one
  /// ends. A run of fewer than `least`, or of more than are left, has those that are there.
  std::vector<size_t> runs(const X3dNode& node, std::string_view name, size_t least,
                           size_t points) const;
  std::vector<Color> colors(const X3dNode& node, std::string_view name) const;

  const X3dDocument& document() const { return document_; }
  /// Warns of what stands at `offset`, and there first.
  void warn(size_t offset, std::string_view what, uint64_t times = 1) const {
    warnings_.add(
        what, [&] { return document_.place(offset); }, times);
  }

  /// Warns that a field, which is there, breaks the rule `expected`, and what is `taken` for it:
  /// "FIELD of NODE: 'TEXT'; expected EXPECTED; TAKEN". Those of one field are one warning.
  void repair(const X3dNode& node, std::string_view name, std::string_view expected,
              std::string_view taken) const;
  /// The same of a part of the field, which is `found` at `offset`.
  void repair(const X3dNode& node, std::string_view name, size_t offset, std::string_view found,
              std::string_view expected, std::string_view taken) const;
  /// The same of what stands at `offset` and is no field.
  void repair(size_t offset, std::string_view found, std::string_view expected,
              std::string_view taken) const {
    warnings_.repair(found, expected, taken, [&] { return document_.place(offset); });
  }

  /// Counts what is made of a node at `offset` as if so much were read.
  void spend(size_t bytes, size_t offset) const;
  /// Reading lists again and again, as USE makes possible, must end: so much, and so often the
  /// length of the file.
  static constexpr size_t kMaxReadBytes = size_t{256} << 20, kMaxReadTimes = 16;

 private:
  /// NaN for what is no finite number, with a warning that says what is `taken`; the nearest one in
  /// the range of single precision for one beyond it, or NaN too if not `clamps`.
  template <typename Number>
  std::vector<Number> list(const X3dNode& node, std::string_view name, size_t width,
                           std::string_view taken, bool clamps) const;
  template <typename Number>
  std::vector<Number> finite_list(const X3dNode& node, std::string_view name, size_t width) const;
  /// The field, whose text is now read once more.
  const X3dField* read_field(const X3dNode& node, std::string_view name) const;
  Color clamped(const Color& color, const X3dNode& node, std::string_view name) const;

  const X3dDocument& document_;
  Warnings& warnings_;
  mutable size_t read_bytes_ = 0;
};

}  // namespace tessera
