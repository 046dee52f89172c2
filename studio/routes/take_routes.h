// A recorded take on its page: shown as changes would make it, kept as a new one, and its baked
// frames as a part of the project.
#pragma once

#include "studio/routes/page_routes.h"
#include "studio/runs/take_editor.h"

namespace keypose::studio {

class TakeRoutes : public PageRoutes {
 public:
  explicit TakeRoutes(SharedProject& project);
  void AddTo(RouteTable& table) override;

 private:
  void AddDrafts(RouteTable& table);
  void AddUses(RouteTable& table);

  TakeEditor takes_;
};

}  // namespace keypose::studio
