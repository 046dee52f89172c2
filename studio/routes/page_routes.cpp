#include "studio/routes/page_routes.h"

namespace keypose::studio {

void RouteTable::Get(const std::string& path, Handler handler) {
  routes_["GET " + path] = {std::move(handler), Changes::kNothing};
}

void RouteTable::Post(const std::string& path, Handler handler, Changes changes) {
  routes_["POST " + path] = {std::move(handler), changes};
}

void RouteTable::Put(const std::string& path, Handler handler, Changes changes) {
  routes_["PUT " + path] = {std::move(handler), changes};
}

void RouteTable::GetBelow(const std::string& folder, Handler handler) {
  below_["GET " + folder] = {std::move(handler), Changes::kNothing};
}

const RouteTable::Route* RouteTable::Find(const std::string& method,
                                          const std::string& path) const {
  const std::string asked = method + " " + path;
  if (const auto found = routes_.find(asked); found != routes_.end()) return &found->second;
  for (const auto& [folder, route] : below_)
    if (asked.starts_with(folder)) return &route;
  return nullptr;
}

}  // namespace keypose::studio
