// What a person said the figure of a pose is, or the actor of a shot.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class FigureRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
