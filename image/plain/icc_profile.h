#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tessera {

/// Takes colours of 8 bits from those of an embedded profile (ICC.1:2010) to sRGB.
class SrgbConversion {
 public:
  /// Knows profiles by matrix and curves, as cameras and painting programs embed them. Nothing for
  /// any other, for one that is damaged, and for one that is sRGB itself to within a code.
  static std::optional<SrgbConversion> from(std::span<const unsigned char> profile);
  /// Pixels of three or more channels, the first three of them red, green and blue.
  void convert(std::span<char> pixels, size_t channels) const;

 private:
  static constexpr int kSteps = 65535;
  std::array<unsigned char, 3> converted(const unsigned char* rgb) const;
  bool changes_nothing() const;
  /// Between two steps whose codes are known.
  void fill_codes(size_t first, size_t last, unsigned char low, unsigned char high);

  std::array<std::array<double, 256>, 3> linear_{};
  std::array<std::array<double, 3>, 3> matrix_{};
  std::array<unsigned char, kSteps + 1> codes_{};  ///< of light in steps
};

}  // namespace tessera
