// What a page of the studio asks of the server: a class for each page, or for what several pages
// share, which adds its requests to a table.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "studio/http/answers.h"
#include "studio/http/shared_project.h"

namespace keypose::studio {

/// What a request changes of the project.
enum class Changes {
  kNothing,
  kQuietly,  ///< the next request sees it; the watch of files tells the tabs, of many at once
  kProject,  ///< the next request sees it, and all tabs are told at once
};

/// Requests by method and path.
class RouteTable {
 public:
  using Handler = std::function<Answer(const Question&)>;
  struct Route {
    Handler handler;
    Changes changes = Changes::kNothing;
  };

  void Get(const std::string& path, Handler handler);
  void Post(const std::string& path, Handler handler, Changes changes = Changes::kProject);
  void Put(const std::string& path, Handler handler, Changes changes = Changes::kProject);
  /// All that begins so. @param folder  ends with '/'
  void GetBelow(const std::string& folder, Handler handler);

  /// Null: there is nothing at this address.
  const Route* Find(const std::string& method, const std::string& path) const;

 private:
  std::map<std::string, Route> routes_;  ///< by "GET /api/project"
  std::map<std::string, Route> below_;   ///< by "GET /report/"
};

class PageRoutes {
 public:
  explicit PageRoutes(SharedProject& project) : project_(project) {}
  virtual ~PageRoutes() = default;
  PageRoutes(const PageRoutes&) = delete;
  PageRoutes& operator=(const PageRoutes&) = delete;

  /// @pre this outlives the table
  virtual void AddTo(RouteTable& table) = 0;

 protected:
  SharedProject& project_;
};

}  // namespace keypose::studio
