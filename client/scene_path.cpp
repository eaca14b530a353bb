#include "client/scene_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace {

constexpr std::string_view joints = ".[";

std::string_view kind_of(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list";
  if (value.is_string()) return "a string";
  if (value.is_number()) return "a number";
  return value.is_null() ? "null" : "true or false";
}

/// One step after the other along a path.
class Walk {
 public:
  Walk(Json& scene, std::string_view path) : at_(&scene), path_(path) {}

  Json& to_the_end() {
    while (done_ < path_.size()) {
      if (path_[done_] == '[')
        take_index();
      else
        take_key();
    }
    return *at_;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(ErrorKind::bad_input, message, {.file = {}, .key = excerpt(path_, 200)});
  }
  [[nodiscard]] std::string here() const {
    return done_ == 0 ? "the scene" : excerpt(path_.substr(0, done_), 200);
  }

  void take_index() {
    const std::size_t close = path_.find(']', done_);
    std::size_t index = 0;
    const char* const last = path_.data() + std::min(close, path_.size());
    const auto [end, error] = std::from_chars(path_.data() + done_ + 1, last, index);
    if (close == std::string_view::npos || error != std::errc() || end != last)
      fail(fmt::format("expected an index such as [0] behind {}", here()));
    if (!at_->is_array()) fail(fmt::format("{} is {} and has no items", here(), kind_of(*at_)));
    if (index >= at_->size())
      fail(fmt::format("{} has {} items, the first is [0]", here(), at_->size()));
    at_ = &(*at_)[index];
    done_ = close + 1;
  }

  void take_key() {
    if (done_ > 0 && path_[done_] != '.')
      fail(fmt::format("expected a dot or an index behind {}", here()));
    const std::size_t begin = done_ + (done_ > 0 ? 1 : 0);
    if (!at_->is_object()) fail(fmt::format("{} is {} and has no keys", here(), kind_of(*at_)));
    const std::string_view rest = path_.substr(begin);
    auto found = at_->end();
    for (auto member = at_->begin(); member != at_->end(); ++member) {
      const std::string& key = member.key();
      const bool fits = rest.starts_with(key) &&
                        (rest.size() == key.size() || joints.find(rest[key.size()]) != joints.npos);
      if (fits && (found == at_->end() || key.size() > found.key().size())) found = member;
    }
    if (found == at_->end()) fail_unknown(rest.substr(0, rest.find_first_of(joints)));
    done_ = begin + found.key().size();
    at_ = &*found;
  }

  [[noreturn]] void fail_unknown(std::string_view key) const {
    std::vector<std::string_view> names;
    for (const auto& member : at_->items()) names.emplace_back(member.key());
    if (names.empty()) fail(fmt::format("{} has no keys", here()));
    fail(unknown_name(fmt::format("key of {}", here()), key, names));
  }

  Json* at_;
  std::string_view path_;
  std::size_t done_ = 0;  ///< characters of the path that are behind us
};

}  // namespace

Json& value_at(Json& scene, std::string_view path) { return Walk(scene, path).to_the_end(); }

}  // namespace tessera::client
