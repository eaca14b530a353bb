#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "client/output.hpp"
#include "client/sheet_layout.hpp"
#include "client/wedge_jobs.hpp"

namespace tessera::client {

/// What the contact sheet of a wedge says: names and values of what varies as labels, and in its
/// note what is the same for all. Pure.
SheetContent content_of(const WedgePlan& plan, const PreparedWedge& prepared, int cell_width,
                        const Look& look);

}  // namespace tessera::client
