#include "image/image_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

#include "base/error.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class ImageFile : public testing::Test {
 protected:
  size_t files() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  static Film ramp() {
    Film film({0, 0, 16, 4});
    for (size_t i = 0; i < film.values().size(); ++i) {
      film.values()[i] = static_cast<float>(i) / static_cast<float>(film.values().size());
    }
    return film;
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
  const OutputSettings display_{.transfer = TransferCurve::display};
};

ExitCode code_of(const std::function<void()>& call, std::string* message = nullptr) {
  try {
    call();
  } catch (const Error& error) {
    if (message) *message = error.what();
    return error.code();
  }
  return ExitCode::done;
}

TEST_F(ImageFile, float_formats_keep_linear_values) {
  Film film = ramp();
  film.values()[5] = 1000;
  for (const char* name : {"a.exr", "a.pfm"}) {
    write_image(folder_ / name, film, {.tone_curve = ToneCurve::reinhard}, {});
    const FloatImage image = read_image(folder_ / name);
    ASSERT_EQ(image.width, 16) << name;
    ASSERT_EQ(image.height, 4);
    EXPECT_TRUE(std::equal(image.values.begin(), image.values.end(), film.values().begin()))
        << name;
  }
  write_image(folder_ / "a.hdr", film, {}, {});
  EXPECT_NEAR(read_image(folder_ / "a.hdr").values[5], 1000, 8);
}

TEST_F(ImageFile, byte_formats_hold_the_tone_mapped_bytes) {
  const Film film = ramp();
  const std::vector<uint8_t> bytes = to_8_bit(film, display_);
  for (const char* name : {"a.png", "a.BMP", "a.tif", "a.tga", "a.ppm"}) {
    write_image(folder_ / name, film, display_, {});
    const FloatImage image = read_image(folder_ / name);
    ASSERT_EQ(image.values.size(), bytes.size()) << name;
    for (size_t i = 0; i < bytes.size(); ++i) {
      ASSERT_EQ(std::lround(image.values[i] * 255), bytes[i]) << name << " " << i;
    }
  }
  write_image(folder_ / "a.jpg", film, display_, {});
  EXPECT_EQ(read_image(folder_ / "a.jpg").width, 16);
  EXPECT_EQ(files(), 6u);  // and no temporary
}

TEST_F(ImageFile, some_hold_sixteen_bits) {
  const Film film = ramp();
  OutputSettings settings = display_;
  settings.bits = 16;
  const std::vector<uint16_t> integers = to_16_bit(film, settings);
  for (const char* name : {"a.png", "a.tiff"}) {
    write_image(folder_ / name, film, settings, {});
    const FloatImage image = read_image(folder_ / name);
    ASSERT_EQ(image.values.size(), integers.size()) << name;
    for (size_t i = 0; i < integers.size(); ++i) {
      ASSERT_EQ(std::lround(image.values[i] * 65535), integers[i]) << name << " " << i;
    }
  }
  EXPECT_EQ(code_of([&] { write_image(folder_ / "a.jpg", film, settings, {}); }),
            ExitCode::bad_usage);
  write_image(folder_ / "a.exr", film, settings, {});
}

TEST_F(ImageFile, alpha_is_associated_in_floats_alone) {
  // Half covered by full red, all by a dark green, by nothing, and more than all by a filter's
  // overshoot.
  Film film({0, 0, 4, 1}, AovSet().with(Aov::depth).with(Aov::alpha));
  const std::array<float, 20> values{.5f, 0, 0, 7, .5f, 0, .25f, 0, 7, 1,
                                     0,   0, 0, 0, 0,   1, 1,    1, 7, 1.25f};
  std::ranges::copy(values, film.values().begin());
  write_image(folder_ / "a.exr", film, display_, {});
  const FloatImage exr = read_image(folder_ / "a.exr");
  EXPECT_EQ(exr.channels, (std::vector<std::string>{"R", "G", "B", "A", "Z"}));
  EXPECT_TRUE(exr.meaning.is_associated);
  EXPECT_EQ((std::vector<float>(exr.values.begin(), exr.values.begin() + 5)),
            (std::vector<float>{.5f, 0, 0, .5f, 7}));
  EXPECT_EQ(exr.values[18], 1.25f);
  for (const int bits : {8, 16}) {
    const double most = bits == 8 ? 255 : 65535;
    const std::vector<double> expected{most, 0, 0, std::floor(most / 2 + .5), 0, 0, 0, most, 0,
                                       0,    0, 0};
    for (const char* name : {"a.png", "a.tif", "a.tga"}) {
      if (bits == 16 && name == std::string_view("a.tga")) continue;
      OutputSettings settings = display_;
      settings.bits = bits;
      write_image(folder_ / name, film, settings, {});
      const FloatImage image = read_image(folder_ / name);
      EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"})) << name;
      EXPECT_FALSE(image.meaning.is_associated) << name;
      for (const size_t i : {0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11})
        EXPECT_NEAR(image.values[i] * most, expected[i], 1e-3) << name << ' ' << i;
      EXPECT_NEAR(image.values[5], .25, .003) << name;
      EXPECT_NEAR(image.values[12], .8, .003) << name;
      EXPECT_EQ(image.values[15], 1) << name;
    }
  }
  std::string message;
  EXPECT_EQ(code_of([&] { write_image(folder_ / "a.jpg", film, {}, {}); }, &message),
            ExitCode::bad_usage);
  EXPECT_NE(message.find("a.jpg' holds no alpha"), std::string::npos) << message;
}

TEST_F(ImageFile, files_carry_their_making) {
  const ImageMetadata making{
      .scene_digest = "0123abcd", .seed = 4294967295, .samples_per_pixel = 77};
  for (const char* name : {"a.png", "a.exr", "a.tif", "a.jpg"}) {
    write_image(folder_ / name, ramp(), display_, making);
    std::ifstream file(folder_ / name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    for (const char* text : {"tessera 0", "tessera:SceneDigest=0123abcd", "tessera:Seed=4294967295",
                             "tessera:Samples=77"}) {
      EXPECT_NE(bytes.find(text), std::string::npos) << name << " " << text;
    }
  }
}

/// The four numbers of a box in an EXR header.
std::array<int32_t, 4> exr_box(const std::string& bytes, const std::string& name) {
  const std::string head = name + '\0' + "box2i" + '\0';
  std::array<int32_t, 4> box{};
  const size_t at = bytes.find(head);
  if (at == std::string::npos) return box;
  std::memcpy(box.data(), bytes.data() + at + head.size() + 4, sizeof box);
  return box;
}

TEST_F(ImageFile, a_crop_knows_its_place) {
  Film film({100, 200, 103, 202});
  film.values()[4] = 0.5f;
  ImageMetadata making;
  making.frame_width = 640;
  making.frame_height = 480;
  write_image(folder_ / "a.exr", film, display_, making);
  std::ifstream file(folder_ / "a.exr", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(exr_box(bytes, "dataWindow"), (std::array<int32_t, 4>{100, 200, 102, 201}));
  EXPECT_EQ(exr_box(bytes, "displayWindow"), (std::array<int32_t, 4>{0, 0, 639, 479}));
  for (const char* name : {"a.exr", "a.tif", "a.png"}) {
    write_image(folder_ / name, film, display_, making);
    const FloatImage image = read_image(folder_ / name);
    EXPECT_EQ(image.width, 3) << name;
    EXPECT_EQ(image.height, 2) << name;
    EXPECT_GT(image.values[4], 0.4f) << name;
  }
}

TEST_F(ImageFile, unknown_endings_name_the_nearest) {
  std::string message;
  EXPECT_EQ(code_of([&] { check_writable(folder_ / "a.pnng"); }, &message), ExitCode::bad_usage);
  EXPECT_NE(message.find("did you mean 'png'"), std::string::npos) << message;
  EXPECT_EQ(code_of([&] { check_writable(folder_ / "noending"); }), ExitCode::bad_usage);
}

TEST_F(ImageFile, what_can_not_be_written_is_found_early) {
  EXPECT_EQ(code_of([&] { check_writable(folder_ / "a.png"); }), ExitCode::done);
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(code_of([&] { check_writable(folder_ / "missing" / "a.png"); }), ExitCode::bad_usage);
  fs::create_directory(folder_ / "folder.png");
  EXPECT_EQ(code_of([&] { check_writable(folder_ / "folder.png"); }), ExitCode::bad_usage);
  EXPECT_EQ(code_of([&] { write_image(folder_ / "missing" / "a.png", ramp(), {}, {}); }),
            ExitCode::render_failed);
}

TEST_F(ImageFile, a_failed_write_leaves_the_old_file) {
  write_image(folder_ / "a.png", ramp(), display_, {});
  const auto size = fs::file_size(folder_ / "a.png");
  fs::create_directory(folder_ / "b.png");
  fs::create_directory(folder_ / "b.png" / "full");
  EXPECT_EQ(code_of([&] { write_image(folder_ / "b.png", ramp(), {}, {}); }),
            ExitCode::render_failed);
  EXPECT_EQ(files(), 2u);
  EXPECT_EQ(fs::file_size(folder_ / "a.png"), size);
}

TEST_F(ImageFile, a_link_is_written_through) {
  write_image(folder_ / "real.png", ramp(), display_, {});
  fs::create_symlink(folder_ / "real.png", folder_ / "link.png");
  fs::resize_file(folder_ / "real.png", 0);
  write_image(folder_ / "link.png", ramp(), display_, {});
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.png"));
  EXPECT_GT(fs::file_size(folder_ / "real.png"), 0u);
}

TEST_F(ImageFile, files_that_are_no_pictures_are_refused) {
  EXPECT_EQ(code_of([&] { read_image(folder_ / "missing.png"); }), ExitCode::bad_scene);
  std::ofstream(folder_ / "text.png") << "not a picture";
  EXPECT_EQ(code_of([&] { read_image(folder_ / "text.png"); }), ExitCode::bad_scene);
}

TEST_F(ImageFile, textures_keep_their_own_numbers) {
  // Red, green, blue and a half clear white, which nothing multiplies.
  const unsigned char png[] = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00,
                               0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00,
                               0x00, 0x02, 0x08, 0x06, 0x00, 0x00, 0x00, 0x72, 0xb6, 0x0d, 0x24,
                               0x00, 0x00, 0x00, 0x13, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63,
                               0xf8, 0xcf, 0xc0, 0xf0, 0x1f, 0x0c, 0x81, 0x34, 0x08, 0x34, 0x00,
                               0x00, 0x49, 0x49, 0x09, 0x78, 0x28, 0xa0, 0xdb, 0x77, 0x00, 0x00,
                               0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  std::ofstream(folder_ / "a.png", std::ios::binary)
      .write(reinterpret_cast<const char*>(png), sizeof png);
  const TextureImage image = read_texture_image(folder_ / "a.png");
  EXPECT_EQ(image.width, 2u);
  EXPECT_EQ(image.height, 2u);
  EXPECT_EQ(image.channels, 4u);
  EXPECT_EQ(image.bits, 8u);
  const int expected[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128};
  ASSERT_EQ(image.texels->size(), 16u);
  for (size_t i = 0; i < 16; ++i)
    EXPECT_EQ(static_cast<int>(image.texels->data()[i]), expected[i]) << i;

  write_image(folder_ / "b.exr", ramp(), {}, {});
  const TextureImage floats = read_texture_image(folder_ / "b.exr");
  EXPECT_EQ(floats.channels, 3u);
  EXPECT_EQ(floats.bits, 32u);
  EXPECT_EQ(code_of([&] { read_texture_image(folder_ / "missing.png"); }), ExitCode::bad_scene);
}

TEST_F(ImageFile, files_in_memory_are_decoded_too) {
  write_image(folder_ / "a.png", ramp(), display_, {});
  std::ifstream file(folder_ / "a.png", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const TextureImage image = decode_texture_image("a", bytes);
  EXPECT_EQ(image.width, 16u);
  EXPECT_EQ(*image.texels, *read_texture_image(folder_ / "a.png").texels);
  std::string message;
  EXPECT_EQ(code_of([&] { decode_texture_image("box.glb", bytes.substr(0, 40)); }, &message),
            ExitCode::bad_scene);
  EXPECT_NE(message.find("box.glb"), std::string::npos) << message;
}

/// Hard to compress, and larger than what is sent of a picture at once.
Film large_picture() {
  Film film({0, 0, 700, 401});
  uint32_t state = 1;
  for (float& value : film.values()) {
    state = state * 1664525u + 1013904223u;
    value = static_cast<float>(state >> 24) / 256;
  }
  return film;
}

TEST_F(ImageFile, a_large_jpeg_is_the_same_however_it_is_read) {
  write_image(folder_ / "a.jpg", large_picture(), display_, {});
  const TextureImage image = read_texture_image(folder_ / "a.jpg");
  ASSERT_EQ(image.texels->size(), 700u * 401 * 3);
  const FloatImage floats = read_image(folder_ / "a.jpg");
  size_t different = 0;
  for (size_t i = 0; i < image.texels->size(); ++i)
    different +=
        std::lround(floats.values[i] * 255) != std::to_integer<int>(image.texels->data()[i]);
  EXPECT_EQ(different, 0u);
}

TEST_F(ImageFile, a_png_of_several_parts_is_one_picture) {
  write_image(folder_ / "a.png", large_picture(), display_, {});
  write_image(folder_ / "a.bmp", large_picture(), display_, {});
  // By OpenImageIO, and by ourselves.
  EXPECT_EQ(read_image(folder_ / "a.png").values, read_image(folder_ / "a.bmp").values);
  EXPECT_EQ(*read_texture_image(folder_ / "a.png").texels,
            *read_texture_image(folder_ / "a.bmp").texels);
}

TEST_F(ImageFile, a_jpeg_that_breaks_off_is_read_as_far_as_it_goes) {
  write_image(folder_ / "a.jpg", large_picture(), display_, {});
  std::ifstream file(folder_ / "a.jpg", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const TextureImage whole = decode_texture_image("a", bytes);
  EXPECT_EQ(whole.damage, "");
  for (const size_t part : {2, 3, 50}) {
    const std::string_view cut =
        std::string_view(bytes).substr(0, bytes.size() * (part - 1) / part);
    const TextureImage read = decode_texture_image("a", cut);
    EXPECT_EQ(read.damage, "Premature end of JPEG file") << part;
    ASSERT_EQ(read.texels->size(), whole.texels->size());
    const auto same = std::ranges::mismatch(*read.texels, *whole.texels).in1 - read.texels->begin();
    EXPECT_GT(same, static_cast<std::ptrdiff_t>(whole.texels->size() / part / 4)) << part;
    EXPECT_LT(same, static_cast<std::ptrdiff_t>(whole.texels->size())) << part;
  }
  const auto header = std::string_view(bytes).substr(0, 100);
  EXPECT_EQ(code_of([&] { decode_texture_image("a", header); }), ExitCode::bad_scene);
}

TEST_F(ImageFile, odd_data_of_a_jpeg_is_told_and_read) {
  write_image(folder_ / "a.jpg", large_picture(), display_, {});
  std::ifstream file(folder_ / "a.jpg", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const TextureImage whole = decode_texture_image("a", bytes);
  // Between the first segment after the file's own marker, which tells its length, and the next.
  const auto byte = [&](size_t at) { return static_cast<size_t>(static_cast<uint8_t>(bytes[at])); };
  bytes.insert(4 + 256 * byte(4) + byte(5), "stray");
  const TextureImage read = decode_texture_image("a", bytes);
  EXPECT_TRUE(read.damage.starts_with("Corrupt JPEG data: 5 extraneous bytes")) << read.damage;
  EXPECT_EQ(*read.texels, *whole.texels);
}

/// The process that decodes for this one, or 0.
pid_t codec_process() {
  const std::string self = std::to_string(getpid());
  std::ifstream children("/proc/self/task/" + self + "/children");
  pid_t child = 0;
  children >> child;
  return child;
}

TEST_F(ImageFile, the_codec_is_in_a_sandbox) {
  for (const char* name : {"a.png", "a.exr"}) {
    write_image(folder_ / name, ramp(), display_, {});
    EXPECT_EQ(read_image(folder_ / name).width, 16);
    std::ifstream status("/proc/" + std::to_string(codec_process()) + "/status");
    const std::string text{std::istreambuf_iterator<char>(status), {}};
    EXPECT_NE(text.find("\nNoNewPrivs:\t1\n"), std::string::npos) << text;
    EXPECT_NE(text.find("\nSeccomp:\t2\n"), std::string::npos) << text;
  }
}

TEST_F(ImageFile, the_codec_inherits_no_open_file) {
  std::ofstream(folder_ / "private") << "text";
  const int left_open = open((folder_ / "private").c_str(), O_RDONLY);
  ASSERT_GE(left_open, 0);
  if (const pid_t before = codec_process(); before > 0) kill(before, SIGKILL);
  write_image(folder_ / "a.png", ramp(), display_, {});
  EXPECT_EQ(read_image(folder_ / "a.png").width, 16);
  const fs::path files = "/proc/" + std::to_string(codec_process()) + "/fd";
  EXPECT_TRUE(fs::exists(files / "0"));
  for (const auto& file : fs::directory_iterator(files)) {
    EXPECT_NE(fs::read_symlink(file), folder_ / "private");
  }
  close(left_open);
}

TEST_F(ImageFile, the_content_tells_the_format_not_the_name) {
  write_image(folder_ / "a.tif", ramp(), display_, {});
  fs::rename(folder_ / "a.tif", folder_ / "a.mov");
  EXPECT_EQ(read_texture_image(folder_ / "a.mov").width, 16u);
  std::string message;
  std::ofstream(folder_ / "b.png") << "<?xml version=\"1.0\"?>\n<MPD></MPD>\n";
  EXPECT_EQ(code_of([&] { read_texture_image(folder_ / "b.png"); }, &message), ExitCode::bad_scene);
  EXPECT_NE(message.find("b.png: is an XML document"), std::string::npos) << message;
}

TEST_F(ImageFile, a_codec_that_is_killed_or_stopped_is_replaced) {
  prepare_to_write(folder_ / "a.png");
  prepare_to_write(folder_ / "a.png");
  for (const int signal : {SIGKILL, SIGSTOP, SIGTERM}) {
    const pid_t process = codec_process();
    ASSERT_GT(process, 0);
    ASSERT_EQ(kill(process, signal), 0);
    write_image(folder_ / "a.png", ramp(), display_, {});
    EXPECT_EQ(read_image(folder_ / "a.png").width, 16);
    EXPECT_NE(codec_process(), process);
  }
}

TEST_F(ImageFile, is_told_once_what_it_will_need) {
  // Far more often than its socket could hold.
  for (int i = 0; i < 2000; ++i) prepare_to_write(folder_ / "a.exr");
  write_image(folder_ / "a.exr", ramp(), display_, {});
  EXPECT_EQ(read_image(folder_ / "a.exr").width, 16);
}

TEST_F(ImageFile, what_we_write_ourselves_needs_no_codec) {
  const pid_t before = codec_process();
  prepare_to_write(folder_ / "a.pfm");
  write_image(folder_ / "a.pfm", ramp(), {}, {});
  EXPECT_EQ(codec_process(), before);
}

}  // namespace
}  // namespace tessera
