#include "scenes/formats/crt/crt_operators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace tessera {
namespace {

using T = CrtToken;
/// Deeper ones would not fit into a scene message.
constexpr uint32_t kMaxNesting = 24;
constexpr uint32_t kMaxLeaves = 250'000;

/// Two's complement, as Java's int.
int32_t wrap(uint32_t bits) { return static_cast<int32_t>(bits); }

[[noreturn]] void fail(T token, const CrtValue& left, const CrtValue& right, CrtSpan where) {
  throw CrtError(
      where, fmt::format("{} between {} and {}", describe(token), describe(left), describe(right)),
      "operands that go together");
}

std::optional<CrtValue> of_integers(T token, int32_t a, int32_t b, CrtSpan where) {
  const auto ua = static_cast<uint32_t>(a), ub = static_cast<uint32_t>(b);
  switch (token) {
    case T::plus:
      return wrap(ua + ub);
    case T::minus:
      return wrap(ua - ub);
    case T::times:
      return wrap(ua * ub);
    case T::divide:
    case T::modulo:
      if (b == 0) throw CrtError(where, "an integer divided by 0", "a divisor other than 0");
      if (b == -1) return token == T::divide ? wrap(0 - ua) : 0;
      return token == T::divide ? a / b : a % b;
    default:
      return std::nullopt;
  }
}

std::optional<CrtValue> of_floats(T token, double a, double b) {
  switch (token) {
    case T::plus:
      return a + b;
    case T::minus:
      return a - b;
    case T::times:
      return a * b;
    case T::divide:
      return a / b;
    case T::modulo:
      return std::fmod(a, b);
    default:
      return std::nullopt;
  }
}

std::optional<bool> compare(T token, double a, double b) {
  switch (token) {
    case T::less:
      return a < b;
    case T::less_equal:
      return a <= b;
    case T::greater:
      return a > b;
    case T::greater_equal:
      return a >= b;
    default:
      return std::nullopt;
  }
}

std::optional<CrtValue> of_numbers(T token, const CrtValue& left, const CrtValue& right,
                                   CrtSpan where) {
  if (const auto order = compare(token, number_of(left), number_of(right))) return *order;
  if (holds<int32_t>(left) && holds<int32_t>(right))
    return of_integers(token, std::get<int32_t>(left), std::get<int32_t>(right), where);
  return of_floats(token, number_of(left), number_of(right));
}

std::string text_of(const CrtValue& value) {
  if (holds<const std::string*>(value)) return *std::get<const std::string*>(value);
  if (holds<bool>(value)) return std::get<bool>(value) ? "true" : "false";
  return number_text(value);
}

bool has_text(const CrtValue& value) {
  return is_number(value) || holds<bool>(value) || holds<const std::string*>(value);
}

const std::string* repeat(const std::string& text, int32_t times, CrtHeap& heap, CrtSpan where) {
  const auto count = static_cast<uint64_t>(std::max(times, 0));
  heap.charge(count * text.size(), where);
  std::string all;
  all.reserve(count * text.size());
  for (uint64_t i = 0; i < count && !text.empty(); ++i) all += text;
  return heap.text(std::move(all), where);
}

std::optional<CrtValue> of_texts(T token, const CrtValue& left, const CrtValue& right,
                                 CrtHeap& heap, CrtSpan where) {
  const auto* a = std::get_if<const std::string*>(&left);
  const auto* b = std::get_if<const std::string*>(&right);
  if (!a && !b) return std::nullopt;
  if (token == T::plus && has_text(left) && has_text(right))
    return heap.text(text_of(left) + text_of(right), where);
  if (token != T::times) return std::nullopt;
  if (a && holds<int32_t>(right)) return repeat(**a, std::get<int32_t>(right), heap, where);
  if (b && holds<int32_t>(left)) return repeat(**b, std::get<int32_t>(left), heap, where);
  return std::nullopt;
}

Vec3 divided(const Vec3& v, double by) { return v / by; }
Color divided(const Color& c, double by) { return {c.r / by, c.g / by, c.b / by}; }

/// Of vectors or of colours.
template <typename V>
std::optional<CrtValue> of_triples(T token, const CrtValue& left, const CrtValue& right) {
  const V* a = std::get_if<V>(&left);
  const V* b = std::get_if<V>(&right);
  if (a && b) {
    if (token == T::plus) return *a + *b;
    if (token == T::minus) return *a - *b;
    if constexpr (std::is_same_v<V, Color>)
      if (token == T::times) return *a * *b;
  }
  if (token == T::times && a && is_number(right)) return *a * number_of(right);
  if (token == T::times && b && is_number(left)) return *b * number_of(left);
  if (token == T::divide && a && is_number(right)) return divided(*a, number_of(right));
  return std::nullopt;
}

std::optional<CrtValue> of_lists(T token, const CrtValue& left, const CrtValue& right,
                                 CrtHeap& heap, CrtSpan where) {
  if (token != T::plus || !holds<const CrtList*>(left) || !holds<const CrtList*>(right))
    return std::nullopt;
  std::vector<CrtValue> items = std::get<const CrtList*>(left)->items;
  const std::vector<CrtValue>& more = std::get<const CrtList*>(right)->items;
  items.insert(items.end(), more.begin(), more.end());
  return heap.list(std::move(items), where);
}

/// Same type and same value. Lists are compared item by item; each costs memory as if it were made,
/// so that lists that share their parts cannot take forever.
bool equal(const CrtValue& a, const CrtValue& b, CrtHeap& heap, CrtSpan where, int depth = 0) {
  constexpr int kMaxListDepth = 100;
  if (a.index() != b.index()) return false;
  if (holds<const std::string*>(a))
    return *std::get<const std::string*>(a) == *std::get<const std::string*>(b);
  if (!holds<const CrtList*>(a)) return a == b;
  const CrtList& left = *std::get<const CrtList*>(a);
  const CrtList& right = *std::get<const CrtList*>(b);
  if (&left == &right) return true;
  if (left.items.size() != right.items.size()) return false;
  if (depth == kMaxListDepth)
    throw CrtLimitError(where, "lists nested too deep",
                        fmt::format("at most {} levels", kMaxListDepth));
  heap.charge(left.items.size() * sizeof(CrtValue), where);
  for (size_t i = 0; i < left.items.size(); ++i)
    if (!equal(left.items[i], right.items[i], heap, where, depth + 1)) return false;
  return true;
}

std::optional<v1::Csg::Operation> operation_of(T token) {
  if (token == T::plus) return v1::Csg::UNION;
  if (token == T::minus) return v1::Csg::DIFFERENCE;
  if (token == T::caret) return v1::Csg::INTERSECTION;
  return std::nullopt;
}

/// Whether the writer adds the operand's own operands to those of `operation`.
bool joins(v1::Csg::Operation operation, const CrtEntity& operand, bool is_left) {
  if (operand.kind != CrtEntity::Kind::set_operation || operand.modifiers.steps_size() > 0)
    return false;
  if (operation == v1::Csg::DIFFERENCE)
    return operand.operation == (is_left ? v1::Csg::DIFFERENCE : v1::Csg::UNION);
  return operand.operation == operation;
}

}  // namespace

CrtValue apply_unary(CrtToken token, const CrtValue& operand, CrtSpan where) {
  if (holds<CrtFailed>(operand)) return operand;
  if (token == T::not_sign) {
    if (holds<bool>(operand)) return !std::get<bool>(operand);
  } else if (is_number(operand) || holds<Vec3>(operand)) {
    if (token == T::plus) return operand;
    if (holds<int32_t>(operand)) return wrap(0 - static_cast<uint32_t>(std::get<int32_t>(operand)));
    if (holds<Vec3>(operand)) return -std::get<Vec3>(operand);
    return -std::get<double>(operand);
  }
  throw CrtError(where, fmt::format("{} before {}", describe(token), describe(operand)),
                 token == T::not_sign ? "a boolean" : "a number or a vector");
}

CrtValue apply_binary(CrtToken token, const CrtValue& left, const CrtValue& right, CrtHeap& heap,
                      CrtSpan where) {
  if (holds<CrtFailed>(left) || holds<CrtFailed>(right)) return CrtFailed{};
  if (token == T::equal) return equal(left, right, heap, where);
  if (token == T::not_equal) return !equal(left, right, heap, where);
  std::optional<CrtValue> result;
  if (is_number(left) && is_number(right)) result = of_numbers(token, left, right, where);
  if (!result) result = of_texts(token, left, right, heap, where);
  if (!result) result = of_triples<Vec3>(token, left, right);
  if (!result) result = of_triples<Color>(token, left, right);
  if (!result) result = of_lists(token, left, right, heap, where);
  if (result) return *result;
  const auto operation = operation_of(token);
  if (operation && holds<const CrtEntity*>(left) && holds<const CrtEntity*>(right))
    return set_operation(*operation, *std::get<const CrtEntity*>(left),
                         *std::get<const CrtEntity*>(right), heap, where);
  fail(token, left, right, where);
}

const CrtEntity* set_operation(v1::Csg::Operation operation, const CrtEntity& left,
                               const CrtEntity& right, CrtHeap& heap, CrtSpan where) {
  for (const CrtEntity* operand : {&left, &right})
    if (operand->kind == CrtEntity::Kind::include)
      throw CrtError(where, "a Mesh in a union, difference or intersection",
                     "solids that are not read from a file");
  const bool no_left = left.kind == CrtEntity::Kind::empty;
  const bool no_right = right.kind == CrtEntity::Kind::empty;
  if (no_right) return operation == v1::Csg::INTERSECTION ? &right : &left;
  if (no_left) return operation == v1::Csg::UNION ? &right : &left;
  CrtEntity made;
  made.kind = CrtEntity::Kind::set_operation;
  made.operation = operation;
  made.left = &left;
  made.right = &right;
  made.span = where;
  made.leaves = left.leaves + right.leaves;
  const auto level = [&](const CrtEntity& operand, bool is_left) {
    return joins(operation, operand, is_left) ? operand.nesting : operand.nesting + 1;
  };
  made.nesting = std::max(level(left, true), level(right, false));
  if (made.nesting > kMaxNesting)
    throw CrtError(where, "set operations nested too deep",
                   fmt::format("at most {} levels", kMaxNesting));
  if (made.leaves > kMaxLeaves)
    throw CrtLimitError(where, "an entity of too many parts",
                        fmt::format("at most {}", kMaxLeaves));
  return heap.add(std::move(made), where);
}

}  // namespace tessera
