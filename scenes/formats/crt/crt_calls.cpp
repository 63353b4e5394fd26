#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/plural.h"
#include "scenes/formats/crt/crt_evaluator.h"
#include "scenes/formats/crt/crt_objects.h"

namespace tessera {

// -------------------------------------------------------------------------------------- variables

CrtScope* CrtEvaluator::open_scope(CrtScope* parent) {
  if (free_scopes_.empty()) {
    heap_.charge(sizeof(CrtScope), {});
    free_scopes_.push_back(&scopes_.emplace_back());
  }
  CrtScope* scope = free_scopes_.back();
  free_scopes_.pop_back();
  scope->parent = parent;
  return scope;
}

void CrtEvaluator::close_scope(CrtScope* scope) {
  if (scope->captured) return;
  scope->variables.clear();
  scope->ends_assignment = false;
  free_scopes_.push_back(scope);
}

CrtScope::Variable* CrtEvaluator::find(std::string_view name) {
  for (CrtScope* scope = scope_; scope; scope = scope->parent) {
    auto found = scope->variables.find(name);
    if (found == scope->variables.end()) continue;
    // An alias is made outside of blocks, of a variable that is there; assigning to either makes it
    // a variable again, so that there is no way round in a circle.
    while (!found->second.alias.empty())
      found = scopes_.front().variables.find(found->second.alias);
    return &found->second;
  }
  return nullptr;
}

CrtValue CrtEvaluator::variable(const CrtSyntax& identifier) {
  if (identifier.text == "t") program_.uses_time = true;
  if (const CrtScope::Variable* found = find(identifier.text)) return found->value;
  std::vector<std::string> known;
  for (const CrtScope* scope = scope_; scope; scope = scope->parent)
    for (const auto& [name, value] : scope->variables) known.emplace_back(name);
  std::sort(known.begin(), known.end());
  const bool is_function = CrtFunctions::has(identifier.text);
  throw CrtError(identifier.span, fmt::format("unknown variable '{}'", identifier.text),
                 is_function
                     ? "'(' after the name of a function"
                     : "a variable that was assigned before" + suggestion(identifier.text, known));
}

void CrtEvaluator::name_thing(const CrtValue& value, std::string_view name) {
  const auto keep = [&](const void* thing) { program_.names.try_emplace(thing, name); };
  if (const auto* entity = std::get_if<const CrtEntity*>(&value)) keep(*entity);
  if (const auto* light = std::get_if<const CrtLight*>(&value)) keep(*light);
  if (const auto* material = std::get_if<const CrtMaterial*>(&value)) keep(*material);
  if (const auto* camera = std::get_if<const CrtCamera*>(&value)) keep(*camera);
  if (const auto* texture = std::get_if<const CrtTexture*>(&value)) keep(*texture);
}

CrtValue CrtEvaluator::assign(const CrtSyntax& node) {
  const std::string_view name = node.children[0]->text;
  const CrtSyntax& source = *node.children[1];
  CrtScope* owner = scope_;
  while (!owner->variables.contains(name) && !owner->ends_assignment) owner = owner->parent;
  const bool is_new = !owner->variables.contains(name);
  if (is_new) {
    owner = scope_;
    heap_.charge(64, node.span);
  }
  CrtValue value = CrtFailed{};
  try {
    value = evaluate(source);
    if (holds<CrtNothing>(value))
      throw CrtError(source.span, "a macro that gives nothing", "a value");
  } catch (const CrtLimitError&) {
    throw;
  } catch (const CrtError& error) {
    diagnostics_.error(error);
  }
  const bool is_alias =
      is_new && source.kind == CrtKind::identifier && !in_block() && !holds<CrtFailed>(value);
  owner->variables[name] = {value, is_alias ? source.text : std::string_view{}};
  name_thing(value, name);
  return value;
}

// ------------------------------------------------------------------------------------------ calls

std::vector<CrtValue> CrtEvaluator::arguments(const CrtSyntax& node) {
  std::vector<CrtValue> values;
  values.reserve(node.children.size() - 1);
  for (size_t i = 1; i < node.children.size(); ++i) values.push_back(evaluate(*node.children[i]));
  return values;
}

CrtValue CrtEvaluator::call_by_name(const CrtSyntax& node) {
  const CrtSyntax& callee = *node.children[0];
  const CrtScope::Variable* found = find(callee.text);
  const CrtValue target = found ? found->value : CrtValue{};
  std::vector<CrtValue> values = arguments(node);
  if (holds<const CrtMacro*>(target))
    return call(*std::get<const CrtMacro*>(target), std::move(values), node.span);
  // Functions have names of their own: a variable may be called sin.
  if (CrtFunctions::has(callee.text)) return functions_.call(callee.text, values, node.span);
  if (found && holds<CrtFailed>(target)) return CrtFailed{};
  if (found)
    throw CrtError(node.span, fmt::format("'{}' is {}", callee.text, type_name(target)),
                   "a macro or a function before '(' (a line that begins with '(' continues the "
                   "one before)");
  std::vector<std::string> names = CrtFunctions::names();
  for (const CrtScope* scope = scope_; scope; scope = scope->parent)
    for (const auto& [name, variable] : scope->variables)
      if (holds<const CrtMacro*>(variable.value)) names.emplace_back(name);
  std::sort(names.begin(), names.end());
  throw CrtError(node.span, fmt::format("unknown function '{}'", callee.text),
                 "a macro or one of the functions" + suggestion(callee.text, names));
}

/// Enters a macro: its scope, and the count of calls inside each other.
class CrtEvaluator::OpenScope {
 public:
  OpenScope(CrtEvaluator& evaluator, CrtScope* parent)
      : evaluator_(evaluator), before_(evaluator.scope_) {
    evaluator.scope_ = evaluator.open_scope(parent);
    ++evaluator.block_depth_;
  }
  ~OpenScope() {
    evaluator_.close_scope(evaluator_.scope_);
    evaluator_.scope_ = before_;
    --evaluator_.block_depth_;
  }
  OpenScope(const OpenScope&) = delete;
  OpenScope& operator=(const OpenScope&) = delete;

 private:
  CrtEvaluator& evaluator_;
  CrtScope* before_;
};

CrtValue CrtEvaluator::call(const CrtMacro& macro, std::vector<CrtValue> values, CrtSpan where) {
  const std::vector<const CrtSyntax*>& parts = macro.syntax->children;
  const size_t parameters = parts.size() - 1;
  if (values.size() != parameters)
    throw CrtError(where, fmt::format("a macro called with {}", counted(values.size(), "argument")),
                   fmt::format("{}", parameters));
  if (calls_ >= kMaxCalls)
    throw CrtLimitError(where, "macros call each other too deep",
                        fmt::format("at most {} calls inside each other", kMaxCalls));
  const Raised deeper(calls_);
  Yields yields;
  {
    const OpenScope inside(*this, macro.scope);
    const Under under(makings_, {where});
    scope_->ends_assignment = true;
    for (size_t i = 0; i < parameters; ++i) scope_->variables[parts[i]->text] = {values[i], {}};
    for (const CrtSyntax* statement : parts.back()->children) run_statement(*statement, &yields);
  }
  if (yields.empty()) return CrtNothing{};
  if (yields.size() == 1) return yields.front().value;
  std::vector<CrtValue> all;
  for (const Yield& yield : yields) {
    if (holds<CrtFailed>(yield.value)) return CrtFailed{};
    all.push_back(yield.value);
  }
  return heap_.list(std::move(all), where);
}

// -------------------------------------------------------------------------------------- modifiers

void CrtEvaluator::add_modifier(const CrtSyntax& modifier, v1::Transform& to, bool& failed) {
  const CrtValue value = evaluate(*modifier.children[0]);
  const CrtSpan where = modifier.children[0]->span;
  if (holds<CrtFailed>(value)) {
    failed = true;
    return;
  }
  const bool is_scale = modifier.token == CrtToken::keyword_scale;
  Vec3 by;
  if (is_scale && is_number(value))
    by = Vec3{1, 1, 1} * number_of(value);
  else if (holds<Vec3>(value))
    by = std::get<Vec3>(value);
  else
    throw CrtError(where, fmt::format("{} {}", modifier.text, describe(value)),
                   is_scale ? "a number or a vector" : "a vector");
  if (!std::isfinite(by.x) || !std::isfinite(by.y) || !std::isfinite(by.z))
    throw CrtError(where, fmt::format("{} by what is not finite", modifier.text), "finite numbers");
  if (is_scale && (by.x == 0 || by.y == 0 || by.z == 0))
    throw CrtError(where, "scale by 0", "numbers other than 0");
  if (is_scale) {
    put(by, to.add_steps()->mutable_scale());
  } else if (modifier.token == CrtToken::keyword_translate) {
    put(by, to.add_steps()->mutable_translate());
  } else {
    for (int axis = 0; axis < 3; ++axis) {
      if (by[axis] == 0) continue;
      v1::AxisAngle& turn = *to.add_steps()->mutable_rotate();
      put(Vec3{axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0},
          turn.mutable_axis());
      turn.set_angle(by[axis]);
    }
  }
}

CrtValue CrtEvaluator::modify(const CrtSyntax& node, const CrtValue& left) {
  v1::Transform modifiers;  // in the order of the script: the first is the innermost
  bool failed = holds<CrtFailed>(left);
  for (size_t i = 1; i < node.children.size(); ++i)
    add_modifier(*node.children[i], modifiers, failed);
  if (failed) return CrtFailed{};
  v1::Transform reversed;
  for (int i = modifiers.steps_size(); i-- > 0;) *reversed.add_steps() = modifiers.steps(i);
  return modified(left, reversed, node.span);
}

CrtValue CrtEvaluator::modified(const CrtValue& value, const v1::Transform& modifiers,
                                CrtSpan where) {
  check_depth(where);
  const Raised deeper(depth_);
  step(where);
  if (holds<const CrtList*>(value)) {
    std::vector<CrtValue> items;
    for (const CrtValue& item : std::get<const CrtList*>(value)->items)
      items.push_back(modified(item, modifiers, where));
    return heap_.list(std::move(items), where);
  }
  const auto* entity = std::get_if<const CrtEntity*>(&value);
  if (!entity) throw CrtError(where, fmt::format("modifiers on {}", describe(value)), "an entity");
  constexpr int kMostModifiers = 1000;
  if ((*entity)->modifiers.steps_size() + modifiers.steps_size() > kMostModifiers)
    throw CrtLimitError(where, "too many modifiers on one entity",
                        fmt::format("at most {}", kMostModifiers));
  CrtEntity made = **entity;
  made.modifiers = modifiers;
  made.modifiers.MergeFrom((*entity)->modifiers);
  heap_.charge(static_cast<uint64_t>(made.modifiers.steps_size()) * 100, where);
  const CrtEntity* added = heap_.add(std::move(made), where);
  if (const auto known = program_.made.find(*entity); known != program_.made.end()) {
    const CrtProgram::Made origin = known->second;
    program_.made.emplace(added, origin);
  }
  return added;
}

// --------------------------------------------------------------------------------------- branches

void CrtEvaluator::run_block(const CrtSyntax& block, Yields* yields) {
  const OpenScope inside(*this, scope_);
  for (const CrtSyntax* statement : block.children) run_statement(*statement, yields);
}

}  // namespace tessera
