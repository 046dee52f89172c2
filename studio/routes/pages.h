// The one list of what the server answers.
#pragma once

#include <memory>
#include <vector>

#include "studio/routes/page_routes.h"

namespace keypose::studio {

/// The routes of every page. @pre `project` outlives them
std::vector<std::unique_ptr<PageRoutes>> AllPages(SharedProject& project);

}  // namespace keypose::studio
