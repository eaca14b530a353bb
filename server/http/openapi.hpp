#pragma once
#include <span>

#include "common/base/json.hpp"
#include "server/http/routes.hpp"

namespace tessera::server {

/// The table of routes as OpenAPI 3.1. Pure.
Json openapi_description(std::span<const Route> routes);

}  // namespace tessera::server
