#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/math/transform.h"
#include "scenes/edit/edit.h"

namespace tessera::edit {

using Triple = std::array<double, 3>;

/// The numbers of a camera as a text has them; what it lacks has its default.
struct WrittenCamera {
  Triple eye{}, target{}, up{0, 1, 0};
};

/// What is to be written for a pose: numbers between blanks; nothing where those in the text will
/// do.
struct CameraNumbers {
  std::optional<std::string> eye, target, up;
};

/// Frames are the same where neither axes nor eye (in lengths from eye to target, or of 1 if that
/// is more) are farther apart.
inline constexpr double kSameFrame = 1e-6;

inline Vec3 to_vec(const Triple& t) { return {t[0], t[1], t[2]}; }

/// `wanted` in short numbers, with those of `there` where they are near enough; `text`: the numbers
/// between blanks.
Triple shortened(const Triple& wanted, const Triple& there, double tolerance, std::string& text);

/// The shortest numbers with which the camera's frame stays the same. `has_up`: the language lets a
/// camera say it.
CameraNumbers camera_numbers(const CameraPose& pose, const WrittenCamera& there, bool has_up);

/// The frame, with axes at right angles, in which a camera at `frame` sees.
Affine seen_from(const Affine& frame);

/// The eye in the axes that `to_world` leads from, which can be inverted, in the shortest numbers
/// with which it stays where it is in the world; nothing where those in the text will do.
std::optional<std::string> written_eye(const CameraPose& pose, const Affine& to_world,
                                       const Triple& there);

/// Why no camera is made of the pose.
std::optional<Refusal> check_pose(const CameraPose& pose);

/// The camera that `name_of` calls so, without it by the entity's name, or, as of `--camera`, of
/// that number from 1; empty: the first. Nothing where the text has none.
std::optional<int> find_camera(const Outline& outline, std::string_view name,
                               std::string (*name_of)(const Entity&) = nullptr);

/// How far the two frames are apart, as above.
double frame_distance(const WrittenCamera& a, const WrittenCamera& b);

/// Three numbers between blanks; nothing where there are not three.
std::optional<Triple> read_triple(std::string_view text);

}  // namespace tessera::edit
