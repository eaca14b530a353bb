#pragma once
#include <boost/asio/awaitable.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/access.hpp"
#include "server/http/api.hpp"
#include "server/http/message.hpp"
#include "server/http/query.hpp"

namespace tessera::server {

/// One request on its way to one handler.
struct Call {
  ApiContext& api;
  HttpRequest& request;
  Target target;
  std::vector<std::string> values;  ///< of the pattern's {…}, in order
};

/// May throw Error, which becomes a problem.
using Handler = boost::asio::awaitable<HttpResponse> (*)(Call& call);

struct Parameter {
  std::string_view name;
  std::string_view summary;
};

/// An answer that says more than that the request was wrong.
struct Refusal {
  std::string_view status;  ///< "422"
  std::string_view summary;
};

struct Route {
  std::string_view method;
  std::string_view pattern;  ///< "/v1/jobs/{id}": a {…} stands for one segment
  Handler handler;
  Role role;
  std::string_view answers;  ///< media type
  std::string_view summary;  ///< a sentence for /openapi.json
  std::span<const Parameter> query{};
  std::span<const Parameter> header{};
  std::span<const Refusal> refusals{};
};

/// The one table.
std::span<const Route> routes();

struct RouteMatch {
  const Route* route = nullptr;  ///< none: see `allow`
  std::vector<std::string> values;
  std::string allow;  ///< methods that the path has; empty if there is no such path
};

/// HEAD finds a GET route where there is none of its own.
RouteMatch find_route(std::string_view method, const Target& target);

}  // namespace tessera::server
