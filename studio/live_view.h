#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/monotonic.h"
#include "studio/ladder.h"

namespace tessera {

/// What decides a view's pixels beside its size and samples: two views with equal looks show the
/// same picture.
struct ViewLook {
  std::string scene_digest;  ///< of the scene as it is read, in hexadecimal
  std::string settings;      ///< camera, frame and overrides, in a form that can be compared
  friend bool operator==(const ViewLook&, const ViewLook&) = default;
};

/// One pane of a page: which pass is traced for it, which comes next, when one is given up for a
/// newer scene. A state machine: instants come in as `now`, and what is to be done comes out as
/// values. Not thread-safe.
class LiveView {
 public:
  enum class Mode { as_typed, on_save, by_hand };
  enum class State { empty, tracing, done, paused, stopped, failed };
  /// A pass to be traced. Its number is new for each, and grows.
  struct Start {
    uint32_t serial = 0;
    ViewPass pass;
    bool is_last = false;
  };
  struct Orders {
    std::optional<uint32_t> interrupt{};  ///< the pass of that serial, which is of no use any more
    std::optional<Start> start{};
  };

  /// Serials count on from `serial`, which all views of a program share.
  explicit LiveView(std::shared_ptr<uint32_t> serial) : serial_(std::move(serial)) {}

  void set_mode(Mode mode) { mode_ = mode; }
  /// The size or number of samples that is wanted. A new size is waited with, as it may go on
  /// changing.
  void set_goal(const ViewGoal& goal, Time now);
  /// What is to be shown. `moving`: the camera is being moved, so that more changes will follow.
  /// `is_asked_for`: refresh() or note_saved() was called for this very look, before it was known.
  void set_look(const ViewLook& look, bool moving, Time now, bool is_asked_for = false);
  /// There is nothing to be shown until set_look() is called: another scene was not read yet.
  void forget_look();
  /// Renders what is to be shown, whatever the mode; goes on where it was stopped or paused.
  void refresh();
  /// The file was saved, which mode on_save waits for.
  void note_saved();
  void pause();
  void stop();

  /// A pass ended whole, after `overhead` seconds until its first tile and `trace` after that.
  void pass_done(uint32_t serial, double overhead, double trace);
  /// A pass could not be rendered.
  void pass_failed(uint32_t serial);

  /// What is due. To be called after each of the above, and at deadline().
  Orders orders(Time now);
  /// When orders() is to be called again even if nothing happens; Time::max(): never.
  Time deadline() const { return deadline_; }

  State state() const { return state_; }
  const ViewGoal& goal() const { return goal_; }
  /// The pass that is being traced; nothing where none is.
  const std::optional<Start>& running() const { return running_; }

  /// A pass that is expected to end within this is not given up for a newer scene, so that steady
  /// typing shows pictures.
  static constexpr double kSpareSeconds = 0.050;
  static constexpr Time kAfterResize = std::chrono::milliseconds(300);
  static constexpr Time kAfterMovement = std::chrono::milliseconds(150);

 private:
  Start begin(const ViewPass& pass, Time now);

  std::shared_ptr<uint32_t> serial_;
  PassLadder ladder_;
  Mode mode_ = Mode::as_typed;
  State state_ = State::empty;
  ViewGoal goal_;
  std::optional<ViewLook> look_;
  bool wanted_ = false;  ///< what is to be shown is not what is traced or was shown
  bool waits_ = false;   ///< for refresh() or note_saved()
  Time not_before_{};    ///< for a size that may go on changing
  Time settled_at_{};    ///< until then only first passes are traced
  std::optional<Start> running_;
  ViewGoal running_goal_;         ///< of that pass
  Time expected_end_{};           ///< of that pass
  std::optional<ViewPass> last_;  ///< that ended and is up to date
  Time deadline_ = Time::max();
};

}  // namespace tessera
