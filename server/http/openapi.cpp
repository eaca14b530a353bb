#include "server/http/openapi.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "common/base/build_info.hpp"
#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

Json parameter(std::string_view name, std::string_view where, std::string_view summary) {
  Json out = Json::object();
  out["name"] = name;
  out["in"] = where;
  out["required"] = where == "path";
  out["schema"] = {{"type", "string"}};
  if (!summary.empty()) out["description"] = summary;
  return out;
}

Json parameters_of(const Route& route) {
  Json out = Json::array();
  std::string_view rest = route.pattern;
  for (std::size_t open = rest.find('{'); open != std::string_view::npos; open = rest.find('{')) {
    const std::size_t close = rest.find('}', open);
    out.push_back(parameter(rest.substr(open + 1, close - open - 1), "path", {}));
    rest.remove_prefix(close + 1);
  }
  for (const Parameter& one : route.query) out.push_back(parameter(one.name, "query", one.summary));
  for (const Parameter& one : route.header)
    out.push_back(parameter(one.name, "header", one.summary));
  return out;
}

Json content(std::string_view type) {
  Json out = Json::object();
  out[std::string(type)] = Json::object();
  return out;
}

Json problem_response(std::string_view description) {
  Json out = Json::object();
  out["description"] = description;
  out["content"] = content("application/problem+json");
  return out;
}

Json operation(const Route& route) {
  Json out = Json::object();
  out["summary"] = route.summary;
  out["parameters"] = parameters_of(route);
  Json good = Json::object();
  good["description"] = "As summarised";
  if (route.method != "HEAD") good["content"] = content(route.answers);
  out["responses"]["2XX"] = std::move(good);
  for (const Refusal& refusal : route.refusals)
    out["responses"][std::string(refusal.status)] = problem_response(refusal.summary);
  out["responses"]["default"] = problem_response("Problem details (RFC 9457)");
  const bool bytes = route.handler == put_blob;
  if (bytes) out["requestBody"]["content"] = content("application/octet-stream");
  if (!bytes && (route.method == "POST" || route.method == "PATCH" || route.method == "PUT"))
    out["requestBody"]["content"] = content("application/json");
  Json security = Json::array();
  security.push_back({{"token", Json::array()}});
  if (route.role == Role::blob_reader) security.push_back({{"blob_token", Json::array()}});
  out["security"] = std::move(security);
  return out;
}

Json bearer(std::string_view description) {
  Json out = Json::object();
  out["type"] = "http";
  out["scheme"] = "bearer";
  out["description"] = description;
  return out;
}

}  // namespace

Json openapi_description(std::span<const Route> routes) {
  Json out = Json::object();
  out["openapi"] = "3.1.0";
  out["info"]["title"] = "Tessera";
  out["info"]["version"] = version();
  out["info"]["license"] = {{"name", "Apache-2.0"}, {"identifier", "Apache-2.0"}};
  for (const Route& route : routes) {
    std::string method(route.method);
    std::transform(method.begin(), method.end(), method.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    out["paths"][std::string(route.pattern)][method] = operation(route);
  }
  out["components"]["securitySchemes"]["token"] =
      bearer("The server's token, where one is configured");
  out["components"]["securitySchemes"]["blob_token"] =
      bearer("What workers are given, for reading blobs");
  return out;
}

}  // namespace tessera::server
