#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/film/aov.h"
#include "renderer/film/tile.h"

namespace tessera {

/// The values of command-line options. Each function names the option in the usage error that it
/// throws, what was typed and what was expected.

struct FrameSize {
  int width = 0, height = 0;
};

struct FrameRange {
  int first = 0, last = 0;
};

/// Frames of an animation: at least one number, ascending, each once.
using FrameNumbers = std::vector<int>;
/// Of one command. They are rendered one after the other, so more of them are for several commands.
inline constexpr int64_t kMostFrames = 1'000'000;
/// Of a job of a farm.
inline constexpr size_t kMostJobFrames = 10'000;

/// A whole number in [least, most], in decimal digits and nothing else.
int64_t parse_whole(std::string_view option, std::string_view text, int64_t least, int64_t most);
/// A whole number above 0, K, M, G or T behind it being powers of 1024.
uint64_t parse_bytes(std::string_view option, std::string_view text);
/// A whole number of at least 1 with s, m, h or d behind it, such as 90m; at most ten years.
std::chrono::seconds parse_duration(std::string_view option, std::string_view text);
/// A share from 0 to 1: "2.5%" or "0.025".
double parse_share(std::string_view option, std::string_view text);
/// A finite number.
double parse_number(std::string_view option, std::string_view text);
/// "WxH", each from 1 to kMaxFrameSide, their product at most kMaxFramePixels.
FrameSize parse_size(std::string_view option, std::string_view text);
/// "X0,Y0,X1,Y1": pixels X0 <= x < X1, Y0 <= y < Y1.
PixelRect parse_crop(std::string_view option, std::string_view text);
/// One frame, a range or a range with a step, or several of them with commas between, as renderers
/// and render managers write them: "5", "0-23", "0..23", "1-100x5", "1,5,10-20".
FrameNumbers parse_frames(std::string_view option, std::string_view text);
/// `text`, if it is one of `names`.
std::string parse_choice(std::string_view option, const std::string& text,
                         std::span<const std::string> names);
/// "NAME, NAME ..." of aov_names(), or "all".
AovSet parse_aovs(std::string_view option, const std::string& text);

}  // namespace tessera
