#include "studio/picture_files.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <new>
#include <utility>

#include "base/error.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "front/render_frame.h"
#include "image/image_file.h"
#include "proto/wire/scene_codec.h"

namespace tessera {
namespace {

void write(const Folder& folder, const std::string& name, std::string_view bytes, bool force) {
  if (force) {
    folder.save(name, bytes, std::nullopt);
  } else {
    folder.create(name, bytes);
  }
}

std::string name_of_frame(const std::string& name, std::optional<int> number) {
  return frame_path(name, number).generic_string();
}

/// Runs `make`; what it throws becomes text behind what failed before.
template <typename Make>
void attempt(std::string& failure, const Make& make) {
  std::string why;
  try {
    make();
  } catch (const std::bad_alloc&) {
    why = "there is not enough memory";
  } catch (const std::exception& error) {
    why = error.what();
  }
  if (why.empty()) return;
  if (!failure.empty()) failure += "; ";
  failure += why;
}

}  // namespace

std::string statistics_name(const std::string& picture_name) {
  return std::filesystem::path(picture_name).replace_extension(".stats.json").generic_string();
}

FrameFinished finish_frame(const FinishFrame& order, const Folder& folder) {
  FrameFinished finished{.job = order.job, .written = {}, .failure = {}};
  attempt(finished.failure, [&] {
    finished.picture = picture_of(order.frame, std::move(*order.result), order.seconds);
  });
  if (!finished.picture) return finished;
  const RenderedPicture& picture = *finished.picture;
  const FileGoal& goal = order.goal;
  const RenderOptions& options = *order.frame.options;
  const auto write_one = [&](const std::string& name, const auto& bytes) {
    attempt(finished.failure, [&] {
      write(folder, name, bytes(), goal.force);
      finished.written.push_back(name);
    });
  };
  for (const std::string& each : goal.names) {
    if (goal.animations && holds_frames(each)) {
      attempt(finished.failure, [&] {
        // Found now rather than after the last frame.
        if (goal.is_first_frame && !goal.force) folder.start(each);
        goal.animations->add(each, picture.film,
                             shown_settings(options.scene, picture, options.output),
                             picture.metadata);
      });
      continue;
    }
    const std::string name = name_of_frame(each, goal.number);
    write_one(name, [&] {
      return encode_image(name, picture.film,
                          shown_settings(options.scene, picture, options.output), picture.metadata);
    });
  }
  if (goal.statistics && !goal.names.empty()) {
    const std::string name = name_of_frame(statistics_name(goal.names.front()), goal.number);
    write_one(name, [&] { return picture.statistics; });
  }
  if (goal.animations && goal.is_last_frame && finished.failure.empty()) {
    const double rate = options.frames_per_second.value_or(
        scene_frame_rate(options.scene, order.frame.reading->scene->loaded.scene.settings()));
    goal.animations->write(rate, [&](const AnimationFiles::Whole& file) {
      if (!file.note.empty()) spdlog::warn("full picture {}: {}", order.job, file.note);
      write_one(file.path.generic_string(), [&]() -> const std::string& { return file.bytes; });
    });
  }
  return finished;
}

FileExported export_file(const ExportFile& order, const Folder& folder) {
  const std::string& name = order.goal.names.front();
  FileExported exported{.name = name, .is_shown = order.goal.is_shown};
  attempt(exported.failure, [&] {
    const bool is_new = !order.goal.is_download && !order.goal.force;
    if (is_new && folder.check_writable(name)) exported.existing.add(name);
    if (is_new && order.goal.statistics && folder.check_writable(statistics_name(name)))
      exported.existing.add(statistics_name(name));
    if (exported.existing.count > 0) {
      exported.failure = exported.existing.why();
      return;
    }
    std::string bytes;
    if (order.picture) {
      bytes = encode_image(name, order.picture->film, order.output, order.picture->metadata);
    } else {
      const LoadedScene& loaded = order.frame.reading->scene->loaded;
      bytes = encode_scene(loaded.scene, loaded.blobs, scene_encoding_of(name).value());
    }
    if (order.goal.is_download) {
      exported.content = std::make_shared<const std::string>(std::move(bytes));
      if (order.goal.statistics && order.picture) exported.statistics = order.picture->statistics;
      return;
    }
    write(folder, name, bytes, order.goal.force);
    if (order.goal.statistics && order.picture && !order.picture->statistics.empty())
      write(folder, statistics_name(name), order.picture->statistics, order.goal.force);
  });
  return exported;
}

}  // namespace tessera
