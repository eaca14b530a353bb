#include "common/base/error.hpp"
#include "common/net/http_client.hpp"

namespace tessera::net {

void EventParser::line(std::string_view text, std::vector<ServerEvent>& events) {
  if (text.empty()) {  // the event's end
    if (has_data_) {
      event_.data.pop_back();
      event_.id = last_id_;
      events.push_back(std::move(event_));
    }
    event_ = {};
    has_data_ = false;
    return;
  }
  if (text.front() == ':') return;
  const std::size_t colon = text.find(':');
  const std::string_view field = text.substr(0, colon);
  std::string_view value =
      colon == std::string_view::npos ? std::string_view{} : text.substr(colon + 1);
  if (value.starts_with(' ')) value.remove_prefix(1);
  if (field == "data") {
    if (event_.data.size() + value.size() > limits::http_json_body)
      throw Error(ErrorKind::too_large, "the server sent an event that is too large");
    has_data_ = true;
    event_.data += value;
    event_.data += '\n';
  } else if (field == "event") {
    event_.type = value.empty() ? std::string_view("message") : value;
  } else if (field == "id" && value.find('\0') == std::string_view::npos) {
    last_id_ = value;
  }
}

std::vector<ServerEvent> EventParser::feed(std::string_view bytes) {
  std::vector<ServerEvent> events;
  // A line ends with \n, \r or \r\n; a \r at the end of one piece may be followed by its \n in the
  // next.
  for (const char c : bytes) {
    if (c == '\n' && skip_newline_) {
      skip_newline_ = false;
      continue;
    }
    skip_newline_ = c == '\r';
    if (c != '\n' && c != '\r') {
      if (rest_.size() >= limits::http_json_body)
        throw Error(ErrorKind::too_large, "the server sent an event that is too large");
      rest_ += c;
      continue;
    }
    std::string_view text = rest_;
    if (first_ && text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    first_ = false;
    line(text, events);
    rest_.clear();
  }
  return events;
}

}  // namespace tessera::net
