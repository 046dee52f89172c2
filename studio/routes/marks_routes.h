// Marks of a performance: read, saved, suggested; the meshes that they join.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class MarksRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  Answer Suggest(const Question& question);
};

}  // namespace keypose::studio
