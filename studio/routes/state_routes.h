// What all pages ask for (studio/web/src/state.tsx): the project, and the state of its steps.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class StateRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
