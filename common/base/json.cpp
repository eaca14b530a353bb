#include "common/base/json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"

namespace tessera {

namespace {
Place place_at(std::string_view text, std::string_view name, std::size_t offset) {
  offset = std::min(offset, text.size());
  const std::string_view before = text.substr(0, offset);
  const std::size_t newline = before.rfind('\n');
  return {.file = std::string(name),
          .line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')),
          .column = 1 + static_cast<int>(newline == std::string_view::npos ? offset
                                                                           : offset - newline - 1)};
}

/// Builds the document, and refuses doubled keys and deep nesting as soon as they come.
class Builder : public nlohmann::json_sax<Json> {
 public:
  Json document;
  std::string problem;
  std::size_t error_byte = 0;

  bool null() override { return value(nullptr); }
  bool boolean(bool flag) override { return value(flag); }
  bool number_integer(number_integer_t number) override { return value(number); }
  bool number_unsigned(number_unsigned_t number) override { return value(number); }
  bool number_float(number_float_t number, const string_t&) override { return value(number); }
  bool string(string_t& text) override { return value(std::move(text)); }
  bool binary(binary_t& bytes) override { return value(std::move(bytes)); }
  bool start_object(std::size_t) override { return enter(Json::object()); }
  bool key(string_t& name) override {
    const auto [member, fresh] = open_.back()->get_ref<Json::object_t&>().try_emplace(name);
    member_ = &member->second;
    if (!fresh) problem = fmt::format("the key \"{}\" stands twice in one object", excerpt(name));
    return fresh;
  }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override { return enter(Json::array()); }
  bool end_array() override { return leave(); }
  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::detail::exception&) override {
    error_byte = position == 0 ? 0 : position - 1;
    problem =
        token.empty() ? "not valid JSON" : fmt::format("not valid JSON at \"{}\"", excerpt(token));
    return false;
  }

 private:
  /// Where the next value stands.
  Json& place(Json next) {
    if (open_.empty()) return document = std::move(next);
    if (!open_.back()->is_array()) return *member_ = std::move(next);
    auto& elements = open_.back()->get_ref<Json::array_t&>();
    elements.push_back(std::move(next));
    return elements.back();
  }
  bool value(Json next) {
    place(std::move(next));
    return true;
  }
  bool enter(Json container) {
    if (open_.size() == static_cast<std::size_t>(limits::json_depth)) {
      problem = fmt::format("nested deeper than {} levels", limits::json_depth);
      return false;
    }
    open_.push_back(&place(std::move(container)));
    return true;
  }
  bool leave() {
    open_.pop_back();
    return true;
  }

  std::vector<Json*> open_;  ///< from the root to the innermost; what is open does not move
  Json* member_ = nullptr;   ///< of the innermost object: the value of the last key
};

/// A value as a message shows it; a container by its type alone, for it may be as long as the
/// document.
std::string shown(const Json& value) {
  constexpr std::size_t most = 40;
  return value.is_primitive() ? excerpt(value.dump(), most) : value.type_name();
}

/// Tells how far the parser has read, so that an error that is not the grammar's has a place too.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, std::size_t* count) : at_(at), count_(count) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    ++at_;
    ++*count_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  std::size_t* count_;
};
}  // namespace

Json parse_json(std::string_view text, std::string_view name) {
  Builder builder;
  std::size_t read = 0;
  const CountingIterator first(text.data(), &read);
  const CountingIterator last(text.data() + text.size(), &read);
  if (!Json::sax_parse(first, last, &builder)) {
    const std::size_t at =
        builder.error_byte != 0 ? builder.error_byte : (read == 0 ? 0 : read - 1);
    throw Error(ErrorKind::bad_input, builder.problem, place_at(text, name, at));
  }
  return std::move(builder.document);
}

ObjectReader::ObjectReader(const Json& json, std::string path)
    : json_(json), path_(std::move(path)) {
  if (!json.is_object())
    throw Error(ErrorKind::bad_input, fmt::format("expected an object, found {}", json.type_name()),
                {.key = path_});
}

std::string ObjectReader::path_of(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

void ObjectReader::fail(std::string_view key, const std::string& message) const {
  throw Error(ErrorKind::bad_input, message, {.key = path_of(key)});
}

bool ObjectReader::has(std::string_view key) const { return json_.contains(key); }

const Json* ObjectReader::optional(std::string_view key) {
  asked_.emplace_back(key);
  const auto found = json_.find(key);
  return found == json_.end() ? nullptr : &*found;
}

const Json& ObjectReader::required(std::string_view key) {
  const Json* found = optional(key);
  if (found == nullptr) fail(key, "is required, and is not there");
  return *found;
}

std::string ObjectReader::text(std::string_view key) {
  const Json& value = required(key);
  if (!value.is_string()) fail(key, fmt::format("expected a string, found {}", value.type_name()));
  return value.get<std::string>();
}

std::string ObjectReader::text_or(std::string_view key, std::string fallback) {
  if (optional(key) == nullptr) return fallback;
  return text(key);
}

bool ObjectReader::boolean_or(std::string_view key, bool fallback) {
  const Json* value = optional(key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean())
    fail(key, fmt::format("expected true or false, found {}", value->type_name()));
  return value->get<bool>();
}

std::int64_t ObjectReader::integer(std::string_view key, std::int64_t low, std::int64_t high) {
  const Json& value = required(key);
  const auto expected = [&] {
    return fmt::format("expected a whole number from {} to {}", low, high);
  };
  if (!value.is_number_integer()) fail(key, fmt::format("{}, found {}", expected(), shown(value)));
  const bool beyond = value.is_number_unsigned() &&
                      value.get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX);
  if (beyond || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high)
    fail(key, fmt::format("{}, found {}", expected(), shown(value)));
  return value.get<std::int64_t>();
}

std::int64_t ObjectReader::integer_or(std::string_view key, std::int64_t low, std::int64_t high,
                                      std::int64_t fallback) {
  return has(key) ? integer(key, low, high) : (optional(key), fallback);
}

double ObjectReader::number(std::string_view key, double low, double high) {
  const Json& value = required(key);
  if (!value.is_number()) fail(key, fmt::format("expected a number, found {}", value.type_name()));
  const double number = value.get<double>();
  if (!std::isfinite(number) || number < low || number > high)
    fail(key, fmt::format("expected a number from {} to {}, found {}", low, high, shown(value)));
  return number;
}

double ObjectReader::number_or(std::string_view key, double low, double high, double fallback) {
  return has(key) ? number(key, low, high) : (optional(key), fallback);
}

void ObjectReader::finish() const {
  for (const auto& [key, value] : json_.items()) {
    if (std::find(asked_.begin(), asked_.end(), key) != asked_.end()) continue;
    const std::vector<std::string_view> known(asked_.begin(), asked_.end());
    throw Error(ErrorKind::bad_input, unknown_name("key", key, known),
                {.key = path_of(excerpt(key))});
  }
}

}  // namespace tessera
