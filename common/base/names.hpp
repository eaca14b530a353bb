#pragma once
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// The candidate nearest to `name` by edit distance (insert, delete, replace, swap of neighbours),
/// or an empty string if none is within a third of its length (at least 1, so that one slip in a
/// short name is still found).
std::string nearest_name(std::string_view name, const std::vector<std::string_view>& candidates);

/// `unknown KIND "NAME"; did you mean "X"? (one of: a, b, c)`: the sentence for a name that is not
/// in a table.
std::string unknown_name(std::string_view kind, std::string_view name,
                         const std::vector<std::string_view>& candidates);

/// True if `name` can stand in paths, logs and metrics as it is: 1 to 128 bytes of UTF-8 without
/// control characters.
bool is_plain_name(std::string_view name);

}  // namespace tessera
