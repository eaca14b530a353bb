#pragma once
#include <cstddef>
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

/// True if `text` is well-formed UTF-8 (RFC 3629).
bool is_utf8(std::string_view text);

/// Something from outside as it can stand in a message: at most `most` bytes, cut between
/// characters, what is not UTF-8 or a control character replaced by '?'. A message goes into JSON,
/// which takes nothing else.
std::string excerpt(std::string_view text, std::size_t most = 64);

/// True if `name` can stand in paths, logs and metrics as it is: 1 to 128 bytes of UTF-8 without
/// control characters.
bool is_plain_name(std::string_view name);

}  // namespace tessera
