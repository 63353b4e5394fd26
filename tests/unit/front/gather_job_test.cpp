#include "front/gather_job.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/error_of.h"

namespace tessera {
namespace {

/// Gathers a job of these frames and counts how often its scene is loaded.
struct Gathering {
  explicit Gathering(size_t frames) : numbers(frames) {
    std::iota(numbers.begin(), numbers.end(), 0);
    options.scene = "scene.tessera";
    options.size = FrameSize{8, 8};
    options.frames = numbers;
  }
  SubmittedJob gather() {
    return gather_job(
        options, {},
        [this](int) {
          ++loads;
          LoadedScene loaded;
          loaded.scene.add_cameras()->set_name(options.camera.value_or(""));
          return loaded;
        },
        [](const std::string&) {});
  }

  FrameNumbers numbers;
  RenderOptions options;
  int loads = 0;
};

TEST(GatherJob, AJobHasTheFramesThatAreAskedFor) {
  Gathering gathering(3);
  gathering.options.frames = FrameNumbers{1, 5, 10};
  const SubmittedJob job = gathering.gather();
  ASSERT_EQ(job.request.frames_size(), 3);
  EXPECT_EQ(job.request.frames(0).number(), 1);
  EXPECT_EQ(job.request.frames(1).number(), 5);
  EXPECT_EQ(job.request.frames(2).number(), 10);
}

TEST(GatherJob, TooManyFramesAreRefusedBeforeTheSceneIsRead) {
  Gathering gathering(kMostJobFrames + 1);
  EXPECT_EQ(usage_error_of([&] { gathering.gather(); }),
            "--frames: 10001 frames; expected at most 10000 in one job: submit those before 10000 "
            "as one, and those from there on as others");
  EXPECT_EQ(gathering.loads, 0);
}

TEST(GatherJob, AsManyAsAreAllowedFitIntoOneMessage) {
  Gathering gathering(kMostJobFrames);
  EXPECT_LT(gathering.gather().request.ByteSizeLong(), max_message_bytes(Channel::control));
}

TEST(GatherJob, FramesWhoseSettingsAreLongAreRefusedAtTheFirst) {
  Gathering gathering(kMostJobFrames);
  gathering.options.camera = std::string(1000, 'c');
  EXPECT_NE(usage_error_of([&] { gathering.gather(); }).find("10000 frames; expected at most 1"),
            std::string::npos);
  EXPECT_EQ(gathering.loads, 1);
}

}  // namespace
}  // namespace tessera
