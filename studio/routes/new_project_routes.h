// A project that is made by the page.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class NewProjectRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
