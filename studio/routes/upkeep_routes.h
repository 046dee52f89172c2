// What a project needs now and then: `keypose gc`, `verify`, `pack`, `unlock`, `doctor`, `cameras`.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class UpkeepRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  std::filesystem::path PackedFile() const;
  Answer Do(const Question& question);
};

}  // namespace keypose::studio
