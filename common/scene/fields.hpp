#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/description.hpp"
#include "common/scene/document.hpp"

namespace tessera::scene {

/// Bounds on numbers that a scene may give. Beyond these lengths products of three leave single
/// precision, and surfaces are no longer found where they are.
constexpr double length_most = 1e12;
constexpr double length_least = 1e-8;
/// Of what gives a direction alone.
constexpr double direction_least = 1e-15;
constexpr double radiance_most = 1e30;

/// A value in a document: knows its place, and reads itself as what is expected or throws
/// Error{bad_input} there.
class Value {
 public:
  Value(const Document& document, std::uint32_t index) : document_(&document), index_(index) {}

  [[nodiscard]] Kind kind() const { return node().kind; }
  [[nodiscard]] const Node& node() const { return document_->node(index_); }
  [[nodiscard]] Place place() const { return document_->place(index_); }
  [[nodiscard]] Place place_of_lacking(std::string_view key) const {
    return document_->place_of_lacking(index_, key);
  }
  /// "expected EXPECTED, found …" at this place.
  [[noreturn]] void fail_expected(std::string_view expected) const;
  [[noreturn]] void fail(const std::string& message) const;

  [[nodiscard]] const std::string& text() const;
  [[nodiscard]] bool boolean() const;
  /// A whole number within [low, high]; 3.0 and 3e2 are none.
  [[nodiscard]] std::int64_t integer(std::int64_t low, std::int64_t high) const;
  [[nodiscard]] double number(double low, double high) const;
  [[nodiscard]] Vec3 vec3(double low, double high) const;
  [[nodiscard]] Vec3 point() const { return vec3(-length_most, length_most); }
  /// [r, g, b], or one number for all three.
  [[nodiscard]] Color color(double high) const;
  /// The items of a list; throws if this is none.
  [[nodiscard]] std::vector<Value> items(std::string_view expected = "a list") const;
  /// `count` numbers into `out`, without a list of values being made.
  void numbers(double* out, std::uint32_t count, double low, double high) const;

  struct Member;
  /// The members of an object in the order in which they stand; throws if this is none.
  [[nodiscard]] std::vector<Member> members() const;

 private:
  [[nodiscard]] std::string found() const;

  const Document* document_;
  std::uint32_t index_;
};

struct Value::Member {
  Value key;
  Value value;
};

/// Reads the members of one object by name, and then insists that there were no others.
class Fields {
 public:
  /// Throws if `object` is none.
  explicit Fields(const Value& object);

  [[nodiscard]] const Value& self() const { return object_; }
  [[nodiscard]] bool has(std::string_view key) const;
  std::optional<Value> optional(std::string_view key);
  Value required(std::string_view key);

  std::string text_or(std::string_view key, std::string fallback);
  bool boolean_or(std::string_view key, bool fallback);
  std::int64_t integer_or(std::string_view key, std::int64_t low, std::int64_t high,
                          std::int64_t fallback);
  double number_or(std::string_view key, double low, double high, double fallback);
  Color color_or(std::string_view key, double high, const Color& fallback);

  /// Throws at the first member that nothing above asked for; names the nearest that was.
  void finish() const;

 private:
  Value object_;
  std::vector<Value::Member> members_;
  std::vector<std::string_view> asked_;
};

}  // namespace tessera::scene
