#include "common/scene/gltf/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/scene/fields.hpp"
#include "common/scene/gltf/rules.hpp"

namespace tessera::scene::gltf {

namespace {

/// The part of `path` before its first slash; `path` goes on behind it.
std::string_view take_part(std::string_view& path) {
  const std::size_t end = std::min(path.find('/'), path.size());
  const std::string_view part = path.substr(0, end);
  path.remove_prefix(std::min(end + 1, path.size()));
  return part;
}

std::optional<Value> member_of(const Value& object, std::string_view key) {
  for (const Value::Member& member : object.members())
    if (member.key.text() == key) return member.value;
  return std::nullopt;
}

class Checker {
 public:
  explicit Checker(const Document& document) : root_(document, 0) {}

  void run() {
    if (root_.kind() != Kind::object) root_.fail_expected("an object");
    for (const Rule& rule : rules())
      visit(root_, rule.path, [&](const Value& value) { check(value, rule.fields); });
    for (const std::string_view path : texture_paths())
      visit(root_, path, [&](const Value& value) {
        check(value, texture_fields());
        visit(value, "extensions/KHR_texture_transform",
              [&](const Value& transform) { check(transform, texture_transform_fields()); });
      });
  }

  /// Calls `see` for every value at `path`.
  template <class See>
  void visit(const Value& at, std::string_view path, const See& see) const {
    if (path.empty()) {
      see(at);
      return;
    }
    const std::string_view part = take_part(path);
    if (part != "*") {
      if (const auto found = member_of(at, part)) visit(*found, path, see);
    } else if (at.kind() == Kind::object) {
      for (const Value::Member& member : at.members()) visit(member.value, path, see);
    } else {
      for (const Value& item : at.items()) visit(item, path, see);
    }
  }

 private:
  void check(const Value& object, std::span<const Field> fields) {
    const std::vector<Value::Member> members = object.members();
    for (const Field& field : fields) {
      bool found = false;
      for (const Value::Member& member : members)
        if (field.key == "*" || member.key.text() == field.key) {
          check(member.value, field);
          found = true;
        }
      if (!found && field.required)
        throw Error(ErrorKind::bad_input, "is required, and is not there",
                    object.place_of_lacking(field.key));
    }
  }

  void check(const Value& value, const Field& field) {
    switch (field.is) {
      case Is::index:
        check_index(value, field.of);
        break;
      case Is::indices:
        for (const Value& item : value.items()) check_index(item, field.of);
        break;
      case Is::whole:
        (void)value.integer(static_cast<std::int64_t>(field.low),
                            static_cast<std::int64_t>(field.high));
        break;
      case Is::number:
        (void)value.number(field.low, field.high);
        break;
      case Is::numbers:
        check_numbers(value, field);
        break;
      case Is::text:
        (void)value.text();
        break;
      case Is::word:
        check_word(value, field.of);
        break;
      case Is::flag:
        (void)value.boolean();
        break;
      case Is::list:
        (void)value.items();
        break;
      case Is::object:
        if (value.kind() != Kind::object) value.fail_expected("an object");
        break;
    }
  }

  void check_index(const Value& value, std::string_view list) {
    const std::int64_t count = count_of(list);
    const std::int64_t index = value.integer(0, std::numeric_limits<std::int32_t>::max());
    if (index >= count)
      value.fail(
          count == 0
              ? fmt::format("names number {} of {}, of which there are none", index, list)
              : fmt::format("names number {} of {}; the last is {}", index, list, count - 1));
  }

  static void check_numbers(const Value& value, const Field& field) {
    if (value.kind() != Kind::array || (field.count != 0 && value.node().count != field.count))
      value.fail_expected(field.count != 0 ? fmt::format("a list of {} numbers", field.count)
                                           : "a list of numbers");
    for (const Value& item : value.items()) (void)item.number(field.low, field.high);
  }

  static void check_word(const Value& value, std::string_view words) {
    const std::string found = value.kind() == Kind::integer
                                  ? fmt::format("{}", value.node().integer)
                              : value.kind() == Kind::text ? value.text()
                                                           : "";
    std::string expected;
    for (std::string_view rest = words; !rest.empty();) {
      const std::size_t end = rest.find(',');
      if (rest.substr(0, end) == found) return;
      expected += fmt::format("{}{}", expected.empty() ? "" : ", ", rest.substr(0, end));
      rest.remove_prefix(end + 1);
    }
    value.fail_expected("one of " + expected);
  }

  std::int64_t count_of(std::string_view list) {
    for (const auto& [known, count] : counts_)
      if (known == list) return count;
    std::int64_t count = 0;
    visit(root_, list,
          [&](const Value& value) { count = static_cast<std::int64_t>(value.items().size()); });
    counts_.emplace_back(list, count);
    return count;
  }

  Value root_;
  std::vector<std::pair<std::string_view, std::int64_t>> counts_;
};

void check_asset(const Value& root) {
  Fields in(root);
  Fields asset(in.required("asset"));
  const Value version = asset.required("version");
  if (!version.text().starts_with("2."))
    version.fail(fmt::format("glTF {}; only 2.x can be read", version.text().substr(0, 16)));
  const auto least = asset.optional("minVersion");
  if (least && least->text() != "2.0")
    least->fail(fmt::format("needs glTF {}; 2.0 can be read", least->text().substr(0, 16)));
}

/// Of number `index` of a list. (A value finds its own place by walking there, which of each of a
/// million takes hours.)
std::optional<Uri> uri_of(Fields& in, std::string_view list, std::size_t index) {
  const auto value = in.optional("uri");
  if (!value) return std::nullopt;
  return Uri{.text = value->text(), .place = fmt::format("/{}/{}/uri", list, index)};
}

/// Gives the first buffer view to those of `accessors` that have none; their numbers.
std::vector<std::size_t> give_views(std::string& text, const Value& accessors) {
  std::vector<std::size_t> out;
  const std::vector<Value> items = accessors.items();
  std::string with;
  std::size_t done = 0;
  for (std::size_t i = 0; i < items.size(); ++i)
    if (!member_of(items[i], "bufferView")) {
      const std::size_t inside = items[i].node().offset + 1;
      with.append(text, done, inside - done).append("\"bufferView\":0,");
      done = inside;
      out.push_back(i);
    }
  text = with.append(text, done);
  return out;
}

/// `text` with an empty list for the list that begins at `offset` and ends before `before`.
void empty_list(std::string& text, std::size_t offset, std::size_t before) {
  const std::size_t end = text.rfind(']', before - 1);
  text.replace(offset, end + 1 - offset, "[]");
}

}  // namespace

CheckedJson check_json(std::string text, const std::string& name) {
  const Document document(std::move(text), name, PathStyle::pointer);
  if (document.size() > limits::gltf_values)
    throw Error(ErrorKind::too_large,
                fmt::format("its JSON has {} keys and values; {} is the most. Vertices belong into "
                            "buffers, and many copies into EXT_mesh_gpu_instancing",
                            document.size(), limits::gltf_values),
                {.file = name, .key = {}});
  const Value root(document, 0);
  Checker checker(document);
  checker.run();
  check_asset(root);

  CheckedJson out;
  checker.visit(root, "buffers/*", [&](const Value& value) {
    Fields in(value);
    out.buffers.push_back(
        {.uri = uri_of(in, "buffers", out.buffers.size()),
         .bytes = static_cast<std::uint64_t>(in.required("byteLength").integer(1, INT64_MAX))});
    checker.visit(value, "extensions/EXT_meshopt_compression/fallback",
                  [&](const Value& fallback) { out.buffers.back().fallback = fallback.boolean(); });
  });
  checker.visit(root, "images/*", [&](const Value& value) {
    Fields in(value);
    ImageEntry image{
        .name = in.text_or("name", ""),
        .uri = uri_of(in, "images", out.images.size()),
        .buffer_view = static_cast<std::int32_t>(in.integer_or("bufferView", 0, INT32_MAX, -1))};
    if (image.uri.has_value() == (image.buffer_view >= 0))
      value.fail("expected either a uri or a bufferView");
    out.images.push_back(std::move(image));
  });

  checker.visit(root, "extensionsUsed/*",
                [&](const Value& value) { out.extensions_used.push_back(value.text()); });
  checker.visit(root, "extensionsRequired/*",
                [&](const Value& value) { out.extensions_required.push_back(value.text()); });

  out.rest = document.text();
  const std::vector<Value::Member> members = root.members();
  for (std::size_t i = members.size(); i-- > 0;) {
    const std::string& key = members[i].key.text();
    if (key == "accessors" && member_of(root, "bufferViews"))
      out.without_view = give_views(out.rest, members[i].value);
    if (key != "buffers" && key != "images") continue;
    const std::size_t before =
        i + 1 < members.size() ? members[i + 1].key.node().offset : document.text().size();
    empty_list(out.rest, members[i].value.node().offset, before);
  }
  return out;
}

}  // namespace tessera::scene::gltf
