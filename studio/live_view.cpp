#include "studio/live_view.h"

#include <algorithm>

namespace tessera {
namespace {

Time seconds(double value) {
  return std::chrono::duration_cast<Time>(std::chrono::duration<double>(value));
}

}  // namespace

void LiveView::set_goal(const ViewGoal& goal, Time now) {
  if (goal == goal_) return;
  const bool is_resized =
      goal_.width > 0 && (goal.width != goal_.width || goal.height != goal_.height);
  goal_ = goal;
  wanted_ = true;
  last_.reset();
  if (is_resized) not_before_ = now + kAfterResize;
}

void LiveView::set_look(const ViewLook& look, bool moving, Time now, bool is_asked_for) {
  if (moving) settled_at_ = now + kAfterMovement;
  if (look_ == look) return;
  const bool is_first = !look_;
  const bool is_new_scene = is_first || look_->scene_digest != look.scene_digest;
  look_ = look;
  wanted_ = true;
  last_.reset();
  // Only a changed text waits to be saved or asked for: the first picture, and other views of the
  // scene, come at once.
  if (mode_ != Mode::as_typed && is_new_scene && !is_first) waits_ = !is_asked_for;
  if (state_ == State::stopped || state_ == State::failed) state_ = State::done;
}

void LiveView::forget_look() {
  look_.reset();
  last_.reset();
  wanted_ = waits_ = false;
  state_ = State::empty;
}

void LiveView::refresh() {
  waits_ = false;
  if (state_ == State::paused || state_ == State::stopped || state_ == State::failed) {
    state_ = State::done;
    if (!last_) wanted_ = true;
  }
}

void LiveView::note_saved() {
  if (mode_ == Mode::on_save) waits_ = false;
}

void LiveView::pause() {
  if (look_ && state_ != State::failed) state_ = State::paused;
}

void LiveView::stop() {
  if (look_ && state_ != State::failed) state_ = State::stopped;
}

void LiveView::pass_done(uint32_t serial, double overhead, double trace) {
  if (!running_ || running_->serial != serial) return;
  ladder_.note(running_goal_, running_->pass, overhead, trace);
  if (!wanted_ && running_goal_ == goal_) last_ = running_->pass;
  running_.reset();
}

void LiveView::pass_failed(uint32_t serial) {
  if (!running_ || running_->serial != serial) return;
  running_.reset();
  last_.reset();
  if (!wanted_) state_ = State::failed;
}

LiveView::Start LiveView::begin(const ViewPass& pass, Time now) {
  const Start start{++*serial_, pass, !PassLadder::next(goal_, pass)};
  running_ = start;
  running_goal_ = goal_;
  expected_end_ = now + seconds(ladder_.expected_seconds(goal_, pass));
  state_ = State::tracing;
  return start;
}

LiveView::Orders LiveView::orders(Time now) {
  Orders orders;
  deadline_ = Time::max();
  const auto give_up = [&] {
    orders.interrupt = running_->serial;
    running_.reset();
  };
  if (state_ == State::paused || state_ == State::stopped) {
    if (running_) give_up();
    return orders;
  }
  if (!look_ && running_) give_up();
  if (!look_ || goal_.width <= 0 || goal_.height <= 0) return orders;
  if (wanted_ && !waits_) {
    if (now < not_before_) {
      deadline_ = not_before_;
      return orders;
    }
    // What ends soon may end: the newer scene follows it.
    const bool ends_soon = running_ && expected_end_ >= now &&
                           expected_end_ - now <= seconds(kSpareSeconds) && running_goal_ == goal_;
    if (running_ && ends_soon) {
      deadline_ = expected_end_ + std::chrono::milliseconds(1);
      return orders;
    }
    if (running_) give_up();
    wanted_ = false;
    orders.start = begin(ladder_.first(goal_), now);
    return orders;
  }
  if (running_ || !last_) {
    if (!running_ && state_ == State::tracing) state_ = State::done;
    return orders;
  }
  const auto next = PassLadder::next(goal_, *last_);
  if (!next) {
    state_ = State::done;
  } else if (now < settled_at_) {
    deadline_ = settled_at_;
  } else {
    orders.start = begin(*next, now);
  }
  return orders;
}

}  // namespace tessera
