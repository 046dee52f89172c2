// A performance's films: their frames and masks.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class FilmsRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
