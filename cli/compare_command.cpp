#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "base/core_count.h"
#include "base/parallel.h"
#include "cli/command_line.h"
#include "cli/say.h"
#include "front/option_values.h"
#include "image/image_file.h"
#include "metrics/difference.h"
#include "metrics/picture_error.h"
#include "metrics/ssim.h"
#include "renderer/math/stored_samples.h"

namespace tessera {
namespace {

struct CompareOptions {
  std::string first, second;
  double max_difference = 0;
  bool metrics = false;
};

void print_where(const FloatImage& a, const FloatImage& b, const Difference& d) {
  const size_t channels = a.channels.size();
  const auto value = [&](const FloatImage& image) {
    std::vector<std::string> numbers;
    for (size_t i = 0; i < channels; ++i) {
      numbers.push_back(fmt::format("{:.9g}", image.values[d.worst_pixel * channels + i]));
    }
    return fmt::format("({})", fmt::join(numbers, ", "));
  };
  const auto width = static_cast<size_t>(a.width);
  say("all of them in    {},{},{},{}\n", d.x0, d.y0, d.x1, d.y1);
  say("the worst pixel   {},{}: {} and {}\n", d.worst_pixel % width, d.worst_pixel / width,
      value(a), value(b));
}

/// The channels that differ most, in order.
void print_channels(const std::vector<std::string>& names, const std::vector<double>& greatest) {
  std::vector<size_t> order(names.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return greatest[a] > greatest[b]; });
  constexpr size_t kMostShown = 8;
  std::vector<std::string> texts;
  for (const size_t i : order) {
    if (greatest[i] > 0 && texts.size() < kMostShown)
      texts.push_back(fmt::format("{} by {:.9g}", printable(names[i]), greatest[i]));
  }
  say("at most           {}\n", fmt::join(texts, ", "));
}

void check_sizes(const CompareOptions& options, const FloatImage& a, const FloatImage& b) {
  if (a.width != b.width || a.height != b.height) {
    throw scene_error(fmt::format("sizes differ: {} is {}x{}, {} is {}x{}", options.first, a.width,
                                  a.height, options.second, b.width, b.height));
  }
}

bool has_channel(const FloatImage& image, const std::string& name) {
  return std::ranges::find(image.channels, name) != image.channels.end();
}

bool has_colors_of(const FloatImage& image, const FloatImage& other) {
  return std::ranges::all_of(color_channels_of(other.channels).in_order(), [&](const auto& color) {
    return !color || has_channel(image, other.channels[*color]);
  });
}

FloatImage with_channels(const FloatImage& image, const std::vector<std::string>& names) {
  FloatImage made = image;
  made.channels = names;
  std::vector<size_t> from;
  for (const std::string& name : names) {
    from.push_back(
        static_cast<size_t>(std::ranges::find(image.channels, name) - image.channels.begin()));
  }
  made.values.clear();
  for (size_t pixel = 0; pixel < image.values.size(); pixel += image.channels.size()) {
    for (const size_t channel : from) made.values.push_back(image.values[pixel + channel]);
  }
  return made;
}

/// Leaves in both pictures what both have, the colours among it, and warns of what is left out.
void keep_common_channels(const CompareOptions& options, FloatImage& a, FloatImage& b) {
  if (a.channels == b.channels) return;
  if (!has_colors_of(a, b) || !has_colors_of(b, a)) {
    throw scene_error(fmt::format("channels differ: {} has {}; {} has {}", options.first,
                                  fmt::join(a.channels, ", "), options.second,
                                  fmt::join(b.channels, ", ")));
  }
  const auto split = [](const FloatImage& image, const FloatImage& other) {
    std::array<std::vector<std::string>, 2> names;  // left out and common
    for (const std::string& name : image.channels) names[has_channel(other, name)].push_back(name);
    return names;
  };
  const auto warn = [](const std::string& path, const std::vector<std::string>& names,
                       const std::string& other) {
    if (names.empty()) return;
    say_warning(fmt::format("{}: {} left out; {} has no such channel", path, fmt::join(names, ", "),
                            other));
  };
  const auto [only_a, common] = split(a, b);
  warn(options.first, only_a, options.second);
  warn(options.second, split(b, a)[0], options.first);
  a = with_channels(a, common);
  b = with_channels(b, common);
}

/// Where the numbers of the two files stand for different things, what those are.
void print_meanings(const CompareOptions& options, const FloatImage& a, const FloatImage& b) {
  if (a.meaning == b.meaning) return;
  const auto meaning = [](const FloatImage& image) {
    return fmt::format(
        "{}{}",
        holds_codes(image.meaning, SampleEncoding::automatic) ? "sRGB codes" : "linear light",
        image.meaning.is_associated ? " multiplied by alpha" : "");
  };
  say("as stored         {}: {}; {}: {}\n", printable(options.first), meaning(a),
      printable(options.second), meaning(b));
}

void print_metrics(const FloatImage& a, const FloatImage& b) {
  const Picture first{a.width, a.height, linear_light(a)},
      second{b.width, b.height, linear_light(b)};
  const PictureError e = picture_error(first, second);
  say("linear rmse       {:.9g}\n", e.rmse);
  say("relMSE            {:.9g}, {:.9g} without the worst thousandth\n", e.rel_mse,
      e.trimmed_rel_mse);
  say("SMAPE             {:.9g}\n", e.smape);
  say("FLIP              {:.9g}\n", e.flip);
  say("SSIM              {:.9g}\n", mean_ssim(first, second));
  say("99.9 % are within {:.9g}\n", e.error_99_9);
  say("mean ratio        {:.9g}\n", e.mean_ratio);
  if (e.not_finite > 0) say("not finite        {} values\n", e.not_finite);
}

/// What cannot be read differs from nothing: it is the command line that is wrong.
FloatImage read_picture(const std::string& path) {
  try {
    return read_image(path);
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_scene) throw;
    throw usage_error(error.what());
  }
}

ExitCode compare(const CompareOptions& options) {
  std::array<FloatImage, 2> pictures;
  for_each_parallel(2, core_count(), [&](size_t i) {
    pictures[i] = read_picture(i == 0 ? options.first : options.second);
  });
  auto& [a, b] = pictures;
  if (!a.part_note.empty()) say_warning(fmt::format("{}: {}", options.first, a.part_note));
  if (!b.part_note.empty()) say_warning(fmt::format("{}: {}", options.second, b.part_note));
  check_sizes(options, a, b);
  keep_common_channels(options, a, b);
  const Difference d = difference_of(a.values, b.values, a.channels.size(),
                                     static_cast<size_t>(a.width), options.max_difference);
  say("size              {}x{}\n", a.width, a.height);
  print_meanings(options, a, b);
  say("max difference    {:.9g}\n", d.greatest);
  say("mean difference   {:.9g}\n", d.mean);
  say("rmse              {:.9g}\n", d.rmse);
  say("differing pixels  {} of {}\n", d.pixels_unequal, int64_t{a.width} * a.height);
  if (d.pixels_unequal > 0) {
    print_where(a, b, d);
    print_channels(a.channels, d.greatest_of);
  }
  if (options.metrics) print_metrics(a, b);
  if (d.pixels_beyond == 0) return ExitCode::done;
  say("{} by more than {}\n",
      d.pixels_beyond == 1 ? "1 pixel differs" : fmt::format("{} pixels differ", d.pixels_beyond),
      options.max_difference);
  return ExitCode::bad_scene;
}

}  // namespace

void add_compare_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand("compare", "Tell how two pictures differ");
  command->footer(
      "Every channel that both pictures have counts, and both must have the same colours and "
      "alpha;\n"
      "other channels of one alone, such as AOVs, are left out with a warning. Values are those "
      "of\n"
      "the files, neither decoded: integers are sRGB codes from 0 to 1, floats linear light. "
      "Where\n"
      "the two differ in this, the line 'as stored' says so; --metrics decodes both.\n"
      "Places count pixels from the left and from the top, a part is X0,Y0,X1,Y1 as in --crop.\n"
      "Two renders of a scene are equal in pixels and in bytes. To hold them against each other\n"
      "without files, compare pixels_sha256 of --stats.\n"
      "Exit code 0 where no channel of any pixel differs by more than --max-diff, 1 where one "
      "does\n"
      "or the sizes do, 2 where a file cannot be read.\n"
      "Examples:\n"
      "  tessera compare now.exr before.exr                 equal to the last bit?\n"
      "  tessera compare now.png before.png --max-diff 0.004    equal to within one step of 255?");
  command->add_option("A", options->first, "A picture")->required()->type_name("FILE");
  command->add_option("B", options->second, "The picture it is held against")
      ->required()
      ->type_name("FILE");
  command
      ->add_option_function<std::string>(
          "--max-diff",
          [options](const std::string& text) {
            options->max_difference = parse_number("--max-diff", text);
            if (options->max_difference < 0) {
              throw usage_error(fmt::format("--max-diff: '{}'; expected 0 or more", text));
            }
          },
          "The greatest difference of a channel that still counts as equal [0]")
      ->type_name("X");
  command->add_flag("--metrics", options->metrics,
                    "Tell relMSE, SMAPE, FLIP, SSIM and their like of A with B as the truth, too");
  command->callback([options, &action] { action = [options] { return compare(*options); }; });
}

}  // namespace tessera
