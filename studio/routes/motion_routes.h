// The moving mesh: the animation between the keys, or a performance's shot and its colours.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class MotionRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
