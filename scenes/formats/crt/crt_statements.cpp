#include <fmt/format.h>

#include <algorithm>

#include "scenes/formats/crt/crt_evaluator.h"
#include "scenes/formats/crt/crt_objects.h"

namespace tessera {
namespace {

using K = CrtKind;

constexpr int32_t kMaxSupersampling = 1024;  // a side of the grid: 2^20 samples a pixel
constexpr int32_t kMaxDofSamples = 1 << 20;
constexpr int32_t kMaxRecursion = 10000;
constexpr int32_t kMaxSide = 65536;

/// Of an attribute that the original lets be anything: below the least it is the least.
uint32_t count(CrtAttributes& in, std::string_view name, int32_t fallback, int32_t least,
               int32_t most) {
  const int32_t value = in.integer(name, fallback);
  if (value > most) in.wrong(*in.find(name), fmt::format("at most {}", most));
  return static_cast<uint32_t>(std::max(least, std::min(value, most)));
}

}  // namespace

void CrtEvaluator::run_top(const CrtSyntax& script) {
  bool has_settings = false, has_scene = false;
  for (const CrtSyntax* statement : script.children) {
    if (diagnostics_.is_full()) return;
    if (statement->kind == K::settings) {
      has_settings = true;
      run_settings(*statement);
    } else if (statement->kind == K::scene) {
      has_scene = true;
      run_scene(*statement);
    } else {
      if (has_scene)
        diagnostics_.warning(statement->span, "what comes after Scene has no effect on it");
      run_statement(*statement, nullptr);
    }
  }
  if (diagnostics_.has_errors()) return;
  const CrtSpan end{script.span.offset, 0};
  if (!has_settings) diagnostics_.error(end, "a script without Settings", "Settings { ... }");
  if (has_settings && !program_.camera)
    diagnostics_.error(end, "Settings without a camera", "camera -> Camera { ... }");
  if (!has_scene && has_settings)
    diagnostics_.error(end, "a script without Scene", "Scene { ... } at its end");
}

void CrtEvaluator::run_statement(const CrtSyntax& statement, Yields* yields) {
  if (diagnostics_.is_full()) throw CrtLimitError(statement.span, "", "");
  try {
    if (statement.kind == K::loop) return run_loop(statement, yields);
    if (statement.kind == K::branch) return run_branch(statement, yields);
    CrtValue value = evaluate(statement);
    if (statement.kind == K::assignment || holds<CrtNothing>(value)) return;
    if (!yields) {
      if (holds<CrtFailed>(value)) return;
      throw CrtError(statement.span, fmt::format("{} by itself", describe(value)),
                     "an assignment, Settings or Scene; entities stand in Scene");
    }
    heap_.charge(sizeof(Yield), statement.span);
    yields->push_back({value, statement.span});
  } catch (const CrtLimitError&) {
    throw;
  } catch (const CrtError& error) {
    diagnostics_.error(error);
    if (yields) yields->push_back({CrtFailed{}, statement.span});
  }
}

std::optional<bool> CrtEvaluator::condition(const CrtSyntax& expression) {
  const CrtValue value = evaluate(expression);
  if (holds<CrtFailed>(value)) return std::nullopt;
  if (holds<bool>(value)) return std::get<bool>(value);
  throw CrtError(expression.span, fmt::format("{} as a condition", describe(value)), "a boolean");
}

void CrtEvaluator::run_loop(const CrtSyntax& loop, Yields* yields) {
  check_depth(loop.span);
  const Raised deeper(depth_), inside(block_depth_);
  const Under under(makings_, {loop.span});
  for (uint64_t turn = 0; condition(*loop.children[0]).value_or(false); ++turn) {
    step(loop.span);
    if (turn == kMaxTurns)
      throw CrtLimitError(loop.span, "a loop without end",
                          fmt::format("at most {} turns", kMaxTurns));
    makings_.back() = {loop.span, static_cast<uint32_t>(turn + 1)};
    run_block(*loop.children[1], yields);
    if (diagnostics_.has_errors()) break;  // the next turn would only say the same
  }
}

void CrtEvaluator::run_branch(const CrtSyntax& branch, Yields* yields) {
  check_depth(branch.span);
  const Raised deeper(depth_);
  step(branch.span);
  const std::optional<bool> chosen = condition(*branch.children[0]);
  if (!chosen) return;
  if (*chosen) return run_block(*branch.children[1], yields);
  if (branch.children.size() < 3) return;
  const CrtSyntax& other = *branch.children[2];
  if (other.kind == K::branch) return run_branch(other, yields);
  run_block(other, yields);
}

void CrtEvaluator::run_settings(const CrtSyntax& settings) {
  CrtAttributes in("Settings", settings.span, attributes(settings), diagnostics_);
  v1::Metadata& metadata = program_.metadata;
  metadata.set_title(in.text("title", "Unnamed Scene"));
  metadata.set_author(in.text("author", "Unknown Author"));
  metadata.set_date(in.text("date", "Unknown Date"));
  metadata.set_notes(in.text("notes", ""));
  if (in.number("gamma", {}, 1) != 1)
    diagnostics_.warning(in.find("gamma")->name_span, "gamma has no effect, as in the original");
  program_.supersampling = count(in, "supersampling", 1, 1, kMaxSupersampling);
  program_.dof_samples = count(in, "dofsamples", 1, 1, kMaxDofSamples);
  program_.recursion_depth = count(in, "recursiondepth", 3, 0, kMaxRecursion);
  if (in.has("width")) program_.image.width = count(in, "width", 1, 1, kMaxSide);
  if (in.has("height")) program_.image.height = count(in, "height", 1, 1, kMaxSide);
  if (const auto* camera = in.thing<CrtCamera>("camera", "Camera { ... }", !program_.camera))
    program_.camera = camera;
  if (const auto* back = in.thing<CrtBackground>("background", "Background { ... }", false))
    program_.background = back;
  in.find("lights");
  for (const CrtAttribute& attribute : in.all()) {
    if (attribute.name != "lights") continue;
    if (const auto* light = std::get_if<const CrtLight*>(&attribute.value)) {
      program_.lights.push_back(*light);
    } else if (const auto* list = std::get_if<const CrtList*>(&attribute.value)) {
      for (const CrtValue& item : (*list)->items) {
        if (const auto* one = std::get_if<const CrtLight*>(&item))
          program_.lights.push_back(*one);
        else
          in.fail(attribute.value_span, fmt::format("{} among the lights", describe(item)),
                  "lights only");
      }
    } else {
      in.wrong(attribute, "a list of lights");
    }
  }
  in.finish();
}

void CrtEvaluator::run_scene(const CrtSyntax& scene) {
  Yields yields;
  for (const CrtSyntax* statement : scene.children) run_statement(*statement, &yields);
  for (const Yield& yield : yields) add_to_scene(yield);
}

void CrtEvaluator::add_to_scene(const Yield& yield) {
  std::vector<CrtValue> open{yield.value};
  while (!open.empty()) {
    const CrtValue value = open.back();
    open.pop_back();
    step(yield.where);
    if (holds<const CrtList*>(value)) {
      const std::vector<CrtValue>& items = std::get<const CrtList*>(value)->items;
      open.insert(open.end(), items.rbegin(), items.rend());
    } else if (const auto* entity = std::get_if<const CrtEntity*>(&value)) {
      leaves_ += (*entity)->leaves;
      if (leaves_ > kMaxEntities)
        throw CrtLimitError(yield.where, "too many entities in the scene",
                            fmt::format("at most {}", kMaxEntities));
      program_.entities.push_back(*entity);
    } else if (!holds<CrtFailed>(value)) {
      diagnostics_.warning(yield.where,
                           fmt::format("{} in Scene has no effect; {}", describe(value),
                                       holds<const CrtLight*>(value) ? "lights belong into Settings"
                                                                     : "only entities are seen"));
    }
  }
}

}  // namespace tessera
