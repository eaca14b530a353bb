#include "common/scene/fields.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::scene {

std::string Value::found() const {
  const Node& at = node();
  switch (at.kind) {
    case Kind::boolean:
      return at.boolean ? "true" : "false";
    case Kind::integer:
      return fmt::format("{}", at.integer);
    case Kind::number:
      return fmt::format("{}", at.number);
    case Kind::text:
      return fmt::format("\"{}\"", document_->string(at).substr(0, 64));
    case Kind::array:
      return fmt::format("a list of {}", at.count);
    default:
      return std::string(name_of(at.kind));
  }
}

void Value::fail(const std::string& message) const {
  throw Error(ErrorKind::bad_input, message, place());
}

void Value::fail_expected(std::string_view expected) const {
  fail(fmt::format("expected {}, found {}", expected, found()));
}

const std::string& Value::text() const {
  if (kind() != Kind::text) fail_expected("a string");
  return document_->string(node());
}

bool Value::boolean() const {
  if (kind() != Kind::boolean) fail_expected("true or false");
  return node().boolean;
}

std::int64_t Value::integer(std::int64_t low, std::int64_t high) const {
  if (kind() != Kind::integer || node().integer < low || node().integer > high)
    fail_expected(fmt::format("a whole number from {} to {}", low, high));
  return node().integer;
}

double Value::number(double low, double high) const {
  const Node& at = node();
  const double value = at.kind == Kind::integer  ? static_cast<double>(at.integer)
                       : at.kind == Kind::number ? at.number
                                                 : std::numeric_limits<double>::quiet_NaN();
  if (!(value >= low && value <= high))
    fail_expected(fmt::format("a number from {} to {}", low, high));
  return value;
}

void Value::numbers(double* out, std::uint32_t count, double low, double high) const {
  if (kind() != Kind::array || node().count != count)
    fail_expected(fmt::format("a list of {} numbers", count));
  for (std::uint32_t i = 0; i < count; ++i) {
    const Value item(*document_, index_ + 1 + i);
    // A list among the items would shift those behind it: number() refuses it before that matters.
    out[i] = item.number(low, high);
  }
}

Vec3 Value::vec3(double low, double high) const {
  Vec3 out;
  numbers(out.data(), 3, low, high);
  return out;
}

Color Value::color(double high) const {
  if (kind() == Kind::array) return vec3(0, high);
  if (kind() != Kind::integer && kind() != Kind::number)
    fail_expected("a colour: [red, green, blue], or one number for all three");
  const double gray = number(0, high);
  return {gray, gray, gray};
}

std::vector<Value> Value::items(std::string_view expected) const {
  if (kind() != Kind::array) fail_expected(expected);
  std::vector<Value> out;
  out.reserve(node().count);
  for (std::uint32_t at = index_ + 1; at < node().end; at = document_->node(at).end)
    out.emplace_back(*document_, at);
  return out;
}

std::vector<Value::Member> Value::members() const {
  if (kind() != Kind::object) fail_expected("an object");
  std::vector<Member> out;
  out.reserve(node().count);
  for (std::uint32_t at = index_ + 1; at < node().end; at = document_->node(at + 1).end)
    out.push_back({Value(*document_, at), Value(*document_, at + 1)});
  return out;
}

Fields::Fields(const Value& object) : object_(object), members_(object.members()) {}

bool Fields::has(std::string_view key) const {
  return std::any_of(members_.begin(), members_.end(),
                     [&](const auto& member) { return member.key.text() == key; });
}

std::optional<Value> Fields::optional(std::string_view key) {
  asked_.push_back(key);
  for (const Value::Member& member : members_)
    if (member.key.text() == key) return member.value;
  return std::nullopt;
}

Value Fields::required(std::string_view key) {
  if (const auto found = optional(key)) return *found;
  throw Error(ErrorKind::bad_input, "is required, and is not there", object_.place_of_lacking(key));
}

std::string Fields::text_or(std::string_view key, std::string fallback) {
  const auto value = optional(key);
  return value ? value->text() : fallback;
}
bool Fields::boolean_or(std::string_view key, bool fallback) {
  const auto value = optional(key);
  return value ? value->boolean() : fallback;
}
std::int64_t Fields::integer_or(std::string_view key, std::int64_t low, std::int64_t high,
                                std::int64_t fallback) {
  const auto value = optional(key);
  return value ? value->integer(low, high) : fallback;
}
double Fields::number_or(std::string_view key, double low, double high, double fallback) {
  const auto value = optional(key);
  return value ? value->number(low, high) : fallback;
}
Color Fields::color_or(std::string_view key, double high, const Color& fallback) {
  const auto value = optional(key);
  return value ? value->color(high) : fallback;
}

void Fields::finish() const {
  for (const Value::Member& member : members_) {
    const std::string& key = member.key.text();
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
      member.key.fail(unknown_name("key", key, asked_));
  }
}

}  // namespace tessera::scene
