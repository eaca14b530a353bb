#pragma once
#include "server/store/database.hpp"

namespace tessera::server {

/// The version that this program writes.
int schema_version();

/// Brings the database from whatever version it has (0: new) to schema_version(), one durable step
/// at a time. Throws Error{conflict} if it is newer, or not ours; `name` is for messages.
void migrate(Database& database, const std::string& name);

}  // namespace tessera::server
