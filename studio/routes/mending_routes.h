// A pose's mesh under the brush that mends: strokes, and what becomes of the mesh.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class MendingRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
