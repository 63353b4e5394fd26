#include "scenes/formats/crt/crt_evaluator.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "scenes/formats/crt/crt_objects.h"
#include "scenes/formats/crt/crt_operators.h"

namespace tessera {
namespace {

using K = CrtKind;
using T = CrtToken;

constexpr std::string_view kTime = "t";

/// A call by name looks its name up among macros and functions, so the name is no operand.
bool leans_left(const CrtSyntax& node) {
  if (node.kind == K::call) return node.children[0]->kind != K::identifier;
  return node.kind == K::binary || node.kind == K::index || node.kind == K::modifiers;
}

}  // namespace

CrtEvaluator::CrtEvaluator(CrtHeap& heap, CrtDiagnostics& diagnostics, bool keep_origins)
    : heap_(heap), diagnostics_(diagnostics), keeps_origins_(keep_origins) {}

CrtProgram CrtEvaluator::run(const CrtSyntax& script, int32_t time) {
  scope_ = open_scope(nullptr);
  scope_->ends_assignment = true;
  scope_->variables[kTime] = {time, {}};
  try {
    run_top(script);
  } catch (const CrtLimitError& error) {
    diagnostics_.error(error);
  }
  return std::move(program_);
}

CrtValue CrtEvaluator::note_made(CrtValue value, CrtSpan where) {
  const auto* entity = std::get_if<const CrtEntity*>(&value);
  if (!keeps_origins_ || !entity) return value;
  const auto [made, is_new] = program_.made.try_emplace(*entity);
  if (!is_new) return value;
  uint32_t in = 0;
  for (Making& making : makings_) {
    if (making.number == 0) {
      program_.makings.push_back({making.where, making.turn, in});
      making.number = static_cast<uint32_t>(program_.makings.size());
    }
    in = making.number;
  }
  made->second = {where, in};
  return value;
}

void CrtEvaluator::step(CrtSpan where) {
  if (++steps_ > kMaxSteps)
    throw CrtLimitError(where, "the script runs too long",
                        fmt::format("at most {} steps", kMaxSteps));
}

// ------------------------------------------------------------------------------------ expressions

void CrtEvaluator::check_depth(CrtSpan where) const {
  if (depth_ >= kMaxDepth)
    throw CrtLimitError(where, "expressions nested too deep",
                        fmt::format("at most {} levels", kMaxDepth));
}

CrtValue CrtEvaluator::evaluate(const CrtSyntax& expression) {
  check_depth(expression.span);
  const Raised deeper(depth_);
  // Chains like a + b + c lean to the left and are as long as the author likes: they are walked.
  if (!leans_left(expression)) return evaluate_leaf(expression);
  std::vector<const CrtSyntax*> chain;
  const CrtSyntax* at = &expression;
  for (; leans_left(*at); at = at->children[0]) chain.push_back(at);
  CrtValue value = evaluate_leaf(*at);
  for (; !chain.empty(); chain.pop_back()) value = apply(*chain.back(), value);
  return value;
}

CrtValue CrtEvaluator::evaluate_leaf(const CrtSyntax& expression) {
  step(expression.span);
  switch (expression.kind) {
    case K::identifier:
      return variable(expression);
    case K::list:
      return list(expression);
    case K::object:
      return object(expression);
    case K::group:
      return group(expression);
    case K::macro: {
      for (CrtScope* scope = scope_; scope; scope = scope->parent) scope->captured = true;
      return heap_.add(CrtMacro{&expression, scope_}, expression.span);
    }
    case K::call:
      return call_by_name(expression);
    case K::unary:
      return apply_unary(expression.token, evaluate(*expression.children[0]), expression.span);
    case K::ternary:
      return ternary(expression);
    case K::assignment:
      return assign(expression);
    default:
      return literal(expression);
  }
}

CrtValue CrtEvaluator::apply(const CrtSyntax& node, const CrtValue& left) {
  step(node.span);
  switch (node.kind) {
    case K::index:
      return index(node, left);
    case K::modifiers:
      return modify(node, left);
    case K::call: {
      std::vector<CrtValue> values = arguments(node);
      if (holds<CrtFailed>(left)) return left;
      if (holds<const CrtMacro*>(left))
        return call(*std::get<const CrtMacro*>(left), std::move(values), node.span);
      throw CrtError(
          node.span, fmt::format("{} is called", describe(left)),
          "a macro or a function (a line that begins with '(' continues the one before)");
    }
    default:
      if (node.token == T::and_sign || node.token == T::or_sign) return logical(node, left);
      return note_made(
          apply_binary(node.token, left, evaluate(*node.children[1]), heap_, node.span), node.span);
  }
}

CrtValue CrtEvaluator::literal(const CrtSyntax& expression) {
  const std::string_view text = expression.text;
  if (expression.kind == K::text) return heap_.text(unescape_crt(text), expression.span);
  if (expression.kind == K::boolean) return expression.token == T::keyword_true;
  if (expression.kind == K::integer) {
    int32_t value = 0;
    if (std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc())
      return value;
    throw CrtError(expression.span, "an integer that is too large",
                   "at most 2147483647, or a float (with a point)");
  }
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec == std::errc()) return value;
  throw CrtError(expression.span, "a number that is too large or too small", "a finite float");
}

CrtValue CrtEvaluator::list(const CrtSyntax& expression) {
  std::vector<CrtValue> items;
  items.reserve(expression.children.size());
  for (const CrtSyntax* child : expression.children) {
    items.push_back(evaluate(*child));
    if (holds<CrtFailed>(items.back())) return CrtFailed{};
  }
  return heap_.list(std::move(items), expression.span);
}

CrtValue CrtEvaluator::ternary(const CrtSyntax& expression) {
  const CrtValue condition = evaluate(*expression.children[0]);
  if (holds<CrtFailed>(condition)) return condition;
  if (!holds<bool>(condition))
    throw CrtError(expression.children[0]->span, fmt::format("{} before '?'", describe(condition)),
                   "a boolean");
  const bool yes = std::get<bool>(condition);
  if (in_block()) return evaluate(*expression.children[yes ? 1 : 2]);
  const CrtValue first = evaluate(*expression.children[1]);
  const CrtValue second = evaluate(*expression.children[2]);
  return yes ? first : second;
}

CrtValue CrtEvaluator::logical(const CrtSyntax& node, const CrtValue& left) {
  const auto checked = [&](const CrtValue& value) {
    if (!holds<bool>(value))
      throw CrtError(node.span, fmt::format("{} beside {}", describe(value), describe(node.token)),
                     "a boolean");
    return std::get<bool>(value);
  };
  if (holds<CrtFailed>(left)) return left;
  const bool is_or = node.token == T::or_sign;
  const bool decided = checked(left) == is_or;
  if (decided && in_block()) return is_or;
  const CrtValue right = evaluate(*node.children[1]);
  if (holds<CrtFailed>(right)) return right;
  return is_or ? checked(left) || checked(right) : checked(left) && checked(right);
}

CrtValue CrtEvaluator::index(const CrtSyntax& node, const CrtValue& left) {
  const CrtValue at = evaluate(*node.children[1]);
  if (holds<CrtFailed>(left) || holds<CrtFailed>(at)) return CrtFailed{};
  const std::optional<int32_t> whole = whole_number(at);
  if (!whole)
    throw CrtError(node.children[1]->span, fmt::format("{} as an index", describe(at)),
                   "an integer");
  const int32_t i = *whole;
  int32_t size = 3;
  if (holds<const CrtList*>(left))
    size = static_cast<int32_t>(std::get<const CrtList*>(left)->items.size());
  else if (!holds<Vec3>(left) && !holds<Color>(left))
    throw CrtError(node.span, fmt::format("an index into {}", describe(left)),
                   "a list, a vector or a colour (a line that begins with '[' continues the one "
                   "before)");
  if (i < 0 || i >= size)
    throw CrtError(node.children[1]->span, fmt::format("the index {}", i),
                   size == 0 ? "a list that is not empty" : fmt::format("0 to {}", size - 1));
  if (holds<Vec3>(left)) return std::get<Vec3>(left)[i];
  if (const Color* color = std::get_if<Color>(&left))
    return i == 0 ? color->r : i == 1 ? color->g : color->b;
  return std::get<const CrtList*>(left)->items[static_cast<size_t>(i)];
}

std::vector<CrtAttribute> CrtEvaluator::attributes(const CrtSyntax& expression) {
  std::vector<CrtAttribute> values;
  for (const CrtSyntax* attribute : expression.children) {
    const CrtSyntax& value = *attribute->children[0];
    CrtAttribute& added = values.emplace_back(
        CrtAttribute{attribute->text, attribute->span, value.span, CrtFailed{}});
    try {
      added.value = evaluate(value);
    } catch (const CrtLimitError&) {
      throw;
    } catch (const CrtError& error) {
      diagnostics_.error(error);
    }
  }
  return values;
}

CrtValue CrtEvaluator::object(const CrtSyntax& expression) {
  CrtAttributes values(expression.text, expression.span, attributes(expression), diagnostics_);
  if (is_crt_object(expression.text))
    return note_made(make_crt_object(expression.text, values, heap_), expression.span);
  const std::vector<std::string> names = crt_object_names();
  throw CrtError(
      expression.span, fmt::format("unknown object '{}'", expression.text),
      fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(expression.text, names)));
}

CrtValue CrtEvaluator::group(const CrtSyntax& expression) {
  Yields parts;
  for (const CrtSyntax* child : expression.children) run_statement(*child, &parts);
  const v1::Csg::Operation operation = expression.text == "Union"        ? v1::Csg::UNION
                                       : expression.text == "Difference" ? v1::Csg::DIFFERENCE
                                                                         : v1::Csg::INTERSECTION;
  CrtValue whole;
  // Lists count item by item; later items come first off the stack.
  std::vector<Yield> open(parts.rbegin(), parts.rend());
  while (!open.empty()) {
    const Yield part = open.back();
    open.pop_back();
    step(part.where);
    if (holds<CrtFailed>(part.value)) return CrtFailed{};
    if (holds<const CrtList*>(part.value)) {
      const std::vector<CrtValue>& items = std::get<const CrtList*>(part.value)->items;
      for (auto item = items.rbegin(); item != items.rend(); ++item)
        open.push_back({*item, part.where});
      continue;
    }
    const auto* entity = std::get_if<const CrtEntity*>(&part.value);
    if (!entity)
      throw CrtError(part.where, fmt::format("{} in {}", describe(part.value), expression.text),
                     "entities");
    if (holds<CrtNothing>(whole))
      whole = *entity;
    else
      whole =
          set_operation(operation, *std::get<const CrtEntity*>(whole), **entity, heap_, part.where);
  }
  if (holds<CrtNothing>(whole))
    throw CrtError(expression.span, fmt::format("{} of nothing", expression.text), "entities");
  return note_made(whole, expression.span);
}

}  // namespace tessera
